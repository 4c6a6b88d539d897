"""How long a step may be when actuators and links are stepped in turn."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

_ROUNDING = 1e-6  # by which a joint that nothing holds, a double eigenvalue 1, is seen above 1
_LONGEST = 1000.0  # periods of the fastest mode over pi: what is stable so far is so for good
_STEPS = 2000  # over the decades of step sizes that are looked through


def largest_stable_step(
    mass: ArrayLike,
    stiffness: ArrayLike,
    damping: ArrayLike,
    *,
    joint_damping: ArrayLike | None = None,
    given_stiffness: ArrayLike | None = None,
    given_damping: ArrayLike | None = None,
) -> float:
    """Largest stable step of links and actuators that take turns, linear about a pose.

    The links' simulator adds the acceleration to the velocity, then the new velocity to the
    position (semi-implicit Euler, as MuJoCo's Euler and implicitfast), with the torques of the
    step's beginning::

        (M + h B + h D_g + h² K_g) v⁺ = M v - h (K q + D v) + h D_g v,  q⁺ = q + h v⁺

    Parameters
    ----------
    mass : (n, n) array, N·m·s²/rad; the mass matrix M
    stiffness : (n, n) array, N·m/rad; K, by which the actuators' torques fall with the positions
    damping : (n, n) array, N·m·s/rad; D, with the velocities
    joint_damping : (n, n) array, N·m·s/rad; B, of the joints themselves, none where missing
    given_stiffness : (n, n) array, N·m/rad; K_g, what the step is told of K, none where explicit
    given_damping : (n, n) array, N·m·s/rad; D_g, what the step is told of D

    Returns
    -------
    float, s; infinite where every step is stable
    """
    mass, stiffness, damping = (np.asarray(matrix, float) for matrix in (mass, stiffness, damping))
    nothing = np.zeros_like(mass)
    others = [
        nothing if matrix is None else np.asarray(matrix, float)
        for matrix in (joint_damping, given_stiffness, given_damping)
    ]
    fastest = np.sqrt(np.abs(np.linalg.eigvals(np.linalg.solve(mass, stiffness))).max())
    fastest = max(fastest, np.abs(np.linalg.eigvals(np.linalg.solve(mass, damping))).max())
    if not fastest > 0:
        return np.inf

    def stable(step: float) -> bool:
        return _radius(step, mass, stiffness, damping, *others) <= 1 + _ROUNDING

    tried = np.geomspace(1e-3, _LONGEST, _STEPS) / fastest
    beyond = next((index for index, step in enumerate(tried) if not stable(step)), None)
    if beyond is None:
        return np.inf
    low, high = tried[max(beyond - 1, 0)], tried[beyond]
    for _ in range(40):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if stable(middle) else (low, middle)
    return float(low)


def _radius(
    step: float,
    mass: Array,
    stiffness: Array,
    damping: Array,
    joint_damping: Array,
    given_stiffness: Array,
    given_damping: Array,
) -> float:
    """Largest factor by which a step multiplies a small deviation."""
    implicit = mass + step * (joint_damping + given_damping) + step**2 * given_stiffness
    by_position = np.linalg.solve(implicit, -step * stiffness)
    by_velocity = np.linalg.solve(implicit, mass - step * (damping - given_damping))
    unit = np.eye(len(mass))
    matrix = np.block([[unit + step * by_position, step * by_velocity], [by_position, by_velocity]])
    return float(np.abs(np.linalg.eigvals(matrix)).max())
