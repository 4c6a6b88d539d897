"""Write the bundled demonstration: two measurements of a machine, and the model its user believes.

The measurements come from the independent simulator in tests/truth. The machine is the actuator
of BioRob-X4 joint 3 with parameters a little off the believed ones, and with Coulomb friction
that the believed model lacks. Its sensors have noise and whole encoder counts.

    python build_scripts/make_demo_data.py [--output FOLDER]

writes demo_model.toml, demo_fit.csv and demo_validate.csv into FOLDER, by default the package's
data folder.
"""

import argparse
import sys
import tomllib
from pathlib import Path

import numpy as np
import pandas as pd

# the truth simulator belongs to the tests and is not installed
sys.path.append(str(Path(__file__).resolve().parents[1] / "tests"))

from truth.actuator import Actuator, Link, Spring
from truth.experiments import Limits, multisine, steps_with_load_pulses
from truth.friction import Coulomb
from truth.noise import Sensor, counts
from truth.sampling import sample
from truth.signals import Experiment
from truth.solver import simulate

DATA_FOLDER = Path(__file__).resolve().parents[1] / "fmu_src" / "elastic_tendon" / "demo"

BELIEVED_MODEL = """\
# What the user of the demonstration believes of the machine: the paper's BioRob-X4 joint 3.
# The machine in demo_fit.csv and demo_validate.csv differs a little in its numbers, and has
# a physical effect that is not in here.
name = "demo_actuator"

[transmission]
joint_pulley_radius = 0.03        # m
motor_pulley_radius = 0.03        # m; equal radii: the motor position counts at the joint
pretension_force = 80.0           # N

[transmission.upper_spring]
stiffness = 11580.0               # N/m, one spring
parallel = 2
max_deflection = 0.015            # m

[transmission.lower_spring]
stiffness = 11580.0               # N/m, one spring
parallel = 2
max_deflection = 0.015            # m

[link]
inertia = 0.03                    # kg m^2; assumed, the paper gives none
damping = 0.16                    # N m s/rad; assumed, the paper gives none
"""

# the machine's numbers as shares of the believed ones
UPPER_STIFFNESS, LOWER_STIFFNESS, PRETENSION, INERTIA, DAMPING = 1.05, 0.97, 0.88, 1.13, 1.25
FRICTION_TORQUE = 0.35  # N·m

RATE = 500  # Hz
DURATION = 10.0  # s
# large enough for slack to both sides, small enough for the springs to bear it
LIMITS = Limits(deflection=0.38, speed=4.1, torque=5.4)  # rad, rad/s, N·m
FIT_SEED, VALIDATION_SEED = 2, 12

SENSORS = {
    "joint_position": Sensor(white=2e-4, step=counts(14)),
    # on the motor's side of a gear of 16: 16 times finer at the motor pulley
    "motor_position": Sensor(white=2e-5, step=counts(14) / 16),
}
# digits that keep every encoder count apart; z writes no negative zero
FORMATS = {"time_s": "{:.3f}", "load_torque_Nm": "{:z.4f}"}
POSITION_FORMAT = "{:z.6f}"


def machine() -> Actuator:
    """The machine as it is: the believed model, its numbers shifted, with friction."""
    believed = tomllib.loads(BELIEVED_MODEL)
    transmission, link = believed["transmission"], believed["link"]

    def spring(side: str, share: float) -> Spring:
        table = transmission[side]
        return Spring(
            stiffness=share * table["stiffness"] * table["parallel"],
            max_deflection=table["max_deflection"],
        )

    return Actuator(
        joint_pulley_radius=transmission["joint_pulley_radius"],
        motor_pulley_radius=transmission["motor_pulley_radius"],
        pretension_force=PRETENSION * transmission["pretension_force"],
        upper=spring("upper_spring", UPPER_STIFFNESS),
        lower=spring("lower_spring", LOWER_STIFFNESS),
        link=Link(
            inertia=INERTIA * link["inertia"],
            damping=DAMPING * link["damping"],
            friction=Coulomb(FRICTION_TORQUE),
        ),
    )


def experiments() -> dict[str, tuple[Experiment, int]]:
    """Experiment and noise seed for each file: another motion is used to validate."""
    return {
        "demo_fit.csv": (multisine(FIT_SEED, LIMITS, DURATION), FIT_SEED),
        "demo_validate.csv": (
            steps_with_load_pulses(VALIDATION_SEED, LIMITS, DURATION),
            VALIDATION_SEED,
        ),
    }


def table(actuator: Actuator, experiment: Experiment, seed: int) -> pd.DataFrame:
    """One measurement, every number as the text that is written."""
    time = np.arange(round(DURATION * RATE)) / RATE
    measurement = sample(simulate(actuator, experiment, time), SENSORS, seed)
    return pd.DataFrame(
        {
            name: [FORMATS.get(name, POSITION_FORMAT).format(value) for value in values]
            for name, values in measurement.items()
        }
    )


def main() -> None:
    """Write the three files."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument(
        "--output", type=Path, default=DATA_FOLDER,
        help="folder to write into (default: the package's data folder)",
    )  # fmt: skip
    folder: Path = parser.parse_args().output
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "demo_model.toml").write_text(BELIEVED_MODEL, encoding="utf-8")
    actuator = machine()
    for file, (experiment, seed) in experiments().items():
        table(actuator, experiment, seed).to_csv(folder / file, index=False, lineterminator="\n")
        print(f"wrote {folder / file}")


if __name__ == "__main__":
    main()
