"""Noise floor of a measured signal, from its highest frequencies.

Differences of order m wipe out everything smooth and multiply the variance of white noise by
binomial(2 m, m), so the RMS of the m-th difference, divided by the root of that number, is the
noise. What is left of the motion makes a low order too large; the estimate falls with the order
until only noise is left, so the first order that the next one does not lower is taken. Impacts
and stops are sharp at any order but rare: the mean square is taken block by block, and its median
over the blocks counts. (The median of the differences themselves would not do: those of a
quantised signal have few values.)
"""

from collections.abc import Mapping
from dataclasses import dataclass
from math import comb, sqrt
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_ORDERS = (2, 3, 4, 5, 6, 7, 8)
# an order that lowers the estimate by less than this has no motion left to remove
_SETTLED = 0.98
# long enough for the median of a block's mean square to be its mean within a percent
_BLOCK = 128
# steps of a quantised signal agree with whole counts up to the rounding of the file
_COUNT_TOLERANCE = 0.05
# finest relative spacing that a sensor can show; below it levels differ by rounding only
_ROUNDING = 1e-9


@dataclass(frozen=True)
class NoiseFloor:
    """Noise of one signal: what kind it is, how large, and how it was found.

    `sigma` is the total standard deviation in the signal's unit, never zero; `correlation` is the
    autocorrelation from one sample to the next, 0 for white noise.
    """

    sigma: float
    kind: Literal["white", "coloured", "quantised"]
    method: Literal["repeated periods", "high frequencies"] = "high frequencies"
    correlation: float = 0.0


def noise_floors(
    time: Array, inputs: Mapping[str, Array], signals: Mapping[str, Array]
) -> dict[str, NoiseFloor]:
    """Noise floor of every signal of a recording.

    Parameters
    ----------
    time : (n,) array, s, strictly increasing; n >= 10
    inputs : name -> (n,) array, any unit; motor position and load: where they repeat, so must
        the signals, up to their noise
    signals : name -> (n,) array, any unit

    Returns
    -------
    dict, name of a signal -> NoiseFloor
    """
    del time, inputs
    return {name: noise_sigma(values) for name, values in signals.items()}


def noise_sigma(signal: Array) -> NoiseFloor:
    """Estimate the noise floor of a signal.

    Parameters
    ----------
    signal : (n,) array, any unit, evenly or nearly evenly sampled; n >= 10

    Returns
    -------
    NoiseFloor; `sigma` is never zero. ``quantised`` where the steps of the sensor, step/sqrt(12),
    make up most of the noise; else ``white``
    """
    white = _white_sigma(signal)
    rounding = quantisation_step(signal) / sqrt(12.0)
    smallest = _ROUNDING * max(float(np.max(np.abs(signal))), 1.0)
    # a dithered sensor shows its steps in the differences as well, hence the larger, not the sum
    sigma = max(white, rounding, smallest)
    return NoiseFloor(sigma, "quantised" if rounding > sigma / sqrt(2.0) else "white")


def _white_sigma(signal: Array) -> float:
    sigma = _difference_sigma(signal, _ORDERS[0])
    for order in _ORDERS[1:]:
        # ten samples are the least there are, so every order leaves some differences
        following = _difference_sigma(signal, order)
        if following > _SETTLED * sigma:
            break
        sigma = following
    return sigma


def _difference_sigma(signal: Array, order: int) -> float:
    squares = np.diff(signal, order) ** 2
    blocks = np.array_split(squares, max(1, len(squares) // _BLOCK))
    variance = float(np.median([np.mean(block) for block in blocks]))
    return sqrt(variance / comb(2 * order, order))


def quantisation_step(signal: Array) -> float:
    """Smallest step between the levels of a quantised signal, 0 where it has none.

    Parameters
    ----------
    signal : (n,) array, any unit

    Returns
    -------
    float, the unit of the signal
    """
    gaps = np.diff(np.unique(signal))
    gaps = gaps[gaps > _ROUNDING * max(float(np.max(np.abs(signal))), 1.0)]
    if len(gaps) < 2:
        return float(gaps[0]) if len(gaps) else 0.0
    step = float(np.median(gaps[gaps < 1.5 * gaps.min()]))
    counts = gaps / step
    whole = np.abs(counts - np.round(counts)) < _COUNT_TOLERANCE
    return step if np.mean(whole) > 0.95 else 0.0
