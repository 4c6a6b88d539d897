"""Workers of a Dask cluster: each is kept supplied from here, so that who is sick, who has left and
which run ended its process is known.

A piece is sent to one worker as bytes that only the worker unpickles, so the scheduler needs Dask
and nothing of ours.
"""

import asyncio
import logging
import pickle
import re
import time
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import CancelledError, ThreadPoolExecutor
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field, replace
from typing import Any
from uuid import uuid4

from elastic_tendon.errors import SweepError
from elastic_tendon.sweeps.execution import FAULTS, KEPT, TRIES, Cluster, Tell, lost, undone
from elastic_tendon.sweeps.fingerprint import ADVICE
from elastic_tendon.sweeps.work import Done, Fault, Order, Piece, Ranges, ready, reason_of, work

CONNECT_SECONDS = 8.0
LOOK_SECONDS = 1.0  # between looks who has come and who has left
GRACE_SECONDS = 5.0  # waited for others where all workers are left out
POLL_SECONDS = 0.01
ORDERS = 8  # that a worker remembers
SHORT = 5.0  # s of a piece, below which the next one waits at its worker already
PIECE_SECONDS = (10.0, 60.0)  # of a piece at least and at most, where there is enough to do
DEALING = 0.02  # s of a piece for each worker: one after the other they are dealt out
PIECES = 500  # for each worker, where pieces may be longer than the least
LAST_PIECES = 4  # for each worker of what is left, so that all end together
LAST_DEALING = 0.005  # s, the same of the last pieces: shorter ones are not dealt out in time
PIECE_BYTES = 2_000_000  # of results that come back
_TALKERS = ("distributed", "distributed.client", "tornado", "tornado.application", "asyncio")


def run_on_cluster(
    order: Order, pieces: Iterable[Piece], place: Cluster, tell: Tell
) -> Generator[Done, None, None]:
    """`execute` for a cluster."""
    with _silence(), _connected(place) as (client, address):
        crew = _Crew(client, address, order, pieces, place.wait, tell)
        try:
            yield from crew.results()
        finally:
            crew.dismiss()


# ---- what is sent to workers ---------------------------------------------------------------------


class _Call:
    """What becomes the value of `function` where it is unpickled."""

    def __init__(self, function: Callable[..., Any], *arguments: Any) -> None:
        self._parts = (function, arguments)

    def __reduce__(self) -> tuple[Callable[..., Any], tuple[Any, ...]]:
        return self._parts


_orders: dict[str, Order] = {}  # of this worker, by name


def begin(name: str, order: Order) -> str:
    """Let this worker remember an order; what it lacks for that, in words."""
    while len(_orders) >= ORDERS:
        del _orders[next(iter(_orders))]
    _orders[name] = order
    return ready(order)


def answer(name: str, start: int, stop: int) -> tuple[Any, ...] | str | None:
    """Do a piece on this worker.

    Returns
    -------
    fields of `Done` behind the piece; the reason of a `Fault`; or None where the worker has
        started anew meanwhile and does not know of what
    """
    order = _orders.get(name)
    if order is None:
        return None
    result = work(order, start, stop)
    if isinstance(result, Fault):
        return result.reason
    return result.failed, result.content, result.size, result.seconds


# ---- who does what -------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Job:
    """A piece; `alone`: in quarantine; `losses`: workers that ended while they did nothing else;
    `tried`: workers that could not do it."""

    piece: Piece
    alone: bool = False
    losses: int = 0
    tried: frozenset[str] = frozenset()


@dataclass
class _Worker:
    """`under_way`: its jobs by the key of their future, in the order in which it does them."""

    address: str
    threads: int
    ready: bool = False
    faults: int = 0  # in a row
    under_way: dict[str, tuple[Any, _Job]] = field(default_factory=dict)

    @property
    def isolated(self) -> bool:
        """Whether a piece is in quarantine here."""
        return any(job.alone for _, job in self.under_way.values())


@dataclass
class Lengths:
    """How long runs took of late, and so how long pieces should be.

    `seconds`, `size` : of a run, and bytes of its results, smoothed; 0 before any is done.
    `piece_seconds` : that the last piece took.
    """

    seconds: float = 0.0
    size: float = 0.0
    piece_seconds: float = float("inf")

    def learn(self, piece: Piece, value: tuple[Any, ...]) -> None:
        """What `answer` says of a piece that was done."""
        _, content, _, self.piece_seconds = value
        count = piece[1] - piece[0]
        share = 0.2 if self.seconds else 1.0
        self.seconds += share * (max(self.piece_seconds, 1e-6) / count - self.seconds)
        self.size += share * (len(content) / count - self.size)

    def tune(self, pieces: Ranges, threads: int) -> None:
        """Let pieces be long enough for the scheduler, and short enough that all end together."""
        if not self.seconds:
            return
        least, most = PIECE_SECONDS
        left = pieces.left * self.seconds / threads
        long = min(max(least, DEALING * threads, left / PIECES), most)
        last = max(left / LAST_PIECES, LAST_DEALING * threads)
        count = min(long, last) / self.seconds
        if self.size:
            count = min(count, PIECE_BYTES / self.size)
        pieces.size = max(1, int(count))


class _Crew:
    """The workers, what each is doing, and what is still to be done."""

    def __init__(
        self,
        client: Any,
        address: str,
        order: Order,
        pieces: Iterable[Piece],
        wait: float,
        tell: Tell,
    ) -> None:
        from distributed import as_completed

        self._client, self._address, self._order = client, address, order
        self._pieces, self._iterator = pieces, iter(pieces)
        self._wait, self._tell = wait, tell
        self._name = uuid4().hex
        self._sent = 0
        self._answers: Any = as_completed([], loop=client.loop, with_results=True)  # type: ignore[no-untyped-call]
        self._workers: dict[str, _Worker] = {}
        self._doors: dict[str, tuple[Any, str]] = {}
        self._left_out: dict[str, str] = {}
        self._again: deque[_Job] = deque()
        self._quarantine: deque[_Job] = deque()
        self._recorded: list[Done] = []
        self._undone: list[Fault] = []
        self._next_look = 0.0
        self._seen = time.monotonic()
        self._lengths = Lengths()
        self._counted = 0
        with suppress(Exception):  # not every scheduler has one
            if link := client.dashboard_link:
                tell(f"Dask shows its work at {link}")

    def results(self) -> Iterator[Done]:
        """All that is done, until nothing is left.

        Raises
        ------
        SweepError : see `execute`
        """
        while True:
            self._look()
            self._supply()
            self._collect()
            recorded, self._recorded = self._recorded, []
            yield from recorded
            if not recorded:
                if self._finished():
                    break
                time.sleep(POLL_SECONDS)
        if self._undone:
            raise undone(self._undone)

    def dismiss(self) -> None:
        """Drop what is under way."""
        futures = [future for future, _ in self._doors.values()]
        for worker in self._workers.values():
            futures += [future for future, _ in worker.under_way.values()]
        with suppress(Exception):  # where there is no scheduler, there is nothing to cancel
            if self._client.status == "running":
                self._client.cancel(futures)

    def _finished(self) -> bool:
        if self._again or self._quarantine or any(w.under_way for w in self._workers.values()):
            return False
        job = self._fresh()
        if job is not None:
            self._again.append(job)
        return job is None

    # ---- who is there ----

    def _look(self) -> None:
        now = time.monotonic()
        if now < self._next_look:
            return
        self._next_look = now + LOOK_SECONDS
        there = self._there()
        for address in self._workers.keys() - there.keys():
            self._gone(address)
        for address in there.keys() - self._workers.keys() - self._left_out.keys():
            self._workers[address] = _Worker(address, there[address])
            self._ask(address)
        if self._workers:
            self._seen = now
        else:
            self._nobody(now - self._seen, there)

    def _there(self) -> dict[str, int]:
        """Threads of each worker that the scheduler has."""
        with suppress(OSError):
            if self._client.status == "running":
                threads: dict[str, int] = self._client.nthreads()
                return threads
        raise SweepError(
            f"{self._address}: the Dask scheduler ended or cannot be reached any more; "
            "what is done is kept: start it again and repeat the command to go on"
        )

    def _ask(self, address: str) -> None:
        """Ask a worker whether it can do this."""
        future = self._submit(address, _Call(begin, self._name, self._order))
        self._doors[future.key] = (future, address)

    def _nobody(self, absent: float, there: Iterable[str]) -> None:
        sick = [address for address in self._left_out if address in there]
        if sick and absent > GRACE_SECONDS:
            raise SweepError(
                f"no worker of {self._address} can do this: "
                f"{sick[0]}: {self._left_out[sick[0]]}; {KEPT}"
            )
        if absent > self._wait:
            raise SweepError(
                f"{self._address}: the scheduler has no worker; start some with "
                f"`dask worker {self._address} --nworkers 2 --nthreads 1` and repeat the command"
            )
        self._tell(f"waiting for a worker of {self._address}, {absent:.0f} of {self._wait:.0f} s")

    def _leave_out(self, address: str, reason: str) -> None:
        """Give a worker nothing any more; what it has is done elsewhere."""
        self._left_out[address] = reason
        self._tell(f"worker {address} is left out: {reason}")
        worker = self._workers.pop(address)
        self._client.cancel([future for future, _ in worker.under_way.values()])
        for _, job in worker.under_way.values():
            self._repeat(job)

    def _gone(self, address: str) -> None:
        """A worker has left, or what it did has ended it; what waited at it is innocent."""
        worker = self._workers.pop(address)
        for key in [key for key, (_, asked) in self._doors.items() if asked == address]:
            self._client.cancel([self._doors.pop(key)[0]])
        self._client.cancel([future for future, _ in worker.under_way.values()])
        for place, (_, job) in enumerate(worker.under_way.values()):
            if place < worker.threads:
                self._suspect(job)
            else:
                self._repeat(job)

    def _suspect(self, job: _Job) -> None:
        """Put halves of a piece in quarantine, or count what a single run has done."""
        start, stop = job.piece
        if stop - start > 1:
            middle = (start + stop) // 2
            for half in ((start, middle), (middle, stop)):
                self._quarantine.append(_Job(half, alone=True))
        elif job.losses + job.alone >= TRIES:
            self._recorded.append(lost(self._order, start))
        else:
            self._quarantine.append(replace(job, alone=True, losses=job.losses + job.alone))

    def _repeat(self, job: _Job) -> None:
        (self._quarantine if job.alone else self._again).append(job)

    # ---- who does what ----

    def _supply(self) -> None:
        able = sorted(
            (worker for worker in self._workers.values() if worker.ready),
            key=lambda worker: len(worker.under_way),
        )
        if len(able) != self._counted:
            self._counted = len(able)
            self._tell("1 worker" if len(able) == 1 else f"{len(able)} workers")
        if not able:
            return
        if isinstance(self._pieces, Ranges) and self._pieces.tuned:
            self._lengths.tune(self._pieces, sum(worker.threads for worker in able))
        kept_free = min(len(self._quarantine), max(1, len(able) // 2))
        for worker in able[:kept_free]:
            if not worker.under_way and (job := self._pick(self._quarantine, worker)):
                self._send(worker, job)
        for depth in (1, 2) if self._lengths.piece_seconds < SHORT else (1,):
            for worker in able[kept_free:]:
                while not worker.isolated and len(worker.under_way) < depth * worker.threads:
                    job = self._pick(self._again, worker) or self._fresh()
                    if job is None:
                        break
                    self._send(worker, job)

    def _pick(self, jobs: deque[_Job], worker: _Worker) -> _Job | None:
        """The first job that this worker has not tried yet, or that all have."""
        able = {address for address, known in self._workers.items() if known.ready}
        for job in jobs:
            if worker.address not in job.tried or able <= job.tried:
                jobs.remove(job)
                return job
        return None

    def _fresh(self) -> _Job | None:
        piece = next(self._iterator, None)
        return None if piece is None else _Job(piece)

    def _send(self, worker: _Worker, job: _Job) -> None:
        future = self._submit(worker.address, _Call(answer, self._name, *job.piece))
        worker.under_way[future.key] = (future, job)

    def _submit(self, address: str, call: _Call) -> Any:
        import cloudpickle

        self._sent += 1
        future = self._client.submit(
            pickle.loads,
            cloudpickle.dumps(call),
            key=f"elastic-tendon-{self._name}-{self._sent}",
            workers=[address],
            allow_other_workers=False,
            pure=False,
        )
        self._answers.add(future)
        return future

    # ---- what came of it ----

    def _collect(self) -> None:
        for future, value in self._answers.next_batch(block=False):
            if (door := self._doors.pop(future.key, None)) is not None:
                self._welcome(door[1], future, value)
                continue
            for worker in list(self._workers.values()):
                if future.key in worker.under_way:
                    self._take(worker, future, value)

    def _welcome(self, address: str, future: Any, value: Any) -> None:
        worker = self._workers[address]
        if future.status == "error":
            self._leave_out(address, _lacking(future.exception()))
        elif future.status != "finished":
            self._gone(address)  # and comes again with the next look, if it is there
        elif value:
            self._leave_out(address, value)
        else:
            worker.ready = True

    def _take(self, worker: _Worker, future: Any, value: Any) -> None:
        from distributed import KilledWorker

        if future.status == "error":
            error = future.exception()
            if not isinstance(error, KilledWorker):
                raise error
            self._gone(worker.address)
            return
        _, job = worker.under_way.pop(future.key)
        if isinstance(value, CancelledError | asyncio.CancelledError) or value is None:
            worker.ready = False
            self._repeat(job)
            self._ask(worker.address)
        elif isinstance(value, str):
            self._fault(worker, job, value)
        else:
            worker.faults = 0
            self._lengths.learn(job.piece, value)
            self._recorded.append(Done(*job.piece, *value))

    def _fault(self, worker: _Worker, job: _Job, reason: str) -> None:
        job = replace(job, tried=job.tried | {worker.address})
        worker.faults += 1
        if len(job.tried) >= FAULTS:
            self._undone.append(Fault(*job.piece, reason))
        else:
            self._repeat(job)
        if worker.faults >= FAULTS:
            self._leave_out(worker.address, f"{FAULTS} pieces in a row failed there: {reason}")


def _lacking(error: BaseException) -> str:
    missing = _cause(error, ModuleNotFoundError)
    if isinstance(missing, ModuleNotFoundError):
        return f"it lacks the package {missing.name}; install the same packages on all computers"
    return (
        "it has other code than the computer where the sweep was begun "
        f"({reason_of(error)}); {ADVICE}"
    )


def _cause(error: BaseException | None, kind: type[BaseException]) -> BaseException | None:
    while error is not None and not isinstance(error, kind):
        error = error.__cause__ or error.__context__
    return error


# ---- connection ----------------------------------------------------------------------------------


@contextmanager
def _connected(place: Cluster) -> Iterator[tuple[Any, str]]:
    """A client of the scheduler, and its address; one that was not given ends with the context.

    Raises
    ------
    SweepError : Dask is not installed, or no scheduler answers
    """
    if place.client is not None:
        yield place.client, str(place.client.scheduler.address)
        return
    try:
        import distributed
    except ModuleNotFoundError:
        raise SweepError(
            'a cluster needs Dask, which is not installed; pip install "elastic-tendon[cluster]"'
        ) from None
    address = place.scheduler or ""
    _check(address)
    open_client: Any = distributed.Client  # has no types
    try:
        client = open_client(address, timeout=CONNECT_SECONDS, set_as_default=False)
    except (OSError, ValueError) as error:
        raise _no_scheduler(address, error) from None
    try:
        yield client, address
    finally:
        # also drops what the scheduler has not begun
        with suppress(Exception):
            client.close(timeout=CONNECT_SECONDS)


def _check(address: str) -> None:
    """SweepError where no scheduler is; a client would try for a minute, or stumble over it."""
    if not re.search(r":\d+$", address):
        raise SweepError(
            f"{address}: is no address of a Dask scheduler; give what `dask scheduler` prints, "
            "as tcp://host:8786"
        )
    with ThreadPoolExecutor(1) as beside:  # a notebook has a loop in its own thread
        try:
            kind = beside.submit(asyncio.run, _kind(address)).result()
        except Exception as error:
            raise _no_scheduler(address, error) from None
    if kind != "Scheduler":
        raise SweepError(
            f"{address}: a Dask {kind.lower()} answers there, and no scheduler; give the address "
            "that `dask scheduler` prints"
        )


async def _kind(address: str) -> str:
    from distributed import rpc
    from distributed.security import Security

    connection: Any = Security().get_connection_args("client")  # type: ignore[no-untyped-call]

    async def ask() -> str:
        remote: Any = rpc(address, timeout=CONNECT_SECONDS, connection_args=connection)  # type: ignore[no-untyped-call]
        async with remote:
            return str((await remote.identity())["type"])

    return await asyncio.wait_for(ask(), CONNECT_SECONDS)


def _no_scheduler(address: str, error: Exception) -> SweepError:
    told = (
        f"nothing that a scheduler says within {CONNECT_SECONDS:.0f} s"
        if isinstance(error, TimeoutError) or not str(error)
        else str(error).partition("\n")[0].rstrip(".")
    )
    return SweepError(
        f"{address}: no Dask scheduler answers there ({told}); "
        "start one with `dask scheduler` and give the address that it prints"
    )


@contextmanager
def _silence() -> Iterator[None]:
    """Keep what Dask logs off the user's terminal: what matters is told in sentences."""
    loggers = [logging.getLogger(name) for name in _TALKERS]
    places = [*loggers, *(handler for logger in loggers for handler in logger.handlers)]
    for place in places:
        place.addFilter(_nothing)
    try:
        yield
    finally:
        for place in places:
            place.removeFilter(_nothing)


def _nothing(_record: logging.LogRecord) -> bool:
    return False
