"""Whether it matters what the inputs did between their samples."""

from dataclasses import replace

import numpy as np
import pytest

from elastic_tendon import load_model, simulate
from elastic_tendon.measurement.reader import read_measurement
from elastic_tendon.misreadings.sampling import sampling_warnings

MODEL = load_model("biorob_x4_joint_3")


def recording(tmp_path, rate, position, noise=2e-4):
    """The model itself, moved as `position` says over a fine time, recorded at `rate` Hz."""
    fine = np.arange(0.0, 12.0, 1e-3)
    joint = simulate(MODEL, fine, position(fine), interpolation="cubic")["joint_position"]
    kept = slice(None, None, round(1000 / rate))
    rng = np.random.default_rng(5)
    columns = (fine, position(fine), joint + noise * rng.standard_normal(fine.size))
    path = tmp_path / "recording.csv"
    header = "time_s,motor_position_rad,joint_position_rad"
    np.savetxt(path, np.column_stack(columns)[kept], delimiter=",", header=header, comments="")
    return read_measurement(str(path))


def smooth(time):
    return 0.3 * np.sin(12.0 * time) + 0.2 * np.sin(23.0 * time)


def stepping(time):
    return 0.2 * (np.floor(time / 0.5) % 2)


def test_slow_samples_of_a_smooth_motion_are_told(tmp_path):
    slow = replace(recording(tmp_path, 50, smooth), interpolation="linear")
    (told,) = sampling_warnings(MODEL, slow)
    assert "--interpolation cubic" in told
    assert "times the noise" in told
    assert sampling_warnings(MODEL, replace(slow, interpolation="cubic")) == ()


def test_slow_samples_of_steps_are_told(tmp_path):
    (told,) = sampling_warnings(MODEL, recording(tmp_path, 50, stepping))
    assert "--interpolation hold" in told


@pytest.mark.parametrize(("rate", "position"), [(500, smooth), (1000, smooth), (1000, stepping)])
def test_nothing_is_said_of_what_linear_inputs_explain(tmp_path, rate, position):
    assert sampling_warnings(MODEL, recording(tmp_path, rate, position)) == ()
