"""Noise floor of a measured signal: how large the noise is, and of what kind.

Where the inputs repeat, from what the signal does differently in the next period (`repetition`).
Else from its high frequencies (`noise_spectrum`), and where samples are too few or too uneven for
a spectrum, from differences: those of order m wipe out everything smooth and multiply the variance
of white noise by binomial(2 m, m). What is left of the motion makes a low order too large; the
estimate falls with the order until only noise is left, so the first order that the next one does
not lower is taken.

Whatever the estimate, a sensor that shows steps has at least the noise of rounding to them.

A signal that was smoothed or filtered shows no noise at its high frequencies. Its floor is then the
least that it can be, and says so (`NoiseFloor.falls_above`): too small a floor makes an error look
large, too large a one would hide it.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from math import sqrt
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from elastic_tendon.measurement.noise_spectrum import (
    MINIMUM_SAMPLES,
    SpectralNoise,
    spectral_noise,
)
from elastic_tendon.measurement.repetition import period_of, repeated_noise

Array = NDArray[np.float64]

_ORDERS = (2, 3, 4, 5, 6, 7, 8)
# an order that lowers the estimate by less than this has no motion left to remove
_SETTLED = 0.98
# samples over which differences are averaged, and the most such blocks of a recording
_BLOCK, _MOST_BLOCKS = 400, 40
# steps of a quantised signal agree with whole counts up to the rounding of the file
_COUNT_TOLERANCE = 0.05
# samples in which a signal rests at least, and times the median of such stretches
_LONG, _FAR_LONGER = 50, 10.0
_ENOUGH = 1_000_000  # samples whose levels tell the steps of a sensor
# finest spacing that a sensor can show, relative to its range: below it levels differ by rounding
_ROUNDING = 1e-9
# what is left of a number after a few operations, relative to it
_PRECISION = 1e-15
# share of the moves that go back on the one before, above which a signal chatters
_CHATTER = 0.02
# steps of time that differ by more than this share are uneven
_JITTER = 0.01
# steps of time that are mostly within these shares of their median leave room for a spline
_SPLINE_STEPS = (0.4, 2.5)
# of the sampling rate: above, a spline through uneven samples shows less than their noise
_SPLINE_TOP = 0.25

Method = Literal["repeated periods", "high frequencies", "what was given"]
Source = Literal["given", "periods", "spectrum"]

_SOURCES: Mapping[Method, Source] = {
    "repeated periods": "periods",
    "high frequencies": "spectrum",
    "what was given": "given",
}


@dataclass(frozen=True)
class NoiseFloor:
    """Noise of one signal: what kind it is, how large, and how it was found.

    `sigma` is the total standard deviation in the signal's unit, never zero. `correlation` is the
    autocorrelation of coloured noise from one sample to the next, at most 0.99; 0 for the other
    kinds. `source` is `method` by the word of the JSON. `spectrum` is what the high frequencies
    alone say, in the signal's unit; where they say nothing, because the spectrum falls too
    steeply for noise above `falls_above` (Hz), it is the least that they allow.
    """

    sigma: float
    kind: Literal["white", "coloured", "quantised"]
    method: Method = "high frequencies"
    correlation: float = 0.0
    spectrum: float | None = None
    falls_above: float | None = None
    source: Source = field(init=False)

    def __post_init__(self) -> None:
        """Set what follows from the method."""
        object.__setattr__(self, "source", _SOURCES[self.method])

    @property
    def is_least(self) -> bool:
        """Whether the noise may be larger, and nothing in the recording tells by how much."""
        return self.source == "spectrum" and self.falls_above is not None

    @property
    def white_share(self) -> float:
        """Share of white noise in the variance that was given, 0 to 1: what is more than the high
        frequencies show is slow, as the noise of a load that was computed. 1 where none was given.
        """
        if self.source != "given" or self.kind != "white" or self.spectrum is None:
            return 1.0
        return min((self.spectrum / self.sigma) ** 2, 1.0)

    def given(self, sigma: float, least: float) -> "NoiseFloor":
        """The floor that a user gives, beside what the recording itself says.

        Parameters
        ----------
        sigma : float > 0, the signal's unit
        least : float >= 0, the signal's unit; what rounding to a sensor's steps adds at least
        """
        size = max(sigma, least)
        kind: Literal["white", "quantised"] = "quantised" if least > size / sqrt(2.0) else "white"
        if self.kind == "coloured" and not self.is_least:
            return replace(self, sigma=size, method="what was given")
        return replace(self, sigma=size, kind=kind, method="what was given", correlation=0.0)


def noise_floors(
    time: Array, inputs: Mapping[str, Array], signals: Mapping[str, Array]
) -> dict[str, NoiseFloor]:
    """Noise floor of every signal of a recording.

    Parameters
    ----------
    time : (n,) array, s, strictly increasing; n >= 10
    inputs : name -> (n,) array, any unit; motor position and load: where they repeat, so do the
        signals, up to their noise
    signals : name -> (n,) array, any unit

    Returns
    -------
    dict, name of a signal -> NoiseFloor
    """
    period = None
    if is_even(time):
        sigmas = {
            name: _from_high_frequencies(time, values).sigma for name, values in inputs.items()
        }
        period = period_of(inputs, sigmas)
    return {name: _noise_floor(time, values, period) for name, values in signals.items()}


def is_even(time: Array) -> bool:
    """Whether the steps of times (n,), n >= 2, differ by no more than an even clock's jitter."""
    mean_step = (time[-1] - time[0]) / (len(time) - 1)
    return bool(np.ptp(np.diff(time)) <= _JITTER * mean_step)


def _is_near_even(time: Array) -> bool:
    steps = np.diff(time)
    low, high = np.quantile(steps, [0.05, 0.95]) / np.median(steps)
    return bool(low >= _SPLINE_STEPS[0] and high <= _SPLINE_STEPS[1])


def rounding_noise(signal: Array) -> float:
    """Standard deviation of rounding to a sensor's steps, the signal's unit; 0 without steps."""
    return quantisation_step(signal) / sqrt(12.0)


def _noise_floor(time: Array, signal: Array, period: int | None) -> NoiseFloor:
    rounding = rounding_noise(signal)
    least = max(rounding, _smallest(signal))
    high = _from_high_frequencies(time, signal)
    repeated = None if period is None else repeated_noise(signal, period)
    method: Method = "high frequencies" if repeated is None else "repeated periods"
    filtered = high.falls_at is not None
    spectrum, colour = (high.least, 0.0) if filtered else (high.sigma, high.correlation)
    noise, correlation = repeated or (spectrum, colour)
    # a dithered sensor shows its steps in the estimate as well, hence the larger, not the sum
    sigma = max(noise, least)
    floor = NoiseFloor(
        sigma,
        "coloured" if correlation > 0.0 else "white",
        method,
        correlation,
        spectrum=max(spectrum, least),
        falls_above=None if high.falls_at is None else high.falls_at * _rate(time),
    )
    if rounding > sigma / sqrt(2.0):
        return replace(floor, kind="quantised", correlation=0.0)
    return floor


def _rate(time: Array) -> float:
    """Mean sampling rate, Hz."""
    return float((len(time) - 1) / (time[-1] - time[0]))


def _smallest(signal: Array) -> float:
    """Noise that every signal has, for its numbers are rounded."""
    return max(
        _ROUNDING * max(float(np.ptp(signal)), 1.0), _PRECISION * float(np.max(np.abs(signal)))
    )


def _from_high_frequencies(time: Array, signal: Array) -> SpectralNoise:
    """Noise, in the unit of the signal, and its correlation from sample to sample."""
    centred = np.asarray(signal - np.mean(signal), dtype=np.float64)
    even = is_even(time)
    if len(centred) < MINIMUM_SAMPLES or not (even or _is_near_even(time)):
        return SpectralNoise(_difference_sigma(time, centred))
    step = quantisation_step(centred)
    if _is_only_rounded(centred, step):
        return SpectralNoise(step / sqrt(12.0))
    noise = spectral_noise(
        centred if even else _at_even_times(time, centred),
        smallest=_smallest(signal),
        rounding=step / sqrt(12.0),
        top=0.5 if even else _SPLINE_TOP,
    )
    # a spline through uneven samples falls by itself
    return noise if even else replace(noise, falls_at=None)


def _is_only_rounded(signal: Array, step: float) -> bool:
    """Whether a slow signal goes from step to step without the chatter of any other noise.

    The error of rounding is then no noise at all but a sawtooth, which a spectrum would misread.
    """
    moves = np.diff(signal)
    if step == 0.0 or np.median(np.abs(moves)) > step:
        return False
    signs = np.sign(moves[moves != 0.0])
    return len(signs) < 2 or bool(np.mean(signs[1:] != signs[:-1]) < _CHATTER)


def _at_even_times(time: Array, signal: Array) -> Array:
    """The signal between uneven samples, at the median step of the same time."""
    from scipy.interpolate import CubicSpline

    step = float(np.median(np.diff(time)))
    count = min(int((time[-1] - time[0]) / step) + 1, 2 * len(time))
    even = np.linspace(time[0], time[-1], count)
    return np.asarray(CubicSpline(time, signal)(even))


def _difference_sigma(time: Array, signal: Array) -> float:
    """White noise from divided differences, which uneven samples do not harm."""
    count = min(max(len(signal) // _BLOCK, 1), _MOST_BLOCKS)
    starts = np.linspace(0, max(len(signal) - _BLOCK, 0), count).astype(int)
    blocks = [(time[start:][:_BLOCK], signal[start:][:_BLOCK]) for start in starts]
    sigma = np.inf
    for order in _ORDERS:
        # ten samples are the least there are, so every order leaves some differences
        squares = [_noise_of_order(*block, order) ** 2 for block in blocks]
        # impacts are in few of the blocks
        following = sqrt(float(np.median(squares)))
        if following > _SETTLED * sigma:
            break
        sigma = following
    return float(sigma)


def _noise_of_order(time: Array, signal: Array, order: int) -> float:
    """Root mean square of the differences, scaled such that white noise keeps its size."""
    count = len(signal) - order
    times = np.stack([time[shift : shift + count] for shift in range(order + 1)])
    values = np.stack([signal[shift : shift + count] for shift in range(order + 1)])
    apart = (times[:, None] - times[None, :]) / np.median(np.diff(time))
    apart[np.arange(order + 1), np.arange(order + 1)] = 1.0
    weights = 1.0 / np.prod(apart, axis=1)
    weights /= np.linalg.norm(weights, axis=0)
    return float(np.sqrt(np.mean(np.sum(weights * values, axis=0) ** 2)))


def rests(signal: Array) -> NDArray[np.bool_]:
    """Which samples (n,) belong to stretches of one value that are far longer than is usual."""
    edges = np.flatnonzero(np.diff(signal, prepend=np.nan, append=np.nan))
    lengths = np.diff(edges)
    return np.repeat(lengths > max(_LONG, _FAR_LONGER * float(np.median(lengths))), lengths)


def quantisation_step(signal: Array) -> float:
    """Smallest step between the levels of a quantised signal, 0 where it has none.

    Parameters
    ----------
    signal : (n,) array, any unit

    Returns
    -------
    float, the unit of the signal
    """
    # so many of its samples show all steps that a sensor has, and take long enough to sort
    signal = signal[:: -(-len(signal) // _ENOUGH)]
    levels = np.unique(signal)
    gaps = np.diff(levels)
    gaps = gaps[gaps > _smallest(signal)]
    if len(gaps) < 2:
        return float(gaps[0]) if len(gaps) else 0.0
    step = float(np.median(gaps[gaps < 1.5 * gaps.min()]))
    counts = gaps / step
    if len(levels) == len(signal) and np.all(np.round(counts) == 1.0):
        return 0.0  # a constant speed, which takes a step of its own from sample to sample
    whole = np.abs(counts - np.round(counts)) < _COUNT_TOLERANCE
    return step if np.mean(whole) > 0.95 else 0.0
