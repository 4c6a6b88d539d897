"""What every effect of the catalogue must satisfy; an effect joins by being in the tuple."""

import numpy as np
import pytest
from scipy.integrate import cumulative_trapezoid

from elastic_tendon.compiled import sensitivities, simulate
from elastic_tendon.effects import CATALOGUE
from elastic_tendon.effects.base import Slot
from elastic_tendon.model import build
from elastic_tendon.parameters import load_model, typical_value

TIME = np.arange(0.0, 3.0, 0.002)
MOTOR = 0.6 * np.sin(2 * np.pi * 1.9 * TIME) * np.sin(np.pi * TIME / 3.0)
LOAD = 8.0 * np.sin(3.0 * TIME)  # N·m, near the springs' limit

NULL_ERROR = 1e-8  # rad: the effect's events, at which nothing happens, shorten steps
QUADRATURE = 1e-3  # relative, of the work at 2 ms
DIFFERENCES = 1e-5  # relative, of central differences at 1e-5 of the value

effects = pytest.mark.parametrize("effect", CATALOGUE, ids=lambda effect: effect.id)


@pytest.fixture
def base():
    return load_model("biorob_x4_joint_3")


def with_typical(model, effect):
    numbers = {one.name: typical_value(model, one) for one in effect.parameters}
    return model.with_effect(effect.id, numbers)


def position(model, motor=MOTOR, load=LOAD, **options):
    return simulate(model, TIME, motor, load, **options)["joint_position"]


@effects
def test_null_gives_the_base_model(effect, base):
    vanished = position(base.with_effect(effect.id, None), tolerance=1e-11)
    assert np.abs(vanished - position(base, tolerance=1e-11)).max() < NULL_ERROR


@effects
def test_typical_numbers_change_the_motion(effect, base):
    assert np.abs(position(with_typical(base, effect)) - position(base)).max() > 1e-4


@effects
def test_makes_no_energy(effect, base):
    """With the motor held, no more work can be taken from the joint than was put in."""
    undamped = with_typical(base.with_values({"link.damping": 0.0}), effect)
    velocity = simulate(undamped, TIME, 0 * TIME, LOAD)["joint_velocity"]
    work = cumulative_trapezoid(LOAD * velocity, TIME, initial=0.0)
    assert work.min() >= -QUADRATURE * work.max()


@effects
def test_sensitivities_agree_with_differences(effect, base):
    model = with_typical(base, effect)
    paths = [path for path in model.values() if path.startswith(f"effects.{effect.id}.")]
    exact = sensitivities(model, TIME, MOTOR, LOAD, parameters=paths, tolerance=1e-10)
    for path, column in zip(paths, exact.of("joint_position").T, strict=True):
        value = model.values()[path]
        step = 1e-5 * value
        high, low = (
            position(model.with_values({path: value + sign * step}), tolerance=1e-12)
            for sign in (1, -1)
        )
        error = np.linalg.norm((high - low) / (2 * step) - column)
        assert error <= DIFFERENCES * np.linalg.norm(column)


@effects
def test_extreme_numbers_finish(effect, base):
    model = with_typical(base, effect)
    for parameter in effect.parameters:
        extreme = min(parameter.upper, 1e4 * typical_value(base, parameter))
        path = f"effects.{effect.id}.{parameter.name}"
        assert np.isfinite(position(model.with_values({path: extreme}))).all()


@effects
def test_declaration_is_complete(effect):
    assert effect.title
    assert effect.physics.endswith(".")
    assert effect.in_data.endswith(".")
    assert effect.reference
    for parameter in effect.parameters:
        assert parameter.lower <= parameter.null <= parameter.upper
        assert parameter.unit
        assert parameter.meaning


def test_listing_order_does_not_matter(base):
    model, reverse = base, base
    for effect in CATALOGUE:
        model = with_typical(model, effect)
    for effect in CATALOGUE[::-1]:
        reverse = reverse.with_effect(effect.id, model.effects[effect.id])
    assert list(model.values()) == list(reverse.values())
    assert np.array_equal(position(model), position(reverse))


@effects
def test_compiled_equations_are_the_symbolic_ones(effect, base):
    """The slope of the simulated motion is what CasADi evaluates from the same expressions."""
    import casadi as ca

    model = with_typical(base, effect)
    system = build(model.effect_ids)
    rates = ca.Function("rates", [system.x, system.u, system.p, system.r], [system.rates])
    start = {"joint_position": 0.1, "joint_velocity": 1.0}
    step = 1e-6
    motion = simulate(
        model, [0.0, step], [0.05, 0.05], [1.0, 1.0], initial_state=start, tolerance=1e-12
    )
    states = np.array([start.get(one.name, one.start) for one in system.interface.states])
    modes = [one.start for one in system.interface.modes]
    if effect.slot is Slot.DRY_FRICTION:
        modes[-1] = 1.0  # the joint moves upwards
    expected = np.array(rates(states, [0.05, 0.0, 1.0], list(model.values().values()), modes))
    slope = (motion.states[1] - motion.states[0]) / step
    # the slope is that at half the step: first order in it
    assert np.allclose(slope, expected.ravel(), rtol=1e-3)
