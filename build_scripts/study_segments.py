"""Machines that nearly integrate, believed wrongly: what segments of rising length do for a fit.

    python build_scripts/study_segments.py [--data FOLDER]
    python build_scripts/study_segments.py --simulated MACHINES

The first call diagnoses EMPS, its part to fit alone, from several beliefs, with and without
segments. The second fits so many linear axes of tests/truth for each of these beliefs and each
thing that the model lacks, both ways.
"""

import argparse
import sys
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

import elastic_tendon as et
from elastic_tendon.actuator.parameters import Model
from elastic_tendon.estimation import segments
from elastic_tendon.estimation.fit import THOROUGH, Effort, FitResult, fit
from kept_answers import print_columns
from scoreboard import DATA, emps
from study_beginning import EFFECTS, EVERY, recordings_of
from truth.axis import LACKING

SOURCE, SIGNAL = "emps_estimation.csv", "joint_position"
# mass, kg, and viscous friction, N s/m
BELIEFS = ((95.0, 20.0), (95.0, 60.0), (95.0, 203.0), (95.0, 600.0), (60.0, 203.0), (150.0, 203.0))
PROMISING = segments.PROMISING
WAYS = {"directly": False, "in segments too": True}
SHOWN = ("link.inertia", "link.damping", *(f"effects.{name}.torque" for name in EFFECTS))


def believed(mass: float, damping: float) -> Model:
    """A linear axis of mass and viscous friction."""
    link = {"inertia": mass, "damping": damping}
    return et.load_model({"name": "given", "motion": "linear", "link": link})


def ask_emps(folder: Path) -> int:
    """Print what is named from each belief; 1 where the recording is not at hand."""
    if not (folder / SOURCE).is_file():
        print(f"{folder} has no {SOURCE}; name its folder with --data", file=sys.stderr)
        return 1
    recording = emps(SOURCE, folder)
    rows = [["mass, kg", "damping", "fitted", "named", "error, mm", "processor, s"]]
    for mass, damping in BELIEFS:
        for way, used in WAYS.items():
            segments.PROMISING = PROMISING if used else np.inf
            begun = time.process_time()
            found = et.diagnose(believed(mass, damping), recording)
            took = time.process_time() - begun
            error = 1e3 * found.comparison.rmse()[SIGNAL]
            named = " + ".join(sorted(found.added))
            rows.append([f"{mass:g}", f"{damping:g}", way, named, f"{error:.3g}", f"{took:.0f}"])
    print_columns(rows)
    return 0


def ask_simulated(machines: int) -> None:
    """Print medians of axes: the error of the fit and its numbers."""
    rows = [["mass, kg", "damping", "fitted", "error, mm", *SHOWN]]
    for mass, damping in BELIEFS:
        given = believed(mass, damping)
        for effect_id in EFFECTS:
            given = given.with_effect(effect_id, None)
        for way, used in WAYS.items():
            effort = replace(THOROUGH, in_segments=used)
            found = [
                numbers(fitted(given, lacking, number, effort))
                for lacking in LACKING
                for number in range(machines)
            ]
            middle = np.median(found, axis=0)
            rows.append([f"{mass:g}", f"{damping:g}", way, *(f"{one:.3g}" for one in middle)])
    print(f"Medians of {machines} axes for each of {len(LACKING)} things that the model lacks:")
    print_columns(rows)


def fitted(given: Model, lacking: str, number: int, effort: Effort) -> FitResult:
    """A fit to one of the axes."""
    recording = recordings_of(lacking, number)[0]
    return fit(given, recording.samples(slice(None, None, EVERY)), effort=effort)


def numbers(found: FitResult) -> list[float]:
    """Error, mm, and fitted numbers."""
    (errors,) = found.problem.errors(found.vector)
    values = found.model.values()
    return [1e3 * float(np.sqrt(np.mean(errors[SIGNAL] ** 2))), *(values[path] for path in SHOWN)]


def main(arguments: Sequence[str] | None = None) -> int:
    """Print the tables; exit status 1 where the recording is not at hand."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--data", type=Path, default=DATA, help="folder of the recordings")
    parser.add_argument("--simulated", type=int, help="so many axes for each thing that is lacking")
    given = parser.parse_args(arguments)
    if given.simulated is None:
        return ask_emps(given.data)
    ask_simulated(given.simulated)
    return 0


if __name__ == "__main__":
    sys.exit(main())
