"""Draw the arm of examples/arm while it moves, its joints coloured where a tendon is slack.

    python build_scripts/draw_arm.py [PICTURE]

Writes PICTURE (default: examples/arm/arm.gif). The colours, orange and blue beside grey, differ
also for those who see few colours; which tendon is slack is written too.
"""

import argparse
import runpy
import sys
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import mujoco
import numpy as np
from matplotlib.animation import FuncAnimation, PillowWriter
from matplotlib.lines import Line2D
from numpy.typing import NDArray

EXAMPLE = Path(__file__).resolve().parents[1] / "examples" / "arm"
TAUT = "#999999"
RATE = 20  # frames a second
REACH = 0.75  # m
DOTS = 60  # to the inch

Points = NDArray[np.float64]


def frames(example: dict[str, Any]) -> list[tuple[Points, Points]]:
    """Of each frame: ends of the links, (6, 3) m, and slack states of the joints, (4,)."""
    arm = example["arm_at"](1e-3)
    start = arm.motor_position.copy()
    every = round(1.0 / (RATE * arm.robot.opt.timestep))
    shown = []
    for count in range(round(example["DURATION"] * RATE) * every):
        arm.step(*example["motors"](start, (count + 1) * arm.robot.opt.timestep))
        if count % every == 0:
            shown.append((_ends(arm.robot, arm.data), arm.actuators["slack_state"]))
    return shown


def _ends(robot: Any, data: Any) -> Points:
    """Floor, foot, shoulder, elbow, wrist and tip."""
    mujoco.mj_kinematics(robot, data)
    hand = robot.body("hand").id
    tip = data.xpos[hand] + data.xmat[hand].reshape(3, 3) @ [0.1, 0.0, 0.0]
    bodies = [data.xpos[robot.body(name).id] for name in ("column", "upper_arm", "forearm", "hand")]
    return np.array([np.zeros(3), *bodies, tip])


def animate(example: dict[str, Any], picture: Path) -> None:
    """Write the picture."""
    shown, colours = frames(example), example["SLACK_STATES"]
    figure = plt.figure(figsize=(6, 5), layout="constrained")
    axes = figure.add_subplot(projection="3d")
    axes.set(xlim=(-0.2, REACH), ylim=(-0.3, 0.65), zlim=(0, 0.8))
    axes.set_box_aspect((0.95, 0.95, 0.8), zoom=1.0)
    axes.set(xlabel="x (m)", ylabel="y (m)", zlabel="z (m)")
    axes.view_init(elev=22, azim=-70)
    (links,) = axes.plot([], [], [], color="black", linewidth=4, solid_capstyle="round")
    (shadow,) = axes.plot([], [], [], color="0.85", linewidth=4)
    joints = [axes.plot([], [], [], "o", markersize=15, markeredgecolor="black")[0] for _ in "1234"]
    marks = [(TAUT, "both tendons taut"), *((colour, text) for text, colour in colours.values())]
    legend = [
        Line2D([], [], color=colour, marker="o", linestyle="", markersize=11, label=text)
        for colour, text in marks
    ]
    figure.legend(handles=legend, loc="outside upper center", ncols=3)

    def draw(index: int) -> list[Any]:
        ends, states = shown[index]
        links.set_data_3d(*ends.T)
        shadow.set_data_3d(ends[:, 0], ends[:, 1], 0 * ends[:, 2])
        for joint, at, state in zip(joints, ends[1:5], states, strict=True):
            joint.set_data_3d(*at[:, None])
            joint.set_color(colours[int(state)][1] if int(state) in colours else TAUT)
            joint.set_markeredgecolor("black")
        return [links, shadow, *joints]

    animation = FuncAnimation(figure, draw, frames=len(shown))
    animation.save(picture, writer=PillowWriter(fps=RATE), dpi=DOTS)
    print(f"{picture}: {len(shown)} frames, {picture.stat().st_size / 1e6:.2f} MB")


def main() -> int:
    """Draw what the command line asks for; exit status."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("picture", nargs="?", type=Path, default=EXAMPLE / "arm.gif")
    animate(runpy.run_path(str(EXAMPLE / "run.py")), parser.parse_args().picture)
    return 0


if __name__ == "__main__":
    sys.exit(main())
