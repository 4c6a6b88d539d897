"""Whether the diagnosis is right on seven kinds of machine that are no tendon arms.

    python build_scripts/study_other_machines.py [--seeds dev|report] [--jobs 2] [--only KIND]
        [--keep]

Recordings come from tests/truth/other_machines.py; see other_machines/cases.py. Results are kept:
interrupt and go on at will. `--keep` runs nothing: it writes those on reporting seeds that are done
to other_machines.json beside this script, of which the site's page "Known machines" has a table.
"""

import json
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
from site_pages.known_machines import OTHER_KINDS

SHOWN = ("name", "kind", "hidden", "verdict", "named", "right", "ratio")
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


def keep(folder: Path) -> int:
    """Write the results on reporting seeds that are at hand for the site; the exit status."""
    paths = [folder / f"{order.name}.json" for order in orders(reported=True)]
    found = [json.loads(path.read_text("utf-8")) for path in paths if path.is_file()]
    rows = [
        {name: row[name] for name in SHOWN} | {"ratio": round(row["ratio"], 3)} for row in found
    ]
    lines = ",\n".join(f" {json.dumps(row)}" for row in rows)
    OTHER_KINDS.write_text(f"[\n{lines}\n]\n", "utf-8")
    print(f"{OTHER_KINDS}: {len(rows)} of {len(paths)}")
    return 0


def main() -> int:
    """Run what is not yet done and print the table; exit status 1 where a target is missed."""
    parser = parser_of(__doc__, "elastic-tendon-study-other-machines")
    parser.add_argument("--keep", action="store_true", help="write results for the site, run none")
    chosen = parser.parse_args()
    if chosen.keep:
        return keep(chosen.folder)
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
