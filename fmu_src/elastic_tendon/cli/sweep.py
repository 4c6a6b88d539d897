"""The command that does something many times: simulate, fit, diagnose; here or on a cluster."""

from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

import elastic_tendon as et
from elastic_tendon.cli.pace import pace
from elastic_tendon.cli.reading import read_all, read_motion, reading, words
from elastic_tendon.cli.shared import (
    INTERRUPTED,
    EffectOption,
    ForceOption,
    InterfaceOption,
    ModelArgument,
    app,
    check_outputs,
    load,
    notice,
    output,
    reporting,
    save_picture,
)
from elastic_tendon.progress import Progress
from elastic_tendon.sweeps import FEWEST_REFITS, WAIT

if TYPE_CHECKING:
    import pandas as pd

DRAWN_RUNS = 1000  # of simulations, where their number is not given
REFITS = 200  # of a bootstrap


class Work(StrEnum):
    """What is done in each run."""

    SIMULATE = "simulate"
    FIT = "fit"
    DIAGNOSE = "diagnose"


OutputOption = Annotated[
    Path,
    typer.Option(
        *("--output", "-o"), metavar="RUNS.csv|.parquet", help="Table of results to write."
    ),
]
DataArgument = Annotated[
    list[str] | None,
    typer.Argument(
        metavar="[DATA...]", help="Recordings; of a fleet a file or folder for each robot."
    ),
]
WorkOption = Annotated[
    Work,
    typer.Option("--do", help="In each run: simulate, refit (bootstrap), or diagnose a robot."),
]
VaryOption = Annotated[
    list[str] | None,
    typer.Option(
        "--vary",
        metavar="PATH=...",
        help="A parameter of model.toml: PATH by its uncertainty, PATH=5% Gaussian of that sigma, "
        "PATH=LOW:HIGH or PATH=-5%:5% uniform, PATH=LOW:HIGH:COUNT or PATH=A,B,C these values; "
        "repeatable. Without: all that stands in \\[uncertainty].",
    ),
]
MethodOption = Annotated[
    Literal["grid", "monte-carlo", "latin-hypercube", "sobol"] | None,
    typer.Option(help="Without: a grid where all that varies has values, else monte-carlo."),
]
RunsOption = Annotated[
    int | None,
    typer.Option(
        min=1,
        help=f"Without: {DRAWN_RUNS} simulations, {REFITS} refits; of those {FEWEST_REFITS} at "
        "least, 1000 for two digits of an interval.",
    ),
]
SeedOption = Annotated[
    int | None, typer.Option(min=0, help="Of what is drawn; the same seed gives the same.")
]
KeepOption = Annotated[
    list[str] | None,
    typer.Option("--keep", metavar="OUTPUT", help="An output to keep; repeatable."),
]
TrajectoriesOption = Annotated[
    bool, typer.Option("--trajectories", help="Keep every sample, not statistics of them.")
]
WorkersOption = Annotated[
    int | None, typer.Option(min=1, help="Without: all cores of this machine.")
]
SchedulerOption = Annotated[
    str | None,
    typer.Option(metavar="ADDRESS", help="Use the workers of this Dask scheduler, tcp://..."),
]
SchedulerFileOption = Annotated[
    Path | None,
    typer.Option(metavar="F", help="File that the Dask scheduler wrote, instead of its address."),
]
WaitOption = Annotated[
    float | None,
    typer.Option(
        min=0.0, metavar="SECONDS", help=f"For a worker of the cluster; without: {WAIT:g}."
    ),
]
PartsOption = Annotated[
    str | None,
    typer.Option(
        metavar="URL",
        help="Folder or object store (s3://...) that all workers see: they write results there.",
    ),
]
ShardOption = Annotated[
    str | None,
    typer.Option(metavar="K/N", help="Do the K-th of N shares of the runs, as of a job array."),
]
JoinOption = Annotated[
    bool, typer.Option("--join", help="Put the shares together that --shard has done.")
]
RetryOption = Annotated[
    bool, typer.Option("--retry-failed", help="Do the runs again that failed before.")
]
AboutOption = Annotated[
    Path | None,
    typer.Option(
        metavar="F.csv",
        help="What is known of the robots: a column robot, others of numbers or dates; what grows "
        "with them is told.",
    ),
]
PlotOption = Annotated[
    Path | None,
    typer.Option("--plot", metavar="F", help="Draw the results (.png, .svg...)."),
]


@dataclass(frozen=True)
class Request:
    """What shall be done in the runs, as the options say it; None or empty where they do not."""

    work: Work
    data: tuple[str, ...]
    vary: tuple[str, ...]
    method: Literal["grid", "monte-carlo", "latin-hypercube", "sobol"] | None
    runs: int | None
    seed: int | None
    keep: tuple[str, ...]
    trajectories: bool

    def check(self) -> None:
        """Refuse, as wrong usage, options that say nothing of this work, or not enough."""
        simulated = ("vary", "method", "keep", "trajectories")
        idle = {Work.SIMULATE: (), Work.FIT: simulated, Work.DIAGNOSE: (*simulated, "runs", "seed")}
        for name in idle[self.work]:
            given = getattr(self, name)
            if not (given is None or given is False or given == ()):
                refusal = f"says nothing where --do is {self.work}"
                raise typer.BadParameter(refusal, param_hint=f"--{name}")
        if self.work is not Work.SIMULATE and not self.data:
            raise typer.BadParameter(f"--do {self.work} needs recordings", param_hint="DATA")
        if self.work is Work.SIMULATE and len(self.data) > 1:
            raise typer.BadParameter("one motion is simulated; name one file", param_hint="DATA")
        if self.work is Work.FIT and self.runs is not None and self.runs < FEWEST_REFITS:
            fault = f"an interval of 95 % needs {FEWEST_REFITS} refits"
            raise typer.BadParameter(fault, param_hint="--runs")

    def task(self, model: "et.Model", options: "et.ReadOptions", progress: "Progress") -> "et.Task":
        """The runs, ready to be done."""
        if self.work is Work.SIMULATE:
            return _simulations(self, model, options, progress)
        if self.work is Work.DIAGNOSE:
            return _fleet(self, model, options)
        from elastic_tendon.sweeps.bootstrap import bootstrap

        measurements = read_all(model, self.data, options, progress)
        return bootstrap(
            *(model, measurements), runs=self.runs or REFITS, seed=self.seed or 0, progress=progress
        )


@app.command()
@reporting
@reading
def sweep(
    model: ModelArgument,
    out: OutputOption,
    data: DataArgument = None,
    work: WorkOption = Work.SIMULATE,
    vary: VaryOption = None,
    method: MethodOption = None,
    runs: RunsOption = None,
    seed: SeedOption = None,
    keep: KeepOption = None,
    trajectories: TrajectoriesOption = False,
    workers: WorkersOption = None,
    scheduler: SchedulerOption = None,
    scheduler_file: SchedulerFileOption = None,
    wait: WaitOption = None,
    parts: PartsOption = None,
    shard: ShardOption = None,
    join: JoinOption = False,
    retry_failed: RetryOption = False,
    about: AboutOption = None,
    *,
    options: "et.ReadOptions",
    own_effects: EffectOption = None,
    interface: InterfaceOption = None,
    plot: PlotOption = None,
    force: ForceOption = False,
) -> None:
    """Do something many times, on all cores or a cluster: simulate, refit, diagnose a fleet.

    A sweep that is stopped goes on where it was if you type the same command again. A run that
    fails is recorded with the reason, and the others go on. The same seed gives the same file, with
    any number of workers. More --runs of a finished sweep are added to its table.

    A cluster needs the extra cluster, a "dask scheduler" on one computer and, on each, "dask worker
    tcp://HOST:8786 --nworkers 8 --nthreads 1".
    """
    drawn = (tuple(vary or ()), method, runs, seed)
    request = Request(work, tuple(data or ()), *drawn, tuple(keep or ()), trajectories)
    request.check()
    clusters = [given for given in (scheduler, scheduler_file) if given is not None]
    if workers is not None and clusters:
        raise typer.BadParameter("the cluster has workers of its own", param_hint="--workers")
    if len(clusters) > 1:
        raise typer.BadParameter("give the address or the file", param_hint="--scheduler")
    if wait is not None and not clusters:
        raise typer.BadParameter("says nothing without a cluster", param_hint="--wait")
    if about is not None and work is not Work.DIAGNOSE:
        raise typer.BadParameter("says nothing without a fleet", param_hint="--about")
    share = _share(shard)
    if share is not None and (join or plot is not None):
        raise typer.BadParameter("a share has no table yet: leave --join and --plot out")
    goes_on = out.exists() and (retry_failed or runs is not None)
    told = [] if about is None else [f"{about}"]
    check_outputs(out, picture=plot, force=force or goes_on, read=[model, *request.data, *told])
    if plot is not None:
        check_outputs(picture=plot, force=force)
    if not request.data and words(options):
        raise typer.BadParameter(f"no DATA to read: leave {words(options)[0]} out")
    loaded = load(model, own_effects, interface)
    try:
        with pace() as progress:
            task = request.task(loaded, options, progress)
            progress.runs = task.runs
            if about is not None:
                _check_about(about, task)
            done = et.sweep(
                *(task, out),
                workers=workers,
                scheduler=scheduler,
                scheduler_file=scheduler_file,
                wait=WAIT if wait is None else wait,
                parts=parts,
                shard=share,
                join=join,
                retry_failed=retry_failed,
                force=force,
                progress=progress,
            )
    except KeyboardInterrupt:
        _stopped(out)
    if shard is not None:
        sentence = f"Share {shard} is done, {done.failed} failed; when all are, repeat with --join."
        output.print(sentence, highlight=False, markup=False)
        return
    _show(work, loaded, task, out, done, about)
    if plot is not None:
        save_picture(done.plot(), plot, force)
    if done.failed == done.runs:
        raise typer.Exit(1)


def _share(text: str | None) -> tuple[int, int] | None:
    """``3/64`` as numbers."""
    if text is None:
        return None
    number, slash, count = text.partition("/")
    if not (slash and number.isdecimal() and count.isdecimal()):
        raise typer.BadParameter(f"{text} is no share; write K/N, as 3/64", param_hint="--shard")
    return int(number), int(count)


def _points(request: Request, model: "et.Model") -> "et.Points":
    """What varies, and how; what cannot be read or drawn is wrong usage."""
    from elastic_tendon.sweeps.factors import parse_factor, stated_factors
    from elastic_tendon.sweeps.points import default_method, points

    hint = "--vary"
    try:
        factors = [parse_factor(model, text) for text in request.vary] or stated_factors(model)
        hint = "--vary, --method and --runs"
        method = request.method or default_method(factors, request.runs)
        count = request.runs if request.runs is not None or method == "grid" else DRAWN_RUNS
        return points(factors, method, count, request.seed or 0)
    except et.SweepError as error:
        raise typer.BadParameter(str(error), param_hint=hint) from None


def _simulations(
    request: Request, model: "et.Model", options: "et.ReadOptions", progress: "Progress"
) -> "et.Task":
    from elastic_tendon.native.library import library_path
    from elastic_tendon.sweeps import simulations as module

    points = _points(request, model)
    library_path(*model.structure, progress)
    motion = module.default_motion(model)
    if request.data:
        motion = module.measured_motion(
            model, read_motion(model, request.data[0], options, progress)
        )
    try:
        return module.simulations(
            *(model, points),
            motion=motion,
            outputs=request.keep or None,
            keep="trajectories" if request.trajectories else "statistics",
        )
    except et.SweepError as error:
        raise typer.BadParameter(str(error), param_hint="--keep") from None


def _fleet(request: Request, model: "et.Model", options: "et.ReadOptions") -> "et.Task":
    from elastic_tendon.sweeps.fleet import robots_of

    robots = robots_of(request.data)
    for robot in robots:
        if len(robot.data) > 1:
            advice = (
                f"its {len(robot.data)} recordings are taken together; else name them one by one"
            )
            notice.print(f"note: {robot.name} is one robot, and {advice}", markup=False)
    return et.fleet(model, robots, options)


def _check_about(about: Path, task: "et.Task") -> None:
    """Before robots are diagnosed, for hours may be."""
    from elastic_tendon.sweeps.fleet import Fleet
    from elastic_tendon.sweeps.fleet_findings import known_of

    if isinstance(task, Fleet):
        known_of([robot.name for robot in task.robots], about)


def _stopped(out: Path) -> None:
    """Say where the work is that was done before the user stopped it."""
    from elastic_tendon.sweeps.parts import folder_of

    folder = folder_of(out)
    kept = f"what was done is in {folder}; the same command goes on from there"
    outcome = kept if folder.is_dir() else "nothing was written"
    notice.print(f"elastic-tendon: stopped, {outcome}", markup=False, soft_wrap=True)
    raise typer.Exit(INTERRUPTED)


def _show_fleet(model: "et.Model", robots: "pd.DataFrame", about: Path | None) -> None:
    """The answer in words, robot by robot, and what the robots share."""
    from elastic_tendon.reports.fleet_tables import pooled_table, robots_table

    found = et.fleet_findings(model, robots, about)
    output.print(found.summary(), highlight=False, markup=False)
    output.print(robots_table(model, robots))
    if found.pooled:
        output.print(pooled_table(found))


def _show(
    work: Work,
    model: "et.Model",
    task: "et.Task",
    out: Path,
    done: "et.Swept",
    about: Path | None,
) -> None:
    from elastic_tendon.reports import sweep_tables as words
    from elastic_tendon.sweeps.bootstrap import Bootstrap, intervals
    from elastic_tendon.sweeps.results import read_fleet
    from elastic_tendon.sweeps.summary import summarise

    summary = summarise(out)
    if work is Work.DIAGNOSE:
        _show_fleet(model, read_fleet(out), about)
    elif isinstance(task, Bootstrap):
        output.print(words.bootstrap_table(intervals(task, done.to_dataframe())))
    else:
        units = {quantity.path: quantity.unit for quantity in model.quantities()}
        output.print(words.statistics_table(summary, units))
    output.print(words.done_sentence(done), highlight=False, markup=False)
    for sentence in words.failure_sentences(summary, reasons=work is not Work.DIAGNOSE):
        notice.print(sentence, markup=False, soft_wrap=True)
