"""How long reading, comparing and locating a large recording take, and how much memory.

    python build_scripts/benchmark_reading.py [--rows N]

Writes a recording of N rows (10⁶ unless said otherwise) into a temporary folder and measures, in a
process each: pandas reading the file, the product reading it, comparing it with BioRob-X4 joint 3,
and locating the error. The target for all three: no longer than three times pandas reading and the
simulation itself. Then it reads a window of a recording of ten times as many rows, for the memory
that this takes.
"""

import argparse
import resource
import sys
import tempfile
import time
from collections.abc import Callable
from multiprocessing import get_context
from pathlib import Path
from typing import TypeVar

import numpy as np

from benchmarking import Row, at_most, print_table

MODEL = "biorob_x4_joint_3"
STEP = 1e-3  # s
CHUNK = 100_000  # rows written at once
MEBIBYTE = 2**20
REPETITIONS = 3  # the shortest counts

Result = TypeVar("Result")


def write_recording(path: Path, rows: int) -> None:
    """A motion with noise, in chunks: time, motor and joint position."""
    rng = np.random.default_rng(7)
    with path.open("w", encoding="utf-8") as file:
        file.write("time_s,motor_position_rad,joint_position_rad\n")
        for first in range(0, rows, CHUNK):
            t = STEP * np.arange(first, min(first + CHUNK, rows))
            motor = 0.3 * np.sin(2.0 * np.pi * 0.5 * t)
            joint = motor + 1e-3 * rng.standard_normal(t.size)
            np.savetxt(file, np.column_stack([t, motor, joint]), fmt="%.6f", delimiter=",")


def by_pandas(path: str) -> float:
    """Seconds in which pandas reads the file."""
    import pandas as pd

    begin = time.perf_counter()
    pd.read_csv(path)
    return time.perf_counter() - begin


def by_product(path: str) -> tuple[float, float, float, float]:
    """Seconds for reading, comparing, locating, and for the simulation that comparing has to do."""
    from elastic_tendon.actuator.parameters import load_model
    from elastic_tendon.comparison.compare import compare
    from elastic_tendon.comparison.locate import locate
    from elastic_tendon.comparison.residuals import simulate_measurement
    from elastic_tendon.measurement import read_measurement

    model = load_model(MODEL)
    warm = read_measurement(f"{path}[0:1]")  # compiles and imports what the first use needs
    locate(compare(model, [warm]))
    begin = time.perf_counter()
    measurement = read_measurement(path)
    middle = time.perf_counter()
    comparison = compare(model, [measurement])
    compared = time.perf_counter()
    locate(comparison)
    end = time.perf_counter()
    simulate_measurement(model, measurement, comparison.files[0].initial_state)
    simulated = time.perf_counter()
    return middle - begin, compared - middle, end - compared, simulated - end


def window_memory(path: str) -> float:
    """MiB by which reading a window of a large file raises the peak memory."""
    import pandas  # noqa: F401 - not part of what reading takes

    from elastic_tendon.measurement import read_measurement

    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    read_measurement(f"{path}[100:200]")
    # kilobytes on Linux
    return (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) * 1024 / MEBIBYTE


def alone(function: Callable[[str], Result], path: Path) -> Result:
    """What the function says in a process of its own, so that no measurement helps another."""
    with get_context("spawn").Pool(1) as pool:
        return pool.apply(function, (str(path),))


def rows_of(path: Path, large: Path) -> list[Row]:
    """The table of times and of memory."""
    pandas = min(alone(by_pandas, path) for _ in range(REPETITIONS))
    runs = [alone(by_product, path) for _ in range(REPETITIONS)]
    reading, comparing, locating, simulating = min(runs, key=lambda run: sum(run[:3]))
    ratio = (reading + comparing + locating) / (pandas + simulating)
    return [
        Row("pandas reads", f"{pandas:.3g} s"),
        Row("the product reads", f"{reading:.3g} s"),
        Row("compares", f"{comparing:.3g} s"),
        Row("of which the simulation", f"{simulating:.3g} s"),
        Row("locates", f"{locating:.3g} s"),
        at_most("all three, times pandas and the simulation", ratio, 3.0, ""),
        at_most("memory for 100 s of ten times the rows", alone(window_memory, large), 200, "MiB"),
    ]


def main() -> int:
    """Print the table; exit status."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--rows", type=int, default=1_000_000, help="of the recording (10⁶)")
    rows: int = parser.parse_args().rows
    with tempfile.TemporaryDirectory() as work:
        path, large = (Path(work) / f"{name}.csv" for name in ("recording", "large"))
        write_recording(path, rows)
        write_recording(large, 10 * rows)
        return print_table(f"Reading, comparing and locating {rows} rows", rows_of(path, large))


if __name__ == "__main__":
    sys.exit(main())
