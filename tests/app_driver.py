"""Drives the real app in a real browser, by what a user sees: roles, names and words."""

import json
import re
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Literal
from urllib.parse import urlsplit

from playwright.sync_api import (
    Browser,
    ConsoleMessage,
    Locator,
    Page,
    Request,
    Response,
    ViewportSize,
    sync_playwright,
)

CHROMIUM = shutil.which("chromium")
PATIENCE = 180_000  # ms that a condition is waited for; machines of CI are slow and busy
SIZE: ViewportSize = {"width": 1280, "height": 800}
# what the browser keeps for a reload, as text
KEPT = "Object.values(sessionStorage).find(one => one.includes('document'))"
# counts the requests that wait for an answer, and for how long none came or went, ms; a browser
# that is too busy to ask counts no time
WATCH = """
  window.asked = {waiting: 0, quiet: 0};
  window.setInterval(() => { window.asked.quiet += 50; }, 50);
  const ask = window.fetch;
  const count = step => {
    window.asked.waiting += step;
    window.asked.quiet = 0;
  };
  window.fetch = (...all) => {
    if (all[1] && all[1].method === "HEAD") return ask(...all); // only whether a server is there
    count(1);
    return ask(...all).finally(() => count(-1));
  };
"""
QUIET = 600  # ms without a request, more than the page waits between looks at work under way
SETTLED = f"""() => document.getElementById("work").hidden
  && window.asked.waiting === 0 && window.asked.quiet > {QUIET}"""
Theme = Literal["light", "dark"]


@contextmanager
def browser() -> Iterator[Browser]:
    """A headless Chromium."""
    with sync_playwright() as playwright:
        started = playwright.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        yield started
        started.close()


class Walk:
    """One tab of the browser that looks at the app.

    `faults` : what went wrong beneath what the user sees: errors in the browser's console, requests
    to other hosts, answers that say something failed.
    """

    def __init__(self, browser: Browser, url: str, theme: Theme = "light") -> None:
        context = browser.new_context(
            viewport=SIZE, accept_downloads=True, color_scheme=theme, reduced_motion="reduce"
        )
        context.set_default_timeout(PATIENCE)
        context.add_init_script(WATCH)
        self.page: Page = context.new_page()
        self.faults: list[str] = []
        self._host = urlsplit(url).netloc
        self.page.on("console", self._hear)
        self.page.on("pageerror", lambda error: self.faults.append(str(error)))
        self.page.on("request", self._see_request)
        self.page.on("response", self._see_response)
        self.page.goto(url)
        self.page.locator("section.step:visible h2").wait_for()
        self.page.locator("#where-we-are:not(:empty)").wait_for()

    def close(self) -> None:
        """Close the tab."""
        self.page.context.close()

    def _hear(self, said: ConsoleMessage) -> None:
        if said.type == "error":
            self.faults.append(f"{said.text} ({said.location.get('url')})")

    def _see_request(self, one: Request) -> None:
        if one.url.startswith("http") and urlsplit(one.url).netloc != self._host:
            self.faults.append(f"asked for {one.url}")

    def _see_response(self, one: Response) -> None:
        if one.status >= 400:
            self.faults.append(f"{one.status} of {one.url}")

    def step(self, title: str) -> Locator:
        """Open a step, and wait until it is shown."""
        links = self.page.get_by_role("navigation", name="Steps")
        links.get_by_role("button", name=title).click()
        self.heading(title).wait_for()
        return self.page.locator("section.step:visible")

    def heading(self, title: str) -> Locator:
        """Heading of a step, visible while it is open."""
        return self.page.get_by_role("heading", level=2, name=title, exact=True)

    def settle(self) -> None:
        """Wait until no work is under way and no answer of the server is waited for."""
        # what a click asks for may be asked a moment later
        self.page.evaluate("() => { window.asked.quiet = 0; }")
        self.page.wait_for_function(SETTLED)

    def choose(self, label: str, value: str) -> None:
        """Choose from a list of the open step by what stands there."""
        self.page.locator("section.step:visible").get_by_label(label, exact=True).click()
        self.page.get_by_role("option", name=value).click()

    def search(self) -> None:
        """Find which effect is missing, and wait for the answer."""
        self.step("Which effect")
        self.settle()
        self.button("Find which effect is missing").click()
        self.page.get_by_role("rowheader", name="none of them").wait_for()
        self.settle()

    def add(self) -> None:
        """Add the effect that the search suggests, and wait until it is there."""
        before = self.versions()
        self.step("Which effect").get_by_role("button", name=re.compile("^Add ")).click()
        self.heading("Add").wait_for()
        self.page.wait_for_function(
            f"count => JSON.parse(JSON.parse({KEPT}).session.document).versions.length > count",
            arg=len(before),
        )
        self.settle()

    def versions(self) -> list[str]:
        """Titles of the versions that the browser keeps."""
        return [one["title"] for one in self.document()["versions"]]

    def document(self) -> dict[str, Any]:
        """What the browser keeps of the user's choices."""
        kept = self.page.evaluate(KEPT)
        return dict(json.loads(json.loads(kept)["session"]["document"]))

    def picture(self, path: Path) -> None:
        """Take a picture of what the window shows."""
        self.page.screenshot(path=path)

    def build(self, button: str) -> Locator:
        """Build a file in the step Take away; the link to it."""
        card = self.card(button)
        self.button(button).click()
        link = card.get_by_role("link", name="Download")
        link.wait_for()
        return link

    def card(self, button: str) -> Locator:
        """The card of a file in the step Take away, by what its button says."""
        return self.page.locator(".card").filter(has=self.page.get_by_text(button, exact=True))

    def button(self, name: str) -> Locator:
        """A button of the open step."""
        return self.page.get_by_role("button", name=name, exact=True)

    def save(self, link: Locator, folder: Path) -> Path:
        """Follow a link to a file, and keep it under the name that it is given."""
        with self.page.expect_download() as coming:
            link.click()
        path = folder / coming.value.suggested_filename
        coming.value.save_as(path)
        return path
