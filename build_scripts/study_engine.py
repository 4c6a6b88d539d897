"""Whether the diagnosis finds what hides in machines that MuJoCo plays.

    python build_scripts/study_engine.py [--seeds dev|report] [--rounds N] [--jobs 2] [--only NAME]

MuJoCo shares no law, integrator or author with the product; see tests/engine. An answer is right
when it names what hides and its error is at most 1.1 times the noise, or, where the catalogue lacks
the law, when it says so. Results are kept: interrupt and go on at will.
"""

import sys
from dataclasses import asdict
from functools import partial
from pathlib import Path

# the machines belong to the tests and are not installed
sys.path.append(str(Path(__file__).resolve().parents[1] / "tests"))

from benchmarking import Row, at_least, print_table
from engine.cases import Case, Order, build, orders
from kept_answers import (
    UNEXPLAINED,
    Content,
    asked,
    collected,
    kept,
    parser_of,
    print_columns,
    print_faults,
)

TARGET = 95.0  # %


def judged(order: Order, folder: Path) -> Content:
    """The row of one case, from disk where it is kept there."""
    return kept(folder / f"{order.name}.json", lambda: row_of(build(order)))


def row_of(case: Case) -> Content:
    """What the tool says of a case, and whether that is right."""
    said = asked(case.given, case.fit, case.validation)
    named = frozenset(said.named)
    return asdict(said) | {
        "name": case.name,
        "hidden": case.hidden,
        "accepted": sorted(sorted(answer) for answer in case.accepted),
        "unknown": case.unknown,
        "floor": case.floor_rmse,
        "right": case.right(said.verdict, named, said.error),
        "names_right": case.names_right(said.verdict, named),
    }


def line_of(row: Content) -> list[str]:
    """A row as text."""
    right = "right" if row["right"] else "named" if row["names_right"] else "WRONG"
    return [
        row["name"],
        row["hidden"],
        row["verdict"],
        "+".join(row["named"]) or "none",
        f"{row['error'] / row['floor']:.3f}",
        f"{row['seconds']:.0f}",
        right,
    ]


def figures(rows: list[Content]) -> list[Row]:
    """Shares of right answers."""
    groups = {
        "right, all": rows,
        "  of the catalogue": [r for r in rows if r["hidden"] != "nothing" and not r["unknown"]],
        "  nothing hidden": [r for r in rows if r["hidden"] == "nothing"],
        "  outside the catalogue": [r for r in rows if r["unknown"]],
    }
    found = [
        at_least(f"{what} ({len(of)})", 100.0 * sum(r["right"] for r in of) / len(of), TARGET, "%")
        for what, of in groups.items()
        if of
    ]
    blamed = [r for r in rows if r["unknown"] and r["verdict"] not in UNEXPLAINED]
    return [*found, Row("outside the catalogue, something named", f"{len(blamed)} cases")]


def main() -> int:
    """Run what is not yet done and print the table; exit status 1 where a target is missed."""
    parser = parser_of(__doc__, "elastic-tendon-study-engine")
    parser.add_argument("--rounds", type=int, default=1, help="seeds of each machine")
    parser.add_argument("--hidden-only", action="store_true", help="no machine without its effect")
    chosen = parser.parse_args()
    every = orders(chosen.seeds == "report", chosen.rounds, bare=not chosen.hidden_only)
    wanted = [order for order in every if chosen.only in order.name]
    rows, faults = collected(wanted, partial(judged, folder=chosen.folder), chosen.jobs)
    rows.sort(key=lambda row: str(row["name"]))
    heads = ["case", "hidden", "verdict", "named", "error/noise", "s", ""]
    print_columns([heads, *map(line_of, rows)])
    print_faults(faults)
    return print_table(f"Machines of MuJoCo, {len(rows)} cases", figures(rows)) if rows else 1


if __name__ == "__main__":
    sys.exit(main())
