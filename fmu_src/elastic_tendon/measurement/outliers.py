"""Samples of a position that no joint can have: spikes, and values that stand while it moves on.

A joint and a motor have inertia, so their positions run smoothly from sample to sample. A spike is
far from the curve through the samples on both sides of it, and these lie on that curve; where the
motion itself is rough, by impacts or coarse samples, they do not. Values stand, where samples were
lost and the last one was repeated, if the position then jumps to where it goes on at another pace.
"""

from collections.abc import Iterable, Iterator

import numpy as np
from numpy.typing import NDArray

from elastic_tendon.measurement.noise import quantisation_step
from elastic_tendon.measurement.tracks import Array, Span, Track, Tracks

_POSITIONS = ("joint_position", "joint_deflection", "motor_position")

_LONGEST = 3  # samples of a spike
_SIDE = 4  # samples on each side of it that the curve runs through
_DEGREE = 3  # of the curve
_FAR, _STEPS = 8.0, 4.0  # times the usual distance from neighbours, and steps of the sensor
_BLOCK, _SOME = 64, 3  # samples of a block, of which each third has its part in the usual distance
_ROUGH = 6.0  # times the distance of the neighbours from the curve through them
_STANDS = 5  # samples of one value, at least
_NEAR, _MOVING = 3, 8  # samples before and after that show how fast the position moves
_JUMP = 3.0  # times the changes from sample to sample around it
_STEADY = 0.5  # of the largest change
_CAUGHT_UP = 0.25  # of the mean speed that was missed, with which it moves on
_MOST = 20  # of each kind in a signal: more of them are its nature
_NAMED = 3  # times in a note

Stretch = tuple[int, int]  # first sample, and the first after it


def without_spikes(tracks: Tracks) -> tuple[Tracks, tuple[str, ...]]:
    """Put spikes of positions on the curve through their neighbours.

    Parameters
    ----------
    tracks : at least one

    Returns
    -------
    the signals, and a note for each that had spikes
    """
    smooth, notes = dict(tracks), []
    for name, track in _positions(tracks):
        spikes = _few(_spikes(track, quantisation_step(track.values)))
        if spikes:
            smooth[name] = Track(track.time, _bridged(track, spikes))
            notes.append(_spike_note(name, track.time, spikes))
    return smooth, tuple(notes)


def without_standing(tracks: Tracks) -> tuple[Tracks, tuple[Span, ...], tuple[str, ...]]:
    """Leave out the samples in which a position stands while the joint moves on.

    Parameters
    ----------
    tracks : at least one

    Returns
    -------
    the signals, of which those that share the clock of such a position have none of its samples
    there; the steps of time that this leaves, (s, s) each; and a note for each such position
    """
    keep: dict[int, NDArray[np.bool_]] = {}
    lost, notes = [], []
    for name, track in _positions(tracks):
        stands = _few(_stands(track.values, quantisation_step(track.values)))
        if stands:
            notes.append(_stand_note(name, track.time, stands))
            lost += [(float(track.time[first]), float(track.time[end])) for first, end in stands]
        for first, end in stands:
            kept = keep.setdefault(id(track.time), np.ones(len(track.time), dtype=bool))
            kept[first + 1 : end] = False
    # those that share a clock go on sharing it
    times = {
        id(track.time): track.time[keep[id(track.time)]]
        for track in tracks.values()
        if id(track.time) in keep
    }
    left = {
        name: Track(times[id(track.time)], track.values[keep[id(track.time)]])
        if id(track.time) in keep
        else track
        for name, track in tracks.items()
    }
    return left, tuple(lost), tuple(notes)


def _positions(tracks: Tracks) -> Iterator[tuple[str, Track]]:
    return ((name, tracks[name]) for name in _POSITIONS if name in tracks)


def _few(stretches: Iterable[Stretch]) -> list[Stretch]:
    found = sorted(stretches)
    return found if len(found) <= _MOST else []


def _spikes(track: Track, step: float) -> Iterator[Stretch]:
    """Stretches of at most three samples that are off the curve through their neighbours."""
    time, values = track.time, track.values
    if len(values) <= 2 * _SIDE + _LONGEST:
        return
    apart = _off_neighbours(time, values)
    limits = _FAR * _usual(apart) + _STEPS * step
    # where a spike lasts, its first sample is half as far from the line to the next one
    first = np.flatnonzero(2.0 * apart > limits) + 1
    first = first[(first >= _SIDE) & (first <= len(values) - _LONGEST - _SIDE)]
    for length in range(1, _LONGEST + 1):
        line, rough = _curves(track, first, length)
        apart = np.abs(values[first[:, None] + np.arange(length)] - line).min(axis=1)
        is_spike = apart > np.maximum(limits[first - 1], _ROUGH * (rough + step))
        yield from ((start, start + length) for start in first[is_spike].tolist())


def _off_neighbours(time: Array, values: Array) -> Array:
    """Distance of each sample but the first and the last from the line between its neighbours."""
    share = (time[1:-1] - time[:-2]) / (time[2:] - time[:-2])
    return np.abs(values[1:-1] - values[:-2] - share * (values[2:] - values[:-2]))


def _usual(distances: Array) -> Array:
    """Median around the block that each distance is in, or the one beside it if that is larger."""
    count = len(distances) // _BLOCK
    if count < 2:
        return np.full(len(distances), np.median(distances))
    some = distances[: count * _BLOCK].reshape(count, _BLOCK)[:, ::_SOME]
    medians = np.pad(np.median(some, axis=1), 1, mode="edge")
    largest = np.maximum(medians[1:-1], np.maximum(medians[:-2], medians[2:]))
    return np.pad(np.repeat(largest, _BLOCK), (0, len(distances) - count * _BLOCK), mode="edge")


def _curves(track: Track, first: NDArray[np.intp], length: int) -> tuple[Array, Array]:
    """The curves through four samples on each side of stretches (k,) of this length, at their
    samples, (k, length); and how far the four are from them at most, (k,)."""
    inner = first[:, None] + np.arange(length)
    sides = np.r_[-_SIDE:0, length : length + _SIDE]
    around = first[:, None] + sides
    start, span = track.time[first - _SIDE], np.ptp(track.time[around], axis=1)

    def powers(places: NDArray[np.intp]) -> Array:
        scaled = (track.time[places] - start[:, None]) / span[:, None]
        return np.asarray(scaled[..., None] ** np.arange(_DEGREE + 1))

    fit: Array = np.linalg.pinv(powers(around)) @ track.values[around][..., None]
    apart = np.abs((powers(around) @ fit)[..., 0] - track.values[around])
    line: Array = powers(inner) @ fit
    return line[..., 0], apart.max(axis=1, initial=0.0)


def _bridged(track: Track, spikes: list[Stretch]) -> Array:
    values = track.values.copy()
    for first, end in spikes:
        values[first:end] = _curves(track, np.array([first]), end - first)[0][0]
    return values


def _stands(values: Array, step: float) -> list[Stretch]:
    """Stretches of one value, the first of which was measured, that end in a jump; none where
    there are such jumps without them, as of a joint that sticks and slips."""
    changes = np.diff(values)
    jumps = _jumps(changes, step)
    # the first of the samples that are alike up to each change
    moved = np.append(0, np.flatnonzero(changes) + 1)
    starts = moved[np.searchsorted(moved, jumps, side="right") - 1]
    stands = jumps - starts + 1 >= _STANDS
    for which in np.flatnonzero(stands):
        stands[which] = _is_between_moves(changes, starts[which], jumps[which], step)
    sizes = np.abs(changes[jumps])
    if not stands.any() or np.any(sizes[~stands] >= np.median(sizes[stands]) / _JUMP):
        return []
    return list(zip(starts[stands].tolist(), (jumps[stands] + 1).tolist(), strict=True))


def _jumps(changes: Array, step: float) -> NDArray[np.intp]:
    """Changes that are larger by far than those before and after."""
    sizes = np.pad(np.abs(changes), _NEAR)
    inner = sizes[_NEAR:-_NEAR]
    least = np.maximum(_STEPS * step, _JUMP * np.maximum(sizes[2:-4], sizes[4:-2]))
    found = np.flatnonzero(inner > least)
    near = sizes[found[:, None] + np.delete(np.arange(2 * _NEAR + 1), _NEAR)]
    return np.asarray(found[inner[found] > _JUMP * near.max(axis=1, initial=0.0)])


def _is_between_moves(changes: Array, first: int, end: int, step: float) -> bool:
    """Whether a position that stands from one sample to another moves before or after that."""
    speed = _CAUGHT_UP * abs(changes[end]) / (end - first + 1)
    sides = changes[max(first - _MOVING, 0) : first][::-1], changes[end + 1 :][:_MOVING]
    return any(_is_steady(side, speed, step) for side in sides)


def _is_steady(changes: Array, speed: float, step: float) -> bool:
    """Whether the first changes from sample to sample, or the sums of more of them where steps of
    the sensor hide them, are of one sign, about alike, and at least as large as told."""
    if len(changes) < _MOVING:
        return False
    for parts in (changes[:_NEAR].reshape(-1, 1), changes.reshape(2, -1)):
        sizes = np.abs(parts.sum(axis=1))
        one_way = np.all(parts >= 0.0) or np.all(parts <= 0.0)
        least = max(2.0 * step, speed * parts.shape[1], _STEADY * sizes.max())
        if one_way and sizes.min() >= least:
            return True
    return False


def _named(times: Array) -> str:
    more = ", ..." if len(times) > _NAMED else ""
    return ", ".join(f"{time:.6g}" for time in times[:_NAMED]) + f"{more} s"


def _spike_note(name: str, time: Array, spikes: list[Stretch]) -> str:
    times = time[[first for first, _ in spikes]]
    one = len(spikes) == 1
    return (
        f"{name}: {'a spike' if one else f'{len(spikes)} spikes'}, far off the samples before and "
        f"after, at {_named(times)} {'was' if one else 'were'} replaced by a curve through these"
    )


def _stand_note(name: str, time: Array, stands: list[Stretch]) -> str:
    times = time[[first for first, _ in stands]]
    count = sum(end - first - 1 for first, end in stands)
    often = "once" if len(stands) == 1 else f"{len(stands)} times"
    return (
        f"{name} stands {often} while what it measures moves on, as where samples are "
        f"lost, from {_named(times)}; these {count} samples were left out"
    )
