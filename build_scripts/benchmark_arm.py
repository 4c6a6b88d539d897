"""Cost of actuators that another simulator steps, beside MuJoCo's step of the arm of examples/arm.

    python build_scripts/benchmark_arm.py

One step of 1 ms. Positions are given as NumPy arrays, as MuJoCo has them. What actuators remember
costs more; threads pay where there are many.
"""

import sys
from pathlib import Path

import mujoco
import numpy as np

from benchmarking import Row, at_most, fastest, print_table, spoken
from elastic_tendon.actuator.parameters import Model, load_model
from elastic_tendon.simulation.actuators import Actuators

ARM = Path(__file__).resolve().parents[1] / "examples" / "arm" / "arm.xml"
STEP = 1e-3  # s
LIMIT = 2.0  # µs, a step and actuator
CALLS = 500  # in one time that is taken
MANY = 1000


def of_actuators(models: list[Model], threads: int = 1) -> float:
    """Least time of a step of one actuator, s."""
    actuators = Actuators(models, threads=threads)
    still = np.zeros(len(models))
    moving = [still + 0.05 * np.sin(0.02 * number) for number in range(CALLS)]
    rates = [still + np.cos(0.02 * number) for number in range(CALLS)]

    def run() -> None:
        for position, velocity in zip(moving, rates, strict=True):
            actuators.step(STEP, still, still, position, velocity)

    return fastest(run, 20) / CALLS / len(models)


def of_mujoco() -> float:
    """Least time of a step of the arm, s."""
    robot = mujoco.MjModel.from_xml_path(str(ARM))
    data = mujoco.MjData(robot)

    def run() -> None:
        for _ in range(CALLS):
            mujoco.mj_step(robot, data)

    return fastest(run, 20) / CALLS


def rows() -> list[Row]:
    """All rows."""
    model = load_model("biorob_x4_joint_3").at("joint")
    hysteresis = {"force": 20.0, "yield_length": 1e-3, "exponent": 1.0}
    remembering = model.with_effect("spring_hysteresis", hysteresis)
    step = of_mujoco()
    four = of_actuators([model] * 4)
    return [
        at_most("a step of one actuator of four", 1e6 * four, LIMIT, "µs"),
        Row("all four / mj_step", f"{4 * four / step:.2g}", beside=f"mj_step {spoken(step)}"),
        Row("with hysteresis, of four", spoken(of_actuators([remembering] * 4))),
        Row(f"of {MANY}", spoken(of_actuators([model] * MANY))),
        Row(
            f"of {MANY} with hysteresis, 2 threads",
            spoken(of_actuators([remembering] * MANY, threads=2)),
            beside=f"1 thread {spoken(of_actuators([remembering] * MANY))}",
        ),
    ]


def main() -> int:
    """Print the table; exit status."""
    return print_table("Actuators of an arm, a step of 1 ms", rows())


if __name__ == "__main__":
    sys.exit(main())
