"""Samples of a recording sorted by what the joint was doing, and by blocks of time."""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from elastic_tendon.actuator.parameters import Model
from elastic_tendon.actuator.transmission import SlackState, slack_boundaries
from elastic_tendon.comparison.residuals import Array, autocorrelation_time

Integers = NDArray[np.int_]

PARTS = 8  # of the range of a variable
STRETCHES = 10  # of the recording
# a bin that holds less than this share of all samples, or fewer than so many, joins its neighbour
SCARCE, FEW = 0.01, 10
# slower than this share of the largest speed counts as rest, or than so many standard deviations
# of the velocity's noise, but up to another share of the largest speed only
REST_SHARE, NOISY_REST, MOST_REST = 0.01, 3.0, 0.1
# of the range of a motion; what goes back by less has not turned
TURN = 0.01
# more blocks than these cost time and say no more
MOST_BLOCKS = 2000
# long enough for every memory of an actuator at common rates
MEMORY_STRETCH, MEMORY_STRETCHES = 16384, 4
UNITS = {
    "deflection": "rad",
    "joint_velocity": "rad/s",
    "joint_acceleration": "rad/s²",
    "joint_position": "rad",
    "motor_position": "rad",
    "load_torque": "N·m",
    "time": "s",
}
# what a slow sweep has too little of to be split by; its time is the number of its row, and as the
# motor is held, its deflection is the joint's position
NOT_STATIC = ("joint_velocity", "joint_acceleration", "joint_position", "time")
MOST_DIGITS = 12  # of a label


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
    """Samples, or blocks of them, sorted into k bins of one variable.

    `member` (n,), the bin of each; `counts` (k,) of samples; `words` of each bin; `edges` (k + 1,)
    where the variable is a quantity of `unit`; `sizes` (n,), the samples in each block, None where
    these are single samples.
    """

    by: str
    member: Integers
    counts: Integers
    words: tuple[str, ...]
    edges: Array | None = None
    unit: str | None = None
    sizes: Integers | None = None

    def means(self, values: Array) -> Array:
        """Mean in each bin, (k,), over all samples; (n,) values, of blocks their means."""
        weighted = values if self.sizes is None else values * self.sizes
        return np.bincount(self.member, weighted, len(self.counts)) / self.counts

    def by_block(self, values: Array, blocks: Integers) -> Sums:
        """Sums of (n,) values over bins and blocks, `blocks` (n,) from `blocks_of`."""
        shape = (len(self.counts), int(blocks[-1]) + 1)
        cell = self.member * shape[1] + blocks
        size = shape[0] * shape[1]
        total = np.bincount(cell, values, size).reshape(shape)
        count = np.bincount(cell, minlength=size).reshape(shape)
        return Sums(np.asarray(total, dtype=np.float64), count.astype(np.float64))


def memory_of(values: Array) -> float:
    """Autocorrelation time, samples; of a long series that of some stretches of it.

    Parameters
    ----------
    values : (n,) array, any unit
    """
    if len(values) <= MEMORY_STRETCHES * MEMORY_STRETCH:
        return autocorrelation_time(values)
    starts = np.linspace(0, len(values) - MEMORY_STRETCH, MEMORY_STRETCHES).astype(int)
    stretches = [values[start : start + MEMORY_STRETCH] for start in starts]
    return float(np.mean([autocorrelation_time(stretch) for stretch in stretches]))


def blocks_of(correlation_time: float, n: int) -> Integers:
    """Number of the block of each of n samples; blocks are twice as long as the samples' memory.

    Parameters
    ----------
    correlation_time : float, samples, see `residuals.autocorrelation_time`
    n : int
    """
    length = int(np.ceil(max(2.0 * correlation_time, n / MOST_BLOCKS)))
    return np.arange(n) // length


def last_way(position: Array) -> Array:
    """Direction of the last motion that was long enough, kept at rest; 0 before the first.

    What is moved with play by the joint follows only where the joint goes on or has turned.

    Parameters
    ----------
    position : (n,) array, any unit

    Returns
    -------
    (n,) array of -1, 0 and 1
    """
    play = 0.5 * TURN * float(np.ptp(position))
    follower, way, ways = float(position[0]), 0.0, []
    for value in position.tolist():
        pulled = max(value - play, min(value + play, follower))
        if pulled != follower:
            way = 1.0 if pulled > follower else -1.0
        follower = pulled
        ways.append(way)
    return np.array(ways)


def partitions(
    variables: Mapping[str, Array],
    model: Model,
    velocity_noise: float,
    *,
    static: bool,
    sizes: Integers | None = None,
) -> dict[str, Partition]:
    """Sort the samples of a recording by each of its variables.

    Parameters
    ----------
    variables : as in `locate.FileLocation`
    model : Model; its slack boundaries are edges of the bins of the deflection
    velocity_noise : float, rad/s, standard deviation of what noise adds to the joint's velocity
    static : whether the recording is a slow sweep, whose speed and time mean nothing
    sizes : (n,) samples in each block, where the variables are those of blocks

    Returns
    -------
    dict, name of a variable -> Partition; a variable that does not change is left out
    """
    springs = model.kind.has_springs
    partitions = [_slack_states(variables["slack_state"], sizes)] if springs else []
    boundaries = slack_boundaries(model.transmission)
    for by in UNITS:
        if (static and by in NOT_STATIC) or (by == "deflection" and not springs):
            continue
        values = variables[by]
        if np.ptp(values) > 1e-9 * np.max(np.abs(values)):
            inner = boundaries if by == "deflection" else ()
            parts = STRETCHES if by == "time" else PARTS
            unit = model.motion.words(UNITS[by])
            partitions.append(_parts(by, unit, values, parts, inner, sizes))
    partitions.append(_directions(variables["joint_velocity"], velocity_noise, sizes))
    return {partition.by: partition for partition in partitions if len(partition.counts)}


def _slack_states(states: Array, sizes: Integers | None) -> Partition:
    numbers = [int(state) for state in SlackState]
    words = [SlackState(number).label for number in numbers]
    return _named("slack_state", states.astype(np.intp) - numbers[0], words, sizes)


def _directions(velocity: Array, noise: float, sizes: Integers | None) -> Partition:
    fastest = float(np.max(np.abs(velocity)))
    rest = max(REST_SHARE * fastest, min(NOISY_REST * noise, MOST_REST * fastest))
    sign = 1 + (velocity > rest).astype(np.intp) - (velocity < -rest)
    return _named("velocity_sign", sign, ["negative", "at rest", "positive"], sizes)


def _named(by: str, number: Integers, words: list[str], sizes: Integers | None) -> Partition:
    """Bins with names; those without samples are left out."""
    counts = _counts(number, len(words), sizes)
    kept = np.flatnonzero(counts)
    place = np.zeros(len(words), dtype=np.intp)
    place[kept] = np.arange(len(kept))
    kept_words = tuple(words[i] for i in kept)
    return Partition(by, place[number], counts[kept], kept_words, sizes=sizes)


def _counts(number: Integers, bins: int, sizes: Integers | None) -> Integers:
    return np.bincount(number, sizes, bins).astype(np.intp)


def range_text(lower: float, upper: float, between: str = " to ") -> str:
    """Two numbers of one quantity, with three digits or as many as distinguish them."""
    for digits in range(3, MOST_DIGITS + 1):
        texts = f"{lower:.{digits}g}", f"{upper:.{digits}g}"
        # a rounded width must still be the width
        width = float(texts[1]) - float(texts[0])
        if abs(width - (upper - lower)) <= 0.1 * abs(upper - lower):
            break
    return between.join(texts)


def _parts(
    by: str,
    unit: str,
    values: Array,
    parts: int,
    inner: tuple[float, ...],
    sizes: Integers | None,
) -> Partition:
    """Equal parts of the range; edges next to `inner` move there, scarce ends join neighbours."""
    lowest, highest = float(np.min(values)), float(np.max(values))
    edges = np.linspace(lowest, highest, parts + 1)
    for boundary in inner:
        if lowest < boundary < highest:
            edges[1 + int(np.argmin(np.abs(edges[1:-1] - boundary)))] = boundary
    member = np.searchsorted(edges[1:-1], values, side="right")
    counts = _counts(member, parts, sizes)
    kept = _joined(counts, max(SCARCE * float(np.sum(counts)), FEW))
    edges = edges[np.append(kept, parts)]
    edges[0] = lowest
    joined = np.add.reduceat(counts, kept)
    number = np.searchsorted(kept, np.arange(parts), side="right") - 1
    member = np.maximum(number, 0)[member]
    words = tuple(f"{range_text(a, b)} {unit}" for a, b in pairwise(edges.tolist()))
    return Partition(by, member, joined, words, edges, unit, sizes)


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
