"""Whether a thousand cores stay busy: costs that are measured here, in a simulation of who waits.

    python build_scripts/benchmark_cluster.py [--quick]

A Dask scheduler on this machine deals out pieces of which nothing is to be done: client and
scheduler are all that takes time then, and this is what a piece costs them. The simulation has a
thousand cores, each of which asks for a piece when it has done one, and one server that takes so
long for each, with the lengths of pieces that the product's own tuning chooses. Results go to a
shared store (`--parts`); who puts them together takes the time a run that is measured here too.

Where a core has only some seconds to do, the scheduler decides: at 5 ms a piece the last of a
thousand cores begins after 5 s. A million runs of 20 ms, 20 s of a core, then keep them 79 % busy
and never could more than 89 %; ten times as many keep them 94 % busy.
"""

import argparse
import heapq
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmark_sweep import WORKERS, Busy, cluster
from benchmarking import Row, at_least, at_most, print_table, seconds, spoken
from elastic_tendon.sweeps.cluster import DEALING, Lengths
from elastic_tendon.sweeps.execution import Cluster, execute
from elastic_tendon.sweeps.fingerprint import fingerprint
from elastic_tendon.sweeps.sweep import sweep
from elastic_tendon.sweeps.work import Order, Ranges

CORES = 1000
RUN = 1.0  # s
SCATTER = 0.3  # of a run's time, one sigma of its logarithm
RUNS = 10**8
SHORT_RUN, SHORT_RUNS = 0.02, 10**7  # s
BUSY, LONGER = 80.0, 1.3  # %, times the ideal
MOST_PIECE = 1e3 * DEALING  # ms, which the lengths of pieces count on
MOST_ROW = 27.0  # µs, what a row of CSV cost the client before workers wrote parts


@dataclass(frozen=True)
class Outcome:
    """`busy` : share of the cores' time that went into runs, %; `total` : s from start to end."""

    busy: float
    total: float


def simulated(runs: int, cores: int, cost: float, run: float = RUN, seed: int = 0) -> Outcome:
    """A sweep on so many cores.

    Parameters
    ----------
    runs, cores : how many
    cost : s that client and scheduler need for a piece, one after the other
    run : s of a run, in the mean; it scatters by `SCATTER`
    """
    random = np.random.default_rng(seed)
    pieces, lengths = Ranges([(0, runs)], 1, tuned=True), Lengths()
    asking = [(0.0, core) for core in range(cores)]  # when each core asks for a piece
    served = worked = end = 0.0
    deviation = np.sqrt(np.exp(SCATTER**2) - 1.0)
    while asking:
        now, core = heapq.heappop(asking)
        lengths.tune(pieces, cores)
        piece = next(pieces, None)
        if piece is None:
            continue
        count = piece[1] - piece[0]
        served = max(served, now) + cost
        duration = run * max(count + deviation * np.sqrt(count) * random.standard_normal(), 0.1)
        lengths.learn(piece, (0, b"", 0, duration))
        worked += duration
        end = max(end, served + duration)
        heapq.heappush(asking, (served + duration, core))
    return Outcome(100.0 * worked / (cores * end), end)


def cost_of_a_piece(count: int) -> float:
    """Time that client and scheduler need for a piece of which nothing is to be done, s."""
    with cluster() as address:
        order = Order(Busy(count, 0.0), ".csv", fingerprint())
        pieces = Ranges([(0, count)], 1)
        done = execute(order, pieces, Cluster(address))
        next(done)  # the start-up is over by then
        return seconds(lambda: sum(1 for _ in done)) / (count - 1)


def cost_of_a_row(count: int) -> float:
    """Time that a row of Parquet takes where parts are written and put together, s."""

    def swept(rows: int) -> float:
        with tempfile.TemporaryDirectory() as work:
            target = Path(work) / "runs.parquet"
            return seconds(lambda: sweep(Busy(rows, 0.0), target, workers=1, batch=1000))

    return (swept(2 * count) - swept(count)) / count  # without what a sweep takes to begin


def rows(quick: bool) -> list[Row]:
    """Costs, and what a thousand cores make of them; `quick` has fewer pieces and runs."""
    piece = cost_of_a_piece(300 if quick else 3000)
    writing = cost_of_a_row(20_000 if quick else 200_000)
    runs = RUNS // 100 if quick else RUNS
    found = simulated(runs, CORES, piece)
    total, ideal = found.total + runs * writing, runs * RUN / CORES
    what = f"{runs:.0e} runs of {spoken(RUN)} on {CORES} cores"
    beside = f"{total:.0f} s, of which {runs * writing:.0f} s are putting together"
    return [
        at_most(f"client and scheduler a piece, {WORKERS} workers", 1e3 * piece, MOST_PIECE, "ms"),
        at_most("a row of Parquet", 1e6 * writing, MOST_ROW, "µs"),
        at_least(f"{what}: busy", found.busy, BUSY, "%"),
        at_most(f"{what}: time / ideal", total / ideal, LONGER, "", beside),
        at_least(
            f"{SHORT_RUNS:.0e} of {spoken(SHORT_RUN)}: busy",
            simulated(SHORT_RUNS, CORES, piece, SHORT_RUN).busy,
            *(BUSY, "%"),
        ),
    ]


def main() -> int:
    """Print the table; exit status."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="a hundredth of the runs")
    return print_table("A thousand cores", rows(parser.parse_args().quick))


if __name__ == "__main__":
    sys.exit(main())
