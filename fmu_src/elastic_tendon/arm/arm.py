"""An arm whose links MuJoCo moves and whose joints elastic tendon actuators drive."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from elastic_tendon.actuator.interfaces import InterfaceKind
from elastic_tendon.actuator.parameters import Model
from elastic_tendon.arm.robot import joint_numbers, joints_of, mass_matrix, mujoco
from elastic_tendon.arm.stability import largest_stable_step
from elastic_tendon.effects import BY_ID
from elastic_tendon.errors import ArmError, SimulationError
from elastic_tendon.simulation.actuators import Actuators

Array = NDArray[np.float64]

_CHANGE = 1e-6  # rad and rad/s, of the joints, to see how the torques answer within a step
_MOST_STEPS, _CLOSE = 50, 1e-10  # of Newton's method for the motors that hold the arm, N·m


class Arm:
    """Joints of a robot in MuJoCo, driven by actuators whose motors move as they are told.

    After each step the torques of the actuators are written to ``data.qfrc_applied`` of their
    joints; forces of your own belong to ``data.xfrc_applied``. What drove these joints before, as a
    servo in the robot's file, is yours to remove.

    Parameters
    ----------
    robot : mujoco.MjModel, of any MJCF or URDF
    actuators : name of a hinge of the robot -> Model of its actuator, at any interface; its link
        is the robot's, and what acts at the link is not simulated here
    semi_implicit : tell MuJoCo's step how the torques fall with position and velocity, as damping
        of the joints; longer steps are stable then, but swings are damped where they are long
    passes : (actuator, joint) -> number; the tendons of the actuator's joint pass another joint on
        a pulley of this many times the radius of their own, negative where they cross. The
        deflection is counted with it, and that joint bears its share of the torque

    Attributes
    ----------
    data : mujoco.MjData of the robot
    actuators : Actuators, in the order in which they were given
    joints : names of their joints

    Raises
    ------
    ArmError
        for a joint that there is not or that is no hinge, a model with effects beyond the springs,
        an integrator that cannot be coupled, or a step of the robot that is not stable
    """

    def __init__(
        self,
        robot: Any,
        actuators: Mapping[str, Model],
        *,
        semi_implicit: bool = False,
        passes: Mapping[tuple[str, str], float] | None = None,
    ) -> None:
        self.robot, self.joints = robot, tuple(actuators)
        self._places, self._dofs = joint_numbers(robot, self.joints)
        self._wiring = _wiring(self.joints, passes or {})
        self._joint_damping = robot.dof_damping.copy()
        self.semi_implicit = semi_implicit
        self._check_coupling()
        self._mujoco = mujoco()
        self.data = self._mujoco.MjData(robot)
        # views, which last; to ask MuJoCo for one takes as long as an actuator's step
        self._position, self._velocity = self.data.qpos, self.data.qvel
        self._force = self.data.qfrc_applied
        self.actuators = Actuators([_at_joint(*pair) for pair in actuators.items()])
        self.reset()

    def __repr__(self) -> str:
        every = joints_of(self.robot)
        return f"Arm of {len(every)} joints ({', '.join(every)}), elastic: {', '.join(self.joints)}"

    def reset(
        self, joint_position: ArrayLike | None = None, motor_position: ArrayLike | None = None
    ) -> None:
        """Begin anew at rest, all else of the robot as its file says.

        Parameters
        ----------
        joint_position : (n,) array, rad; as the robot's file says where missing
        motor_position : (n,) array, rad; what holds the joints there where missing

        Raises
        ------
        ArmError
            where the robot's step is not stable there, no motors hold it, or a position is missing
        """
        self._mujoco.mj_resetData(self.robot, self.data)
        self.robot.dof_damping[:] = self._joint_damping
        if joint_position is not None:
            if np.shape(joint_position) != (len(self.joints),):
                raise ArmError(
                    f"joint_position has shape {np.shape(joint_position)}, but {len(self.joints)} "
                    f"joints have actuators ({', '.join(self.joints)}); give one position for each"
                )
            self._position[self._places] = joint_position
        self._mujoco.mj_forward(self.robot, self.data)
        holding = self.motors_that_hold() if motor_position is None else motor_position
        self.motor_position = np.array(np.broadcast_to(holding, len(self.joints)), float)
        self.actuators.reset(self.motor_position, 0.0, *self._seen())
        limit = self.largest_stable_step()
        if self.robot.opt.timestep > limit:
            advice = "" if self.semi_implicit else ", or let the arm be semi_implicit"
            raise ArmError(
                f"the robot's step of {1e3 * self.robot.opt.timestep:.3g} ms is longer than "
                f"{1e3 * limit:.3g} ms, beyond which the arm is unstable in this pose; set "
                f"robot.opt.timestep to less{advice}"
            )
        self._apply()

    def step(self, motor_position: ArrayLike, motor_velocity: ArrayLike) -> None:
        """One step of the robot, ``robot.opt.timestep``, and of all actuators.

        Parameters
        ----------
        motor_position : (n,) array, rad at the motor pulleys, at the end of the step
        motor_velocity : (n,) array, rad/s, its rate there

        Raises
        ------
        SimulationError
            where the arm has become unstable or an actuator cannot go on
        """
        before = self.data.time
        self._mujoco.mj_step(self.robot, self.data)
        step = self.data.time - before
        if not step > 0:  # MuJoCo begins anew where accelerations are huge
            raise SimulationError(
                f"the arm became unstable at {before:.6g} s; set robot.opt.timestep to less than "
                f"{1e3 * self.robot.opt.timestep:.3g} ms, or let the arm be semi_implicit"
            )
        self.motor_position = np.array(motor_position, float)
        self.actuators.step(step, self.motor_position, motor_velocity, *self._seen())
        self._apply()

    @property
    def joint_position(self) -> Array:
        """Positions of the joints, (n,), rad."""
        return np.array(self._position[self._places])

    def largest_stable_step(self, semi_implicit: bool | None = None) -> float:
        """Largest step that is stable in the present pose, s; infinite where all are.

        Of the linear arm about the pose: the mass matrix there, and how the torques answer to the
        joints within one step, with what the actuators remember.

        Parameters
        ----------
        semi_implicit : of this coupling; of the arm's own where missing
        """
        implicit = self.semi_implicit if semi_implicit is None else semi_implicit
        given = self.actuators.stiffness_and_damping() if implicit else (0.0, 0.0)
        answers = self._answers()
        return largest_stable_step(
            mass_matrix(self.robot, self.data),
            *(self._at_dofs(numbers) for numbers in answers),
            joint_damping=np.diag(self._joint_damping),
            given_stiffness=self._at_dofs(given[0]),
            given_damping=self._at_dofs(given[1]),
        )

    def motors_that_hold(self) -> Array:
        """Motor positions, (n,) rad, under which the arm rests in its present pose.

        Raises
        ------
        ArmError
            where no motors do
        """
        position, _ = self._seen()
        at_joints = self.data.qfrc_bias[self._dofs] - self.data.qfrc_passive[self._dofs]
        wanted = np.linalg.solve(self._wiring.T, at_joints)
        share = [model.transmission.motor_share for model in self.actuators.models]
        motor = position / share
        column = self.actuators.output_names.index("joint_torque")
        for _ in range(_MOST_STEPS):
            self.actuators.reset(motor, 0.0, position, 0.0)
            missing = wanted - self.actuators["joint_torque"]
            if np.abs(missing).max() <= _CLOSE * (1.0 + np.abs(wanted).max()):
                return motor
            slope = self.actuators.derivatives()[:, column, 0]
            if not np.abs(slope).min() > 0:
                break
            motor = motor + missing / slope
        raise ArmError(
            "no motor positions hold the arm in this pose; give motor_position, or begin in "
            "another pose"
        )

    # ---- between robot and actuators -------------------------------------------------------

    def _seen(self) -> tuple[Array, Array]:
        """Positions and velocities of the joints as the tendons feel them."""
        position, velocity = self._position[self._places], self._velocity[self._dofs]
        return self._wiring @ position, self._wiring @ velocity

    def _apply(self) -> None:
        """Write torques to the joints; semi-implicit, with what they lose while the joints move.

        MuJoCo steps the damping of joints implicitly, so h K + D as damping, and D v added to the
        torque, is the torque at the end of the step to first order.
        """
        torque = self._wiring.T @ self.actuators["joint_torque"]
        if self.semi_implicit:
            stiffness, damping = self.actuators.stiffness_and_damping()
            added = self.robot.opt.timestep * stiffness + damping
            self.robot.dof_damping[self._dofs] = self._joint_damping[self._dofs] + added
            torque += damping * self._velocity[self._dofs]
        self._force[self._dofs] = torque

    def _answers(self) -> tuple[Array, Array]:
        """By how much torques have fallen at the end of a step in which the joints moved a little
        more, by position and velocity."""
        saved, step = self.actuators.save(), self.robot.opt.timestep
        position, velocity = self._seen()

        def torque(further: float, faster: float) -> Array:
            self.actuators.restore(saved)
            moved = (position + further, velocity + faster)
            self.actuators.step(step, self.motor_position, 0.0, *moved)
            return self.actuators["joint_torque"]

        # the way on which friction and hysteresis answer most
        answers = []
        for change in np.eye(2) * _CHANGE:
            at_rest = torque(0.0, 0.0)
            ways = [sign * (at_rest - torque(*(sign * change))) / _CHANGE for sign in (1, -1)]
            answers.append(np.max(ways, axis=0))
        self.actuators.restore(saved)
        return answers[0], answers[1]

    def _at_dofs(self, numbers: ArrayLike) -> Array:
        """Matrix of all degrees of freedom of a number for each actuator."""
        matrix = np.zeros((self.robot.nv, self.robot.nv))
        own = self._wiring.T @ np.diag(np.broadcast_to(numbers, len(self.joints))) @ self._wiring
        matrix[np.ix_(self._dofs, self._dofs)] = own
        return matrix

    def _check_coupling(self) -> None:
        if self.robot.opt.integrator == mujoco().mjtIntegrator.mjINT_RK4:
            raise ArmError(
                "the integrator RK4 looks at torques within a step, which the arm cannot give; set "
                "robot.opt.integrator to Euler or implicitfast"
            )
        if self.semi_implicit and not np.array_equal(self._wiring, np.eye(len(self.joints))):
            raise ArmError(
                "semi_implicit needs tendons that move one joint each; leave it or passes out"
            )


def _at_joint(joint: str, model: Model) -> Model:
    """The model as a force between motor and link."""
    at_link = [
        effect_id
        for effect_id in model.effects
        if not InterfaceKind.JOINT.has_slot(BY_ID[effect_id].slot)
    ]
    if at_link:
        raise ArmError(
            f"{model.name} at {joint} has {', '.join(at_link)}, beyond the springs; give the "
            "robot's joint what is like it, as frictionloss, and the arm the model without"
        )
    return model.at(InterfaceKind.JOINT)


def _wiring(joints: tuple[str, ...], passes: Mapping[tuple[str, str], float]) -> Array:
    """Positions as the tendons feel them, of those of the joints."""
    wiring = np.eye(len(joints))
    for (actuator, joint), ratio in passes.items():
        for name in (actuator, joint):
            if name not in joints:
                raise ArmError(
                    f"passes names {name!r}, which has no actuator; there are {', '.join(joints)}"
                )
        if actuator == joint:
            raise ArmError(f"the tendons of {joint} end there and cannot pass it; leave it out")
        wiring[joints.index(actuator), joints.index(joint)] = ratio
    return wiring
