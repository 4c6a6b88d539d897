"""The loop from end to end on recordings of the independent simulator."""

import json
from dataclasses import replace

import pytest

from elastic_tendon.diagnosis.diagnose import diagnose
from elastic_tendon.diagnosis.diagnosis_json import diagnosis_json
from elastic_tendon.errors import MeasurementError
from elastic_tendon.identify.initial_state import estimate_initial_state
from recorded_machines import FRICTION

TORQUE = "effects.coulomb_friction.torque"


@pytest.fixture(scope="module")
def found(sticking):
    known, recording, heldout = sticking
    return diagnose(known.model, [recording], [heldout])


def test_hidden_friction_is_named_with_its_size(found) -> None:
    assert found.verdict == "missing_effect"
    assert found.added == ("coulomb_friction",)
    torque = next(one for one in found.findings.estimates if one.path == TORQUE)
    assert torque.determined
    assert torque.interval[0] <= FRICTION <= torque.interval[1]


def test_the_error_falls_to_the_noise_on_both_recordings(found) -> None:
    first, last = found.ladder[0], found.ladder[-1]
    assert last.noise_ratio["joint_position"] < 1.1
    assert last.heldout_rmse["joint_position"] < 0.1 * first.heldout_rmse["joint_position"]
    assert not found.remaining["joint_position"].significant


def test_the_evidence_is_complete(found) -> None:
    best = found.rounds[0].candidates[0]
    assert best.id == found.rounds[0].chosen == "coulomb_friction"
    assert best.p_value < 0.01
    assert best.gain > 0.5
    assert best.heldout_gain > 0.5
    assert TORQUE in best.expected
    assert sum(one.probability for one in found.rounds[0].candidates) <= 1.0 + 1e-9
    assert found.rounds[-1].chosen is None


def test_the_same_call_gives_the_same_answer(found, sticking) -> None:
    known, recording, heldout = sticking
    again = diagnose(known.model, [recording], [heldout])
    assert json.dumps(diagnosis_json(again)) == json.dumps(diagnosis_json(found))


def test_wrong_numbers_are_no_missing_effect(frictionless) -> None:
    known, recording = frictionless
    found = diagnose(known.model, [recording])
    assert found.verdict == "wrong_parameter"
    assert found.added == ()
    assert "link.inertia" in found.parameters_changed


def test_the_true_numbers_are_adequate(frictionless) -> None:
    known, recording = frictionless
    found = diagnose(known.model.with_values(known.truth), [recording])
    assert (found.verdict, found.added, found.parameters_changed) == ("adequate", (), ())


def test_one_step_at_a_time(sticking) -> None:
    known, recording, _ = sticking
    seen = []
    found = diagnose(known.model, [recording], ask=lambda one: bool(seen.append(one)))
    assert [one.chosen for one in seen] == ["coulomb_friction"]
    assert len(found.rounds) == 1


def test_an_interrupt_keeps_what_was_found(sticking) -> None:
    known, recording, _ = sticking
    rounds = []

    def interrupting(text: str, share: float) -> None:
        if text.startswith("screening") and share == 0.0:
            rounds.append(text)
            if len(rounds) == 2:
                raise KeyboardInterrupt

    found = diagnose(known.model, [recording], report=interrupting)
    assert found.interrupted
    assert found.added == ("coulomb_friction",)


def test_fitted_samples_cannot_judge(sticking) -> None:
    known, recording, _ = sticking
    with pytest.raises(MeasurementError, match="shares samples"):
        diagnose(known.model, [recording], [replace(recording, name="again")])


def test_the_answer_starts_where_the_recording_does(found, sticking) -> None:
    _, recording, _ = sticking
    state = estimate_initial_state(found.model, recording)
    assert found.comparison.files[0].initial_state.position == pytest.approx(
        state.position, abs=1e-3
    )
