"""FMI 3.0 co-simulation in which the importer handles events, and steps that end early."""

import numpy as np
import pytest
from fmu_cases import FMI3, MODELS
from refusals import check_refused, check_set_refused

from elastic_tendon.simulation.simulate import simulate

pytestmark = FMI3

TOLERANCE = 1e-8
START = {"motor_position": 0.3}
STOP = 0.5  # s, with a dozen events before it


def expected(stop=STOP, model="base"):
    """Motion from START."""
    held = [START["motor_position"]] * 2
    return simulate(MODELS[model], np.array([0.0, stop]), held, tolerance=TOLERANCE)


def started(fmu, **options):
    """An instance after initialisation."""
    slave = fmu.slave(**options)
    slave.begin(START, tolerance=TOLERANCE)
    return slave


def run(slave, step, stop=STOP):
    """Time, slack state before and slack state after each event."""
    time, events = 0.0, []
    while time < stop:
        end = slave.advance(time, min(step, stop - time))
        time = end.time
        assert time == slave.get("time")
        if end.event:
            before = slave.get("slack_state")
            slave.fmu.enterEventMode()
            assert slave.get("slack_state") == before
            slave.iterate_events()
            events.append((time, before, slave.get("slack_state")))
    return events


@pytest.mark.parametrize("step", [0.5, 0.1, 0.01])
def test_a_step_ends_at_the_event_with_the_values_before_it(base, instances, step):
    slave = instances(started(base, event_mode=True, early_return=True))
    events = run(slave, step)
    times, before, after = (np.array(column) for column in zip(*events, strict=True))
    motion = expected()
    assert len(times) == len(motion.event_times) > 5
    assert np.abs(times - motion.event_times).max() < 1e-7
    assert (before != after).all()
    assert (before[1:] == after[:-1]).all()  # nothing changes outside event mode
    assert abs(slave.get("joint_position") - motion["joint_position"][-1]) < 1e-6


def test_a_step_that_ends_at_an_event_says_so(base, instances):
    slave = instances(started(base, event_mode=True, early_return=True))
    first = expected().event_times[0]
    end = slave.advance(0.0, first / 2)
    assert (end.event, end.terminate, end.early, end.time) == (False, False, False, first / 2)
    end = slave.advance(first / 2, STOP)
    assert (end.event, end.terminate, end.early) == (True, False, True)
    assert end.time == pytest.approx(first, abs=1e-9)
    slave.fmu.enterEventMode()
    assert slave.iterate_events().calls == 2


def test_an_event_at_the_end_of_a_step_is_told_and_nothing_is_early(base, instances):
    options = {"event_mode": True, "early_return": True}
    first = instances(started(base, **options)).advance(0.0, STOP).time
    slave = instances(started(base, **options))
    end = slave.advance(0.0, first)
    assert (end.event, end.terminate, end.early, end.time) == (True, False, False, first)
    before = slave.get("slack_state")
    slave.fmu.enterEventMode()
    slave.iterate_events()
    assert slave.get("slack_state") != before


def test_events_are_logged_at_their_own_time(base, instances):
    slave = instances(started(base, event_mode=True, early_return=True))
    slave.log.clear()
    events = run(slave, 0.1)
    told = [message.text for message in slave.log if message.category == "logEvents"]
    assert len(told) == len(events)
    for text, (time, _, _) in zip(told, events, strict=True):
        assert f"fmi3UpdateDiscreteStates at {time:.9g} s: " in text


@pytest.mark.parametrize("options", [{}, {"early_return": True}, {"event_mode": True}])
def test_without_both_a_step_reaches_its_end(base, instances, options):
    """Events are handled inside; the result is that of `simulate`, to the bit."""
    slave = instances(started(base, **options))
    end = slave.advance(0.0, STOP)
    assert (end.event, end.terminate, end.early, end.time) == (False, False, False, STOP)
    assert slave.get("joint_position") == expected()["joint_position"][-1]


def test_event_mode_is_for_importers_that_asked_for_it(base, instances):
    slave = instances(started(base))
    check_refused(slave, "fmi3EnterEventMode", telling=["eventModeUsed"])
    check_refused(slave, "fmi3EnterStepMode")


def test_relations_are_frozen_between_steps(base, instances):
    """An input that jumps changes them in event mode only, and outputs show no other ones."""
    slave = instances(started(base, event_mode=True, early_return=True))
    slave.set("motor_position", -0.3)
    assert slave.get("slack_state") == 1
    slave.fmu.enterEventMode()
    assert slave.get("slack_state") == 1
    slave.iterate_events()
    assert slave.get("slack_state") == 2


def test_discrete_states_are_updated_not_evaluated(base, instances):
    """The optional function is refused in each phase in which the standard knows it."""
    slave = instances(base.slave(event_mode=True))
    slave.set_up()
    check_refused(slave, "fmi3EvaluateDiscreteStates", telling=["last update"])
    slave.fmu.exitInitializationMode()
    check_refused(slave, "fmi3EvaluateDiscreteStates", telling=["last update"])


def test_tunable_parameters_change_in_event_mode_only(base, instances):
    slave = instances(started(base, event_mode=True, early_return=True))
    slave.advance(0.0, 0.01)
    check_set_refused(
        slave, "link.inertia", 0.05, telling=["link.inertia", "it is tuned in event mode"]
    )
    slave.fmu.enterEventMode()
    check_set_refused(slave, "transmission.joint_pulley_radius", 0.05, telling=["in event mode"])
    slave.set("link.inertia", 0.05)
    slave.iterate_events()
    changed = MODELS["base"].with_values({"link.inertia": 0.05})
    before = expected(0.01)
    state = {name: before[name][-1] for name in ("joint_position", "joint_velocity")}
    motion = simulate(changed, [0.0, 0.3], [0.3, 0.3], initial_state=state, tolerance=TOLERANCE)
    time = 0.01
    while time < 0.31:
        end = slave.advance(time, 0.31 - time)
        time = end.time
        if end.event:
            slave.fmu.enterEventMode()
            slave.iterate_events()
    assert abs(slave.get("joint_position") - motion["joint_position"][-1]) < 1e-6


def test_sticking_takes_the_rest_of_the_velocity_away(fmus, instances):
    """A state that jumps at an event is said to."""
    slave = instances(fmus("effects").slave(event_mode=True, early_return=True))
    slave.begin({"joint_velocity": 0.5}, tolerance=TOLERANCE)
    time, jumps = 0.0, []
    while time < STOP:
        end = slave.advance(time, STOP - time)
        time = end.time
        if end.event:
            before = slave.get("joint_velocity")
            slave.fmu.enterEventMode()
            jumped = slave.iterate_events().jumped
            assert jumped == (slave.get("joint_velocity") != before)
            jumps.append(jumped)
    assert any(jumps)
    assert slave.get("joint_velocity") == 0.0


def test_state_keeps_the_event_mode(base, instances):
    """A state taken in event mode goes on there, in another instance of the kind."""
    slave = instances(started(base, event_mode=True, early_return=True))
    first = slave.advance(0.0, STOP).time
    slave.fmu.enterEventMode()
    data = slave.snapshot()
    other = instances(base.slave(event_mode=True, early_return=True))
    other.restore(data)
    for one in (slave, other):
        one.iterate_events()
        one.advance(first, 1e-3)
    assert other.everything() == slave.everything()
    stranger = instances(base.slave())
    with pytest.raises(Exception, match="fmi3"):
        stranger.restore(data)
