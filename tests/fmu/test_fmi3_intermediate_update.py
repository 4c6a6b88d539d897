"""FMI 3.0 co-simulation: looks inside a step, inputs set there, and wishes to stop."""

import numpy as np
import pytest
from fmu_cases import FMI3, MODELS
from refusals import NOTHING

from elastic_tendon.simulation.simulate import simulate
from fmu_driver import DISCARD, ERROR

pytestmark = FMI3

TOLERANCE = 1e-9
AGREEMENT = 1e-7  # rad; of runs whose steps differ
OUTPUTS = ["joint_position", "joint_torque"]
START = {"joint_velocity": 1.0, "motor_position": 0.2}
END = 0.3  # s


@pytest.fixture
def start(base, instances):
    """Makes an instance whose step is looked into."""

    def make(update=None, required=("motor_position", *OUTPUTS), **options):
        slave = instances(base.slave(update=update, required=required, **options))
        slave.begin(START, tolerance=TOLERANCE)
        return slave

    return make


def test_each_step_of_the_solver_is_told(start):
    looks = []

    def look(slave, told):
        looks.append((told, slave.values(OUTPUTS)))

    slave = start(look)
    assert slave.advance(0.0, END).time == END
    times = np.array([told.time for told, _ in looks])
    assert len(times) > 10
    assert (np.diff(times) > 0).all()
    assert times[-1] == END
    assert all(told.may_set and told.may_get and told.step_finished for told, _ in looks)
    assert not any(told.may_stop for told, _ in looks)
    for told, values in looks[::7]:
        shorter = start()
        shorter.advance(0.0, told.time)
        assert np.abs(shorter.values(OUTPUTS) - values).max() < 100 * AGREEMENT
        assert abs(shorter.get("joint_position") - values[0]) < AGREEMENT


def test_looking_changes_nothing(start):
    def look(slave, _told):
        slave.values(OUTPUTS)

    watched, alone = start(look), start()
    for slave in (watched, alone):
        slave.advance(0.0, END)
    assert abs(watched.get("joint_position") - alone.get("joint_position")) < AGREEMENT


def test_an_input_set_inside_a_step_acts_from_then_on(start):
    changed = []

    def push(slave, told):
        if told.time >= 0.1 and not changed:
            changed.append(told.time)
            slave.set("motor_position", 0.5)
            assert slave.get("motor_position") == 0.5

    slave = start(push)
    slave.advance(0.0, END)
    (at,) = changed
    assert 0.1 <= at < END
    pieces, late = start(), start()
    pieces.advance(0.0, at)
    pieces.set("motor_position", 0.5)
    pieces.advance(at, END - at)
    late.advance(0.0, END)
    assert abs(slave.get("joint_position") - pieces.get("joint_position")) < AGREEMENT
    assert abs(slave.get("joint_position") - late.get("joint_position")) > 1e-3


@pytest.mark.parametrize("event_mode", [False, True])
def test_a_wish_to_stop_is_granted_at_the_time_asked(start, event_mode):
    wishes = []

    def stop(_slave, told):
        assert told.may_stop
        if not wishes:
            wishes.append(told.time + 1e-3)
            return wishes[0]
        return None

    slave = start(stop, early_return=True, event_mode=event_mode)
    end = slave.advance(0.0, END)
    assert (end.event, end.early, end.time) == (False, True, wishes[0])
    assert slave.get("time") == wishes[0]
    end = slave.advance(end.time, 0.01)
    assert (end.early, end.time) == (False, wishes[0] + 0.01)


@pytest.mark.parametrize("wish", [-1.0, float("nan")])
def test_a_wish_for_a_time_gone_by_stops_at_once(start, wish):
    slave = start(lambda _slave, _told: wish, early_return=True)
    end = slave.advance(0.0, END)
    assert end.early
    assert 0.0 < end.time < END


def test_a_wish_for_a_time_beyond_the_step_does_not_lengthen_it(start):
    slave = start(lambda _slave, _told: 9.0, early_return=True)
    assert slave.advance(0.0, 0.01).time == 0.01


def test_a_wish_without_early_return_is_not_granted(start):
    slave = start(lambda _slave, told: told.time)
    end = slave.advance(0.0, END)
    assert (end.early, end.time) == (False, END)


def test_events_end_a_step_that_is_looked_into(start):
    """The last look is at the event."""
    times = []
    slave = start(lambda _slave, told: times.append(told.time), early_return=True, event_mode=True)
    plain = start(early_return=True, event_mode=True)
    one, other = (each.advance(0.0, END) for each in (slave, plain))
    assert one.event
    assert other.event
    assert one.early
    assert abs(one.time - other.time) < 1e-8
    assert max(times) == one.time


def test_an_event_inside_a_step_is_looked_at(start):
    """Also where nobody but the instance handles it."""
    looks = []
    slave = start(lambda _slave, told: looks.append(told.time))
    slave.advance(0.0, END)
    state = {"joint_velocity": START["joint_velocity"]}
    held = [START["motor_position"]] * 2
    events = simulate(
        MODELS["base"], [0.0, END], held, initial_state=state, tolerance=TOLERANCE
    ).event_times
    assert len(events) > 3
    assert np.abs(np.array(looks)[:, None] - events).min(axis=0).max() < AGREEMENT


def test_illegal_calls_inside_a_step_are_refused(start):
    """What is not required cannot be got; nothing that would change the phase of life works."""
    statuses, functions = [], ("Reset", "Terminate", "GetFMUState", "DoStep", "SetDebugLogging")

    def try_all(slave, _told):
        statuses.append(slave.status(*slave.getting(slave.reference("deflection"))))
        statuses.append(slave.status(*slave.getting(slave.reference("motor_torque"), "Int32")))
        statuses.append(slave.status(*slave.setting(["load_torque"], [1.0])))
        statuses.extend(slave.status(f"fmi3{name}", *NOTHING) for name in functions)
        slave.fmu.fmi3FreeInstance(slave.fmu.component)

    slave, alone = start(try_all), start()
    for one in (slave, alone):
        one.advance(0.0, END)
    assert set(statuses) == {ERROR}
    assert len([m for m in slave.log if m.status == ERROR]) >= len(statuses)
    assert any("not one of the required intermediate variables" in m.text for m in slave.log)
    assert any("inside a step" in m.text for m in slave.log)
    assert abs(slave.get("joint_position") - alone.get("joint_position")) < AGREEMENT


def test_messages_of_a_step_name_the_step(start):
    """Also after calls inside it."""

    def overload(slave, _told):
        slave.get("joint_position")
        slave.set("motor_position", 1.7e308)

    slave = start(overload)
    assert slave.status(*slave.stepping(0.0, END)) == DISCARD
    assert "fmi3DoStep" in slave.log[-1].text
    assert slave.get("time") < END
