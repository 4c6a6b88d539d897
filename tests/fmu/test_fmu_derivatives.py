"""Directional derivatives, and output derivatives, against central differences."""

from ctypes import c_double

import numpy as np
import pytest
from fmu_cases import motion

from fmu_driver import ERROR

RELATIVE = 1e-6  # central differences of a function that is linear but for products
OUTPUTS = ["joint_torque", "deflection", "motor_torque", "upper_spring_force", "lower_spring_force"]
RATES = ["der(joint_position)", "der(joint_velocity)"]
UNKNOWNS = OUTPUTS + RATES
INPUTS = ["motor_position", "motor_velocity", "load_torque"]
STATES = ["joint_position", "joint_velocity"]
START = {"joint_position": 0.1, "joint_velocity": 0.7, "motor_position": 0.15}


def _differences(instance, name):
    """Central differences, one-sided at a bound."""
    centre, variable = instance.get(name), instance.variables[name]
    step = 1e-5 * max(abs(centre), float(variable.nominal))
    lower, upper = (
        float(bound or sign * np.inf) for bound, sign in ((variable.min, -1), (variable.max, 1))
    )
    points = [max(centre - step, lower), min(centre + step, upper)]
    values = []
    for point in points:
        instance.set(name, point)
        values.append(np.array([instance.get(unknown) for unknown in UNKNOWNS]))
    instance.set(name, centre)
    return (values[1] - values[0]) / (points[1] - points[0])


def _check_agreement(instance, knowns):
    checked = 0
    for known in knowns:
        expected = _differences(instance, known)
        found = instance.derivative(UNKNOWNS, [known], [1.0])
        scale = np.abs(expected).max() + 1e-3
        assert np.abs(found - expected).max() <= RELATIVE * scale, known
        checked += np.count_nonzero(expected)
    assert checked > 0


@pytest.mark.parametrize("kind", ["slave", "model"])
@pytest.mark.parametrize("connected", [False, True])
def test_while_initialising_by_inputs_states_and_parameters(fmus, instances, name, kind, connected):
    fmu = fmus(name)
    instance = instances(getattr(fmu, kind)())
    instance.set_up(START | {"motor_velocity_connected": connected})
    parameters = [
        one.name
        for one in fmu.description.modelVariables
        if one.causality == "parameter" and one.type == "Real"
    ]
    _check_agreement(instance, INPUTS + STATES + parameters)


@pytest.mark.parametrize("motor_position", [0.1, 0.5, -0.5])
def test_between_steps_by_inputs_in_each_slack_state(fmus, instances, motor_position):
    slave = instances(fmus("damped").slave())
    slave.begin({"motor_velocity_connected": True})
    slave.set("motor_position", motor_position)
    slave.fmu.doStep(0.0, 0.01)
    _check_agreement(slave, INPUTS)


def test_in_continuous_time_by_inputs(fmus, instances):
    model = instances(fmus("damped").model())
    model.begin(START | {"motor_velocity_connected": True})
    _check_agreement(model, INPUTS)


def test_in_continuous_time_by_states(fmus, instances):
    model = instances(fmus("effects").model())
    model.begin(START)
    x, step = np.array([START[state] for state in STATES]), 1e-6
    for i, state in enumerate(STATES):
        values = []
        for side in (1, -1):
            moved = x.copy()
            moved[i] += side * step
            model.fmu.setContinuousStates((c_double * 2)(*moved), 2)
            values.append(np.array([model.get(unknown) for unknown in UNKNOWNS]))
        model.fmu.setContinuousStates((c_double * 2)(*x), 2)
        expected = (values[0] - values[1]) / (2 * step)
        found = model.derivative(UNKNOWNS, [state], [1.0])
        assert np.abs(found - expected).max() <= 1e-5 * np.abs(expected).max()


def test_seeds_add_up_and_results_are_written_anew(base, instances):
    slave = instances(base.slave())
    slave.begin(START)
    single = [slave.derivative(UNKNOWNS, [known], [1.0]) for known in STATES]
    together = slave.derivative(UNKNOWNS, STATES, [2.0, -3.0])
    assert np.allclose(together, 2 * single[0] - 3 * single[1], rtol=1e-14)
    assert slave.derivative(["joint_position"], STATES, [4.0, 5.0]) == [4.0]


def test_a_velocity_that_is_not_connected_changes_nothing(fmus, instances):
    slave = instances(fmus("damped").slave())
    slave.begin(START)
    assert not slave.derivative(UNKNOWNS, ["motor_velocity"], [1.0]).any()
    connected = instances(fmus("damped").slave())
    connected.begin(START | {"motor_velocity_connected": True})
    assert connected.derivative(UNKNOWNS, ["motor_velocity"], [1.0]).any()


@pytest.mark.parametrize(
    ("unknown", "known"),
    [
        ("slack_state", "motor_position"),
        ("motor_position", "motor_position"),
        ("link.inertia", "motor_position"),
        ("joint_torque", "link.inertia"),  # only while initialising
        ("joint_torque", "transmission.upper_spring.parallel"),
        ("joint_torque", "deflection"),
        ("joint_torque", "time"),
    ],
)
def test_pairs_without_a_derivative_are_refused(base, instances, unknown, known):
    slave = instances(base.slave())
    slave.begin()
    with pytest.raises(Exception, match="fmi2GetDirectionalDerivative"):
        slave.derivative([unknown], [known], [1.0])
    assert slave.log[-1].status == ERROR


def test_output_derivatives_are_those_along_the_motion(fmus, instances):
    """Against differences of the outputs of tiny steps."""
    slave = instances(fmus("damped").slave())
    segments, step = motion(True), 1e-6
    slave.begin(START, tolerance=1e-12)
    slave.set("motor_position", segments.position[0])
    slave.set_rate("motor_position", segments.slope[0])
    slave.set_rate("load_torque", 2.0)
    names = [*OUTPUTS, *STATES]
    values = []
    for i in range(3):
        values.append(np.array([slave.get(name) for name in names]))
        if i == 1:
            references = [slave.reference(name) for name in names]
            found = slave.fmu.getRealOutputDerivatives(references, [1] * len(names))
        slave.fmu.doStep(i * step, step)
    expected = (values[2] - values[0]) / (2 * step)
    assert np.abs(np.array(found) - expected).max() < 1e-5 * np.abs(expected).max()
