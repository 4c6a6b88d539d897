"""Every step as full as it gets: everybody can read and reach it, in both themes and on paper.

WCAG 2.2 AA as axe-core measures it, narrow windows, A4.
"""

from collections.abc import Iterator
from typing import Any

import pytest

pytest.importorskip("playwright")
pytest.importorskip("dash")
pytest.importorskip("axe_playwright_python")

from playwright.sync_api import Browser, TimeoutError, ViewportSize

from accessibility import BEYOND, CONTRAST, LEVEL_AA, violations
from app_driver import CHROMIUM, SIZE, Theme, Walk
from elastic_tendon.app.own_effects import template
from elastic_tendon.app.server import Served
from elastic_tendon.app.steps import STEPS
from figure_texts import faults as unread
from screenshots import SIZES
from searched_session import SEARCHED, searched_session, served_session, with_friction

NARROW = ("small", "enlarged", "phone")  # the narrowest last, where all rules are looked at
PAPER: ViewportSize = {"width": 680, "height": 1009}  # what lies between the margins of A4
SOON = 20_000  # ms, in which plotly places a legend anew on a busy machine
BEFORE = ("model", "data", "compare", "where", "effect")  # something is missing
AFTER = ("add", "take_away")  # it was added

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
# what paper would cut, or the end of a page part; what only a hand can use; words in a light ink
ON_PAPER = """height => {
  const shown = selector => [...document.querySelectorAll(selector)].filter(
    one => one.checkVisibility() && one.getBoundingClientRect().width > 1);
  const words = one => one.textContent.trim().slice(0, 40) || one.id || one.className;
  const light = one => { // as WCAG 2 has it
    const [red, green, blue] = getComputedStyle(one).fill.match(/[\\d.]+/g).map(part => {
      const share = part / 255;
      return share <= 0.04045 ? share / 12.92 : ((share + 0.055) / 1.055) ** 2.4;
    });
    return 1.05 / (0.2126 * red + 0.7152 * green + 0.0722 * blue + 0.05) < 4.5;
  };
  const cut = one => getComputedStyle(one).overflowX !== "visible"
    && one.scrollWidth > one.clientWidth + 1;
  return [
    ...shown("section *:not(.unseen, svg, svg *, input)").filter(cut)
      .map(one => `cut: ${words(one)}`),
    ...shown(".saveable").filter(one => one.getBoundingClientRect().height > height)
      .map(one => `longer than a page: ${one.firstChild.id}`),
    ...shown("nav, button:not(.link, .dash-dropdown), section input[type=range], .drop, .modebar")
      .map(one => `of no use on paper: ${words(one)}`),
    ...shown(".main-svg text").filter(light).map(one => `too light: ${words(one)}`),
  ];
}"""
INK = "getComputedStyle(document.querySelector('#compare-overlay .xtick text')).fill"

pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="chromium is not installed")


@pytest.fixture(scope="module")
def app(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    path = tmp_path_factory.mktemp("every") / "night.session"
    with served_session(searched_session(path, with_friction())) as served:
        yield served


def look_at(app: Served, version: str) -> None:
    """Look at a version of the session."""
    app.workspace.open(None).change(lambda document: document.at(version))


def open_full(walk: Walk, name: str) -> None:
    """Open a step, and all in it that can be opened."""
    (title,) = (step.title for step in STEPS if step.id == name)
    step = walk.step(title)
    walk.settle()
    if name == "compare":
        walk.page.get_by_text("Move parameters").click()
        walk.page.get_by_role("slider", name="inertia").press("ArrowRight")
    elif name == "where":
        step.get_by_role("button", name="Show").first.click()
    elif name == "effect":
        walk.page.locator("#effect-experiment-figure .main-svg").first.wait_for()
        walk.page.locator("#effect-evidence .main-svg").first.wait_for()
        walk.page.get_by_text("Write an effect of your own").click()
        walk.page.get_by_label("The effect, in Python").fill(template() + "nothing\n")
        walk.button("Try it").click()
        walk.page.locator("#own-effect-line:not(:empty)").wait_for()
    walk.settle()


def faults_in_windows(walk: Walk) -> list[str]:
    """What is wrong with the open step, in the window as it is and ever narrower."""
    found = [f"in a wide window, {fault}" for fault in violations(walk.page, CONTRAST)]
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
    found += [f"on a phone, {fault}" for fault in violations(walk.page, LEVEL_AA)]
    walk.page.set_viewport_size(SIZE)
    walk.settle()
    return found


def faults_on_paper(walk: Walk) -> list[str]:
    """What is wrong with the open step where it is printed."""
    page = walk.page
    page.set_viewport_size(PAPER)
    page.emulate_media(media="print")
    page.evaluate("window.dispatchEvent(new Event('beforeprint'))")
    found = [*unread(page), *page.evaluate(ON_PAPER, PAPER["height"]), *violations(page, CONTRAST)]
    if (beyond := page.evaluate(BEYOND)) > 0:
        found.append(f"{beyond} pixels beyond the paper")
    page.emulate_media(media="screen")
    page.evaluate("window.dispatchEvent(new Event('afterprint'))")
    page.set_viewport_size(SIZE)
    walk.settle()
    return [f"on paper, {fault}" for fault in found]


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_every_step_can_be_read_and_reached_by_everybody(
    chromium: Browser, app: Served, theme: Theme
) -> None:
    found: dict[str, list[str]] = {}
    for version, names in ((SEARCHED, BEFORE), (with_friction().current, AFTER)):
        look_at(app, version)
        walk = Walk(chromium, app.url, theme)
        for name in names:
            open_full(walk, name)
            found[name] = [*faults_in_windows(walk), *faults_on_paper(walk)]
        walk.close()
        assert walk.faults == []
    assert {name: faults for name, faults in found.items() if faults} == {}
    assert found.keys() == {step.id for step in STEPS}


def test_a_step_is_printed_and_stays_as_it_was(chromium: Browser, app: Served) -> None:
    walk = Walk(chromium, app.url, "dark")
    open_full(walk, "compare")
    listen = "window.addEventListener('beforeprint', () => { window.onpaper = INK; })"
    walk.page.evaluate(listen.replace("INK", INK))
    before = drawn(walk)
    paper = walk.page.pdf(prefer_css_page_size=True)
    assert paper.startswith(b"%PDF")
    assert b"/MediaBox [0 0 594" in paper or b"/MediaBox [0 0 595" in paper  # A4, upright
    assert walk.page.evaluate("window.onpaper") == "rgb(26, 26, 26)"
    walk.settle()
    assert drawn(walk) == before
    walk.close()
    assert walk.faults == []


def drawn(walk: Walk) -> tuple[Any, ...]:
    """Ink and width of the curves."""
    width = "document.querySelector('#compare-overlay .main-svg').clientWidth"
    return walk.page.evaluate(INK), walk.page.evaluate(width)
