"""What is asked of a robot of MuJoCo."""

from collections.abc import Sequence
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastic_tendon.errors import ArmError

Indices = NDArray[np.int64]


def mujoco() -> ModuleType:
    """The package; ArmError where it is not installed."""
    try:
        import mujoco
    except ImportError:
        raise ArmError(
            'arms need MuJoCo, which is not installed; pip install "elastic-tendon[mujoco]"'
        ) from None
    module: ModuleType = mujoco
    return module


def joints_of(robot: Any) -> tuple[str, ...]:
    """Names of all joints, in MuJoCo's order."""
    package = mujoco()
    return tuple(
        package.mj_id2name(robot, package.mjtObj.mjOBJ_JOINT, number) or f"number {number}"
        for number in range(robot.njnt)
    )


def mass_matrix(robot: Any, data: Any) -> NDArray[np.float64]:
    """Of all degrees of freedom in the pose of `data`, (nv, nv)."""
    mass = np.zeros((robot.nv, robot.nv))
    for column, unit in zip(mass, np.eye(robot.nv), strict=True):
        mujoco().mj_mulM(robot, data, column, unit)
    return mass


def joint_numbers(robot: Any, names: Sequence[str]) -> tuple[Indices, Indices]:
    """Where hinges stand in the robot's positions and velocities.

    Raises
    ------
    ArmError
        for a joint that there is not, or that is no hinge
    """
    known = joints_of(robot)
    if not names:
        raise ArmError(f"no joint has an actuator; the robot has {', '.join(known) or 'no joint'}")
    for name in names:
        if name not in known:
            raise ArmError(
                f"the robot has no joint {name!r}; it has {', '.join(known) or 'none at all'}"
            )
    numbers = np.array([known.index(name) for name in names], dtype=np.int64)
    for name, number in zip(names, numbers, strict=True):
        if robot.jnt_type[number] != mujoco().mjtJoint.mjJNT_HINGE:
            raise ArmError(f"joint {name} is no hinge, and tendons on pulleys turn hinges alone")
    return (
        robot.jnt_qposadr[numbers].astype(np.int64),
        robot.jnt_dofadr[numbers].astype(np.int64),
    )
