"""Actuators, motions and numbers on which every effect is tried."""

import numpy as np

from elastic_tendon.parameters import Model, load_model, typical_value

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


def with_typical(model: Model, effect) -> Model:
    """The model with an effect at its typical numbers, within their bounds."""
    numbers = {
        one.name: float(np.clip(typical_value(model, one), one.lower, one.upper))
        for one in effect.parameters
    }
    return model.with_effect(effect.id, numbers)
