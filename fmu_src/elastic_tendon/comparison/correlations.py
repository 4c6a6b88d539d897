"""What is left in the error: its correlation with itself and with what drives the joint.

An error that is only noise follows neither its own past nor the inputs. How far estimates stray
from that by chance depends on how smooth both series are, so the bounds are Bartlett's and not
the usual ones of white noise: those call every smooth input guilty.
"""

from dataclasses import dataclass

import numpy as np
from scipy.signal import savgol_filter

from elastic_tendon.comparison.compare import FileComparison
from elastic_tendon.comparison.residuals import Array, autocorrelation_time
from elastic_tendon.measurement import Measurement

# quantile of the normal distribution: of an error that is only noise, 99 % lies within
BOUND = 2.576
# lags go on for this many autocorrelation times, where the recording is long enough
_TIMES = 5.0
_MINIMUM_LAGS = 25
_LARGEST_PART = 0.25  # of a recording; later lags have too few pairs
_SMOOTHED = 9  # samples over which the motor position is differentiated; an encoder rounds it
_EVEN = 0.01  # relative deviation of a step below which sampling counts as even


@dataclass(frozen=True)
class Correlation:
    """Correlation of an error with its past or with an input.

    `signal` names the input, "" for the error itself; `lag` (k,) s, positive where the error comes
    later; `values` (k,) between -1 and 1; `expected` (k,) and `bound` (k,): of an error that is
    only noise, 99 % of the values at one lag lie within `expected` ± `bound`.
    """

    signal: str
    lag: Array
    values: Array
    expected: Array
    bound: Array


def correlations(file: FileComparison, signal: str) -> tuple[Correlation, ...]:
    """Autocorrelation of an error, and its correlation with motor velocity, acceleration, load.

    The error is brought to even steps where it is not evenly sampled. Bounds: M. S. Bartlett, On
    the theoretical specification and sampling properties of autocorrelated time-series, 1946.

    Parameters
    ----------
    file : FileComparison of a time series
    signal : name of a compared signal

    Returns
    -------
    tuple of Correlation, that of the error with itself first; inputs that never change are left out
    """
    measurement = file.measurement
    error = file.trajectory[file.trajectory.measured(signal)] - measurement.signals[signal]
    time = measurement.time
    even = np.linspace(time[0], time[-1], len(time))
    series = {"": error, **_inputs(measurement)}
    if np.max(np.abs(time - even)) > _EVEN * (even[1] - even[0]):
        series = {name: np.interp(even, time, values) for name, values in series.items()}
    error = series.pop("")
    error = error - np.mean(error)
    length = _number_of_lags(error)
    step = float(even[1] - even[0])
    noise = file.signals[signal].noise.correlation
    own = _autocorrelation(error, length, step, noise)
    with_inputs = (
        _cross_correlation(name, error, values - np.mean(values), length, step, noise)
        for name, values in series.items()
        if np.ptp(values) > 0.0
    )
    return (own, *with_inputs)


def _inputs(measurement: Measurement) -> dict[str, Array]:
    step = float(np.ptp(measurement.time)) / (len(measurement.time) - 1)
    position = measurement.motor_position
    inputs = {
        name: np.asarray(savgol_filter(position, _SMOOTHED, 3, deriv=order, delta=step))
        for name, order in (("motor_velocity", 1), ("motor_acceleration", 2))
    }
    if measurement.load_torque is not None:
        inputs["load_torque"] = measurement.load_torque
    return inputs


def _number_of_lags(error: Array) -> int:
    wanted = max(_MINIMUM_LAGS, int(_TIMES * autocorrelation_time(error)))
    return max(1, min(wanted, int(_LARGEST_PART * len(error))))


def _autocorrelation(error: Array, length: int, step: float, noise: float) -> Correlation:
    """`noise`: correlation of the noise from one sample to the next."""
    lags = np.arange(1.0, length + 1.0)
    values = _correlate(error, error, length)[length + 1 :]
    expected = noise**lags
    squared = expected**2
    # variance of the estimates for a first-order autoregression, 1/n where it is white
    variance = (1.0 + noise**2) * (1.0 - squared) / (1.0 - noise**2) - 2.0 * lags * squared
    bound = BOUND * np.sqrt(np.maximum(variance, 0.0) / len(error))
    return Correlation("", step * lags, values, expected, bound)


def _cross_correlation(
    name: str, error: Array, signal: Array, length: int, step: float, noise: float
) -> Correlation:
    """`noise` as in `_autocorrelation`; an error that is no noise must not widen its own bound."""
    n = len(error)
    apart = np.abs(np.arange(-(n // 4), n // 4 + 1))
    both = noise**apart * _correlate(signal, signal, n // 4)
    # of two independent series: the sum over all lags of the product of their autocorrelations
    variance = max(1.0, float(np.sum(both))) / n
    lags = np.arange(-float(length), length + 1.0)
    return Correlation(
        signal=name,
        lag=step * lags,
        values=_correlate(error, signal, length),
        expected=np.zeros(len(lags)),
        bound=np.full(len(lags), min(1.0, BOUND * np.sqrt(variance))),
    )


def _correlate(late: Array, early: Array, length: int) -> Array:
    """Correlation at the lags -length to length by which `late` follows `early`."""
    size = 2 * len(late)
    spectrum = np.fft.rfft(late, size) * np.conj(np.fft.rfft(early, size))
    covariance = np.fft.irfft(spectrum, size)
    scale = float(np.linalg.norm(late) * np.linalg.norm(early))
    values = np.concatenate([covariance[size - length :], covariance[: length + 1]])
    return values / scale if scale > 0.0 else np.zeros(2 * length + 1)
