"""Nonlinear least squares within bounds, for many residuals of few variables.

Levenberg's and Marquardt's method with the damping of H. B. Nielsen (Damping parameter in
Marquardt's method, IMM-REP-1999-05). The tall Jacobian is brought to a small triangle once a step,
where scipy's `least_squares` takes its singular values; of a few thousand residuals that is most of
its time.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import lsq_linear

Array = NDArray[np.float64]

FIRST_DAMPING = 1e-4  # of the squared norm of each column
LEAST_DAMPING, MOST_DAMPING = 1e-12, 1e12
ENOUGH = 1e-4  # share of the predicted fall of the cost with which a step is taken
GOOD = 0.25  # share from which a small fall means convergence
STILL = 1e-8  # relative change of the variables that is none
SPARSE = 0.5  # share of the columns below which the others of a piece take no part
ROWS = 128  # that are brought to a triangle at once: they fit the processor's cache


def descend(
    residuals: Callable[[Array], Array],
    jacobian: Callable[[Array], Array],
    start: Array,
    bounds: tuple[Array, Array],
    evaluations: int,
    tolerance: float,
) -> tuple[Array, float]:
    """Local minimum of half the sum of squares near a start, or as far as the evaluations lead.

    Parameters
    ----------
    residuals : of the variables (k,) -> (N,); infinite where there are none
    jacobian : of the variables -> (N, k)
    start : (k,) array within the bounds, where the residuals are finite
    bounds : lowest and highest variables, (k,) arrays
    evaluations : of the residuals, at the most
    tolerance : relative fall of the cost at which the descent ends

    Returns
    -------
    variables (k,), and their cost
    """
    x, left = start, evaluations - 1
    value = residuals(x)
    cost = 0.5 * float(value @ value)
    damping, growth, scale = FIRST_DAMPING, 2.0, np.zeros(len(x))
    while left > 0:
        triangle, rotated = _triangle(jacobian(x), value)
        scale = np.maximum(scale, np.linalg.norm(triangle, axis=0))
        while left > 0:
            step = _step(triangle, rotated, damping, scale, (bounds[0] - x, bounds[1] - x))
            if np.linalg.norm(step) < STILL * (STILL + np.linalg.norm(x)):
                return x, cost
            moved = np.clip(x + step, *bounds)
            following = residuals(moved)
            left -= 1
            new_cost = 0.5 * float(following @ following)
            predicted = 0.5 * float(rotated @ rotated - np.sum((triangle @ step + rotated) ** 2))
            fell = (cost - new_cost) / predicted if predicted > 0.0 else -1.0
            ratio = min(fell, 1.0) if np.isfinite(fell) else -1.0
            if ratio > ENOUGH:
                damping = max(damping * max(1 / 3, 1 - (2 * ratio - 1) ** 3), LEAST_DAMPING)
                growth = 2.0
                break
            damping, growth = damping * growth, 2.0 * growth
            if damping > MOST_DAMPING:
                return x, cost
        else:
            return x, cost
        converged = cost - new_cost < tolerance * cost and ratio > GOOD
        x, value, cost = moved, following, new_cost
        if converged:
            break
    return x, cost


def _triangle(jacobian: Array, residuals: Array) -> tuple[Array, Array]:
    """Triangle (k, k) and residuals (k,) with the same normal equations."""
    count = jacobian.shape[1]
    rows = np.zeros((-(-len(residuals) // ROWS) * ROWS, count + 1))
    rows[: len(residuals), :count], rows[: len(residuals), count] = jacobian, residuals
    pieces = rows.reshape(-1, ROWS, count + 1)
    used: NDArray[np.bool_] = np.any(pieces != 0.0, axis=1)
    if np.mean(used) < SPARSE:
        parts = [_triangle_of(piece, own) for piece, own in zip(pieces, used, strict=True)]
    else:
        parts = [*np.linalg.qr(pieces, mode="r")]
    whole: Array = np.linalg.qr(np.concatenate(parts), mode="r")  # type: ignore[assignment]
    return whole[:count, :count], whole[:count, count]


def _triangle_of(rows: Array, used: NDArray[np.bool_]) -> Array:
    """Triangle of rows of which some columns are zero, as of a recording that knows nothing of the
    initial states of others."""
    triangle: Array = np.linalg.qr(rows[:, used], mode="r")  # type: ignore[assignment]
    whole = np.zeros((len(triangle), len(used)))
    whole[:, used] = triangle
    return whole


def _step(
    triangle: Array, residuals: Array, damping: float, scale: Array, room: tuple[Array, Array]
) -> Array:
    """Damped step within the room that the bounds leave."""
    scale = np.where(scale > 0.0, scale, 1.0)
    matrix = np.vstack([triangle, np.diag(np.sqrt(damping) * scale)]) / scale
    target = np.concatenate([-residuals, np.zeros(len(scale))])
    free: Array = np.linalg.lstsq(matrix, target)[0]
    low, high = room[0] * scale, room[1] * scale
    if np.all((free >= low) & (free <= high)):
        return free / scale
    fixed = high - low <= 0.0
    found = lsq_linear(matrix[:, ~fixed], target, (low[~fixed], high[~fixed]), method="bvls")
    step = np.zeros(len(scale))
    step[~fixed] = found.x
    return step / scale
