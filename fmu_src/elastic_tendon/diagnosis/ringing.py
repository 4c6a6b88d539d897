"""Frequencies at which what an answer leaves rings, far above the actuator's own.

A light mass that is hardly damped swings for so long that a refit finds it only from a start that
is right to a percent. The spectrum of what is left shows its frequency.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter, uniform_filter1d
from scipy.signal import periodogram
from scipy.stats import chi2

from elastic_tendon.design import design
from elastic_tendon.diagnosis.answer import Answer
from elastic_tendon.identify.residuals import Array

ABOVE = 2.0  # times the actuator's own frequency
# rough probability up to which a peak is none of the noise; neighbouring bins hang together, so
# that noise has one in three times, which costs a few simulations
CHANCE = 0.03
WIDTHS = (1, 4, 16)  # bins of a spectrum that are taken together: damping spreads a peak
AROUND = 201  # bins that show the power around one
HANN = 1.5  # bins that the window makes one of
FEWEST = 2 * AROUND  # samples


def ringing(answer: Answer) -> list[float]:
    """The most prominent frequency in the errors of each signal, if any, rad/s.

    Parameters
    ----------
    answer : a refitted model
    """
    lowest = ABOVE * design(answer.result.model).frequency_state_3
    peaks = [
        _peak(measurement.time, errors, lowest)
        for measurement, signals in zip(
            answer.result.problem.measurements, answer.errors, strict=True
        )
        if not measurement.static and len(measurement.time) >= FEWEST
        for errors in signals.values()
    ]
    return [frequency for frequency, chance in peaks if chance < CHANCE]


def _peak(time: Array, errors: Array, lowest: float) -> tuple[float, float]:
    """Frequency (rad/s) of the peak that stands out most, and its rough probability by chance."""
    even = np.asarray(np.interp(np.linspace(time[0], time[-1], len(time)), time, errors))
    rate = (len(time) - 1) / float(time[-1] - time[0])
    hertz, power = periodogram(even, rate, window="hann")
    around = np.maximum(median_filter(power, AROUND), np.finfo(float).tiny)
    excess = np.log(2.0) * power / around  # of noise: exponential, mean one
    high = 2.0 * np.pi * hertz > lowest
    peaks = [_widest(excess, high, width) for width in WIDTHS]
    least, frequency = min((chance, float(share @ hertz)) for chance, share in peaks)
    return 2.0 * np.pi * frequency, float(len(WIDTHS) * np.exp(least))


def _widest(excess: Array, high: NDArray[np.bool_], width: int) -> tuple[float, Array]:
    """Logarithm of the rough probability of the highest peak of some bins together, and each bin's
    share of it."""
    means = np.where(high, uniform_filter1d(excess, width), 0.0)
    means[-1] = 0.0
    peak, freedom = int(np.argmax(means)), 2.0 * max(width / HANN, 1.0)
    chance = float(chi2.logsf(freedom * means[peak], freedom)) + np.log(len(means) / width)
    near = np.abs(np.arange(len(means)) - peak) <= width
    share = np.where(near, np.maximum(excess - 1.0, 1e-9), 0.0)
    return chance, share / share.sum()
