"""What is left out of a long curve cannot be seen."""

import numpy as np

from elastic_tendon.reports.thinning import BUCKETS, POINTS, envelope, some, stride


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
        assert 0 < len(range(n)[stride(n)]) <= POINTS
        assert len(set(some(n).tolist())) == min(n, POINTS)


def test_a_cloud_does_not_fall_in_step_with_a_motion() -> None:
    n = 50 * POINTS
    phases = some(n) % 50
    assert np.bincount(phases, minlength=50).min() > 0.5 * POINTS / 50
