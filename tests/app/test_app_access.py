"""Every step for everybody: WCAG 2.2 AA as axe-core measures it, narrow windows, the dark."""

from pathlib import Path

import pytest

pytest.importorskip("playwright")
pytest.importorskip("dash")
pytest.importorskip("axe_playwright_python")

from playwright.sync_api import ViewportSize

from accessibility import BEYOND, LEVEL_AA, violations
from app_driver import CHROMIUM, SIZE, Walk, browser
from app_process import served
from screenshots import walked

PHONE: ViewportSize = {"width": 390, "height": 844}
OTHERS: tuple[ViewportSize, ...] = (
    {"width": 1024, "height": 768},
    {"width": 640, "height": 400},  # 1280 x 800, enlarged to 200 %
)
EVERY = ("model", "data", "compare", "where", "which_effect", "add", "take_away")
SOME = EVERY[1::2]  # looking takes long

pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="chromium is not installed")


def faults_of(walk: Walk) -> list[str]:
    """What is wrong with the step that is open: in one theme, then in the other and ever narrower.

    The other theme stays, as drawing all figures anew takes long: the next step begins with it.
    """
    contrast = {"type": "rule", "values": ["color-contrast"]}
    found = [f"in a wide window, {fault}" for fault in violations(walk.page, contrast)]
    walk.page.locator("#switch-theme").click()
    walk.settle()
    for size in (*OTHERS, PHONE):
        walk.page.set_viewport_size(size)
        walk.settle()
        if (beyond := walk.page.evaluate(BEYOND)) > 0:
            found.append(f"{beyond} pixels beyond a window of {size['width']}")
    level = {"type": "tag", "values": LEVEL_AA}
    found += [f"on a phone, {fault}" for fault in violations(walk.page, level)]
    walk.page.set_viewport_size(SIZE)
    walk.settle()
    return found


@pytest.mark.parametrize(
    "steps",
    [pytest.param(SOME, id="some"), pytest.param(EVERY, id="every", marks=pytest.mark.slow)],
)
def test_steps_can_be_read_and_reached_by_everybody(steps: tuple[str, ...], tmp_path: Path) -> None:
    with served("--demo") as url, browser() as chromium:
        walk = Walk(chromium, url)
        found = {name: faults_of(walk) for name in walked(walk, tmp_path) if name in steps}
        walk.close()
        (report,) = tmp_path.iterdir()
        page = chromium.new_page(viewport=SIZE)
        page.goto(report.as_uri())
        found["report"] = violations(page, {"type": "tag", "values": LEVEL_AA})
    assert set(found) == {*steps, "report"}
    assert {name: faults for name, faults in found.items() if faults} == {}
