"""Signals on clocks of their own: cut apart at gaps and brought to one clock.

A finer signal is averaged over the steps of the clock it is brought to, a coarser one interpolated
linearly. Both are one rule: the samples within each step give their mean time and mean value, and
between these the signal is linear.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from math import ceil, floor

import numpy as np
from numpy.typing import NDArray

from elastic_tendon.measurement.noise import is_even

Array = NDArray[np.float64]
Tracks = Mapping[str, "Track"]
Span = tuple[float, float]  # s

# a step so many times as long as nine in ten others is a gap
_GAP = 10.0
# and so is one that misses a sample or more, if an input bends in it so many times as far
_MISSING, _BENT = 2.5, 5.0
_USUAL = 0.9
_INPUTS = ("motor_position", "motor_torque", "load_torque")
# grid points that the common time misses by rounding only
_ROUNDING = 1e-6
# how far from an even clock, in steps of the rounding, stamps lie that were only rounded
_ROUNDED = 0.6


@dataclass(frozen=True)
class Track:
    """One signal: `time` (n,) s, strictly increasing, and `values` (n,) at these times."""

    time: Array
    values: Array

    def converted(self, factor: float, offset: float) -> "Track":
        """The same signal in another unit."""
        if (factor, offset) == (1.0, 0.0):
            return self
        return Track(self.time, self.values * factor + offset)


@dataclass(frozen=True)
class Bins:
    """Sums over the samples in each step: `index` (k,) of the step, `count` (k,), sum of the
    `times` from the step's middle (k,), sum of the `values` (k,).
    """

    index: NDArray[np.int64]
    count: Array
    times: Array
    values: Array

    @classmethod
    def of(cls, time: Array, values: Array, step: float) -> "Bins":
        """Sums over steps whose middles are whole multiples of `step`."""
        index = np.floor(time / step + 0.5).astype(np.int64)
        return cls(index, np.ones(len(index)), time - index * step, values).joined()

    def joined(self) -> "Bins":
        """Entries of one step added up; `index` must not decrease."""
        if not len(self.index):
            return self
        starts = np.flatnonzero(np.diff(self.index, prepend=self.index[0] - 1))
        sums = (
            np.add.reduceat(entries, starts) for entries in (self.count, self.times, self.values)
        )
        return Bins(self.index[starts], *sums)


def reduced(bins: Sequence[Bins], step: float) -> Track:
    """Mean time and mean value of each step, over all chunks."""
    joined = Bins(
        np.concatenate([part.index for part in bins]),
        np.concatenate([part.count for part in bins]),
        np.concatenate([part.times for part in bins]),
        np.concatenate([part.values for part in bins]),
    ).joined()
    time = joined.index * step + joined.times / joined.count
    return Track(time, joined.values / joined.count)


def between(tracks: Tracks, lower: float, upper: float) -> Tracks:
    """Samples with ``lower <= time <= upper``; signals that share a clock go on sharing it."""
    clocks: dict[int, tuple[slice, Array]] = {}
    for track in tracks.values():
        if id(track.time) not in clocks:
            first, last = np.searchsorted(track.time, [lower, np.nextafter(upper, np.inf)])
            clocks[id(track.time)] = slice(first, last), track.time[first:last]
    return {
        name: Track(clocks[id(track.time)][1], track.values[clocks[id(track.time)][0]])
        for name, track in tracks.items()
    }


def common_time(tracks: Tracks) -> tuple[float, float]:
    """First and last time at which every signal is known, s; none where the first is later."""
    if not all(len(track.time) for track in tracks.values()):
        return np.inf, -np.inf
    clocks = [track.time for track in tracks.values()]
    return max(float(clock[0]) for clock in clocks), min(float(clock[-1]) for clock in clocks)


def pieces(
    tracks: Tracks, step: float | None, lost: Collection[Span] = ()
) -> list[tuple[Tracks, Span | None]]:
    """Cut signals apart where one of them has a gap: a step far longer than usual, or one in which
    samples are missing while an input bends, so that nobody knows how it ran.

    Parameters
    ----------
    tracks : at least one
    step : s, where they were averaged over steps of this length; they are cut between steps
    lost : steps (s, s) from which samples were left out that the file holds

    Returns
    -------
    list of the signals and the window that cuts them out, None where nothing was cut; no piece
    has a gap by its own steps, so that a piece read alone stays whole
    """
    gaps = _gaps(tracks)
    if not gaps:
        return [(tracks, None)]
    # nothing of what was left out is in a window
    cuts = [gap if gap in lost else _cut(gap, step) for gap in gaps]
    starts, ends = zip(*cuts, strict=True)
    parts: list[tuple[Tracks, Span | None]] = []
    for lower, upper in zip((-np.inf, *ends), (*starts, np.inf), strict=True):
        part = between(tracks, lower, upper)
        if all(len(track.time) for track in part.values()):
            for inner, window in pieces(part, step, lost):
                low, high = window or (-np.inf, np.inf)
                parts.append((inner, (max(lower, low), min(upper, high))))
        else:
            parts.append((part, (lower, upper)))
    return parts


def _cut(gap: Span, step: float | None) -> Span:
    """End of what is before and beginning of what is after the middle of a gap, s; between two
    steps where signals were averaged over steps."""
    middle = 0.5 * (gap[0] + gap[1])
    if step is not None:
        middle = (floor(middle / step) + 0.5) * step
    return float(np.nextafter(middle, -np.inf)), middle


def _gaps(tracks: Tracks) -> list[Span]:
    """Beginning and end of the gaps within the common time, s, in order."""
    first, last = common_time(tracks)
    found: set[Span] = set()
    for clock in {id(track.time): track.time for track in tracks.values()}.values():
        steps = np.diff(clock)
        # no gap without a step so many times the shortest, which is found faster than a quantile
        if len(steps) and steps.max() > _MISSING * steps.min():
            inputs = [tracks[name].values for name in _INPUTS if _has_clock(tracks, name, clock)]
            long = _long_steps(steps, inputs)
            within = long[(clock[long + 1] > first) & (clock[long] < last)]
            found |= {(float(clock[i]), float(clock[i + 1])) for i in within}
    return sorted(found)


def _has_clock(tracks: Tracks, name: str, clock: Array) -> bool:
    return name in tracks and tracks[name].time is clock


def _long_steps(steps: Array, inputs: Sequence[Array]) -> NDArray[np.intp]:
    """Which steps of a clock (n,) are gaps, where these inputs (n + 1,) have it."""
    lengths = steps / np.quantile(steps, _USUAL)
    gaps = lengths > _GAP
    missing = lengths > _MISSING
    if np.any(missing & ~gaps):
        for values in inputs:
            bends = _bends(steps, values)
            gaps |= missing & (bends > _BENT * np.quantile(bends, _USUAL))
    return np.flatnonzero(gaps)


def _bends(steps: Array, values: Array) -> Array:
    """How far in each step the curve with the speeds before and after it is from a line."""
    bends = np.zeros(len(steps))
    speeds = (values[2:] - values[:-2]) / (steps[1:] + steps[:-1])
    # a parabola is an eighth of its length times the change of its slope from its chord
    bends[2:-2] = steps[2:-2] * np.abs(speeds[3:] - speeds[:-3]) / 8.0
    return bends


def on_one_clock(
    tracks: Tracks, reference: str, step: float | None
) -> tuple[Array, dict[str, Array]]:
    """Bring signals to one clock over the time that they have in common.

    Parameters
    ----------
    tracks : at least one; after `reduced` where `step` is given
    reference : the signal whose clock counts
    step : s; the clock is its whole multiples instead

    Returns
    -------
    time (n,) s, and the values of each signal (n,)
    """
    if step is None and len({id(track.time) for track in tracks.values()}) == 1:
        return tracks[reference].time, {name: track.values for name, track in tracks.items()}
    first, last = common_time(tracks)
    if step is None:
        tracks = _stepwise(tracks, tracks[reference].time)
        time = between({reference: tracks[reference]}, first, last)[reference].time
    else:
        lowest, highest = ceil(first / step - _ROUNDING), floor(last / step + _ROUNDING)
        time = np.arange(lowest, highest + 1, dtype=np.float64) * step
    return time, {name: np.interp(time, track.time, track.values) for name, track in tracks.items()}


def evenly(time: Array) -> Array:
    """Times (n,) of samples that were taken evenly, where stamps were only rounded; else the same.

    Then the steps have two lengths, one rounding apart, and no stamp is further than half of that
    from an even clock.
    """
    steps = np.diff(time)
    short, long = float(steps.min()), float(steps.max())
    rounding = long - short
    between = np.minimum(steps - short, long - steps)
    if is_even(time) or float(between.max()) > _ROUNDING * long:
        return time
    number = np.arange(len(time), dtype=np.float64)
    even = np.polynomial.Polynomial.fit(number, time, 1)(number)
    return even if np.max(np.abs(time - even)) < _ROUNDED * rounding else time


def _stepwise(tracks: Tracks, clock: Array) -> Tracks:
    """Signals with other clocks, averaged over the steps of this one."""
    middles = 0.5 * (clock[1:] + clock[:-1])
    # the first and the last step reach as far to the other side
    edges = np.concatenate(
        [[2.0 * clock[0] - middles[0]], middles, [2.0 * clock[-1] - middles[-1]]]
    )
    return {
        name: track if track.time is clock else _averaged(track, edges)
        for name, track in tracks.items()
    }


def _averaged(track: Track, edges: Array) -> Track:
    """Mean time and value between each two edges; samples beyond the edges stay as they are."""
    index = np.searchsorted(edges, track.time, side="right").astype(np.int64)
    before, after = np.count_nonzero(index == 0), np.count_nonzero(index == len(edges))
    index[:before] = np.arange(-before, 0)
    index[len(index) - after :] += np.arange(after)
    start = track.time[0]
    bins = Bins(index, np.ones(len(index)), track.time - start, track.values).joined()
    time, values = start + bins.times / bins.count, bins.values / bins.count
    # half a step at an end has its mean within, so its outermost sample says how it begins
    ends = [(0, time[0] > track.time[0]), (len(time), time[-1] < track.time[-1])]
    for place, short in reversed(ends):
        if short:
            outermost = 0 if place == 0 else -1
            time = np.insert(time, place, track.time[outermost])
            values = np.insert(values, place, track.values[outermost])
    return Track(time, values)
