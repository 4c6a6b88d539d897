"""An effect that is there and too small to matter is told in a note, and changes no verdict."""

import pytest

from elastic_tendon.diagnosis.diagnose import diagnose
from elastic_tendon.diagnosis.options import Options
from elastic_tendon.diagnosis.result import Diagnosis
from smooth_motion import GIVEN, played

COULOMB, GUIDES, DRAG = "coulomb_friction", "tendon_guide_friction", "quadratic_drag"
NOISE = 1e-3  # rad


def found(torque: float) -> Diagnosis:
    truth = GIVEN.with_effect(COULOMB, {"torque": torque}) if torque else GIVEN
    recording = played(truth).recording(NOISE)
    return diagnose(GIVEN, [recording], options=Options(only=(COULOMB, GUIDES, DRAG)))


@pytest.mark.parametrize("torque", [0.0, 0.006])
def test_it_is_told_with_what_cannot_be_told_from_it(torque) -> None:
    diagnosis = found(torque)
    assert diagnosis.verdict == "adequate"
    assert diagnosis.added == ()
    told = [note for note in diagnosis.notes if note.startswith("There, but too small to matter:")]
    if not torque:
        assert told == []
        assert diagnosis.indistinguishable == ()
        return
    assert "Coulomb friction" in told[0]
    assert "Tendon guide friction" in told[0]
    assert "Quadratic drag" not in told[0]
    assert "too small to matter" in diagnosis.sentence
    assert [set(alike) for alike in diagnosis.indistinguishable] == [{COULOMB, GUIDES}]
