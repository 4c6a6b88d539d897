"""The panel in which the model of a report runs: what it shows is what Python computes."""

import re
from functools import cache
from html import unescape
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("playwright")
pytest.importorskip("axe_playwright_python")

from app_driver import CHROMIUM
from elastic_tendon import demo, simulate
from elastic_tendon.actuator.parameters import Model, load_model
from elastic_tendon.comparison.compare import compare
from elastic_tendon.comparison.comparison import Comparison
from elastic_tendon.estimation.determinability import Estimate
from elastic_tendon.measurement import read_measurement
from elastic_tendon.progress import silent
from elastic_tendon.reports.html.blocks import Section
from elastic_tendon.reports.html.live import SAMPLES, live, live_recording
from elastic_tendon.reports.html.page import page
from live_panel import opened

TORQUE = "effects.coulomb_friction.torque"
LARGEST = 400_000  # bytes that a panel may add

pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="chromium is not installed")


@cache
def compared() -> Comparison:
    model = load_model(demo.DATA / "demo_model.toml").with_effect(
        "coulomb_friction", {"torque": 0.3}
    )
    return compare(model, read_measurement(str(demo.DATA / "demo_fit.csv")))


def rms_in_panel(model: Model) -> float:
    """Of the samples that a panel shows, mrad."""
    recording = live_recording(compared().model, compared().files[0])
    trajectory = simulate(
        model,
        recording.time,
        **recording.inputs,
        initial_state=recording.start,
        interpolation=recording.interpolation,
        as_measured=True,
    )
    error = trajectory["joint_position"] - recording.measured["joint_position"]
    return 1e3 * float(np.sqrt(np.mean(error**2)))


def shown(numbers: str) -> float:
    found = re.search(r"RMS error of the joint position ([\d.]+) mrad", numbers)
    assert found is not None, numbers
    return float(found[1])


@cache
def written(alive: bool = True) -> str:
    found = compared()
    estimate = Estimate(TORQUE, "N.m", 0.0, 0.3, 0.05, (0.2, 0.9), determined=True)
    blocks = tuple(live(found.model, found.files, [estimate], silent))
    return page("Test", "of the panel", [Section("live", "Try the model", blocks[: 1 + alive])])


@pytest.fixture
def report(tmp_path: Path) -> Path:
    path = tmp_path / "report.html"
    path.write_text(written(), encoding="utf-8")
    return path


def test_the_error_follows_a_slider_and_comes_back(report: Path) -> None:
    model = compared().model
    with opened(report) as panel:
        panel.wait()
        begun = panel.numbers
        assert shown(begun) == pytest.approx(rms_in_panel(model), rel=5e-3)
        panel.press("torque", "Home")
        assert panel.slider("torque").get_attribute("aria-valuetext") == "0 N·m"
        without = rms_in_panel(model.with_values({TORQUE: 0.0}))
        assert shown(panel.numbers) == pytest.approx(without, rel=5e-3)
        assert without > 1.5 * shown(begun)
        panel.press("torque", "End")
        assert panel.slider("torque").get_attribute("aria-valuetext") == "0.9 N·m"
        panel.page.get_by_role("button", name="Reset all").click()
        panel.settle()
        assert panel.numbers == begun
        assert panel.faults == []


def test_the_samples_of_a_panel_err_as_the_recording_does() -> None:
    file = compared().files[0]
    recording = live_recording(compared().model, file)
    assert len(recording.time) <= SAMPLES < len(file.measurement.time)
    whole = 1e3 * file.signals["joint_position"].rmse
    assert rms_in_panel(compared().model) == pytest.approx(whole, rel=0.05)


def test_a_step_takes_the_place_of_the_recording(report: Path) -> None:
    with opened(report) as panel:
        panel.wait()
        panel.page.get_by_label("a step of the motor position").check()
        panel.settle()
        assert "RMS" not in panel.numbers
        before = panel.numbers
        panel.press("step of the motor position", "End")
        assert panel.numbers != before
        assert panel.faults == []


def test_the_policy_allows_webassembly_and_its_own_scripts_alone() -> None:
    (policy,) = re.findall(r'Content-Security-Policy" content="([^"]*)"', unescape(written()))
    (scripts,) = (part for part in policy.split("; ") if part.startswith("script-src"))
    _, *allowed = scripts.split()
    assert allowed[-1] == "'wasm-unsafe-eval'"
    assert all(one.startswith("'sha256-") for one in allowed[:-1])
    assert policy.startswith("default-src 'none'")


def test_a_panel_adds_little() -> None:
    assert 20_000 < len(written()) - len(written(alive=False)) < LARGEST


def test_without_webassembly_a_sentence_takes_its_place(report: Path) -> None:
    with opened(report, webassembly=False) as panel:
        panel.page.get_by_text("WebAssembly, one of which is switched off").wait_for()
        assert panel.page.locator(".live").is_hidden()
        assert panel.page.get_by_role("slider").count() == 0


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_everybody_can_read_and_reach_it(report: Path, theme: str) -> None:
    with opened(report, theme=theme) as panel:
        panel.wait()
        assert panel.shortcomings() == []


def test_on_paper_there_are_curves_and_no_sliders(report: Path) -> None:
    with opened(report, theme="dark") as panel:
        panel.wait()
        panel.page.emulate_media(media="print")
        assert panel.page.locator(".live canvas").is_visible()
        assert panel.page.get_by_role("slider").count() == 0
