"""A measurement shifted in time keeps the noise of what is compared, and says what was done."""

import numpy as np
import pytest

from elastic_tendon.errors import MeasurementError
from elastic_tendon.measurement import Measurement, Preparation
from elastic_tendon.measurement.recording import samples_text


@pytest.fixture
def recording() -> Measurement:
    time = 0.01 * np.arange(200)
    rng = np.random.default_rng(3)
    return Measurement(
        time,
        np.sin(time),
        {
            "joint_position": np.sin(time) + 0.1 * rng.standard_normal(200),
            "joint_torque": np.cos(time),
        },
        time**2,
        name="made",
    )


def test_late_joint_keeps_its_samples(recording: Measurement) -> None:
    shifted = recording.shifted({"joint_position": 0.034})
    kept = recording.signals["joint_position"][4:]
    assert np.array_equal(shifted.signals["joint_position"], kept)
    assert shifted.time == pytest.approx(recording.time[4:] - 0.034)
    assert shifted.motor_position == pytest.approx(np.sin(shifted.time), abs=2e-5)
    assert shifted.signals["joint_torque"] == pytest.approx(np.cos(shifted.time), abs=2e-5)
    assert shifted.load_torque == pytest.approx(shifted.time**2, abs=3e-5)
    assert shifted.preparation.time_shift == {"joint_position": 0.034}


def test_late_load_is_brought_to_the_other_samples(recording: Measurement) -> None:
    shifted = recording.shifted({"load_torque": -0.02})
    assert np.array_equal(shifted.time, recording.time[2:])
    assert np.array_equal(
        shifted.signals["joint_position"], recording.signals["joint_position"][2:]
    )
    assert shifted.load_torque == pytest.approx((shifted.time - 0.02) ** 2, abs=1e-12)


def test_shift_by_nothing_changes_nothing_but_is_recorded(recording: Measurement) -> None:
    shifted = recording.shifted({"joint_position": 0.0})
    assert np.array_equal(shifted.time, recording.time)
    assert shifted.preparation.time_shift == {"joint_position": 0.0}


def test_where_nothing_is_done_the_recording_stays_itself(recording: Measurement) -> None:
    assert recording.shifted({}) is recording
    assert recording.noted(()) is recording
    assert recording.noted(["seen", "heard"]).notes == ("seen", "heard")


def test_shifts_add_up(recording: Measurement) -> None:
    twice = recording.shifted({"load_torque": 0.02}).shifted({"load_torque": 0.01})
    assert twice.preparation.time_shift == {"load_torque": pytest.approx(0.03)}
    assert twice.load_torque == pytest.approx((twice.time + 0.03) ** 2, abs=1e-12)


def test_window_is_part_of_the_preparation(recording: Measurement) -> None:
    cut = recording.window(0.5, None)
    assert cut.name == "made[0.5:]"
    assert cut.preparation.window == (0.5, recording.time[-1])


@pytest.mark.parametrize(
    ("shifts", "fragment"),
    [
        ({"joint_position": 1.95}, "shifted by 1.95 s, signals have 5 samples in common"),
        ({"joint_position": -5.0}, "have 0 samples in common and need 10"),
        ({"motor_torque": 0.1}, "motor_torque was not measured"),
    ],
)
def test_impossible_shift_is_refused(
    recording: Measurement, shifts: dict[str, float], fragment: str
) -> None:
    with pytest.raises(MeasurementError, match=fragment):
        recording.shifted(shifts)


def test_noise_is_that_of_each_signal(recording: Measurement) -> None:
    assert recording.noise.keys() == recording.signals.keys()
    assert recording.noise["joint_position"].sigma == pytest.approx(0.1, rel=0.3)
    assert recording.noise is recording.noise  # found once


def test_recording_made_by_hand_was_not_prepared(recording: Measurement) -> None:
    assert recording.preparation == Preparation()
    assert not recording.static


@pytest.mark.parametrize(("count", "told"), [(0, "0 samples"), (1, "1 sample"), (7, "7 samples")])
def test_samples_are_counted_in_words(count: int, told: str) -> None:
    assert samples_text(count) == told
