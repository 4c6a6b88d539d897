"""What the benchmark scripts share: a row with its target, the table, and where it was measured."""

import platform
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib.metadata import version


@dataclass(frozen=True)
class Row:
    """One figure beside its target; `met` is None where the figure is only reported."""

    what: str
    figure: str
    target: str = "reported"
    met: bool | None = None


def at_most(what: str, value: float, limit: float, unit: str = "") -> Row:
    """Row whose figure must not exceed a limit."""
    return Row(what, f"{value:.3g} {unit}".strip(), f"≤ {limit:g} {unit}".strip(), value <= limit)


def at_least(what: str, value: float, limit: float, unit: str = "") -> Row:
    """Row whose figure must reach a limit."""
    return Row(what, f"{value:.3g} {unit}".strip(), f"≥ {limit:g} {unit}".strip(), value >= limit)


def fastest(call: Callable[[], object], repetitions: int) -> float:
    """Shortest wall-clock time of several calls, s; the first, untimed call warms up."""
    call()
    times = []
    for _ in range(repetitions):
        begin = time.perf_counter()
        call()
        times.append(time.perf_counter() - begin)
    return min(times)


def _commit() -> str:
    run = subprocess.run(
        ["git", "describe", "--always", "--dirty"], capture_output=True, text=True, check=False
    )
    return run.stdout.strip() or "unknown"


def _processor() -> str:
    try:
        with open("/proc/cpuinfo") as lines:
            return next(line.split(":")[1].strip() for line in lines if "model name" in line)
    except (OSError, StopIteration):
        return platform.processor()


def print_table(title: str, rows: Sequence[Row]) -> None:
    """Print the rows and what they were measured with."""
    packages = ("numpy", "scipy", "casadi", "fmpy", "ziglang")
    print(f"\n{title}")
    print(
        f"{_processor()}, Python {platform.python_version()}, commit {_commit()}, "
        + ", ".join(f"{name} {version(name)}" for name in packages)
    )
    width = max(len(row.what) for row in rows)
    for row in rows:
        verdict = {None: "", True: "met", False: "MISSED"}[row.met]
        print(f"  {row.what:<{width}}  {row.figure:>14}  {row.target:>14}  {verdict}")
    sys.stdout.flush()
