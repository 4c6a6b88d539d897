"""Compare models with recordings of real machines: where they fail, and what a fit makes of it.

    python build_scripts/bench_real_data.py [--data FOLDER] [--figures FOLDER]

Reads muir_*.csv (a bench actuator) and mrd_run_*.csv (the jaw of a surgical tool), compares each
with its bundled model, says in words where the model fails, and draws it with --figures. Then it
prints how the error falls when Coulomb friction is added, on fitted and on held-out data, as

    elastic-tendon add bench_actuator coulomb_friction TRACKING --validate DISTURBED[3.3:15] -o NEW

does, beside the figures of an earlier trial; and last what diagnose finds by itself.
"""

import argparse
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from elastic_tendon.actuator.parameters import load_model
from elastic_tendon.comparison.compare import compare
from elastic_tendon.comparison.comparison import Comparison
from elastic_tendon.comparison.locate import Location, locate
from elastic_tendon.diagnosis.diagnose import diagnose
from elastic_tendon.estimation.add import add
from elastic_tendon.measurement import Measurement, read_measurement
from elastic_tendon.reports.comparison_figures import save
from elastic_tendon.reports.location_figures import all_figures

DATA = Path(__file__).resolve().parents[2] / "shared" / "data"
TRACKING = "muir_position_loop_tracking.csv"
DISTURBED = "muir_position_loop_disturbed_by_hand.csv"
HELD = "muir_torque_loop_output_held.csv"
SLOW, FAST = "mrd_run_04.csv", "mrd_run_44.csv"
MODELS = {
    TRACKING: "bench_actuator",
    DISTURBED: "bench_actuator",
    HELD: "bench_actuator",
    SLOW: "mrd_jaw",
    FAST: "mrd_jaw",
}
ROWS_BETWEEN = 4  # of the held output's 200 Hz; it turns slowly


@dataclass(frozen=True)
class Climb:
    """Friction added to a model: what is fitted, what is held out, figures of an earlier trial."""

    model: str
    fitted: str
    heldout: str
    trial: tuple[str, str, str]  # mrad RMS, fitted / held out


CLIMBS = (
    Climb(
        "bench_actuator", TRACKING, f"{DISTURBED}[3.3:15]", ("28 / 25", "23 / 23", "13-14 / 7-9")
    ),
    Climb("mrd_jaw", SLOW, FAST, ("", "", "")),
)


def read(folder: Path, name: str) -> Measurement:
    """One of the recordings.

    The clamp's torque on the held output is not known, so of this one the static curve is taken:
    the commanded motor torque, which the springs carry, over the deflection between the encoders.
    """
    if name != HELD:
        return read_measurement(str(folder / name))
    table = pd.read_csv(folder / name)[::ROWS_BETWEEN]
    deflection = table["joint_position_rad"] - table["motor_position_rad"]
    torque = table["motor_torque_cmd_Nm"]
    with tempfile.TemporaryDirectory() as work:
        path = Path(work) / name
        curve = pd.DataFrame({"joint_deflection_rad": deflection, "joint_torque_Nm": torque})
        curve.to_csv(path, index=False)
        return read_measurement(str(path))


def located(folder: Path, name: str) -> tuple[Comparison, Location]:
    """One recording compared with the model of its machine, and where the model fails."""
    comparison = compare(load_model(MODELS[name]), [read(folder, name)])
    return comparison, locate(comparison)


def print_findings(comparison: Comparison, location: Location) -> None:
    """Figures and words for each signal of each recording."""
    for file, place in zip(comparison.files, location.files, strict=True):
        print(f"\n{file.measurement.name}, model {comparison.model.name}")
        for note in (*file.measurement.notes, *place.missing_torque.notes):
            print(f"  note: {note}")
        for signal, error in file.signals.items():
            fit = "" if error.fit_percent is None else f", fit {error.fit_percent:.1f} %"
            print(
                f"  {signal}: RMSE {error.rmse:.3g}, largest {error.max_abs:.3g}, bias "
                f"{error.bias:.2g}{fit}, {error.noise_ratio:.3g} times the noise"
            )
            print(f"    {place.in_words[signal]}")


def print_climb(folder: Path, climb: Climb) -> None:
    """The ladder of errors, and what the fit found."""
    heldout = read_measurement(str(folder / climb.heldout))
    result = add(
        load_model(climb.model), "coulomb_friction", [read(folder, climb.fitted)], [heldout]
    )
    print(f"\n{climb.model + ', mrad RMS':22}{'fitted':>8}{'held out':>10}    trial")
    for step, trial in zip(result.ladder, climb.trial, strict=True):
        fitted, judged = (
            1e3 * errors["joint_position"] for errors in (step.rmse, step.heldout_rmse)
        )
        print(f"{step.title:22}{fitted:8.1f}{judged:10.1f}    {trial}".rstrip())
    for ratio in result.findings.ratios:
        low, high = ratio.interval
        print(f"{ratio.name} = {ratio.value:.3g} ({low:.3g} to {high:.3g}) {ratio.unit}")
    for sentence in result.findings.sentences:
        print(sentence)


def print_diagnosis(folder: Path, climb: Climb) -> None:
    """What the loop finds without being told of any effect."""
    heldout = read_measurement(str(folder / climb.heldout))
    found = diagnose(load_model(climb.model), [read(folder, climb.fitted)], [heldout])
    print(f"\ndiagnose {climb.model}: {found.sentence}")
    for step in found.ladder:
        fitted, judged = (
            1e3 * errors["joint_position"] for errors in (step.rmse, step.heldout_rmse)
        )
        print(f"{step.title:40}{fitted:8.1f}{judged:10.1f}")
    for considered in found.rounds:
        print(f"  {considered.reason}")
        for candidate in considered.candidates:
            if candidate.fitted:
                print(f"    {' + '.join(candidate.ids)}: {candidate.reason}")
    for neighbour in found.neighbours:
        if neighbour.refitted and neighbour.evidence is not None:
            print(f"  {neighbour.change}: evidence worse by {neighbour.evidence:.0f}")
    for alike in found.indistinguishable:
        print(f"  not told apart: {', '.join(alike)}")
    for signal, remaining in found.remaining.items():
        print(
            f"  remains of {signal}: {remaining.noise_ratio:.3g} times the noise, "
            f"significant: {remaining.significant}, matters: {remaining.matters}"
        )


def main() -> int:
    """Print it all; exit status 1 where the recordings are not at hand."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--data", type=Path, default=DATA, help="folder of the recordings")
    parser.add_argument("--figures", type=Path, help="folder to draw the figures into")
    arguments = parser.parse_args()
    folder: Path = arguments.data
    if missing := [name for name in MODELS if not (folder / name).is_file()]:
        print(f"{folder}: it has no {missing[0]}; name the folder with --data", file=sys.stderr)
        return 1
    for name in MODELS:
        comparison, location = located(folder, name)
        print_findings(comparison, location)
        if arguments.figures is not None:
            drawn = arguments.figures / Path(name).stem
            drawn.mkdir(parents=True, exist_ok=True)
            for title, draw in all_figures(comparison, location):
                save(draw(), drawn / f"{title}.png")
    for climb in CLIMBS:
        print_climb(folder, climb)
    for climb in CLIMBS:
        print_diagnosis(folder, climb)
    return 0


if __name__ == "__main__":
    sys.exit(main())
