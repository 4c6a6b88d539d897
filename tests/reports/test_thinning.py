"""What is left out of a long curve cannot be seen."""

from collections.abc import Callable

import numpy as np
import pytest
from scipy.spatial import KDTree

from elastic_tendon.reports.thinning import BUCKETS, POINTS, Array, envelope, path, some


def test_short_curves_stay_as_they_are() -> None:
    time = np.linspace(0.0, 1.0, 4 * BUCKETS)
    across, values = envelope(time, time**2)
    assert across is time
    assert np.array_equal(values, time**2)


def test_long_curves_keep_ends_peaks_and_order() -> None:
    time = np.arange(1_000_003.0)
    values = np.sin(1e-4 * time)
    values[777_777], values[3] = 5.0, -7.0
    across, kept = envelope(time, values)
    assert len(kept) <= 2 * BUCKETS + 2
    assert (kept.max(), kept.min()) == (5.0, -7.0)
    assert (across[0], across[-1]) == (time[0], time[-1])
    assert np.all(np.diff(across) > 0.0)
    assert np.array_equal(kept, values[across.astype(int)])


def test_clouds_keep_at_most_so_many_points() -> None:
    for n in (1, POINTS, POINTS + 1, 10**6):
        assert len(set(some(n).tolist())) == min(n, POINTS)


def test_a_cloud_does_not_fall_in_step_with_a_motion() -> None:
    n = 50 * POINTS
    phases = some(n) % 50
    assert np.bincount(phases, minlength=50).min() > 0.5 * POINTS / 50


def _series(n: int) -> tuple[Array, Array]:
    time = np.linspace(0.0, 20.0, n)
    return time, np.sin(3.0 * time) + 0.3 * np.sign(np.sin(40.0 * time))


def _loop(n: int) -> tuple[Array, Array]:
    """A hysteresis loop of slowly growing size, run through some hundred times."""
    phase = np.linspace(0.0, 600.0, n)
    size = 1.0 + 1e-4 * phase
    across = size * np.sin(phase)
    return across, across**3 + 0.2 * np.tanh(8.0 * np.cos(phase))


def _strikes(n: int) -> tuple[Array, Array]:
    """Few samples far out: what a stride would step over."""
    phase = np.linspace(0.0, 60.0, n)
    across, up = np.sin(phase), np.cos(phase)
    up[:: n // 7] += 3.0
    return across, up


def _noisy(curve: tuple[Array, Array]) -> tuple[Array, Array]:
    random = np.random.default_rng(1)
    across, up = curve
    return across, up + 0.01 * random.standard_normal(len(up))


def _dense(across: Array, up: Array) -> Array:
    """Places along a curve of pixels, a fifth of one apart; a NaN interrupts it."""
    ends = np.stack([across, up], axis=1)
    steps = np.diff(ends, axis=0)
    drawn = np.isfinite(steps).all(axis=1)
    ends, steps = ends[:-1][drawn], steps[drawn]
    assert np.isfinite(ends).all()
    counts = np.ceil(5.0 * np.hypot(*steps.T)).astype(int) + 1
    which = np.repeat(np.arange(len(counts)), counts)
    share = (np.arange(len(which)) - np.repeat(np.cumsum(counts) - counts, counts)) / counts[which]
    return np.asarray(ends[which] + share[:, None] * steps[which])


def _apart(full: tuple[Array, Array], drawn: tuple[Array, Array], pixels: float) -> float:
    """Largest distance of either curve from the other, in pixels."""
    extents = [pixels / float(np.ptp(values)) for values in full]
    curves = [_dense(across * extents[0], up * extents[1]) for across, up in (full, drawn)]
    there, back = (KDTree(curve).query(places)[0].max() for curve, places in (curves, curves[::-1]))
    return float(max(there, back))


@pytest.mark.parametrize(
    "full",
    [_loop(60_000), _noisy(_loop(60_000)), _strikes(60_000), _series(60_000)],
    ids=["loop", "noisy loop", "strikes", "series"],
)
def test_no_place_of_a_path_is_a_pixel_and_a_half_from_what_is_drawn(
    full: tuple[Array, Array],
) -> None:
    assert _apart(full, path(*full), 1000.0) < 1.5


@pytest.mark.parametrize("n", [1_000, 60_000])
def test_a_path_is_drawn_where_it_is_asked_for(n: int) -> None:
    full, drawn = _strikes(n), np.arange(n) < n // 2
    half = full[0][drawn], full[1][drawn]
    assert _apart(half, path(*full, drawn=drawn), 1000.0) < 1.5


@pytest.mark.parametrize("full", [_series(90_000), _noisy(_series(90_000))], ids=["plain", "noisy"])
def test_no_place_of_a_series_is_a_pixel_and_a_half_from_what_is_drawn(
    full: tuple[Array, Array],
) -> None:
    assert _apart(full, envelope(*full), 1000.0) < 1.5


@pytest.mark.parametrize("loop", [_loop, lambda n: _noisy(_loop(n))], ids=["plain", "noisy"])
def test_a_path_does_not_grow_with_its_samples(loop: Callable[[int], tuple[Array, Array]]) -> None:
    assert len(path(*loop(1_000_000))[0]) < 100_000


def test_what_never_moves_is_still_drawn() -> None:
    across, up = path(np.full(10_000, 2.0), np.full(10_000, 3.0))
    assert (across[0], up[0]) == (2.0, 3.0)
