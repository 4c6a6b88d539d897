"""The loop from end to end on recordings of the independent simulator."""

import json
import signal
from contextlib import suppress
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from effects_at import searched_in_positions
from elastic_tendon.comparison.initial_state import estimate_initial_state
from elastic_tendon.diagnosis import conclude as concluding
from elastic_tendon.diagnosis import data as excerpting
from elastic_tendon.diagnosis import refits as refitting
from elastic_tendon.diagnosis.diagnose import _not_shown, diagnose
from elastic_tendon.diagnosis.diagnosis_json import diagnosis_json
from elastic_tendon.diagnosis.options import Options
from elastic_tendon.diagnosis.search import Search
from elastic_tendon.errors import MeasurementError, ModelError, SimulationError
from hidden_effect.cases import Order, build
from recorded_machines import FRICTION

COULOMB = "coulomb_friction"
TORQUE = f"effects.{COULOMB}.torque"
FEW = (COULOMB, "gravity_load", "quadratic_drag")
POSITION = "joint_position"
SHORT = 3.0  # s
PAIR = (COULOMB, "spring_hardening")


@pytest.fixture(scope="module")
def found(sticking):
    known, recording, heldout = sticking
    return diagnose(known.model, [recording], [heldout])


@pytest.fixture(scope="module")
def brief(sticking):
    """The sticking machine for a short while: model and recording."""
    known, recording, _ = sticking
    return known.model, recording.window(None, SHORT)


# ---- something hides -----------------------------------------------------------------------------


def test_hidden_friction_is_named_with_its_size(found) -> None:
    assert found.verdict == "missing_effect"
    assert found.added == (COULOMB,)
    assert found.complete
    assert found.sentence.startswith("Coulomb friction is surely missing: the error falls from ")
    torque = next(part for part in found.findings.estimates if part.path == TORQUE)
    assert torque.determined
    assert torque.interval[0] <= FRICTION <= torque.interval[1]


def test_the_error_falls_to_the_noise_on_both_recordings(found) -> None:
    first, last = found.ladder[0], found.ladder[-1]
    assert last.noise_ratio["joint_position"] < 1.1
    assert last.heldout_rmse["joint_position"] < 0.1 * first.heldout_rmse["joint_position"]
    assert not found.remaining["joint_position"].significant
    assert [part.role for part in found.recordings] == ["fitted", "validation"]


def test_the_evidence_is_complete(found) -> None:
    first = found.rounds[0]
    best = first.candidates[0]
    assert best.ids == first.chosen == (COULOMB,)
    assert best.evidence < -100.0
    assert best.gain > 0.5
    assert best.heldout_gain > 0.5
    assert TORQUE in best.expected_parameters
    assert sum(part.probability for part in first.candidates) <= 1.0 + 1e-9
    assert found.rounds[-1].chosen == ()
    assert found.ladder[-1].evidence < found.ladder[1].evidence - 100.0


def test_no_neighbour_does_better(found) -> None:
    changes = {part.change for part in found.neighbours}
    assert f"-{COULOMB}" in changes
    assert "+gravity_load" in changes
    for part in found.neighbours:
        if part.refitted and not part.reason:
            # a richer one may fit a little better, never so that it decides
            assert part.evidence > -10.0


def test_what_would_have_shown_is_told(found) -> None:
    would = {part.id: part for part in found.would_show}
    assert COULOMB not in would
    gravity = would["gravity_load"]
    assert gravity.path == "effects.gravity_load.torque"
    assert 0.0 < gravity.smallest < 0.3  # N·m; the friction that was found is 0.35
    assert {"N*m", "N.m", "N·m"} & {gravity.unit}


def test_each_other_effect_has_a_size_from_which_it_would_have_shown(found) -> None:
    told = {part.id: part for part in found.would_show}
    laws = {"stribeck_friction", "lugre_friction"}  # of what was found
    assert set(told) == set(searched_in_positions()) - {COULOMB} - laws
    # in place of softer springs nobody sees it
    compliance = told["tendon_compliance"].smallest
    assert compliance is None or compliance > 1e-6
    assert told["spring_mass"].smallest > 1e-3  # kg


def test_the_answer_starts_where_the_recording_does(found, sticking) -> None:
    state = estimate_initial_state(found.model, sticking[1])
    assert found.comparison.files[0].initial_state.position == pytest.approx(
        state.position, abs=1e-3
    )


def test_two_effects_are_found_together() -> None:
    case = build(Order("two effects", PAIR, 3.0, "multisine", "white", 900, duration=6.0))
    found = diagnose(case.given, case.fit)
    assert (found.verdict, set(found.added)) == ("missing_effect", set(PAIR))
    assert found.ladder[-1].rmse["joint_position"] < 1.1 * case.facts.floor["joint_position"]
    assert [len(part.chosen) for part in found.rounds] == [1, 1, 0]


# ---- nothing hides -------------------------------------------------------------------------------


def test_wrong_parameters_are_no_missing_effect(frictionless) -> None:
    known, recording = frictionless
    found = diagnose(known.model, [recording])
    assert (found.verdict, found.added) == ("wrong_parameter", ())
    assert "link.inertia" in found.parameters_changed
    assert "link.inertia" in found.sentence


def test_the_true_parameters_are_adequate(frictionless) -> None:
    known, recording = frictionless
    found = diagnose(known.model.with_values(known.truth), [recording])
    assert (found.verdict, found.added, found.parameters_changed) == ("adequate", (), ())
    assert all(part.chosen == () for part in found.rounds)


# ---- what a user asks for ------------------------------------------------------------------------


def test_the_same_call_gives_the_same_answer(brief) -> None:
    model, recording = brief
    texts = {
        json.dumps(diagnosis_json(diagnose(model, [recording], options=Options(only=FEW))))
        for _ in range(2)
    }
    assert len(texts) == 1


def test_only_and_without(brief) -> None:
    model, recording = brief
    found = diagnose(model, [recording], options=Options(only=FEW, without=(COULOMB,)))
    seen = {ids for part in found.rounds for row in part.candidates for ids in row.ids}
    assert seen <= {"gravity_load", "quadratic_drag"}
    assert COULOMB not in found.added


def test_an_effect_at_which_nothing_happens_is_found_again(brief) -> None:
    model, recording = brief
    idle = model.with_effect(COULOMB, {"torque": 0.0})
    found = diagnose(idle, [recording], options=Options(only=FEW))
    assert found.added == (COULOMB,)
    assert found.model.effects[COULOMB]["torque"] == pytest.approx(FRICTION, rel=0.05)


def test_one_step_at_a_time(brief) -> None:
    model, recording = brief
    seen = []
    found = diagnose(
        model,
        [recording],
        options=Options(only=FEW),
        ask=lambda part: bool(seen.append(part)),
    )
    assert [part.chosen for part in seen] == [(COULOMB,)]
    assert len(found.rounds) == 1
    assert found.added == (COULOMB,)


def test_when_time_is_up_there_is_an_answer(brief) -> None:
    model, recording = brief
    found = diagnose(model, [recording], options=Options(only=FEW, time_limit=0.3))
    assert not found.complete
    assert found.sentence.endswith("the search was stopped before its end.")
    assert found.ladder[1].rmse["joint_position"] <= found.ladder[0].rmse["joint_position"]
    assert diagnosis_json(found)["complete"] is False


@pytest.mark.parametrize("stage", ["refitting the par", "screening", "looking at what", "judging"])
def test_an_interrupt_keeps_what_was_found(brief, stage: str) -> None:
    model, recording = brief

    def interrupting(text: str, _share: float) -> None:
        if text.startswith(stage):
            raise KeyboardInterrupt

    found = diagnose(model, [recording], options=Options(only=FEW), progress=interrupting)
    assert not found.complete
    early = stage in ("refitting the par", "screening")
    assert found.added == (() if early else (COULOMB,))
    # whatever is left, and was not judged, makes no model adequate
    assert found.verdict == ("unexplained" if early else "missing_effect")
    assert found.remaining["joint_position"].p_value is None


def test_an_interrupt_that_a_library_swallows_is_heeded(brief) -> None:
    model, recording = brief
    told = []

    def swallowing(text: str, _share: float) -> None:
        told.append(text)
        if text.startswith("screening"):
            with suppress(KeyboardInterrupt):
                signal.raise_signal(signal.SIGINT)

    found = diagnose(model, [recording], options=Options(only=FEW), progress=swallowing)
    assert not found.complete
    assert [text.startswith("screening") for text in told].count(True) == 1
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_an_interrupt_while_it_is_concluded_loses_nothing(brief) -> None:
    model, recording = brief
    told = []

    def impatient(text: str, _share: float) -> None:
        if text.startswith("screening") or "missing torque" in text:
            told.append(text)
            signal.raise_signal(signal.SIGINT)

    found = diagnose(model, [recording], options=Options(only=FEW), progress=impatient)
    assert any("missing torque" in text for text in told)
    assert found.added == ()
    assert not found.complete
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


@pytest.mark.parametrize("stopped", [True, False])
def test_whoever_stops_a_search_does_not_wait_for_constants_of_long_recordings(
    sticking, monkeypatch, stopped
) -> None:
    known, recording, heldout = sticking
    lengths = []

    def explained_by(_model, measurement) -> None:
        lengths.append(len(measurement.time))

    monkeypatch.setattr(concluding, "explained_by", explained_by)
    monkeypatch.setattr(concluding, "SOON", 300)

    def report(text: str, _share: float) -> None:
        if stopped and text.startswith("screening"):
            raise KeyboardInterrupt

    options = Options(only=(COULOMB,))
    diagnose(
        known.model, [recording.window(None, SHORT)], [heldout], options=options, progress=report
    )
    assert lengths == [300 if stopped else len(heldout.time)]


def test_neighbours_are_held_against_the_answer_to_the_same_excerpt(brief, monkeypatch) -> None:
    model, recording = brief
    asked = []

    def neighbours_of(search, answer) -> tuple[()]:
        asked.append((search.answers[answer.added], answer))
        return ()

    monkeypatch.setattr(concluding, "neighbours_of", neighbours_of)
    monkeypatch.setattr(excerpting, "MOST", len(recording.time) // 2)
    monkeypatch.setattr(excerpting, "FEWER", len(recording.time) // 4)
    found = diagnose(model, [recording], options=Options(only=(COULOMB,)))
    assert found.added == (COULOMB,)
    ((searched, answer),) = asked
    assert answer is searched
    assert len(answer.floored) < len(recording.time)


def test_what_happens_where_no_excerpt_was_taken_is_no_disturbance(brief, monkeypatch) -> None:
    """Ten times the noise is left of all samples, and nothing on what was searched."""
    model, recording = brief
    n = len(recording.time)
    monkeypatch.setattr(excerpting, "MOST", n // 2)
    monkeypatch.setattr(excerpting, "FEWER", n // 4)
    monkeypatch.setattr("elastic_tendon.diagnosis.diagnose._not_shown", lambda *_: None)
    searched = excerpting.data_of(model, [recording], []).fitted
    seen = np.any(
        [(recording.time >= part.time[0]) & (recording.time <= part.time[-1]) for part in searched],
        axis=0,
    )
    bumped = recording.signals["joint_position"] + np.where(seen, 0.0, 0.02)
    other = replace(recording, signals={**recording.signals, "joint_position": bumped})
    found = diagnose(model, [other], options=Options(only=(COULOMB,)))
    assert found.verdict == "unexplained"


def test_what_excerpts_do_not_show_is_searched_where_the_answer_errs(brief, monkeypatch) -> None:
    model, recording = brief
    n = len(recording.time)
    monkeypatch.setattr(excerpting, "MOST", n // 2)
    monkeypatch.setattr(excerpting, "FEWER", n // 4)
    monkeypatch.setattr("elastic_tendon.diagnosis.diagnose.leaves_far_more", lambda *_: True)
    searched = []

    class Watched(Search):
        @classmethod
        def of(cls, data, progress) -> Search:
            searched.append(sum(len(part.time) for part in data.fitted))
            return super().of(data, progress)

    monkeypatch.setattr("elastic_tendon.diagnosis.diagnose.Search", Watched)
    found = diagnose(model, [recording], options=Options(only=(COULOMB,)))
    assert found.added == (COULOMB,)
    first, second = searched
    assert first < second < n


def test_where_excerpts_leave_more_than_the_whole_everything_is_searched() -> None:
    """An excerpt begins in the midst of a motion, which springs and friction remember."""
    data = SimpleNamespace(everything="everything", with_worst=lambda errors: errors)

    def more(excerpts: float, whole: float) -> object:
        answer = SimpleNamespace(mean_square=excerpts)
        fitted = SimpleNamespace(mean_square=whole, errors="the worst")
        return _not_shown(data, SimpleNamespace(answer=answer), fitted)

    assert more(excerpts=27.0, whole=1.0) == "everything"
    assert more(excerpts=1.0, whole=27.0) == "the worst"
    assert more(excerpts=27.0, whole=20.0) is None
    assert more(excerpts=2.0, whole=0.4) is None  # too little to matter


@pytest.mark.parametrize("horizon", [None, 1.0])
def test_windows_of_one_recording_do_not_contradict_one_another(
    brief, monkeypatch, horizon
) -> None:
    model, recording = brief
    asked = []

    def contradictions(_given, _answer, recordings, _report) -> dict[str, tuple[str, ...]]:
        asked.append(len(recordings))
        return {}

    monkeypatch.setattr(concluding, "contradictions", contradictions)
    found = diagnose(model, [recording], options=Options(only=("gravity_load",), horizon=horizon))
    assert found.verdict == "unexplained"
    assert asked == ([1] if horizon is None else [])


def test_progress_tells_what_is_tried_and_the_best_so_far(brief) -> None:
    model, recording = brief
    told: list[str] = []
    diagnose(
        *(model, [recording]), options=Options(only=FEW), progress=lambda text, _: told.append(text)
    )
    assert any(
        text.startswith("screening: Gravity load; best so far: no effect, ") for text in told
    )
    assert any("; best so far: Coulomb friction, 1." in text for text in told)


def test_a_candidate_that_cannot_be_refitted_is_a_row_with_its_reason(brief, monkeypatch) -> None:
    model, recording = brief
    whole = refitting.refit

    def refit(given, added, *rest):
        if COULOMB in added:
            raise SimulationError("it runs away")
        return whole(given, added, *rest)

    monkeypatch.setattr(refitting, "refit", refit)
    found = diagnose(model, [recording], options=Options(only=FEW))
    assert found.complete
    assert COULOMB not in found.added
    rows = [row for part in found.rounds[:1] for row in part.candidates if row.ids == (COULOMB,)]
    assert [row.reason for row in rows] == ["could not be refitted: it runs away"]
    content = json.loads(json.dumps(diagnosis_json(found), allow_nan=False))
    assert content["complete"]


def test_a_horizon_is_followed(brief) -> None:
    model, recording = brief
    found = diagnose(model, [recording], options=Options(only=FEW, horizon=1.0))
    assert found.added == (COULOMB,)
    assert len(found.comparison.files) == 3


def test_noise_is_that_of_all_recordings_and_doubts_of_it_are_told(brief) -> None:
    model, recording = brief
    first = replace(recording.with_noise({POSITION: 1e-4}), name="first")
    second = recording.window(1.0, None).with_noise({POSITION: 3e-3})
    found = diagnose(
        model, [first, second], options=Options(only=("gravity_load",), time_limit=0.01)
    )
    sizes = [len(part.time) * part.noise[POSITION].sigma ** 2 for part in (first, second)]
    samples = len(first.time) + len(second.time)
    assert found.noise[POSITION].sigma == pytest.approx((sum(sizes) / samples) ** 0.5)
    (note,) = [note for note in found.notes if note.startswith(f"{second.name}: the noise")]
    assert "what was given is taken" in note


# ---- what is refused -----------------------------------------------------------------------------


def test_fitted_samples_cannot_judge(sticking) -> None:
    known, recording, _ = sticking
    with pytest.raises(MeasurementError, match="shares samples"):
        diagnose(known.model, [recording], [replace(recording, name="again")])


def test_unknown_effects_are_named(brief) -> None:
    model, recording = brief
    with pytest.raises(ModelError, match="colomb"):
        diagnose(model, [recording], options=Options(only=("colomb_friction",)))
