"""Co-simulation, model exchange and `simulate` give the same trajectory."""

import numpy as np
import pytest
from fmu_cases import MODELS, motion

from elastic_tendon.compiled import simulate
from fmu_driver import run_co_simulation, run_model_exchange

TOLERANCE = 1e-8
AGREEMENT = 1e-6  # rad; CVode's own error at this tolerance


def _simulated(name, segments):
    options = {"interpolation": segments.interpolation, "tolerance": TOLERANCE}
    return simulate(MODELS[name], segments.time, segments.position, **options)


@pytest.mark.parametrize("linear", [False, True])
def test_co_simulation_is_simulate_to_the_bit(fmus, instances, name, linear):
    segments = motion(linear)
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
    assert events > 5
    assert np.abs(found - expected["joint_position"]).max() < AGREEMENT


def test_model_exchange_locates_as_many_events_as_simulate(base, instances):
    segments = motion(True)
    _, events = run_model_exchange(instances(base.model()), segments, tolerance=TOLERANCE)
    assert events == _simulated("base", segments).statistics["events"]


def test_the_joint_sticks_and_slides_in_model_exchange(fmus, instances):
    segments = motion(True)
    args = (segments, "joint_velocity")
    velocity, _ = run_model_exchange(instances(fmus("effects").model()), *args, tolerance=TOLERANCE)
    expected = _simulated("effects", segments)["joint_velocity"]
    assert (velocity == 0).any()
    assert ((velocity == 0) == (expected == 0)).all()


def test_a_rate_set_once_carries_on(base, instances):
    """Inputs and their derivatives keep their values, as variables do, until they are set."""
    slave = instances(base.slave())
    slave.begin(tolerance=TOLERANCE)
    slave.set_rate("motor_position", 0.5)
    for i in range(4):
        slave.fmu.doStep(0.25 * i, 0.25)
    assert slave.get("motor_position") == 0.5
    expected = simulate(MODELS["base"], [0, 0.25, 0.5, 0.75, 1], 0.5 * np.arange(5) / 4)
    assert abs(slave.get("joint_position") - expected["joint_position"][-1]) < 1e-7


def test_result_does_not_depend_on_the_communication_step(base, instances):
    def end(steps):
        slave = instances(base.slave())
        slave.begin({"motor_position": 0.3}, tolerance=1e-10)
        for i in range(steps):
            slave.fmu.doStep(0.5 * i / steps, 0.5 / steps)
        return slave.get("joint_position")

    assert max(abs(end(steps) - end(5)) for steps in (50, 5000, 50000)) < 1e-8


def test_a_ramp_given_with_its_derivative_needs_no_small_steps(base, instances):
    def end(steps):
        slave = instances(base.slave())
        slave.begin(tolerance=1e-10)
        for i in range(steps):
            slave.set("motor_position", 0.8 * 0.5 * i / steps)
            slave.set_rate("motor_position", 0.8)
            slave.fmu.doStep(0.5 * i / steps, 0.5 / steps)
        return slave.get("joint_position")

    assert abs(end(1) - end(500)) < 1e-8


def test_velocity_comes_from_the_input_or_from_the_derivative(fmus, instances):
    """A ramp, once with motor_velocity connected, once by the derivative, once without either."""

    def end(start, rate):
        slave = instances(fmus("damped").slave())
        slave.begin({"motor_velocity": 0.6} | start)
        for i in range(100):
            slave.set("motor_position", 0.6 * i * 0.01)
            slave.set_rate("motor_position", rate)
            slave.fmu.doStep(i * 0.01, 0.01)
        return slave.get("joint_torque")

    connected = end({"motor_velocity_connected": True}, 0.6)
    assert end({}, 0.6) == connected
    assert abs(end({}, 0.0) - connected) > 1e-3


def test_a_velocity_that_is_missing_is_told_once(fmus, instances):
    for name, start, warnings in (
        ("damped", {}, 1),
        ("damped", {"motor_velocity_connected": True}, 0),
        ("base", {}, 0),
    ):
        slave = instances(fmus(name).slave())
        slave.begin(start)
        slave.fmu.doStep(0.0, 0.01)
        told = [m for m in slave.log if m.category == "logStatusWarning"]
        assert len(told) == warnings
        assert all("motor_velocity_connected" in message.text for message in told)
