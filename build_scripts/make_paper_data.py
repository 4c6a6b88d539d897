"""Write the two measurements of examples/paper_figures: what the paper measured, but synthetic.

The paper gives no data file. These come from the independent simulator in tests/truth, of a
BioRob-X4 joint 3 whose springs have an overstretch protection, as the paper's had (Fig. 6), and
in motion also a little friction and a slightly heavier link than the model's.

    python build_scripts/make_paper_data.py [--output FOLDER]

writes static_curve.csv (Fig. 10) and excitation.csv (Fig. 11) into FOLDER, by default the
example's folder.
"""

import argparse
import sys
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray

# the truth simulator belongs to the tests and is not installed
sys.path.append(str(Path(__file__).resolve().parents[1] / "tests"))

from truth.actuator import Actuator, Link, Overstretch, Spring
from truth.experiments import Limits, steps_with_load_pulses
from truth.friction import Coulomb
from truth.noise import Sensor, counts, measured
from truth.sampling import sample
from truth.solver import simulate

EXAMPLE = Path(__file__).resolve().parents[1] / "examples" / "paper_figures"

RADIUS = 0.03  # m
STIFFNESS = 2 * 11580.0  # N/m, two tendons in parallel
MAX_DEFLECTION = 0.015  # m
PRETENSION = 80.0  # N
# the paper says that there is a protection, not of which size: assumed
ENGAGEMENT, STRING = 0.8 * MAX_DEFLECTION, 1.5 * STIFFNESS  # m, N/m
INERTIA, DAMPING, FRICTION = 0.031, 0.15, 0.05  # kg m², N·m s/rad, N·m

LARGEST, ROWS_EACH_WAY = 0.38, 48  # rad of deflection, rows from rest to the largest
STATIC_SEED, EXCITATION_SEED = 101, 103
ENCODER = Sensor(white=2e-4, step=counts(14))  # rad
TORQUE_SENSOR = Sensor(white=0.03, step=0.01)  # N·m

RATE, DURATION = 200, 12.0  # Hz, s
MOTION = Limits(deflection=0.28, speed=4.0, torque=0.0)  # no load: the joint follows the motor


def machine() -> Actuator:
    """The actuator as it is."""
    spring = Spring(STIFFNESS, MAX_DEFLECTION, overstretch=Overstretch(ENGAGEMENT, STRING))
    return Actuator(
        joint_pulley_radius=RADIUS,
        motor_pulley_radius=RADIUS,
        pretension_force=PRETENSION,
        upper=spring,
        lower=spring,
        link=Link(inertia=INERTIA, damping=DAMPING, friction=Coulomb(FRICTION)),
    )


def static_torque(actuator: Actuator, deflection: float) -> float:
    """Torque on the joint at rest, N·m, of a deflection (rad): (7) with protected springs."""
    lengths = actuator.elongations(0.0, deflection)
    springs = zip(actuator.springs, lengths, strict=True)
    upper, lower = (max(spring.static_force(e, e > ENGAGEMENT), 0.0) for spring, e in springs)
    return actuator.joint_pulley_radius * (upper - lower)


def static_curve(actuator: Actuator) -> dict[str, NDArray[np.float64]]:
    """The joint turned by hand to both sides and back, read at rest in between."""
    there = np.linspace(0.0, LARGEST, ROWS_EACH_WAY + 1)
    deflection = np.concatenate([there, there[-2::-1], -there[1:], -there[-2::-1]])
    torque = np.array([static_torque(actuator, float(angle)) for angle in deflection])
    streams = [np.random.default_rng([STATIC_SEED, column]) for column in range(3)]
    # the motor's encoder stands at zero and has its noise too
    joint = measured(deflection, ENCODER, streams[0])
    motor = measured(np.zeros_like(deflection), ENCODER, streams[1])
    return {
        "joint_deflection_rad": joint - motor,
        "joint_torque_Nm": measured(torque, TORQUE_SENSOR, streams[2]),
    }


def excitation(actuator: Actuator) -> dict[str, NDArray[np.float64]]:
    """The motor driven along smooth steps, the joint free."""
    time = np.arange(round(DURATION * RATE)) / RATE
    experiment = steps_with_load_pulses(EXCITATION_SEED, MOTION, DURATION)
    sensors = {"joint_position": ENCODER, "motor_position": Sensor(2e-5, step=counts(14) / 16)}
    run = simulate(actuator, experiment, time)
    return sample(run, sensors, EXCITATION_SEED, ("motor_position", "joint_position"))


def text(table: dict[str, NDArray[np.float64]]) -> pd.DataFrame:
    """Every number as the text that is written; z writes no negative zero."""
    digits = {"time_s": "{:.3f}", "joint_torque_Nm": "{:z.2f}"}
    return pd.DataFrame(
        {
            name: [digits.get(name, "{:z.6f}").format(value) for value in values]
            for name, values in table.items()
        }
    )


def main() -> None:
    """Write the two files."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument(
        "--output", type=Path, default=EXAMPLE,
        help="folder to write into (default: the example's)",
    )  # fmt: skip
    folder: Path = parser.parse_args().output
    folder.mkdir(parents=True, exist_ok=True)
    actuator = machine()
    for name, make in (("static_curve", static_curve), ("excitation", excitation)):
        path = folder / f"{name}.csv"
        text(make(actuator)).to_csv(path, index=False, lineterminator="\n")
        print(f"wrote {path}")


if __name__ == "__main__":
    main()
