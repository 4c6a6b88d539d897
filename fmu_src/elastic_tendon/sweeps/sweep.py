"""A sweep: many runs, on all cores or on a cluster, which may be stopped and gone on with."""

from collections.abc import Callable
from contextlib import closing
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from elastic_tendon.errors import SweepError
from elastic_tendon.measurement.formats.base import silent
from elastic_tendon.result import Result
from elastic_tendon.sweeps.execution import Cluster, Local, Place, execute
from elastic_tendon.sweeps.parts import add, alone, check_output, done_before, finish, open_parts
from elastic_tendon.sweeps.results import read_results
from elastic_tendon.sweeps.task import TEXTS, Task


@dataclass(frozen=True, repr=False)
class Swept(Result):
    """What a sweep gave.

    Parameters
    ----------
    path : table of results, one row for each run
    runs : how many there are
    failed : how many of them failed; the last column of the table says why
    resumed : how many had been done before, by a sweep that was stopped
    """

    path: Path
    runs: int
    failed: int
    resumed: int

    def summary(self) -> str:
        """Where the table is, and how many runs it holds."""
        before = f", {self.resumed} of them done before" if self.resumed else ""
        return f"{self.path}: {self.runs} runs{before}, {self.failed} failed"

    def to_dataframe(self) -> pd.DataFrame:
        """The table of results, a row for each run."""
        return read_results(self.path, TEXTS)

    def to_dict(self) -> dict[str, Any]:
        """As the attributes say."""
        return asdict(self) | {"path": str(self.path)}


def sweep(
    task: Task,
    output: Path | str,
    *,
    workers: int | None = None,
    scheduler: str | None = None,
    batch: int | None = None,
    force: bool = False,
    progress: Callable[[str, float], None] = silent,
) -> Swept:
    """Do all runs of a task and write their results to a file.

    What is done is kept in the folder `output`.parts until all is done. A sweep that was stopped,
    by Ctrl-C or otherwise, goes on where it stopped when it is asked for again. The file is the
    same whatever the workers, the batches and the interruptions. A run that fails, or that ends
    its process, is recorded with the reason and does not end the sweep.

    Parameters
    ----------
    task : what is done, such as `simulations` and `fleet` make it
    output : file for the results, .csv or .parquet (extra `formats`)
    workers : number of processes, or of threads where the runs are C; all cores if not given
    scheduler : address of a Dask scheduler, whose workers are used instead (extra `cluster`)
    batch : number of runs that are done and kept at once; by default what the task finds best;
        a sweep that goes on keeps the batch with which it began
    force : whether an existing output is replaced, and parts of another sweep are removed
    progress : called with what is done, in words and as a share from 0 to 1

    Returns
    -------
    Swept

    Raises
    ------
    OutputError : the output exists and `force` is not given, it is neither CSV nor Parquet, or
        it cannot be written (full disk); what is done is kept
    SweepError : there are parts of another sweep, another sweep writes this output now, there is
        nothing to do, or the cluster cannot be reached, has no workers, or lacks this package
    KeyboardInterrupt : the workers are stopped, what is done is kept

    """
    output = Path(output)
    _check(task, workers, batch)
    check_output(output, force=force)
    with alone(output):
        parts = open_parts(task, output, batch, force=force)
        before = done_before(parts)
        missing = [piece for piece in parts.pieces if piece not in before]
        resumed = sum(stop - start for start, stop in before)
        count, failed = resumed, sum(before.values())
        if missing:
            place = _place(workers, scheduler, len(missing))
            with closing(execute(task, missing, place)) as results:
                for done in results:
                    failed += add(parts, done)
                    count += done.stop - done.start
                    progress(f"{count} of {task.runs} runs, {failed} failed", count / task.runs)
        finish(parts, force=force)
    return Swept(output, task.runs, failed, resumed)


def _check(task: Task, workers: int | None, batch: int | None) -> None:
    for name, number in (("workers", workers), ("runs in a batch", batch)):
        if number is not None and number < 1:
            raise SweepError(f"the number of {name} is {number}; give 1 or more")
    if task.runs < 1:
        raise SweepError("the sweep has no runs; give it at least one")


def _place(workers: int | None, scheduler: str | None, pieces: int) -> Place:
    if scheduler is not None:
        return Cluster(scheduler)
    from joblib import cpu_count

    return Local(max(1, min(workers or cpu_count(), pieces)))
