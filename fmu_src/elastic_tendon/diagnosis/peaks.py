"""Resonances in what an answer leaves: frequencies that stand out of their neighbourhood."""

import numpy as np
from scipy.signal import welch
from scipy.stats import chi2

from elastic_tendon.comparison.residuals import Array

RESOLUTION = 0.03  # of the lowest frequency
FEWEST = 4  # segments of a recording over which its spectrum is averaged
OVERLAP = 2  # independent segments of n samples are about so many times n over a segment's length
NEAR = 1.3  # times a frequency, and the reciprocal, around which the level is that of others
CHANCE = 0.01  # probability that noise alone shows a peak


def peaks(errors: Array, step: float, lowest: float, highest: float) -> list[tuple[float, float]]:
    """Peaks of a spectrum that noise would not have, the highest first.

    Parameters
    ----------
    errors : (n,) array, evenly sampled
    step : time between samples, s
    lowest, highest : angular frequencies between which they are sought, rad/s

    Returns
    -------
    list of (angular frequency, rad/s; times by which it exceeds the median of what is around it)
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
    freedom = 2.0 * OVERLAP * len(errors) / length
    least = chi2.isf(CHANCE / max(len(inside), 1), freedom) / chi2.median(freedom)
    found = []
    for top in tops:
        near = (frequency >= frequency[top] / NEAR) & (frequency <= NEAR * frequency[top])
        excess = density[top] / max(float(np.median(density[near])), np.finfo(float).tiny)
        if excess > least:
            found.append((float(frequency[top]), float(excess)))
    return sorted(found, key=lambda peak: -peak[1])
