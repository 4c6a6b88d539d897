"""Forms of every effect that a rival of the truth is tried in: shapes on a grid."""

import math
from itertools import product

import numpy as np

from hidden_effect.machines import Reached, Sizes, Tree, sizes_of

Numbers = dict[str, float]
Form = tuple[Numbers, Numbers]  # shapes, and strengths of an ordinary size


def frictions(s: Sizes) -> list[Form]:
    """Stribeck curves."""
    dry = 0.03 * s.torque
    return [
        ({"stribeck_velocity": v}, {"coulomb_torque": a * dry, "static_torque": b * dry})
        for v, (a, b) in product((0.05, 0.2, 0.8), ((1.0, 1.6), (0.3, 1.5)))
    ]


def bristles(s: Sizes) -> list[Form]:
    """The same with bristles."""
    damping = 0.5 * s.stiffness / s.frequency
    return [
        (shape | {"bristle_stiffness": k * s.stiffness, "bristle_damping": damping}, strength)
        for k, (shape, strength) in product((3.0, 15.0), frictions(s))
    ]


def stops(s: Sizes, reached: Reached) -> list[Form]:
    """A stop inside one end of the motion."""
    span = reached.highest - reached.lowest
    strength = {
        "stiffness": 10.0 * s.stiffness,
        "damping": 0.5 * s.stiffness / s.frequency,
    }
    return [
        (
            {
                "lower": reached.lowest + (inside if low else -1.0) * span,
                "upper": reached.highest - (inside if high else -1.0) * span,
            },
            strength,
        )
        for inside, (low, high) in product((0.01, 0.04, 0.1, 0.2), ((1, 0), (0, 1)))
    ]


def spring_forms(s: Sizes, reached: Reached) -> dict[str, list[Form]]:
    """What changes the springs and tendons."""
    force = 0.05 * s.spring * s.deflection
    ringing = 0.001 * s.stiffness / s.frequency * s.link_mass
    return {
        "overstretch_protection": [
            (
                {"engagement": share * reached.elongation / s.deflection},
                {"stiffness": 3.0 * s.spring},
            )
            for share in (0.4, 0.55, 0.7, 0.8, 0.9)
        ],
        "spring_hardening": [({}, {"cubic_stiffness": 0.3 * s.spring / s.deflection**2})],
        "spring_hysteresis": [
            ({"yield_length": share * s.deflection, "exponent": 1.0}, {"force": force})
            for share in (0.01, 0.04, 0.12, 0.4)
        ],
        "spring_relaxation": [
            ({"time_constant": share / s.frequency}, {"stiffness": 0.2 * s.spring})
            for share in (0.3, 1.5, 6.0, 30.0, 150.0)
        ],
        "spring_mass": [
            ({}, {"mass": share * s.link_mass, "damping": ringing}) for share in (0.003, 0.01)
        ],
        "tendon_guide_friction": [({}, {"wrap_friction": 0.05})],
        "tendon_compliance": [({}, {"compliance": 0.1 / s.side})],
    }


def forms(effect: str, tree: Tree, reached: Reached) -> list[Form]:
    """Shapes and ordinary strengths of an effect over a grid of its shapes."""
    s = sizes_of(tree)
    turns = np.linspace(-math.pi, math.pi, 8, endpoint=False).tolist()
    offsets: list[Form] = [({}, {"offset": sign * 0.01}) for sign in (-1.0, 1.0)]
    grids = spring_forms(s, reached) | {
        "coulomb_friction": [({}, {"torque": 0.03 * s.torque})],
        "stribeck_friction": frictions(s),
        "lugre_friction": bristles(s),
        "quadratic_drag": [({}, {"coefficient": 0.003})],
        "gravity_load": [({"angle": turn}, {"torque": 0.1 * s.torque}) for turn in turns],
        "constant_torque": [({}, {"torque": sign * 0.03 * s.torque}) for sign in (-1.0, 1.0)],
        "joint_stop": stops(s, reached),
        "gear_backlash": [({}, {"gap": 0.01})],
        "pulley_eccentricity": [({"phase": turn}, {"amplitude": 0.02}) for turn in turns],
        "joint_encoder_offset": offsets,
        "motor_encoder_offset": offsets,
        "measurement_delay": [({}, {"delay": 0.005})],
    }
    return grids[effect]
