"""All benchmarks against what people would use instead, in one table.

    python build_scripts/benchmark_all.py [--quick] [--only WORD]

Every ratio is of two times taken in this run, side by side; beside it stand the times, as median
with least and most where one number would mislead. Wants a machine that does nothing else.
`--quick` has fewer runs and repetitions.
"""

import argparse
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import benchmark_arm
import benchmark_cluster
import benchmark_fit
import benchmark_fmpy
import benchmark_fmu
import benchmark_simulate
import benchmark_startup
import benchmark_sweep
from benchmarking import Row, print_provenance, print_rows


@dataclass(frozen=True)
class Group:
    """Rows under a heading, and how they are measured."""

    title: str
    measure: Callable[[], list[Row]]


def export(quick: bool) -> list[Row]:
    """Time of an export."""
    with tempfile.TemporaryDirectory() as work:
        return benchmark_fmu.export_rows(Path(work), everywhere=not quick)


def groups(quick: bool) -> list[Group]:
    """All of them, in the order of the table."""
    return [
        Group("Simulation of 12 s at 500 Hz against scipy", benchmark_simulate.rows),
        Group("Many simulations against scipy", partial(benchmark_sweep.scipy_rows, quick)),
        Group(
            "3 s at 500 Hz through the FMU, by fmpy.simulate_fmu with a reused instance",
            partial(benchmark_fmpy.rows, repetitions=2 if quick else 5),
        ),
        Group("Sensitivities of 12 s at 500 Hz", benchmark_fit.sensitivity_rows),
        Group("A fit", benchmark_fit.fit_rows),
        Group("A diagnosis", benchmark_fit.demo_rows),
        Group("Export", partial(export, quick)),
        Group(
            "Sweeps of simulations of 1 s, statistics to CSV",
            partial(benchmark_sweep.sweep_rows, quick),
        ),
        Group("A thousand cores", partial(benchmark_cluster.rows, quick)),
        Group("Actuators of an arm, a step of 1 ms", benchmark_arm.rows),
        Group("A diagnosis where nothing was compiled", benchmark_startup.refit_rows),
        Group("Start-up", partial(benchmark_startup.process_rows, 5 if quick else 20)),
    ]


def main() -> int:
    """Print the table; exit status 1 where a target is missed, or no heading has the word."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="fewer runs and repetitions")
    parser.add_argument(
        "--only", default="", metavar="WORD", help="groups with this in the heading"
    )
    arguments = parser.parse_args()
    quick: bool = arguments.quick
    word: str = arguments.only.lower()
    chosen = [group for group in groups(quick) if word in group.title.lower()]
    if not chosen:
        print(f"no heading has {word!r} in it", file=sys.stderr)
        return 1
    print_provenance()
    status = 0
    for group in chosen:
        print(f"\n{group.title}")
        status |= print_rows(group.measure())
    return status


if __name__ == "__main__":
    sys.exit(main())
