"""Resonances in what an answer leaves: frequencies that stand out of their neighbourhood."""

from collections.abc import Iterable
from operator import itemgetter

import numpy as np
from scipy.signal import welch
from scipy.stats import chi2

from elastic_tendon.comparison.residuals import Array

RESOLUTION = 0.03  # of the lowest frequency
FEWEST = 4  # segments of a recording over which its spectrum is averaged
NEAR = 1.3  # times a frequency, and its reciprocal, up to which others are beside it
# swings in a recording, and rad between samples, between which peaks of any frequency are sought
SWUNG, HIGHEST = 8.0, 1.9
CHANCE = 0.01  # probability that noise alone shows a peak, were the level beside it exact


def strongest(
    errors: Iterable[tuple[Array, Array]],
    count: int,
    bounds: tuple[float, float] | None = None,
) -> list[float]:
    """Angular frequencies, rad/s, of the highest peaks in the spectra of some errors.

    Parameters
    ----------
    errors : time, s, and error, (n,) arrays each
    count : most that are wanted
    bounds : angular frequencies between which they are sought; else all that a recording shows
    """
    found: list[tuple[float, float]] = []
    for time, error in errors:
        even = np.linspace(time[0], time[-1], len(time))
        step = float(even[1] - even[0])
        lowest, highest = bounds or (
            2.0 * np.pi * SWUNG / float(time[-1] - time[0]),
            HIGHEST / step,
        )
        found += peaks(np.interp(even, time, error), step, lowest, highest)
    return [frequency for frequency, _ in sorted(found, key=itemgetter(1), reverse=True)[:count]]


def peaks(errors: Array, step: float, lowest: float, highest: float) -> list[tuple[float, float]]:
    """Peaks of a spectrum that noise would not have, the highest first.

    Parameters
    ----------
    errors : (n,) array, evenly sampled
    step : time between samples, s
    lowest, highest : angular frequencies between which they are sought, rad/s

    Returns
    -------
    list of (angular frequency, rad/s; times by which it exceeds what is beside it)
    """
    turn = 2.0 * np.pi
    length = min(len(errors) // FEWEST, round(turn / (RESOLUTION * lowest * step)))
    if length < FEWEST:
        return []
    frequency, density = welch(errors, turn / step, nperseg=length)
    inside = np.flatnonzero((frequency[1:-1] >= lowest) & (frequency[1:-1] <= highest)) + 1
    tops = inside[
        (density[inside] >= density[inside - 1]) & (density[inside] >= density[inside + 1])
    ]
    segments = 2.0 * len(errors) / length - 1.0  # each half over the next
    freedom = 2.0 * segments
    least = chi2.isf(CHANCE / max(len(inside), 1), freedom) / chi2.median(freedom)
    found = []
    for top in tops:
        excess = float(density[top]) / _level(frequency, density, top)
        if excess > least:
            found.append((float(frequency[top]), excess))
    return sorted(found, key=lambda peak: -peak[1])


def _level(frequency: Array, density: Array, top: int) -> float:
    """The spectrum beside a frequency, as its medians below and above have it: it may slope.

    Infinite where it is too coarse to tell.
    """
    center = frequency[top]
    below = density[(frequency >= center / NEAR) & (frequency < center)]
    above = density[(frequency > center) & (frequency <= NEAR * center)]
    if not (len(below) and len(above)):
        return np.inf
    return float(np.sqrt(np.median(below) * np.median(above))) or np.finfo(float).tiny
