"""Diagnose a fleet: the logs of six robots against one model, on two workers, in one table.

    python examples/fleet/run.py [FOLDER]

The script makes the logs itself, from machines that differ in ways that the model is not told of:
two are as they should be, one joint is damped more, one spring has softened, in one joint dry
friction has appeared, and one log lacks a column. Writes them in logs/, the table in fleet.csv
and the picture in fleet.png, all in FOLDER (default: here).
"""

import argparse
from pathlib import Path

import numpy as np
import pandas as pd

import elastic_tendon as et

HERE = Path(__file__).parent
MODEL = "biorob_x4_joint_3"
NOISE = 2e-4  # rad, of the joint's encoder
RATE, DURATION = 500, 8.0  # Hz, s
UPPER = "transmission.upper_spring.stiffness"


def machines(model: et.Model) -> dict[str, et.Model]:
    """The robots as they really are."""
    damping, stiffness = model.link.damping, model.transmission.upper_spring.stiffness
    return {
        "ada": model,
        "bela": model.with_values({"link.damping": 1.6 * damping}),
        "cora": model.with_values({UPPER: 0.85 * stiffness}),
        "dora": model.with_effect("coulomb_friction", {"torque": 0.3}),
        "emil": model,
        "finn": model,
    }


def log(machine: et.Model, seed: int) -> pd.DataFrame:
    """Slow and fast sines of the motor under a load, as a noisy encoder sees them."""
    lot = np.random.default_rng(seed)
    time = np.arange(round(DURATION * RATE)) / RATE
    rise = np.minimum(time, 1.0)  # from rest
    frequencies = lot.uniform(0.2, 3.0, 6)[:, None]
    phases = lot.uniform(0.0, 2.0 * np.pi, (6, 1))
    motor_position = rise * np.sum(0.15 * np.sin(2.0 * np.pi * frequencies * time + phases), axis=0)
    load_torque = rise * 5.0 * np.sin(2.0 * np.pi * 0.5 * time + phases[0])
    motion = et.simulate(machine, time, motor_position, load_torque)
    return pd.DataFrame(
        {
            "time_s": time,
            "motor_position_rad": motor_position,
            "load_torque_Nm": load_torque,
            "joint_position_rad": motion["joint_position"] + NOISE * lot.standard_normal(len(time)),
        }
    )


def write_logs(model: et.Model, folder: Path) -> list[Path]:
    """One CSV file for each robot; finn's encoder was not plugged in."""
    folder.mkdir(exist_ok=True)
    for seed, (name, machine) in enumerate(machines(model).items()):
        table = log(machine, seed)
        if name == "finn":
            table = table.drop(columns="joint_position_rad")
        table.to_csv(folder / f"{name}.csv", index=False)
    return [folder / f"{name}.csv" for name in machines(model)]


def main(folder: Path) -> None:
    model = et.load_model(MODEL)
    task = et.fleet(model, write_logs(model, folder / "logs"))
    swept = et.sweep(task, folder / "fleet.csv", workers=2, force=True)
    found = et.fleet_findings(model, swept.to_dataframe())
    print(found)
    for robot, reason in found.failed.items():
        print(f"{robot}: {reason}")
    swept.plot().savefig(folder / "fleet.png")


def chosen_folder() -> Path:
    """FOLDER of the command line, created if missing."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    told = "where logs, table and picture go (default: beside this script); created if missing"
    parser.add_argument("folder", nargs="?", type=Path, default=HERE, metavar="FOLDER", help=told)
    folder = parser.parse_args().folder
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        parser.error(f"{folder} cannot be made a folder: {error.strerror}")
    return folder


if __name__ == "__main__":
    main(chosen_folder())
