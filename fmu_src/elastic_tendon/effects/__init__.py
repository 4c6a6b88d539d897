"""The catalogue of physical effects; a new effect is its file and two lines here.

An effect of the user's own comes in by `load`, or from an installed package by its id. It is
written with the classes that are imported here from `base`, and the functions of `symbolic`.
"""

from pathlib import Path

from elastic_tendon.effects import symbolic as symbolic
from elastic_tendon.effects.base import Contribution as Contribution
from elastic_tendon.effects.base import Effect as Effect
from elastic_tendon.effects.base import FrictionBounds as FrictionBounds
from elastic_tendon.effects.base import HalfTensions as HalfTensions
from elastic_tendon.effects.base import Parameter as Parameter
from elastic_tendon.effects.base import Relation as Relation
from elastic_tendon.effects.base import Slot as Slot
from elastic_tendon.effects.base import Spread as Spread
from elastic_tendon.effects.base import State as State
from elastic_tendon.effects.coulomb_friction import EFFECT as coulomb_friction
from elastic_tendon.effects.gear_backlash import EFFECT as gear_backlash
from elastic_tendon.effects.gravity_load import EFFECT as gravity_load
from elastic_tendon.effects.joint_encoder_offset import EFFECT as joint_encoder_offset
from elastic_tendon.effects.joint_stop import EFFECT as joint_stop
from elastic_tendon.effects.lugre_friction import EFFECT as lugre_friction
from elastic_tendon.effects.measurement_delay import EFFECT as measurement_delay
from elastic_tendon.effects.motor_encoder_offset import EFFECT as motor_encoder_offset
from elastic_tendon.effects.overstretch_protection import EFFECT as overstretch_protection
from elastic_tendon.effects.pulley_eccentricity import EFFECT as pulley_eccentricity
from elastic_tendon.effects.quadratic_drag import EFFECT as quadratic_drag
from elastic_tendon.effects.registry import Registry
from elastic_tendon.effects.spring_hardening import EFFECT as spring_hardening
from elastic_tendon.effects.spring_hysteresis import EFFECT as spring_hysteresis
from elastic_tendon.effects.spring_mass import EFFECT as spring_mass
from elastic_tendon.effects.spring_relaxation import EFFECT as spring_relaxation
from elastic_tendon.effects.stribeck_friction import EFFECT as stribeck_friction
from elastic_tendon.effects.tendon_compliance import EFFECT as tendon_compliance
from elastic_tendon.effects.tendon_guide_friction import EFFECT as tendon_guide_friction

CATALOGUE: tuple[Effect, ...] = (
    coulomb_friction,
    stribeck_friction,
    lugre_friction,
    quadratic_drag,
    gravity_load,
    joint_stop,
    overstretch_protection,
    spring_hardening,
    spring_hysteresis,
    spring_relaxation,
    spring_mass,
    tendon_guide_friction,
    tendon_compliance,
    pulley_eccentricity,
    gear_backlash,
    joint_encoder_offset,
    motor_encoder_offset,
    measurement_delay,
)
BY_ID = Registry(CATALOGUE)  # these, and what is loaded later


def load(path: str | Path) -> Effect:
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
