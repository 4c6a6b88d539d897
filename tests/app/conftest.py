"""One server of the demo and one browser for all tests of a module: to start them takes long."""

from collections.abc import Iterator

import pytest

from app_process import served


@pytest.fixture(scope="module")
def demo() -> Iterator[str]:
    """Address of a server that shows the demo."""
    with served("--demo") as url:
        yield url


@pytest.fixture(scope="module")
def chromium() -> Iterator[object]:
    """A browser that runs; what drives it is an extra, which other tests of the app do without."""
    from app_driver import browser

    with browser() as started:
        yield started
