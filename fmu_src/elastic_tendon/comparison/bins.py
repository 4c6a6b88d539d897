"""The squared error of one signal, split by what the joint was doing.

Whether a bin's error is more than noise is judged by its mean square over the noise floor, which
for noise alone follows an F distribution. Its first degrees of freedom are the number of
independent samples in the bin, after the autocorrelation of the squared residual and of the noise;
its second ones express how well the noise floor itself is known. What a quantised sensor adds is
neither even over a motion nor white where the motion is slow, so there the floor of each bin is at
least what rounding does to the simulated signal.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from elastic_tendon.comparison.averaging import block_means
from elastic_tendon.comparison.partition import FEW, Partition, memory_of, range_text
from elastic_tendon.comparison.residuals import Array
from elastic_tendon.measurement import NoiseFloor

# fewer independent samples say nothing about a mean square
MINIMUM_FREEDOM = 1.0
OCTAVES = 9
LEAST_FREQUENCIES = 4  # in the lowest band
EVEN = 1e-3  # share of a step by which a sample may be off an even grid
# times the noise, what a band may hold on top: inputs between samples are known no better
NEGLIGIBLE = 0.33
RISK = 0.05  # that any bin of a signal stands out where there is nothing but noise
# relative standard error of the squared noise floor, by its kind
FLOOR_ERROR = {"white": 0.08, "quantised": 0.15, "coloured": 0.4}


@dataclass(frozen=True)
class Bin:
    """Error of one signal over the samples of one bin, simulated less measured.

    `by` is the variable and `bin` says in words which part of it; `lower` and `upper` are its
    edges in SI units (Hz for the frequency), None where it has none. `count` samples (values of
    the spectrum for a frequency); `rmse` and `bias` in the signal's unit; `share` of the signal's
    squared error, which add up to 1 over the bins of one variable. `significance`: by how many
    standard errors the mean square lies above the noise floor, None where the bin is too short to
    tell. `stands_out`: it does so with 5 % risk for all bins of the signal together.
    """

    by: str
    bin: str
    lower: float | None
    upper: float | None
    count: int
    rmse: float
    bias: float
    share: float
    significance: float | None
    stands_out: bool


def bins_of(
    residual: Array,
    measured: Array,
    time: Array,
    parts: Mapping[str, Partition],
    noise: NoiseFloor,
    *,
    static: bool,
    stride: int = 1,
) -> tuple[Bin, ...]:
    """Split the squared error of one signal by every variable and by frequency.

    Parameters
    ----------
    residual : (n,) array, simulated less measured
    measured : (n,) array, the signal
    time : (n,) array, s
    parts : of `partition.partitions`, of n samples or of blocks of them
    noise : NoiseFloor of the signal
    static : whether the recording is a slow sweep, which has no frequencies
    stride : samples in a block; the figures are those of all samples

    Returns
    -------
    tuple of Bin; empty bins are left out
    """
    squares = residual**2
    memory = memory_of(squares - np.mean(squares))
    memory = max(memory, (1.0 + noise.correlation**2) / (1.0 - noise.correlation**2))
    rounding = rounding_error(residual + measured, measured, noise)
    means = [block_means(samples, stride) for samples in (residual, squares, rounding**2)]
    bins = [unjudged for part in parts.values() for unjudged in _split(part, means, memory, noise)]
    if not static:
        bins += _octaves(residual, rounding, time, noise)
    return _assessed(bins, FLOOR_ERROR[noise.kind])


def rounding_error(simulated: Array, measured: Array, noise: NoiseFloor) -> Array:
    """What a sensor of the measured steps would do to the simulated signal; 0 without steps.

    Parameters
    ----------
    simulated, measured : (n,) arrays, the signal
    noise : NoiseFloor of the signal

    Returns
    -------
    (n,) array, the signal's unit
    """
    if noise.kind != "quantised":
        return np.zeros(len(simulated))
    step = np.sqrt(12.0) * noise.sigma
    counts = (simulated - measured[0]) / step
    return np.asarray(step * (np.rint(counts) - counts))


@dataclass(frozen=True)
class _Unjudged:
    """A bin before it is judged: mean square over the noise's, from so many independent samples."""

    bin: Bin
    ratio: float
    freedom: float


def _split(
    part: Partition, blocks: list[Array], memory: float, noise: NoiseFloor
) -> list[_Unjudged]:
    """`blocks`: means of the residual, of its square, and of the square of what rounding does."""
    bias, squares, roundings = (part.means(block) for block in blocks)
    floors = np.maximum(roundings, noise.sigma**2)
    sums = part.counts * squares
    total = float(np.sum(sums)) or 1.0
    bins = []
    for index, words in enumerate(part.words):
        edges = (None, None) if part.edges is None else part.edges[index : index + 2].tolist()
        bin_ = Bin(
            by=part.by,
            bin=words,
            lower=edges[0],
            upper=edges[1],
            count=int(part.counts[index]),
            rmse=float(np.sqrt(squares[index])),
            bias=float(bias[index]),
            share=float(sums[index]) / total,
            significance=None,
            stands_out=False,
        )
        ratio = float(squares[index] / floors[index])
        enough = bin_.count >= FEW
        bins.append(_Unjudged(bin_, ratio, bin_.count / memory if enough else 0.0))
    return bins


def _octaves(residual: Array, rounding: Array, time: Array, noise: NoiseFloor) -> list[_Unjudged]:
    """Bins of one octave each, down to the lowest that holds enough frequencies."""
    power = _power(residual, time)
    angles = np.linspace(0.0, np.pi, len(power))
    density = noise_density(angles, noise)
    density *= noise.sigma**2 / np.sum(density)
    step = float(time[-1] - time[0]) / (len(time) - 1)
    lowest = min(OCTAVES, int(np.log2(max(len(power) / LEAST_FREQUENCIES, 1.0))))
    edges = np.append(0.0, 0.5 / step * 2.0 ** np.arange(-lowest, 1.0))
    starts = np.append(0, np.ceil(len(power) * 2.0 ** np.arange(-lowest, 0.0)).astype(int))
    sums = np.add.reduceat(power, starts)
    floors = np.add.reduceat(density, starts) + (NEGLIGIBLE * noise.sigma) ** 2
    if rounding.any():
        floors = np.maximum(floors, np.add.reduceat(_power(rounding, time), starts))
    counts = np.diff(np.append(starts, len(power)))
    total = float(np.sum(sums)) or 1.0
    octaves = []
    for index, (lower, upper) in enumerate(pairwise(edges.tolist())):
        bin_ = Bin(
            by="frequency",
            bin=f"{range_text(lower, upper)} Hz",
            lower=lower,
            upper=upper,
            count=int(counts[index]),
            rmse=float(np.sqrt(sums[index])),
            bias=float(np.mean(residual)) if index == 0 else 0.0,
            share=float(sums[index]) / total,
            significance=None,
            stands_out=False,
        )
        ratio = float(sums[index] / floors[index])
        octaves.append(_Unjudged(bin_, ratio, 2.0 * float(counts[index])))
    return octaves


def _power(values: Array, time: Array) -> Array:
    """Mean square of (n,) values at each frequency from 0 to half the mean rate; they add up."""
    from scipy.fft import rfft

    n = len(values)
    grid = np.linspace(time[0], time[-1], n)
    if np.max(np.abs(time - grid)) > EVEN * (grid[1] - grid[0]):
        values = np.interp(grid, time, values)
    power = np.abs(np.asarray(rfft(values)) / n) ** 2
    power[1 : (n + 1) // 2] *= 2.0  # the negative frequencies
    return np.asarray(power)


def noise_density(angle: Array, noise: NoiseFloor) -> Array:
    """Spectral density of noise of variance 1; its mean over all angles is 1.

    Parameters
    ----------
    angle : (k,) array, rad a sample, 0 to π
    noise : NoiseFloor; coloured noise is taken as first-order autoregressive
    """
    rho = noise.correlation
    return (1.0 - rho**2) / np.asarray(1.0 - 2.0 * rho * np.cos(angle) + rho**2)


def _assessed(unjudged_bins: list[_Unjudged], floor_error: float) -> tuple[Bin, ...]:
    """Say of each bin how far it lies above the noise; Holm's correction over all of them."""
    from scipy.special import fdtrc

    testable = [
        index for index, unjudged in enumerate(unjudged_bins) if unjudged.freedom >= MINIMUM_FREEDOM
    ]
    ratio = np.array([unjudged_bins[index].ratio for index in testable])
    freedom = np.array([unjudged_bins[index].freedom for index in testable])
    significance = np.asarray((ratio - 1.0) / np.sqrt(2.0 / freedom + floor_error**2))
    chance = np.asarray(fdtrc(freedom, 2.0 / floor_error**2, ratio))
    order = np.argsort(chance)
    small = chance[order] < RISK / np.arange(len(order), 0, -1)
    out = set(order[: len(order) if small.all() else int(np.argmin(small))].tolist())
    bins = [unjudged.bin for unjudged in unjudged_bins]
    for place, index in enumerate(testable):
        bins[index] = replace(
            bins[index], significance=float(significance[place]), stands_out=place in out
        )
    return tuple(bins)
