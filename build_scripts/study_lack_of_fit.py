"""How often what remains of an error is called significant: with an unknown effect, and by chance.

    python build_scripts/study_lack_of_fit.py [--cases 6] [--ratio 3] [--seeds dev|report]

The base model is refitted to recordings of machines with an effect that is not in the catalogue,
and of machines in which nothing is missing, with every kind of noise. Cases, refits and results are
kept: interrupt and go on at will.
"""

import pickle
import sys
import time
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import TypeVar

# the truth simulator and the cases belong to the tests and are not installed
sys.path.append(str(Path(__file__).resolve().parents[1] / "tests"))

from benchmarking import Row, at_least, at_most, print_table
from elastic_tendon.diagnosis.lack_of_fit import regress
from elastic_tendon.estimation.fit import FitResult, fit
from hidden_effect import motions
from hidden_effect.cases import FIRST_REPORTED_SEED, Order, UnreachableError, build
from hidden_effect.recordings import NOISES
from hidden_effect.study import written
from kept_answers import (
    SIGNAL,
    Content,
    collected,
    kept,
    parser_of,
    print_columns,
    print_faults,
)
from truth.outside import OTHER_LAWS, OUTSIDE

FOUND_TARGET, CHANCE_TARGET = 90.0, 5.0  # %
NOTHING = 4  # cases of every noise in which nothing is missing, for each one of an unknown

Made = TypeVar("Made")


def orders(cases: int, ratio: float, reported: bool) -> Iterator[Order]:
    """Every unknown with white noise, and every noise with nothing hidden."""
    first = FIRST_REPORTED_SEED if reported else 0
    for seed in range(first, first + cases):
        kind = motions.RICH[seed % 2]
        for family, laws in (("outside", OUTSIDE), ("other law", OTHER_LAWS)):
            for law in laws:
                yield Order(family, (law,), ratio, kind, "white", seed)
    for seed in range(NOTHING * first, NOTHING * (first + cases)):
        for noise in NOISES:
            yield Order("nothing", (), 0.0, motions.RICH[seed % 2], noise, seed)


def pickled(path: Path, make: Callable[[], Made]) -> Made:
    """An object that takes long to make, from disk where it is kept there."""
    if path.exists():
        found: Made = pickle.loads(path.read_bytes())
        return found
    made = make()
    written(path, pickle.dumps(made))
    return made


def refitted(order: Order) -> tuple[FitResult, float]:
    """The base model refitted to a case, and its noise, rad RMS."""
    case = build(order)
    return fit(case.given, case.fit), case.facts.floor[SIGNAL]


def judged(order: Order, folder: Path) -> Content:
    """The row of one case, from disk where it is kept there."""
    return kept(folder / "results" / f"{order.name}.json", partial(row_of, order, folder))


def row_of(order: Order, folder: Path) -> Content:
    """What is said of what remains."""
    row: Content = {"name": order.name, "what": order.effects[0] if order.effects else order.noise}
    row["hidden"] = bool(order.effects)
    try:
        result, noise = pickled(folder / "refits" / f"{order.name}.pickle", lambda: refitted(order))
    except UnreachableError:
        return row | {"reached": False}
    begin = time.perf_counter()
    found = regress(result).found[SIGNAL]
    return row | {
        "reached": True,
        "ratio": float(result.problem.errors(result.vector)[0][SIGNAL].std() / noise),
        "p_value": found.p_value,
        "significant": found.significant,
        "explains": found.explains,
        "variables": "+".join(found.variables),
        "seconds": time.perf_counter() - begin,
    }


def line_of(row: Content) -> list[str]:
    """A row as text."""
    return [
        row["name"],
        "found" if row["significant"] else "",
        f"{row['ratio']:.2f}",
        f"{row['p_value']:.4f}",
        f"{row['explains']:.2f}",
        row["variables"],
        f"{row['seconds']:.1f}",
    ]


def rate(rows: list[Content]) -> float:
    """Percentage called significant."""
    return 100.0 * sum(bool(row["significant"]) for row in rows) / len(rows)


def figures(rows: list[Content]) -> list[Row]:
    """Rates of every unknown and every noise beside their targets."""
    found = []
    for hidden in (True, False):
        some = [row for row in rows if row["hidden"] == hidden]
        for what in sorted({str(row["what"]) for row in some}):
            own = [row for row in some if row["what"] == what]
            found.append(_beside_target(f"{what} ({len(own)})", rate(own), hidden))
        if some:
            word = "all unknown effects" if hidden else "nothing missing, all noises"
            found.append(_beside_target(f"{word} ({len(some)})", rate(some), hidden))
    seconds = sum(row["seconds"] for row in rows) / len(rows)
    return [*found, Row("time", f"{seconds:.2f} s")]


def _beside_target(name: str, value: float, hidden: bool) -> Row:
    if hidden:
        return at_least(name, value, FOUND_TARGET, "%")
    return at_most(name, value, CHANCE_TARGET, "%")


def main() -> int:
    """Run what is not yet done and print the table; exit status 1 where a target is missed."""
    parser = parser_of(__doc__, "elastic-tendon-study-lack-of-fit")
    parser.add_argument("--cases", type=int, default=6, help="of every unknown")
    parser.add_argument("--ratio", type=float, default=3.0, help="of effect to noise, R")
    chosen = parser.parse_args()
    every = orders(chosen.cases, chosen.ratio, chosen.seeds == "report")
    wanted = [order for order in every if chosen.only in order.name]
    rows, faults = collected(wanted, partial(judged, folder=chosen.folder), chosen.jobs)
    rows = sorted((row for row in rows if row["reached"]), key=lambda row: str(row["name"]))
    print_columns([["case", "", "error/noise", "p", "explains", "by", "s"], *map(line_of, rows)])
    print_faults(faults)
    return print_table(f"What remains, {len(rows)} cases", figures(rows)) if rows else 1


if __name__ == "__main__":
    sys.exit(main())
