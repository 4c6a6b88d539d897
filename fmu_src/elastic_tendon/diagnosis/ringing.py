"""Frequencies at which what an answer leaves rings, far above the actuator's own.

A light mass that is hardly damped swings for so long that a refit finds it only from a start that
is right to a percent. The spectrum of what is left shows its frequency.
"""

import numpy as np
from scipy.ndimage import median_filter
from scipy.signal import periodogram

from elastic_tendon.design import design
from elastic_tendon.diagnosis.answer import Answer
from elastic_tendon.identify.residuals import Array

ABOVE = 2.0  # times the actuator's own frequency
PROMINENT = 13.0  # times the power around a peak; that of noise reaches it in a third of cases
AROUND = 101  # bins that show the power around one
FEWEST = 4 * AROUND  # samples


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
    return [frequency for frequency, power in peaks if power > PROMINENT]


def _peak(time: Array, errors: Array, lowest: float) -> tuple[float, float]:
    """Frequency (rad/s) of the power that stands out most, and how many times that around it."""
    even = np.asarray(np.interp(np.linspace(time[0], time[-1], len(time)), time, errors))
    rate = (len(time) - 1) / float(time[-1] - time[0])
    hertz, power = periodogram(even, rate, window="hann")
    power = np.maximum(power, np.finfo(float).tiny)
    excess = np.where(2.0 * np.pi * hertz > lowest, power / median_filter(power, AROUND), 0.0)
    peak = int(np.argmax(excess[:-1]))
    # the parabola through the logarithms of three bins has its top where the peak is
    left, top, right = np.log(power[peak - 1 : peak + 2]) if peak else np.zeros(3)
    bend = left - 2.0 * top + right
    shift = 0.5 * (left - right) / bend if bend else 0.0
    return 2.0 * np.pi * float(hertz[peak] + shift * hertz[1]), float(excess[peak])
