"""Giving threads of the app time."""

from collections.abc import Callable
from threading import Event

LONG = 20.0  # s that a thread is waited for before a test gives up


def wait_for(happens: Callable[[], bool]) -> None:
    """Return as soon as it happens; fails if that takes for ever."""
    pause = Event()
    for _ in range(int(LONG / 0.01)):
        if happens():
            return
        pause.wait(0.01)
    raise AssertionError("it did not happen")
