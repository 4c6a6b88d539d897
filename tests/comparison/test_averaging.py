"""Blocks of a long recording hold its means, and noise falls as it does in any mean."""

import numpy as np
import pytest

from elastic_tendon.comparison import averaging
from elastic_tendon.comparison.averaging import (
    averaged_file,
    averaged_noise,
    block_means,
    block_sizes,
    spread,
    stride_of,
)
from elastic_tendon.comparison.compare import compare
from elastic_tendon.comparison.locate import locate
from elastic_tendon.comparison.residuals import residuals_of
from elastic_tendon.measurement import NoiseFloor


def test_a_recording_has_no_more_blocks_than_are_analysed() -> None:
    assert stride_of(averaging.LONG) == 1
    assert stride_of(averaging.LONG + 1) == 2
    assert len(block_sizes(10**6 + 1, stride_of(10**6 + 1))) <= averaging.LONG


def test_blocks_hold_means_and_the_last_may_be_short() -> None:
    values = np.array([1.0, 3.0, 5.0, 7.0, 10.0])
    assert block_means(values, 2) == pytest.approx([2.0, 6.0, 10.0])
    assert block_sizes(5, 2).tolist() == [2, 2, 1]
    assert spread(np.array([2.0, 6.0, 10.0]), 2, 5).tolist() == [2.0, 2.0, 6.0, 6.0, 10.0]


@pytest.mark.parametrize("correlation", [0.0, 0.9])
def test_noise_of_means_is_that_of_averaged_noise(correlation: float) -> None:
    rng = np.random.default_rng(61)
    values = rng.standard_normal(200_000)
    for index in range(1, len(values)):
        values[index] *= np.sqrt(1.0 - correlation**2)
        values[index] += correlation * values[index - 1]
    means = block_means(values, 4)
    found = averaged_noise(NoiseFloor(1.0, "coloured", correlation=correlation), 4)
    assert np.std(means) == pytest.approx(found.sigma, rel=0.03)
    neighbours = np.corrcoef(means[1:], means[:-1])[0, 1]
    assert neighbours == pytest.approx(found.correlation, abs=0.02)


def test_the_error_of_a_block_is_the_mean_of_its_errors(sticking) -> None:
    known, recording, _ = sticking
    file = compare(known.model, [recording]).files[0]
    short = averaged_file(file, 3)
    whole = residuals_of(file.trajectory, recording)["joint_position"]
    errors = residuals_of(short.trajectory, short.measurement)["joint_position"]
    assert errors == pytest.approx(block_means(whole, 3), abs=1e-12)
    assert averaged_file(file, 1) is file


def test_a_long_recording_is_told_like_a_short_one(sticking, monkeypatch) -> None:
    known, recording, _ = sticking
    comparison = compare(known.model, [recording])
    whole = locate(comparison).files[0]
    monkeypatch.setattr(averaging, "LONG", len(recording.time) // 2)
    halved = locate(comparison).files[0]
    assert len(halved.missing_torque.torque) == len(recording.time)
    assert all(len(values) == len(recording.time) for values in halved.variables.values())
    counts = [sum(bin_.count for bin_ in halved.bins["joint_position"] if bin_.by == "time")]
    assert counts == [len(recording.time)]
    before, after = (location.in_words["joint_position"][:60] for location in (whole, halved))
    assert before == after
