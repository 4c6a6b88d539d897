"""Which cases the study asks for."""

import random
from collections.abc import Iterator
from itertools import cycle

from hidden_effect import motions, recordings
from hidden_effect.cases import FIRST_REPORTED_SEED, Order
from hidden_effect.machines import EFFECTS
from truth.outside import OTHER_LAWS, OUTSIDE

RATIOS = (0.1, 0.3, 1.0, 3.0)
PAIRS = (
    ("coulomb_friction", "spring_hardening"),
    ("gravity_load", "quadratic_drag"),
    ("gear_backlash", "spring_hysteresis"),
    ("joint_encoder_offset", "measurement_delay"),
    ("coulomb_friction", "pulley_eccentricity"),
    ("joint_stop", "spring_relaxation"),
    ("stribeck_friction", "gravity_load"),
    ("coulomb_friction", "motor_encoder_offset"),
    ("measurement_delay", "spring_hysteresis"),
    ("joint_stop", "coulomb_friction"),
    ("gravity_load", "spring_hardening"),
    ("overstretch_protection", "quadratic_drag"),
)
NOTHING, WRONG = 10, 24  # cases for each of a cell
# effects of different places, on which the harder noises are tried
DIFFERENT = (
    *("coulomb_friction", "gravity_load", "spring_hardening"),
    *("joint_encoder_offset", "measurement_delay", "spring_hysteresis"),
)


def orders(cases: int, reported: bool) -> list[Order]:
    """All cases of a study, mixed, so that a part of them says what the whole will.

    Parameters
    ----------
    cases : for each cell
    reported : seeds from which nothing was tuned, else those of development
    """
    first = FIRST_REPORTED_SEED if reported else 0
    found = [
        order
        for number in range(cases)
        for order in (*_effects(first + number), *_others(first + number))
    ]
    random.Random(7).shuffle(found)
    return found


def _effects(seed: int) -> Iterator[Order]:
    """Every effect at every strength in every experiment."""
    noises = cycle(("white", "white", "quantised", "white", "quantised"))
    for number, effect in enumerate(EFFECTS):
        for kind in motions.KINDS:
            for ratio in RATIOS:
                torque = (number + seed + round(10 * ratio)) % 5 == 0
                yield Order("effect", (effect,), ratio, kind, next(noises), seed, torque)
        kind = motions.RICH[(number + seed) % 2]
        yield Order("effect", (effect,), 1.0, kind, "white", seed, interpolation="linear")


def _others(seed: int) -> Iterator[Order]:
    """Nothing hidden, wrong numbers, two effects, and what is not in the catalogue."""
    rich = cycle(motions.RICH)
    for noise in recordings.NOISES:
        for number in range(NOTHING):
            yield Order("nothing", (), 0.0, next(rich), noise, 100 * seed + number)
        for effect in () if noise in recordings.PLAIN else DIFFERENT:
            yield Order("effect", (effect,), 1.0, next(rich), noise, seed)
    for number in range(WRONG):
        noise = recordings.PLAIN[number % 2]
        yield Order("wrong parameter", (), 0.0, next(rich), noise, 100 * seed + number)
    for pair in PAIRS:
        for ratio in (1.0, 3.0):
            yield Order("two effects", pair, ratio, next(rich), "white", seed)
    for family, laws in (("outside", OUTSIDE), ("other law", OTHER_LAWS)):
        for law in laws:
            for ratio in (1.0, 3.0):
                yield Order(family, (law,), ratio, next(rich), "white", seed)
