"""The contract ``elastic-tendon/comparison/1``."""

import json

import numpy as np

from elastic_tendon.comparison.compare import compare
from elastic_tendon.comparison.comparison_json import comparison_json
from elastic_tendon.comparison.locate import locate
from elastic_tendon.measurement import Measurement

FILE_KEYS = {
    *("name", "source", "notes", "static", "preparation", "initial_state", "missing_torque"),
    "signals",
}
SIGNAL_KEYS = {
    *("rmse", "max_abs", "fit_percent", "bias", "noise_ratio", "count", "noise"),
    *("slack_states", "where", "in_words", "residual_tests"),
}
BIN_KEYS = {
    *("by", "bin", "lower", "upper", "count", "rmse", "bias", "share", "significance"),
    "stands_out",
}
TEST_KEYS = {"with", "more_than_chance", "lags", "beyond", "beyond_by_chance", "strongest"}
CURVE_KEYS = {"by", "unit", "centre", "mean", "low", "high", "count"}


def test_json_is_the_contract(frictionless) -> None:
    known, recording = frictionless
    comparison = compare(known.model, [recording])
    location = locate(comparison)
    content = json.loads(json.dumps(comparison_json(comparison, location), allow_nan=False))
    assert content["schema"] == "elastic-tendon/comparison/1"
    assert content["model"] == known.model.name
    (file,) = content["files"]
    assert set(file) == FILE_KEYS
    assert file["name"] == recording.name
    assert set(file["initial_state"]) == {"joint_position", "joint_velocity"}
    signal = file["signals"]["joint_position"]
    assert set(signal) == SIGNAL_KEYS
    assert all(set(bin_) == BIN_KEYS for bin_ in signal["where"])
    assert signal["in_words"] == location.files[0].in_words["joint_position"]
    tests, found = signal["residual_tests"], location.files[0].correlations["joint_position"]
    assert all(set(test) == TEST_KEYS for test in tests)
    assert [test["with"] for test in tests][:2] == ["itself", "motor_position"]
    for test, correlation in zip(tests, found, strict=True):
        strongest = test["strongest"]
        assert test["more_than_chance"] is bool(correlation.surely_beyond.any())
        beyond = abs(strongest["correlation"] - strongest["expected"]) > strongest["bound"]
        assert beyond is (test["beyond"] > 0)
    curves = file["missing_torque"]["curves"]
    assert all(set(curve) == CURVE_KEYS for curve in curves)
    assert {"deflection", "joint_velocity", "time"} <= {curve["by"] for curve in curves}


def test_numbers_are_finite_or_absent(frictionless) -> None:
    known, recording = frictionless
    still = recording.window(0.0, 0.3)
    nothing = np.zeros(len(still.time))
    flat = Measurement(still.time, nothing, {"joint_position": nothing}, name="flat")
    comparison = compare(known.model, [flat])
    text = json.dumps(comparison_json(comparison, locate(comparison)), allow_nan=False)
    assert json.loads(text)["files"][0]["signals"]["joint_position"]["fit_percent"] is None
