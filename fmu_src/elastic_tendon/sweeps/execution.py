"""Where the batches of a sweep are done, and what becomes of those whose worker is lost."""

import os
import signal
import threading
import time
import warnings
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from contextlib import closing, suppress
from dataclasses import dataclass, field
from typing import Any

from elastic_tendon.errors import SweepError
from elastic_tendon.sweeps import WAIT
from elastic_tendon.sweeps.work import Done, Fault, Order, Piece, finished, work

FAULTS = 3  # of the environment in a row, after which a place is given up
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
    """Workers of a Dask cluster, those that join later as well.

    A worker does one run at a time and should have one thread and a nanny: nannies start lost
    workers anew and keep BLAS at one thread (`dask worker ADDRESS --nworkers 8 --nthreads 1`).

    Parameters
    ----------
    scheduler : its address, as in tcp://host:8786, or the file that it wrote
    client : a `distributed.Client` instead, which stays open
    wait : for a first worker, and for another one when all have left, s
    """

    scheduler: str | None = None
    client: Any = None
    wait: float = WAIT


Place = Local | Cluster
Tell = Callable[[str], object]  # called with what goes on besides: who is waited for or left out


KEPT = "what is done is kept: mend this and repeat the command to go on"


class Lost(Exception):  # noqa: N818 - what happened, no mistake of anybody
    """A worker ended before it gave its results."""


@dataclass(frozen=True)
class Pool:
    """Workers of this computer.

    Parameters
    ----------
    workers : how many there are
    parallel : a joblib.Parallel that has so many pieces in flight
    explain : what an exception of it means; `Lost` where a worker was lost
    """

    workers: int
    parallel: Callable[[int], Any]
    explain: Callable[[Exception], Exception]


def quiet(_text: str) -> None:
    """Tell nobody."""


def execute(
    order: Order, pieces: Iterable[Piece], place: Place, tell: Tell = quiet
) -> Generator[Done, None, None]:
    """Do pieces of a task; each run comes once, as soon as it is done, in no order.

    Pieces are taken as workers become free, and no more than some for each worker are under way
    or wait to be taken away, so memory does not grow with their number. Closing the iterator ends
    the workers.

    Parameters
    ----------
    order : whose task's `rows` may raise: the runs of that piece are then done one by one, and
        those that raise become `task.failed`; what the environment is at fault for is tried again
    pieces : first run of each, and the one after its last; on a cluster the size of `Ranges` is
        tuned as they run
    place : where they are done
    tell : called with what goes on besides

    Raises
    ------
    SweepError : runs could not be done anywhere, or the cluster cannot be reached, has no workers,
        or has other code
    ValueError : `task.rows` gives a table that breaks the promise
    """
    if isinstance(place, Cluster):
        from elastic_tendon.sweeps.cluster import run_on_cluster

        return run_on_cluster(order, pieces, place, tell)
    return _here(order, pieces, place)


def _here(order: Order, pieces: Iterable[Piece], place: Local) -> Generator[Done, None, None]:
    pool, faults = _pool(order, place), _Faults()
    under_way = _UnderWay(iter(pieces), 4 * pool.workers + 32)
    while not under_way.finished:
        try:
            with closing(_results(pool, 2 * pool.workers, order, under_way.take())) as results:
                for result in results:
                    under_way.pieces.remove((result.start, result.stop))
                    if isinstance(result, Done):
                        faults.none()
                        yield result
                    else:
                        faults.add(result)
        except Lost:
            # any of them may have ended the worker, and the others went down with it
            for start, stop in under_way.take_back():
                yield from _alone(pool, order, start, stop, faults)
    again, faults.kept = faults.kept, []
    for fault in again:
        yield from _alone(pool, order, fault.start, fault.stop, faults)
    faults.check()


@dataclass
class _Faults:
    """What the environment kept from being done on this computer."""

    in_a_row: int = 0
    kept: list[Fault] = field(default_factory=list)

    def none(self) -> None:
        """Something was done."""
        self.in_a_row = 0

    def add(self, fault: Fault) -> None:
        """Note one; SweepError where nothing can be done here."""
        self.in_a_row += 1
        self.kept.append(fault)
        if self.in_a_row >= FAULTS:
            raise SweepError(f"runs cannot be done here: {fault.reason}; {KEPT}")

    def check(self) -> None:
        """SweepError where anything is left."""
        if self.kept:
            raise undone(self.kept)


def undone(faults: Sequence[Fault]) -> SweepError:
    """What to say of runs that could not be done anywhere."""
    first = min(faults, key=lambda fault: fault.start)
    count = sum(fault.stop - fault.start for fault in faults)
    which = f"run {first.start}" if count == 1 else f"{count} runs, from run {first.start} on,"
    return SweepError(f"{which} could not be done anywhere: {first.reason}; {KEPT}")


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


def _alone(pool: Pool, order: Order, start: int, stop: int, faults: "_Faults") -> Iterator[Done]:
    """Do a piece while nothing else is done, so that a lost worker tells who is guilty; halves of
    it where it is."""
    for _ in range(TRIES if stop - start == 1 else 1):
        with suppress(Lost):
            [result] = _results(pool, 1, order, [(start, stop)])
            if isinstance(result, Done):
                faults.none()
                yield result
            else:
                faults.add(result)
            return
    if stop - start == 1:
        yield lost(order, start)
        return
    middle = (start + stop) // 2
    yield from _alone(pool, order, start, middle, faults)
    yield from _alone(pool, order, middle, stop, faults)


def lost(order: Order, run: int) -> Done:
    """A run that ended its process whenever it was tried."""
    return finished(order, run, run + 1, order.task.failed(run, LOST))


class _Stop(Exception):  # noqa: N818
    """Thrown into joblib, which then ends its workers without a warning."""


def _results(
    pool: Pool, in_flight: int, order: Order, pieces: Iterable[Piece]
) -> Generator[Done | Fault, None, None]:
    from joblib import delayed

    delayed_work = delayed(work)
    outputs = None
    try:
        outputs = pool.parallel(in_flight)(delayed_work(order, *piece) for piece in pieces)
        for result in outputs:  # noqa: UP028 - `yield from` would close `outputs`, which warns
            yield result
    except Exception as error:
        explained = pool.explain(error)
        if explained is error:
            raise
        raise explained from None
    finally:
        if outputs is not None:
            with suppress(_Stop):
                outputs.throw(_Stop())


def _pool(order: Order, place: Local) -> Pool:
    if order.task.threads:
        return Pool(place.workers, lambda in_flight: _threads(place.workers, in_flight), _same)
    return Pool(place.workers, lambda in_flight: _processes(place.workers, in_flight), _meaning)


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
