"""FMI 2.0: inputs of co-simulation that move with a rate between communication points."""

import numpy as np
import pytest
from fmu_cases import MODELS, motion

from elastic_tendon.simulation.simulate import simulate
from fmu_driver import DISCARD, run_co_simulation

TOLERANCE = 1e-8


def test_co_simulation_is_simulate_to_the_bit(fmus, instances, name):
    segments = motion(True)
    found = run_co_simulation(instances(fmus(name).slave()), segments, tolerance=TOLERANCE)
    options = {"interpolation": "linear", "tolerance": TOLERANCE}
    expected = simulate(MODELS[name], segments.time, segments.position, **options)
    assert np.ptp(found) > 0.5
    assert (found == expected["joint_position"]).all()


def test_a_rate_set_once_carries_on(base, instances):
    """Inputs and their derivatives keep their values, as variables do, until they are set."""
    slave = instances(base.slave())
    slave.begin(tolerance=TOLERANCE)
    slave.set_rate("motor_position", 0.5)
    for i in range(4):
        slave.advance(0.25 * i, 0.25)
    assert slave.get("motor_position") == 0.5
    expected = simulate(MODELS["base"], [0, 0.25, 0.5, 0.75, 1], 0.5 * np.arange(5) / 4)
    assert abs(slave.get("joint_position") - expected["joint_position"][-1]) < 1e-7


@pytest.mark.parametrize("steps", [5, 500, 50000])
def test_a_ramp_given_with_its_derivative_does_not_depend_on_the_step(base, instances, steps):
    """In one step of 0.5 s and in steps of 0.1 s to 10 µs."""

    def end(steps):
        slave = instances(base.slave())
        slave.begin(tolerance=1e-10)
        for i in range(steps):
            slave.set("motor_position", 0.8 * 0.5 * i / steps)
            slave.set_rate("motor_position", 0.8)
            slave.advance(0.5 * i / steps, 0.5 / steps)
        return slave.get("joint_position")

    assert abs(end(1) - end(steps)) < 1e-8


def test_velocity_comes_from_the_input_or_from_the_derivative(fmus, instances):
    """A ramp, once with motor_velocity connected, once by the derivative, once without either."""

    def end(start, rate):
        slave = instances(fmus("damped").slave())
        slave.begin({"motor_velocity": 0.6} | start)
        for i in range(100):
            slave.set("motor_position", 0.6 * i * 0.01)
            slave.set_rate("motor_position", rate)
            slave.advance(i * 0.01, 0.01)
        return slave.get("joint_torque")

    connected = end({"motor_velocity_connected": True}, 0.6)
    assert end({}, 0.6) == connected
    assert abs(end({}, 0.0) - connected) > 1e-3


@pytest.mark.parametrize(("order", "value"), [(0, 1.0), (2, 1.0), (1, np.nan)])
def test_only_finite_first_derivatives(base, instances, order, value):
    slave = instances(base.slave())
    slave.begin()
    slave.set_rate("motor_position", 0.5)
    before = slave.snapshot()
    with pytest.raises(Exception, match="fmi2SetRealInputDerivatives"):
        slave.fmu.setRealInputDerivatives([slave.reference("motor_position")], [order], [value])
    assert "motor_position" in slave.log[-1].text
    assert slave.snapshot() == before


@pytest.mark.parametrize("name", ["base", "implicit"])
def test_a_rate_that_no_step_bears_is_discarded_soon(fmus, instances, name):
    """Also at time zero, near which steps may shrink without end."""
    slave = instances(fmus(name).slave())
    slave.begin()
    slave.set_rate("load_torque", 1.7e308)
    assert slave.status(*slave.stepping(0.0, 0.01)) == DISCARD
