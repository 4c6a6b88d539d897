"""Co-simulation, model exchange and `simulate` give the same trajectory."""

import numpy as np
import pytest
from fmu_cases import BOTH, MODELS, motion

from elastic_tendon.compiled import simulate
from fmu_driver import WARNING, run_co_simulation, run_model_exchange

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
    assert statuses.count(WARNING) == len(told) == 1
    assert told[0].status == WARNING
    assert slave.get("overstretched")
    assert slave.get("time") == pytest.approx(0.3)


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
