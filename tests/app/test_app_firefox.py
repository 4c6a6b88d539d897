"""The app in Firefox: a short walk, for all else is tried in Chromium."""

from pathlib import Path

import pytest

pytest.importorskip("dash")

from firefox import FIREFOX, Firefox, firefox

pytestmark = pytest.mark.skipif(FIREFOX is None, reason="Firefox is not installed")

STEPS = ("Model", "Data", "Compare", "Where", "Which effect", "Add", "Take away")
FIGURES = {
    "Model": ("model-figure",),
    "Data": (),
    "Compare": ("compare-overlay", "compare-loop"),
    "Where": ("where-overlay", "where-shares", "where-maps", "where-torque", "where-residual"),
    "Which effect": (),
}
BEYOND = "return document.documentElement.scrollWidth - window.innerWidth"
OPEN = "document.querySelector('section:not([hidden]) h2')?.innerText === arguments[0]"


def step(browser: Firefox, title: str) -> None:
    """Open a step as a user does, and wait until it is shown."""
    browser.click("nav button", str(1 + STEPS.index(title)))
    browser.until(OPEN, title)


def test_a_walk_in_firefox(demo: str, tmp_path: Path) -> None:
    with firefox(tmp_path) as browser:
        browser.open(demo)
        browser.until("document.getElementById('where-we-are')?.innerText")
        for title, figures in FIGURES.items():
            step(browser, title)
            for figure in figures:
                browser.until("document.querySelector(arguments[0])", f"#{figure} .main-svg")
            assert browser.run(BEYOND) <= 0
        browser.until("document.querySelector('#effect-screen')?.innerText.includes('Next: ')")
        step(browser, "Take away")
        browser.click("button", "Write the model")
        browser.until("document.querySelector('a.button[href]')")
        assert browser.run("return window.faults") == []
        assert browser.run("return document.getElementById('lost').innerText") == ""
