"""Tests of the residual: its correlation with itself and with what drives the joint.

A residual that is only noise follows neither its own past nor the inputs. How far estimates stray
from that by chance depends on how smooth both series are, so the bounds are Bartlett's and not
the usual ones of white noise: those call every smooth input guilty.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from elastic_tendon.comparison.bins import rounding_error
from elastic_tendon.comparison.comparison import FileComparison
from elastic_tendon.comparison.residuals import Array, autocorrelation_time
from elastic_tendon.measurement import Measurement

# share of the values at one lag that lies beyond its bound by chance
CHANCE = 0.01
# lags go on for this many autocorrelation times, where the recording is long enough
_TIMES = 5.0
_MINIMUM_LAGS = 25
_LARGEST_PART = 0.25  # of a recording; later lags have too few pairs
_SMOOTHED = 9  # samples over which the motor position is differentiated; an encoder rounds it
_EVEN = 0.01  # relative deviation of a step below which sampling counts as even


@dataclass(frozen=True)
class Correlation:
    """Correlation of a residual with its past or with an input.

    `signal` names the input, "" for the residual itself; `lag` (k,) s, positive where the residual
    comes later; `values` (k,) between -1 and 1; `expected` (k,) and `bound` (k,): where there is
    nothing but chance, 99 % of the values at one lag lie within `expected` ± `bound`.
    `independent`: as many lags, independent of each other, would stray by chance as far.
    """

    signal: str
    lag: Array
    values: Array
    expected: Array
    bound: Array
    independent: float

    @property
    def beyond(self) -> NDArray[np.bool_]:
        """Which values lie beyond the bound at their lag, (k,)."""
        return np.asarray(np.abs(self.values - self.expected) > self.bound)

    @property
    def beyond_by_chance(self) -> float:
        """How many values lie beyond their bounds by chance, on average."""
        return CHANCE * len(self.lag)

    @property
    def surely_beyond(self) -> NDArray[np.bool_]:
        """Which values lie so far off, (k,), as by chance any of all does in 1 % of recordings."""
        wider = _quantile(CHANCE / self.independent) / _quantile(CHANCE)
        return np.asarray(np.abs(self.values - self.expected) > wider * self.bound)

    @property
    def strongest(self) -> int:
        """Number of the lag, from 0, whose value lies farthest off for its bound."""
        return int(np.argmax(np.abs(self.values - self.expected) / self.bound))


def _quantile(chance: float) -> float:
    """Standard deviations beyond which a normal value lies, to either side, by this chance."""
    from scipy.special import ndtri

    return -float(ndtri(0.5 * chance))


def correlations(file: FileComparison, signal: str) -> tuple[Correlation, ...]:
    """Autocorrelation of a residual, simulated less measured, and its correlation with the inputs.

    Where the motor position is an input, so are its velocity and acceleration. A recording that is
    not evenly sampled is brought to even steps. Chance is what noise of the sensor does, as it is
    known from its floor, in the autocorrelation; and in the correlation with an input, what a
    residual does that hangs together as this one and has nothing to do with that input. Bounds:
    M. S. Bartlett, On the theoretical specification and sampling properties of autocorrelated
    time-series, 1946; L. Ljung, System Identification, 1999, chapter 16.6.

    Parameters
    ----------
    file : FileComparison of a time series
    signal : name of a compared signal

    Returns
    -------
    tuple of Correlation, that of the residual with itself first; inputs that never change are left
    out
    """
    measurement = file.measurement
    measured = measurement.signals[signal]
    simulated = file.trajectory[file.trajectory.measured(signal)]
    noise = file.signals[signal].noise
    series = {
        "": simulated - measured,
        "rounding": rounding_error(simulated, measured, noise),
        **_inputs(measurement),
    }
    time = measurement.time
    even = np.linspace(time[0], time[-1], len(time))
    step = float(even[1] - even[0])
    if np.max(np.abs(time - even)) > _EVEN * step:
        series = {name: np.interp(even, time, values) for name, values in series.items()}
    series = {name: values - np.mean(values) for name, values in series.items()}
    residual, rounding = series.pop(""), series.pop("rounding")
    length = _number_of_lags(residual)
    memory = _noise_memory(rounding, noise.correlation)
    every = [_autocorrelation(residual, memory, length)]
    every += [
        _cross_correlation(name, residual, values, length)
        for name, values in series.items()
        if np.ptp(values) > 0.0
    ]
    return tuple(replace(found, lag=step * found.lag) for found in every)


def _inputs(measurement: Measurement) -> dict[str, Array]:
    inputs = dict(measurement.inputs)
    if "motor_position" in inputs:
        inputs |= {
            name: motor_derivative(measurement, order)
            for order, name in ((1, "motor_velocity"), (2, "motor_acceleration"))
        }
    return inputs


def motor_derivative(measurement: Measurement, order: int) -> Array:
    """Derivative of the motor position as measured, (n,), rad/s or rad/s²; order 1 or 2."""
    from scipy.signal import savgol_filter

    step = float(np.ptp(measurement.time)) / (len(measurement.time) - 1)
    position = measurement.motor_position
    return np.asarray(savgol_filter(position, _SMOOTHED, 3, deriv=order, delta=step))


def _number_of_lags(residual: Array) -> int:
    wanted = max(_MINIMUM_LAGS, int(_TIMES * autocorrelation_time(residual)))
    return max(1, min(wanted, int(_LARGEST_PART * len(residual))))


def _noise_memory(rounding: Array, correlation: float) -> Array:
    """Autocorrelation of a sensor's noise at the lags 0 to n // 2; of steps that of rounding."""
    n = len(rounding)
    if not rounding.any():
        return np.asarray(correlation ** np.arange(n // 2 + 1.0))
    return _correlate(rounding, rounding, n // 2)[n // 2 :]


def _autocorrelation(residual: Array, memory: Array, length: int) -> Correlation:
    """With itself at the lags 1 to `length`, in samples; `memory` as of `_noise_memory`."""
    n = len(residual)
    lags = np.arange(1, length + 1)
    # sums of products of the noise's autocorrelation, at all lags, with itself shifted
    both_sides = np.concatenate([memory[:0:-1], memory])
    spectrum = np.abs(np.fft.rfft(both_sides, 2 * len(both_sides))) ** 2
    products = np.fft.irfft(spectrum)[: 2 * length + 1]
    expected = memory[lags]
    variance = products[0] * (1.0 + 2.0 * expected**2)
    variance += products[2 * lags] - 4.0 * expected * products[lags]
    # no less than that of white noise: how the noise hangs together is itself an estimate
    bound = _quantile(CHANCE) * np.sqrt(np.maximum(variance, 1.0) / n)
    return Correlation(
        signal="",
        lag=lags.astype(np.float64),
        values=_correlate(residual, residual, length)[length + 1 :],
        expected=expected,
        bound=bound,
        independent=1.0 + length / max(1.0, float(products[0])),
    )


def _cross_correlation(name: str, residual: Array, values: Array, length: int) -> Correlation:
    """With an input at the lags -`length` to `length`, in samples."""
    n = len(residual)
    both = _correlate(residual, residual, n // 4) * _correlate(values, values, n // 4)
    # of two independent series: the sum over all lags of the product of their autocorrelations
    alike = max(1.0, float(np.sum(both)))
    lags = np.arange(-float(length), length + 1.0)
    return Correlation(
        signal=name,
        lag=lags,
        values=_correlate(residual, values, length),
        expected=np.zeros(len(lags)),
        bound=np.full(len(lags), min(1.0, _quantile(CHANCE) * np.sqrt(alike / n))),
        independent=1.0 + len(lags) / alike,
    )


def _correlate(late: Array, early: Array, length: int) -> Array:
    """Correlation at the lags -length to length by which `late` follows `early`."""
    size = 2 * len(late)
    spectrum = np.fft.rfft(late, size) * np.conj(np.fft.rfft(early, size))
    covariance = np.fft.irfft(spectrum, size)
    scale = float(np.linalg.norm(late) * np.linalg.norm(early))
    values = np.concatenate([covariance[size - length :], covariance[: length + 1]])
    return values / scale if scale > 0.0 else np.zeros(2 * length + 1)
