"""The product against the truth: the same actuators by two simulators that share no code."""

import numpy as np
import pytest

from elastic_tendon.actuator.parameters import Model, parse_model
from elastic_tendon.simulation.simulate import simulate
from truth import actuator as true
from truth import signals, solver
from truth.friction import Coulomb

TIME = np.arange(0.0, 3.0, 0.01)
DENSER = 20  # product's samples between those compared: the spline's error falls below AGREEMENT
AGREEMENT = 1e-9  # rad


def random_actuator(seed: int, friction: float = 0.0, string: float = 0.0) -> true.Actuator:
    """Asymmetric, damped, geared; numbers off any grid."""
    rng = np.random.default_rng(seed)

    def spring() -> true.Spring:
        stiffness = rng.uniform(8e3, 3e4)
        protection = true.Overstretch(0.008, string * stiffness) if string else None
        return true.Spring(stiffness, rng.uniform(0.01, 0.02), rng.uniform(0, 20.0), protection)

    return true.Actuator(
        joint_pulley_radius=rng.uniform(0.02, 0.05),
        motor_pulley_radius=rng.uniform(0.01, 0.04),
        pretension_force=rng.uniform(30.0, 75.0),
        upper=spring(),
        lower=spring(),
        link=true.Link(
            rng.uniform(0.01, 0.06), rng.uniform(0.02, 0.3), Coulomb(friction) if friction else None
        ),
    )


def as_model(actuator: true.Actuator) -> Model:
    """The same numbers as a model.toml."""

    def spring(one: true.Spring) -> dict[str, float]:
        return {
            "stiffness": one.stiffness,
            "damping": one.damping,
            "max_deflection": one.max_deflection,
        }

    tree = {
        "name": "truth",
        "transmission": {
            "joint_pulley_radius": actuator.joint_pulley_radius,
            "motor_pulley_radius": actuator.motor_pulley_radius,
            "pretension_force": actuator.pretension_force,
            "upper_spring": spring(actuator.upper),
            "lower_spring": spring(actuator.lower),
        },
        "link": {"inertia": actuator.link.inertia, "damping": actuator.link.damping},
    }
    if isinstance(actuator.link.friction, Coulomb):
        tree["effects"] = {"coulomb_friction": {"torque": actuator.link.friction.torque}}
    return parse_model(tree, "truth")


def excitation(actuator: true.Actuator) -> signals.Experiment:
    """Motor motion and load that take both tendons through slack."""
    ratio = actuator.joint_pulley_radius / actuator.motor_pulley_radius
    wide = 1.8 * (actuator.deflection_limits()[1] - actuator.deflection_limits()[0])
    frequencies = [1.1, 2.7]
    motor = signals.sines(ratio * wide * np.array([0.4, 0.15]), frequencies, [0.0, 0.0])
    load = signals.sines([1.5], [1.9], [0.0])
    return signals.Experiment(float(TIME[-1]), motor, load)


def difference(actuator: true.Actuator, model: Model) -> tuple[float, set[float]]:
    """Largest difference of the joint position, rad, and the slack states passed."""
    experiment = excitation(actuator)
    expected = solver.simulate(actuator, experiment, TIME)
    fine = np.linspace(0.0, TIME[-1], DENSER * (TIME.size - 1) + 1)
    motor = [experiment.motor_position.value(time) for time in fine]
    load = [experiment.load_torque.value(time) for time in fine]
    start = {name: float(expected[name][0]) for name in ("joint_position", "joint_velocity")}
    motion = simulate(
        model, fine, motor, load, initial_state=start, interpolation="cubic", tolerance=1e-10
    )
    apart = motion["joint_position"][::DENSER] - expected["joint_position"]
    return float(np.abs(apart).max()), set(motion["slack_state"])


@pytest.mark.parametrize("seed", range(4))
def test_base_model(seed):
    actuator = random_actuator(seed)
    error, states = difference(actuator, as_model(actuator))
    assert states == {1.0, 2.0, 3.0}
    assert error < AGREEMENT


@pytest.mark.parametrize("seed", range(2))
def test_coulomb_friction(seed):
    actuator = random_actuator(10 + seed, friction=0.3)
    error, _ = difference(actuator, as_model(actuator))
    assert error < AGREEMENT


def test_overstretch_protection_with_the_exact_kink():
    actuator = random_actuator(20, string=1.5)
    stiffness, length = 1.5 * actuator.upper.stiffness, actuator.upper.max_deflection
    even = true.Spring(actuator.upper.stiffness, length, 5.0, true.Overstretch(0.008, stiffness))
    actuator = true.Actuator(**{**vars(actuator), "upper": even, "lower": even})
    model = as_model(actuator).with_effect(
        "overstretch_protection", {"engagement": 0.008 / length, "stiffness": stiffness}
    )
    error, _ = difference(actuator, model)
    assert error < AGREEMENT
