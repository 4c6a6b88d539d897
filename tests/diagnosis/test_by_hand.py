"""The loop walked by hand on recordings of the independent simulator."""

from dataclasses import replace

import pytest

from elastic_tendon.diagnosis import by_hand
from elastic_tendon.diagnosis.by_hand import Walked
from elastic_tendon.diagnosis.rounds import Data, Outcome, look
from elastic_tendon.errors import ModelError
from elastic_tendon.identify.ladder import REFIT
from hand_made_diagnosis import friction_found
from recorded_machines import FRICTION

COULOMB = "coulomb_friction"
SHORT = 3.0  # s of the recordings
TORQUE = f"effects.{COULOMB}.torque"


def silent(_text: str, _share: float) -> None:
    pass


@pytest.fixture(scope="module")
def data(sticking) -> Data:
    known, recording, heldout = sticking
    fitted, judged = (one.window(None, SHORT) for one in (recording, heldout))
    return by_hand.data_of(known.model, [fitted], [judged])


@pytest.fixture(scope="module")
def start(data):
    """The refitted model, and what the search sees from it."""
    base = by_hand.base(data, silent)
    return base, look(data, base, silent)


@pytest.fixture(scope="module")
def walk(data, start) -> list[Walked]:
    """The suggestion taken, and the search looking on."""
    base, seen = start
    answer = by_hand.with_effect(data, base, seen.round.chosen, silent)
    then = look(data, answer, silent)
    return [Walked(REFIT, None, base, seen), Walked("with friction", COULOMB, answer, then)]


def test_taking_what_is_suggested_ends_in_the_diagnosis_of_the_loop(data, walk) -> None:
    found = by_hand.concluded(data, walk, silent)
    assert (found.verdict, found.added) == ("missing_effect", (COULOMB,))
    assert not found.interrupted
    assert [one.title for one in found.steps] == ["as given", REFIT, "with friction"]
    assert [one.chosen for one in found.rounds] == [COULOMB, None]
    torque = next(one for one in found.findings.estimates if one.path == TORQUE)
    assert torque.interval[0] <= FRICTION <= torque.interval[1]
    assert found.ladder[-1].noise_ratio["joint_position"] < 1.1
    assert not found.remaining["joint_position"].significant


def test_the_prior_stays_that_of_the_model_as_given(data, walk) -> None:
    given = data.given.uncertainty
    for one in walk:
        assert {path: one.answer.result.model.uncertainty[path] for path in given} == given


def test_where_nobody_searched_on_more_may_be_missing(data, walk) -> None:
    first, last = walk
    assert by_hand.concluded(data, [first], silent).interrupted
    assert by_hand.concluded(data, [first, replace(last, outcome=None)], silent).interrupted


def test_what_the_data_could_not_tell_apart_is_told(data, start, walk) -> None:
    seen = start[1]
    rival = next(one for one in seen.refitted if one.added[-1] != COULOMB)
    names = (COULOMB, rival.added[-1])
    candidates = tuple(
        replace(one, equivalence_class=names) if one.id in names else one
        for one in seen.round.candidates
    )
    alike = replace(seen, round=replace(seen.round, candidates=candidates))
    found = by_hand.concluded(data, [replace(walk[0], outcome=alike), walk[1]], silent)
    assert found.indistinguishable == (names,)
    assert found.next_experiment is not None or found.words


def test_any_effect_can_come_in_and_never_makes_the_fit_worse(data, start) -> None:
    base = start[0]
    answer = by_hand.with_effect(data, base, "gravity_load", silent)
    assert answer.added == ("gravity_load",)
    assert answer.floored @ answer.floored <= 1.001 * (base.floored @ base.floored)


def test_an_effect_comes_in_once(data, walk) -> None:
    with pytest.raises(ModelError, match="already"):
        by_hand.with_effect(data, walk[1].answer, COULOMB, silent)


def test_a_preview_has_the_numbers_of_the_round(start) -> None:
    base, seen = start
    fitted = by_hand.preview(base.result.model, seen, COULOMB)
    assert fitted.effects[COULOMB]["torque"] == pytest.approx(FRICTION, rel=0.05)
    unlikely = next(one for one in seen.round.candidates if not one.fitted)
    expected = by_hand.preview(base.result.model, seen, unlikely.id)
    assert unlikely.id in expected.effect_ids
    unseen = replace(seen.round, candidates=())
    with pytest.raises(ModelError, match="add it to have it fitted"):
        by_hand.preview(base.result.model, Outcome(unseen, None, (), (), ()), COULOMB)


def test_refits_of_a_round_can_be_stopped(data, start) -> None:
    def stopping(text: str, _share: float) -> None:
        if text.startswith("refitting with"):
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        look(data, start[0], stopping)


def test_a_round_tells_what_was_taken_by_hand() -> None:
    one = friction_found().rounds[0]
    first, second, *_ = (replace(candidate, verdict="taken") for candidate in one.candidates)
    one = replace(one, candidates=(first, second))
    assert by_hand.decided(one, COULOMB) is one
    untaken = by_hand.decided(one, None)
    assert untaken.chosen is None
    assert untaken.candidates[0].verdict == "the search would take it"
    other = by_hand.decided(one, second.id)
    assert other.chosen == second.id
    assert other.candidates[1].verdict.startswith("taken by hand")
