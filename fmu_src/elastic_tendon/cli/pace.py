"""How a long sweep tells where it is: a bar on a terminal, else a line now and then."""

import re
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from elastic_tendon.cli.shared import notice, progress_bar

LINE_SECONDS = 30.0  # between lines where there is no terminal
_WORKERS = re.compile(r"\d+ workers?")
_PASSING = "waiting"  # how a note begins that is true for a moment


class Pace:
    """A progress callback that knows how fast it goes; `runs` : how many there are, once known.

    Parameters
    ----------
    show : called with the words and the share, whenever something is told
    clock : gives s
    """

    def __init__(
        self, show: Callable[[str, float], object], clock: Callable[[], float] = time.monotonic
    ) -> None:
        self.runs = 0
        self._show, self._clock = show, clock
        self._text, self._note, self._workers = "", "", ""
        self._share = self._first_share = 0.0
        self._begin: float | None = None

    def __call__(self, text: str, share: float) -> None:
        """Hear what is done."""
        self._text, _, note = text.partition("; ")
        if self.runs and self._begin is None:  # what was done before tells no speed
            self._begin, self._first_share = self._clock(), share
        self._share = share
        self._note = note if note.startswith(_PASSING) else ""
        if _WORKERS.fullmatch(note):
            self._workers = note
        elif note and not self._note:
            notice.print(f"elastic-tendon: {note}", markup=False, soft_wrap=True)
        self._show(self.words(), share)

    def words(self) -> str:
        """What is done, by how many, how fast, and how long the rest will take."""
        parts = [self._text, self._workers, *self._speed(), self._note]
        return ", ".join(part for part in parts if part)

    def _speed(self) -> Iterator[str]:
        done = self._share - self._first_share
        if self._begin is None or done <= 0.0 or not self.runs:
            return
        taken = max(self._clock() - self._begin, 1e-9)
        yield f"{done * self.runs / taken:.3g} runs/s"
        yield f"{_spoken((1.0 - self._share) / done * taken)} left"


def _spoken(seconds: float) -> str:
    for unit, size in (("d", 86_400.0), ("h", 3600.0), ("min", 60.0)):
        if seconds >= 2.0 * size:
            return f"{seconds / size:.0f} {unit}"
    return f"{seconds:.0f} s"


@contextmanager
def pace() -> Iterator[Pace]:
    """A `Pace` that moves a bar on stderr where that is a terminal, and else writes lines."""
    if notice.is_terminal:
        with progress_bar() as bar:
            yield Pace(bar)
        return
    lines_pace = Pace(lambda _text, _share: None)
    ended = threading.Event()

    def lines() -> None:
        while not ended.wait(LINE_SECONDS):
            notice.print(lines_pace.words(), markup=False, soft_wrap=True)

    thread = threading.Thread(target=lines, daemon=True)
    thread.start()
    try:
        yield lines_pace
    finally:
        ended.set()
        thread.join()
