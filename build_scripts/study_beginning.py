"""Where a machine drifts: what its fit errs when it begins as a recording that no fit has seen.

    python build_scripts/study_beginning.py [--data FOLDER] [--machine NAME] [--effects ID...]

A fit chooses the initial state of each recording with all its samples; that of an unseen recording
comes from its first 0.1 s. What a model lacks can hide in the first, not in the second. The table
has the RMS error on the part to fit of a machine of `scoreboard.py` for what `diagnose` finds with
these effects as candidates, begun both ways, and for its numbers fitted once more, begun from the
first 0.1 s. No test part is touched.
"""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

import elastic_tendon as et
from scoreboard import DATA, MACHINES

STEP = 1e-3  # relative, of the numbers, for differences
EVERY = 10  # of so many samples one is fitted
EVALUATIONS = 15


def begun(model: et.Model, recording: et.Measurement, signal: str) -> NDArray[np.float64]:
    """Errors of a model that begins as the first 0.1 s say, (n,)."""
    (file,) = et.compare(model, recording).files
    return np.asarray(file.trajectory[signal] - recording.signals[signal])


def described(model: et.Model, paths: Sequence[str]) -> str:
    """Numbers of a model in words."""
    values = model.values()
    return ", ".join(f"{path} {values[path]:.4g}" for path in paths)


def refitted(
    model: et.Model, paths: Sequence[str], recording: et.Measurement, signal: str
) -> et.Model:
    """Some numbers fitted once more, begun from the first 0.1 s."""
    centre = np.array([model.values()[path] for path in paths])

    def at(scale: NDArray[np.float64]) -> et.Model:
        return model.with_values(dict(zip(paths, (scale * centre).tolist(), strict=True)))

    def residuals(scale: NDArray[np.float64]) -> NDArray[np.float64]:
        return begun(at(scale), recording, signal)[::EVERY]

    steps = np.full(len(paths), STEP)
    start = np.ones(len(paths))
    found = least_squares(residuals, start, diff_step=steps, max_nfev=EVALUATIONS)
    return at(found.x)


def main(arguments: Sequence[str] | None = None) -> int:
    """Print the table; exit status 1 where the recording is not at hand."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--data", type=Path, default=DATA, help="folder of the recordings")
    parser.add_argument("--machine", default="EMPS", choices=[one.name for one in MACHINES])
    parser.add_argument("--effects", nargs="+", default=["constant_torque", "coulomb_friction"])
    given = parser.parse_args(arguments)
    machine = next(one for one in MACHINES if one.name == given.machine)
    if not (given.data / machine.source).is_file():
        print(f"{given.data} has no {machine.source}; name its folder with --data", file=sys.stderr)
        return 1
    recording, signal = machine.fitted(given.data), machine.signal
    options = et.Options(only=tuple(given.effects))
    found = et.diagnose(machine.model(), recording, options=options)
    determined = [one for one in found.findings.estimates if one.determined]
    paths = [one.path for one in determined]
    again = refitted(found.model, paths, recording, signal)
    errors = (
        ("fitted with its initial state", found.ladder[-1].rmse[signal], found.model),
        ("begun from the first 0.1 s", rms(begun(found.model, recording, signal)), found.model),
        ("fitted again, begun so", rms(begun(again, recording, signal)), again),
    )
    for title, error, model in errors:
        print(f"{title:30} {machine.scale * error:6.3g} {machine.unit}  {described(model, paths)}")
    for one in determined:
        print(f"{one.path}: {one.interval[0]:.3g} to {one.interval[1]:.3g} {one.unit}")
    return 0


def rms(errors: NDArray[np.float64]) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(errors**2)))


if __name__ == "__main__":
    sys.exit(main())
