"""Derivatives: directional against central differences, adjoint against directional, by time."""

import numpy as np
import pytest
from fmu_cases import BOTH, FMI3, IMPLICIT_EFFECTS, motion

from elastic_tendon.actuator.variables import interface
from fmu_driver import DISCARD, ERROR

RELATIVE = 1e-6  # central differences of a function that is linear but for products
OUTPUTS = ["joint_torque", "deflection", "motor_torque", "upper_spring_force", "lower_spring_force"]
RATES = ["der(joint_position)", "der(joint_velocity)"]
INPUTS = ["motor_position", "motor_velocity", "load_torque"]
STATES = ["joint_position", "joint_velocity"]
START = {"joint_position": 0.1, "joint_velocity": 0.7, "motor_position": 0.15}


def parameters(instance, variability=("fixed", "tunable")):
    """Real parameters."""
    return [
        name
        for name in instance.named(causality="parameter", type=instance.number)
        if instance.variables[name].variability in variability
    ]


def differences(instance, name, wanted):
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
        values.append(instance.values(wanted))
    instance.set(name, centre)
    return (values[1] - values[0]) / (points[1] - points[0])


def check_agreement(instance, knowns):
    """Directional derivatives by each known against differences."""
    checked, wanted = 0, OUTPUTS + RATES
    for known in knowns:
        expected = differences(instance, known, wanted)
        found = instance.derivative(wanted, [known], [1.0])
        scale = np.abs(expected) + 1e-4 * np.abs(expected).max() + 1e-3
        assert (np.abs(found - expected) <= 10 * RELATIVE * scale).all(), known
        checked += np.count_nonzero(expected)
    assert checked > 0


@BOTH
@pytest.mark.parametrize("kind", ["slave", "model"])
@pytest.mark.parametrize("connected", [False, True])
def test_while_initialising_by_inputs_states_and_parameters(fmus, instances, name, kind, connected):
    instance = instances(getattr(fmus(name), kind)())
    instance.set_up(START | {"motor_velocity_connected": connected})
    check_agreement(instance, INPUTS + STATES + parameters(instance))


@BOTH
@pytest.mark.parametrize("motor_position", [0.1, 0.5, -0.5])
def test_between_steps_by_inputs_and_tunables_in_each_slack_state(fmus, instances, motor_position):
    slave = instances(fmus("damped").slave())
    slave.begin({"motor_velocity_connected": True})
    slave.set("motor_position", motor_position)
    slave.advance(0.0, 0.01)
    check_agreement(slave, INPUTS + parameters(slave, ["tunable"]))


@BOTH
def test_in_continuous_time_by_inputs(fmus, instances):
    model = instances(fmus("damped").model())
    model.begin(START | {"motor_velocity_connected": True})
    check_agreement(model, INPUTS)


@BOTH
def test_in_event_mode_by_inputs_and_tunables(fmus, instances):
    model = instances(fmus("damped").model())
    model.begin(START | {"motor_velocity_connected": True})
    model.fmu.enterEventMode()
    check_agreement(model, INPUTS + parameters(model, ["tunable"]))


@BOTH
def test_in_continuous_time_by_states(fmus, instances):
    model = instances(fmus("effects").model())
    model.begin(START)
    wanted = OUTPUTS + RATES
    x, step = np.array([START[state] for state in STATES]), 1e-6
    for i, state in enumerate(STATES):
        values = []
        for side in (1, -1):
            moved = x.copy()
            moved[i] += side * step
            model.move(*moved)
            values.append(model.values(wanted))
        model.move(*x)
        expected = (values[0] - values[1]) / (2 * step)
        found = model.derivative(wanted, [state], [1.0])
        assert np.abs(found - expected).max() <= 1e-5 * np.abs(expected).max()


@BOTH
def test_calculated_starts_follow_what_is_set(fmus, instances):
    """They are unknowns while initialising, and states to derive by afterwards."""
    model = instances(fmus("implicit").model())
    model.set_up(START)
    calculated = [name for name in interface(IMPLICIT_EFFECTS).state_names if name not in STATES]
    assert calculated
    for known in (*STATES, "motor_position", "link.inertia"):
        expected = differences(model, known, calculated)
        found = model.derivative(calculated, [known], [1.0])
        assert np.abs(found - expected).max() <= 1e-5 * (np.abs(expected).max() + 1e-6), known
    for unknown in (RATES, calculated):
        assert model.status(*model.differentiating(unknown[:1], calculated[:1])) == ERROR
    model.fmu.exitInitializationMode()
    own = [f"der({name})" for name in calculated]
    assert model.derivative(own, calculated, [1.0] * len(own)).any()


@BOTH
def test_seeds_add_up_and_results_are_written_anew(base, instances):
    slave = instances(base.slave())
    slave.begin(START)
    wanted = OUTPUTS + RATES
    single = [slave.derivative(wanted, [known], [1.0]) for known in STATES]
    together = slave.derivative(wanted, STATES, [2.0, -3.0])
    assert np.allclose(together, 2 * single[0] - 3 * single[1], rtol=1e-14)
    assert slave.derivative(["joint_position"], STATES, [4.0, 5.0]) == [4.0]


@BOTH
def test_a_velocity_that_is_not_connected_changes_nothing(fmus, instances):
    slave = instances(fmus("damped").slave())
    slave.begin(START)
    assert not slave.derivative(OUTPUTS + RATES, ["motor_velocity"], [1.0]).any()
    connected = instances(fmus("damped").slave())
    connected.begin(START | {"motor_velocity_connected": True})
    assert connected.derivative(OUTPUTS + RATES, ["motor_velocity"], [1.0]).any()


@BOTH
@pytest.mark.parametrize(
    ("unknown", "known"),
    [
        ("slack_state", "motor_position"),
        ("motor_position", "motor_position"),
        ("link.inertia", "motor_position"),
        ("joint_torque", "transmission.upper_spring.stiffness"),  # only while initialising
        ("joint_torque", "transmission.upper_spring.parallel"),
        ("joint_torque", "deflection"),
        ("joint_torque", "time"),
    ],
)
def test_pairs_without_a_derivative_are_refused(base, instances, unknown, known):
    slave = instances(base.slave())
    slave.begin()
    with pytest.raises(Exception, match="GetDirectionalDerivative"):
        slave.derivative([unknown], [known], [1.0])
    assert slave.log[-1].status == ERROR


@BOTH
def test_derivatives_that_are_not_finite_are_discarded(fmus, instances):
    """Where equations have no solution; forwards of the unknown, adjoint by the known."""
    model = instances(fmus("implicit").model())
    model.begin(START)
    model.set("motor_position", 1e150)
    pair = (["joint_torque"], ["joint_position"])
    assert model.status(*model.differentiating(*pair)) == DISCARD
    assert "derivative for joint_torque is not finite" in model.log[-1].text
    if model.version == 3:
        with pytest.raises(Exception, match="GetAdjointDerivative"):
            model.adjoint(*pair, [1.0])
        assert model.log[-1].status == DISCARD
        assert "derivative for joint_position is not finite" in model.log[-1].text


@FMI3
def test_event_indicators_are_no_unknowns(base, instances):
    """FMI 3.0.2: derivatives are those of outputs and states."""
    model = instances(base.model())
    model.begin(START)
    with pytest.raises(Exception, match="GetDirectionalDerivative"):
        model.derivative(["upper_spring.taut.indicator"], ["joint_position"], [1.0])
    assert "upper_spring.taut.indicator is no unknown" in model.log[-1].text


def to_initialisation(instance):
    """Where all inputs, states with a start and parameters are known."""
    instance.set_up(START | {"motor_velocity_connected": True})
    return INPUTS + STATES + parameters(instance)


def to_event_mode(instance):
    """Where inputs, states and tunable parameters are."""
    instance.begin(START | {"motor_velocity_connected": True})
    instance.fmu.enterEventMode()
    return INPUTS + STATES + parameters(instance, ["tunable"])


def to_the_next_step(instance):
    """Between steps, or in continuous time, with an input that has changed."""
    instance.begin(START | {"motor_velocity_connected": True})
    instance.set("motor_position", -0.4)
    if instance.is_slave:
        instance.advance(0.0, 0.05)
    return INPUTS + STATES


@FMI3
@pytest.mark.parametrize("name", ["damped", "effects", "implicit"])
@pytest.mark.parametrize("kind", ["slave", "model"])
@pytest.mark.parametrize("go", [to_initialisation, to_event_mode, to_the_next_step])
def test_adjoint_is_the_transpose_of_directional(fmus, instances, name, kind, go):
    options = {"event_mode": True} if kind == "slave" and go is to_event_mode else {}
    instance = instances(getattr(fmus(name), kind)(**options))
    knowns, wanted = go(instance), OUTPUTS + RATES
    forward = np.array([instance.derivative(wanted, [known], [1.0]) for known in knowns])
    backward = np.array(
        [instance.adjoint(wanted, knowns, seed) for seed in np.eye(len(wanted)).tolist()]
    )
    assert np.count_nonzero(forward) > len(wanted)
    assert (backward == forward.T).all()
    seed = np.linspace(-1.0, 2.0, len(wanted))
    together = instance.adjoint(wanted, knowns, seed.tolist())
    assert np.abs(together - forward @ seed).max() <= 1e-14 * (np.abs(forward) @ np.abs(seed)).max()


@BOTH
def test_output_derivatives_are_those_along_the_motion(fmus, instances):
    """Against differences of the outputs of tiny steps."""
    slave = instances(fmus("damped").slave())
    segments, step = motion(True), 1e-6
    slave.begin(START, tolerance=1e-12)
    slave.set("motor_position", segments.position[0])
    if slave.version == 2:
        slave.set_rate("motor_position", segments.slope[0])
        slave.set_rate("load_torque", 2.0)
    names = [*OUTPUTS, *STATES]
    values = []
    for i in range(3):
        values.append(slave.values(names))
        if i == 1:
            found = slave.output_derivatives(names)
        slave.advance(i * step, step)
    expected = (values[2] - values[0]) / (2 * step)
    assert np.abs(found).max() > 1.0
    assert np.abs(found - expected).max() < 1e-5 * np.abs(expected).max()
