"""The loop walked by hand on recordings of the independent simulator."""

from dataclasses import replace

import pytest

from elastic_tendon import demo
from elastic_tendon.actuator.parameters import load_model
from elastic_tendon.diagnosis import by_hand
from elastic_tendon.diagnosis.by_hand import Ranked, Walked, next_round, ranked
from elastic_tendon.diagnosis.data import Data, data_of
from elastic_tendon.diagnosis.options import Options
from elastic_tendon.diagnosis.rounds import TAKEN
from elastic_tendon.errors import ModelError
from elastic_tendon.estimation.ladder import REFIT
from elastic_tendon.measurement import read_measurement
from hand_made_diagnosis import friction_found
from recorded_machines import FRICTION

COULOMB = "coulomb_friction"
SHORT = 3.0  # s of the recordings
TORQUE = f"effects.{COULOMB}.torque"
FEW = Options(only=(COULOMB, "gravity_load", "quadratic_drag", "spring_hardening"))


def silent(_text: str, _share: float) -> None:
    """Nobody asked."""


@pytest.fixture(scope="module")
def data(sticking) -> Data:
    known, recording, heldout = sticking
    fitted, judged = (part.window(None, SHORT) for part in (recording, heldout))
    return data_of(known.model, [fitted], [judged], FEW)


@pytest.fixture(scope="module")
def start(data):
    """The refitted model, and what the search sees from it."""
    base = by_hand.base(data, silent)
    return base, next_round(data, base, silent)


@pytest.fixture(scope="module")
def walk(data, start) -> list[Walked]:
    """The suggestion taken, and the search looking on."""
    base, seen = start
    answer = by_hand.with_effect(data, base, seen.round.chosen[0], silent)
    then = next_round(data, answer, silent)
    return [Walked(REFIT, None, base, seen), Walked("with friction", COULOMB, answer, then)]


# ---- looking -------------------------------------------------------------------------------------


def test_a_look_suggests_and_adds_nothing(start) -> None:
    base, seen = start
    assert base.added == ()
    assert seen.round.chosen == (COULOMB,)
    assert {row.ids for row in seen.round.candidates} >= {(name,) for name in FEW.only}
    assert seen.search.answer.added == (COULOMB,)


def test_where_nothing_is_missing_a_look_suggests_nothing(walk) -> None:
    last = walk[-1].outcome
    assert last.round.chosen == ()
    assert all(COULOMB not in row.ids for row in last.round.candidates)


def test_refits_of_a_look_can_be_stopped(data, start) -> None:
    def stopping(text: str, _share: float) -> None:
        if text.startswith("refitting the likeliest"):
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        next_round(data, start[0], stopping)


# ---- adding --------------------------------------------------------------------------------------


def test_the_prior_stays_that_of_the_model_as_given(data, walk) -> None:
    given = data.given.uncertainty
    for step in walk:
        own = step.answer.result.model.uncertainty
        assert {path: own[path] for path in given} == given


@pytest.mark.parametrize("effect_id", ["gravity_load", "tendon_compliance"])
def test_any_effect_can_come_in_and_never_makes_the_fit_worse(data, start, effect_id) -> None:
    base = start[0]
    answer = by_hand.with_effect(data, base, effect_id, silent)
    assert answer.added == (effect_id,)
    assert answer.floored @ answer.floored <= 1.001 * (base.floored @ base.floored)


def test_an_effect_comes_in_once(data, walk) -> None:
    with pytest.raises(ModelError, match="already"):
        by_hand.with_effect(data, walk[1].answer, COULOMB, silent)


def test_a_refit_again_starts_where_it_was(data, walk) -> None:
    before = walk[1].answer
    after = by_hand.again(data, before.added, before.result.model, silent)
    assert after.added == before.added
    assert after.values(COULOMB)["torque"] == pytest.approx(FRICTION, rel=0.05)
    assert after.floored @ after.floored <= 1.001 * (before.floored @ before.floored)


# ---- previews ------------------------------------------------------------------------------------


def test_a_preview_of_what_was_refitted_has_its_values(start) -> None:
    base, seen = start
    fitted = by_hand.preview(base.result.model, ranked(base.result.model, seen), COULOMB)
    assert fitted.effects[COULOMB]["torque"] == pytest.approx(FRICTION, rel=0.05)


def test_a_preview_of_another_has_what_the_screen_expects(start) -> None:
    base, seen = start
    unlikely = next(row for row in seen.round.candidates if not row.fitted and len(row.ids) == 1)
    (effect_id,) = unlikely.ids
    found = by_hand.preview(base.result.model, ranked(base.result.model, seen), effect_id)
    for name, value in found.effects[effect_id].items():
        assert value == pytest.approx(unlikely.expected_parameters[f"effects.{effect_id}.{name}"])


def test_what_the_search_has_not_seen_has_no_preview(start) -> None:
    base, seen = start
    unseen = Ranked(replace(seen.round, candidates=()), {})
    with pytest.raises(ModelError, match="add it to have it fitted"):
        by_hand.preview(base.result.model, unseen, COULOMB)


# ---- what it amounts to --------------------------------------------------------------------------


def test_taking_what_is_suggested_ends_in_the_diagnosis_of_the_loop(data, walk) -> None:
    found = by_hand.concluded(data, walk, silent)
    assert (found.verdict, found.added) == ("missing_effect", (COULOMB,))
    assert found.complete
    assert [step.title for step in found.steps] == ["as given", REFIT, "with friction"]
    assert [part.chosen for part in found.rounds] == [(COULOMB,), ()]
    torque = next(part for part in found.findings.estimates if part.path == TORQUE)
    assert torque.interval[0] <= FRICTION <= torque.interval[1]
    assert found.ladder[-1].noise_ratio["joint_position"] < 1.1
    assert not found.remaining["joint_position"].significant
    assert "surely missing" in found.sentence


def test_where_nobody_searched_on_more_may_be_missing(data, walk) -> None:
    first, last = walk
    assert not by_hand.concluded(data, [first], silent).complete
    assert not by_hand.concluded(data, [first, replace(last, outcome=None)], silent).complete


def test_a_step_against_the_search_is_told_as_such(data, start) -> None:
    base, seen = start
    gravity = by_hand.with_effect(data, base, "gravity_load", silent)
    steps = [Walked(REFIT, None, base, seen), Walked("gravity", "gravity_load", gravity, None)]
    found = by_hand.concluded(data, steps, silent)
    assert found.added == ("gravity_load",)
    reasons = {row.ids: row.reason for row in found.rounds[0].candidates}
    assert reasons[(COULOMB,)] == by_hand.SUGGESTED
    assert reasons[("gravity_load",)].startswith(by_hand.BY_HAND)


def test_a_round_tells_what_was_taken_by_hand() -> None:
    found = friction_found().rounds[0]
    first, second, *_ = (replace(row, reason=TAKEN) for row in found.candidates)
    found = replace(found, candidates=(first, second))
    assert by_hand.decided(found, COULOMB) is found
    untaken = by_hand.decided(found, None)
    assert untaken.chosen == ()
    assert untaken.candidates[0].reason == by_hand.SUGGESTED
    other = by_hand.decided(found, second.ids[0])
    assert other.chosen == second.ids
    assert other.candidates[1].reason.startswith(by_hand.BY_HAND)


# ---- what is left open ---------------------------------------------------------------------------

GUIDE = "tendon_guide_friction"


@pytest.fixture(scope="module")
def short() -> Data:
    """A recording so short that it does not tell where friction acts."""
    recording = read_measurement(str(demo.DATA / "demo_fit.csv")).window(None, 1.0)
    given = load_model(demo.DATA / "demo_model.toml")
    return data_of(given, [recording], [], Options(only=(COULOMB, GUIDE)))


@pytest.fixture(scope="module")
def undecided(short) -> list[Walked]:
    base = by_hand.base(short, silent)
    return [Walked(REFIT, None, base, next_round(short, base, silent))]


def test_what_is_left_open_is_what_the_search_would_take_and_its_rivals(short, undecided) -> None:
    found = by_hand.left_open(short, undecided, silent)
    assert set(found.sets) == {(COULOMB,), (GUIDE,)}
    assert found.sets[0] == undecided[-1].outcome.round.chosen
    assert found.complete
    assert found.shared == frozenset()
    assert set(found.names) == {COULOMB, GUIDE}


def test_what_was_refitted_before_the_choice_is_still_a_rival_after_it(short, undecided) -> None:
    answer = by_hand.with_effect(short, undecided[-1].answer, COULOMB, silent)
    then = next_round(short, answer, silent)
    known = dict(then.search.answers)
    walk = [*undecided, Walked("with friction", COULOMB, answer, then)]
    assert by_hand.left_open(short, walk, silent).sets == ((COULOMB,), (GUIDE,))
    assert then.search.answers == known
    found = by_hand.concluded(short, walk, silent)
    assert found.indistinguishable == ((COULOMB, GUIDE),)
    assert found.next_experiment is not None


def test_the_experiment_decides_between_what_is_left_open(short, undecided) -> None:
    found = by_hand.proposed(short, undecided, silent)
    assert found.reason == ""
    assert set(found.experiment.predictions) == {COULOMB, GUIDE}
    assert found.experiment.power > 0.95


def test_where_the_data_decide_nothing_is_left_open(data, walk) -> None:
    found = by_hand.left_open(data, walk, silent)
    assert (found.sets, found.names, found.complete) == ((), [], True)
