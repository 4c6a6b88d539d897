"""Sampled LQG controllers of the joint's position, designed on linear models."""

from collections.abc import Mapping
from dataclasses import dataclass

import control
import numpy as np

from elastic_tendon import Drive, LinearModel, Model, OperatingPoint, SlackState, linearise

SAMPLE = 1e-3  # s
ENCODER = 1e-4  # rad, step of both encoders
LOAD = 7.5  # N·m at which the slack states are linearised: far from both of their boundaries
EFFORT = 3e-4  # s²: what the motor's velocity costs, squared, beside the joint's error
MOTOR_DRIFT = 3e-5  # rad/√s: a motor that never strayed would leave the Riccati equation singular
# the states: joint position, joint velocity, motor position, and the load that is observed
MOTION, LOADED = slice(0, 3), 3
JOINT, JOINT_VELOCITY, MOTOR = 0, 1, 2


@dataclass(frozen=True)
class Controller:
    """An observer of motion and load, and the feedback of what it observes.

    Attributes
    ----------
    model : sampled model of motion and load
    K, L : gains of the feedback (1, 4) and of the observer (4, 2)
    acceleration : (4,), of the joint by each of the states
    origin : (4,), where the model lies; the joint is at 0 there
    """

    model: control.StateSpace
    K: np.ndarray
    L: np.ndarray
    acceleration: np.ndarray
    origin: np.ndarray

    @property
    def feedback(self) -> control.StateSpace:
        """From what the encoders read to the command: negative feedback closes the loop."""
        A = self.model.A - self.model.B @ self.K - self.L @ self.model.C
        return control.ss(A, self.L, self.K, 0.0, SAMPLE)

    def command(self, x: np.ndarray, reference: np.ndarray) -> float:
        """Velocity of the motor, by what is observed and the reference.

        `reference` is a position and its first three derivatives. The springs move the joint
        along it if the motor leads it by the right deflection; `lead` is the motor's target, but
        for what the load takes, which K adds.
        """
        position, velocity, acceleration, jerk = reference
        by_position, by_velocity, by_motor, _ = self.acceleration
        lead = (acceleration - by_position * position - by_velocity * velocity) / by_motor
        lead_rate = (jerk - by_position * velocity - by_velocity * acceleration) / by_motor
        target = self.origin + np.array([position, velocity, lead, 0.0])
        return lead_rate - (self.K @ (x - target)).item()

    def observe(self, x: np.ndarray, u: float, y: np.ndarray) -> np.ndarray:
        """The state one sample later, by the command and the positions of joint and motor."""
        moved = self.model.A @ (x - self.origin) + self.model.B[:, 0] * u
        return self.origin + moved + self.L @ (y - x[[JOINT, MOTOR]])

    def at_rest(self, motor_position: float) -> np.ndarray:
        """The state at rest with the joint at 0: what the model's springs hold is the load."""
        x = self.origin.copy()
        x[MOTOR] = motor_position
        x[LOADED] -= self.acceleration @ (x - self.origin) / self.acceleration[LOADED]
        return x


Design = Mapping[SlackState, Controller]  # which controller acts in which slack state


def plants(model: Model) -> dict[SlackState, LinearModel]:
    """Linear models of all states, from motor velocity and load to both positions."""
    loads = {SlackState.I: -LOAD, SlackState.II: LOAD, SlackState.III: 0.0}
    return {
        state: linearise(
            model,
            state,
            OperatingPoint(load_torque=load, joint_position=0.0),
            drive=Drive.VELOCITY,
            outputs=["joint_position", "motor_position"],
        )
        for state, load in loads.items()
    }


def origin(plant: LinearModel) -> np.ndarray:
    """Where a linear model lies, as a state of the controller."""
    at = plant.validity.operating_point
    motion = [at.states["joint_position"], at.states["joint_velocity"]]
    return np.array([*motion, at.inputs["motor_position"], at.inputs["load_torque"]])


def lqg(plant: control.StateSpace, origin: np.ndarray, load_drift: float) -> Controller:
    """LQG on a model whose load is a fourth state; observing it makes the controller integrate.

    The command uses measurements up to the sample before: this delay is part of the design.

    Parameters
    ----------
    plant : from motor velocity and load to joint and motor position
    origin : where it lies
    load_drift : N·m/√s, how fast the observer expects the load to change
    """
    A = np.vstack([np.hstack([plant.A, plant.B[:, 1:]]), np.zeros(4)])
    B = np.vstack([plant.B[:, :1], [[0.0]]])
    C = np.hstack([plant.C, np.zeros((2, 1))])
    model = control.c2d(control.ss(A, B, C, 0.0), SAMPLE)
    cost = np.diag([1.0, 0.0, 0.0])  # of the error; the motor may be anywhere
    motion, _, _ = control.dlqr(model.A[MOTION, MOTION], model.B[MOTION], cost, [[EFFORT]])
    # the motor's target gives way to the load
    K = np.hstack(
        [motion, motion[:, [MOTOR]] * A[JOINT_VELOCITY, LOADED] / A[JOINT_VELOCITY, MOTOR]]
    )
    drift = SAMPLE * np.diag([0.0, 0.0, MOTOR_DRIFT**2, load_drift**2])
    L, _, _ = control.dlqe(model.A, np.eye(4), C, drift, np.eye(2) * ENCODER**2 / 12.0)
    return Controller(model, K, L, A[JOINT_VELOCITY], origin)


def softened(taut: LinearModel, slack: LinearModel, share: float) -> control.StateSpace:
    """A plant on the way from one state to another: stiffness enters A alone, and linearly."""
    return control.ss((1.0 - share) * taut.A + share * slack.A, taut.B, taut.C, taut.D)


def stiffness(plant: control.StateSpace) -> float:
    """Load for each radian of the joint (N·m/rad), the motor held and all at rest."""
    return float(-plant.A[JOINT_VELOCITY, JOINT] / plant.B[JOINT_VELOCITY, 1])
