"""Measure how often recordings are suspected of being misread, rightly and wrongly.

    python build_scripts/study_suspicions.py [--first SEED] [--count N]

Recordings come from the independent simulator in tests/truth. Of each seed there are two: one of a
machine that the model describes, and one with an effect at its typical strength that the model
lacks, held against a model that has both stiffnesses twice or the inertia three times too large, or
neither. Each is judged as it is (any suspicion is a false alarm) and misread in every way that
can show in it. By default the seeds apart from those with which the thresholds were chosen are
taken; 100 of them take half an hour.
"""

import argparse
import sys
import warnings
from collections import Counter
from pathlib import Path

# the truth simulator belongs to the tests and is not installed
sys.path.append(str(Path(__file__).resolve().parents[1] / "tests"))

from elastic_tendon.misreadings.suspicion import suspicions
from misread_recordings import MISREADINGS, REPORTED_SEEDS, Case, can_show, truth_case

DESCRIBED, HIDDEN = "described by the model", "effect hidden, model wrong"


def judge(case: Case, kind: str, counts: Counter[tuple[str, str, str]]) -> None:
    """Count what is said of a recording as it is and misread in every way."""
    alarms = suspicions(case.model, case.measurement)
    counts[kind, "as it is", "tried"] += 1
    counts[kind, "as it is", "suspected"] += bool(alarms)
    for sentence in alarms:
        print(f"false alarm ({case.effect or 'no effect'}): {sentence}")
    for name, misreading in MISREADINGS.items():
        if not can_show(misreading, case):
            continue
        found = suspicions(case.model, misreading.misread(case.measurement))
        counts[kind, name, "tried"] += 1
        counts[kind, name, "suspected"] += bool(found)
        counts[kind, name, "rightly named"] += any(
            misreading.says in suspicion for suspicion in found
        )


def print_rates(counts: Counter[tuple[str, str, str]]) -> None:
    """One row for each misreading, one column for each kind of recording."""
    print(f"{'suspected / rightly named / tried':34}{DESCRIBED:>28}{HIDDEN:>30}")
    for name in ("as it is", *MISREADINGS):
        cells = [
            " / ".join(
                str(counts[kind, name, what]) for what in ("suspected", "rightly named", "tried")
            )
            for kind in (DESCRIBED, HIDDEN)
        ]
        print(f"{name:34}{cells[0]:>28}{cells[1]:>30}")


def main() -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--first", type=int, default=REPORTED_SEEDS, help="first seed")
    parser.add_argument("--count", type=int, default=110, help="number of seeds")
    options = parser.parse_args()
    # the truth's integrator warns of trial steps that run away
    warnings.simplefilter("ignore", RuntimeWarning)
    counts: Counter[tuple[str, str, str]] = Counter()
    for seed in range(options.first, options.first + options.count):
        for kind in (DESCRIBED, HIDDEN):
            try:
                case = truth_case(seed, hidden=kind == HIDDEN)
            except (RuntimeError, OverflowError) as error:
                print(f"seed {seed} is left out, the truth cannot be simulated: {error}")
                continue
            judge(case, kind, counts)
    print_rates(counts)
    return 0


if __name__ == "__main__":
    sys.exit(main())
