"""Noise of a measured signal, from the part of its spectrum that the motion does not reach.

The motion of a joint on springs dies away quickly above its natural frequency: kinks of its
velocity (impacts, stiction) leave a power that falls as f^-4, kinks of its acceleration f^-6. Noise
falls more slowly: white noise not at all, noise that drifts from sample to sample (first-order
autoregressive) as f^-2 at most. So the lowest frequency is looked for above which the spectrum is
explained by noise of one of these kinds and the tail of a motion, and the fitted noise is continued
down to zero frequency, where the motion hides it.

Impacts are rare in time: segments of the recording that a short event makes louder than the others
are left out, and of those that are left the median counts. Differences of second order take the
size out of the motion before the taper has to.

A signal that was filtered has no such part: its spectrum falls, somewhere in its upper half, far
more steeply than any motion or noise does; or, after averages over neighbouring samples, it has
gaps. Below the fall the noise may still show, as a shoulder beside the motion. Where it does not,
what is left at the top is the least that the noise can be, and the rest is not known
(`SpectralNoise.falls_at`).
"""

from dataclasses import dataclass
from functools import cache
from math import pi

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

# fewer samples than this have too few frequencies above a motion
MINIMUM_SAMPLES = 256

_ORDER = 2
_SHORTEST, _LONGEST = 64, 1024  # samples of a segment
_SEGMENTS = 8  # that a recording is long, if that gives such a length
_MOST_SEGMENTS = 400  # overlapping ones, spread over long recordings: they say enough
# a segment has an impact if the upper half of its band holds so many times the power of the quiet
# third of the segments, and its largest square so many times the mean (of noise, about 16): loud
# for all its length, it is noise
_LOUD, _QUIET, _CREST = 2.0, 1.0 / 3.0, 30.0
_FIRST_BIN = 6  # the taper's main lobe is 4 bins to each side
_BAND_RATIO = 1.06  # between neighbouring bands of frequencies
# correlations that are tried, from one sample to the next, as 1 less the correlation
_DECORRELATIONS = np.geomspace(0.85, 0.01, 24)
_TAIL_POWERS = (4, 6)  # at which the power of a motion's tail falls
_TAIL_PLACES = 14  # frequencies at which a tail sinks into the noise
_TAIL_TOP = 0.35  # highest of them, as a share of the sampling rate
# shares of white noise in coloured noise; only a sensor with visible steps has both
_WHITE_SHARES = (0.003, 0.01, 0.02, 0.04, 0.08, 0.16, 0.3)
# a band is worth to be explained rather than left to the motion if it costs less than this in
# log-likelihood; a band of nothing but noise costs 0.5 on average
_WORTH = 0.7
_HIGHEST_LIMIT = 0.25  # of the sampling rate; the noise must explain all frequencies above
_FEWEST_BANDS = 4
# standard deviation of the logarithm of the variance that rounding adds; half a step of the grid
_ROUNDING_SPREAD = 0.35
# prior of the correlation: (1 - correlation) to this power, uniform in log(1 - correlation)
_PRIOR_POWER = 0.75
# no noise is quite like its model: relative error of a spectrum that is not held against it
_MODEL_ERROR = 0.05
# share of a median's information on the mean of squares that are distributed as chi-squared of
# two degrees; and neighbouring bins share half of theirs through the taper
_INFORMATION = 0.5 * 0.5
# the tail of a motion falls by 64 in an octave of the power; noisy motions of the truth simulator
# were seen to fall by 131 above this share of the sampling rate, filters of second order by 19 000
_FALL, _FALL_LOWEST, _OCTAVE = 1000.0, 0.12, 2.0
# octaves that a shoulder is wide at least; noise falls there by less than this power of frequency
_SHOULDER, _NOISE_SLOPE = 0.5, 2.0
# ... what is higher above it than so many times its power is a line, and no filter's fall
_NO_LINE, _MOST_CORRELATED = 4.0, 0.99
# averages leave gaps that are so many times lower than what is beside them on either side, which
# the spectrum of noise over at least `_GAP_SEGMENTS` segments does once in a thousand recordings
_GAP, _GAP_SEGMENTS = 20.0, 5
_BESIDE, _LOBE = 1.4, 0.75  # ratio of frequencies beside a gap, and quantile of their power
_OVERLAP = 4  # segments begin this many times per length
_INDEPENDENT = 0.45  # of a segment's length, apart from each other, are independent ones


@dataclass(frozen=True)
class SpectralNoise:
    """Noise as the high frequencies show it, in the unit of the signal.

    `sigma` is that of all noise together if the high frequencies are noise, `correlation` that from
    one sample to the next, 0 for white noise. `falls_at` is the share of the sampling rate above
    which the spectrum falls too steeply for that, None where it does not; then `least`, the
    standard deviation of white noise as low as the spectrum becomes, is all that is known.
    """

    sigma: float
    correlation: float = 0.0
    falls_at: float | None = None
    least: float = 0.0


@dataclass(frozen=True)
class _Models:
    """Spectra of m mixtures of noise and tail in k bands, for noise of variance one.

    `spectra` and their `logarithms` (m, k); `correlation`, `white_share`, `tail` (true where there
    is one) and `prior`, the logarithm of the models' own probability, (m,). All of the `fewest`
    highest bands must be explained.
    """

    spectra: Array
    logarithms: Array
    correlation: Array
    white_share: Array
    tail: NDArray[np.bool_]
    prior: Array
    fewest: int


def spectral_noise(signal: Array, smallest: float, rounding: float, top: float) -> SpectralNoise:
    """Total noise of a signal and its correlation from sample to sample.

    Parameters
    ----------
    signal : (n,) array, any unit, evenly sampled; n >= MINIMUM_SAMPLES
    smallest : float > 0, the unit of the signal; no noise is smaller
    rounding : float >= 0, the unit of the signal; standard deviation of what rounding to a
        sensor's steps adds as white noise
    top : float, share of the sampling rate above which the spectrum is not used, at most 0.5

    Returns
    -------
    SpectralNoise
    """
    length = 2 ** round(np.log2(np.clip(len(signal) / _SEGMENTS, _SHORTEST, _LONGEST)))
    density, segments = _density(signal, length)
    edges = _band_edges(length, top)
    count = np.diff(edges)
    bands = np.add.reduceat(density[: edges[-1]], edges[:-1]) / count
    # from high to low: limits of the explained part are then ends of cumulated sums
    power = np.maximum(bands, smallest**2)[::-1]
    weight = 1.0 / (1.0 / (_INFORMATION * segments * count) + _MODEL_ERROR**2)
    sigma, correlation = _fitted(power, weight[::-1], _models(length, top), rounding)
    fall = _steep_fall(power, _centres(length, top))
    if fall is not None:
        shoulder = _shoulder(power, _centres(length, top), fall)
        return shoulder or SpectralNoise(sigma, correlation, fall, float(np.sqrt(np.min(power))))
    return SpectralNoise(sigma, correlation, _gap(signal, top), sigma)


def _steep_fall(power: Array, frequency: Array) -> float | None:
    """Frequency above which a spectrum falls as only a filtered one does, None where it does not.

    Parameters
    ----------
    power : (k,) array, from high to low frequencies
    frequency : (k,) array, shares of the sampling rate
    """
    within = (frequency[None, :] > frequency[:, None]) & (
        frequency[None, :] <= _OCTAVE * frequency[:, None]
    )
    lowest = np.min(np.where(within, power[None, :], np.inf), axis=1)
    fall = np.where(frequency >= _FALL_LOWEST, power / lowest, 0.0)
    steepest = int(np.argmax(fall))
    return float(frequency[steepest]) if fall[steepest] >= _FALL else None


def _shoulder(power: Array, frequency: Array, fall: float) -> SpectralNoise | None:
    """Noise that a filter has left, where it shows between the motion and where the filter falls:
    there the power falls as that of noise does. None where it does not show.

    Parameters
    ----------
    power : (k,) array, from high to low frequencies
    frequency : (k,) array, shares of the sampling rate
    fall : of these, above which the spectrum falls too steeply
    """
    from scipy.integrate import trapezoid

    place, height = np.log2(frequency), np.log2(power)
    slopes = np.full(len(power), -np.inf)
    for index in np.flatnonzero(frequency <= fall):
        near = np.abs(place - place[index]) <= _SHOULDER
        if np.sum(near) >= _FEWEST_BANDS:
            slopes[index] = np.polyfit(place[near], height[near], 1)[0]
    flat = np.flatnonzero(np.abs(slopes) < _NOISE_SLOPE)
    if not len(flat):
        return None
    steep = np.flatnonzero(np.abs(slopes[flat[0] :]) >= _NOISE_SLOPE)
    last = flat[0] + (steep[0] if len(steep) else len(slopes) - flat[0])
    inside = slice(flat[0], last)
    if place[flat[0]] - place[last - 1] < _SHOULDER:
        return None
    # as high below as the shoulder is in its middle, and above as it is seen
    low = int(np.median(np.arange(len(power))[inside]))
    if np.max(power[:low]) > _NO_LINE * power[low]:
        return None
    grid = np.concatenate([frequency[: low + 1], [0.0]])[::-1]
    density = np.concatenate([power[: low + 1], [power[low]]])[::-1]
    variance = 2.0 * float(trapezoid(density, grid))
    together = 2.0 * float(trapezoid(density * np.cos(2.0 * pi * grid), grid))
    return SpectralNoise(float(np.sqrt(variance)), min(together / variance, _MOST_CORRELATED))


def _gap(signal: Array, top: float) -> float | None:
    """Frequency of the deepest gap of a spectrum, a share of the sampling rate; None without one.

    Parameters
    ----------
    signal : (n,) array
    top : share of the sampling rate above which the spectrum is not used
    """
    length = int(2 ** np.floor(np.log2(np.clip(len(signal) / _GAP_SEGMENTS, _SHORTEST, _LONGEST))))
    density, _ = _density(signal, length)
    first, end = int(_FALL_LOWEST * length), int(top * length)

    def depth(place: int) -> float:
        below, above = round(place / _BESIDE), min(round(_BESIDE * place), end)
        beside = density[below:place], density[place + 1 : above + 1]
        around = min(float(np.quantile(part, _LOBE)) for part in beside)
        return around / max(float(density[place]), 1e-300)

    # deep is only what lies far below something above it
    highest = np.maximum.accumulate(density[end::-1])[::-1]
    low = _GAP * np.maximum(density[: end - _FIRST_BIN], 1e-300) <= highest[1:-_FIRST_BIN]
    depths = {place: depth(place) for place in (first + np.flatnonzero(low[first:])).tolist()}
    deepest = max(depths, key=depths.__getitem__, default=None)
    return None if deepest is None or depths[deepest] < _GAP else deepest / length


def _taper(length: int) -> Array:
    """Blackman-Harris: its side lobes are 92 dB down; sum of squares one."""
    angle = 2.0 * pi * np.arange(length) / length
    taper = (
        0.35875
        - 0.48829 * np.cos(angle)
        + 0.14128 * np.cos(2.0 * angle)
        - 0.01168 * np.cos(3.0 * angle)
    )
    return np.asarray(taper / np.linalg.norm(taper))


def _density(signal: Array, length: int) -> tuple[Array, float]:
    """Median spectrum over segments, 1 for white noise of variance one, and how many they are.

    Returns (length // 2 + 1,) array in the squared unit, and the number of independent segments.
    """
    count = len(signal) - _ORDER  # of differences
    last = count - length
    starts = np.arange(0, last + 1, length // _OVERLAP)
    if len(starts) > _MOST_SEGMENTS:
        starts = np.linspace(0, last, _MOST_SEGMENTS).astype(int)
    pieces = np.diff(signal[starts[:, None] + np.arange(length + _ORDER)], _ORDER)
    # a saturated sensor shows no noise; the rest of the recording does
    alive = np.any(pieces != 0.0, axis=1)
    if np.any(alive):
        pieces = pieces[alive]
    power = np.abs(np.fft.rfft(pieces * _taper(length), axis=1)) ** 2
    loudness = np.mean(power[:, length // 4 :], axis=1)
    squares = pieces**2
    sharp = np.max(squares, axis=1) > _CREST * np.mean(squares, axis=1)
    power = power[~sharp | (loudness <= _LOUD * np.quantile(loudness, _QUIET))]
    covered = count * len(power) / len(starts)
    independent = max(1.0, min(len(power), covered / (_INDEPENDENT * length)))
    # the filter of the differences is undone; zero frequency is never used
    gain = (2.0 * np.sin(pi * np.arange(power.shape[1]) / length)) ** (2 * _ORDER)
    gain[0] = 1.0
    median = np.asarray(np.median(power, axis=0)) / _median_of_squares(independent)
    return np.asarray(median / gain), independent


def _median_of_squares(count: float) -> float:
    """Expected median of so many independent exponential numbers of mean one."""
    odd = round(count) | 1
    pairs = 2.0 * np.arange(1, (odd - 1) // 2 + 1)
    return float(1.0 + np.sum(1.0 / (pairs + 1.0) - 1.0 / pairs))


def _band_edges(length: int, top: float) -> NDArray[np.int_]:
    """Bins at which the bands begin, and the one at which the last ends."""
    end = min(int(top * length), length // 2)
    edges = [_FIRST_BIN]
    while edges[-1] < end:
        edges.append(min(max(edges[-1] + 1, round(edges[-1] * _BAND_RATIO)), end))
    return np.array(edges)


def _centres(length: int, top: float) -> Array:
    """Mean frequency of every band, from high to low, as a share of the sampling rate."""
    edges = _band_edges(length, top)
    return 0.5 * (edges[:-1] + edges[1:] - 1.0)[::-1] / length


@cache
def _models(length: int, top: float) -> _Models:
    """All mixtures that are tried; the first is white noise alone."""
    frequency = _centres(length, top)
    noises = [(0.0, 0.0)]
    noises += [(1.0 - d, share) for d in _DECORRELATIONS for share in (0.0, *_WHITE_SHARES)]
    correlation, share = np.array(noises).T
    plain = _noise_spectra(frequency, correlation, share)
    spectra = [plain]
    sine = np.sin(pi * frequency)
    for power in _TAIL_POWERS:
        for place in np.geomspace(1.1 * frequency[-1], _TAIL_TOP, _TAIL_PLACES):
            level = _noise_spectra(np.array([place]), correlation, share)
            spectra.append(plain + level * (np.sin(pi * place) / sine) ** power)
    correlation, share = np.tile(correlation, len(spectra)), np.tile(share, len(spectra))
    tail = np.repeat(np.arange(len(spectra)) > 0, len(noises))
    # each grid has the probability one together, however fine it is
    prior = _PRIOR_POWER * np.log(1.0 - correlation) - tail * np.log(len(spectra) - 1.0)
    prior -= (correlation > 0.0) * np.log(len(_DECORRELATIONS))
    prior -= (share > 0.0) * np.log(len(_WHITE_SHARES))
    joined = np.concatenate(spectra)
    fewest = max(int(np.sum(frequency > _HIGHEST_LIMIT)), _FEWEST_BANDS)
    return _Models(joined, np.log(joined), correlation, share, tail, prior, fewest)


def _noise_spectra(frequency: Array, correlation: Array, white_share: Array) -> Array:
    """(m, k) spectra of autoregressive noise and a share of white noise, variance one together."""
    r, share = correlation[:, None], white_share[:, None]
    coloured = (1.0 - r**2) / (1.0 - 2.0 * r * np.cos(2.0 * pi * frequency) + r**2)
    return np.asarray(share + (1.0 - share) * coloured)


def _fitted(power: Array, weight: Array, models: _Models, rounding: float) -> tuple[float, float]:
    """Whittle's likelihood over models and lowest frequency, then the mean over what is likely.

    Parameters
    ----------
    power, weight : (k,) array, from high to low frequencies; the spectrum in the squared unit of
        the signal, and how many independent squares each says as much as
    """
    total = np.cumsum(weight)
    variance = np.cumsum(weight * power / models.spectra, axis=1) / total
    misfit = total * np.log(variance) - np.cumsum(weight * np.log(power))
    misfit += np.cumsum(weight * models.logarithms, axis=1)
    coloured, mixed = models.correlation > 0.0, models.white_share > 0.0
    numbers = coloured.astype(float) + models.tail + mixed
    misfit += 0.5 * numbers[:, None] * np.log(total + 2.0)
    misfit[mixed] += _unlike_rounding(models.white_share[mixed, None] * variance[mixed], rounding)
    cost = misfit - _WORTH * np.arange(1, len(power) + 1)
    limit = models.fewest + int(np.argmin(np.min(cost[:, models.fewest :], axis=0)))
    logarithm = models.prior - misfit[:, limit]
    share = np.exp(logarithm - np.max(logarithm))
    is_coloured = np.sum(share[coloured]) > 0.5 * np.sum(share)
    share = np.where(coloured == is_coloured, share, 0.0)
    share = share / np.sum(share)
    sigma = np.exp(0.5 * np.sum(share * np.log(variance[:, limit])))
    correlation = np.sum(share * models.correlation * (1.0 - models.white_share))
    return float(sigma), float(correlation)


def _unlike_rounding(white: Array, rounding: float) -> Array:
    """Cost in log-likelihood of white variances that are not what rounding adds."""
    if rounding == 0.0:
        return np.full_like(white, np.inf)
    return np.asarray(0.5 * (np.log(white / rounding**2) / _ROUNDING_SPREAD) ** 2)
