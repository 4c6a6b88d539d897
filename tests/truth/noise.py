"""What a sensor makes of a true signal."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

Vector = NDArray[np.float64]


@dataclass(frozen=True)
class Sensor:
    """White and coloured noise are added, then the sum is rounded to multiples of `step`."""

    white: float = 0.0  # standard deviation, unit of the signal
    coloured: float = 0.0  # standard deviation of first-order autoregressive noise
    correlation: float = 0.9  # of the coloured noise from one sample to the next
    step: float = 0.0  # quantisation; 0 for none


def counts(bits: int) -> float:
    """Step of an encoder of so many bits a turn, rad."""
    return 2.0 * math.pi / (1 << bits)


def coloured_noise(rng: np.random.Generator, n: int, sigma: float, correlation: float) -> Vector:
    """(n,) stationary noise n_i = correlation n_(i-1) + w_i of standard deviation `sigma`."""
    drive = sigma * math.sqrt(1.0 - correlation**2) * rng.standard_normal(n)
    # the first sample has the whole variance already
    drive[0] = sigma * rng.standard_normal()
    return np.asarray(lfilter([1.0], [1.0, -correlation], drive), dtype=np.float64)


def measured(signal: Vector, sensor: Sensor, rng: np.random.Generator) -> Vector:
    """The (n,) signal as the sensor shows it."""
    shown = signal + sensor.white * rng.standard_normal(len(signal))
    shown = shown + coloured_noise(rng, len(signal), sensor.coloured, sensor.correlation)
    return shown if sensor.step == 0.0 else sensor.step * np.round(shown / sensor.step)
