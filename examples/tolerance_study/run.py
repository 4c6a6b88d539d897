"""What tolerances of springs do to the slack boundary, and to a position loop.

    python examples/tolerance_study/run.py [FOLDER]

Draws machines whose springs and pretension differ from the nominal ones, sweeps over them, prints
how far the boundary of slack moves and how many machines miss what is required, and draws
slack_boundary.png and closed_loop.png in FOLDER (default: here).
"""

import argparse
import tempfile
from pathlib import Path

import numpy as np
import pandas as pd
from bench import LOWER, PRETENSION, UPPER, closed_form, joint_clamped, joint_loaded, moved_by
from closed_loop import II, III, SHARES, I, apart, closed_loops_of
from figures import draw_boundaries, draw_loops

from elastic_tendon import Model, Points, Task, design, load_model, sweep, vary

HERE = Path(__file__).parent
TOLERANCES = {UPPER: "5%", LOWER: "5%", PRETENSION: "10%"}  # one sigma of a Gaussian
MACHINES, SEED = 2048, 1
REQUIRED_TORQUE = 4.0  # N·m that the joint shall bear with both tendons taut
REQUIRED_DAMPING, REQUIRED_OVERSHOOT = 0.3, 0.15  # in each slack state


def swept(task: Task, name: str) -> pd.DataFrame:
    """The table of a sweep; a file, which here only this script reads."""
    with tempfile.TemporaryDirectory() as work:
        return sweep(task, Path(work) / f"{name}.csv").to_dataframe()


def slack_boundary(model: Model, machines: Points, picture: Path) -> None:
    clamped, loaded = joint_clamped(model, machines), joint_loaded(model, machines)
    table, loads = swept(clamped.task, "clamped"), swept(loaded.task, "loaded")
    deflection, torque = clamped.boundary(table), loaded.boundary(loads)
    nominal = design(model).positive_slack_boundary
    bearable = design(model).stiffness_state_3 * nominal
    print("Where the upper tendon goes slack, and what one sigma of each tolerance moves it by")
    print("            nominal     mean   5 % of machines below   upper   lower   pretension")
    moved = {"deflection": moved_by(deflection, table), "torque": moved_by(torque, loads)}
    sized = {"deflection": (deflection, nominal, "rad"), "torque": (torque, bearable, "N·m")}
    for name, (values, given, unit) in sized.items():
        upper, lower, pretension = (100.0 * one for one in moved[name].values())
        print(
            f"{name:10} {given:8.4f} {values.mean():8.4f} {np.quantile(values, 0.05):12.4f}"
            f" {unit:10} {upper:+6.2f}% {lower:+6.2f}% {pretension:+9.2f}%"
        )
    for name, simulated, paper in zip(
        sized, (deflection, torque), closed_form(model, table), strict=True
    ):
        largest = 100.0 * np.abs(simulated / paper - 1.0).max()
        print(f"{name}: simulated boundaries are within {largest:.3f} % of the paper's closed form")
    short = 100.0 * np.mean(torque < REQUIRED_TORQUE)
    print(f"{short:.1f} % of the machines go slack below the {REQUIRED_TORQUE:g} N·m required")
    labels = ("deflection there (rad)", "torque there (N·m)")
    drawn = {
        label: (values, given)
        for label, (values, given, _) in zip(labels, sized.values(), strict=True)
    }
    draw_boundaries(drawn, moved, REQUIRED_TORQUE, picture)


def closed_loop(model: Model, machines: Points, picture: Path) -> None:
    task = closed_loops_of(model, machines)
    table = swept(task, "loops")
    far = max(apart(task, run) for run in range(3))
    print(f"\nMatrices of three machines are within {far:.1g} of those that linearise gives them")
    print("\nThe position loop, its design made for the nominal machine")
    print("            least damping      largest overshoot (%)   machines that")
    print("made for    nominal   worst        nominal   worst     miss the limits (%)")
    nominal = closed_loops_of(model, _nominal(model)).rows(0, 1)
    damping = {name: _least(table, name) for name in SHARES}
    overshoot = {name: _largest(table, name) for name in SHARES}
    for name in SHARES:
        missed = (damping[name] < REQUIRED_DAMPING) | (overshoot[name] > REQUIRED_OVERSHOOT)
        print(
            f"{name:10} {_least(nominal, name)[0]:8.3f} {damping[name].min():7.3f}"
            f" {100 * _largest(nominal, name)[0]:14.1f} {100 * overshoot[name].max():7.1f}"
            f" {100 * missed.mean():18.1f}"
        )
    draw_loops(damping, overshoot, (REQUIRED_DAMPING, REQUIRED_OVERSHOOT), picture)


def _nominal(model: Model) -> Points:
    """Points whose first is the model as given."""
    given = model.values()
    return vary(model, {path: f"{given[path]},{1.01 * given[path]}" for path in TOLERANCES}, "grid")


def _least(table: pd.DataFrame, name: str) -> np.ndarray:
    columns = [f"{name}.damping_{state.name}" for state in (I, II, III)]
    return table[columns].min(axis=1).to_numpy()


def _largest(table: pd.DataFrame, name: str) -> np.ndarray:
    columns = [f"{name}.overshoot_{state.name}" for state in (I, II, III)]
    return table[columns].max(axis=1).to_numpy()


def main(folder: Path) -> None:
    model = load_model("biorob_x4_joint_3")
    machines = vary(model, TOLERANCES, "sobol", runs=MACHINES, seed=SEED)
    slack_boundary(model, machines, folder / "slack_boundary.png")
    closed_loop(model, machines, folder / "closed_loop.png")


def chosen_folder() -> Path:
    """FOLDER of the command line, created if missing."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    told = "where the pictures go (default: beside this script); created if missing"
    parser.add_argument("folder", nargs="?", type=Path, default=HERE, metavar="FOLDER", help=told)
    folder = parser.parse_args().folder
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        parser.error(f"{folder} cannot be made a folder: {error.strerror}")
    return folder


if __name__ == "__main__":
    main(chosen_folder())
