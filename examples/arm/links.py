"""The arm's links in MuJoCo, and what moves its motors, as an FMU that Python runs.

Built and connected by system.py; needs pythonfmu, MuJoCo and NumPy where it runs.
"""

from pathlib import Path

import mujoco
import numpy as np
from pythonfmu import Fmi2Causality, Fmi2Slave, Real

JOINTS = ("base", "shoulder", "elbow", "wrist")
OUTPUTS = ("motor_position", "motor_velocity", "joint_position", "joint_velocity")


class Links(Fmi2Slave):
    """Joint torques in; where motors and joints are, out."""

    def __init__(self, **options):
        super().__init__(**options)
        resources = Path(self.resources or Path(__file__).parent)
        self.robot = mujoco.MjModel.from_xml_path(str(resources / "arm.xml"))
        self.data = mujoco.MjData(self.robot)
        start, swing, period, pose = np.loadtxt(resources / "motion.txt")
        self.start, self.swing, self.rate = start, swing, 2 * np.pi / period
        self.data.qpos[:] = pose
        for joint in JOINTS:
            self._register(f"{joint}_joint_torque", Fmi2Causality.input)
            for name in OUTPUTS:
                self._register(f"{joint}_{name}", Fmi2Causality.output)
        self._show(0.0)

    def _register(self, name, causality):
        setattr(self, name, 0.0)
        self.register_variable(Real(name, causality=causality))

    def _show(self, now):
        turned = 0.5 * (1 - np.cos(self.rate * now))
        columns = (
            self.start + self.swing * turned,
            0.5 * self.swing * self.rate * np.sin(self.rate * now),
            self.data.qpos,
            self.data.qvel,
        )
        for name, values in zip(OUTPUTS, columns, strict=True):
            for joint, value in zip(JOINTS, values, strict=True):
                setattr(self, f"{joint}_{name}", float(value))

    def do_step(self, current_time, step_size):
        self.robot.opt.timestep = step_size
        self.data.qfrc_applied[:] = [getattr(self, f"{joint}_joint_torque") for joint in JOINTS]
        mujoco.mj_step(self.robot, self.data)
        self._show(current_time + step_size)
        return True
