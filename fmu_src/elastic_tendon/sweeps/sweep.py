"""A sweep: many runs, on all cores or on a cluster, which may be stopped and gone on with."""

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
from elastic_tendon.sweeps.execution import Cluster, Local, Place, execute
from elastic_tendon.sweeps.parts import add, alone, check_output, done_before, finish, open_parts
from elastic_tendon.sweeps.points import Points
from elastic_tendon.sweeps.points import vary as points_of
from elastic_tendon.sweeps.results import read_results
from elastic_tendon.sweeps.simulations import Motion, Simulations, measured_motion, simulations
from elastic_tendon.sweeps.task import TEXTS, Task

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

        return sweep_figure(self.task, self.to_dataframe())


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
    batch: int | None = None,
    force: bool = False,
    progress: Progress = silent,
) -> Swept:
    """Simulate a model many times with other parameters, or do all runs of a task, into a table.

    ``et.sweep(model, vary={"link.inertia": "5%"}, runs=200)`` varies a parameter, and
    ``et.sweep(model, runs=200)`` all whose uncertainty the model states.

    What is done is kept in the folder `output`.parts until all is done. A sweep that was stopped,
    by Ctrl-C or otherwise, goes on where it stopped when it is asked for again. The file is the
    same whatever the workers, the batches and the interruptions. A run that fails, or that ends
    its process, is recorded with the reason and does not end the sweep.

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
        nothing to do, what varies cannot be read, or the cluster cannot be reached, has no
        workers, or lacks this package
    KeyboardInterrupt : the workers are stopped, what is done is kept

    """
    if isinstance(task, Model):
        task = _simulations(task, points_of(task, vary, runs=runs, seed=seed), motion)
    elif any((vary, runs, seed)) or motion is not None:
        raise SweepError("a task says itself what varies, how often and how it moves")
    if output is None:
        with TemporaryDirectory() as folder:
            kept = Path(folder) / "runs.csv"
            swept = sweep(
                *(task, kept),
                workers=workers,
                scheduler=scheduler,
                batch=batch,
                progress=progress,
            )
            return replace(swept, path=None, table=swept.to_dataframe())
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
    return Swept(task, output, failed, resumed)


def _simulations(model: Model, points: Points, motion: Motion | Measurement | None) -> Simulations:
    if isinstance(motion, Measurement):
        motion = measured_motion(model, motion)
    return simulations(model, points, motion=motion)


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
