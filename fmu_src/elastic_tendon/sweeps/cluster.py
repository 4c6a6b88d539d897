"""Workers of a Dask cluster, through joblib, with what joblib's backend leaves open closed."""

import asyncio
import logging
import re
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError, Future
from contextlib import contextmanager, suppress
from pickle import dumps
from time import monotonic
from typing import Any

from joblib import Parallel
from joblib._dask import DaskDistributedBackend

from elastic_tendon.errors import SweepError
from elastic_tendon.sweeps.execution import Done, Lost, Pool
from elastic_tendon.sweeps.task import Task

CONNECT_SECONDS = 5.0
WORKER_SECONDS = 10.0  # waited for the first worker
ABSENCE_SECONDS = 60.0  # waited for another one when all are gone
SENT_ONCE = 100_000  # bytes of a task, from which on it is sent to each worker once
_TALKERS = ("distributed", "distributed.client", "tornado", "tornado.application", "asyncio")


@contextmanager
def connect(address: str, task: Task) -> Iterator[Pool]:
    """The workers of the scheduler at `address`; the connection lasts as long as the context.

    Raises
    ------
    SweepError : Dask is not installed, or no scheduler answers
    """
    try:
        import distributed
    except ModuleNotFoundError:
        raise SweepError(
            'a cluster needs Dask, which is not installed; pip install "elastic-tendon[cluster]"'
        ) from None
    if not re.search(r":\d+$", address):
        raise SweepError(
            f"{address}: is no address of a Dask scheduler; give what `dask scheduler` prints, "
            "as tcp://host:8786"
        )
    open_client: Any = distributed.Client  # has no types
    with _silence():
        try:
            client = open_client(address, timeout=CONNECT_SECONDS, set_as_default=False)
        except (OSError, ValueError) as error:
            raise SweepError(
                f"{address}: no Dask scheduler answers there ({_first_line(error)}); "
                "start one with `dask scheduler` and give the address that it prints"
            ) from None
        try:
            _wait_for_workers(client, address)
            yield _pool(client, address, task)
        finally:
            # also drops what the scheduler has not begun
            with suppress(Exception):
                client.close(timeout=CONNECT_SECONDS)


def _wait_for_workers(client: Any, address: str) -> None:
    try:
        client.wait_for_workers(1, timeout=WORKER_SECONDS)
    except TimeoutError:
        raise _no_worker(address) from None


def _no_worker(address: str) -> SweepError:
    return SweepError(
        f"{address}: the scheduler has no worker; start some with "
        f"`dask worker {address} --nworkers 2 --nthreads 1` and repeat the command"
    )


def _pool(client: Any, address: str, task: Task) -> Pool:
    # joblib would send it with each piece: it looks at the size of the object's outside only
    sent_once = [task] if len(dumps(task)) > SENT_ONCE else None

    def parallel(in_flight: int) -> Parallel:
        backend = _Backend(client=client, wait_for_workers_timeout=WORKER_SECONDS)
        if sent_once:
            # a key of its own for each round: the name of a task that was just let go may reach a
            # worker after the same name was sent again, and Dask then waits for it for ever
            sent = client.scatter(sent_once, broadcast=True, hash=False)
            backend.data_futures = {id(task): future for future in sent}
        return Parallel(
            -1,
            backend=backend,
            return_as="generator_unordered",
            batch_size=1,
            pre_dispatch=in_flight,
        )

    def explain(error: Exception) -> Exception:
        return _explained(error, client, address)

    return Pool(sum(client.ncores().values()), parallel, explain)


def _explained(error: Exception, client: Any, address: str) -> Exception:
    from distributed import KilledWorker

    if client.status != "running":
        return SweepError(
            f"{address}: the Dask scheduler ended or cannot be reached any more; "
            "what is done is kept: start it again and repeat the command to go on"
        )
    if isinstance(error, KilledWorker | CancelledError | asyncio.CancelledError):
        return Lost()
    if isinstance(error, TimeoutError):
        return _no_worker(address)
    missing = _cause(error, ModuleNotFoundError)
    if isinstance(missing, ModuleNotFoundError):
        return SweepError(
            f"a worker of {address} lacks the package {missing.name}; "
            "install the same packages on all computers of the cluster"
        )
    return error


def _cause(error: BaseException | None, kind: type[BaseException]) -> BaseException | None:
    while error is not None and not isinstance(error, kind):
        error = error.__cause__ or error.__context__
    return error


def _first_line(error: Exception) -> str:
    return str(error).partition("\n")[0].rstrip(".")


class _Backend(DaskDistributedBackend):  # type: ignore[misc]
    """joblib's backend, which tells joblib of every piece that will not come."""

    def effective_n_jobs(self, n_jobs: int) -> int:
        # for one worker, joblib would do everything in this process
        return max(2, int(super().effective_n_jobs(n_jobs)))

    def submit(self, func: Any, callback: Callable[[Any], None]) -> Future[Any]:
        future: Future[Any] = super().submit(func, callback)
        future.add_done_callback(lambda done: _pass_on(done, callback))
        return future

    def retrieve_result_callback(self, out: Any) -> Any:
        if isinstance(out, BaseException):
            raise out
        results = super().retrieve_result_callback(out)
        if not all(isinstance(result, Done) for result in results):
            raise CancelledError  # joblib takes what Dask says of a cancelled piece for a result
        return results

    def start_call(self) -> None:
        super().start_call()
        self.client.loop.add_callback(self._watch)

    def abort_everything(self, ensure_ready: bool = True) -> None:
        super().abort_everything(ensure_ready)
        with suppress(Exception):  # where there is no scheduler, there is nothing to cancel
            self.client.cancel(list(self._results))

    async def _watch(self) -> None:
        """Give up where all workers are gone and none comes: Dask would wait for ever."""
        seen = monotonic()
        while self._continue and self.client.status == "running":
            with suppress(OSError):
                if await self.client.nthreads():
                    seen = monotonic()
            if monotonic() - seen > ABSENCE_SECONDS and self._results:
                next(iter(self._results.values())).set_exception(TimeoutError())
                return
            await asyncio.sleep(1.0)


def _pass_on(future: Future[Any], callback: Callable[[Any], None]) -> None:
    error = future.exception()
    if error is not None:
        callback(error)


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
