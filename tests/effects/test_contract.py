"""What every effect of the catalogue must satisfy; an effect joins by its file."""

import casadi as ca
import numpy as np
import pytest
from contract_cases import (
    CROOKED,
    LOAD,
    MODELS,
    MOTOR,
    PAPER,
    TIME,
    assert_sensitivities_agree_with_differences,
    drive,
    measured,
    with_typical,
)
from scipy.integrate import cumulative_trapezoid

from effects_at import AT_POSITION, placed, shown_in
from elastic_tendon.actuator.model import build
from elastic_tendon.actuator.parameters import quantities, typical_value
from elastic_tendon.effects import CATALOGUE
from elastic_tendon.effects.units import base_exponents
from elastic_tendon.errors import SimulationError
from elastic_tendon.simulation.simulate import sensitivities, simulate

NULL_ERROR = 1e-8  # rad: the effect's events, at which nothing happens, shorten steps
QUADRATURE = 1e-3  # relative, of the work at 2 ms
DIFFERENCES = 1e-5  # relative, of central differences at 1e-5 of the value
SCALING = 1e-7  # rad: solver tolerances and dead bands do not scale with the units

effects = pytest.mark.parametrize("effect", CATALOGUE, ids=lambda effect: effect.id)
at_position = pytest.mark.parametrize("effect", AT_POSITION, ids=lambda effect: effect.id)
models = pytest.mark.parametrize("model", MODELS.values(), ids=MODELS)


@models
@effects
def test_null_gives_the_base_model(effect, model):
    model = placed(model, effect)
    vanished = measured(model.with_effect(effect.id, None), tolerance=1e-11)
    assert np.abs(vanished - measured(model, tolerance=1e-11)).max() < NULL_ERROR


@models
@effects
def test_typical_numbers_change_what_is_measured(effect, model):
    signal = shown_in(effect)
    bare = measured(placed(model, effect), signal)
    assert np.abs(measured(with_typical(model, effect), signal) - bare).max() > 1e-4


@models
@at_position
def test_makes_no_energy(effect, model):
    """With the motor held, no more work can be taken from the joint than was put in."""
    strong = with_typical(model, effect)
    rest = simulate(strong, [0.0, 60.0], [0.0, 0.0]).states[-1]
    states = (state.name for state in build(strong.effect_ids).interface.states)
    undamped = strong.with_values({"link.damping": 0.0})
    start = dict(zip(states, rest, strict=True))
    velocity = simulate(undamped, TIME, 0 * TIME, LOAD, initial_state=start)["joint_velocity"]
    work = cumulative_trapezoid(LOAD * velocity, TIME, initial=0.0)
    assert work.max() > 0.01
    assert work.min() >= -QUADRATURE * work.max()


@models
@effects
def test_sensitivities_agree_with_differences(effect, model):
    model = with_typical(model, effect)
    own = [path for path in model.values() if path.startswith(f"effects.{effect.id}.")]
    paths = [*own, "transmission.pretension_force", "transmission.upper_spring.stiffness"]
    assert_sensitivities_agree_with_differences(model, paths, DIFFERENCES, shown_in(effect))


@effects
def test_extreme_numbers_finish_or_fail_cleanly(effect):
    for parameter in effect.parameters:
        for extreme in (parameter.lower, parameter.upper, 1e4 * typical_value(PAPER, parameter)):
            value = float(np.clip(extreme, parameter.lower, parameter.upper))
            numbers = with_typical(PAPER, effect).effects[effect.id] | {parameter.name: value}
            if effect.refuses(numbers):
                continue
            model = placed(PAPER, effect)
            assert finishes_or_says_why(model.with_effect(effect.id, numbers))


def finishes_or_says_why(model):
    try:
        return np.isfinite(measured(model)).all()
    except SimulationError as error:
        return "stopped at" in str(error)


@at_position
def test_units_are_those_of_the_equations(effect):
    """In other units of mass, length and time the same actuator moves alike."""
    unit = {"kg": 3.0, "m": 2.0, "s": 1.25}

    def scale(name):
        return np.prod([unit.get(base, 1.0) ** n for base, n in base_exponents(name).items()])

    model = with_typical(CROOKED, effect)
    scaled = {
        quantity.path: model.values()[quantity.path] * scale(quantity.unit)
        for quantity in quantities(model.effect_ids)
        if not quantity.integer
    }
    differing = simulate(
        model.with_values(scaled),
        TIME * scale("s"),
        MOTOR,
        LOAD * scale("N.m"),
        as_measured=True,
        tolerance=1e-11,
    )
    found = differing[differing.measured("joint_position")]
    assert np.abs(found - measured(model, tolerance=1e-11)).max() < SCALING


@effects
def test_declaration_is_complete(effect):
    texts = (effect.physics, effect.in_data, effect.confused_with, effect.confirm)
    for text in (*texts, effect.cure, effect.magnitude):
        assert text.endswith("."), text
    assert effect.title
    assert effect.reference
    for parameter in effect.parameters:
        assert parameter.lower <= parameter.null <= parameter.upper
        assert parameter.lower <= typical_value(PAPER, parameter) <= parameter.upper
        assert base_exponents(parameter.unit) is not None
        assert parameter.meaning


@effects
def test_derivative_at_the_null_is_regular_or_declared_singular(effect):
    """A score test needs it; an effect that is structurally absent at its null says so."""
    shapes = {
        parameter.name: typical_value(PAPER, parameter)
        for parameter in effect.parameters
        if parameter.shape
    }
    null = placed(PAPER, effect).with_effect(effect.id, shapes)
    strengths = [parameter.name for parameter in effect.parameters if not parameter.shape]
    paths = [f"effects.{effect.id}.{name}" for name in strengths]
    result = sensitivities(
        null, TIME, load_torque=LOAD, parameters=paths, as_measured=True, **drive(null)
    )
    size = np.linalg.norm(result.of(result.trajectory.measured(shown_in(effect))), axis=0)
    assert np.isfinite(size).all()
    assert (size.max() == 0.0) == effect.singular_null
    assert effect.singular_null or (size > 0.0).all()


@models
@at_position
def test_compiled_equations_are_the_symbolic_ones(effect, model):
    """The slope of the simulated motion is what CasADi evaluates from the same expressions."""
    model = with_typical(model, effect)
    system = build(model.effect_ids)
    assert system.w.numel() == 0
    start = {"joint_position": 0.1, "joint_velocity": 1.0}
    step = 1e-8
    motion = simulate(
        model, [0.0, step], [0.05, 0.05], [1.0, 1.0], initial_state=start, tolerance=1e-12
    )
    states = 0.5 * (motion.states[0] + motion.states[1])
    parameters = [*model.values().values(), *([0.0] if system.interface.reads_signals else [])]
    values = (states, [0.05, 0.0, 1.0], parameters)
    arguments = [system.x, system.u, system.p, system.r]
    evaluate = ca.Function("model", arguments, [system.rates, system.next_modes])
    modes = [mode.start for mode in system.interface.modes]
    for _ in range(3):
        modes = evaluate(*values, modes)[1]
    expected = np.array(evaluate(*values, modes)[0]).ravel()
    slope = (motion.states[1] - motion.states[0]) / step
    # a difference of states of order 0.01 m over 10 ns has lost eight digits
    assert np.allclose(slope, expected, rtol=1e-6, atol=1e-8)
