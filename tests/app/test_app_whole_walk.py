"""The whole walk: it leads to the FMU with what was hidden, and to a report for everybody."""

import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from fmpy import simulate_fmu

pytest.importorskip("playwright")
pytest.importorskip("dash")
pytest.importorskip("axe_playwright_python")

from playwright.sync_api import Browser

from accessibility import LEVEL_AA, violations
from app_driver import CHROMIUM, SIZE, Walk
from elastic_tendon.demo import DATA

# of the FMU, and what they are called in the recording
COLUMNS = {
    "time": "time_s",
    "motor_position": "motor_position_rad",
    "load_torque": "load_torque_Nm",
}

pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="chromium is not installed")


def follows(fmu: Path) -> float:
    """RMS error of an FMU that is driven by the demo's recording, rad."""
    recording = pd.read_csv(DATA / "demo_fit.csv")
    inputs = np.zeros(len(recording), dtype=[(name, float) for name in COLUMNS])
    for name, column in COLUMNS.items():
        inputs[name] = recording[column]
    motion = simulate_fmu(
        str(fmu),
        fmi_type="ModelExchange",  # whose inputs fmpy interpolates
        stop_time=float(inputs["time"][-1]),
        output_interval=float(inputs["time"][1]),
        input=inputs,
        output=["joint_position"],
    )
    at = np.interp(inputs["time"], motion["time"], motion["joint_position"])
    return float(np.sqrt(np.mean((at - recording["joint_position_rad"]) ** 2)))


def reload(walk: Walk, step: str) -> None:
    """Reload the page; the same step is open, and nothing was lost."""
    before = walk.document()
    walk.page.reload()
    walk.heading(step).wait_for()
    walk.settle()
    assert walk.document() == before


@dataclass(frozen=True)
class Walked:
    """A tab at the end of the walk, and what was there on the way.

    `versions` : after the search, and after its suggestion was added. `errors` : of the FMUs of the
    model as given and as improved, rad.
    """

    walk: Walk
    versions: tuple[list[str], list[str]]
    errors: tuple[float, float]
    findings: dict[str, Any]
    report: Path


@pytest.fixture(scope="module")
def end(chromium: Browser, demo: str, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Walked]:
    walk, folder = Walk(chromium, demo), tmp_path_factory.mktemp("walk")
    walk.step("Take away")
    given = walk.save(walk.build("Build the FMU"), folder)
    error = follows(given)
    walk.search()
    searched = walk.versions()
    reload(walk, "Which effect")
    walk.add()
    added = walk.versions()
    reload(walk, "Add")
    walk.step("Take away")
    walk.page.get_by_text("as given → parameters refitted → + Coulomb friction").wait_for()
    improved = walk.save(walk.build("Build the FMU"), folder)
    findings = json.loads(walk.save(walk.build("Write the findings"), folder).read_text())
    report = walk.save(walk.build("Write the report"), folder)
    yield Walked(walk, (searched, added), (error, follows(improved)), findings, report)
    walk.close()


def test_from_a_hidden_effect_to_the_fmu_that_has_it(end: Walked) -> None:
    searched, added = end.versions
    assert searched == ["as given", "parameters refitted"]
    assert added[2:] == ["+ Coulomb friction"]
    given, improved = end.errors
    assert improved < 0.1 * given
    assert end.findings["added"] == ["coulomb_friction"]
    errors = [step["rmse"]["joint_position"] for step in end.findings["ladder"]]
    assert errors == sorted(errors, reverse=True)
    assert end.findings["sentence"] in end.report.read_text()
    assert end.walk.faults == []


def test_the_report_can_be_read_and_reached_by_everybody(chromium: Browser, end: Walked) -> None:
    page = chromium.new_page(viewport=SIZE)
    page.goto(end.report.as_uri())
    found = violations(page, LEVEL_AA)
    page.close()
    assert found == []
