"""The catalogue of physical effects; a new effect is its file and one line here.

An effect of the user's own comes in by `load_effect`, or from an installed package by its id.
"""

from pathlib import Path

from elastic_tendon.effects import (
    coulomb_friction,
    gear_backlash,
    gravity_load,
    joint_encoder_offset,
    joint_stop,
    lugre_friction,
    measurement_delay,
    motor_encoder_offset,
    overstretch_protection,
    pulley_eccentricity,
    quadratic_drag,
    spring_hardening,
    spring_hysteresis,
    spring_mass,
    spring_relaxation,
    stribeck_friction,
    tendon_compliance,
    tendon_guide_friction,
)
from elastic_tendon.effects.base import Effect
from elastic_tendon.effects.registry import Registry

CATALOGUE: tuple[Effect, ...] = (
    coulomb_friction.EFFECT,
    stribeck_friction.EFFECT,
    lugre_friction.EFFECT,
    quadratic_drag.EFFECT,
    gravity_load.EFFECT,
    joint_stop.EFFECT,
    overstretch_protection.EFFECT,
    spring_hardening.EFFECT,
    spring_hysteresis.EFFECT,
    spring_relaxation.EFFECT,
    spring_mass.EFFECT,
    tendon_guide_friction.EFFECT,
    tendon_compliance.EFFECT,
    pulley_eccentricity.EFFECT,
    gear_backlash.EFFECT,
    joint_encoder_offset.EFFECT,
    motor_encoder_offset.EFFECT,
    measurement_delay.EFFECT,
)
BY_ID = Registry(CATALOGUE)  # these, and what is loaded later


def load_effect(path: str | Path) -> Effect:
    """Run a Python file that defines ``EFFECT``; models can name its id from then on.

    Parameters
    ----------
    path : of the file; one that is loaded already is not run again

    Returns
    -------
    Effect

    Raises
    ------
    EffectError
        for a file that cannot be used, with the line and the reason
    """
    return BY_ID.load(path)
