"""The app in a real browser: what a user can do there, and what strangers' text cannot."""

import json
from collections.abc import Iterator

import pytest

pytest.importorskip("playwright")
pytest.importorskip("dash")

from app_driver import CHROMIUM, Walk, browser, served

pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="chromium is not installed")


@pytest.fixture(scope="module")
def demo() -> Iterator[str]:
    with served("--demo") as url:
        yield url


@pytest.fixture(scope="module")
def chromium() -> Iterator[object]:
    with browser() as started:
        yield started


@pytest.fixture
def walk(chromium, demo) -> Iterator[Walk]:
    tab = Walk(chromium, demo)
    yield tab
    tab.close()
    assert tab.faults == []


def test_cancel_answers_at_once_and_changes_nothing(walk: Walk) -> None:
    walk.step("Take away")
    walk.page.get_by_label("all of these").check()
    before = json.loads(walk.kept())["session"]["document"]
    walk.button("Build the FMU").click()
    walk.button("Cancel").click()
    walk.page.locator("#work").wait_for(state="hidden")
    walk.button("Build the FMU").wait_for()
    assert walk.card("Build the FMU").get_by_role("link").count() == 0
    assert json.loads(walk.kept())["session"]["document"] == before
