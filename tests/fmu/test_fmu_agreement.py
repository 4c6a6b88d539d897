"""Co-simulation, model exchange and `simulate` give the same trajectory."""

import re

import numpy as np
import pytest
from fmu_cases import BOTH, MODELS, motion

from elastic_tendon.simulation.simulate import simulate
from fmu_driver import OK, WARNING, run_co_simulation, run_model_exchange

pytestmark = BOTH

TOLERANCE = 1e-8
AGREEMENT = 1e-6  # rad, s; CVode's own error at this tolerance


def _simulated(name, segments):
    options = {"interpolation": segments.interpolation, "tolerance": TOLERANCE}
    return simulate(MODELS[name], segments.time, segments.position, **options)


def test_co_simulation_is_simulate_to_the_bit(fmus, instances, name):
    segments = motion(False)
    found = run_co_simulation(instances(fmus(name).slave()), segments, tolerance=TOLERANCE)
    assert np.ptp(found) > 0.5
    assert (found == _simulated(name, segments)["joint_position"]).all()


@pytest.mark.parametrize("output", ["joint_torque", "slack_state", "upper_spring_force"])
def test_outputs_at_a_sample_see_the_inputs_that_begin_there(fmus, instances, output):
    segments = motion(False)
    slave = instances(fmus("damped").slave())
    found = run_co_simulation(slave, segments, output, tolerance=TOLERANCE)
    assert len(set(found)) > 1
    assert (found == _simulated("damped", segments)[output]).all()


def test_the_number_of_the_slack_state_is_the_enumeration(base, instances, version):
    """The same values under the last reference, so that no other one has moved."""
    numbers, states = (
        run_co_simulation(instances(base.slave()), motion(False), name, tolerance=TOLERANCE)
        for name in ("slack_state_number", "slack_state")
    )
    assert len(set(states)) > 2
    assert (numbers == states).all()
    last = max(base.description.modelVariables, key=lambda variable: variable.valueReference)
    assert (last.name, last.type) == ("slack_state_number", {2: "Integer", 3: "Int32"}[version])


@pytest.mark.parametrize("linear", [False, True])
def test_model_exchange_with_cvode_agrees(fmus, instances, name, linear):
    segments = motion(linear)
    model = instances(fmus(name).model())
    found, events = run_model_exchange(model, segments, tolerance=TOLERANCE)
    expected = _simulated(name, segments)
    assert len(events) > 5
    assert np.abs(found - expected["joint_position"]).max() < AGREEMENT


def test_importers_locate_slack_where_simulate_does(base, instances):
    segments = motion(True)
    _, events = run_model_exchange(instances(base.model()), segments, tolerance=TOLERANCE)
    expected = _simulated("base", segments).event_times
    assert len(expected) > 5
    assert np.abs(np.array(events) - expected).max() < AGREEMENT  # of one length too


def test_the_joint_sticks_and_slides_in_model_exchange(fmus, instances):
    segments = motion(True)
    args = (segments, "joint_velocity")
    velocity, _ = run_model_exchange(instances(fmus("effects").model()), *args, tolerance=TOLERANCE)
    expected = _simulated("effects", segments)["joint_velocity"]
    assert (velocity == 0).any()
    assert ((velocity == 0) == (expected == 0)).all()


def test_result_does_not_depend_on_the_communication_step(base, instances):
    """Steps of 0.1 s, 10 ms, 0.1 ms and 10 µs through slack and back."""

    def end(steps):
        slave = instances(base.slave())
        slave.begin({"motor_position": 0.3}, tolerance=1e-10)
        for i in range(steps):
            slave.advance(0.5 * i / steps, 0.5 / steps)
        return slave.get("joint_position")

    assert max(abs(end(steps) - end(5)) for steps in (50, 5000, 50000)) < 1e-8


def _events_told(slave):
    """Times and texts of the events in the log."""
    told = [message.text for message in slave.log if message.category == "logEvents"]
    events = [re.search(r"DoStep at (\S+) s: (.*)", text).groups() for text in told]
    return zip(*events, strict=True)


@pytest.mark.parametrize("steps", [1, 5])
def test_each_event_inside_a_step_is_told_once_at_its_time(base, instances, steps):
    held = {"motor_position": 0.3}
    expected = simulate(MODELS["base"], [0.0, 0.5], [0.3, 0.3], tolerance=TOLERANCE).event_times
    slave = instances(base.slave())
    slave.begin(held, tolerance=TOLERANCE)
    slave.log.clear()
    for i in range(steps):
        slave.advance(0.5 * i / steps, 0.5 / steps)
    times, changes = _events_told(slave)
    assert len(times) == len(expected) > 5
    assert np.abs(np.array(times, float) - expected).max() < AGREEMENT
    if steps == 1:
        assert list(times) == [f"{time:.9g}" for time in expected]
    assert changes[:3] == (
        *("lower_spring.taut 0 -> 1", "upper_spring.taut 1 -> 0", "upper_spring.taut 0 -> 1"),
    )


def test_a_velocity_that_is_missing_is_told_once(fmus, instances):
    for name, start, warnings in (
        ("damped", {}, 1),
        ("damped", {"motor_velocity_connected": True}, 0),
        ("base", {}, 0),
    ):
        slave = instances(fmus(name).slave())
        slave.begin(start)
        slave.advance(0.0, 0.01)
        told = [m for m in slave.log if m.category == "logStatusWarning"]
        assert len(told) == warnings
        assert all("motor_velocity_connected" in message.text for message in told)


def test_a_spring_stretched_too_far_is_told_once_and_goes_on(base, instances):
    """2.6 rad stretch a spring by 1.3 of what it bears; by and by the joint comes to rest there."""
    slave = instances(base.slave())
    slave.begin({"joint_position": 0.0})
    slave.set("load_torque", -30.0)
    statuses = [slave.status(*slave.stepping(0.05 * i, 0.05)) for i in range(6)]
    told = [m for m in slave.log if m.category == "logStatusWarning"]
    assert set(statuses) == {OK}
    assert len(told) == 1
    assert told[0].status == WARNING
    assert slave.get("overstretched")
    assert slave.get("time") == pytest.approx(0.3)


def test_a_spring_stretched_too_far_inside_a_step_is_told(base, instances):
    """From 10 ms to 0.1 s; at the end of the step nothing shows any more."""
    slave = instances(base.slave())
    slave.begin({"joint_velocity": 40.0})
    assert slave.status(*slave.stepping(0.0, 0.11)) == OK
    assert not slave.get("overstretched")
    (told,) = [m for m in slave.log if m.category == "logStatusWarning"]
    assert told.status == WARNING
    assert "max_deflection" in told.text
    assert 0.0 < float(re.search(r" at (\S+) s: ", told.text)[1]) < 0.1
    assert slave.status(*slave.stepping(0.11, 0.01)) == OK


@pytest.mark.parametrize("kind", ["slave", "model"])
def test_damping_tuned_without_the_velocity_is_told_once(base, instances, kind):
    """Between steps, or in event mode: from then on the model needs what is not connected."""
    instance = instances(getattr(base, kind)())
    instance.begin()

    def go(i):
        if kind == "slave":
            return instance.status(*instance.stepping(0.1 * i, 0.1))
        instance.iterate_events()
        instance.fmu.enterEventMode()
        return None

    def warnings():
        return [message for message in instance.log if message.category == "logStatusWarning"]

    if kind == "model":
        instance.fmu.enterEventMode()
    go(0)
    instance.set("link.damping", 0.2)  # needs no velocity of the motor
    go(1)
    assert warnings() == []
    instance.set("transmission.upper_spring.damping", 30.0)
    statuses = [go(i) for i in (2, 3, 4)]
    assert statuses == [OK if kind == "slave" else None] * 3
    (told,) = warnings()
    assert "motor_velocity_connected" in told.text


def test_a_tunable_parameter_changed_on_the_way_is_two_simulations(base, instances):
    """Damping and inertia, between steps or, with event mode, in it."""
    changed = {"link.damping": 0.9, "link.inertia": 0.05}
    model, half = MODELS["base"], np.array([0.0, 0.25])
    slave = instances(base.slave())
    slave.begin({"motor_position": 0.3}, tolerance=TOLERANCE)
    slave.advance(0.0, 0.25)
    for name, value in changed.items():
        slave.set(name, value)
    slave.advance(0.25, 0.25)
    first = simulate(model, half, [0.3, 0.3], tolerance=TOLERANCE)
    state = {name: first[name][-1] for name in ("joint_position", "joint_velocity")}
    other = model.with_values(changed)
    second = simulate(other, half, [0.3, 0.3], tolerance=TOLERANCE, initial_state=state)
    assert abs(slave.get("joint_position") - second["joint_position"][-1]) < 10 * TOLERANCE
    assert abs(slave.get("joint_position") - _straight_on(model)) > 1e-3


def _straight_on(model):
    return simulate(model, np.array([0.0, 0.5]), [0.3, 0.3])["joint_position"][-1]
