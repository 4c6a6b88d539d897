"""The bundled demonstration is what its script makes, and fit for what it demonstrates."""

import tomllib
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import regenerating

ROOT = Path(__file__).resolve().parents[2]
DATA = ROOT / "fmu_src" / "elastic_tendon" / "demo"
MEASUREMENTS = ("demo_fit.csv", "demo_validate.csv")
LARGEST_FILE = 300_000  # bytes, so that the package stays small

# Another scipy or processor moves a position by some 1e-11 rad. Only where that crosses the edge of
# an encoder count (2 pi / 2^14) does the shown value move, and then by one count; that is less than
# one sample in a million. All other numbers agree to the last digit written.
ONE_COUNT = 3.9e-4  # rad
LAST_DIGIT = 1.1e-6  # rad
SHARE_OF_MOVED_COUNTS = 5e-4


@pytest.fixture(scope="module")
def regenerated(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return regenerating.regenerated("make_demo_data.py", tmp_path_factory.mktemp("demo"))


def test_the_script_writes_just_the_bundled_files(regenerated: Path) -> None:
    written = {file.name for file in regenerated.iterdir()}
    assert written == {"demo_model.toml", *MEASUREMENTS}
    model = (regenerated / "demo_model.toml").read_text(encoding="utf-8")
    assert model == (DATA / "demo_model.toml").read_text(encoding="utf-8")


@pytest.mark.parametrize("file", MEASUREMENTS)
def test_regenerated_measurements_are_the_bundled_ones(regenerated: Path, file: str) -> None:
    bundled, fresh = pd.read_csv(DATA / file), pd.read_csv(regenerated / file)
    assert list(fresh.columns) == list(bundled.columns)
    assert len(fresh) == len(bundled)
    difference = (fresh - bundled).abs().to_numpy()
    assert np.max(difference) < ONE_COUNT
    assert np.mean(difference > LAST_DIGIT) < SHARE_OF_MOVED_COUNTS


@pytest.mark.parametrize("file", MEASUREMENTS)
def test_measurements_are_rich_and_inside_what_the_springs_bear(file: str) -> None:
    assert (DATA / file).stat().st_size < LARGEST_FILE
    table = pd.read_csv(DATA / file)
    assert list(table.columns) == [
        "time_s",
        "motor_position_rad",
        "joint_position_rad",
        "load_torque_Nm",
    ]
    believed = tomllib.loads((DATA / "demo_model.toml").read_text(encoding="utf-8"))
    assert "effects" not in believed
    transmission = believed["transmission"]
    spring, radius = transmission["upper_spring"], transmission["joint_pulley_radius"]
    prestretched = transmission["pretension_force"] / (spring["stiffness"] * spring["parallel"])
    slack_boundary = prestretched / radius  # (14)
    largest = (spring["max_deflection"] - prestretched) / radius  # (16)
    deflection = table["joint_position_rad"] - table["motor_position_rad"]
    for side in (deflection, -deflection):
        assert np.max(side) < largest
        assert np.mean(side > slack_boundary) > 0.02
    assert np.max(np.abs(table["load_torque_Nm"])) > 1.0
