"""The whole walk: it leads to the FMU with what was hidden, and everybody can read each step.

WCAG 2.2 AA as axe-core measures it, narrow windows, the dark. In CI both look at one walk.
"""

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

from playwright.sync_api import Browser, TimeoutError

from accessibility import BEYOND, LEVEL_AA, violations
from app_driver import CHROMIUM, SIZE, Walk
from elastic_tendon.demo import DATA
from figure_texts import faults as unread
from screenshots import SIZES, walked

NARROW = ("small", "enlarged", "phone")  # the narrowest last, where all rules are looked at
EVERY = ("model", "data", "compare", "where", "which_effect", "add", "take_away")
SOME = {"data": "Data", "where": "Where", "add": "Add"}  # by title; looking takes long

# whether no legend lies on the panels of its figure; plotly places it anew after a window changed
APART = """() => Array.from(document.querySelectorAll("section:not([hidden]) .js-plotly-plot"))
  .every(plot => {
    const legend = plot.querySelector(".legend .bg");
    const at = legend && legend.getBoundingClientRect();
    return !at || Array.from(plot.querySelectorAll(".nsewdrag")).every(panel => {
      const on = panel.getBoundingClientRect();
      return at.bottom < on.top + 2 || at.top > on.bottom - 2;
    });
  })"""
SOON = 20_000  # ms, in which it does so on a busy machine

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


def faults_of(walk: Walk) -> list[str]:
    """What is wrong with the step that is open: in one theme, then in the other and ever narrower.

    The other theme stays, as drawing all figures anew takes long: the next step begins with it.
    """
    contrast = {"type": "rule", "values": ["color-contrast"]}
    found = [f"in a wide window, {fault}" for fault in violations(walk.page, contrast)]
    walk.page.locator("#switch-theme").click()
    walk.settle()
    for size in (SIZES[name] for name in NARROW):
        walk.page.set_viewport_size(size)
        walk.settle()
        if (beyond := walk.page.evaluate(BEYOND)) > 0:
            found.append(f"{beyond} pixels beyond a window of {size['width']}")
        try:
            walk.page.wait_for_function(APART, timeout=SOON)
        except TimeoutError:
            found.append(f"a legend lies on its figure in a window of {size['width']}")
        found += [f"in a window of {size['width']}, {fault}" for fault in unread(walk.page)]
    level = {"type": "tag", "values": LEVEL_AA}
    found += [f"on a phone, {fault}" for fault in violations(walk.page, level)]
    walk.page.set_viewport_size(SIZE)
    walk.settle()
    return found


def faults_in(walk: Walk, *names: str) -> dict[str, list[str]]:
    """What is wrong with some steps."""
    found = {}
    for name in names:
        step = walk.step(SOME[name])
        walk.settle()
        if name == "where":
            step.get_by_role("button", name="Show").first.click()
            walk.settle()
        found[name] = faults_of(walk)
    return found


@dataclass(frozen=True)
class Walked:
    """A tab at the end of the walk, and what was there on the way.

    `versions` : after the search, and after its suggestion was added. `errors` : of the FMUs of the
    model as given and as improved, rad. `faults` : of some steps, while there was something to see.
    """

    walk: Walk
    versions: tuple[list[str], list[str]]
    errors: tuple[float, float]
    findings: dict[str, Any]
    report: Path
    faults: dict[str, list[str]]


@pytest.fixture(scope="module")
def end(chromium: Browser, demo: str, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Walked]:
    walk, folder = Walk(chromium, demo), tmp_path_factory.mktemp("walk")
    walk.step("Take away")
    given = walk.save(walk.build("Build the FMU"), folder)
    error = follows(given)
    faults = faults_in(walk, "data", "where")
    walk.search()
    searched = walk.versions()
    reload(walk, "Which effect")
    walk.add()
    added = walk.versions()
    reload(walk, "Add")
    faults |= faults_in(walk, "add")
    walk.step("Take away")
    walk.page.get_by_text("as given → parameters refitted → + Coulomb friction").wait_for()
    improved = walk.save(walk.build("Build the FMU"), folder)
    findings = json.loads(walk.save(walk.build("Write the findings"), folder).read_text())
    report = walk.save(walk.build("Write the report"), folder)
    yield Walked(walk, (searched, added), (error, follows(improved)), findings, report, faults)
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


def faults_of_report(chromium: Browser, report: Path) -> list[str]:
    page = chromium.new_page(viewport=SIZE)
    page.goto(report.as_uri())
    found = violations(page, {"type": "tag", "values": LEVEL_AA})
    page.close()
    return found


def test_some_steps_can_be_read_and_reached_by_everybody(chromium: Browser, end: Walked) -> None:
    found = end.faults | {"report": faults_of_report(chromium, end.report)}
    assert found == {name: [] for name in (*SOME, "report")}


@pytest.mark.slow
def test_every_step_can_be_read_and_reached_by_everybody(
    chromium: Browser, demo: str, tmp_path: Path
) -> None:
    walk = Walk(chromium, demo)
    found = {name: faults_of(walk) for name in walked(walk, tmp_path)}
    walk.close()
    (report,) = tmp_path.iterdir()
    found["report"] = faults_of_report(chromium, report)
    assert found == {name: [] for name in (*EVERY, "report")}
