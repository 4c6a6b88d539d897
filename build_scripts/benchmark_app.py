"""How fast the app answers when it looks at a long recording, in a real browser.

    python build_scripts/benchmark_app.py [--rows N]

Writes a recording of N rows (10⁶ unless said otherwise) of a machine that differs a little from
its model, opens the app with it in headless Chromium, and prints the time from each click, key or
end of a drag, as the browser stamps it, until the last figure that follows from it is drawn. Clicks
while the missing torque is computed show whether long work keeps the page from answering; the last
row is how long a model that runs in a page by itself takes to follow a slider. The targets are
those of issue 25, for 10⁷ rows and less on two idle cores. Needs playwright and chromium.
"""

import argparse
import re
import statistics
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
from playwright.sync_api import Browser, Locator

# what drives the browser belongs to the tests and is not installed
sys.path.append(str(Path(__file__).resolve().parents[1] / "tests"))

from app_driver import PATIENCE, Walk, browser
from app_process import served
from benchmarking import Row, at_most, print_table
from elastic_tendon.actuator.parameters import load_model
from elastic_tendon.actuator.variables import interface
from elastic_tendon.fmu.documentation import documentation
from elastic_tendon.fmu.live import fmu_panel
from elastic_tendon.native.layout import layout
from elastic_tendon.simulation.simulate import simulate

MODEL = "biorob_x4_joint_3"
STEP = 1e-3  # s
NOISE = 2e-4  # rad
TONES = ((0.5, 0.3), (0.11, 0.7), (0.05, 2.9))  # rad and Hz
ANSWER, LOAD = 500.0, 1500.0  # ms, in which every interaction is answered; until the page is there
FRAME = 16.7  # ms, of 60 a second
FOLLOWS, SHORT = 50.0, 12_000  # ms, in which curves follow a slider beside so many rows: 12 s
MOVES = 20  # of a slider
FIRST, CURVES = "reading, and the first curves", 5.0  # s
# tells when the user did something, and when each figure was drawn last, and how many requests wait
# for an answer
WATCH = """() => {
  window.watched = {drawn: {}, first: {}, waiting: 0, began: Infinity};
  for (const kind of ["pointerup", "keydown"]) {
    window.addEventListener(kind, told => {
      window.watched.began = told.timeStamp;
      window.watched.first = {};
    }, true);
  }
  const ask = window.fetch;
  window.fetch = (...all) => {
    window.watched.waiting += 1;
    return ask(...all).finally(() => { window.watched.waiting -= 1; });
  };
}"""
LISTEN = """() => {
  for (const one of document.querySelectorAll(".js-plotly-plot")) {
    if (one.watched) continue;
    one.watched = true;
    one.on("plotly_afterplot", () => {
      window.watched.drawn[one.parentElement.id] = performance.now();
      window.watched.first[one.parentElement.id] ??= performance.now();
    });
  }
}"""
TOOK = """graphs => Math.max(...graphs.map(one => window.watched.drawn[one] ?? 0))
  - window.watched.began"""
FIRST_DRAWN = "graph => window.watched.first[graph] - window.watched.began"
QUIET = 1500  # ms without a figure drawn, after which no other is expected
SETTLED = f"""graphs => {{
  const last = Math.max(...Object.values(window.watched.drawn));
  const quiet = window.watched.waiting === 0 && performance.now() - last > {QUIET};
  return quiet && ({TOOK})(graphs) > 0;
}}"""


def write_recording(path: Path, rows: int) -> None:
    """A machine whose inertia and damping are not the model's: time, motor and joint position."""
    model = load_model(MODEL)
    wrong = {"link.inertia": 1.2 * model.link.inertia, "link.damping": 1.5 * model.link.damping}
    t = STEP * np.arange(rows)
    motor = np.sum([size * np.sin(2.0 * np.pi * rate * t) for size, rate in TONES], axis=0)
    joint = simulate(model.with_values(wrong), t, motor)["joint_position"]
    joint = joint + NOISE * np.random.default_rng(7).standard_normal(rows)
    with path.open("w", encoding="utf-8") as file:
        file.write("time_s,motor_position_rad,joint_position_rad\n")
        np.savetxt(file, np.column_stack([t, motor, joint]), fmt="%.6f", delimiter=",")


class RefusedError(Exception):
    """The page says that it cannot show a recording."""


class Watched:
    """A tab of the browser whose answers are timed; figures of `rows` in the order of clicks."""

    def __init__(self, walk: Walk) -> None:
        self.walk, self.page = walk, walk.page
        self.rows: list[Row] = []
        self.page.evaluate(WATCH)

    def time(self, what: str, act: Callable[[], object], *graphs: str) -> None:
        """Do something, and note when the last of the figures that follow from it was drawn."""
        self.page.evaluate(LISTEN)
        self.page.evaluate("() => { window.watched.began = Infinity; }")
        act()
        self.page.wait_for_function(SETTLED, arg=list(graphs), timeout=PATIENCE)
        took = float(self.page.evaluate(TOOK, list(graphs)))
        self.rows.append(at_most(what, took, ANSWER, "ms"))

    def note(self, what: str, act: Callable[[], object], limit: float | None = None) -> None:
        """Do something that may take long, and note how long it took, s."""
        begin = time.perf_counter()
        act()
        took = time.perf_counter() - begin
        self.rows.append(
            Row(what, f"{took:.2f} s") if limit is None else at_most(what, took, limit, "s")
        )

    def at(self, graph: str, across: float, up: float) -> tuple[float, float]:
        """A place in the first panel of a figure, from shares of its width and height."""
        panel = self.page.locator(f"#{graph} .nsewdrag").first
        panel.scroll_into_view_if_needed()
        box = panel.bounding_box()
        assert box is not None
        return box["x"] + across * box["width"], box["y"] + up * box["height"]

    def drag(self, graph: str, low: float, high: float) -> None:
        """Zoom into a stretch of the axis."""
        mouse, first, last = self.page.mouse, self.at(graph, low, 0.5), self.at(graph, high, 0.5)
        mouse.move(*first)
        mouse.down()
        mouse.move(*last, steps=3)
        mouse.up()

    def shown(self, graph: str) -> None:
        """Wait until a figure has curves.

        Raises
        ------
        RefusedError : the page says why it never will
        """
        curves = f"#{graph} .scatterlayer .trace, #{graph} .heatmaplayer image"
        fault = self.page.locator("section.step:visible > .sentence:not(:empty)")
        self.page.locator(curves).or_(fault).first.wait_for(timeout=PATIENCE)
        if told := fault.all_inner_texts():
            raise RefusedError(told[0])


def walk_through(seen: Watched) -> None:
    """Compare, before and after the missing torque is known, then Where."""
    click, page = seen.page.mouse.click, seen.page
    compare = partial(_open, seen, "Compare", "compare-overlay")
    seen.note(FIRST, compare, CURVES)
    place = seen.at("compare-overlay", 0.3, 0.5)
    both, curves = ("compare-overlay", "compare-loop"), "where-overlay"
    seen.time("a cursor, beside work under way", lambda: click(*place), "compare-overlay")
    seen.shown("compare-loop")
    seen.walk.settle()
    seen.time("a cursor", lambda: click(*place), "compare-overlay")
    seen.time("zoom in, by half", lambda: seen.drag("compare-overlay", 0.25, 0.75), *both)
    seen.time("zoom in, to a fiftieth", lambda: seen.drag("compare-overlay", 0.5, 0.52), *both)
    seen.time("zoom out", lambda: seen.page.locator("#compare-reset").click(), *both)
    page.get_by_text("Move parameters").click()
    slider = page.get_by_role("slider", name="inertia")
    seen.time("a slider, the first time", lambda: slider.press("ArrowRight"), "compare-overlay")
    seen.rows.append(at_most("a slider", following(seen, slider), ANSWER, "ms"))
    seen.time("back from it", page.locator("#compare-back").click, "compare-overlay")
    seen.note("Where, for the first time", lambda: _open(seen, "Where", "where-maps"))
    page.wait_for_timeout(QUIET)
    seen.time("a bin of the table", page.get_by_role("button", name="Show").first.click, curves)
    cell = seen.at("where-maps", 0.5, 0.5)
    seen.time("a cell of a map", lambda: click(*cell), curves)
    seen.time("back to Compare", lambda: seen.walk.step("Compare"), *both)
    seen.time("on to Where", lambda: seen.walk.step("Where"), curves, "where-torque")


def following(seen: Watched, slider: Locator) -> float:
    """How long curves take to follow a slider that was moved before, ms, median of some moves."""
    took = []
    for _ in range(MOVES):
        slider.press("ArrowRight")
        seen.page.wait_for_function(f"graph => ({FIRST_DRAWN})(graph) > 0", arg="compare-overlay")
        took.append(float(seen.page.evaluate(FIRST_DRAWN, "compare-overlay")))
        seen.page.wait_for_timeout(QUIET)
    return statistics.median(took)


def short(started: Browser, folder: Path) -> Row:
    """How long curves take to follow a slider beside a recording of a usual length."""
    path = folder / "short.csv"
    write_recording(path, SHORT)
    with served(MODEL, path) as url:
        seen = Watched(Walk(started, url))
        _open(seen, "Compare", "compare-overlay")
        seen.page.get_by_text("Move parameters").click()
        slider = seen.page.get_by_role("slider", name="inertia")
        seen.time("a slider, the first time", lambda: slider.press("ArrowRight"), "compare-overlay")
        took = following(seen, slider)
    return at_most(f"app, {SHORT:.0e} rows: a slider", took, FOLLOWS, "ms")


def _open(seen: Watched, step: str, graph: str) -> None:
    seen.walk.step(step)
    seen.shown(graph)


def frame(started: Browser, folder: Path) -> Row:
    """The model in the page of an FMU: it is simulated and drawn anew for each move of a slider."""
    model, path = load_model(MODEL), folder / "index.html"
    variables = layout(interface(*model.structure), model.values())
    pages = documentation(model, variables, 2, panel=fmu_panel(model))
    path.write_bytes(pages["documentation/index.html"])
    page, took = started.new_page(), []
    page.goto(path.as_uri())
    told = page.locator(".live-numbers", has_text="Computed in")
    told.wait_for()
    for _ in range(MOVES):
        page.get_by_role("slider", name="pretension force").press("ArrowRight")
        page.wait_for_timeout(100)
        took.append(sum(map(float, re.findall(r"in ([\d.]+) ms", told.inner_text()))))
    page.close()
    return at_most("a frame of the model that runs in a page", statistics.median(took), FRAME, "ms")


def main() -> int:
    """Print the table; exit status."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--rows", type=int, default=1_000_000, help="of the recording (10⁶)")
    rows: int = parser.parse_args().rows
    with tempfile.TemporaryDirectory() as work:
        path = Path(work) / "recording.csv"
        write_recording(path, rows)
        with served(MODEL, path) as url, browser() as started:
            begin = time.perf_counter()
            walk = Walk(started, url)
            loaded = time.perf_counter() - begin
            seen = Watched(walk)
            try:
                walk_through(seen)
            except RefusedError as fault:
                print(fault)
                seen.rows.append(Row(FIRST, "refused", f"≤ {CURVES:g} s", met=False))
            load = at_most("the page itself", 1e3 * loaded, LOAD, "ms")
            title = f"The app beside {rows} rows, from click to figure"
            named = [
                replace(row, what=f"app, {rows:.0e} rows: {row.what}") for row in [load, *seen.rows]
            ]
            others = [short(started, Path(work)), frame(started, Path(work))]
            status = print_table(title, [*named, *others])
            print("\n".join(walk.faults))
    return status


if __name__ == "__main__":
    sys.exit(main())
