"""The server is killed in the middle of each step; another one goes on where it was."""

import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

pytest.importorskip("playwright")
pytest.importorskip("dash")

from app_driver import CHROMIUM, Walk, browser
from app_process import end, start

pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="chromium is not installed")

TIME = np.arange(50) / 100
MOTION = {"motor_position_rad": TIME / 10, "joint_position_rad": TIME / 10.01}
SENT = pd.DataFrame({"time_s": TIME, **MOTION}).to_parquet()
RUNS = "() => !document.getElementById('work').hidden"  # work is under way
FRICTION = "Coulomb friction"


class Killed:
    """A page whose server is killed now and then."""

    def __init__(self, chromium, file: Path) -> None:
        self.file = file
        self.process: subprocess.Popen[str]
        self.process, self.url = start("--demo", "--session", file)
        self.walk = Walk(chromium, self.url)

    def kill(self, title: str) -> None:
        """Kill the server, and let another one go on; the page shows the same step by itself."""
        page = self.walk.page
        self.process.kill()
        self.process.communicate()
        page.get_by_role("alert").filter(has_text="The server does not answer").wait_for()
        assert f"--session {self.file.name}" in page.inner_text("#lost")
        with page.expect_navigation():
            self.process, url = start("--session", self.file)
        assert url == self.url
        self.walk.heading(title).wait_for()
        page.get_by_text(f"{self.file.name} · ").wait_for()
        assert page.inner_text("#lost") == ""


def in_model(killed: Killed) -> None:
    walk = killed.walk
    inertia = walk.step("Model").get_by_label("inertia").first
    inertia.fill("0.031")
    inertia.press("Enter")
    walk.page.get_by_text("edited by hand").first.wait_for()
    killed.kill("Model")
    walk.settle()
    assert walk.versions() == ["edited by hand"]
    assert inertia.input_value() == "0.031"


def in_data(killed: Killed) -> None:
    walk = killed.walk
    walk.step("Data")
    sent = {"name": "sent.parquet", "mimeType": "application/octet-stream", "buffer": SENT}
    walk.page.locator("#data-upload input[type=file]").set_input_files([sent])
    walk.page.get_by_text("sent.parquet", exact=True).first.wait_for()
    killed.kill("Data")
    walk.settle()
    card = walk.page.locator(".card").filter(has=walk.page.get_by_text("sent.parquet", exact=True))
    assert "50 samples" in card.inner_text()
    card.get_by_role("button", name="Remove").click()
    walk.settle()


def in_compare(killed: Killed) -> None:
    looking(killed, "Compare", "compare-overlay")


def in_where(killed: Killed) -> None:
    looking(killed, "Where", "where-overlay")


def looking(killed: Killed, title: str, figure: str) -> None:
    """Nobody asked for what a step shows: it is computed anew."""
    killed.walk.step(title)
    killed.kill(title)
    killed.walk.page.locator(f"#{figure} .main-svg").first.wait_for()


def in_which_effect(killed: Killed) -> None:
    walk = killed.walk
    walk.step("Which effect")
    walk.settle()
    walk.button("Find which effect is missing").click()
    walk.page.wait_for_function(RUNS)
    killed.kill("Which effect")
    ranking = walk.page.get_by_role("rowheader", name="none of them")
    ranking.wait_for()  # nobody asked again
    walk.settle()
    killed.kill("Which effect")
    ranking.wait_for()
    assert "missing" not in walk.page.inner_text("#work-words")  # nor is it searched again


def in_add(killed: Killed) -> None:
    walk = killed.walk
    walk.step("Which effect").get_by_role("button", name=f"Add {FRICTION}").click()
    walk.heading("Add").wait_for()
    walk.page.wait_for_function(RUNS)
    killed.kill("Add")
    walk.page.get_by_text(f"{FRICTION} is in the model").wait_for()
    walk.settle()
    assert walk.versions()[-1] == f"+ {FRICTION}"


def in_take_away(killed: Killed) -> None:
    walk = killed.walk
    walk.step("Take away")
    walk.button("Write the findings").click()
    killed.kill("Take away")
    walk.build("Write the findings")


SOME = (in_data,)  # a server takes seconds to begin
EVERY = (in_model, in_data, in_compare, in_where, in_which_effect, in_add, in_take_away)


@pytest.mark.parametrize(
    "steps",
    [pytest.param(SOME, id="some"), pytest.param(EVERY, id="every", marks=pytest.mark.slow)],
)
def test_another_server_goes_on(
    steps: tuple[Callable[[Killed], None], ...], tmp_path: Path
) -> None:
    with browser() as chromium:
        killed = Killed(chromium, tmp_path / "night.session")
        try:
            for step in steps:
                step(killed)
            assert killed.process.poll() is None  # the last server goes on
        finally:
            end(killed.process)
