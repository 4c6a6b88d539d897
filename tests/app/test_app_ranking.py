"""What the step Which effect says."""

from dataclasses import replace

import pytest

from elastic_tendon import effects
from elastic_tendon.actuator.parameters import load_model
from elastic_tendon.app import ranking, walk
from elastic_tendon.app.document import Version, new_document
from elastic_tendon.app.results import Compared
from elastic_tendon.app.workspace import Cache
from elastic_tendon.progress import silent
from elastic_tendon.reports.first_screen import of_diagnosis
from elastic_tendon.simulation.signature import signature
from hand_made_diagnosis import COULOMB, friction_found

MODEL = load_model("biorob_x4_joint_3")


def first_round():
    return friction_found().rounds[0]


def test_what_the_data_cannot_tell_apart_stands_together() -> None:
    first = first_round()
    groups = ranking.refitted(first)
    assert [[candidate.ids for candidate in group] for group in groups] == [
        [(COULOMB,), ("lugre_friction",)]
    ]
    assert len(ranking.unlikely(first)) == len(first.candidates) - 2


def test_nothing_missing_is_said_as_such() -> None:
    last = friction_found().rounds[-1]
    assert ranking.suggestion(last) == "The search would add nothing: nothing is left but noise."


def test_what_the_search_would_take_is_as_sure_as_its_probability() -> None:
    first = first_round()
    taken, alike, *others = first.candidates
    assert alike.ids in taken.equivalence_class
    for own, second, word in (
        (0.9, 0.095, "surely"),
        (0.5, 0.45, "probably"),
        (0.6, 0.2, "perhaps"),
    ):
        rows = (replace(taken, probability=own), replace(alike, probability=second), *others)
        told = ranking.suggestion(replace(first, candidates=rows))
        assert told.endswith(f", and is {word} there.")


def test_the_step_begins_with_what_is_missing_how_far_the_error_falls_and_what_now() -> None:
    found = friction_found()
    given, refitted, with_it = found.ladder
    seen = ranking.screen(found.rounds[0], [given, refitted], with_it)
    assert seen.verdict == ranking.suggestion(found.rounds[0])
    assert seen.errors == of_diagnosis(found).errors
    assert seen.advice.startswith("add Coulomb friction, and search again")


def test_before_its_error_is_known_nothing_is_promised() -> None:
    found = friction_found()
    assert ranking.screen(found.rounds[0], found.ladder[:2], None).errors == ()


def test_the_step_begins_with_the_error_before_anybody_searched() -> None:
    found = friction_found()
    seen = ranking.screen(None, found.ladder[:2], None)
    assert "not searched" in seen.verdict
    assert seen.errors[0].startswith("The joint position error falls from 37.5 to ")
    assert ranking.SEARCH in seen.advice


@pytest.mark.parametrize(("rest", "words"), [(1.0, "Take away"), (9.0, "other motions")])
def test_where_nothing_is_to_be_added_the_rest_says_what_now(rest: float, words: str) -> None:
    found = friction_found()
    last = replace(found.ladder[-1], noise_ratio={"joint_position": rest})
    seen = ranking.screen(found.rounds[-1], [found.ladder[0], last], last)
    assert words in seen.advice


def test_the_search_says_what_it_will_do() -> None:
    document = new_document(MODEL)
    assert "refitted first" in ranking.search_words(document)[1]
    key = document.data_key()
    fitted = Version(id="", parent="1", title="", model=MODEL.to_toml(), fitted_to=key)
    document = document.adding(fitted)
    assert "refitted first" not in ranking.search_words(document)[1]
    assert ranking.search_words(document.with_search("2", key))[1] == ""


def test_an_effect_that_a_model_cannot_take_is_not_offered() -> None:
    model = MODEL.with_effect(COULOMB, None)
    assert "already" in ranking.refusal(model, effects.BY_ID[COULOMB])
    assert "law" in ranking.refusal(model, effects.BY_ID["lugre_friction"])
    offered = {choice["value"] for choice in ranking.choices(new_document(MODEL), model)}
    assert offered.isdisjoint({COULOMB, "stribeck_friction", "lugre_friction"})
    assert "gear_backlash" in offered


def test_only_what_the_search_names_is_looked_at_unasked() -> None:
    first = first_round()
    assert ranking.first_choice(None) is None
    assert ranking.first_choice(first) == COULOMB
    assert ranking.first_choice(replace(first, chosen=())) is None


def test_small_odds_of_none_of_them_are_no_sign_of_an_effect() -> None:
    undecided = replace(first_round(), chosen=(), reason="no effect was taken")
    assert "has to be decidedly more than chance" in ranking.suggestion(undecided)
    assert "others likely" not in ranking.suggestion(friction_found().rounds[-1])


def test_the_picture_of_an_effect_names_its_machine_and_size() -> None:
    told = ranking.signature_words(signature(effects.BY_ID[COULOMB], MODEL))
    assert told.startswith("On biorob_x4_joint_3, typical: torque")
    assert told.endswith("N·m.")


def test_an_effect_of_the_motor_is_pictured_where_a_torque_drives_it() -> None:
    seen = Cache().obtain(walk.shows("motor_friction"), silent)
    assert seen.difference > 0.0
    assert seen.experiments[0] == "slow load, torque that would hold the motor"


def test_a_try_says_whether_its_numbers_were_fitted() -> None:
    found = friction_found()
    before, after = found.ladder[-2:]
    step = found.steps[-1]
    tried = walk.Tried(Compared(step.comparison, step.heldout), before, after)
    fitted, *_, unlikely = first_round().candidates
    assert not any("screen" in sentence for sentence in ranking.tried_sentences(tried, fitted))
    told = ranking.tried_sentences(tried, unlikely)
    assert any("screen" in sentence for sentence in told)
    assert told[-1] == "Nothing was added."
