"""Actuators, motions and numbers on which every effect is tried."""

import numpy as np

from effects_at import placed
from elastic_tendon.actuator.parameters import Model, load_model, typical_value
from elastic_tendon.simulation.simulate import sensitivities, simulate

TIME = np.arange(0.0, 3.0, 0.002)
MOTOR = 0.6 * np.sin(2 * np.pi * 1.9 * TIME) * np.sin(np.pi * TIME / 3.0)
LOAD = 8.0 * np.sin(3.0 * TIME)  # N·m, near the springs' limit

PAPER = load_model("biorob_x4_joint_3")
# nothing equal, nothing zero
CROOKED = PAPER.with_values(
    {
        "transmission.joint_pulley_radius": 0.034,
        "transmission.motor_pulley_radius": 0.021,
        "transmission.upper_spring.stiffness": 9000.0,
        "transmission.upper_spring.damping": 7.0,
        "transmission.lower_spring.parallel": 3,
        "transmission.lower_spring.damping": 4.0,
        "transmission.lower_spring.max_deflection": 0.012,
    }
)
MODELS = {"paper": PAPER, "crooked": CROOKED}


def drive(model):
    """What moves the motor, by name: its position, or a torque that also bears the load."""
    if not model.kind.has_rotor:
        return {"motor_position": MOTOR}
    transmission = model.transmission
    ratio = transmission.motor_pulley_radius / transmission.joint_pulley_radius
    return {"motor_torque": 2.0 * np.sin(9.0 * TIME) * np.sin(np.pi * TIME / 3.0) - ratio * LOAD}


def with_typical(model: Model, effect) -> Model:
    """The model with an effect at its typical numbers, within their bounds."""
    model = placed(model, effect)
    numbers = {
        parameter.name: float(
            np.clip(typical_value(model, parameter), parameter.lower, parameter.upper)
        )
        for parameter in effect.parameters
    }
    return model.with_effect(effect.id, numbers)


def measured(model, signal="joint_position", **options):
    """What a sensor reads."""
    motion = simulate(
        model, TIME, load_torque=LOAD, as_measured=True, **{**drive(model), **options}
    )
    return motion[motion.measured(signal)]


def assert_sensitivities_agree_with_differences(model, paths, relative, signal="joint_position"):
    """Exact derivatives of what is measured against central differences at 1e-5 of each value."""
    # cubic: where a delayed motor position has kinks, differences to the delay do not converge
    options = {"interpolation": "cubic", "as_measured": True, **drive(model)}
    exact = sensitivities(
        model, TIME, load_torque=LOAD, parameters=paths, tolerance=1e-10, **options
    )
    derivatives = exact.of(exact.trajectory.measured(signal))
    for path, column in zip(paths, derivatives.T, strict=True):
        value = model.values()[path]
        step = 1e-5 * value
        high, low = (
            measured(
                model.with_values({path: value + sign * step}),
                signal,
                interpolation="cubic",
                tolerance=1e-12,
            )
            for sign in (1, -1)
        )
        error = np.linalg.norm((high - low) / (2 * step) - column)
        assert error <= relative * np.linalg.norm(column), path
