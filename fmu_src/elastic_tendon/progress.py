"""How long work tells what it does: one protocol for all of it."""

from collections.abc import Callable

Progress = Callable[[str, float], object]  # what is being done, and the share of it that is done


def silent(_text: str, _share: float) -> None:
    """Tell nobody."""
