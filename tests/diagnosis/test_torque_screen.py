"""The screen names what hides in recordings of the independent simulator, and how large it is."""

from functools import cache

import numpy as np
import pytest

from effects_at import loaded_at_position
from elastic_tendon import effects
from elastic_tendon.diagnosis.sets import in_order, size_of
from elastic_tendon.diagnosis.torque_screen import Estimate, Screen
from elastic_tendon.errors import ModelError
from hidden_effect.cases import Case, Order, build
from smooth_motion import GIVEN, played, typical_model

SEED, SHORT = 900, 8.0  # of development; s
STRENGTHS = {  # effect -> by which its size is judged
    "coulomb_friction": "torque",
    "gravity_load": "torque",
    "spring_hardening": "cubic_stiffness",
    "quadratic_drag": "coefficient",
    "measurement_delay": "delay",
    "gear_backlash": "gap",
    "joint_encoder_offset": "offset",
    "spring_hysteresis": "force",
}
RIVALS = ("coulomb_friction", "gravity_load", "spring_hardening", "quadratic_drag")
PAIR = ("coulomb_friction", "gravity_load")
NOISE = 2e-4  # rad
# mean square of a right set: whitened by the given stiffness, which is off, and around every
# reversal nobody knows which way friction acts
LEFT = 1.5


@cache
def case_of(*names: str) -> Case:
    family = "effect" if len(names) == 1 else "two effects"
    return build(Order(family, names, 3.0, "multisine", "white", SEED, duration=SHORT))


@cache
def screen_of(*names: str) -> Screen:
    found = case_of(*names)
    return Screen(found.given, found.fit)


def strength(values, effect_id: str) -> float:
    return values[f"effects.{effect_id}.{STRENGTHS[effect_id]}"]


@pytest.mark.parametrize("effect_id", STRENGTHS)
def test_what_hides_is_estimated(effect_id: str) -> None:
    screen, true = screen_of(effect_id), case_of(effect_id).facts.numbers
    found = screen.single(effect_id)
    assert strength(found.values, effect_id) == pytest.approx(strength(true, effect_id), rel=0.06)
    assert found.square < LEFT
    assert screen.fit((), {}, 8).square > 1.5


def test_hops_lead_out_of_the_wrong_minima_of_contacts() -> None:
    backlash, protection = names = ("gear_backlash", "overstretch_protection")
    order = Order("two effects", names, 30.0, "multisine", "white", 3, duration=5.0)
    found = build(order)
    screen = Screen(found.given, found.fit)
    (stuck,) = screen.combined(screen.single(backlash), [protection], 1)[0].values()
    free = screen.hopped(stuck)
    assert free.square < 0.2 * stuck.square
    assert free.values[f"effects.{protection}.engagement"] == pytest.approx(
        found.facts.numbers[f"effects.{protection}.engagement"], rel=0.02
    )
    assert screen.hopped(free).square <= free.square


def test_what_hides_is_better_than_its_rivals() -> None:
    screen = screen_of("coulomb_friction")
    squares = {effect_id: screen.single(effect_id).square for effect_id in RIVALS}
    assert min(squares, key=lambda effect_id: squares[effect_id]) == "coulomb_friction"
    assert all(square > 1.1 for name, square in squares.items() if name != "coulomb_friction")


def test_a_pair_is_found_from_either_of_it() -> None:
    screen, true = screen_of(*PAIR), case_of(*PAIR).facts.numbers
    singles = {effect_id: screen.single(effect_id) for effect_id in RIVALS}
    for origin in PAIR:
        others = [effect_id for effect_id in RIVALS if effect_id != origin]
        found, looked = screen.combined(singles[origin], others, 2)
        assert set(looked) == {in_order((origin, effect_id)) for effect_id in others}
        assert min(looked, key=lambda added: looked[added].square) == PAIR
        assert PAIR in found
        assert len(found) == 2
        assert found[PAIR].square < LEFT
        for effect_id in PAIR:
            own = strength(found[PAIR].values, effect_id)
            assert own == pytest.approx(strength(true, effect_id), rel=0.06)


def test_a_look_knows_about_how_much_a_fit_will_leave() -> None:
    screen = screen_of(*PAIR)
    single = screen.single("coulomb_friction")
    screen.single("gravity_load")
    found, looked = screen.combined(single, ["gravity_load"], 1)
    assert found[PAIR].square <= 1.01 * looked[PAIR].square
    assert looked[PAIR].square < 0.5 * single.square


@pytest.mark.parametrize("effect_id", ["coulomb_friction", "gravity_load"])
def test_the_smallest_size_is_about_where_detection_begins(effect_id: str) -> None:
    """Where it would show with 95 %: a third of it hardly ever does, three times as much does."""
    plain = Screen(GIVEN, [played(GIVEN).recording(NOISE)])
    smallest = plain.smallest(plain.fit((), {}, 8), effect_id)
    assert smallest is not None
    name = STRENGTHS[effect_id]
    gains = {}
    for share in (0.3, 3.0):
        values = dict(typical_model(effect_id).effects[effect_id]) | {name: share * smallest}
        hidden = GIVEN.with_effect(effect_id, values)
        screen = Screen(GIVEN, [played(hidden).recording(NOISE)])
        without, found = screen.fit((), {}, 8), screen.single(effect_id)
        facts = len(without.residuals)
        gains[share] = facts * np.log(without.square / found.square)
    needed = 10.0 + size_of(found.added) * np.log(facts)
    assert gains[0.3] < needed < gains[3.0]


def test_an_effect_that_no_motion_shows_has_no_smallest_size() -> None:
    still = played(GIVEN).recording(NOISE).samples(slice(0, 1500))
    held = type(still)(
        **{
            **{name: getattr(still, name) for name in ("name", "time", "interpolation")},
            "motor_position": 0.0 * still.time,
            "signals": {"joint_position": NOISE * np.random.default_rng(1).standard_normal(1500)},
        }
    )
    screen = Screen(GIVEN, [held])
    assert screen.smallest(screen.fit((), {}, 4), "overstretch_protection") is None


def test_what_the_motion_does_not_resolve_is_not_seen() -> None:
    screen = screen_of("coulomb_friction")
    unseen = [effect_id for effect_id in loaded_at_position() if not screen.sees(effect_id)]
    assert unseen == ["spring_mass", "tendon_compliance"]


def test_two_laws_of_one_friction_do_not_go_together() -> None:
    screen = screen_of("coulomb_friction")
    assert not screen.goes(("coulomb_friction", "stribeck_friction"))
    assert not screen.goes(("gravity_load", "gravity_load"))
    assert screen.goes(PAIR)
    with pytest.raises(ModelError):
        screen.structure(("coulomb_friction", "stribeck_friction"))


def test_a_fit_starts_where_it_is_told_and_stays_within_bounds() -> None:
    screen = screen_of("coulomb_friction")
    path = "effects.coulomb_friction.torque"
    stopped = screen.fit(("coulomb_friction",), {path: 0.2}, 0)
    assert stopped.values[path] == pytest.approx(0.2)
    found = screen.fit(("coulomb_friction",), {path: 0.2}, 8)
    structure = screen.structure(("coulomb_friction",))
    assert np.all((structure.lower <= found.x) & (found.x <= structure.upper))
    assert found.square < stopped.square


def test_derivatives_are_those_of_differences() -> None:
    screen = screen_of("coulomb_friction")
    structure = screen.structure(("coulomb_friction",))
    found = screen.single("coulomb_friction").x
    start = np.clip(found, structure.lower + 1e-4, structure.upper - 1e-4)  # room for differences
    _, derivatives = screen.evaluate(structure, start)
    for column in range(len(start)):
        step = 1e-5 * np.eye(len(start))[column]
        high, low = (screen.evaluate(structure, start + sign * step)[0] for sign in (1.0, -1.0))
        difference = (high - low) / 2e-5
        error = np.linalg.norm(difference - derivatives[:, column])
        # smoothing takes a little of the motion, which the derivatives leave out
        assert error < 0.1 * np.linalg.norm(difference) + 1e-3


def test_sets_are_named_in_the_order_of_the_catalogue() -> None:
    assert in_order(reversed(effects.BY_ID.ids())) == effects.BY_ID.ids()
    assert in_order(["gravity_load", "coulomb_friction", "gravity_load"]) == PAIR


def test_an_estimate_that_has_run_away_leaves_infinitely_much() -> None:
    assert Estimate((), np.zeros(1), {}, np.array([1e200, 1.0])).square == np.inf
