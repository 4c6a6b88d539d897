"""What the benchmark scripts share: rows, ways to time, the table, and where it was measured.

A target that is missed makes the exit status of a benchmark or study 1, unless known_misses.toml
names it.
"""

import platform
import re
import subprocess
import sys
import time
import tomllib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

PACKAGES = (
    *("casadi", "fmpy", "pythonfmu", "numpy", "scipy", "pandas"),
    *("joblib", "distributed", "ziglang"),
)
KNOWN_MISSES = Path(__file__).with_name("known_misses.toml")
_COUNT = re.compile(r" \(\d+\)$")
UNITS = ((1.0, "s"), (1e-3, "ms"), (1e-6, "µs"), (1e-9, "ns"))


@dataclass(frozen=True)
class Row:
    """One figure beside its target; `met` is None where the figure is only reported.

    `beside` : what the figure is made of, such as the times of both sides of a ratio.
    """

    what: str
    figure: str
    target: str = "reported"
    met: bool | None = None
    beside: str = ""


def at_most(what: str, value: float, limit: float, unit: str = "", beside: str = "") -> Row:
    """Row whose figure must not exceed a limit."""
    met = value <= limit
    return Row(what, f"{value:.3g} {unit}".strip(), f"≤ {limit:g} {unit}".strip(), met, beside)


def at_least(what: str, value: float, limit: float, unit: str = "", beside: str = "") -> Row:
    """Row whose figure must reach a limit."""
    met = value >= limit
    return Row(what, f"{value:.3g} {unit}".strip(), f"≥ {limit:g} {unit}".strip(), met, beside)


# ---- times ---------------------------------------------------------------------------------------


def seconds(call: Callable[[], object]) -> float:
    """Wall-clock time of one call, s."""
    begin = time.perf_counter()
    call()
    return time.perf_counter() - begin


def in_turn(calls: Sequence[Callable[[], object]], repetitions: int) -> Array:
    """Wall-clock times (calls, repetitions), s, of calls that take turns.

    So whatever slows the machine for a while slows all of them. One untimed call of each warms up.
    """
    for call in calls:
        call()
    return np.array([[seconds(call) for call in calls] for _ in range(repetitions)]).T


def fastest(call: Callable[[], object], repetitions: int) -> float:
    """Shortest wall-clock time of several calls, s; the first, untimed call warms up."""
    return float(in_turn([call], repetitions).min())


def spoken(duration: float) -> str:
    """A time in s, with the unit that suits it."""
    scale, unit = next((scaled for scaled in UNITS if duration >= scaled[0]), UNITS[-1])
    return f"{duration / scale:.3g} {unit}"


def spread(durations: Array) -> str:
    """Median of some times in s, with the least and the most."""
    least, middle, most = (spoken(float(x)) for x in np.quantile(durations, (0.0, 0.5, 1.0)))
    return f"{middle} ({least} to {most})"


# ---- table ---------------------------------------------------------------------------------------


def _commit() -> str:
    run = subprocess.run(
        ["git", "describe", "--always", "--dirty"],
        cwd=Path(__file__).parent,
        capture_output=True,
        text=True,
        check=False,
    )
    return run.stdout.strip() or "unknown"


def _processor() -> str:
    try:
        with open("/proc/cpuinfo") as lines:
            return next(line.split(":")[1].strip() for line in lines if "model name" in line)
    except (OSError, StopIteration):
        return platform.processor()


def _version(package: str) -> str:
    try:
        return f"{package} {version(package)}"
    except PackageNotFoundError:  # of an extra
        return f"no {package}"


def known_misses(path: Path = KNOWN_MISSES) -> dict[str, str]:
    """Figures that are known to miss their target, by what they are of."""
    return tomllib.loads(path.read_text("utf-8"))


def print_rows(rows: Sequence[Row], known: Mapping[str, str] | None = None) -> int:
    """Print rows in columns.

    Parameters
    ----------
    rows : Row
    known : as from `known_misses`, which is asked where it is missing

    Returns
    -------
    int
        exit status: 1 where a target is missed that is not among the known misses
    """
    known = known_misses() if known is None else known
    width = max(len(row.what) for row in rows)
    for row in rows:
        line = f"  {row.what:<{width}}  {row.figure:>14}  {row.target:>14}  {_verdict(row, known)}"
        print(f"{line}  {row.beside}".rstrip())
    sys.stdout.flush()
    return int(any(row.met is False and _known(row, known) is None for row in rows))


def _known(row: Row, known: Mapping[str, str]) -> str | None:
    """The known figure of a row, whose name may end in the count of its cases."""
    return known.get(_COUNT.sub("", row.what))


def _verdict(row: Row, known: Mapping[str, str]) -> str:
    """Whether the target is met, and what is known of that."""
    if row.met is None:
        return " " * 6
    figure = _known(row, known)
    note = "" if figure is None else f" (known: {figure})"
    return f"{'met' if row.met else 'MISSED':6}{note}"


def print_provenance() -> None:
    """Print on what, and with what, the figures are measured."""
    print(f"{_processor()}, {platform.platform()}, Python {platform.python_version()}")
    print(f"commit {_commit()}, " + ", ".join(_version(name) for name in PACKAGES))


def print_table(title: str, rows: Sequence[Row]) -> int:
    """Print the rows and what they were measured with; exit status as of `print_rows`."""
    print(f"\n{title}")
    print_provenance()
    return print_rows(rows)
