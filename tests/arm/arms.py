"""The arm of the example, for tests."""

from pathlib import Path

import mujoco

import elastic_tendon as et

MJCF = Path(__file__).parents[2] / "examples" / "arm" / "arm.xml"
ACTUATORS = {
    "base": et.load_model("figure_8"),
    "shoulder": et.load_model("biorob_x4_joint_3"),
    "elbow": et.load_model("biorob_x4_joint_3"),
    "wrist": et.load_model("bench_actuator"),
}


def robot():
    """The robot, anew."""
    return mujoco.MjModel.from_xml_path(str(MJCF))
