"""Many simulations: against scipy, in memory, over their number, over cores, on a cluster.

    python build_scripts/benchmark_sweep.py [--quick]

Simulations are 1 s of the base model at 500 Hz with three numbers drawn within 20 %; in a sweep,
statistics of the three usual outputs of each run are written to a CSV file by one worker unless a
row says otherwise. Scipy simulates some of the same machines with the fastest of its methods and
tolerances whose error on the nominal one is at most 1e-7 rad; ours is far below that at the
tolerance chosen here, of which it says the error.
"""

import argparse
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd

from benchmark_simulate import Run, motor_motion, python_rates, scipy_fastest, scipy_run
from benchmarking import (
    Array,
    Row,
    at_least,
    at_most,
    print_table,
    seconds,
    spoken,
    spread,
)
from elastic_tendon.actuator.parameters import Model, load_model
from elastic_tendon.simulation.simulate import simulate, simulate_many
from elastic_tendon.sweeps.execution import Cluster, Local, Place, execute
from elastic_tendon.sweeps.factors import Factor, Uniform
from elastic_tendon.sweeps.fingerprint import fingerprint
from elastic_tendon.sweeps.formats import NUMBER, ROW_GROUP
from elastic_tendon.sweeps.points import Points, points
from elastic_tendon.sweeps.simulations import Motion, Simulations, simulations
from elastic_tendon.sweeps.sweep import sweep
from elastic_tendon.sweeps.task import FAILURE, RUN
from elastic_tendon.sweeps.work import Order, Ranges

MODEL = "biorob_x4_joint_3"
DURATION = 1.0  # s
TOLERANCE = 1e-6  # of ours; a smaller one only makes the error smaller
VARIED = ("transmission.pretension_force", "link.inertia", "link.damping")
SPREAD = 0.2  # of their values, to both sides
SLOWER = 500.0  # times than us, that scipy is to be
CALL = 1000  # runs in one call of the library
MACHINES = 20  # that scipy simulates
SUMMARISED = 50  # times as many runs as the largest sweep of these, for the summary's memory
SUMMARY = 300.0  # MB
BATCH_OF_MEMORY = 1000  # runs, so that all sizes of a sweep have the same batches
WORK = 0.05  # s of a run on a cluster
BATCH = 20  # of these
WORKERS = 2
PATIENCE = 60.0  # s for a cluster to start


# ---- simulations ---------------------------------------------------------------------------------


def drawn(model: Model, count: int) -> Points:
    """Machines around the model."""
    values = model.values()
    factors = [
        Factor(path, Uniform((1 - SPREAD) * values[path], (1 + SPREAD) * values[path]))
        for path in VARIED
    ]
    return points(factors, "monte-carlo", count, seed=1)


def task(count: int) -> Simulations:
    """So many simulations, as a task for `sweep`."""
    model = load_model(MODEL)
    motion = Motion(*motor_motion(measured=True, duration=DURATION))
    return simulations(model, drawn(model, count), motion=motion, tolerance=TOLERANCE)


def swept(count: int, workers: int = 1, batch: int | None = None, suffix: str = ".csv") -> float:
    """Time of a whole sweep, file and all, s."""
    with tempfile.TemporaryDirectory() as work:
        target = Path(work) / f"runs{suffix}"
        return seconds(lambda: sweep(task(count), target, workers=workers, batch=batch))


def in_calls(model: Model, count: int) -> float:
    """Mean time of a simulation, s, in calls of the library with `CALL` of them each."""
    machines, motion = drawn(model, count), motor_motion(measured=True, duration=DURATION)

    def call(first: int) -> None:
        numbers = dict(zip(VARIED, machines.rows(first, min(first + CALL, count)).T, strict=True))
        simulate_many(model, numbers, *motion, outputs=("joint_position",), tolerance=TOLERANCE)

    def every_call() -> None:
        for first in range(0, count, CALL):
            call(first)

    call(0)
    return seconds(every_call) / count


def scipy_times(model: Model, machines: int) -> tuple[Run, Array]:
    """Scipy's fastest accurate run of the model, and times of the same of other machines, s."""
    now, position = motor_motion(measured=True, duration=DURATION)
    exact = simulate(model, now, position, tolerance=1e-13)["joint_position"]
    best = scipy_fastest(python_rates(model, now, position, cubic=False), now, exact)
    times = []
    for numbers in drawn(model, machines).rows(0, machines):
        machine = model.with_values(dict(zip(VARIED, numbers.tolist(), strict=True)))
        rates = python_rates(machine, now, position, cubic=False)
        times.append(seconds(partial(scipy_run, rates, now, best.method, best.tolerance)))
    return best, np.array(times)


def own_error(model: Model) -> float:
    """Largest error of the nominal simulation, rad."""
    motion = motor_motion(measured=True, duration=DURATION)
    exact, ours = (simulate(model, *motion, tolerance=t) for t in (1e-13, TOLERANCE))
    return float(np.abs(ours["joint_position"] - exact["joint_position"]).max())


def peer_rows(count: int = 100_000, machines: int = MACHINES) -> list[Row]:
    """Scipy against calls of the library and against a whole sweep, per run and on one core."""
    model = load_model(MODEL)
    best, theirs = scipy_times(model, machines)
    peer = float(np.median(theirs))
    ours = {
        "in calls of the library": in_calls(model, count),
        "in a sweep to Parquet": swept(count, suffix=".parquet") / count,
        "in a sweep to CSV": swept(count) / count,
    }
    method = f"scipy {best.method} at {best.tolerance:g}: {spread(theirs)}, {best.error:.1g} rad"
    return [
        at_least(
            *(f"{count:.0e} simulations of 1 s {how}: solve_ivp / ours", peer / each, SLOWER, ""),
            f"{spoken(each)} a run, error {own_error(model):.1g} rad; {method}",
        )
        for how, each in ours.items()
    ]


def fresh_peak(work: str) -> float:
    """Largest memory of a new process that does some Python, MB; Linux tells it."""
    told = "[line.split()[1] for line in open('/proc/self/status') if line.startswith('VmHWM')]"
    run = subprocess.run(
        [sys.executable, "-c", f"{work}\nprint({told}[0])"],
        cwd=Path(__file__).parent,
        capture_output=True,
        text=True,
        check=True,
    )
    return int(run.stdout) / 1024


def summary_row(count: int) -> Row:
    """Memory of the summary of so many runs, of which Parquet holds the usual columns."""
    random = np.random.default_rng(1)
    with tempfile.TemporaryDirectory() as work:
        path = Path(work) / "runs.parquet"
        numbers = [name for name in task(1).rows(0, 1) if name not in (RUN, FAILURE)]
        table = pd.DataFrame(random.standard_normal((count, len(numbers))), columns=numbers)
        table.insert(0, RUN, np.arange(count))
        table[FAILURE] = ""
        table.to_parquet(path, row_group_size=ROW_GROUP // (NUMBER * table.shape[1]))
        del table
        summary = "from pathlib import Path\nfrom elastic_tendon.sweeps.summary import summarise"
        taken = fresh_peak(f"{summary}\nsummarise(Path({str(path)!r}))")
    return at_most(f"memory of the summary of {count:.0e} runs", taken, SUMMARY, "MB")


def memory_rows(counts: Sequence[int]) -> list[Row]:
    """Whether memory grows with the number of runs, from the first of them to the last."""
    if not Path("/proc/self/status").is_file():
        return [Row("memory of many runs", "not told here")]
    sweeping = "import benchmark_sweep as own\nown.swept({}, batch=own.BATCH_OF_MEMORY)"
    taken = [fresh_peak(sweeping.format(count)) for count in counts]
    name = (
        f"largest memory of {counts[-1]:.0e} runs / {counts[0]:.0e}, batches of {BATCH_OF_MEMORY}"
    )
    beside = ", ".join(f"{part:.0f} MB" for part in taken)
    summary = summary_row(SUMMARISED * counts[-1])
    return [at_most(name, taken[-1] / taken[0], 1.1, "", beside), summary]


def scaling_rows(counts: Sequence[int]) -> list[Row]:
    """Time of a run over the number of runs, start and end of the sweep included."""
    swept(counts[0])  # loads the library
    each = {count: swept(count) / count for count in counts}
    return [
        Row(f"{count:.0e} runs, one core", f"{1 / item:.3g} runs/s", beside=f"{spoken(item)} a run")
        for count, item in each.items()
    ]


def cores_rows(count: int = 200_000, repetitions: int = 2) -> list[Row]:
    """One worker against two, which are threads, in turn."""
    swept(CALL)  # loads the library
    times = np.array([[swept(count, workers) for workers in (1, 2)] for _ in range(repetitions)]).T
    one, two = times.min(axis=1)
    name = f"{count:.0e} runs: one core / two cores"
    return [at_least(name, one / two, 1.8, "", f"{spread(times[0])}; {spread(times[1])}")]


# ---- cluster -------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Busy:
    """Runs that keep a processor busy for a while, as a task for `sweep`."""

    runs: int
    each: float  # s of the processor

    identity = {"kind": "busy"}  # noqa: RUF012 - the protocol asks for no more
    threads = False

    def batch(self) -> int:
        """Never asked for: the pieces are given."""
        return BATCH

    def rows(self, start: int, stop: int) -> pd.DataFrame:
        """Spend the time; nothing comes of it."""
        for _ in range(start, stop):
            begin = time.thread_time()
            while time.thread_time() - begin < self.each:
                pass
        return self._table(start, stop, "")

    def failed(self, run: int, reason: str) -> pd.DataFrame:
        """One row."""
        return self._table(run, run + 1, reason)

    def _table(self, start: int, stop: int, reason: str) -> pd.DataFrame:
        return pd.DataFrame({RUN: np.arange(start, stop), FAILURE: [reason] * (stop - start)})


@contextmanager
def cluster() -> Iterator[str]:
    """Address of a Dask scheduler on this machine with `WORKERS` workers, all of them processes."""
    here = Path(__file__).parent  # where workers find the task
    environment = os.environ | {
        "PYTHONPATH": f"{here}{os.pathsep}{os.environ.get('PYTHONPATH', '')}"
    }
    with tempfile.TemporaryDirectory() as work:
        file = Path(work) / "scheduler.json"
        shared = ["--scheduler-file", str(file), "--no-dashboard"]
        commands = [
            ["distributed.cli.dask_scheduler", "--host", "127.0.0.1", "--port", "0", *shared],
            *[["distributed.cli.dask_worker", "--nthreads", "1", *shared]] * WORKERS,
        ]
        start = partial(
            subprocess.Popen,
            cwd=work,
            text=True,
            env=environment,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        processes: list[subprocess.Popen[str]] = []
        try:
            processes.extend(start([sys.executable, "-m", *command]) for command in commands)
            yield _address(file)
        finally:
            for process in reversed(processes):
                process.terminate()
            for process in processes:
                process.wait()


def _address(file: Path) -> str:
    """Wait for the scheduler and its workers."""
    from distributed import Client

    until = time.monotonic() + PATIENCE
    while not file.is_file() and time.monotonic() < until:
        time.sleep(0.05)
    with Client(scheduler_file=str(file), timeout=PATIENCE, set_as_default=False) as client:  # type: ignore[no-untyped-call]
        client.wait_for_workers(WORKERS, timeout=PATIENCE)
        return str(client.scheduler.address)


def steady(runs: int, each: float, place: Place) -> float:
    """Time from the first batch that is done to the last one, s: the start-up is over by then."""
    order = Order(Busy(runs, each), ".csv", fingerprint())
    pieces = Ranges([(0, runs)], BATCH)
    done = [time.perf_counter() for _ in execute(order, pieces, place)]
    return done[-1] - done[0]


def cluster_rows(runs: int = 1000, each: float = WORK, repetitions: int = 2) -> list[Row]:
    """Local processes against a Dask cluster of as many, in turn."""
    with cluster() as address:
        places: tuple[Place, Place] = (Local(WORKERS), Cluster(address))
        times = np.array(
            [[steady(runs, each, place) for place in places] for _ in range(repetitions)]
        ).T
    local, dask = times.min(axis=1)
    name = f"{runs} runs of {spoken(each)} in batches of {BATCH}: joblib's processes / Dask"
    return [at_least(name, local / dask, 0.9, "", f"{spread(times[0])}; {spread(times[1])}")]


# ---- all -----------------------------------------------------------------------------------------


def scipy_rows(quick: bool) -> list[Row]:
    """Scipy against many simulations, and their memory; `quick` has ten thousand."""
    count = 10_000 if quick else 100_000
    sizes = [size for size in (1_000, 10_000, 100_000) if size <= count]
    return [*peer_rows(count), *memory_rows(sizes)]


def sweep_rows(quick: bool) -> list[Row]:
    """Sweeps over their number of runs, over cores and on a cluster; `quick` ends sooner."""
    return [
        *scaling_rows([10**power for power in range(2, 5 if quick else 7)]),
        *cores_rows(20_000 if quick else 200_000, 1 if quick else 2),
        *cluster_rows(200 if quick else 1000, repetitions=1 if quick else 2),
    ]


def main() -> int:
    """Print the tables; exit status."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="ten thousand runs at most")
    quick: bool = parser.parse_args().quick
    return max(
        print_table("Many simulations against scipy", scipy_rows(quick)),
        print_table("Sweeps", sweep_rows(quick)),
    )


if __name__ == "__main__":
    sys.exit(main())
