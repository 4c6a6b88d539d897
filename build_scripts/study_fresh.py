"""Whether the diagnosis names all of one to three hidden effects where every number is wrong.

    python build_scripts/study_fresh.py [--count 24] [--seeds dev|report] [--jobs 2] [--quick]

Machines come from the independent simulator in tests/truth; see hidden_effect/fresh.py. Cases and
results are kept: interrupt and go on at will.
"""

import pickle
import sys
from dataclasses import asdict
from functools import partial
from pathlib import Path
from statistics import median

# the truth simulator and the cases belong to the tests and are not installed
sys.path.append(str(Path(__file__).resolve().parents[1] / "tests"))

import numpy as np

from benchmarking import Row, at_least, print_table
from hidden_effect.fresh import FreshCase, FreshOrder, build_fresh, orders
from hidden_effect.study import written
from kept_answers import (
    Content,
    asked,
    collected,
    kept,
    parser_of,
    print_columns,
    print_faults,
)

AT_NOISE, AT_NOISE_TARGET = 1.05, 97.0  # error over noise, %
NAMED_TARGET = 95.0  # %


def case_of(order: FreshOrder, folder: Path, quick: bool) -> FreshCase:
    """The case, from disk where it is kept there: it takes longer to make than to judge."""
    path = folder / "cases" / f"{order.name}.pickle"
    if path.exists():
        found: FreshCase = pickle.loads(path.read_bytes())
        return found
    case = build_fresh(order, judge=not quick)
    written(path, pickle.dumps(case))
    return case


def judged(order: FreshOrder, folder: Path, quick: bool) -> Content:
    """The row of one case, from disk where it is kept there."""
    path = folder / "results" / f"{order.name}.json"
    return kept(path, lambda: row_of(case_of(order, folder, quick)))


def row_of(case: FreshCase) -> Content:
    """What the tool says of a case, beside the facts."""
    said, facts = asked(case.given, case.fit, case.validation), case.facts
    return asdict(said) | {
        "name": case.order.name,
        "noise": case.order.noise,
        "validation": bool(case.validation),
        "hidden": sorted(facts.hidden),
        "ratios": facts.ratios,
        "alternatives": sorted(sorted(alternative) for alternative in facts.alternatives),
        "floor": facts.floor,
    }


def exact(row: Content) -> bool:
    """Whether exactly the hidden effects are named."""
    return bool(row["named"] == row["hidden"])


def of_class(row: Content) -> bool:
    """Whether the named effects are the hidden ones or explain the recording as well."""
    return exact(row) or row["named"] in row["alternatives"]


def ratio(row: Content) -> float:
    """Error over noise."""
    return float(row["error"] / row["floor"])


def line_of(row: Content) -> list[str]:
    """A row as text."""
    return [
        row["name"],
        "+".join(row["hidden"]),
        row["verdict"],
        "+".join(row["named"]) or "none",
        f"{ratio(row):.3f}",
        f"{row['seconds']:.0f}",
        "exact" if exact(row) else "alias" if of_class(row) else "WRONG",
        " | ".join("+".join(alternative) or "none" for alternative in row["alternatives"]),
    ]


def share(rows: list[Content], met: list[bool]) -> float:
    """Percentage that is met."""
    return 100.0 * sum(met) / len(rows)


def figures(rows: list[Content]) -> list[Row]:
    """Shares beside their targets, and times."""
    decidable = [row for row in rows if not row["alternatives"]]
    reached = share(rows, [ratio(row) <= AT_NOISE for row in rows])
    found = [at_least(f"error ≤ {AT_NOISE} noise ({len(rows)})", reached, AT_NOISE_TARGET, "%")]
    if decidable:
        named = share(decidable, [exact(row) for row in decidable])
        what = f"exactly the hidden effects, decidable ({len(decidable)})"
        found.append(at_least(what, named, NAMED_TARGET, "%"))
    found.append(
        Row("the hidden effects or an alias", f"{share(rows, list(map(of_class, rows))):.3g} %")
    )
    for count in (1, 2, 3):
        some = [row for row in decidable if len(row["hidden"]) == count]
        if some:
            text = f"{share(some, [exact(row) for row in some]):.3g} % of {len(some)}"
            found.append(Row(f"  exact, {count} hidden, decidable", text))
    for noise in sorted({float(row["noise"]) for row in rows}):
        some = [row for row in rows if row["noise"] == noise]
        text = f"{share(some, [ratio(row) <= AT_NOISE for row in some]):.3g} % of {len(some)}"
        found.append(Row(f"  at the noise, {1e6 * noise:g} µrad", text))
    times = [float(row["seconds"]) for row in rows]
    spread = f"{median(times):.1f}, {np.quantile(times, 0.95):.1f}, {max(times):.1f} s"
    return [*found, Row("time: median, 95 %, largest", spread)]


def main() -> int:
    """Run what is not yet done and print the table; exit status 1 where a target is missed."""
    parser = parser_of(__doc__, "elastic-tendon-study-fresh")
    parser.add_argument("--count", type=int, default=24, help="machines")
    parser.add_argument(
        "--quick", action="store_true", help="aliases from a list, not by refits that take minutes"
    )
    chosen = parser.parse_args()
    folder = chosen.folder / ("quick" if chosen.quick else "refitted")
    every = orders(chosen.seeds == "report", chosen.count)
    wanted = [order for order in every if chosen.only in order.name]
    rows, faults = collected(
        wanted, partial(judged, folder=folder, quick=chosen.quick), chosen.jobs
    )
    rows.sort(key=lambda row: str(row["name"]))
    heads = ["case", "hidden", "verdict", "named", "error/noise", "s", "", "alternatives"]
    print_columns([heads, *map(line_of, rows)])
    print_faults(faults)
    return print_table(f"Fresh machines, {len(rows)} cases", figures(rows)) if rows else 1


if __name__ == "__main__":
    sys.exit(main())
