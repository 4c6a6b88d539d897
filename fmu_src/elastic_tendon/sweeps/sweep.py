"""A sweep: many runs, on all cores or on a cluster, which may be stopped and gone on with."""

import json
from collections.abc import Mapping
from contextlib import closing
from dataclasses import dataclass, field, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

import pandas as pd

from elastic_tendon.actuator.parameters import Model
from elastic_tendon.errors import SweepError
from elastic_tendon.measurement import Measurement
from elastic_tendon.progress import Progress, silent
from elastic_tendon.result import Result
from elastic_tendon.sweeps import WAIT
from elastic_tendon.sweeps.execution import Cluster, Local, Place, execute
from elastic_tendon.sweeps.fingerprint import fingerprint
from elastic_tendon.sweeps.finished import drop_failed, runs_in, take_apart
from elastic_tendon.sweeps.fleet import Fleet
from elastic_tendon.sweeps.parts import (
    Parts,
    add,
    alone,
    check_output,
    done_before,
    finish,
    forget,
    missing,
    open_parts,
)
from elastic_tendon.sweeps.points import Points
from elastic_tendon.sweeps.points import vary as points_of
from elastic_tendon.sweeps.results import read_fleet, read_results
from elastic_tendon.sweeps.simulations import Motion, Simulations, measured_motion, simulations
from elastic_tendon.sweeps.store import store_of
from elastic_tendon.sweeps.task import TEXTS, Task
from elastic_tendon.sweeps.work import Order, Piece, Ranges

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, repr=False)
class Swept(Result):
    """What a sweep gave.

    Parameters
    ----------
    task : what was done
    path : of the table of results, one row for each run; None where no file was asked for
    failed : how many runs failed; the last column of the table says why
    resumed : how many had been done before, by a sweep that was stopped
    table : the results, where there is no file of them
    """

    task: Task
    path: Path | None
    failed: int
    resumed: int
    table: pd.DataFrame = field(default_factory=pd.DataFrame, compare=False)

    @property
    def runs(self) -> int:
        """How many there are."""
        return self.task.runs

    def summary(self) -> str:
        """How many runs there were, and where their table is."""
        before = f", {self.resumed} of them done before" if self.resumed else ""
        where = "" if self.path is None else f"; results in {self.path}"
        return f"Sweep of {self.runs} runs{before}, {self.failed} failed{where}"

    def to_dataframe(self) -> pd.DataFrame:
        """The table of results, a row for each run."""
        return self.table if self.path is None else read_results(self.path, TEXTS)

    def to_dict(self) -> dict[str, Any]:
        """How many runs there were, and where their table is."""
        path = None if self.path is None else str(self.path)
        return {"path": path} | {
            name: getattr(self, name) for name in ("runs", "failed", "resumed")
        }

    def plot(self) -> "Figure":
        """Draw the results.

        Of simulations the statistics of each output over what varied, or the trajectories over
        time; of a fleet what moved in each robot; of other tasks how each number is distributed.

        Raises
        ------
        SweepError : all runs failed
        """
        if self.failed == self.runs:
            raise SweepError("all runs failed: there is nothing to draw; the table says why")
        from elastic_tendon.reports.sweep_figures import sweep_figure

        if self.path is not None and isinstance(self.task, Fleet):
            return sweep_figure(self.task, read_fleet(self.path))
        return sweep_figure(self.task, self.to_dataframe())


@dataclass(frozen=True)
class _Wanted:
    """How a task is to be done, see `sweep`."""

    place: Place
    batch: int | None
    parts: str | None
    shard: tuple[int, int] | None
    join: bool
    retry_failed: bool
    force: bool


def sweep(
    task: Task | Model,
    output: Path | str | None = None,
    *,
    vary: Mapping[str, str | None] | None = None,
    runs: int | None = None,
    seed: int = 0,
    motion: Motion | Measurement | None = None,
    workers: int | None = None,
    scheduler: str | None = None,
    scheduler_file: Path | str | None = None,
    client: Any = None,
    wait: float = WAIT,
    parts: Path | str | None = None,
    shard: tuple[int, int] | None = None,
    join: bool = False,
    retry_failed: bool = False,
    batch: int | None = None,
    force: bool = False,
    progress: Progress = silent,
) -> Swept:
    """Simulate a model many times with other parameters, or do all runs of a task, into a table.

    ``et.sweep(model, vary={"link.inertia": "5%"}, runs=200)`` varies a parameter, and
    ``et.sweep(model, runs=200)`` all whose uncertainty the model states.

    What is done is kept in the folder `output`.parts until all is done. A sweep that was stopped,
    by Ctrl-C or otherwise, goes on where it stopped when it is asked for again; one that is
    finished goes on where more runs are asked for, if what is drawn allows it. The file is the
    same whatever the workers, the batches and the interruptions. A run that fails, or that ends
    its process, is recorded with the reason and does not end the sweep. Where a computer is at
    fault (no compiler, full disk, other code), the run is done elsewhere.

    Parameters
    ----------
    task : Model, whose simulations are summarised in a row each; or what is done, such as
        `simulations` and `fleet` make it
    output : file for the results, .csv or .parquet (extra `formats`); None: the results are kept
        in memory, and what is done is lost when the sweep is stopped
    vary : of a model: what varies, and how, as the `spreads` of `vary`
    runs : of a model: how many, as in `vary`
    seed : of a model: another one draws other numbers
    motion : of a model: of all runs, or a recording, whose motor motion and load are simulated
    workers : number of processes, or of threads where the runs are C; all cores if not given
    scheduler : address of a Dask scheduler, whose workers are used instead (extra `cluster`)
    scheduler_file : that a Dask scheduler has written, instead of its address
    client : a `distributed.Client` instead; it stays open
    wait : for a first worker of a cluster, and for another one when all have left, s
    parts : folder or URL (fsspec) that all computers see, into which workers write what is done;
        without, it comes back and is kept beside the output
    shard : (k, n): do the k-th of n shares of the runs (k from 1), and leave the table to `join`
    join : put the shares together, and do nothing else
    retry_failed : do runs again that failed, of a table that is finished as well
    batch : number of runs that are done and kept at once; by default what the task finds best,
        and on a cluster some 10 s of work or more
    force : whether an existing output is replaced, and parts of another sweep are removed
    progress : called with what is done, in words and as a share from 0 to 1

    Returns
    -------
    Swept; of a shard without a table

    Raises
    ------
    OutputError : the output exists and `force` is not given, it is neither CSV nor Parquet, or
        it cannot be written (full disk); what is done is kept
    SweepError : there are parts of another sweep, another sweep writes this output now, there is
        nothing to do, what varies cannot be read, runs could not be done anywhere, or the cluster
        cannot be reached, has no workers, or lacks this package
    KeyboardInterrupt : the workers are stopped, what is done is kept

    """
    if isinstance(task, Model):
        task = _simulations(task, points_of(task, vary, runs=runs, seed=seed), motion)
    elif any((vary, runs, seed)) or motion is not None:
        raise SweepError("a task says itself what varies, how often and how it moves")
    place = _place(workers, scheduler, scheduler_file, client, wait)
    _check(task, workers, batch, shard)
    where = None if parts is None else str(parts)
    wanted = _Wanted(place, batch, where, shard, join, retry_failed, force)
    if output is not None:
        return _sweep(task, Path(output), wanted, progress)
    if shard is not None or join or retry_failed:
        raise SweepError("shards, their join and a repetition need an output; name a file")
    with TemporaryDirectory() as folder:
        swept = _sweep(task, Path(folder) / "runs.csv", wanted, progress)
        return replace(swept, path=None, table=swept.to_dataframe())


def _sweep(task: Task, output: Path, wanted: _Wanted, progress: Progress) -> Swept:
    apart = output.exists() and not wanted.force and _goes_on(task, output, wanted)
    check_output(output, force=wanted.force or apart)
    share = _share(task.runs, wanted.shard)
    name = "" if wanted.shard is None else ".{}-of-{}".format(*wanted.shard)
    with alone(output, name):
        store = None if wanted.parts is None else store_of(wanted.parts)
        parts = open_parts(task, output, store=store, share=share, force=wanted.force)
        order = Order(task, output.suffix, fingerprint(), store)
        try:
            if apart:
                plain = replace(order, store=None)
                take_apart(plain, output, parts, without_failed=wanted.retry_failed)
            elif wanted.retry_failed:
                drop_failed(parts)
            failed, resumed = _do(order, parts, wanted, progress)
        except BaseException:
            forget(parts)
            raise
        if wanted.shard is not None:
            return Swept(task, None, failed, resumed)
        finish(parts, force=wanted.force or apart)
    return Swept(task, output, failed, resumed)


def _do(order: Order, parts: Parts, wanted: _Wanted, progress: Progress) -> tuple[int, int]:
    """Do what is missing; how many runs failed, and how many had been done before."""
    before = done_before(parts)
    gaps = missing(parts.share, before)
    resumed = sum(stop - start for start, stop in before)
    count, failed, total = resumed, sum(before.values()), parts.share[1] - parts.share[0]
    if not gaps or wanted.join:
        return failed, resumed
    batch = wanted.batch or max(1, order.task.batch())
    pieces = Ranges(gaps, batch, tuned=wanted.batch is None)
    place = _no_more_than(wanted.place, -(-pieces.left // batch))

    def said() -> str:
        return f"{count} of {total} runs, {failed} failed"

    def tell(text: str) -> None:
        progress(f"{said()}; {text}", count / total)

    with closing(execute(order, pieces, place, tell)) as results:
        for done in results:
            failed += add(parts, done)
            count += done.stop - done.start
            progress(said(), count / total)
    return failed, resumed


def _goes_on(task: Task, output: Path, wanted: _Wanted) -> bool:
    """Whether a finished table is to have more runs, or its failed ones done again."""
    if wanted.shard is not None or wanted.join:
        return False
    count = runs_in(output)
    return 0 < count < task.runs or (wanted.retry_failed and count == task.runs)


def _share(runs: int, shard: tuple[int, int] | None) -> Piece:
    number, count = shard or (1, 1)
    return runs * (number - 1) // count, runs * number // count


def _simulations(model: Model, points: Points, motion: Motion | Measurement | None) -> Simulations:
    if isinstance(motion, Measurement):
        motion = measured_motion(model, motion)
    return simulations(model, points, motion=motion)


def _check(
    task: Task, workers: int | None, batch: int | None, shard: tuple[int, int] | None
) -> None:
    for name, number in (("workers", workers), ("runs in a batch", batch)):
        if number is not None and number < 1:
            raise SweepError(f"the number of {name} is {number}; give 1 or more")
    if task.runs < 1:
        raise SweepError("the sweep has no runs; give it at least one")
    if shard is not None and not 1 <= shard[0] <= shard[1] <= task.runs:
        raise SweepError(
            f"there is no shard {shard[0]} of {shard[1]} of {task.runs} runs; shards count from 1, "
            "and each has a run at least"
        )


def _place(
    workers: int | None,
    scheduler: str | None,
    scheduler_file: Path | str | None,
    client: Any,
    wait: float,
) -> Place:
    if sum(given is not None for given in (workers, scheduler, scheduler_file, client)) > 1:
        raise SweepError("give workers, a scheduler, its file or a client, and not several of them")
    if scheduler_file is not None:
        scheduler = _address_in(Path(scheduler_file))
    if scheduler is not None or client is not None:
        return Cluster(scheduler, client, wait)
    from joblib import cpu_count

    return Local(workers or cpu_count())


def _no_more_than(place: Place, pieces: int) -> Place:
    return Local(max(1, min(place.workers, pieces))) if isinstance(place, Local) else place


def _address_in(file: Path) -> str:
    try:
        return str(json.loads(file.read_text())["address"])
    except (OSError, ValueError, KeyError, TypeError):
        raise SweepError(
            f"{file}: no Dask scheduler has written this file; give what was named in "
            "`dask scheduler --scheduler-file`"
        ) from None
