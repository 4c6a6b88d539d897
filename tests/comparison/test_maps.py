"""Means over cells are those of the samples in them."""

import numpy as np
import pytest

from elastic_tendon.comparison.maps import CELLS, MINIMUM_COUNT, mean_by_cell, samples_in_cell


def test_cells_hold_the_mean_of_their_samples() -> None:
    rng = np.random.default_rng(11)
    across, up = rng.uniform(0.0, 1.0, (2, 50_000))
    found = mean_by_cell(across, up, 3.0 * across - up)
    assert found.values.shape == (CELLS, CELLS)
    middle_across = (found.horizontal[:-1] + found.horizontal[1:]) / 2.0
    middle_up = (found.vertical[:-1] + found.vertical[1:]) / 2.0
    expected = 3.0 * middle_across[None, :] - middle_up[:, None]
    assert found.values == pytest.approx(expected, abs=0.05)


def test_cells_with_few_samples_are_blank() -> None:
    corner = np.zeros(MINIMUM_COUNT - 1)
    across = np.concatenate([corner, np.ones(100)])
    found = mean_by_cell(across, across, across)
    assert np.isnan(found.values[0, 0])
    assert found.values[-1, -1] == 1.0
    assert np.count_nonzero(np.isfinite(found.values)) == 1


def test_there_is_no_map_over_what_never_changes() -> None:
    across = np.linspace(0.0, 1.0, 100)
    assert mean_by_cell(across, np.full(100, 2.0), across) is None


def test_a_cell_knows_its_samples() -> None:
    rng = np.random.default_rng(12)
    across, up, values = rng.uniform(0.0, 1.0, (3, 20_000))
    found = mean_by_cell(across, up, values)
    for column, row in ((0, 0), (CELLS - 1, CELLS - 1), (7, 15)):
        inside = samples_in_cell(across, up, column, row)
        assert np.mean(values[inside]) == pytest.approx(found.values[row, column], rel=1e-12)
        assert np.all(across[inside] >= found.horizontal[column])
        assert np.all(up[inside] <= found.vertical[row + 1])


def test_every_sample_lies_in_one_cell() -> None:
    rng = np.random.default_rng(13)
    across, up = np.round(rng.uniform(-1.0, 1.0, (2, 5_000)), 1)  # many upon the edges
    times = sum(
        samples_in_cell(across, up, column, row).astype(int)
        for column in range(CELLS)
        for row in range(CELLS)
    )
    assert np.all(times == 1)
