"""How long a fleet takes, and what is found in it.

    python build_scripts/benchmark_fleet.py [--quick]

Robots are drawn around a bundled model; friction and gravity appeared in some of them. Logs are
made by our own simulation, 12 s at 500 Hz with noise: this is about time, not about truth.
"""

import argparse
import sys
import tempfile
from pathlib import Path

import numpy as np
import pandas as pd

import elastic_tendon as et
from benchmarking import Row, at_least, at_most, print_table, seconds

MODEL = et.load_model("biorob_x4_joint_3")
ROBOTS, WORKERS = 20, 2
MOST = 60.0  # s for all of them
RATE, DURATION = 500, 12.0  # Hz, s
NOISE = 2e-4  # rad
SCATTER = 0.03  # of a robot's stiffness, inertia and damping, one sigma
VARIED = (
    *(f"transmission.{side}_spring.stiffness" for side in ("upper", "lower")),
    *("link.inertia", "link.damping"),
)
APPEARED: tuple[tuple[str, dict[str, float]] | None, ...] = (
    None,
    ("coulomb_friction", {"torque": 0.3}),
    None,
    ("gravity_load", {"torque": 0.6}),
)


def robot(number: int, random: np.random.Generator) -> et.Model:
    """A robot as it really is."""
    own = {path: MODEL.values()[path] * random.normal(1.0, SCATTER) for path in VARIED}
    appeared = APPEARED[number % len(APPEARED)]
    machine = MODEL.with_values(own)
    return machine if appeared is None else machine.with_effect(*appeared)


def log(machine: et.Model, random: np.random.Generator) -> pd.DataFrame:
    """Slow and fast sines of the motor under a load, from rest."""
    time = np.arange(round(DURATION * RATE)) / RATE
    rise = np.minimum(time, 1.0)
    frequencies = random.uniform(0.2, 3.0, (6, 1))
    phases = random.uniform(0.0, 2.0 * np.pi, (6, 1))
    motor = rise * np.sum(0.15 * np.sin(2.0 * np.pi * frequencies * time + phases), axis=0)
    load = rise * 5.0 * np.sin(np.pi * time + phases[0])
    joint = et.simulate(machine, time, motor, load)["joint_position"]
    return pd.DataFrame(
        {
            "time_s": time,
            "motor_position_rad": motor,
            "load_torque_Nm": load,
            "joint_position_rad": joint + NOISE * random.standard_normal(len(time)),
        }
    )


def rows(quick: bool) -> list[Row]:
    """Time of the fleet and what was named; `quick` has four robots."""
    count = len(APPEARED) if quick else ROBOTS
    random = np.random.default_rng(1)
    with tempfile.TemporaryDirectory() as work:
        paths = [Path(work) / f"{number:02}.csv" for number in range(count)]
        for number, path in enumerate(paths):
            log(robot(number, random), random).to_csv(path, index=False)
        task, table = et.fleet(MODEL, paths), Path(work) / "fleet.parquet"
        time = seconds(lambda: et.sweep(task, table, workers=WORKERS))
        named = pd.read_parquet(table)["appeared"].str.partition(":")[0]
    hidden = [APPEARED[number % len(APPEARED)] for number in range(count)]
    right = [
        name == ("" if appeared is None else appeared[0])
        for name, appeared in zip(named, hidden, strict=True)
    ]
    return [
        at_most(f"{count} robots on {WORKERS} cores", time, MOST * count / ROBOTS, "s"),
        at_least(f"named as hidden ({count})", 100.0 * float(np.mean(right)), 95.0, "%"),
    ]


def main() -> int:
    """Print the table; exit status."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="four robots")
    return print_table("A fleet", rows(parser.parse_args().quick))


if __name__ == "__main__":
    sys.exit(main())
