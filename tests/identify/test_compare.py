"""The comparison's figures, its contract, and where the error lies."""

import json

import numpy as np
import pytest

from elastic_tendon.identify.compare import compare
from elastic_tendon.identify.where import where_it_fails

SIGNAL_KEYS = {"rmse", "max_abs", "fit_percent", "bias", "noise_ratio", "noise", "where"}
BIN_KEYS = {"by", "bin", "rmse", "share", "significance"}


def test_true_model_reaches_the_noise(frictionless) -> None:
    known, recording = frictionless
    error = compare(known.model.with_values(known.truth), [recording]).files[0].signals
    assert error["joint_position"].rmse == pytest.approx(known.noise, rel=0.1)
    assert error["joint_position"].noise_ratio == pytest.approx(1.0, abs=0.1)
    assert error["joint_position"].fit_percent > 99.0
    assert abs(error["joint_position"].bias) < 0.2 * known.noise


def test_figures_are_what_their_names_say(frictionless) -> None:
    known, recording = frictionless
    file = compare(known.model, [recording]).files[0]
    error = file.signals["joint_position"]
    measured = recording.signals["joint_position"]
    difference = file.trajectory["joint_position"] - measured
    assert error.rmse == pytest.approx(np.sqrt(np.mean(difference**2)))
    assert error.max_abs == pytest.approx(np.max(np.abs(difference)))
    assert error.bias == pytest.approx(np.mean(difference))
    spread = np.linalg.norm(measured - np.mean(measured))
    assert error.fit_percent == pytest.approx(100 * (1 - np.linalg.norm(difference) / spread))


def test_pooled_error_weighs_by_samples(sticking) -> None:
    known, first, second = sticking
    comparison = compare(known.model, [first, second])
    squares = [
        len(one.measurement.time) * one.signals["joint_position"].rmse ** 2
        for one in comparison.files
    ]
    expected = np.sqrt(sum(squares) / (len(first.time) + len(second.time)))
    assert comparison.rmse()["joint_position"] == pytest.approx(expected)


def test_json_is_the_contract(frictionless) -> None:
    known, recording = frictionless
    content = json.loads(json.dumps(compare(known.model, [recording]).to_json(), allow_nan=False))
    assert content["schema"] == "elastic-tendon/comparison/1"
    (file,) = content["files"]
    assert file["name"] == recording.name
    assert set(file["signals"]) == {"joint_position"}
    signal = file["signals"]["joint_position"]
    assert set(signal) == SIGNAL_KEYS
    assert {one["by"] for one in signal["where"]} == {"slack_state", "velocity_sign", "deflection"}
    assert all(set(one) == BIN_KEYS for one in signal["where"])


def test_shares_of_each_split_add_to_one(sticking) -> None:
    known, recording, _ = sticking
    bins = compare(known.model, [recording]).files[0].signals["joint_position"].where
    for by in ("slack_state", "velocity_sign", "deflection"):
        assert sum(one.share for one in bins if one.by == by) == pytest.approx(1.0)


def test_an_error_in_one_direction_stands_out_there_and_only_there(frictionless) -> None:
    known, recording = frictionless
    model = known.model.with_values(known.truth)
    file = compare(model, [recording]).files[0]
    rng = np.random.default_rng(7)
    velocity = file.trajectory["joint_velocity"]
    error = known.noise * rng.standard_normal(len(velocity)) * np.where(velocity > 0, 5.0, 1.0)
    found = {one.bin: one for one in where_it_fails(error, file.trajectory, known.noise)}
    assert found["positive"].significance > 5.0
    assert found["positive"].share > 0.9
    assert abs(found["negative"].significance) < 3.0


def test_noise_alone_stands_out_nowhere(frictionless) -> None:
    known, recording = frictionless
    bins = (
        compare(known.model.with_values(known.truth), [recording])
        .files[0]
        .signals["joint_position"]
        .where
    )
    assert len(bins) >= 7
    assert all(one.significance is None or one.significance < 4.0 for one in bins)
