"""Pictures of the app and of the report, for whoever wants to look at all of them.

    python build_scripts/screenshots.py FOLDER [--readme]

Walks the app on the demo's data in headless Chromium, and writes pictures into FOLDER, light and
dark: of each step from top to bottom in windows of four sizes, of what the usual window shows, of
the top of the report and of the model that runs in it. Says where a step is wider than its window.
With --readme, the pictures that examples/app/README.md shows are replaced too. Needs playwright and
chromium.
"""

import argparse
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

from PIL import Image

# what drives the browser belongs to the tests and is not installed
sys.path.append(str(Path(__file__).resolve().parents[1] / "tests"))

from playwright.sync_api import Browser, Page, ViewportSize

from accessibility import BEYOND
from app_driver import SIZE, Theme, Walk, browser
from app_process import served

ROOT = Path(__file__).resolve().parents[1]
THEMES: tuple[Theme, ...] = ("light", "dark")
SIZES: dict[str, ViewportSize] = {
    "usual": SIZE,
    "small": {"width": 1024, "height": 768},
    "phone": {"width": 390, "height": 844},
    "enlarged": {"width": SIZE["width"] // 2, "height": SIZE["height"] // 2},  # to 200 %
}
README = ("compare", "where", "which_effect", "add", "live")  # in the light
COLOURS = 256  # of its pictures, which have a third of the bytes then and look the same
WEAKENED = 60  # places by which the slider of the friction is moved, so that an error shows


def walked(walk: Walk, folder: Path) -> Iterator[str]:
    """Walk from the model to the report, which is kept in a folder; names of what can be seen."""
    walk.step("Model")
    walk.settle()
    yield "model"
    walk.step("Data")
    walk.settle()
    yield "data"
    walk.step("Compare")
    walk.page.get_by_text("Move parameters").click()
    walk.settle()
    walk.page.locator("#compare-overlay").evaluate("curves => curves.scrollIntoView()")
    yield "compare"
    walk.step("Where")
    walk.settle()
    walk.page.get_by_role("button", name="Show").first.click()
    walk.settle()
    yield "where"
    walk.search()
    walk.page.get_by_role("button", name="Try ").click()
    walk.settle()
    yield "which_effect"
    walk.add()
    walk.page.locator("#add-columns").scroll_into_view_if_needed()
    yield "add"
    walk.step("Take away")
    walk.save(walk.build("Write the report"), folder)
    yield "take_away"


def take_live(page: Page, path: Path) -> None:
    """Of the model that runs in an open report, with less friction than was found."""
    page.locator(".live-numbers", has_text="Computed in").wait_for()
    friction = page.get_by_role("slider", name="torque")
    for _ in range(WEAKENED):
        friction.press("ArrowLeft")
    page.wait_for_timeout(1000)
    page.locator("section", has=page.locator("#live")).screenshot(path=path)


def take_sizes(walk: Walk, path: Path) -> None:
    """Of the open step from top to bottom in every size, which the file's name ends with."""
    for size, window in SIZES.items():
        walk.page.set_viewport_size(window)
        walk.settle()
        walk.page.screenshot(path=path.with_stem(f"{path.stem}_{size}"), full_page=True)
        if (beyond := walk.page.evaluate(BEYOND)) > 0:
            print(f"{path.stem}: {beyond} pixels beyond a window of {window['width']}")
    walk.page.set_viewport_size(SIZE)
    walk.settle()


def write_pictures(started: Browser, url: str, folder: Path) -> None:
    """Of every step, in both themes; then of the top of the report, and of what runs in it."""
    for theme in THEMES:
        walk = Walk(started, url, theme)
        with tempfile.TemporaryDirectory() as work:
            for name in walked(walk, Path(work)):
                walk.picture(folder / f"{name}_{theme}.png")
                take_sizes(walk, folder / f"{name}_{theme}.png")
            (report,) = Path(work).iterdir()
            page = started.new_page(viewport=SIZE, color_scheme=theme)
            page.goto(report.as_uri())
            page.wait_for_load_state("networkidle")
            page.screenshot(path=folder / f"report_{theme}.png")
            take_live(page, folder / f"live_{theme}.png")
            page.close()
        walk.close()
        print("\n".join(walk.faults) or f"{theme}: nothing was wrong beneath the page")


def main() -> int:
    """Write the pictures."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("folder", type=Path, help="for the pictures; made where it is absent")
    parser.add_argument("--readme", action="store_true", help="replace those of the README too")
    given = parser.parse_args()
    given.folder.mkdir(parents=True, exist_ok=True)
    with served("--demo") as url, browser() as started:
        write_pictures(started, url, given.folder)
    if given.readme:
        for name in README:
            picture = Image.open(given.folder / f"{name}_light.png").convert("RGB")
            shown = ROOT / "examples" / "app" / f"{name}.png"
            few = picture.quantize(
                COLOURS, Image.Quantize.MAXCOVERAGE
            )  # rare ones stay as they are
            few.save(shown, optimize=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
