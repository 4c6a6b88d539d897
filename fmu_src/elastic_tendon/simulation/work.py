"""How much is simulated: a measure of the time that work takes, the same on every machine."""

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass

AFFORDABLE = 8e8  # multiplications that one piece of work may take: some seconds
# multiplications that the rates alone take, in those of a derivative of one state, and that a
# simulation takes however short it is
PLAIN, BEGINNING = 8, 40_000


@dataclass
class Work:
    """Multiplications, about, that simulations have taken so far."""

    multiplications: float = 0.0


_UNDER_WAY: ContextVar[Work | None] = ContextVar("work under way", default=None)


@contextmanager
def counted(work: Work) -> Iterator[None]:
    """Count what this thread simulates; also as part of what is counted already."""
    whole, before = _UNDER_WAY.get(), work.multiplications
    token = _UNDER_WAY.set(work)
    try:
        yield
    finally:
        _UNDER_WAY.reset(token)
        if whole is not None:
            whole.multiplications += work.multiplications - before


def count(evaluations: int, columns: int = 0) -> None:
    """Count a simulation: evaluations of the rates, each with so many derivatives of states."""
    if (work := _UNDER_WAY.get()) is not None:
        work.multiplications += multiplications_of(evaluations, columns)


def multiplications_of(evaluations: int, columns: int = 0) -> float:
    """Multiplications, about, of a simulation with so many derivatives of states."""
    return float(BEGINNING + evaluations * (PLAIN + columns))


def worked() -> float:
    """Multiplications of the work under way so far, 0 where nobody counts."""
    work = _UNDER_WAY.get()
    return 0.0 if work is None else work.multiplications


def enough() -> bool:
    """Whether the work under way has taken what it may."""
    return worked() > AFFORDABLE
