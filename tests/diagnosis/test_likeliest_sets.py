"""Which laws take part in pairs, and where a richer law begins."""

from types import SimpleNamespace

import pytest

from begun_search import COULOMB, DRAG, GRAVITY, begun
from elastic_tendon.diagnosis.around import STIFFER
from elastic_tendon.diagnosis.likeliest_sets import FOLLOWED
from elastic_tendon.effects import BY_ID
from smooth_motion import typical_model

STRIBECK = ("stribeck_friction",)


@pytest.fixture(scope="module")
def search():
    return begun(typical_model(*COULOMB), *COULOMB, *STRIBECK)


@pytest.mark.parametrize(("richer", "preferred"), [(6.0, COULOMB), (4.0, STRIBECK)])
def test_of_laws_of_one_thing_the_simplest_that_none_beats_by_far(
    search, richer, preferred, monkeypatch
) -> None:
    squares = {COULOMB: 10.0, STRIBECK: richer}
    estimates = {law: SimpleNamespace(square=square) for law, square in squares.items()}
    monkeypatch.setattr(search, "estimates", estimates)
    assert [law for law in estimates if search._law_preferred(*law)] == [preferred]


@pytest.mark.parametrize(("gravity", "drag", "likely"), [(11.0, 13.0, 2), (11.0, 11.5, 3)])
def test_pairs_close_to_the_likeliest_are_tried_too(
    search, gravity, drag, likely, monkeypatch
) -> None:
    pairs = {("constant_torque", *COULOMB): 10.0, (*GRAVITY, *COULOMB): gravity}
    pairs |= {(*DRAG, *COULOMB): drag}
    estimates = {pair: SimpleNamespace(square=square) for pair, square in pairs.items()}
    monkeypatch.setattr(search, "estimates", estimates)
    assert search._far_better(2, best=100.0) == list(pairs)[:likely]
    assert search._far_better(2, best=19.0) == []  # a single does nearly as well


def test_all_pairs_with_the_likeliest_are_estimated(search, monkeypatch) -> None:
    followed = []
    monkeypatch.setattr(
        search.screen, "combined", lambda *asked: followed.append(asked[-1]) or ({}, {})
    )
    estimates = {single: SimpleNamespace(square=1.0) for single in (COULOMB, GRAVITY)}
    monkeypatch.setattr(search, "estimates", estimates)
    search._pairs([COULOMB, GRAVITY], ["coulomb_friction", "gravity_load", *map(str, range(9))])
    assert followed == [10, FOLLOWED]


def test_a_richer_law_begins_as_the_simpler_one_too(search) -> None:
    richer, simpler = BY_ID[STRIBECK[0]], BY_ID[COULOMB[0]]
    begun_at = search._starts_like(richer, simpler, {"torque": 0.3})
    level = [start for start in begun_at if start["static_torque"] == 0.3]
    assert {start["coulomb_torque"] for start in level} == {0.3}
    assert len({start["stribeck_velocity"] for start in level}) == len(level) > 1
    assert all(0.2 < start["coulomb_torque"] < 0.45 for start in begun_at)


def test_a_simpler_law_begins_at_the_strength_of_the_richer(search) -> None:
    richer, simpler = BY_ID[STRIBECK[0]], BY_ID[COULOMB[0]]
    known = {"coulomb_torque": 0.3, "static_torque": 0.5, "stribeck_velocity": 0.1}
    (start,) = search._starts_like(simpler, richer, known)
    assert start["torque"] == pytest.approx(0.3)


def test_near_a_simpler_law_bristles_begin_stiff_too(search) -> None:
    """Without end, they would be the simpler law."""
    law, simpler = BY_ID["lugre_friction"], BY_ID[COULOMB[0]]

    def stiffest(*, near: bool) -> float:
        begun_at = search._starts_like(law, simpler, {"torque": 0.3}, near=near)
        return max(start["bristle_stiffness"] for start in begun_at)

    assert stiffest(near=True) == pytest.approx(STIFFER * stiffest(near=False))
