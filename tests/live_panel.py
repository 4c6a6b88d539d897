"""Opens a page with a panel in which the model runs, and works its sliders as a user does."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from playwright.sync_api import Locator, Page, sync_playwright

from accessibility import BEYOND, LEVEL_AA, violations
from app_driver import CHROMIUM, SIZE, Theme

WIDTHS = (390, 1024)


class Panel:
    """One page of one browser. `faults` : what it said, and what it asked for beside itself."""

    def __init__(self, page: Page, path: Path) -> None:
        self.page, self.faults = page, list[str]()
        page.on("console", lambda message: self.faults.append(message.text))
        page.on("pageerror", lambda error: self.faults.append(str(error)))
        page.on("request", lambda one: self._ask(one.url, path.as_uri()))
        page.goto(path.as_uri())

    def _ask(self, url: str, own: str) -> None:
        if url != own and not url.startswith("data:"):
            self.faults.append(f"asked for {url}")

    def wait(self) -> None:
        """Wait until the model runs and its curves are drawn."""
        self.page.locator(".live-numbers", has_text="Computed in").wait_for()

    def slider(self, name: str) -> Locator:
        """A slider by its label, which its value follows."""
        return self.page.get_by_role("slider", name=name)

    def press(self, name: str, key: str) -> None:
        """Press a key upon a slider, and wait for the next frame."""
        self.slider(name).press(key)
        self.settle()

    def settle(self) -> None:
        """Wait until what was asked for is drawn."""
        self.page.evaluate("new Promise((done) => setTimeout(() => requestAnimationFrame(done)))")

    @property
    def numbers(self) -> str:
        """The sentences below the curves, without the times that they took."""
        return self.page.locator(".live-numbers").inner_text().partition(" Computed")[0]

    def shortcomings(self) -> list[str]:
        """What somebody cannot read or reach in narrow windows."""
        found = []
        for width in WIDTHS:
            self.page.set_viewport_size({"width": width, "height": 800})
            self.settle()
            if (beyond := self.page.evaluate(BEYOND)) > 0:
                found.append(f"{beyond} pixels beyond a window of {width}")
            found += [f"at {width}, {fault}" for fault in violations(self.page, LEVEL_AA)]
        return found


@contextmanager
def opened(path: Path, *, theme: Theme = "light", webassembly: bool = True) -> Iterator[Panel]:
    """Open a file in a browser, if so wanted in one that has no WebAssembly."""
    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        page = chromium.new_page(viewport=SIZE, color_scheme=theme)
        if not webassembly:
            page.add_init_script("delete window.WebAssembly")
        yield Panel(page, path)
        chromium.close()
