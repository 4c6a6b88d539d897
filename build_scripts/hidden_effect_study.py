"""Which hidden effects a diagnosis finds, and what it blames that is not there.

    python build_scripts/hidden_effect_study.py [--cases N] [--seeds dev|report] [--jobs 2]

Recordings come from the independent simulator in tests/truth; the diagnosis gets the model without
the hidden effect and is never told. What is done is kept in a folder: interrupt and go on at will.
Nothing is ever tuned on the seeds of the report.
"""

import argparse
import sys
import time
from functools import partial
from pathlib import Path

# the truth simulator and the cases belong to the tests and are not installed
sys.path.append(str(Path(__file__).resolve().parents[1] / "tests"))

from platformdirs import user_cache_path

from benchmarking import Row, print_table
from hidden_effect.cases import Order
from hidden_effect.plan import orders
from hidden_effect.score import Figure, Result, consistent, figures
from hidden_effect.study import judged
from kept_answers import mapped

MOST_NAMED = 12  # misses of a row


def row_of(figure: Figure) -> Row:
    """A figure as a row of the table."""
    sign = {"high": "≥", "low": "≤", "": ""}[figure.best]
    target = f"{sign} {figure.target:g} {figure.unit}".strip() if sign else "reported"
    reached = f"{figure.value:.3g} {figure.unit} of {figure.count}" if figure.count else "no case"
    return Row(figure.what, reached.replace("  ", " "), target, figure.met)


def attempted(order: Order, folder: Path) -> tuple[str, Result | None, str]:
    """Name, result and fault of one case; a fault of one does not end the study."""
    try:
        return order.name, judged(order, folder), ""
    except Exception as fault:
        return order.name, None, f"{type(fault).__name__}: {fault}"


def report(found: list[Result], absent: list[str], faults: list[str]) -> int:
    """Print the table, the misses by name, and the cases that could not be judged; exit status."""
    table = [*figures(found), consistent(found)]
    status = print_table(f"Hidden effects, {len(found)} cases", [row_of(row) for row in table])
    print("\nMissed")
    for row in table:
        if row.missed and row.target is not None:
            more = len(row.missed) - MOST_NAMED
            tail = [f"... and {more} more"] if more > 0 else []
            print(f"  {row.what}", *row.missed[:MOST_NAMED], *tail, sep="\n    ")
    print(f"\n{len(absent)} cases cannot be: their effect does not show in their experiment")
    for name in absent[:MOST_NAMED]:
        print(f"    {name}")
    if faults:
        print(f"\n{len(faults)} cases failed", *faults, sep="\n    ")
    return status


def main() -> int:
    """Run what is not yet done and print the table; exit status 1 where a target is missed."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--cases", type=int, default=1, help="for each cell")
    parser.add_argument("--seeds", choices=("dev", "report"), default="dev")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--only", default="", help="cases whose name holds this")
    parser.add_argument("--most", type=int, default=None, help="number of cases")
    parser.add_argument(
        "--folder", type=Path, default=user_cache_path("elastic-tendon-study"),
        help="where cases and results are kept",
    )  # fmt: skip
    chosen = parser.parse_args()
    wanted = [
        order
        for order in orders(chosen.cases, chosen.seeds == "report")
        if chosen.only in order.name
    ][: chosen.most]
    found: list[Result] = []
    absent: list[str] = []
    faults: list[str] = []
    begin = time.monotonic()
    try:
        for number, (name, result, fault) in enumerate(
            mapped(partial(attempted, folder=chosen.folder), wanted, chosen.jobs), start=1
        ):
            if fault:
                faults.append(f"{name}: {fault}")
            elif result is None:
                absent.append(name)
            else:
                found.append(result)
            elapsed = time.monotonic() - begin
            print(f"\r{number} of {len(wanted)}, {elapsed:.0f} s  ", end="", file=sys.stderr)
    except KeyboardInterrupt:
        print("\ninterrupted; what is done is kept", file=sys.stderr)
    return report(found, absent, faults)


if __name__ == "__main__":
    sys.exit(main())
