"""Where a machine drifts: what fits do whose initial states may not hide what a model lacks.

    python build_scripts/study_beginning.py [--data FOLDER] [--machine NAME] [--effects ID...]
    python build_scripts/study_beginning.py --simulated MACHINES

A fit chooses the initial state of each recording with all its samples; that of an unseen recording
comes from its first 0.1 s. What a model lacks can hide in the first, not in the second. So there
are three ways to fit: with the initial state free; begun from the first 0.1 s; in windows of 3 s,
each with an initial state of its own.

The first call asks a machine of `scoreboard.py`, its part to fit alone: what `diagnose` finds with
these effects as candidates, begun both ways; then how halves and thirds of that part, fitted each
way, predict the others. The second asks so many linear axes of tests/truth for each thing that the
model lacks: the error on three unseen recordings, and how far numbers are off the truth.
"""

import argparse
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

# the truth simulator belongs to the tests and is not installed
sys.path.append(str(Path(__file__).resolve().parents[1] / "tests"))

import elastic_tendon as et
from kept_answers import print_columns
from scoreboard import DATA, MACHINES, axis
from truth.axis import CONSTANT, DRY, LACKING, MASS, VISCOUS, recorded

STEP = 1e-3  # relative, of the numbers, for differences
EVERY = 10  # of so many samples one is fitted
EVALUATIONS = 15
WINDOW = 3.0  # s
PARTS = (2, 3)  # halves and thirds
UNSEEN = 3  # recordings of a simulated axis
LATE = 1.3  # s after which every second axis is recorded, in full motion
EFFECTS = ("constant_torque", "coulomb_friction")
TRUE = {
    "link.inertia": MASS,
    "link.damping": VISCOUS,
    "effects.coulomb_friction.torque": DRY,
    "effects.constant_torque.torque": -CONSTANT,  # it acts along the position
}
Way = Callable[[et.Model, Sequence[str], et.Measurement], et.Model]


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


def freely(given: et.Model, effects: Sequence[str], recording: et.Measurement) -> et.Model:
    """Fitted as `add` does."""
    return et.add(given, effects, recording).model


def from_beginning(given: et.Model, effects: Sequence[str], recording: et.Measurement) -> et.Model:
    """Fitted so, then once more begun from the first 0.1 s."""
    found = et.add(given, effects, recording)
    paths = [one.path for one in found.findings.estimates if one.determined]
    return refitted(found.model, paths, recording, "joint_position")


def in_windows(given: et.Model, effects: Sequence[str], recording: et.Measurement) -> et.Model:
    """Fitted to windows of it."""
    count = round(float(recording.time[-1] - recording.time[0]) / WINDOW)
    return et.add(given, effects, parts_of(recording, count)).model


WAYS: Mapping[str, Way] = {
    "initial state free": freely,
    "begun from the first 0.1 s": from_beginning,
    f"in windows of {WINDOW:g} s": in_windows,
}


def parts_of(recording: et.Measurement, count: int) -> list[et.Measurement]:
    """So many parts of equal length, with the noise of the whole."""
    noise = {name: floor.sigma for name, floor in recording.noise.items()}
    known = recording.with_noise(noise)
    ends = np.array_split(np.arange(len(recording.time)), count)
    return [known.samples(slice(int(part[0]), int(part[-1]) + 1)) for part in ends]


def ask_machine(name: str, folder: Path, effects: Sequence[str]) -> int:
    """Print what is found on the part to fit; 1 where it is not at hand."""
    machine = next(one for one in MACHINES if one.name == name)
    if not (folder / machine.source).is_file():
        print(f"{folder} has no {machine.source}; name its folder with --data", file=sys.stderr)
        return 1
    recording, signal = machine.fitted(folder), machine.signal
    found = et.diagnose(machine.model(), recording, options=et.Options(only=tuple(effects)))
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
    rows = []
    for way, fitted in WAYS.items():
        errors_of = [
            machine.scale * rms(begun(model, other, signal))
            for count in PARTS
            for model, others in predictions(fitted, machine.model(), effects, recording, count)
            for other in others
        ]
        rows.append([way, *(f"{error:.3g}" for error in errors_of), f"{rms(errors_of):.3g}"])
    names = [
        f"{k + 1} to {i + 1} of {count}"
        for count in PARTS
        for k in range(count)
        for i in range(count)
        if i != k
    ]
    print(f"\nErrors of parts as others predict them, {machine.unit}:")
    print_columns([["fitted", *names, "RMS"], *rows])
    return 0


def predictions(
    fitted: Way, given: et.Model, effects: Sequence[str], recording: et.Measurement, count: int
) -> Iterable[tuple[et.Model, list[et.Measurement]]]:
    """A model of each part, and the other parts."""
    parts = parts_of(recording, count)
    for k, part in enumerate(parts):
        yield fitted(given, effects, part), [*parts[:k], *parts[k + 1 :]]


def ask_simulated(machines: int) -> None:
    """Print a table of linear axes."""
    rows = [["lacking", "fitted", "unseen, mm", "mass, %", "viscous", "Coulomb", "constant"]]
    for lacking in LACKING:
        axes = [recordings_of(lacking, number) for number in range(machines)]
        for way, fitted in WAYS.items():
            found = [off_truth(fitted(axis(), EFFECTS, own), unseen) for own, *unseen in axes]
            error, *off = np.median(found, axis=0)
            rows.append([lacking, way, f"{error:.3g}", *(f"{one:.2g}" for one in off)])
    print(f"Medians of {machines} axes each:")
    print_columns(rows)


def recordings_of(lacking: str, number: int) -> list[et.Measurement]:
    """One to fit and some unseen ones of the same axis, every second one begun in full motion."""
    random = np.random.default_rng([number, 23])
    runs = [recorded(lacking, random, late=LATE * (number % 2)) for _ in range(1 + UNSEEN)]
    return [
        et.Measurement(
            time=run.time,
            motor_position=np.zeros(len(run.time)),
            load_torque=run.force,
            signals={"joint_position": run.position},
            name=f"{lacking} {number}",
        ).to_compare(axis())
        for run in runs
    ]


def off_truth(model: et.Model, unseen: Sequence[et.Measurement]) -> list[float]:
    """RMS error on unseen recordings, mm, and how far each number is off, %."""
    errors = [rms(begun(model, part, "joint_position")) for part in unseen]
    values = model.values()
    return [1e3 * rms(errors), *(100.0 * abs(values[path] / TRUE[path] - 1.0) for path in TRUE)]


def rms(errors: Sequence[float] | NDArray[np.float64]) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(np.square(errors))))


def main(arguments: Sequence[str] | None = None) -> int:
    """Print the tables; exit status 1 where the recording is not at hand."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--data", type=Path, default=DATA, help="folder of the recordings")
    parser.add_argument("--machine", default="EMPS", choices=[one.name for one in MACHINES])
    parser.add_argument("--effects", nargs="+", default=list(EFFECTS))
    parser.add_argument("--simulated", type=int, help="so many axes for each thing that is lacking")
    given = parser.parse_args(arguments)
    if given.simulated is None:
        return ask_machine(given.machine, given.data, given.effects)
    ask_simulated(given.simulated)
    return 0


if __name__ == "__main__":
    sys.exit(main())
