"""The app in a real browser: what a user can do there, and what strangers' text cannot."""

import json
import time
from collections.abc import Iterator
from dataclasses import replace
from io import BytesIO
from pathlib import Path
from threading import Thread

import pandas as pd
import pytest
from asammdf import MDF, Signal

pytest.importorskip("playwright")
pytest.importorskip("dash")

from playwright.sync_api import Route

from app_driver import CHROMIUM, KEPT, Walk
from app_process import served
from benchmark_app import MODEL, Watched, walk_through, write_recording
from benchmarking import print_table
from elastic_tendon.actuator.parameters import load_model
from elastic_tendon.app.document import Source, new_document
from elastic_tendon.app.server import listen
from elastic_tendon.app.sliders import STILL
from elastic_tendon.comparison.compare import compare as compare_with
from elastic_tendon.demo import DATA
from elastic_tendon.diagnosis import by_hand
from elastic_tendon.measurement import read_measurement
from elastic_tendon.progress import Enough
from elastic_tendon.reports.first_screen import UNFINISHED
from elastic_tendon.reports.units import number
from hand_made_diagnosis import friction_found

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


@pytest.fixture
def walk(chromium, demo) -> Iterator[Walk]:
    tab = Walk(chromium, demo)
    yield tab
    tab.close()
    assert tab.faults == []


@pytest.fixture(scope="module")
def shared(chromium, demo) -> Iterator[Walk]:
    """One tab for tests that leave the user's choices as they were: opening one takes long."""
    tab = Walk(chromium, demo)
    yield tab
    tab.close()


@pytest.fixture
def compare(shared: Walk) -> Iterator[Walk]:
    """The step Compare, with the whole of the recording that is fitted."""
    shared.step("Compare")
    shared.settle()
    shared.choose("Recording", "demo_fit.csv")
    shared.button("Reset zoom").click()
    shared.settle()
    assert seen(shared)[1] == ""
    yield shared
    assert shared.faults == []


def upload(walk: Walk, **files: bytes) -> None:
    """Add files on the page; their names may be anything."""
    payload = [
        {"name": name, "mimeType": "text/csv", "buffer": content} for name, content in files.items()
    ]
    walk.page.locator("#data-upload input[type=file]").set_input_files(payload)


def as_mdf(recording: pd.DataFrame) -> bytes:
    """A recording as a file of MDF 4."""
    time, file = recording.pop("time_s").to_numpy(), BytesIO()
    with MDF(version="4.10") as written:
        for name, values in recording.items():
            written.append(Signal(values.to_numpy(), time, name=str(name)))
        written.save(file)
    return file.getvalue()


def test_cancel_answers_at_once_and_keeps_what_was_refitted(walk: Walk) -> None:
    walk.step("Which effect")
    walk.settle()
    (before,) = walk.document()["versions"]
    walk.page.evaluate(CANCEL_THE_SEARCH)
    walk.button("Find which effect is missing").click()
    walk.page.wait_for_function("() => window.cancelled")
    walk.page.locator("#work").wait_for(state="hidden")
    walk.button("Find which effect is missing").wait_for()
    # what was let go does not keep other work from beginning
    walk.step("Take away")
    walk.build("Write the model")
    given, *refitted = walk.document()["versions"]
    assert given == before
    assert [one["title"] for one in refitted] in ([], ["parameters refitted"])
    assert not any(one["searched"] for one in refitted)


def test_the_page_is_there_before_what_draws_its_figures(chromium, demo) -> None:
    page = chromium.new_page()
    held: list[Route] = []
    page.route("**/plotly.min.js", lambda route: held.append(route))
    page.goto(demo)
    page.locator("#model-numbers input").first.wait_for()
    page.wait_for_function("() => document.querySelector('script[src$=\"plotly.min.js\"]')")
    assert page.locator("#model-figure .main-svg").count() == 0
    while not held:
        page.wait_for_timeout(50)
    held[0].continue_()
    page.locator("#model-figure .main-svg").first.wait_for()
    page.close()


def test_what_is_known_of_a_search_can_be_looked_at_and_taken(chromium, monkeypatch) -> None:
    """A search that goes on until somebody has enough of it."""
    first = friction_found().rounds[0]
    alone = tuple(candidate for candidate in first.candidates if len(candidate.ids) == 1)

    def endless(data, _current, progress, so_far=None):
        search = by_hand.Search.of(data, progress)
        found = by_hand.Outcome(replace(first, candidates=alone), search, complete=False)
        so_far(by_hand.Ranked(found.round, {}, complete=False))
        try:
            while True:
                progress("refitting what may do better", 0.5)
                time.sleep(0.05)
        except Enough:
            return found

    monkeypatch.setattr(by_hand, "next_round", endless)
    files = {role: DATA / f"demo_{role}.csv" for role in ("fit", "validate")}
    sources = (Source(key="fit", name="fit.csv"),)
    app = listen(new_document(load_model(DATA / "demo_model.toml"), sources), files)
    Thread(target=app.run, daemon=True).start()
    try:
        walk = Walk(chromium, app.url)
        walk.step("Which effect")
        walk.settle()
        assert walk.page.locator("#take-best").is_hidden()
        walk.button("Find which effect is missing").click()
        walk.page.get_by_text("Judged so far").wait_for()
        said = walk.page.get_by_role("status").filter(has_text="refitting what may do better")
        said.wait_for()
        assert said.get_attribute("aria-live") == "polite"
        assert (
            walk.page.get_by_role("progressbar", name="Work done").get_attribute("value") == "0.500"
        )
        screen, listed = (walk.page.locator(place) for place in ("#effect-screen", "#effect-list"))
        interim, rows = screen.inner_text().splitlines()[0], listed.get_by_role("row")
        assert interim.startswith("Coulomb friction")
        assert UNFINISHED in screen.inner_text()
        assert "The joint position error falls from" in screen.inner_text()
        judged = rows.all_inner_texts()
        walk.step("Add").get_by_role("heading", name="Error after each step").wait_for()
        assert walk.versions() == ["as given", "parameters refitted"]
        assert walk.page.locator("#work").is_visible()  # the search goes on
        walk.step("Which effect")
        walk.page.get_by_text("Judged so far").wait_for()
        walk.button("Take the best so far").click()
        walk.page.get_by_text("The search was ended early").wait_for()
        walk.settle()
        assert screen.inner_text().splitlines()[0] == interim
        assert UNFINISHED in screen.inner_text()
        assert rows.all_inner_texts() == judged
        assert walk.page.get_by_text("Judged so far").count() == 0
        walk.button("Search to the end").wait_for()
        walk.close()
        assert walk.faults == []
    finally:
        app.close()


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
    walk.page.get_by_text("1 recording is fitted").wait_for()
    walk.step("Compare").get_by_role("rowheader", name="all", exact=True).wait_for()
    left_out = walk.page.locator("#left-out").inner_text()
    for name in ("rubbish.csv", "wrong.csv"):
        assert f"{name} is left out: " in left_out
    walk.step("Data")
    walk.settle()
    for _ in range(2):
        walk.page.get_by_role("button", name="Remove").last.click()
        walk.settle()
    assert walk.page.locator("#left-out").inner_text() == ""
    assert [source["name"] for source in walk.document()["sources"]] == [
        "demo_fit.csv",
        "demo_validate.csv",
    ]


def test_names_of_files_are_never_markup(walk: Walk) -> None:
    rude = "<img src=x onerror=alert(1)><b>bold.mf4"
    walk.page.on("dialog", lambda dialog: walk.faults.append(dialog.message) or dialog.dismiss())
    walk.step("Data")
    recording = pd.read_csv(DATA / "demo_fit.csv", nrows=1000)
    upload(walk, **{rude: as_mdf(recording)})
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


def test_the_browser_goes_back_to_the_step_before(shared: Walk) -> None:
    shared.step("Model")
    shared.button("Next: Data").click()
    shared.button("Next: Compare").click()
    shared.heading("Compare").wait_for()
    for way, title in ((shared.page.go_back, "Data"), (shared.page.go_back, "Model")):
        way()
        shared.heading(title).wait_for()
    shared.page.go_forward()
    shared.heading("Data").wait_for()
    shared.page.reload()
    shared.heading("Data").wait_for()
    assert shared.heading("Data").is_visible()
    assert shared.faults == []


def test_a_page_that_hears_nothing_says_so_and_goes_on(shared: Walk) -> None:
    """As after the computer slept."""
    shared.step("Data")
    shared.settle()
    before, context = shared.document(), shared.page.context
    context.set_offline(True)
    shared.page.get_by_role("alert").filter(has_text="The server does not answer").wait_for()
    with shared.page.expect_navigation():
        context.set_offline(False)
    shared.heading("Data").wait_for()
    shared.settle()
    assert shared.document() == before
    assert shared.page.inner_text("#lost") == ""
    assert all("ERR_INTERNET_DISCONNECTED" in fault for fault in shared.faults)
    shared.faults.clear()


# share of the dots of Compare's loop that are faint
FAINT_DOTS = """() => {
  const drawn = document.querySelector("#compare-loop .js-plotly-plot")._fullData;
  const all = drawn.flatMap(one => one.mode === "markers" ? Array.from(one.marker.opacity) : []);
  return all.filter(one => one < 1).length / all.length;
}"""
# how many elements are moved by a style of the page
MOVED = """() => Array.from(document.querySelectorAll("*")).filter(one =>
  ["", "::before", "::after"].some(part => {
    const look = getComputedStyle(one, part);
    return look.animationName !== "none" || !/^0s(, 0s)*$/.test(look.transitionDuration);
  })).length"""
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
    walk.choose("Recording", "demo_validate.csv (held out)")
    walk.settle()
    type_in(walk, "#compare-from", "5")
    type_in(walk, "#compare-a", "6.5")
    assert seen(walk) == ["demo_validate.csv (held out)", "5", "6.5"]
    return seen(walk)


def test_what_is_looked_at_survives_a_reload(compare: Walk) -> None:
    before = look(compare)
    compare.page.reload()
    compare.heading("Compare").wait_for()
    compare.settle()
    assert seen(compare) == before


def test_a_tolerance_is_told_drawn_and_kept(compare: Walk) -> None:
    words = compare.page.locator("#compare-tolerance-words")
    drawn = compare.page.locator("#compare-overlay").get_by_text("tolerance ± 500 mrad")
    type_in(compare, "#compare-tolerance", "500")
    drawn.wait_for()
    assert "keeps the tolerance of 500 mrad" in words.inner_text()
    compare.page.reload()
    drawn.wait_for()
    compare.settle()
    assert compare.page.input_value("#compare-tolerance") == "500"
    type_in(compare, "#compare-tolerance", "0.01")
    assert "exceeds the tolerance of 0.0100 mrad in" in words.inner_text()
    type_in(compare, "#compare-tolerance", "")
    assert words.inner_text() == ""
    assert drawn.count() == 0
    assert compare.faults == []


def test_errors_are_told_where_conditions_hold_and_kept(compare: Walk) -> None:
    words = compare.page.locator("#compare-filters-words")
    samples = compare.page.locator("#compare-errors tbody td").first
    whole = int(samples.inner_text())
    compare.choose("Only slack state", "III, both taut")
    compare.choose("Only a range of", "time (s)")
    type_in(compare, "#compare-low", "2")
    type_in(compare, "#compare-high", "5")
    told = words.inner_text()
    assert told.startswith("Only where slack_state=III and time=2..5: ")
    assert 0.0 < compare.page.evaluate(FAINT_DOTS) < 1.0
    assert 0 < int(samples.inner_text()) < whole
    compare.page.reload()
    compare.heading("Compare").wait_for()
    compare.settle()
    assert words.inner_text() == told
    type_in(compare, "#compare-high", "1")
    fault = compare.page.locator("#compare-filters-fault")
    assert "a range goes from its lower end to its upper end. All samples" in fault.inner_text()
    assert int(samples.inner_text()) == whole
    for field in ("Only slack state", "Only a range of"):
        compare.choose(field, "all samples")
        compare.settle()
    for field in ("#compare-low", "#compare-high"):
        type_in(compare, field, "")
    assert words.inner_text() == fault.inner_text() == ""
    assert compare.faults == []


def move(walk: Walk, presses: int) -> float:
    """Move the slider of the inertia by the keyboard; what it stands at then, kg·m²."""
    slider = walk.page.get_by_role("slider", name="inertia")
    for _ in range(presses):
        slider.press("ArrowRight")
    slider.blur()  # the hand rests
    walk.settle()
    return float(slider.locator("xpath=../preceding-sibling::span").inner_text().split()[0])


def test_sliders_redraw_the_simulation_until_they_are_taken(compare: Walk) -> None:
    before = compare.document()
    words = compare.page.locator("#compare-moved-words")
    drawn = compare.page.locator("#compare-overlay").get_by_text("with the sliders: RMS")
    compare.page.get_by_text("Move parameters").click()
    inertia = move(compare, 9)
    model = load_model(DATA / "demo_model.toml").with_values({"link.inertia": inertia})
    error = (
        compare_with(model, read_measurement(str(DATA / "demo_fit.csv")))
        .files[0]
        .signals["joint_position"]
        .rmse
    )
    told = words.inner_text()
    assert f"{number(1e3 * error)} mrad with the sliders" in told
    curves = compare.page.locator("#compare-overlay")
    curves.get_by_text(f"with the sliders: RMS {number(1e3 * error)} mrad").wait_for()
    compare.page.get_by_role("rowheader", name="with the sliders, all").wait_for()
    assert compare.document() == before
    compare.page.reload()
    drawn.wait_for()
    compare.settle()
    assert words.inner_text() == told
    compare.button("Back to the model's values").click()
    compare.settle()
    assert drawn.count() == 0
    assert words.inner_text() == STILL
    inertia = move(compare, 3)
    compare.button("Take these values into the model").click()
    compare.settle()
    assert words.inner_text() == STILL
    assert compare.page.evaluate("document.activeElement.id") == "compare-take"
    assert f"inertia = {inertia}\n" in compare.document()["versions"][0]["model"]
    compare.step("Model")
    compare.button("Take edits back").click()
    compare.settle()
    assert compare.document() == before


def test_curves_follow_a_slider_while_it_moves(compare: Walk) -> None:
    """Before the page's callbacks know of it, which draw the same once the hand rests."""
    compare.page.locator("#compare-move").evaluate("part => { part.open = true; }")
    move(compare, 1)  # the callbacks draw its curves first
    curves = compare.page.locator("#compare-overlay").get_by_text("with the sliders: RMS")
    slider = compare.page.get_by_role("slider", name="inertia")
    value = slider.locator("xpath=../preceding-sibling::span")
    label, number_before = curves.text_content(), value.inner_text()
    stored = compare.page.evaluate("sessionStorage.getItem('compare-moved')")
    with compare.page.expect_response("**/moved") as told:
        slider.press("ArrowRight")
    assert told.value.status == 200
    assert value.inner_text() != number_before
    found = told.value.json()
    compare.page.locator("#compare-overlay").get_by_text(found["curves"][0]["name"]).wait_for()
    assert curves.text_content() != label
    slider.blur()
    compare.settle()
    assert curves.text_content() == found["curves"][0]["name"]
    assert compare.page.evaluate("sessionStorage.getItem('compare-moved')") != stored
    compare.button("Back to the model's values").click()
    compare.settle()
    assert curves.count() == 0
    assert compare.faults == []


def test_edits_are_taken_back_though_fields_answer_late(shared: Walk) -> None:
    """Fields that come tell what they show; that is no edit, however late it is heard."""
    shared.step("Model")
    shared.settle()
    before, inertia = shared.document(), shared.page.get_by_label("Link: inertia")
    inertia.fill("0.031")
    shared.page.keyboard.press("Tab")
    shared.settle()
    assert shared.document() != before
    held: list[Route] = []

    def hold(route: Route) -> None:
        late = "model-note" in route.request.post_data_json["output"]
        held.append(route) if late else route.continue_()

    shared.page.route(CALLS, hold)
    shared.page.reload()
    with shared.page.expect_response(lambda one: '"model-back"' in (one.request.post_data or "")):
        shared.button("Take edits back").click()
    while not held:
        shared.page.wait_for_timeout(50)
    while held:
        held.pop(0).continue_()
    shared.page.unroute(CALLS)
    shared.settle()
    assert shared.document() == before
    assert inertia.input_value() == "0.03"
    assert shared.faults == []


def test_nothing_moves_by_itself_for_those_who_ask_for_that(compare: Walk) -> None:
    compare.page.locator("#compare-recording").click()
    compare.page.get_by_role("option").first.wait_for()
    compare.page.emulate_media(reduced_motion="no-preference")
    moved = compare.page.evaluate(MOVED)
    compare.page.emulate_media(reduced_motion="reduce")
    assert moved > 0
    assert compare.page.evaluate(MOVED) == 0
    compare.page.keyboard.press("Escape")


def test_the_residual_is_tested_where_the_model_fails(compare: Walk) -> None:
    part = compare.step("Where").locator("#where-residual-part")
    compare.settle()
    part.get_by_role("rowheader", name="the motor velocity").wait_for()
    assert part.get_by_text("with the motor velocity").count() == 1
    assert part.get_by_role("rowheader").first.inner_text() == "itself"
    assert "What is left of the joint position is not white" in compare.page.inner_text(
        "#where-sentences"
    )


@pytest.mark.parametrize("late", ["**/async-graph*", CALLS])
def test_a_zoom_survives_a_reload_whatever_comes_last(compare: Walk, late: str) -> None:
    """Figures come after the last answer of the server, or all answers come late."""
    before = look(compare)
    held: list[Route] = []
    compare.page.route(late, lambda route: held.append(route))
    with compare.page.expect_request(late):
        compare.page.reload(wait_until="commit")
    if late != CALLS:
        compare.heading("Compare").wait_for()
        compare.settle()
    while held:
        held.pop().continue_()
    compare.page.unroute(late)
    compare.page.locator("#compare-overlay .main-svg").first.wait_for()
    compare.settle()
    assert seen(compare) == before
    # Where shows the recording that is fitted; its figure speaks last
    compare.page.evaluate(RESIZE, "where-overlay")
    compare.settle()
    assert seen(compare) == before


def test_a_choice_counts_though_news_come_before_its_answer(compare: Walk) -> None:
    held: list[Route] = []
    compare.page.route(CALLS, lambda route: held.append(route))
    with compare.page.expect_request(CALLS):
        compare.choose("Recording", "demo_validate.csv (held out)")
    with compare.page.expect_request(CALLS):
        compare.page.evaluate(NEWS)
    while held:
        held.pop().continue_()
    compare.page.unroute(CALLS)
    compare.settle()
    assert seen(compare)[0] == "demo_validate.csv (held out)"


def test_news_are_asked_of_the_open_step_alone(compare: Walk) -> None:
    asked: list[str] = []
    compare.page.on("request", lambda one: asked.append(one.post_data or ""))
    with compare.page.expect_request(CALLS):
        compare.page.evaluate(NEWS)
    compare.settle()
    outputs = [json.loads(body)["output"].lstrip(".") for body in asked if '"output"' in body]
    assert any(output.startswith("compare-overlay.") for output in outputs)
    hidden = ("model-", "data-", "effect-", "add-", "take_away-")
    assert not [output for output in outputs if output.startswith(hidden)]


def ends(walk: Walk) -> list[str]:
    """Ends of the zoom that Compare shows."""
    return [walk.page.input_value(field) for field in ("#compare-from", "#compare-to")]


def test_a_table_and_a_number_of_it_are_copied_with_all_digits(compare: Walk) -> None:
    compare.page.context.grant_permissions(["clipboard-read", "clipboard-write"])
    frame = compare.page.locator("#compare-errors .table")
    frame.get_by_role("button", name="Copy this table").click()
    frame.get_by_text("Copied", exact=True).wait_for()
    copied = compare.page.evaluate("navigator.clipboard.readText()")
    rows = [line.split("\t") for line in copied.splitlines()]
    shown = frame.locator("tr").evaluate_all("all => all.map(row => row.cells.length)")
    assert [len(row) for row in rows] == shown
    assert rows[0][2] == "RMS (mrad)"
    assert rows[1][0] == frame.locator("tbody tr").first.locator("th").first.inner_text()
    rmse = frame.locator("tbody tr").first.locator("td").nth(1)
    assert len(rows[1][2]) > len(rmse.inner_text())
    assert number(float(rows[1][2])) == rmse.inner_text()
    rmse.dblclick()
    compare.page.keyboard.press("Control+c")
    assert compare.page.evaluate("navigator.clipboard.readText()") == rows[1][2]


def test_a_figure_is_saved_from_where_it_is(compare: Walk, tmp_path: Path) -> None:
    figure = compare.page.locator(".saveable").filter(has=compare.page.locator("#compare-overlay"))
    figure.locator(".main-svg").first.wait_for()
    for kind, begins in (("PNG", b"\x89PNG"), ("SVG", b"<svg"), ("CSV", b"measured")):
        button = figure.get_by_role("button", name=f"Save this figure as {kind}")
        saved = compare.save(button, tmp_path)
        assert saved.name == f"curves.{kind.lower()}"
        assert saved.read_bytes().startswith(begins)
    numbers = pd.read_csv(saved)
    assert numbers.columns[:2].tolist() == ["measured: time (s)", "measured: joint position (rad)"]
    drawn = numbers[numbers.columns[:2]].dropna()
    assert drawn.iloc[:, 0].is_monotonic_increasing
    assert len(drawn) > 200
    assert 0.1 < drawn.iloc[:, 1].std() < 1.0
    assert compare.faults == []


def test_a_zoom_stays_within_the_recording(compare: Walk) -> None:
    for low, high, shown in (
        ("4", "", ["4", "9.998"]),
        ("-1", "5", ["0", "5"]),
        ("7", "6", ["", ""]),
        ("12", "14", ["", ""]),
        ("-2", "11", ["", ""]),
        ("2.0004", "3", ["2", "3"]),
    ):
        compare.button("Reset zoom").click()
        compare.settle()
        type_in(compare, "#compare-from", low)
        if high:
            type_in(compare, "#compare-to", high)
        assert ends(compare) == shown


def test_a_number_may_be_typed_again_after_it_was_undone(compare: Walk) -> None:
    for _ in range(3):
        type_in(compare, "#compare-from", "4")
        assert ends(compare) == ["4", "9.998"]
        compare.button("Reset zoom").click()
        compare.settle()
        assert ends(compare) == ["", ""]


def test_a_double_click_undoes_every_zoom(compare: Walk) -> None:
    for text in ("3", "4"):
        type_in(compare, "#compare-from", text)
        assert ends(compare) == [text, "9.998"]
        compare.page.locator("#compare-overlay .nsewdrag").first.dblclick()
        compare.settle()
        assert ends(compare) == ["", ""]


def test_a_mark_out_of_sight_undoes_the_zoom(compare: Walk) -> None:
    type_in(compare, "#compare-to", "1.5")
    compare.step("Where")
    compare.settle()
    compare.button("Show the samples of time 1 to 2 s").click()
    compare.settle()
    assert ends(compare) == ["0", "1.5"]
    assert not compare.page.get_by_text("The zoom was reset").is_visible()
    # buttons made anew would forget a click that is not yet answered
    compare.page.evaluate("document.querySelector('#where-bins button').kept = true")
    compare.page.evaluate(NEWS)
    compare.settle()
    assert compare.page.evaluate("document.querySelector('#where-bins button').kept")
    compare.button("Show the samples of time 2 to 3 s").click()
    compare.page.get_by_text("The zoom was reset").wait_for()
    compare.settle()
    assert ends(compare) == ["", ""]
