"""Fewer points for a long curve, none of which anybody would miss on paper."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

BUCKETS = 1500  # more than a figure has pixels across
POINTS = 20_000


def envelope(horizontal: Array, values: Array, buckets: int = BUCKETS) -> tuple[Array, Array]:
    """Smallest and largest value of each of so many stretches, in the order of the curve.

    Parameters
    ----------
    horizontal, values : (n,) arrays, any unit
    buckets : number of stretches, positive

    Returns
    -------
    two (m,) arrays; the given ones where they are short
    """
    length = -(-len(values) // buckets)
    if length <= 4:
        return horizontal, values
    starts = np.arange(0, len(values), length)
    whole = len(values) // length * length
    stretches = values[:whole].reshape(-1, length)
    extremes = np.stack([stretches.argmin(axis=1), stretches.argmax(axis=1)], axis=1)
    chosen = np.sort(starts[: len(stretches), None] + extremes, axis=1).ravel()
    kept = np.unique(np.concatenate([[0], chosen, [len(values) - 1]]))
    return horizontal[kept], values[kept]


def stride(n: int, points: int = POINTS) -> slice:
    """Every so many of n samples that `points` are left at most; for loops, drawn as lines."""
    return slice(None, None, max(1, -(-n // points)))


def some(n: int, points: int = POINTS) -> NDArray[np.intp]:
    """At most so many of n samples, drawn by lot; for clouds.

    Samples a fixed number apart would fall in step with a periodic motion. The lot is the same
    each time.
    """
    if n <= points:
        return np.arange(n)
    return np.sort(np.random.default_rng(0).choice(n, points, replace=False))
