"""The app in a real browser: what a user can do there, and what strangers' text cannot."""

import json
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from fmpy import simulate_fmu

pytest.importorskip("playwright")
pytest.importorskip("dash")

from playwright.sync_api import Route

from app_driver import CHROMIUM, KEPT, Walk, browser
from app_process import served
from benchmark_app import MODEL, Watched, walk_through, write_recording
from benchmarking import print_table
from elastic_tendon.demo import DATA

# of the FMU, and what they are called in the recording
COLUMNS = {
    "time": "time_s",
    "motor_position": "motor_position_rad",
    "load_torque": "load_torque_Nm",
}

# presses Cancel as soon as the page tells of the search: on a busy machine the search
# may be over, and other work shown, before a click from outside arrives
CANCEL_THE_SEARCH = """() => {
  const words = document.getElementById("work-words");
  const observer = new MutationObserver(() => {
    if (/finding|refitting|reading the motion|screening/.test(words.textContent)) {
      observer.disconnect();
      document.getElementById("cancel").click();
      window.cancelled = true;
    }
  });
  observer.observe(words, {childList: true, characterData: true, subtree: true});
}"""

pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="chromium is not installed")


@pytest.fixture(scope="module")
def demo() -> Iterator[str]:
    with served("--demo") as url:
        yield url


@pytest.fixture(scope="module")
def chromium() -> Iterator[object]:
    with browser() as started:
        yield started


@pytest.fixture
def walk(chromium, demo) -> Iterator[Walk]:
    tab = Walk(chromium, demo)
    yield tab
    tab.close()
    assert tab.faults == []


def upload(walk: Walk, **files: bytes) -> None:
    """Add files on the page; their names may be anything."""
    payload = [
        {"name": name, "mimeType": "text/csv", "buffer": content} for name, content in files.items()
    ]
    walk.page.locator("#data-upload input[type=file]").set_input_files(payload)


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


def test_from_a_hidden_effect_to_the_fmu_that_has_it(walk: Walk, tmp_path: Path) -> None:
    walk.step("Take away")
    given = walk.save(walk.build("Build the FMU"), tmp_path)
    error = follows(given)
    walk.search()
    assert walk.versions() == ["as given", "parameters refitted"]
    reload(walk, "Which effect")
    walk.add()
    assert walk.versions()[2:] == ["+ Coulomb friction"]
    reload(walk, "Add")
    walk.step("Take away")
    walk.page.get_by_text("as given → parameters refitted → + Coulomb friction").wait_for()
    improved = walk.save(walk.build("Build the FMU"), tmp_path)
    assert follows(improved) < 0.1 * error
    findings = json.loads(walk.save(walk.build("Write the findings"), tmp_path).read_text())
    assert findings["added"] == ["coulomb_friction"]
    errors = [step["rmse"]["joint_position"] for step in findings["ladder"]]
    assert errors == sorted(errors, reverse=True)
    report = walk.save(walk.build("Write the report"), tmp_path)
    assert "Coulomb friction" in report.read_text()


def test_cancel_answers_at_once_and_changes_nothing(chromium) -> None:
    # a server of its own: what another test has searched is found at once
    with served("--demo") as url:
        walk = Walk(chromium, url)
        walk.step("Which effect")
        walk.settle()
        before = walk.document()
        walk.page.evaluate(CANCEL_THE_SEARCH)
        walk.button("Find which effect is missing").click()
        walk.page.wait_for_function("() => window.cancelled")
        walk.page.locator("#work").wait_for(state="hidden")
        walk.button("Find which effect is missing").wait_for()
        # what was let go does not keep other work from beginning
        walk.step("Take away")
        walk.build("Write the model")
        assert walk.document() == before
        walk.close()
    assert walk.faults == []


def test_a_bad_file_is_told_in_its_place_and_costs_nothing_else(walk: Walk) -> None:
    walk.step("Data")
    rubbish = bytes(range(256)) * 40
    upload(walk, **{"rubbish.csv": rubbish, "wrong.csv": b"time_s,colour\n0,1\n1,2\n2,3\n"})
    for name in ("rubbish.csv", "wrong.csv"):
        card = walk.page.locator(".card").filter(has=walk.page.get_by_text(name, exact=True))
        sentence = card.get_by_role("alert").filter(has_text=name)
        sentence.wait_for()
        assert "Traceback" not in sentence.inner_text()
    walk.settle()
    good = walk.page.locator(".card").filter(has=walk.page.get_by_text("demo_fit.csv", exact=True))
    assert "5000 samples" in good.inner_text()
    assert len(walk.document()["sources"]) == 4
    for _ in range(2):
        walk.page.get_by_role("button", name="Remove").last.click()
        walk.settle()
    walk.page.get_by_text("1 recording is fitted").wait_for()
    assert [source["name"] for source in walk.document()["sources"]] == [
        "demo_fit.csv",
        "demo_validate.csv",
    ]


def test_names_of_files_are_never_markup(walk: Walk) -> None:
    rude = "<img src=x onerror=alert(1)><b>bold.csv"
    walk.page.on("dialog", lambda dialog: walk.faults.append(dialog.message) or dialog.dismiss())
    walk.step("Data")
    upload(walk, **{rude: (DATA / "demo_fit.csv").read_bytes()})
    walk.page.get_by_text(rude, exact=True).first.wait_for()
    walk.page.get_by_text("2 recordings are fitted").wait_for()
    for step in ("Compare", "Where"):
        walk.step(step)
        walk.settle()
        walk.choose("Recording", rude)
        walk.settle()
        assert walk.page.locator(".js-plotly-plot").count() > 0
        assert walk.page.locator("img[src=x], main b").count() == 0


@pytest.mark.slow
def test_a_million_samples(chromium, tmp_path: Path) -> None:
    """How long each click takes is printed and not judged; see build_scripts/benchmark_app.py."""
    recording = tmp_path / "recording.csv"
    write_recording(recording, 1_000_000)
    with served(MODEL, recording) as url:
        tab = Walk(chromium, url)
        seen = Watched(tab)
        walk_through(seen)
        tab.close()
    print_table("10⁶ samples, from click to figure", seen.rows)
    assert len(seen.rows) > 10
    assert tab.faults == []


def test_the_browser_goes_back_to_the_step_before(walk: Walk) -> None:
    walk.button("Next: Data").click()
    walk.button("Next: Compare").click()
    walk.heading("Compare").wait_for()
    for way, title in ((walk.page.go_back, "Data"), (walk.page.go_back, "Model")):
        way()
        walk.heading(title).wait_for()
    walk.page.go_forward()
    walk.heading("Data").wait_for()
    walk.page.reload()
    walk.heading("Data").wait_for()
    assert walk.heading("Data").is_visible()


SEEN = "#compare-recording, #compare-from, #compare-a"
# what plotly tells where a figure's size has changed
RESIZE = "id => Plotly.relayout(document.querySelector(`#${id} .js-plotly-plot`), {height: 191})"
CALLS = "**/_dash-update-component*"  # what the page asks of the server
NEWS = f"dash_clientside.set_props('session', {{data: JSON.parse({KEPT}).session}})"


def seen(walk: Walk) -> list[str]:
    """Recording, zoom and cursor that Compare shows."""
    return walk.page.locator(SEEN).evaluate_all("all => all.map(one => one.value || one.innerText)")


def type_in(walk: Walk, field: str, text: str) -> None:
    """Type into a field and leave it."""
    walk.page.fill(field, text)
    walk.page.keyboard.press("Tab")
    walk.settle()


def look(walk: Walk) -> list[str]:
    """Look at a stretch of the recording that is held out; what Compare shows then."""
    walk.step("Compare")
    walk.settle()
    walk.choose("Recording", "demo_validate.csv (held out)")
    walk.settle()
    type_in(walk, "#compare-from", "5")
    type_in(walk, "#compare-a", "6.5")
    assert seen(walk) == ["demo_validate.csv (held out)", "5", "6.5"]
    return seen(walk)


def test_what_is_looked_at_survives_a_reload(walk: Walk) -> None:
    before = look(walk)
    walk.page.reload()
    walk.heading("Compare").wait_for()
    walk.settle()
    assert seen(walk) == before


@pytest.mark.parametrize("late", ["**/async-graph*", CALLS])
def test_a_zoom_survives_a_reload_whatever_comes_last(walk: Walk, late: str) -> None:
    """Figures come before the first answer of the server, or after the last one."""
    before = look(walk)
    held: list[Route] = []
    walk.page.route(late, lambda route: held.append(route))
    with walk.page.expect_request(late):
        walk.page.reload(wait_until="commit")
    if late != CALLS:
        walk.heading("Compare").wait_for()
        walk.settle()
    else:
        walk.page.locator("#where-overlay .main-svg").first.wait_for(state="attached")
    while held:
        held.pop().continue_()
    walk.page.unroute(late)
    walk.page.locator("#compare-overlay .main-svg").first.wait_for()
    walk.settle()
    assert seen(walk) == before
    # Where shows the recording that is fitted; its figure speaks last
    walk.page.evaluate(RESIZE, "where-overlay")
    walk.settle()
    assert seen(walk) == before


def test_a_choice_counts_though_news_come_before_its_answer(walk: Walk) -> None:
    walk.step("Compare")
    walk.settle()
    held: list[Route] = []
    walk.page.route(CALLS, lambda route: held.append(route))
    with walk.page.expect_request(CALLS):
        walk.choose("Recording", "demo_validate.csv (held out)")
    with walk.page.expect_request(CALLS):
        walk.page.evaluate(NEWS)
    while held:
        held.pop().continue_()
    walk.page.unroute(CALLS)
    walk.settle()
    assert seen(walk)[0] == "demo_validate.csv (held out)"


def ends(walk: Walk) -> list[str]:
    """Ends of the zoom that Compare shows."""
    return [walk.page.input_value(field) for field in ("#compare-from", "#compare-to")]


def test_a_zoom_stays_within_the_recording(walk: Walk) -> None:
    walk.step("Compare")
    walk.settle()
    for low, high, shown in (
        ("4", "", ["4", "9.998"]),
        ("-1", "5", ["0", "5"]),
        ("7", "6", ["", ""]),
        ("12", "14", ["", ""]),
        ("-2", "11", ["", ""]),
        ("2.0004", "3", ["2", "3"]),
    ):
        walk.button("Reset zoom").click()
        type_in(walk, "#compare-from", low)
        if high:
            type_in(walk, "#compare-to", high)
        assert ends(walk) == shown


def test_a_double_click_undoes_every_zoom(walk: Walk) -> None:
    walk.step("Compare")
    walk.settle()
    for text in ("3", "4"):
        type_in(walk, "#compare-from", text)
        assert ends(walk) == [text, "9.998"]
        walk.page.locator("#compare-overlay .nsewdrag").first.dblclick()
        walk.settle()
        assert ends(walk) == ["", ""]


def test_a_mark_out_of_sight_undoes_the_zoom(walk: Walk) -> None:
    walk.step("Compare")
    walk.settle()
    type_in(walk, "#compare-to", "1.5")
    walk.step("Where")
    walk.settle()
    walk.button("Show the samples of time 1 to 2 s").click()
    walk.settle()
    assert ends(walk) == ["0", "1.5"]
    assert not walk.page.get_by_text("The zoom was reset").is_visible()
    walk.button("Show the samples of time 2 to 3 s").click()
    walk.page.get_by_text("The zoom was reset").wait_for()
    walk.settle()
    assert ends(walk) == ["", ""]
