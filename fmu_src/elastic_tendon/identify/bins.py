"""The squared error of one signal, split by what the joint was doing.

Whether a bin's error is more than noise is judged by its mean square over the noise floor, which
for noise alone follows an F distribution. Its first degrees of freedom are the number of
independent samples in the bin, after the autocorrelation of the squared residual and of the noise;
its second ones express how well the noise floor itself is known.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from elastic_tendon.identify.residuals import Array, autocorrelation_time
from elastic_tendon.measurement import NoiseFloor
from elastic_tendon.parameters import Model
from elastic_tendon.transmission import SlackState, slack_boundaries

Integers = NDArray[np.int_]

PARTS = 8  # of the range of a variable
STRETCHES = 10  # of the recording
# a bin at an end that holds less than this share of all samples joins its neighbour
SCARCE = 0.01
# slower than this share of the largest speed counts as rest
REST_SHARE = 0.01
# more blocks than these cost time and say no more
MOST_BLOCKS = 2000
# fewer independent samples say nothing about a mean square
MINIMUM_FREEDOM = 1.0
OCTAVES = 9
LEAST_FREQUENCIES = 4  # in the lowest band
RISK = 0.05  # that any bin of a signal stands out where there is nothing but noise
# relative standard error of the squared noise floor, by its kind
FLOOR_ERROR = {"white": 0.08, "quantised": 0.15, "coloured": 0.3}
UNITS = {
    "deflection": "rad",
    "joint_velocity": "rad/s",
    "joint_acceleration": "rad/s²",
    "motor_position": "rad",
    "load_torque": "N·m",
    "time": "s",
}
# what a slow sweep has too little of to be split by
MOTION = ("joint_velocity", "joint_acceleration")


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


@dataclass(frozen=True)
class Sums:
    """Sums of a quantity over k bins and m blocks of neighbouring samples: (k, m) arrays."""

    total: Array
    count: Array

    def mean_with_error(self) -> tuple[Array, Array, Array]:
        """Mean of each bin, its standard error by the scatter of the blocks, and the degrees of
        freedom of that; (k,) arrays.
        """
        weight = self.count / self.count.sum(axis=1, keepdims=True)
        mean = self.total.sum(axis=1) / self.count.sum(axis=1)
        block = np.divide(self.total, self.count, out=np.zeros_like(weight), where=self.count > 0)
        freedom = 1.0 / np.sum(weight**2, axis=1) - 1.0
        scatter = np.sum(weight**2 * (block - mean[:, None]) ** 2, axis=1)
        correction = (freedom + 1.0) / np.maximum(freedom, 1e-9)
        return mean, np.sqrt(scatter * correction), freedom


@dataclass(frozen=True)
class Partition:
    """Samples sorted into k bins of one variable.

    `member` (n,), the bin of each sample; `words` of each bin; `edges` (k + 1,) where the variable
    is a quantity of `unit`.
    """

    by: str
    member: Integers
    counts: Integers
    words: tuple[str, ...]
    edges: Array | None = None
    unit: str | None = None

    def means(self, values: Array) -> Array:
        """Mean of (n,) values in each bin, (k,)."""
        return np.bincount(self.member, values, len(self.counts)) / self.counts

    def by_block(self, values: Array, blocks: Integers) -> Sums:
        """Sums of (n,) values over bins and blocks, `blocks` (n,) from `blocks_of`."""
        shape = (len(self.counts), int(blocks[-1]) + 1)
        cell = self.member * shape[1] + blocks
        size = shape[0] * shape[1]
        total = np.bincount(cell, values, size).reshape(shape)
        return Sums(total, np.bincount(cell, minlength=size).reshape(shape).astype(float))


def blocks_of(correlation_time: float, n: int) -> Integers:
    """Number of the block of each of n samples; blocks are twice as long as the samples' memory.

    Parameters
    ----------
    correlation_time : float, samples, see `residuals.autocorrelation_time`
    n : int
    """
    length = int(np.ceil(max(2.0 * correlation_time, n / MOST_BLOCKS)))
    return np.arange(n) // length


def partitions(
    variables: Mapping[str, Array], model: Model, *, static: bool
) -> dict[str, Partition]:
    """Sort the samples of a recording by each of its variables.

    Parameters
    ----------
    variables : as in `locate.FileLocation`
    model : Model; its slack boundaries are edges of the bins of the deflection
    static : whether the recording is a slow sweep, whose speed means nothing

    Returns
    -------
    dict, name of a variable -> Partition; a variable that does not change is left out
    """
    found = [_slack_states(variables["slack_state"])]
    boundaries = slack_boundaries(model.transmission)
    for by in UNITS:
        if static and by in MOTION:
            continue
        values = variables[by]
        if np.ptp(values) > 1e-9 * np.max(np.abs(values)):
            inner = boundaries if by == "deflection" else ()
            found.append(_parts(by, values, STRETCHES if by == "time" else PARTS, inner))
    found.append(_directions(variables["joint_velocity"]))
    return {one.by: one for one in found if len(one.counts)}


def _slack_states(states: Array) -> Partition:
    present, member, counts = np.unique(states.astype(int), return_inverse=True, return_counts=True)
    words = tuple(SlackState(number).label for number in present)
    return Partition("slack_state", member, counts, words)


def _directions(velocity: Array) -> Partition:
    rest = REST_SHARE * float(np.max(np.abs(velocity)))
    sign = np.where(np.abs(velocity) <= rest, 0, np.sign(velocity)).astype(int)
    present, member, counts = np.unique(sign, return_inverse=True, return_counts=True)
    names = {-1: "negative", 0: "at rest", 1: "positive"}
    return Partition("velocity_sign", member, counts, tuple(names[one] for one in present))


def _parts(by: str, values: Array, parts: int, inner: tuple[float, ...]) -> Partition:
    """Equal parts of the range; edges next to `inner` move there, scarce ends join neighbours."""
    lowest, highest = float(np.min(values)), float(np.max(values))
    edges = np.linspace(lowest, highest, parts + 1)
    for boundary in inner:
        if lowest < boundary < highest:
            edges[1 + int(np.argmin(np.abs(edges[1:-1] - boundary)))] = boundary
    member = np.searchsorted(edges[1:-1], values, side="right")
    counts = np.bincount(member, minlength=parts)
    kept = _joined(counts, max(SCARCE * len(values), 2.0))
    edges = edges[np.append(kept, parts)]
    edges[0] = lowest
    sizes = np.add.reduceat(counts, kept)
    number = np.searchsorted(kept, np.arange(parts), side="right") - 1
    member = np.maximum(number, 0)[member]
    unit = UNITS[by]
    words = tuple(f"{a:.3g} to {b:.3g} {unit}" for a, b in zip(edges[:-1], edges[1:], strict=True))
    return Partition(by, member, sizes, words, edges, unit)


def _joined(counts: Integers, least: float) -> Integers:
    """First of the neighbouring parts of each bin, so that every bin holds at least `least`."""
    first, held, starts = 0, 0, []
    for index, count in enumerate(counts):
        held += int(count)
        if held >= least:
            starts.append(first)
            first, held = index + 1, 0
    # what is left over at the upper end belongs to the last bin
    return np.array(starts or [0])


def bins_of(
    residual: Array, time: Array, parts: Mapping[str, Partition], noise: NoiseFloor, *, static: bool
) -> tuple[Bin, ...]:
    """Split the squared error of one signal by every variable and by frequency.

    Parameters
    ----------
    residual : (n,) array, simulated less measured
    time : (n,) array, s
    parts : of `partitions`
    noise : NoiseFloor of the signal
    static : whether the recording is a slow sweep, which has no frequencies

    Returns
    -------
    tuple of Bin; empty bins are left out
    """
    squares = residual**2
    memory = autocorrelation_time(squares - np.mean(squares))
    memory = max(memory, (1.0 + noise.correlation**2) / (1.0 - noise.correlation**2))
    found = [one for part in parts.values() for one in _split(part, residual, memory, noise)]
    if not static:
        found += _octaves(residual, time, noise)
    return _judged(found, FLOOR_ERROR[noise.kind])


@dataclass(frozen=True)
class _Unjudged:
    """A bin before it is judged: mean square over the noise's, from so many independent samples."""

    bin: Bin
    ratio: float
    freedom: float


def _split(part: Partition, residual: Array, memory: float, noise: NoiseFloor) -> list[_Unjudged]:
    squares = part.means(residual**2)
    sums = part.counts * squares
    total = float(np.sum(sums)) or 1.0
    edges = (
        [(None, None)] * len(squares)
        if part.edges is None
        else list(zip(part.edges[:-1].tolist(), part.edges[1:].tolist(), strict=True))
    )
    bias = part.means(residual)
    return [
        _Unjudged(
            Bin(
                by=part.by,
                bin=words,
                lower=lower,
                upper=upper,
                count=int(part.counts[index]),
                rmse=float(np.sqrt(squares[index])),
                bias=float(bias[index]),
                share=float(sums[index]) / total,
                significance=None,
                stands_out=False,
            ),
            ratio=float(squares[index]) / noise.sigma**2,
            freedom=float(part.counts[index]) / memory,
        )
        for index, (words, (lower, upper)) in enumerate(zip(part.words, edges, strict=True))
    ]


def _octaves(residual: Array, time: Array, noise: NoiseFloor) -> list[_Unjudged]:
    """Bins of one octave each, down to the lowest that holds enough frequencies."""
    from scipy.fft import rfft

    n = len(residual)
    step = float(time[-1] - time[0]) / (n - 1)
    power = np.abs(rfft(np.interp(np.linspace(time[0], time[-1], n), time, residual)) / n) ** 2
    power[1 : (n + 1) // 2] *= 2.0  # the negative frequencies
    floor = np.full(len(power), noise.sigma**2 / n)
    floor[1 : (n + 1) // 2] *= 2.0
    floor *= noise_density(np.linspace(0.0, np.pi, len(power)), noise)
    lowest = min(OCTAVES, int(np.log2(max(len(power) / LEAST_FREQUENCIES, 1.0))))
    edges = 0.5 / step * 2.0 ** np.arange(-lowest, 1.0)
    starts = np.append(0, np.ceil(len(power) * 2.0 ** np.arange(-lowest, 0.0)).astype(int))
    sums, floors = np.add.reduceat(power, starts), np.add.reduceat(floor, starts)
    counts = np.diff(np.append(starts, len(power)))
    total = float(np.sum(sums)) or 1.0
    lower = np.append(0.0, edges[:-1])
    return [
        _Unjudged(
            Bin(
                by="frequency",
                bin=f"{lower[index]:.3g} to {edges[index]:.3g} Hz",
                lower=float(lower[index]),
                upper=float(edges[index]),
                count=int(counts[index]),
                rmse=float(np.sqrt(sums[index])),
                bias=float(np.mean(residual)) if index == 0 else 0.0,
                share=float(sums[index]) / total,
                significance=None,
                stands_out=False,
            ),
            ratio=float(sums[index] / floors[index]),
            freedom=2.0 * float(counts[index]),
        )
        for index in range(len(sums))
    ]


def noise_density(angle: Array, noise: NoiseFloor) -> Array:
    """Spectral density of noise of variance 1; its mean over all angles is 1.

    Parameters
    ----------
    angle : (k,) array, rad a sample, 0 to π
    noise : NoiseFloor; coloured noise is taken as first-order autoregressive
    """
    rho = noise.correlation
    return np.asarray((1.0 - rho**2) / (1.0 - 2.0 * rho * np.cos(angle) + rho**2))


def _judged(found: list[_Unjudged], floor_error: float) -> tuple[Bin, ...]:
    """Say of each bin how far it lies above the noise; Holm's correction over all of them."""
    from scipy.stats import f

    judged = [index for index, one in enumerate(found) if one.freedom >= MINIMUM_FREEDOM]
    ratio = np.array([found[index].ratio for index in judged])
    freedom = np.array([found[index].freedom for index in judged])
    significance = (ratio - 1.0) / np.sqrt(2.0 / freedom + floor_error**2)
    chance = f.sf(ratio, freedom, 2.0 / floor_error**2)
    order = np.argsort(chance)
    small = chance[order] < RISK / np.arange(len(order), 0, -1)
    out = set(order[: len(order) if small.all() else int(np.argmin(small))].tolist())
    bins = [one.bin for one in found]
    for place, index in enumerate(judged):
        bins[index] = replace(
            bins[index], significance=float(significance[place]), stands_out=place in out
        )
    return tuple(bins)
