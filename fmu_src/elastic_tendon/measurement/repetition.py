"""Noise of a measured signal, where the inputs of the recording repeat.

What a signal does differently from one period to the next, under the same inputs, is its noise.
The estimate knows nothing of the motion and finds noise of any colour, and what else does not
repeat (a load that nobody measured).
"""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

# inputs repeat if they differ by less than this many times what their noise explains
_AGREEMENT = 1.5
# an input that moves less than this many times its noise says nothing about a period
_VISIBLE = 10.0
# share of its spread by which an input without noise may miss its repetition
_EXACT = 1e-6
# a period is longer than the lag at which the input has come away from itself by this share of
# its variance
_AWAY = 0.1
# fewer samples of a period cannot distinguish a transient from noise
_SHORTEST_PERIOD = 40
# samples that show a period; more are thinned first
_ENOUGH = 100_000
# a transient is over where a quarter of a period differs from its repetition by no more than
# this times the median of the later quarters
_SETTLED = 1.5
# correlation, in standard deviations of that of white noise, that is more than chance; neighbours
# of a lag share samples, hence not 3
_CHANCE = 4.0
# less correlation makes no difference, and the rest of a transient may leave as much
_LEAST_CORRELATION = 0.15
# a drift repeats from sample to sample exactly, which no noise does
_MOST_CORRELATION = 0.99


def period_of(inputs: Mapping[str, Array], sigmas: Mapping[str, float]) -> int | None:
    """Samples after which all inputs repeat, for the whole recording.

    Parameters
    ----------
    inputs : name -> (n,) array, any unit, evenly sampled
    sigmas : name -> float, noise of that input, its unit

    Returns
    -------
    int, at most n / 2, the shortest period; None where no input moves, or none repeats
    """
    moving = {
        name: values for name, values in inputs.items() if np.std(values) > _VISIBLE * sigmas[name]
    }
    if not moving:
        return None
    n = len(next(iter(moving.values())))
    every = max(n // _ENOUGH, 1)
    allowed = {name: _allowed(values, sigmas[name]) for name, values in moving.items()}
    # of thinned samples none may be a whole period apart, but half a thinned step beside it
    beside = {name: _difference_at(values, every // 2, every) for name, values in moving.items()}
    rough = _shortest_period(
        {name: values[: n // every * every : every] for name, values in moving.items()},
        {name: allowed[name] + beside[name] for name in moving},
        max(_SHORTEST_PERIOD // every, 1),
    )
    if rough is None or every == 1:
        return rough

    def excess(lag: int) -> float:
        return max(_difference_at(u, lag, every) / allowed[name] for name, u in moving.items())

    best = min(range((rough - 1) * every + 1, min((rough + 1) * every, n // 2 + 1)), key=excess)
    return best if excess(best) <= 1.0 else None


def _allowed(values: Array, sigma: float) -> float:
    """Mean squared difference of samples that repeat."""
    return float(2.0 * (_AGREEMENT * sigma) ** 2 + (_EXACT * np.std(values)) ** 2)


def _difference_at(values: Array, lag: int, every: int) -> float:
    """Mean squared difference at one lag, of every so many samples."""
    return float(np.mean((values[lag::every] - values[: len(values) - lag : every]) ** 2))


def _shortest_period(
    inputs: Mapping[str, Array], allowed: Mapping[str, float], shortest: int
) -> int | None:
    """Shortest lag of at least `shortest` samples at which all inputs repeat.

    Parameters
    ----------
    inputs, allowed : name -> (n,) array, and its mean squared difference where it repeats
    """
    n = len(next(iter(inputs.values())))
    excess = np.zeros(n // 2 + 1)
    away = np.zeros(n // 2 + 1, dtype=bool)
    for name, values in inputs.items():
        difference = _mean_squared_differences(values)
        excess = np.maximum(excess, difference / allowed[name])
        away |= difference > _AWAY * np.var(values)
    if not np.any(away):
        return None
    start = max(int(np.argmax(away)), shortest)
    agreeing = start + np.flatnonzero(excess[start:] <= 1.0)
    if not len(agreeing):
        return None
    # the best of the neighbouring lags that the noise allows
    run = agreeing[: 1 + int(np.argmax(np.diff(np.append(agreeing, 2 * n)) > 1))]
    return int(run[np.argmin(excess[run])])


def _mean_squared_differences(values: Array) -> Array:
    """(n // 2 + 1,) mean of (u[i + lag] - u[i])² for every lag up to half the recording."""
    n = len(values)
    centred = values - np.mean(values)
    spectrum = np.abs(np.fft.rfft(centred, 2 * n)) ** 2
    product = np.fft.irfft(spectrum, 2 * n)[: n // 2 + 1]
    squares = np.concatenate(([0.0], np.cumsum(centred**2)))
    lags = np.arange(n // 2 + 1)
    both = squares[n - lags] + squares[n] - squares[lags]
    # rounding of the transform may leave less than nothing
    return np.asarray(np.maximum(both - 2.0 * product, 0.0) / (n - lags))


def repeated_noise(signal: Array, period: int) -> tuple[float, float] | None:
    """Noise of a signal under inputs that repeat: half the variance between repeated samples.

    Parameters
    ----------
    signal : (n,) array, any unit
    period : int, samples; at most n / 2

    Returns
    -------
    sigma : float, the unit of the signal; 0 where the signal repeats exactly
    correlation : float, from one sample to the next, at most 0.99; 0 where it is no more than
        chance
    None where a transient lasts to the end of the recording
    """
    differences = signal[period:] - signal[:-period]
    end = _end_of_transient(differences, max(period // 4, 1))
    if end is None:
        return None
    settled = differences[end:]
    variance = 0.5 * float(np.mean(settled**2))
    if variance == 0.0:
        return 0.0, 0.0
    correlation = 0.5 * float(np.mean(settled[1:] * settled[:-1])) / variance
    chance = max(_CHANCE / np.sqrt(len(settled)), _LEAST_CORRELATION)
    significant = min(correlation, _MOST_CORRELATION) if correlation > chance else 0.0
    return float(np.sqrt(variance)), significant


def _end_of_transient(differences: Array, quarter: int) -> int | None:
    """First difference from which on the signal repeats as well as later, None if there is none."""
    parts = np.array_split(differences, max(len(differences) // quarter, 1))
    means = [float(np.mean(part**2)) for part in parts]
    for index in range(len(parts) - 1):
        if means[index] <= _SETTLED**2 * np.median(means[index + 1 :]):
            return sum(map(len, parts[:index]))
    return None
