"""The elastic transmission, (1) to (25) of the paper.

Functions of plain quantities work alike on floats, numpy arrays and CasADi symbols; the
model's equations are made of them. Functions of a `Transmission` evaluate its static
characteristic with numpy, for plots and design.

Symbols: q joint position, eθ motor position at the motor pulley, jθ = eθ / n_t the same
reflected to the joint, n_t = R / r, δ = q − jθ deflection; R, r pulley radii; index 1 the
upper spring, 2 the lower; F_p pretension; k_i, d_i combined stiffness and damping of the
parallel springs of a side, (33) and (34); l_p,i prestretched length.

Signs are the paper's: a positive deflection stretches the lower spring, and the torque on
the joint is then negative.
"""

from collections.abc import Callable
from enum import IntEnum
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from elastic_tendon.effects.symbolic import Symbol, where

if TYPE_CHECKING:
    from elastic_tendon.actuator.sections import Spring, Transmission

FloatArray = NDArray[np.float64]


class SlackState(IntEnum):
    """Which tendon is slack (Fig. 4); the paper has no name for both at once."""

    I = 1  # noqa: E741 - the paper's numeral
    II = 2
    III = 3
    BOTH = 4

    @property
    def label(self) -> str:
        """Name in words."""
        return _LABELS[self]


_LABELS = {
    SlackState.I: "I: lower tendon slack",
    SlackState.II: "II: upper tendon slack",
    SlackState.III: "III: both tendons taut",
    SlackState.BOTH: "both tendons slack",
}


def reflected_motor_position(motor_position: Symbol, R: Symbol, r: Symbol) -> Symbol:
    """Motor position seen at the joint, jθ = (r / R) eθ, (10); rates map alike.

    Parameters
    ----------
    motor_position : float, (n,) array or SX; eθ, rad at the motor pulley
    R, r : float or SX; radius of the joint and of the motor pulley, m

    Returns
    -------
    float, (n,) array or SX; rad
    """
    return motor_position * r / R


def displacement(q: Symbol, theta_joint: Symbol, R: Symbol) -> Symbol:
    """Displacement x_1 of the upper spring from its prestretched length, (1), (11); x_2 = −x_1.

    Given rates instead of positions it is the rate of the displacement. (12) is the same
    seen from the motor pulley.

    Parameters
    ----------
    q, theta_joint : float, (n,) array or SX; joint and reflected motor position, rad
    R : float or SX; radius of the joint pulley, m

    Returns
    -------
    float, (n,) array or SX; m
    """
    return -R * (q - theta_joint)


def prestretched_length(F_p: Symbol, k: Symbol) -> Symbol:
    """Elongation of a spring at rest, l_p = F_p / k, (4); so l_p,1 / l_p,2 = k_2 / k_1, (5).

    Parameters
    ----------
    F_p : float or SX; pretension, N
    k : float or SX; combined stiffness of the side, N/m

    Returns
    -------
    float or SX; m
    """
    return F_p / k


def spring_force(k: Symbol, elongation: Symbol, d: Symbol, rate: Symbol) -> Symbol:
    """Force of a viscoelastic spring, F = k (l_p + x) + d ẋ, (3); negative where it would push.

    Parameters
    ----------
    k : float or SX; stiffness, N/m
    elongation : float, (n,) array or SX; l_p + x, from the rest length, m
    d : float or SX; damping, N·s/m
    rate : float, (n,) array or SX; ẋ, m/s

    Returns
    -------
    float, (n,) array or SX; N
    """
    return k * elongation + d * rate


def tension(force: Symbol) -> Symbol:
    """Tension F σ(F) of a tendon, which only pulls, (6).

    Parameters
    ----------
    force : float, (n,) array or SX; spring force, N

    Returns
    -------
    float, (n,) array or SX; N, never negative
    """
    return where(force < 0, 0.0, force)


def joint_torque(F1: Symbol, F2: Symbol, R: Symbol) -> Symbol:
    """Elastic torque on the joint, jτ_e = R (F_1 − F_2), (7).

    Parameters
    ----------
    F1, F2 : float, (n,) array or SX; tension of the upper and lower tendon, see `tension`, N
    R : float or SX; radius of the joint pulley, m

    Returns
    -------
    float, (n,) array or SX; N·m
    """
    return R * (F1 - F2)


def motor_torque(joint_torque: Symbol, R: Symbol, r: Symbol) -> Symbol:
    """Elastic torque at the motor pulley, τ_e = (r / R) jτ_e, (8), (9).

    Parameters
    ----------
    joint_torque : float, (n,) array or SX; jτ_e, N·m
    R, r : float or SX; radius of the joint and of the motor pulley, m

    Returns
    -------
    float, (n,) array or SX; N·m
    """
    return joint_torque * r / R


def slack_state_by_force(F1: Symbol, F2: Symbol) -> Symbol:
    """Dynamic slack state: a tendon is slack where its spring force is negative, (6), (7).

    Both are slack at once only in motion, when d_1 / k_1 differs from d_2 / k_2.

    Parameters
    ----------
    F1, F2 : float, (n,) array or SX; force of the upper and lower spring, (3), N

    Returns
    -------
    float, (n,) array or SX; a number of `SlackState`
    """
    return _slack_state(F1 < 0, F2 < 0)


def slack_state_by_length(elongation_1: Symbol, elongation_2: Symbol) -> Symbol:
    """Static slack state: a tendon is slack where its spring is below its rest length, (13), (14).

    Erratum: after (5) the paper writes slack as x_i < l_p,i; it is x_i < −l_p,i, as in (13).
    On the boundary, slack by (13) and taut by (14), the tendon counts as taut, as σ(0) = 1.

    Parameters
    ----------
    elongation_1, elongation_2 : float, (n,) array or SX; l_p,i + x_i, m

    Returns
    -------
    float, (n,) array or SX; a number of `SlackState`
    """
    return _slack_state(elongation_1 < 0, elongation_2 < 0)


def _slack_state(upper_slack: Symbol, lower_slack: Symbol) -> Symbol:
    return where(
        upper_slack,
        where(lower_slack, int(SlackState.BOTH), int(SlackState.II)),
        where(lower_slack, int(SlackState.I), int(SlackState.III)),
    )


def slack_boundaries(transmission: "Transmission") -> tuple[float, float]:
    """Deflections between which both tendons are taut at rest, −F_p/(R k_2) and F_p/(R k_1), (14).

    Returns
    -------
    tuple of two floats; rad. Where springs push too, `deflection_limits`
    """
    if not transmission.slack:
        return deflection_limits(transmission)
    upper, lower = _prestretched_lengths(transmission)
    R = transmission.joint_pulley_radius
    return -lower / R, upper / R


def deflection_limits(transmission: "Transmission") -> tuple[float, float]:
    """Deflections at which the upper and the lower spring are at l_max,i, (15), (16) corrected.

    Erratum: the signs of (16) are wrong; consistent with (28), (29) and (37) it reads
    −l_max,1/R + F_p/(k_1 R) ≤ δ ≤ l_max,2/R − F_p/(k_2 R).

    Returns
    -------
    tuple of two floats; rad
    """
    upper, lower = _prestretched_lengths(transmission)
    R = transmission.joint_pulley_radius
    return (
        -(transmission.upper_spring.max_deflection - upper) / R,
        (transmission.lower_spring.max_deflection - lower) / R,
    )


def characteristic_torque(
    deflection: ArrayLike, transmission: "Transmission", deflection_rate: ArrayLike = 0.0
) -> FloatArray:
    """Torque on the joint over its deflection, (17), (18), (21), (22) and (24).

    Parameters
    ----------
    deflection : float or (n,) array; δ, rad
    transmission : Transmission
    deflection_rate : float or (n,) array; rad/s

    Returns
    -------
    (n,) array; N·m. Valid within `deflection_limits`; beyond them the springs go on linearly.
    """
    R = transmission.joint_pulley_radius
    upper, lower = transmission.upper_spring, transmission.lower_spring
    length_1, length_2 = _elongations(deflection, transmission)
    rate_1 = displacement(np.asarray(deflection_rate, dtype=float), 0.0, R)
    F1 = spring_force(upper.combined_stiffness, length_1, upper.combined_damping, rate_1)
    F2 = spring_force(lower.combined_stiffness, length_2, lower.combined_damping, -rate_1)
    if transmission.slack:
        F1, F2 = tension(F1), tension(F2)
    return np.asarray(joint_torque(F1, F2, R))


def characteristic_stiffness(deflection: ArrayLike, transmission: "Transmission") -> FloatArray:
    """Stiffness −∂jτ_e/∂δ at rest: R² k_1, R² k_2, R² (k_1 + k_2) in I, II, III; (19), (23), (25).

    Parameters
    ----------
    deflection : float or (n,) array; δ, rad
    transmission : Transmission

    Returns
    -------
    (n,) array; N·m/rad. Without pretension one of the two tendons is always slack.
    """
    return _sum_of_taut(deflection, transmission, lambda spring: spring.combined_stiffness)


def characteristic_damping(deflection: ArrayLike, transmission: "Transmission") -> FloatArray:
    """Damping −∂jτ_e/∂δ̇ at rest: R² d_1, R² d_2, R² (d_1 + d_2) in I, II, III; (20), (23), (25).

    Parameters
    ----------
    deflection : float or (n,) array; δ, rad
    transmission : Transmission

    Returns
    -------
    (n,) array; N·m·s/rad
    """
    return _sum_of_taut(deflection, transmission, lambda spring: spring.combined_damping)


def _sum_of_taut(
    deflection: ArrayLike, transmission: "Transmission", value_of: Callable[["Spring"], float]
) -> FloatArray:
    """R² times the sum of a value of the springs whose tendons are taut."""
    upper, lower = value_of(transmission.upper_spring), value_of(transmission.lower_spring)
    length_1, length_2 = _elongations(deflection, transmission)
    slack = bool(transmission.slack)
    total = where(slack & (length_1 < 0), 0.0, upper) + where(slack & (length_2 < 0), 0.0, lower)
    return np.asarray(transmission.joint_pulley_radius**2 * total)


def _prestretched_lengths(transmission: "Transmission") -> tuple[float, float]:
    F_p = transmission.pretension_force
    if F_p == 0.0:  # also where there are no springs
        return 0.0, 0.0
    return (
        prestretched_length(F_p, transmission.upper_spring.combined_stiffness),
        prestretched_length(F_p, transmission.lower_spring.combined_stiffness),
    )


def _elongations(
    deflection: ArrayLike, transmission: "Transmission"
) -> tuple[FloatArray, FloatArray]:
    """l_p,i + x_i of the upper and lower spring, m."""
    upper, lower = _prestretched_lengths(transmission)
    x_1 = displacement(np.asarray(deflection, dtype=float), 0.0, transmission.joint_pulley_radius)
    return upper + x_1, lower - x_1
