"""Names and sizes of sets of effects, their other laws and aliases, and models with them."""

import pytest

from begun_search import COULOMB, DRAG, GRAVITY
from elastic_tendon.diagnosis.sets import (
    aliases,
    change_between,
    limiting,
    model_with,
    richer,
    simpler,
    size_of,
)


@pytest.mark.parametrize(
    ("before", "after", "change"),
    [
        ((), COULOMB, "+coulomb_friction"),
        (COULOMB, (), "-coulomb_friction"),
        (COULOMB, GRAVITY, "coulomb_friction -> gravity_load"),
        ((*COULOMB, *DRAG), (*GRAVITY, *DRAG), "coulomb_friction -> gravity_load"),
        (DRAG, (*COULOMB, *GRAVITY), None),
        ((*COULOMB, *GRAVITY), DRAG, None),
        ((), (*COULOMB, *GRAVITY), None),
        ((*COULOMB, *GRAVITY), (), None),
    ],
)
def test_a_change_is_named(before, after, change) -> None:
    assert change_between(before, after) == change


def test_the_size_of_a_set_is_its_number_of_parameters() -> None:
    assert size_of(()) == 0
    assert size_of((*COULOMB, *GRAVITY)) == 3


def test_aliases_take_the_place_of_an_effect() -> None:
    assert list(aliases(("gravity_load",))) == []
    assert list(aliases((*COULOMB, "joint_encoder_offset"))) == [
        ("tendon_guide_friction", "joint_encoder_offset"),
        (*COULOMB, "constant_torque"),
        (*COULOMB, "motor_encoder_offset"),
    ]
    assert list(aliases(("tendon_compliance",))) == []  # its aliases are no effects


def test_what_an_effect_comes_to_takes_its_place() -> None:
    assert list(limiting((*COULOMB, *GRAVITY))) == [(*COULOMB, "constant_torque")]
    assert list(limiting((*GRAVITY, "constant_torque"))) == []


def test_simpler_laws_of_the_same_thing() -> None:
    assert list(simpler((*COULOMB, *GRAVITY))) == []
    assert list(simpler(("stribeck_friction", *GRAVITY))) == [(*COULOMB, *GRAVITY)]
    assert set(simpler(("lugre_friction",))) == {COULOMB, ("stribeck_friction",)}


def test_richer_laws_of_the_same_thing() -> None:
    assert list(richer(("lugre_friction",))) == list(richer(GRAVITY)) == []
    assert list(richer((*COULOMB, *GRAVITY))) == [
        ("stribeck_friction", *GRAVITY),
        ("lugre_friction", *GRAVITY),
    ]


def test_a_model_with_a_set_has_its_values_within_bounds(sticking) -> None:
    model = sticking[0].model
    values = {"effects.coulomb_friction.torque": -1.0, "link.inertia": 0.05}
    found = model_with(model, COULOMB, values)
    assert found.effects["coulomb_friction"]["torque"] == 0.0
    assert found.link.inertia == 0.05
    assert found.link.damping == model.link.damping
