"""The measurements of examples/paper_figures are what their script makes, and fit for it."""

import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import regenerating
from elastic_tendon.actuator.parameters import load_model
from elastic_tendon.comparison.compare import compare
from elastic_tendon.comparison.locate import locate
from elastic_tendon.estimation.fit import fit
from elastic_tendon.measurement import read_measurement

ROOT = Path(__file__).resolve().parents[1]
EXAMPLE = ROOT / "examples" / "paper_figures"
LARGEST_ROWS = 3000
# another processor rounds a position elsewhere; where that crosses an encoder count it shows
ONE_COUNT = 3.9e-4  # rad
SHARE_OF_MOVED_COUNTS = 5e-4
SLACK, ENGAGED = 80.0 / 23160.0 / 0.03, (0.012 - 80.0 / 23160.0) / 0.03  # rad of deflection
STIFFNESS = 0.03**2 * 23160.0  # N·m/rad, of one side


@pytest.fixture(scope="module")
def regenerated(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return regenerating.regenerated("make_paper_data.py", tmp_path_factory.mktemp("paper"))


@pytest.mark.parametrize("name", ["static_curve.csv", "excitation.csv"])
def test_regenerated_measurements_are_those_of_the_example(regenerated: Path, name: str) -> None:
    kept, fresh = pd.read_csv(EXAMPLE / name), pd.read_csv(regenerated / name)
    assert list(fresh.columns) == list(kept.columns)
    assert len(fresh) == len(kept) < LARGEST_ROWS
    difference = (fresh - kept).abs().to_numpy()
    assert np.max(difference) < 1.1 * ONE_COUNT
    assert np.mean(difference > 1e-6) < SHARE_OF_MOVED_COUNTS


def test_measured_corners_deviate_as_in_the_paper() -> None:
    """One slope between the slack boundaries, half of it beyond, and a steeper one at the ends."""
    table = pd.read_csv(EXAMPLE / "static_curve.csv")
    deflection, torque = table["joint_deflection_rad"], table["joint_torque_Nm"]

    def slope(inside: pd.Series) -> float:
        return -float(np.polyfit(deflection[inside], torque[inside], 1)[0])

    assert slope(deflection.abs() < SLACK) == pytest.approx(2.0 * STIFFNESS, rel=0.02)
    for side in (-1.0, 1.0):
        beyond = side * deflection
        assert slope((beyond > SLACK) & (beyond < ENGAGED)) == pytest.approx(STIFFNESS, rel=0.03)
        assert slope(beyond > ENGAGED) == pytest.approx(2.5 * STIFFNESS, rel=0.03)


def test_it_is_told_how_stiff_the_protection_is_and_where_it_begins() -> None:
    recording = read_measurement(str(EXAMPLE / "static_curve.csv"))
    location = locate(compare(load_model("biorob_x4_joint_3"), [recording]))
    words = location.files[0].in_words["joint_position"]
    told = re.search(r"beyond (\S+) and (\S+) rad .* stiffer there .* about (\S+) N·m/rad", words)
    lower, upper, stiffness = map(float, told.groups())
    assert (lower, upper) == pytest.approx((-ENGAGED, ENGAGED), abs=0.01)
    assert stiffness == pytest.approx(1.5 * STIFFNESS, rel=0.05)
    assert "in both directions" in words


def test_a_fitted_protection_takes_the_deviation_away() -> None:
    """What made the corners is found, with its numbers; the torque sensor's noise is left."""
    recording = read_measurement(str(EXAMPLE / "static_curve.csv"))
    given = load_model("biorob_x4_joint_3")
    # begun beside the truth, which spares the many starts of `add`
    started = given.with_effect("overstretch_protection", {"engagement": 0.9, "stiffness": 2e4})
    result = fit(started, [recording])
    before, after = (
        compare(model, [recording]).files[0].signals["joint_position"].rmse
        for model in (given, result.model)
    )
    assert before > 30.0 * after
    found = {one.path: one for one in result.findings.estimates}
    truth = {"engagement": 0.8, "stiffness": 1.5 * 11580.0}
    for name, value in truth.items():
        low, high = found[f"effects.overstretch_protection.{name}"].interval
        assert low < value < high
