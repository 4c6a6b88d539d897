"""Print the ladder of errors on a real machine's recordings.

    python build_scripts/bench_real_data.py [--data FOLDER]

The bench actuator is fitted to muir_position_loop_tracking.csv, as given, refitted, and with
Coulomb friction; muir_position_loop_disturbed_by_hand.csv after 3.3 s is held out. It is what

    elastic-tendon add bench_actuator coulomb_friction TRACKING --validate DISTURBED[3.3:15] -o NEW

does, beside the figures of an earlier trial.
"""

import argparse
import sys
from pathlib import Path

from elastic_tendon.identify.add import add
from elastic_tendon.measurement import read_measurement
from elastic_tendon.parameters import load_model

DATA = Path(__file__).resolve().parents[2] / "shared" / "data"
TRIAL = ("28 / 25", "23 / 23", "13-14 / 7-9")  # mrad RMS, fitted / held out


def main() -> int:
    """Print the table; exit status 1 where the recordings are not at hand."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--data", type=Path, default=DATA, help="folder of the muir_*.csv files")
    folder: Path = parser.parse_args().data
    if not folder.is_dir():
        print(f"{folder}: there is no such folder; name it with --data", file=sys.stderr)
        return 1
    tracking = read_measurement(str(folder / "muir_position_loop_tracking.csv"))
    disturbed = read_measurement(
        str(folder / "muir_position_loop_disturbed_by_hand.csv") + "[3.3:15]"
    )
    result = add(load_model("bench_actuator"), "coulomb_friction", [tracking], [disturbed])
    print(f"{'mrad RMS':22}{'fitted':>8}{'held out':>10}    trial")
    for rung, trial in zip(result.ladder, TRIAL, strict=True):
        fitted, heldout = (1e3 * one["joint_position"] for one in (rung.rmse, rung.heldout_rmse))
        print(f"{rung.title:22}{fitted:8.1f}{heldout:10.1f}    {trial}")
    for ratio in result.findings.ratios:
        low, high = ratio.interval
        print(f"{ratio.name} = {ratio.value:.3g} ({low:.3g} to {high:.3g}) {ratio.unit}")
    for sentence in result.findings.sentences:
        print(sentence)
    return 0


if __name__ == "__main__":
    sys.exit(main())
