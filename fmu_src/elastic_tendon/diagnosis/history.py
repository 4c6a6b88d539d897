"""What the machine did before, as columns that an error may be held against."""

from itertools import accumulate

import numpy as np
from scipy.signal import lfilter

from elastic_tendon.comparison.residuals import Array

SLIPS = (0.01, 0.03, 0.1, 0.3)  # shares of the longest way, after which elements slip
LAGS = (0.1, 0.3, 1.0, 3.0)  # times a typical time
DAMPINGS = (0.01, 0.04, 0.15)  # damping ratios of what rings


def slipping(values: Array, longest: float) -> Array:
    """Elements that each follow (n,) values until they slip, by shares of `longest`; (n, k)."""
    steps = np.diff(values).tolist()

    def following(slip: float) -> Array:
        def moved(stretched: float, step: float) -> float:
            return min(max(stretched + step, -slip), slip)

        return np.array(list(accumulate(steps, moved, initial=0.0)))

    return np.column_stack([following(longest * share) for share in SLIPS])


def lagging(values: Array, time: Array, typical: float) -> Array:
    """What (n,) values lack where they come late by a lag of the first order, or of two in a row,
    of times about a typical one, s; (n, k)."""
    step, even = _evenly(values - values[0], time)
    columns = []
    for times in LAGS:
        share = 1.0 - np.exp(-step / (times * typical))
        once = lfilter([share], [1.0, share - 1.0], even)
        columns += [once - even, lfilter([share], [1.0, share - 1.0], once) - even]
    return _at(time, columns)


def ringing(values: Array, time: Array, frequency: float) -> Array:
    """What swings at an angular frequency, rad/s, when (n,) values shake it, and its rate, with
    little damping and more; (n, k), of which 1 is the most."""
    step, even = _evenly(values, time)
    columns = []
    for damping in DAMPINGS:
        radius = np.exp(-damping * frequency * step)
        way = radius * np.cos(frequency * np.sqrt(1.0 - damping**2) * step)
        swing = lfilter([1.0], [1.0, -2.0 * way, radius**2], even)
        columns += [swing, swing * way - np.concatenate([[0.0], swing[:-1]])]
    found = _at(time, columns)
    return np.asarray(found / np.maximum(np.max(np.abs(found), axis=0), np.finfo(float).tiny))


def _evenly(values: Array, time: Array) -> tuple[float, Array]:
    """Step, s, of as many samples evenly in time, and values there."""
    even = np.linspace(time[0], time[-1], len(time))
    return float(even[1] - even[0]), np.interp(even, time, values)


def _at(time: Array, columns: list[Array]) -> Array:
    even = np.linspace(time[0], time[-1], len(time))
    return np.column_stack([np.interp(time, even, column) for column in columns])
