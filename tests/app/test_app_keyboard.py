"""The whole walk without a mouse: from the model to the report, by Tab, Enter and arrows."""

from pathlib import Path

import pytest

pytest.importorskip("playwright")
pytest.importorskip("dash")

from app_driver import CHROMIUM, Walk, browser
from app_process import served

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(CHROMIUM is None, reason="chromium is not installed"),
]

MOST = 150  # presses of Tab within which everything of a step is reached
# what a reader of the screen would call the element that has the focus, and whether it can be seen
FOCUSED = """() => {
  const one = document.activeElement;
  const box = one.getBoundingClientRect();
  const own = one.getAttribute("aria-label");
  const by = (one.getAttribute("aria-labelledby") || "").split(" ").map(
    id => (document.getElementById(id) || {}).innerText || "").join(" ").trim();
  const label = one.labels && one.labels.length ? one.labels[0].innerText : "";
  const around = one.closest("label") ? one.closest("label").innerText : "";
  const text = one.matches("button, a, summary") ? one.innerText : "";
  return {
    name: [own, by, label, text, around].filter(Boolean).join(" | "),
    seen: box.width > 0 && box.height > 0 && box.bottom > 0 && box.top < window.innerHeight,
    marked: [one, one.parentElement].some(part => {
      const look = getComputedStyle(part);
      return look.outlineStyle !== "none" && parseFloat(look.outlineWidth) >= 2;
    }),
  };
}"""


class Keys:
    """A walk on which nothing is clicked."""

    def __init__(self, walk: Walk) -> None:
        self.walk = walk
        self.page = walk.page

    def to(self, name: str) -> None:
        """Press Tab until something has the focus that is called so."""
        passed = []
        for _ in range(MOST):
            self.page.keyboard.press("Tab")
            now = self.page.evaluate(FOCUSED)
            if name in now["name"]:
                assert now["seen"], f"{name} has the focus out of sight"
                assert now["marked"], f"nothing shows that {name} has the focus"
                return
            passed.append(now["name"][:40])
        raise AssertionError(f"Tab never reaches {name}, only {passed}")

    def press(self, name: str) -> None:
        """Go to a button or a link, and press it."""
        self.to(name)
        self.page.keyboard.press("Enter")

    def on(self, title: str) -> None:
        """Go on to the next step."""
        self.press(f"Next: {title}")
        self.walk.heading(title).wait_for()
        self.walk.settle()
        focused = self.page.evaluate("document.activeElement.innerText")
        assert focused == title, "the focus is not at the head of the new step"


def test_the_whole_walk_by_keyboard(tmp_path: Path) -> None:
    with served("--demo") as url, browser() as chromium:
        walk = Walk(chromium, url)
        walk.settle()
        keys, page = Keys(walk), walk.page

        keys.to("inertia")
        page.keyboard.press("Control+a")
        page.keyboard.type("0.031")
        page.keyboard.press("Enter")
        page.get_by_text("edited by hand").first.wait_for()
        keys.on("Data")
        page.get_by_text("1 recording is fitted").wait_for()
        keys.on("Compare")
        keys.to("Recording")
        for key, chosen in (("Enter", "fitted 0"), ("ArrowDown", "held out 0")):
            page.keyboard.press(key)  # and the list follows a moment later
            page.locator(f"input[value='{chosen}']:focus").wait_for(state="attached")
        page.keyboard.press("Enter")
        walk.settle()
        page.locator("#compare-recording").get_by_text("demo_validate.csv").wait_for()
        keys.press("Move parameters")
        keys.to("inertia")
        page.keyboard.press("ArrowRight")
        page.get_by_role("rowheader", name="with the sliders, all").wait_for()
        keys.on("Where")
        keys.press("Show the samples of")
        walk.settle()
        keys.on("Which effect")
        keys.press("Find which effect is missing")
        page.get_by_role("rowheader", name="none of them").wait_for()
        walk.settle()
        keys.press("Try Coulomb friction")
        page.get_by_text("tried and not added").wait_for()
        keys.press("Add Coulomb friction")
        walk.heading("Add").wait_for()
        walk.page.get_by_text("Coulomb friction is in the model").wait_for()
        walk.settle()
        keys.on("Take away")
        keys.press("Write the report")
        walk.card("Write the report").get_by_role("link", name="Download").wait_for()
        with page.expect_download() as coming:
            keys.press("Download")
        report = tmp_path / coming.value.suggested_filename
        coming.value.save_as(report)
        walk.close()
    assert "Coulomb friction" in report.read_text()
    assert walk.faults == []
