"""What a linear model says of the actuator: poles, zeros, stiffness, natural frequency.

All of it is found in state space; a transfer function's polynomials would lose digits.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from math import inf
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from elastic_tendon.actuator.variables import JOINT_MOTION
from elastic_tendon.errors import LinearisationError
from elastic_tendon.linear.drive import (
    DRIVE_TORQUE,
    LOAD_TORQUE,
    MOTOR_POSITION,
    MOTOR_TORQUE,
    MOTOR_VELOCITY,
    SHIFTED,
)
from elastic_tendon.linear.result import Array, Drive, LinearModel

JOINT_POSITION, JOINT_VELOCITY, JOINT_TORQUE = "joint_position", "joint_velocity", "joint_torque"
DEFLECTION = "deflection"
_SHARE = 0.5  # of the motions of joint and motor that deflects the tendons, if these oscillate
_CANCELS = 1e-6  # relative distance within which a zero and a pole are one

_DECADES = 1.0  # of frequencies around the poles
_PER_RANGE = 600
_NEAR = np.geomspace(1e-4, 0.1, 30)  # relative distances from resonances at which is looked

# what scipy's stubs say of these calls differs from version to version
_EIG: Any = linalg.eig
_SCHUR: Any = linalg.schur

Complex = NDArray[np.complex128]


@dataclass(frozen=True)
class Pole:
    """A pole (rad/s); of a complex pair, the one with positive imaginary part.

    `natural_frequency` is its size in rad/s, `damping_ratio` 1 for a real pole on the left, -1 on
    the right, and 0 at the origin. `time_constant` (s) of a real pole is positive where it decays
    and infinite at the origin; None of a pair.
    """

    value: complex
    natural_frequency: float
    damping_ratio: float
    time_constant: float | None

    @property
    def oscillates(self) -> bool:
        """Whether this is a complex pair."""
        return self.time_constant is None


@dataclass(frozen=True)
class Channel:
    """From one input to one output.

    Attributes
    ----------
    input, output : names
    gain : static gain in SI units; infinite where the output drifts away
    responds : whether the input reaches the output at all
    zeros : transmission zeros, rad/s, pairs in full. A zero that cancels a pole (both within 1e-6
        of each other) is left out; infinite ones do not arise, since the relative degree is found
        first: derivatives of the output of which the input's share is rounding do not count
    """

    input: str
    output: str
    gain: float
    responds: bool
    zeros: tuple[complex, ...]

    @property
    def anti_resonances(self) -> tuple[float, ...]:
        """Frequencies of complex zero pairs, rad/s, rising: there the output hardly moves."""
        return tuple(sorted(abs(zero) for zero in self.zeros if zero.imag > 0.0))


@dataclass(frozen=True)
class Analysis:
    """Numbers of a linear model.

    Attributes
    ----------
    poles : by rising natural frequency; complex pairs once
    tendon_oscillation : the slowest pair in which joint and motor move against each other rather
        than together, as an arm under gravity does with its motor; None where there is none
    stiffness : N·m/rad; load over deflection of the joint that it holds in the long run, with the
        motor held, or torque over position of a joint that is given. It includes gravity, joint
        stops and memory that does not fade (of hysteresis, of the bristles of friction at rest);
        infinite where the joint sticks
    tendon_stiffness : N·m/rad; of the tendons' torque against a small and sudden deflection of the
        joint, in which what relaxes has had no time and the memory of a hysteresis has moved along;
        (19), (23) and (25) without effects. None where joint_torque is no output (Drive.POSITION
        with damped springs, as it needs the motor's velocity) or the joint sticks, which it holds
    tendon_damping : N·m·s/rad; by joint_velocity, (20), (23) and (25); None as above
    channels : every input with every output, inputs first
    """

    poles: tuple[Pole, ...]
    tendon_oscillation: Pole | None
    stiffness: float
    tendon_stiffness: float | None
    tendon_damping: float | None
    channels: tuple[Channel, ...]

    def channel(self, input_name: str, output_name: str) -> Channel:
        """A channel by its names.

        Raises
        ------
        LinearisationError
            where there is none
        """
        for channel in self.channels:
            if (channel.input, channel.output) == (input_name, output_name):
                return channel
        raise LinearisationError(f"there is no channel from {input_name!r} to {output_name!r}")


@dataclass(frozen=True)
class FrequencySpan:
    """Lowest and highest natural frequency (rad/s) of the tendons' oscillation over the states."""

    lowest: float
    highest: float

    @property
    def ratio(self) -> float:
        """Highest over lowest."""
        return self.highest / self.lowest


def analyse(model: LinearModel) -> Analysis:
    """Poles, zeros, stiffness and natural frequencies of a linear model.

    It takes the model with all inputs and outputs, as `linearise` gives it without a selection;
    `linear.selection.selected` then takes those that are wanted elsewhere.

    Parameters
    ----------
    model : LinearModel

    Returns
    -------
    Analysis

    Raises
    ------
    LinearisationError
        where load_torque, joint_position or deflection was left out, or joint_torque of a joint
        that is given
    """
    given = is_joint_given(model)
    for kind, name, names in (
        ("input", JOINT_VELOCITY if given else LOAD_TORQUE, model.input_labels),
        ("output", JOINT_TORQUE if given else JOINT_POSITION, model.output_labels),
        ("output", DEFLECTION, model.output_labels),
    ):
        if name not in names:
            raise LinearisationError(
                f"the linear model has no {kind} {name}, which its analysis needs; linearise with "
                "all inputs and outputs, and select afterwards"
            )
    system = _System(model.A, model.B, model.C, model.D)
    channels = tuple(
        _channel(system.channel(i, j), input_name, output_name)
        for j, input_name in enumerate(model.input_labels)
        for i, output_name in enumerate(model.output_labels)
    )
    held = _gain(_motor_held(model))  # a compliance, or a stiffness
    tendon_stiffness, tendon_damping = _felt(model) if given else _tendons(model)
    return Analysis(
        _poles(model.A),
        _tendon_oscillation(model),
        0.0 - held if given else 1.0 / held if held else inf,
        tendon_stiffness,
        tendon_damping,
        channels,
    )


def is_joint_given(model: LinearModel) -> bool:
    """Whether the joint's position is an input, as at interface joint and torque_joint."""
    return JOINT_POSITION in model.input_labels


def motor_input(model: LinearModel) -> str:
    """Name of the input that moves the motor."""
    if model.drive is Drive.TORQUE:
        return DRIVE_TORQUE if DRIVE_TORQUE in model.input_labels else MOTOR_TORQUE
    return MOTOR_VELOCITY if model.drive is Drive.VELOCITY else MOTOR_POSITION


def main_channels(model: LinearModel) -> tuple[tuple[str, str], ...]:
    """Inputs and outputs that a controller of the joint meets first.

    Of a torque-driven rotor, the collocated channel comes first, then the non-collocated one; of a
    joint that is given, what it feels.
    """
    motor = motor_input(model)
    if is_joint_given(model):
        return (JOINT_POSITION, JOINT_TORQUE), (motor, JOINT_TORQUE)
    if model.drive is Drive.TORQUE:
        return (motor, MOTOR_POSITION), (motor, JOINT_POSITION), (LOAD_TORQUE, JOINT_POSITION)
    return (motor, JOINT_POSITION), (motor, JOINT_TORQUE), (LOAD_TORQUE, JOINT_POSITION)


def frequency_span(analyses: Iterable[Analysis]) -> FrequencySpan | None:
    """Between which natural frequencies the tendons' oscillation lies over several states.

    Parameters
    ----------
    analyses : of the same actuator

    Returns
    -------
    FrequencySpan; None where none of the tendons oscillates
    """
    pairs = [analysis.tendon_oscillation for analysis in analyses]
    frequencies = [pair.natural_frequency for pair in pairs if pair is not None]
    return FrequencySpan(min(frequencies), max(frequencies)) if frequencies else None


@dataclass(frozen=True)
class _System:
    """A (n, n), B (n, m), C (k, n), D (k, m)."""

    A: Array
    B: Array
    C: Array
    D: Array

    def channel(self, output: int, input_: int) -> "_System":
        """One input and one output, with states scaled so that rounding is small beside them."""
        A, scale = _balanced(self.A)
        B = self.B[:, input_ : input_ + 1] / scale[:, None]
        C = self.C[output : output + 1] * scale
        return _System(A, B, C, self.D[output : output + 1, input_ : input_ + 1])


def _balanced(A: Array) -> tuple[Array, Array]:
    """A in scaled states, and the sizes (n,) of these in the states as they were."""
    balanced, (scale, _) = linalg.matrix_balance(A, permute=False, separate=True)
    return np.asarray(balanced, float), np.asarray(scale, float)


def _motor_held(model: LinearModel) -> _System:
    """From load to joint position, or from a given one to its torque, with the motor's position,
    where it is a state, held at 0."""
    kept = [
        i
        for i, name in enumerate(model.state_labels)
        if name not in (MOTOR_POSITION, MOTOR_VELOCITY)
    ]
    system = _System(model.A[np.ix_(kept, kept)], model.B[kept], model.C[:, kept], model.D)
    names = (
        (JOINT_TORQUE, JOINT_POSITION) if is_joint_given(model) else (JOINT_POSITION, LOAD_TORQUE)
    )
    return system.channel(model.output_labels.index(names[0]), model.input_labels.index(names[1]))


def _tendons(model: LinearModel) -> tuple[float, float] | tuple[None, None]:
    """Stiffness and damping of the tendons, by what a sudden motion of the joint does at once.

    States that move with the joint's velocity, as the memory of a hysteresis, have moved along.
    """
    names = [name.removesuffix(SHIFTED) for name in model.state_labels]
    sticks = model.validity.modes.get(JOINT_MOTION.name) == 0
    if JOINT_TORQUE not in model.output_labels or JOINT_VELOCITY not in names or sticks:
        return None, None
    torque = model.C[model.output_labels.index(JOINT_TORQUE)]
    velocity = names.index(JOINT_VELOCITY)
    moved = model.A[:, velocity].copy()  # positions and memory, by a unit of deflection
    moved[_velocities(model.A)] = 0.0  # which only an impulse would change
    return float(0.0 - torque @ moved), float(0.0 - torque[velocity])  # not -0.0


def _felt(model: LinearModel) -> tuple[float, float]:
    """The same of a joint that is given."""
    torque = model.output_labels.index(JOINT_TORQUE)
    position, velocity = map(model.input_labels.index, (JOINT_POSITION, JOINT_VELOCITY))
    moved = model.B[:, velocity].copy()  # memory, by a unit of deflection
    moved[_velocities(model.A)] = 0.0
    at_once = model.D[torque, position] + model.C[torque] @ moved
    return float(0.0 - at_once), float(0.0 - model.D[torque, velocity])


def _velocities(A: Array) -> list[int]:
    """Places of the states that are the rate of another one."""
    rates = [row for row in A if np.count_nonzero(row) == 1 and row.max() == 1.0]
    return [int(row.argmax()) for row in rates]


def _tendon_oscillation(model: LinearModel) -> Pole | None:
    values, vectors = np.linalg.eig(model.A)
    deflection = model.C[model.output_labels.index(DEFLECTION)] @ vectors
    joint = np.zeros_like(deflection)
    if not is_joint_given(model):
        joint = model.C[model.output_labels.index(JOINT_POSITION)] @ vectors
    deflects = np.abs(deflection) > _SHARE * (np.abs(joint) + np.abs(joint - deflection))
    oscillating = values[deflects & (values.imag > 0.0)]
    return _pole(complex(oscillating[np.argmin(np.abs(oscillating))])) if oscillating.size else None


def _poles(A: Array) -> tuple[Pole, ...]:
    values = [value for value in _eigenvalues(A) if value.imag >= 0.0]
    return tuple(
        _pole(value) for value in sorted(values, key=lambda value: (abs(value), value.imag))
    )


def _pole(value: complex) -> Pole:
    frequency = abs(value)
    if value.imag:
        return Pole(value, frequency, -value.real / frequency, None)
    if value.real == 0.0:
        return Pole(value, 0.0, 0.0, inf)
    return Pole(value, frequency, float(-np.sign(value.real)), -1.0 / value.real)


def _eigenvalues(A: Array, size: float = 0.0) -> list[complex]:
    """Eigenvalues; 0 for those which rounding cannot distinguish from 0, judged by their condition.

    `size` is that of the terms by which A was found, where they are larger than A. A double
    eigenvalue at 0 comes out as large as sqrt(eps), a single one as eps.
    """
    if A.size == 0:
        return []
    values, left, right = _EIG(A, left=True, right=True)
    rounding = len(A) * np.finfo(float).eps
    overlap = np.maximum(np.abs((left.conj() * right).sum(axis=0)), np.sqrt(rounding))
    size = max(size, float(np.linalg.norm(A)))
    values[np.abs(values) <= rounding * size / overlap] = 0.0
    return [complex(value) for value in values]


def _channel(system: _System, input_name: str, output_name: str) -> Channel:
    poles = _eigenvalues(system.A)
    size = max(map(abs, poles), default=0.0)
    zeros = []
    finite = _zeros(system)
    for zero in sorted(finite or (), key=lambda value: (abs(value), value.imag)):
        near = min(poles, key=lambda pole: abs(pole - zero), default=None)
        if near is not None and abs(near - zero) <= _CANCELS * (abs(near) or _CANCELS * size):
            poles.remove(near)
        else:
            zeros.append(zero)
    return Channel(input_name, output_name, _gain(system), finite is not None, tuple(zeros))


def _zeros(system: _System) -> list[complex] | None:
    """Invariant zeros: modes that stay when feedback keeps the output and its derivatives at 0.

    None where the input does not reach the output.
    """
    A, B, C, D = system.A, system.B, system.C, system.D
    rows: list[Array] = []
    share, row, noise = D, C, np.zeros(1)
    for _ in range(len(A) + 1):
        if abs(share[0, 0]) > noise.max():
            feedback = B @ row / share
            size = float(np.linalg.norm(A) + np.linalg.norm(feedback))
            free = linalg.null_space(np.vstack(rows)) if rows else np.eye(len(A))
            return _eigenvalues(free.T @ (A - feedback) @ free, size)
        rows.append(row / (np.linalg.norm(row) or 1.0))
        # the next derivative of the output, and what rounding may make of the input's share in it
        share, noise = row @ B, 100.0 * len(A) * np.finfo(float).eps * np.abs(row) @ np.abs(B)
        row = row @ A
    return None


def _gain(system: _System) -> float:
    """Static gain: modes at 0 that the input does not reach, or the output not see, do not count.

    The space of these modes is split off by an ordered Schur form and a Sylvester equation.
    """
    A, B, C, D = system.A, system.B, system.C, system.D
    zeros = sum(value == 0.0 for value in _eigenvalues(A))
    if not zeros:
        return _static(A, B, C, D)
    sizes = np.sort(np.abs(linalg.eigvals(A)))
    limit = inf if zeros == len(A) else 0.5 * (sizes[zeros - 1] + sizes[zeros])
    form, basis, _ = _SCHUR(A, output="complex", sort=lambda value: abs(value) <= limit)
    still, moving = slice(0, zeros), slice(zeros, None)
    coupling = linalg.solve_sylvester(
        form[still, still], -form[moving, moving], -form[still, moving]
    )
    split = basis.copy()  # columns: states of the modes at 0, and of the others
    split[:, moving] += basis[:, still] @ coupling
    inverse = basis.conj().T
    inverse[still] -= coupling @ inverse[moving]
    drift, reached = C @ split[:, still], inverse[still] @ B
    condition = np.linalg.norm(A) * np.linalg.norm(np.linalg.pinv(form[moving, moving]))
    noise = 100.0 * len(A) * np.finfo(float).eps * max(1.0, float(condition))
    noise *= np.linalg.norm(C) * np.linalg.norm(inverse[still]) * np.linalg.norm(B)
    for _ in range(zeros):
        share = complex((drift @ reached)[0, 0])
        if abs(share) > noise:
            return float(np.copysign(inf, share.real))
        drift = drift @ form[still, still]
        noise *= np.linalg.norm(A)  # of which that block may be the rounding
    return _static(form[moving, moving], inverse[moving] @ B, C @ split[:, moving], D)


def _static(A: Array | Complex, B: Array | Complex, C: Array | Complex, D: Array) -> float:
    """D - C A⁻¹ B, real; 0 where rounding cannot distinguish it from 0."""
    parts = np.append(C.ravel() * np.linalg.solve(A, -B).ravel(), D.ravel())
    gain = float(parts.sum().real)
    noise = 100.0 * len(parts) * np.finfo(float).eps * float(np.abs(parts).sum())
    return gain if abs(gain) > noise else 0.0


def frequencies(analyses: Iterable[Analysis]) -> Array:
    """Angular frequencies (n,), rad/s, to draw responses at: around all poles, close to resonances.

    Not on a pole: that of an undamped pair has no value there.

    Parameters
    ----------
    analyses : of the models that are drawn together
    """
    poles = [pole for analysis in analyses for pole in analysis.poles]
    sizes = np.array([pole.natural_frequency for pole in poles if pole.natural_frequency > 0.0])
    if not sizes.size:
        return np.geomspace(0.1, 100.0, _PER_RANGE)
    ends = sizes.min() / 10.0**_DECADES, sizes.max() * 10.0**_DECADES
    beside = np.concatenate([1.0 - _NEAR, 1.0 + _NEAR])
    return np.unique([*np.geomspace(*ends, _PER_RANGE), *np.outer(sizes, beside).ravel()])
