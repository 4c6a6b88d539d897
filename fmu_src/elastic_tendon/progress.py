"""How long work tells what it does: one protocol for all of it."""

from collections.abc import Callable

Progress = Callable[[str, float], object]  # what is being done, and the share of it that is done


class Enough(KeyboardInterrupt):
    """Raised by a progress callback of which whoever waits has enough: what is known so far is the
    result, where there is any."""


def silent(_text: str, _share: float) -> None:
    """Tell nobody."""
