"""What is done with a piece of a sweep, wherever that is."""

import time
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd

from elastic_tendon.errors import ElasticTendonError
from elastic_tendon.sweeps.fingerprint import differences
from elastic_tendon.sweeps.formats import FORMATS
from elastic_tendon.sweeps.store import Store, part_name
from elastic_tendon.sweeps.task import ENVIRONMENT, FAILURE, RUN, Task

Piece = tuple[int, int]  # first run, and the one after the last


@dataclass(frozen=True, eq=False)
class Done:
    """The results of the runs `start` to `stop` - 1, of which `failed` failed.

    `content` : the table as bytes of its format; empty where it is in a shared store already.
    `size` : of the table, bytes; `seconds` : that it took.
    """

    start: int
    stop: int
    failed: int
    content: bytes
    size: int
    seconds: float


@dataclass(frozen=True)
class Fault:
    """These runs could not be done there, for a `reason` that is not theirs."""

    start: int
    stop: int
    reason: str


@dataclass(frozen=True)
class Order:
    """What is wanted of every piece.

    `suffix` : of the format of tables; `store` : where tables go, None: back to who asked;
    `fingerprint` : of the code that must be there.
    """

    task: Task
    suffix: str
    fingerprint: Mapping[str, str]
    store: Store | None = None


class Ranges:
    """Runs to be done, cut into pieces of `size` as they are asked for; who does them may change
    it where it may be `tuned`."""

    def __init__(self, missing: Iterable[Piece], size: int, *, tuned: bool = False) -> None:
        self._missing = [piece for piece in missing if piece[1] > piece[0]][::-1]
        self.size, self.tuned = size, tuned
        self.left = sum(stop - start for start, stop in self._missing)

    def __iter__(self) -> Iterator[Piece]:
        return self

    def __next__(self) -> Piece:
        if not self._missing:
            raise StopIteration
        start, stop = self._missing.pop()
        cut = min(start + self.size, stop)
        if cut < stop:
            self._missing.append((cut, stop))
        self.left -= cut - start
        return start, cut


def work(order: Order, start: int, stop: int) -> Done | Fault:
    """Do some runs.

    Raises
    ------
    ValueError : the task's table breaks its promise
    """
    if different := differences(order.fingerprint):
        return Fault(start, stop, different)
    begin = time.monotonic()
    try:
        table = _rows(order.task, start, stop)
        return finished(order, start, stop, table, time.monotonic() - begin)
    except ENVIRONMENT as error:
        return Fault(start, stop, reason_of(error))


def finished(
    order: Order, start: int, stop: int, table: pd.DataFrame, seconds: float = 0.0
) -> Done:
    """A table as it goes back, or into the store.

    Raises
    ------
    ValueError : it breaks the promise of a `Task`
    """
    content = FORMATS[order.suffix].encode(_promised(order.task, start, stop, table))
    failed = int((table[FAILURE] != "").sum())
    size = len(content)
    if order.store is not None:
        order.store.put(part_name(start, stop, failed, content, order.suffix), content)
        content = b""
    return Done(start, stop, failed, content, size, seconds)


def ready(order: Order) -> str:
    """What this process lacks for the task, in words; "" where it lacks nothing."""
    if different := differences(order.fingerprint):
        return different
    try:
        FORMATS[order.suffix].encode(order.task.failed(0, ""))
    except ENVIRONMENT as error:
        return reason_of(error)
    return ""


def reason_of(error: BaseException) -> str:
    """An error in one line."""
    text = " ".join(str(error).split())
    return text if isinstance(error, ElasticTendonError) else f"{type(error).__name__}: {text}"


def _rows(task: Task, start: int, stop: int) -> pd.DataFrame:
    try:
        return task.rows(start, stop)
    except ENVIRONMENT:
        raise
    except Exception as error:  # whatever it is, the other runs go on
        if stop - start == 1:
            return task.failed(start, reason_of(error))
    tables = [_rows(task, run, run + 1) for run in range(start, stop)]
    return pd.concat(tables, ignore_index=True)


def _promised(task: Task, start: int, stop: int, table: pd.DataFrame) -> pd.DataFrame:
    """The table, if it is what a `Task` promises.

    Raises
    ------
    ValueError : columns or their types differ from those of `task.failed`, or runs are missing
    """
    example = task.failed(start, "")
    if _columns(table) != _columns(example):
        raise ValueError(
            f"rows() gives the columns {_columns(table)}, but failed() gives {_columns(example)}"
        )
    if table.columns[0] != RUN or table.columns[-1] != FAILURE:
        raise ValueError(f"the first column must be {RUN!r} and the last {FAILURE!r}")
    runs = table[RUN].to_numpy()
    first_rows = np.flatnonzero(np.diff(runs, prepend=start - 1))  # a run may have several
    if not np.array_equal(runs[first_rows], np.arange(start, stop)):
        raise ValueError(f"rows({start}, {stop}) gives other runs, or not in order")
    return table


def _columns(table: pd.DataFrame) -> list[tuple[str, str]]:
    # text has several types in pandas
    return [
        (str(name), str(kind) if isinstance(kind, np.dtype) and kind.kind in "biuf" else "text")
        for name, kind in table.dtypes.items()
    ]
