"""The torque balance holds along motions of the product's own simulator."""

from functools import cache

import numpy as np
import pytest

from effects_at import IDS_AT_POSITION
from elastic_tendon.diagnosis.torque_balance import Balance, Torque, Torques, torque_balance
from elastic_tendon.estimation.coordinates import free_parameters
from smooth_motion import SETTLED, Played, played, typical_model

# the mass of a spring swings faster than the motion is sampled
RINGING = "spring_mass"
SMALL = 3e-4  # of the torque's RMS; the median residual
# the acceleration that is read is not that of the joint
SCALED = {"deflection_gain", "joint_encoder_gain"}
# dry friction turns the acceleration at once: splines of the samples ring there for a while
KINKED = 1e-3
SETS = (
    ("spring_hardening", "gear_backlash"),  # implicit: a pulley floats between hardening springs
    ("spring_hardening", "tendon_compliance"),
    ("tendon_compliance",),
    ("coulomb_friction", "spring_hysteresis", "measurement_delay"),
    ("spring_relaxation", "gravity_load", "joint_encoder_offset"),
    ("motor_encoder_offset", "measurement_delay", "pulley_eccentricity"),
)
SHOWN = ("joint_torque", "motor_torque")
STEP = 1e-6  # of a parameter's size, for differences
DAMPINGS = ("transmission.upper_spring.damping", "transmission.lower_spring.damping")
DAMPING = 20.0  # N s/m


@cache
def run(*effect_ids: str) -> Played:
    return played(typical_model(*effect_ids))


def balance_of(found: Played) -> Balance:
    return torque_balance(found.model.effect_ids, free_parameters(found.model), SHOWN)


def torques(found: Played) -> Torques:
    return balance_of(found).torques(found.model.values(), found.motion)


def each_of(along: Torques) -> list[Torque]:
    """The torque on the link and those that sensors show."""
    return [along.moved[0], *along.shown.values()]


def residual(found: Played) -> float:
    """Median of what is left of the balance, of the torque's RMS."""
    torque = found.model.link.inertia * found.acceleration
    left = np.abs(torque - torques(found).moved[0].value)[SETTLED]
    return float(np.median(left) / np.std(torque[SETTLED]))


@pytest.mark.parametrize("effect_id", sorted({*IDS_AT_POSITION} - {RINGING} - SCALED))
def test_inertia_times_acceleration_is_the_torque(effect_id: str) -> None:
    assert residual(run(effect_id)) < SMALL


@pytest.mark.parametrize("effect_ids", SETS, ids="+".join)
def test_sets_balance_too(effect_ids: tuple[str, ...]) -> None:
    assert residual(run(*effect_ids)) < (KINKED if "coulomb_friction" in effect_ids else SMALL)


def test_the_memory_of_few_effects_is_too_quick_for_the_instants() -> None:
    unresolved = {name for name in IDS_AT_POSITION if not torque_balance((name,), ()).resolved}
    assert unresolved == {RINGING, "tendon_compliance"}


@pytest.mark.parametrize(
    "effect_ids", [*((name,) for name in IDS_AT_POSITION), *SETS], ids="+".join
)
def test_derivatives_are_those_of_differences(effect_ids: tuple[str, ...]) -> None:
    found = run(*effect_ids)
    balance, motion = balance_of(found), found.motion
    # a damping of 0 is where it begins: there are no differences to both sides of it
    values = {**found.model.values(), **dict.fromkeys(DAMPINGS, DAMPING)}
    along = balance.torques(values, motion)
    for column, path in enumerate(balance.paths):
        step = STEP * abs(values[path]) or STEP * found.model.uncertainty_of(path)
        beside = [
            balance.torques({**values, path: values[path] + sign * step}, motion)
            for sign in (1.0, -1.0)
        ]
        for torque, high, low in zip(*(each_of(part) for part in (along, *beside)), strict=True):
            exact = torque.by_parameter[:, column]
            error = np.abs((high.value - low.value) / (2.0 * step) - exact)
            rounding = 1e-9 * np.max(np.abs(torque.value)) / step
            # but for samples at which a mode changes within the step
            assert np.quantile(error, 0.98) < 1e-4 * np.max(np.abs(exact)) + rounding


@pytest.mark.parametrize("effect_ids", [(), ("spring_hardening", "gear_backlash")])
def test_slopes_are_those_of_differences(effect_ids: tuple[str, ...]) -> None:
    found = run(*effect_ids)
    balance, motion, values = balance_of(found), found.motion, found.model.values()
    along = balance.torques(values, motion)
    for name in ("position", "velocity"):
        own, step = getattr(motion, name), STEP
        beside = [
            balance.torques(values, type(motion)(**{**vars(motion), name: own + sign * step}))
            for sign in (1.0, -1.0)
        ]
        for torque, high, low in zip(*(each_of(part) for part in (along, *beside)), strict=True):
            exact = getattr(torque, f"by_{name}")
            error = np.abs((high.value - low.value) / (2.0 * step) - exact)
            assert np.quantile(error, 0.98) <= 1e-4 * np.max(np.abs(exact))


def test_friction_holds_as_far_as_it_can() -> None:
    found = run("coulomb_friction")
    balance, motion, values = balance_of(found), found.motion, found.model.values()
    still = np.tile([0.0, 0.0, 1.0, 0.0, 0.0, 0.0], (len(motion.position), 1))
    resting = type(motion)(**{**vars(motion), "weights": still})
    held = balance.torques(values, resting).moved[0].value
    friction = values["effects.coulomb_friction.torque"]
    free = {**values, "effects.coulomb_friction.torque": 0.0}
    push = balance.torques(free, motion).moved[0].value
    np.testing.assert_allclose(
        held, np.sign(push) * np.maximum(np.abs(push) - friction, 0.0), atol=1e-12
    )


def test_a_balance_is_made_once() -> None:
    assert torque_balance(("gravity_load",), ("link.inertia",)) is torque_balance(
        ["gravity_load"], ["link.inertia"]
    )
