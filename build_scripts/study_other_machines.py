"""Whether the diagnosis is right on seven kinds of machine that are no tendon arms.

    python build_scripts/study_other_machines.py [--seeds dev|report] [--jobs 2] [--only KIND]

Recordings come from tests/truth/other_machines.py; see other_machines/cases.py. Results are kept:
interrupt and go on at will.
"""

import sys
from dataclasses import asdict
from functools import partial
from pathlib import Path
from statistics import median

# the truth simulator and the cases belong to the tests and are not installed
sys.path.append(str(Path(__file__).resolve().parents[1] / "tests"))

from benchmarking import Row, at_least, print_table
from kept_answers import (
    SIGNAL,
    Content,
    asked,
    collected,
    kept,
    parser_of,
    print_columns,
    print_faults,
)
from other_machines.cases import Order, made, orders

TARGET = 95.0  # %, of cases in which nothing wrong is named


def judged(order: Order, folder: Path) -> Content:
    """The row of one case, from disk where it is kept there."""
    return kept(folder / f"{order.name}.json", lambda: row_of(order))


def row_of(order: Order) -> Content:
    """What the tool says of a case, beside the facts."""
    case = made(order)
    said = asked(case.given, case.recordings)
    noises = [part.for_model(case.given).noise[SIGNAL].sigma for part in case.recordings]
    return asdict(said) | {
        "name": order.name,
        "kind": order.kind,
        "hidden": order.hidden,
        "right": frozenset(said.named) in case.right,
        "ratio": said.error / median(noises),
    }


def line_of(row: Content) -> list[str]:
    """A row as text."""
    return [
        row["kind"],
        row["hidden"],
        row["verdict"],
        "+".join(row["named"]) or "none",
        f"{row['ratio']:.3g}",
        f"{row['seconds']:.0f}",
        "right" if row["right"] else "WRONG",
    ]


def main() -> int:
    """Run what is not yet done and print the table; exit status 1 where a target is missed."""
    chosen = parser_of(__doc__, "elastic-tendon-study-other-machines").parse_args()
    every = orders(reported=chosen.seeds == "report")
    wanted = [order for order in every if chosen.only in order.name]
    rows, faults = collected(wanted, partial(judged, folder=chosen.folder), chosen.jobs)
    rows.sort(key=lambda row: str(row["name"]))
    print_columns(
        [["kind", "hidden", "verdict", "named", "error/noise", "s", ""], *map(line_of, rows)]
    )
    print_faults(faults)
    if not rows:
        return 1
    share = 100.0 * sum(row["right"] for row in rows) / (len(rows) + len(faults))
    times = [float(row["seconds"]) for row in rows]
    return print_table(
        f"Machines of other kinds, {len(rows)} cases",
        [
            at_least("right", share, TARGET, "%"),
            Row("time: median, largest", f"{median(times):.0f}, {max(times):.0f} s"),
        ],
    )


if __name__ == "__main__":
    sys.exit(main())
