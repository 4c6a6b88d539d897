"""What moves the motor, put into a linear model that has position and velocity as inputs.

The velocity is the derivative of the position, which no linear model may be given as an input of
its own without saying so. Each way here is exact; none differentiates.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from elastic_tendon.actuator.sections import Motor
from elastic_tendon.actuator.variables import INPUTS
from elastic_tendon.errors import LinearisationError
from elastic_tendon.linear.plant import Jacobians
from elastic_tendon.linear.result import Array, Drive, Equilibrium

SHIFTED = "_shifted"  # ends the name of a state less what the motor's position makes of it
MOTOR_TORQUE, DRIVE_TORQUE = "motor_torque", "motor_drive_torque"
MOTOR_POSITION, MOTOR_VELOCITY, LOAD_TORQUE = (variable.name for variable in INPUTS)


@dataclass(frozen=True)
class Matrices:
    """A (n, n), B (n, m), C (k, n), D (k, m) with the names of states, inputs and outputs."""

    A: Array
    B: Array
    C: Array
    D: Array
    states: tuple[str, ...]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]


def driven_by_source(
    jacobians: Jacobians, states: tuple[str, ...], outputs: tuple[str, ...]
) -> Matrices:
    """Position and velocity of the motor are inputs of their own, as of the FMU."""
    return Matrices(*jacobians, states, tuple(variable.name for variable in INPUTS), outputs)


def driven(source: Matrices, drive: Drive, motor: Motor | None, name: str) -> Matrices:
    """The linear model with another drive than that of `driven_by_source`.

    Parameters
    ----------
    source : Matrices, by `driven_by_source`
    drive : Drive
    motor : [motor] of model.toml, needed by Drive.TORQUE
    name : of the model, for messages

    Raises
    ------
    LinearisationError
        where there is no [motor]
    """
    if drive is Drive.SOURCE:
        return source
    if drive is Drive.POSITION:
        return _by_position(source)
    if drive is Drive.VELOCITY:
        return _by_velocity(source)
    if motor is None:
        raise LinearisationError(
            f"{name}: a motor that is driven by a torque needs [motor] in model.toml, with inertia "
            "(kg m^2, at the motor pulley) and, where known, damping"
        )
    return _by_torque(source, motor)


def completed(
    at: Equilibrium, matrices: Matrices, source: Matrices, motor: Motor | None
) -> Equilibrium:
    """The operating point with the signals that a drive adds, so that every name has its value.

    Parameters
    ----------
    at : by states, inputs and outputs of the source
    matrices : of the drive
    source : Matrices, by `driven_by_source`
    motor : the rotor, if there is one
    """
    values = {**at.outputs, **at.inputs, **at.states}
    for name, velocity in zip(source.states, source.B[:, 1], strict=True):
        values[f"{name}{SHIFTED}"] = at.states[name] - float(velocity) * at.inputs[MOTOR_POSITION]
    if motor is not None:
        rate = at.inputs[MOTOR_VELOCITY]
        friction = motor.friction_torque * float(np.sign(rate))
        values[DRIVE_TORQUE] = at.outputs[MOTOR_TORQUE] + motor.damping * rate + friction

    def with_all(known: Mapping[str, float], names: tuple[str, ...]) -> dict[str, float]:
        return {**known, **{name: values[name] for name in names}}

    return replace(
        at,
        states=with_all(at.states, matrices.states),
        inputs=with_all(at.inputs, matrices.inputs),
        outputs=with_all(at.outputs, matrices.outputs),
    )


def _by_position(source: Matrices) -> Matrices:
    """The velocity as derivative of the position: with z = x - B_v u the input's rate goes.

    Outputs on which the velocity acts directly would be improper: they are left out.
    """
    A, B, C, D = source.A, source.B, source.C, source.D
    position, velocity, load = B.T
    proper = D[:, 1] == 0.0
    moved = [
        f"{name}{SHIFTED}" if part else name
        for name, part in zip(source.states, velocity, strict=True)
    ]
    return Matrices(
        A,
        np.column_stack([position + A @ velocity, load]),
        C[proper],
        np.column_stack([D[:, 0] + C @ velocity, D[:, 2]])[proper],
        tuple(moved),
        (MOTOR_POSITION, LOAD_TORQUE),
        tuple(name for name, kept in zip(source.outputs, proper, strict=True) if kept),
    )


def _by_velocity(source: Matrices) -> Matrices:
    """The position as a state."""
    n = len(source.states)
    A = np.block([[source.A, source.B[:, :1]], [np.zeros((1, n + 1))]])
    B = np.vstack([source.B[:, 1:], [1.0, 0.0]])
    C = np.hstack([source.C, source.D[:, :1]])
    with_motor = Matrices(
        *(A, B, C, source.D[:, 1:]),
        (*source.states, MOTOR_POSITION),
        (MOTOR_VELOCITY, LOAD_TORQUE),
        source.outputs,
    )
    return _observing(with_motor, MOTOR_POSITION)


def _by_torque(source: Matrices, motor: Motor) -> Matrices:
    """A rotor J θ'' = τ − b θ' − τ_e, τ_e the torque of the tendons at its pulley, (8).

    Its dry friction is constant while it slides, so it has no part in deviations.
    """
    n = len(source.states)
    row = source.outputs.index(MOTOR_TORQUE)
    tendons = np.concatenate([source.C[row], source.D[row]])  # by states, position, velocity, load
    A = np.zeros((n + 2, n + 2))
    A[:n, :n] = source.A
    A[:n, n:] = source.B[:, :2]
    A[n, n + 1] = 1.0
    A[n + 1] = -tendons[: n + 2] / motor.inertia
    A[n + 1, n + 1] -= motor.damping / motor.inertia
    B = np.zeros((n + 2, 2))
    B[:n, 1] = source.B[:, 2]
    B[n + 1] = np.array([1.0, -tendons[n + 2]]) / motor.inertia
    C = np.hstack([source.C, source.D[:, :2]])
    D = np.column_stack([np.zeros(len(source.outputs)), source.D[:, 2]])
    with_motor = Matrices(
        *(A, B, C, D),
        (*source.states, MOTOR_POSITION, MOTOR_VELOCITY),
        (DRIVE_TORQUE, LOAD_TORQUE),
        source.outputs,
    )
    return _observing(_observing(with_motor, MOTOR_POSITION), MOTOR_VELOCITY)


def _observing(matrices: Matrices, state: str) -> Matrices:
    """With a state as one more output."""
    row = np.array([[float(name == state) for name in matrices.states]])
    return Matrices(
        matrices.A,
        matrices.B,
        np.vstack([matrices.C, row]),
        np.vstack([matrices.D, np.zeros((1, len(matrices.inputs)))]),
        matrices.states,
        matrices.inputs,
        (*matrices.outputs, state),
    )
