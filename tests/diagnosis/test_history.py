"""What the machine did before, beside what is known of lags, resonances and friction."""

import numpy as np
import pytest

from elastic_tendon.diagnosis.history import DAMPINGS, LAGS, SLIPS, lagging, ringing, slipping

STEP = 0.001  # s
TIME = np.arange(0.0, 4.0, STEP)


def test_what_lags_has_not_yet_reached_a_step() -> None:
    after = TIME - 1.0
    columns = lagging(np.where(after >= 0.0, 2.0, 0.0), TIME, 0.1)
    for index, times in enumerate(LAGS):
        gone = np.maximum(after, 0.0) / (0.1 * times)
        once, twice = -2.0 * np.exp(-gone), -2.0 * (1.0 + gone) * np.exp(-gone)
        for column, exact in zip(columns.T[2 * index :], (once, twice), strict=False):
            later = after > 10.0 * STEP
            # as exact as steps of a tenth of the shortest lag are
            assert column[later] == pytest.approx(exact[later], abs=2.0 * STEP / (0.1 * times))
            assert column[after < -STEP] == pytest.approx(0.0, abs=1e-12)


def test_what_rings_goes_on_after_a_blow_at_its_own_frequency() -> None:
    blow, frequency = np.where(np.arange(len(TIME)) == 100, 1.0, 0.0), 40.0
    columns = ringing(blow, TIME, frequency)
    since = np.maximum(TIME - TIME[100], 0.0)
    for index, ratio in enumerate(DAMPINGS):
        own = np.exp(-ratio * frequency * since)
        phase = frequency * np.sqrt(1.0 - ratio**2) * since
        both = np.column_stack([own * np.sin(phase), own * np.cos(phase)])[101:]
        for column in columns.T[2 * index : 2 * index + 2]:
            weights, *_ = np.linalg.lstsq(both, column[101:], rcond=None)
            assert both @ weights == pytest.approx(column[101:], abs=1e-9)
            assert np.max(np.abs(column)) == pytest.approx(1.0)


def test_times_that_are_not_even_make_no_difference() -> None:
    uneven = np.sort(np.random.default_rng(3).uniform(0.0, 4.0, 4000))
    uneven[[0, -1]] = TIME[[0, -1]]
    for make, scale in ((lagging, 0.1), (ringing, 30.0)):
        even, found = (make(np.sin(3.0 * time), time, scale) for time in (TIME, uneven))
        for column, exact in zip(found.T, even.T, strict=True):
            expected = np.interp(uneven, TIME, exact)
            assert column == pytest.approx(expected, abs=0.02 * np.max(np.abs(exact)))


def test_what_slips_holds_no_more_than_its_share() -> None:
    columns = slipping(np.sin(TIME), 0.5)
    assert np.max(np.abs(columns), axis=0) == pytest.approx(0.5 * np.array(SLIPS))
