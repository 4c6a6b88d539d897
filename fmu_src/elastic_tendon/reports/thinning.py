"""Fewer points for a long curve, none of which anybody would miss on paper."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Places = NDArray[np.float32]  # pixels

BUCKETS = 1500  # more than a figure has pixels across
PIXELS = 1200  # more than a loop has across and up
SHORT = 2000  # samples of a path that is drawn as it is
MOVES = 5000  # that are judged at once: what is made of them stays near the processor
POINTS = 20_000
STRETCHES = 400  # of chosen samples; more are distinguished by zooming in


def envelope(horizontal: Array, values: Array, buckets: int = BUCKETS) -> tuple[Array, Array]:
    """Smallest and largest value of each of so many stretches, in the order of the curve.

    Parameters
    ----------
    horizontal, values : (n,) arrays, any unit
    buckets : number of stretches, positive

    Returns
    -------
    two (m,) arrays; the given ones where they are short
    """
    length = -(-len(values) // buckets)
    if length <= 4:
        return horizontal, values
    starts = np.arange(0, len(values), length)
    whole = len(values) // length * length
    stretches = values[:whole].reshape(-1, length)
    extremes = np.stack([stretches.argmin(axis=1), stretches.argmax(axis=1)], axis=1)
    chosen = np.sort(starts[: len(stretches), None] + extremes, axis=1).ravel()
    kept = np.unique(np.concatenate([[0], chosen, [len(values) - 1]]))
    return horizontal[kept], values[kept]


def path(
    horizontal: Array,
    vertical: Array,
    pixels: int = PIXELS,
    drawn: NDArray[np.bool_] | None = None,
) -> tuple[Array, Array]:
    """A curve that may turn back, as loops do: its moves that come to a pixel for the first time.

    All that is left out lies in pixels that a drawn move touches, so less than a pixel and a half
    from the drawing.

    Parameters
    ----------
    horizontal, vertical : (n,) arrays, any unit
    pixels : across the extent of each, positive
    drawn : (n,), samples between which the line runs; all where it is None

    Returns
    -------
    two (m,) arrays with NaN where the line is interrupted; the given ones where they are short
    """
    if drawn is None:
        drawn = np.ones(len(horizontal), dtype=np.bool_)
    if len(horizontal) <= SHORT:
        return np.where(drawn, horizontal, np.nan), np.where(drawn, vertical, np.nan)
    places = _scaled(horizontal, pixels), _scaled(vertical, pixels)
    moves = _moves_to_new_pixels(*places, pixels, drawn[1:] & drawn[:-1])
    kept = np.stack([moves, moves + 1], axis=1)
    pixel = np.floor(np.stack([values[kept] for values in places], axis=-1))
    apart = 1 + np.flatnonzero((pixel[:-1, 1] != pixel[1:, 0]).any(axis=1))
    samples = np.insert(kept.ravel(), 2 * apart, -1)  # a gap; within a pixel the line goes on
    samples = samples[np.diff(samples, prepend=-1) != 0]
    across, up = (
        np.where(samples < 0, np.nan, values[samples]) for values in (horizontal, vertical)
    )
    return across, up


def _scaled(values: Array, pixels: int) -> Places:
    extent = float(np.ptp(values)) or 1.0
    return np.asarray((values - values.min()) * (pixels / extent), np.float32)


def _moves_to_new_pixels(
    across: Places, up: Places, pixels: int, drawn: NDArray[np.bool_]
) -> NDArray[np.intp]:
    """Indices of the samples from which a move to the next touches a pixel that none before did;
    `drawn` (n - 1,) are the moves that count.
    """
    touched = np.zeros((pixels + 1) ** 2, dtype=np.bool_)
    kept = []
    for start in range(0, len(across) - 1, MOVES):
        ends = [values[start : start + MOVES + 1] for values in (across, up)]
        steps = [np.diff(values) for values in ends]
        # half a pixel apart, along the longer side
        counts = (2.0 * np.maximum(*map(np.abs, steps))).astype(np.int32) + 1
        counts *= drawn[start : start + MOVES]
        move = np.repeat(np.arange(len(counts), dtype=np.int32), counts)
        first = (np.cumsum(counts) - counts).astype(np.int32)
        share = (np.arange(len(move), dtype=np.int32) - first[move]) / np.float32(counts[move])
        column, row = (
            (values[:-1][move] + share * step[move]).astype(np.int32)
            for values, step in zip(ends, steps, strict=True)
        )
        pixel = column * (pixels + 1) + row
        fresh = np.flatnonzero(~touched[pixel])
        first_to_come = np.unique(pixel[fresh], return_index=True)[1]
        kept.append(start + np.unique(move[fresh[first_to_come]]))
        touched[pixel[fresh]] = True
    return np.concatenate(kept)


def within(time: Array, window: tuple[float, float] | None, beyond: int = 0) -> slice:
    """Samples in a window.

    Parameters
    ----------
    time : (n,) s, rising
    window : start and end, s; None for all
    beyond : samples more at each end: one, and curves reach the edges of the window
    """
    if window is None:
        return slice(None)
    start = int(np.searchsorted(time, window[0], side="left"))
    end = int(np.searchsorted(time, window[1], side="right"))
    return slice(max(start - beyond, 0), end + beyond)


def some(n: int, points: int = POINTS) -> NDArray[np.intp]:
    """At most so many of n samples, drawn by lot; for clouds.

    Samples a fixed number apart would fall in step with a periodic motion. The lot is the same
    each time.
    """
    if n <= points:
        return np.arange(n)
    return np.sort(np.random.default_rng(0).choice(n, points, replace=False))


def stretches(
    time: Array, chosen: NDArray[np.bool_], most: int = STRETCHES
) -> list[tuple[float, float]]:
    """Beginning and end, s, of the stretches of chosen samples; the closest ones are joined.

    Parameters
    ----------
    time : (n,) array, s
    chosen : (n,)
    most : of stretches, positive

    Returns
    -------
    list of at most `most` pairs, in order; a sample reaches half way to its neighbours
    """
    if not chosen.any():
        return []
    change = np.flatnonzero(np.diff(np.concatenate([[False], chosen, [False]]).astype(np.int8)))
    middle = 0.5 * (time[1:] + time[:-1])
    edges = np.concatenate([time[:1], middle, time[-1:]])
    start, end = edges[change[::2]], edges[change[1::2]]
    gaps = start[1:] - end[:-1]
    if len(gaps) >= most:
        # those between stretches that stay apart
        wide = np.sort(np.argsort(gaps)[len(gaps) - most + 1 :])
        start, end = start[np.append(0, wide + 1)], end[np.append(wide, len(end) - 1)]
    return list(zip(start.tolist(), end.tolist(), strict=True))
