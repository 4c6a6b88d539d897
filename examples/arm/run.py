"""Drive an arm with four elastic joints in MuJoCo, and see where tendons go slack.

    python examples/arm/run.py [FOLDER]

Prints the largest stable steps, the error of the coupling as the step halves, and what the
actuators cost beside MuJoCo. Draws arm.png in FOLDER (default: here).
"""

import argparse
import time
from itertools import pairwise
from pathlib import Path

import matplotlib.pyplot as plt
import mujoco
import numpy as np

import elastic_tendon as et

HERE = Path(__file__).parent
ROBOT = HERE / "arm.xml"
ACTUATORS = {
    "base": et.load_model("figure_8"),
    "shoulder": et.load_model("biorob_x4_joint_3"),
    "elbow": et.load_model("biorob_x4_joint_3"),
    "wrist": et.load_model("bench_actuator"),
}
DURATION = 4.0  # s
POSE = np.array([0.0, -0.5, 0.9, 0.3])  # rad, at the start
SWING = np.array([0.9, 0.6, -0.9, 0.5])  # rad, of the motors
PERIOD = np.array([4 / 3, 2.0, 1.0, 0.8])  # s
STEPS = (2e-3, 1e-3, 5e-4, 2.5e-4)  # s, each half of the one before
SLACK_STATES = {1: ("lower slack", "#D55E00"), 2: ("upper slack", "#0072B2")}


# ---- the arm and its motion ----------------------------------------------------------------


def arm_at(step: float, **options: bool) -> et.Arm:
    """The arm at rest in its pose, with steps of this length, s."""
    robot = mujoco.MjModel.from_xml_path(str(ROBOT))
    robot.opt.timestep = step
    arm = et.Arm(robot, ACTUATORS, **options)
    arm.reset(POSE)
    return arm


def motors(start: np.ndarray, now: float) -> tuple[np.ndarray, np.ndarray]:
    """Motor positions, rad, and their rates: swings that begin and end at rest."""
    rate = 2 * np.pi / PERIOD
    turned = 0.5 * (1 - np.cos(rate * now))
    return start + SWING * turned, 0.5 * SWING * rate * np.sin(rate * now)


def move(arm: et.Arm, duration: float = DURATION) -> dict[str, np.ndarray]:
    """Times, motors, joints and slack states after each step."""
    start = arm.motor_position.copy()
    rows = []
    while arm.data.time < duration - 1e-9:
        arm.step(*motors(start, arm.data.time + arm.robot.opt.timestep))
        state = arm.actuators["slack_state"]
        rows.append((arm.data.time, arm.motor_position, arm.joint_position, state))
    columns = map(np.array, zip(*rows, strict=True))
    return dict(zip(("time", "motor", "joint", "slack_state"), columns, strict=True))


# ---- what is measured on it ----------------------------------------------------------------


def changes(**options: bool) -> dict[float, float]:
    """By how much a joint moves elsewhere, rad at most, when a step (s) is halved: about half of
    that step's error, as the coupling is of first order."""
    joints = [move(arm_at(step, **options))["joint"] for step in STEPS]
    return {
        step: float(np.abs(longer - shorter[1::2]).max())
        for step, (longer, shorter) in zip(STEPS, pairwise(joints), strict=False)
    }


def costs(arm: et.Arm, repetitions: int = 2000) -> tuple[float, float]:
    """Least times of a step, s: of one actuator, and of MuJoCo."""
    motor = arm.motor_position
    position, still = arm.joint_position, np.zeros(len(motor))
    step = arm.robot.opt.timestep

    def least(call: object, *arguments: object) -> float:
        times = []
        for _ in range(20):
            begin = time.perf_counter()
            for _ in range(repetitions // 20):
                call(*arguments)
            times.append((time.perf_counter() - begin) / (repetitions // 20))
        return min(times)

    ours = least(arm.actuators.step, step, motor, still, position, still)
    return ours / len(motor), least(mujoco.mj_step, arm.robot, arm.data)


def draw(run: dict[str, np.ndarray], picture: Path) -> None:
    figure, rows = plt.subplots(4, 1, figsize=(7, 8), sharex=True, layout="constrained")
    for index, (axes, name) in enumerate(zip(rows, ACTUATORS, strict=True)):
        share = ACTUATORS[name].transmission.motor_share
        axes.plot(run["time"], share * run["motor"][:, index], color="0.6", label="motor")
        axes.plot(run["time"], run["joint"][:, index], color="#009E73", label="joint")
        for state, (label, colour) in SLACK_STATES.items():
            there = run["slack_state"][:, index] == state
            shade = {"color": colour, "alpha": 0.4, "linewidth": 0, "label": label}
            axes.fill_between(
                run["time"], 0, 1, there, transform=axes.get_xaxis_transform(), **shade
            )
        axes.set(ylabel=f"{name} (rad)")
    rows[-1].set(xlabel="time (s)")
    figure.legend(*rows[0].get_legend_handles_labels(), loc="outside upper center", ncols=4)
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
    arm = arm_at(1e-3)
    explicit, told = arm.largest_stable_step(), arm.largest_stable_step(semi_implicit=True)
    print(f"largest stable step, explicit: {1e3 * explicit:.1f} ms")
    every = "any" if np.isinf(told) else f"{1e3 * told:.1f} ms"
    print(f"largest stable step, semi-implicit: {every}")
    ours, theirs = costs(arm)
    print(
        f"an actuator's step takes {1e6 * ours:.2f} µs, {ours / theirs:.2f} of mj_step's "
        f"{1e6 * theirs:.1f} µs"
    )
    run = move(arm_at(1e-3))
    for index, name in enumerate(ACTUATORS):
        slack = np.mean(run["slack_state"][:, index] != 3)
        print(f"{name}: a tendon is slack for {100 * slack:.0f} % of the time")
    for words, options in (("explicit", {}), ("semi-implicit", {"semi_implicit": True})):
        for step, change in changes(**options).items():
            print(f"{words}, {1e3 * step:g} ms halved: joints move by {1e3 * change:.2f} mrad")
    draw(run, folder / "arm.png")


if __name__ == "__main__":
    main(chosen_folder())
