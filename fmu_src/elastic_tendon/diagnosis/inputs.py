"""Noise of the motor's sensors, which is an error of the model's input.

The simulation would follow it: at high speed, with springs that lose energy at every small turn,
and with more steps; a rotor would integrate that of its torque. The motor itself moves smoothly, so
its noise is what stands alone at high frequencies, and a Wiener filter takes it away; but for
moments where that would take away far more than noise, as at a jerk.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d, uniform_filter1d

from elastic_tendon.comparison.residuals import Array, rms
from elastic_tendon.measurement import Measurement
from elastic_tendon.measurement.noise import is_even

NOISY = 0.5  # from this share of the highest frequency on the motor does not move
NEIGHBOURS = 25  # frequencies over which power is averaged
FLAT = 3.0  # ratio of powers up to which noise may still be called white
SURELY = 2.0  # times the noise that power must have to be motion
JERK = 5.0  # times the RMS of what is taken away elsewhere, which no noise has at one moment ...
BESIDE = 25  # ... nor so many samples beside it, where the filter rings
RARE = 0.2  # share of the samples up to which that is rare; else noise comes and goes
MOST_ROUNDS = 10  # in which large jerks no longer hide smaller ones
FEWEST = 100  # samples, below which there is no spectrum


def smoothed(measurement: Measurement) -> Measurement:
    """The recording with the noise of the motor's encoder and of its torque taken away.

    Evenly sampled recordings only; others, short ones and static curves come back as they are.
    """
    time = measurement.time
    if measurement.static or len(time) <= FEWEST or not is_even(time):
        return measurement
    return replace(
        measurement,
        motor_position=_filtered(measurement.motor_position),
        driving={name: _filtered(values) for name, values in measurement.driving.items()},
    )


def noise_stands_alone(values: Array) -> bool:
    """Whether a signal has noise at high frequencies that is none of its motion, which the filter
    would take away."""
    return len(values) > FEWEST and not np.array_equal(_filtered(values), values)


def _filtered(values: Array) -> Array:
    """Wiener filter against white noise, as large as the power at high frequencies; (n,) array."""
    trend = np.linspace(values[0], values[-1], len(values))
    # turned about both ends the rest is periodic, with no kink that would look like noise
    rest = values - trend
    spectrum = np.fft.rfft(np.concatenate([rest, -rest[-2:0:-1]]))
    power = uniform_filter1d(np.abs(spectrum) ** 2, NEIGHBOURS, mode="nearest")
    lower, upper = np.array_split(power[int(NOISY * len(power)) :], 2)
    if np.mean(lower) > FLAT * np.mean(upper):  # what is left of a motion, not noise
        return values
    noise = float(np.mean([lower.mean(), upper.mean()]))
    share = np.clip(1.0 - noise / np.maximum(power, 1e-300), 0.0, 1.0)
    share[power < SURELY * noise] = 0.0
    motion = trend + np.asarray(np.fft.irfft(share * spectrum, 2 * len(values) - 2))[: len(values)]
    return np.where(_jerks(values - motion), values, motion)


def _jerks(taken: Array) -> NDArray[np.bool_]:
    """Whether far more than elsewhere is taken away near a sample, (n,) array; nowhere, unless
    that is rare."""
    near = maximum_filter1d(np.abs(taken), 2 * BESIDE + 1)
    found = np.zeros(len(taken), bool)
    for _ in range(MOST_ROUNDS):
        more = near > JERK * rms(taken[~found])
        if np.mean(more) > RARE:
            return np.zeros(len(taken), bool)
        if not np.any(more & ~found):
            break
        found |= more
    return found
