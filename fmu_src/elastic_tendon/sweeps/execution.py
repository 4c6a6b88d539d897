"""Where the batches of a sweep are done, and what becomes of those whose worker is lost."""

import os
import signal
import threading
import time
import warnings
from collections.abc import Callable, Generator, Iterable, Iterator
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass
from importlib.metadata import version
from typing import Any

import numpy as np
import pandas as pd

from elastic_tendon.errors import ElasticTendonError, SweepError
from elastic_tendon.sweeps.task import FAILURE, RUN, Task

Piece = tuple[int, int]  # first run, and the one after the last
TRIES = 2  # how often a run may end its process before it counts as failed
PARENT_SECONDS = 1.0  # between looks whether the parent is still there
LOST = (
    f"the process that did this run ended {TRIES} times, although it did nothing else "
    "(too little memory, or a crash in compiled code)"
)


@dataclass(frozen=True)
class Local:
    """Threads or processes of this computer, `workers` of them."""

    workers: int


@dataclass(frozen=True)
class Cluster:
    """Workers of a Dask cluster; `scheduler` is its address, as in tcp://host:8786.

    A worker does one run at a time and should have one thread and a nanny: nannies start lost
    workers anew and keep BLAS at one thread (`dask worker ADDRESS --nworkers 8 --nthreads 1`).
    """

    scheduler: str


Place = Local | Cluster


@dataclass(frozen=True, eq=False)
class Done:
    """The results of the runs `start` to `stop` - 1."""

    start: int
    stop: int
    table: pd.DataFrame


class Lost(Exception):  # noqa: N818 - what happened, no mistake of anybody
    """A worker ended before it gave its results."""


@dataclass(frozen=True)
class Pool:
    """Workers that are ready.

    Parameters
    ----------
    workers : how many there are
    parallel : a joblib.Parallel that has so many pieces in flight
    explain : what an exception of it means; `Lost` where a worker was lost
    """

    workers: int
    parallel: Callable[[int], Any]
    explain: Callable[[Exception], Exception]


def execute(task: Task, pieces: Iterable[Piece], place: Place) -> Generator[Done, None, None]:
    """Do pieces of a task; each comes once, as soon as it is done, in no order.

    Pieces are taken as workers become free, and no more than some for each worker are under way
    or wait to be taken away, so memory does not grow with their number. Closing the iterator ends
    the workers.

    Parameters
    ----------
    task : its `rows` may raise: the runs of that piece are then done one by one, and those that
        raise become `task.failed`
    pieces : first run of each, and the one after its last
    place : where they are done

    Raises
    ------
    SweepError : the cluster cannot be reached, has no workers, or has another version
    ValueError : `task.rows` gives a table that breaks the promise
    """
    with _pool(task, place) as pool:
        under_way = _UnderWay(iter(pieces), 4 * pool.workers + 32)
        while not under_way.finished:
            try:
                with closing(_results(pool, 2 * pool.workers, task, under_way.take())) as results:
                    for done in results:
                        under_way.pieces.remove((done.start, done.stop))
                        yield done
            except Lost:
                # any of them may have ended the worker, and the others went down with it
                for start, stop in under_way.take_back():
                    yield _alone(pool, task, start, stop)


class _UnderWay:
    """Pieces on their way to workers and back, `limit` at most."""

    def __init__(self, waiting: Iterator[Piece], limit: int) -> None:
        self.pieces: set[Piece] = set()
        self.finished = False
        self._waiting = waiting
        self._limit = limit
        self._round = 0
        self._lock = threading.Lock()  # joblib asks for pieces in threads of its own

    def take(self) -> Iterator[Piece]:
        """Pieces, until there are none or until results wait that nobody has taken away.

        joblib asks for the next piece when one is done, whether or not its result was taken.
        """
        self._round += 1
        mine = self._round
        while (piece := self._next(mine)) is not None:
            yield piece

    def take_back(self) -> list[Piece]:
        """Pieces that did not come back, in order; who asked for pieces before gets no more."""
        with self._lock:
            self._round += 1
            lost = sorted(self.pieces)
            self.pieces.clear()
            return lost

    def _next(self, mine: int) -> Piece | None:
        with self._lock:
            if mine != self._round or len(self.pieces) >= self._limit:
                return None
            piece = next(self._waiting, None)
            if piece is None:
                self.finished = True
            else:
                self.pieces.add(piece)
            return piece


def _alone(pool: Pool, task: Task, start: int, stop: int) -> Done:
    """Do a piece while nothing else is done, so that a lost worker tells who is guilty."""
    for _ in range(TRIES if stop - start == 1 else 1):
        with suppress(Lost):
            [done] = _results(pool, 1, task, [(start, stop)])
            return done
    if stop - start == 1:
        return Done(start, stop, task.failed(start, LOST))
    tables = [_alone(pool, task, run, run + 1).table for run in range(start, stop)]
    return Done(start, stop, pd.concat(tables, ignore_index=True))


class _Stop(Exception):  # noqa: N818
    """Thrown into joblib, which then ends its workers without a warning."""


def _results(
    pool: Pool, in_flight: int, task: Task, pieces: Iterable[Piece]
) -> Generator[Done, None, None]:
    from joblib import delayed

    work, ours = delayed(_work), version("elastic-tendon")
    outputs = None
    try:
        outputs = pool.parallel(in_flight)(work(task, *piece, ours) for piece in pieces)
        for done in outputs:  # noqa: UP028 - `yield from` would close `outputs`, which warns
            yield done
    except Exception as error:
        explained = pool.explain(error)
        if explained is error:
            raise
        raise explained from None
    finally:
        if outputs is not None:
            with suppress(_Stop):
                outputs.throw(_Stop())


@contextmanager
def _pool(task: Task, place: Place) -> Iterator[Pool]:
    if isinstance(place, Cluster):
        from elastic_tendon.sweeps.cluster import connect

        with connect(place.scheduler, task) as pool:
            yield pool
    elif task.threads:
        yield Pool(place.workers, lambda in_flight: _threads(place.workers, in_flight), _same)
    else:
        yield Pool(place.workers, lambda in_flight: _processes(place.workers, in_flight), _meaning)


def _same(error: Exception) -> Exception:
    return error


def _threads(workers: int, in_flight: int) -> Any:
    from joblib import Parallel

    return Parallel(
        workers,
        backend="threading",
        return_as="generator_unordered",
        batch_size=1,
        pre_dispatch=in_flight,
    )


def _processes(workers: int, in_flight: int) -> Any:
    from joblib import Parallel, parallel_config

    if workers == 1:
        # one of two processes: joblib does the work of a single one here, where a crash would
        # end the sweep
        workers, in_flight = 2, 1

    # a worker that has grown is replaced by joblib, which is nothing to tell users about
    warnings.filterwarnings("ignore", "A worker stopped while some jobs", UserWarning)
    with parallel_config(
        "loky", inner_max_num_threads=1, initializer=_follow_parent, initargs=(os.getpid(),)
    ):
        return Parallel(
            workers,
            return_as="generator_unordered",
            batch_size=1,
            pre_dispatch=in_flight,
            max_nbytes=None,  # arrays arrive as they were sent, not as read-only files
        )


def _follow_parent(parent: int) -> None:
    """End with the parent, and not before: Ctrl-C reaches all processes of a terminal."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(PARENT_SECONDS)
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


def _meaning(error: Exception) -> Exception:
    from joblib.externals.loky.process_executor import TerminatedWorkerError

    return Lost() if isinstance(error, TerminatedWorkerError) else error


def _work(task: Task, start: int, stop: int, wanted: str) -> Done:
    """What a worker does with a piece."""
    installed = version("elastic-tendon")
    if installed != wanted:
        raise SweepError(
            f"a worker has elastic-tendon {installed}, but the sweep was begun with {wanted}; "
            "install the same version on all computers of the cluster"
        )
    return Done(start, stop, _promised(task, start, stop, _rows(task, start, stop)))


def _rows(task: Task, start: int, stop: int) -> pd.DataFrame:
    try:
        return task.rows(start, stop)
    except Exception as error:  # whatever it is, the other runs go on
        if stop - start == 1:
            return task.failed(start, _reason(error))
    tables = [_rows(task, run, run + 1) for run in range(start, stop)]
    return pd.concat(tables, ignore_index=True)


def _reason(error: Exception) -> str:
    text = " ".join(str(error).split())
    return text if isinstance(error, ElasticTendonError) else f"{type(error).__name__}: {text}"


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
