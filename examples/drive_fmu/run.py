"""Export an actuator as an FMU and drive it with fmpy, as a system simulator would.

    python examples/drive_fmu/run.py [FOLDER]

The motor swings faster and faster; the tendons go slack in turn. Draws loop.png in FOLDER
(default: here): joint torque against deflection, coloured by slack state, and the motion.
"""

import argparse
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from fmpy import simulate_fmu

import elastic_tendon as et

HERE = Path(__file__).parent
SLACK_STATES = {1: ("I: lower slack", "#D55E00"), 2: ("II: upper slack", "#0072B2")}
SLACK_STATES[3] = ("III: both taut", "#009E73")


def motor_motion() -> np.ndarray:
    """A swing of 0.25 rad whose frequency rises from 0.5 to 4 Hz in 5 s."""
    time = np.arange(0.0, 5.0, 0.002)
    motor_position = 0.25 * np.sin(2 * np.pi * (0.5 * time + 0.35 * time**2))
    names = ("time", "motor_position", "motor_velocity", "load_torque")
    inputs = np.zeros(time.size, dtype=[(name, float) for name in names])
    inputs["time"], inputs["motor_position"] = time, motor_position
    return inputs


def draw(inputs: np.ndarray, motion: np.ndarray, picture: Path) -> None:
    figure, (loop, course) = plt.subplots(2, 1, figsize=(7, 7), layout="constrained")
    for state, (label, colour) in SLACK_STATES.items():
        there = motion["slack_state"] == state
        loop.plot(
            motion["deflection"][there],
            motion["joint_torque"][there],
            ".",
            color=colour,
            label=label,
        )
    loop.set(xlabel="deflection (rad)", ylabel="joint torque (N·m)")
    loop.legend()
    course.plot(inputs["time"], inputs["motor_position"], color="0.6", label="motor")
    course.plot(motion["time"], motion["joint_position"], color="#0072B2", label="joint")
    course.set(xlabel="time (s)", ylabel="position (rad)")
    course.legend(loc="lower left")
    figure.savefig(picture, dpi=110)


def chosen_folder() -> Path:
    """FOLDER of the command line, created if missing."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    told = "where the picture goes (default: beside this script); created if missing"
    parser.add_argument("folder", nargs="?", type=Path, default=HERE, metavar="FOLDER", help=told)
    folder = parser.parse_args().folder
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        parser.error(f"{folder} cannot be made a folder: {error.strerror}")
    return folder


def main(folder: Path) -> None:
    inputs = motor_motion()
    with tempfile.TemporaryDirectory() as work:
        fmu = et.export_fmu(et.load_model("biorob_x4_joint_3"), Path(work) / "actuator.fmu")
        motion = simulate_fmu(
            str(fmu),
            stop_time=inputs["time"][-1],
            output_interval=0.001,  # fmpy holds the inputs from one step to the next
            input=inputs,
            output=["joint_position", "joint_torque", "deflection", "slack_state"],
        )
    for state, (label, _) in SLACK_STATES.items():
        share = np.mean(motion["slack_state"] == state)
        print(f"{label}: {100 * share:.0f} % of the time")
    draw(inputs, motion, folder / "loop.png")


if __name__ == "__main__":
    main(chosen_folder())
