"""Noise is given in plain text, is taken, and is contradicted where the recording shows another."""

import numpy as np
import pytest
from scipy.signal import butter, filtfilt

from elastic_tendon.errors import MeasurementError
from elastic_tendon.measurement import Measurement, parse_size

TIME = np.arange(5000) / 500.0
MOTION = 0.5 * np.sin(37.0 * TIME) + np.sin(2.0 * TIME)
NOISE = 1e-3  # rad
SIGNAL = "joint_position"


def recording(signal: np.ndarray) -> Measurement:
    return Measurement(TIME, np.sin(TIME), {SIGNAL: signal}, name="made.csv")


@pytest.fixture
def noisy() -> Measurement:
    rng = np.random.default_rng(3)
    return recording(MOTION + NOISE * rng.standard_normal(len(TIME)))


@pytest.mark.parametrize(
    ("text", "signal", "sigma"),
    [
        ("joint_position=0.2mrad", SIGNAL, 2e-4),
        ("joint_position = 0.2 mrad", SIGNAL, 2e-4),
        ("joint_position=2e-4", SIGNAL, 2e-4),
        ("joint_position=1deg", SIGNAL, np.pi / 180.0),
        ("joint_torque=5mNm", "joint_torque", 5e-3),
        ("motor_torque=5 mN·m", "motor_torque", 5e-3),
    ],
)
def test_noise_is_read_in_any_unit(text: str, signal: str, sigma: float) -> None:
    name, size = parse_size(text)
    assert name == signal
    assert size == pytest.approx(sigma)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("elbow=0.2mrad", "elbow is not compared with a model; give that of joint_position"),
        ("motor_position=0.2mrad", "motor_position is not compared"),
        ("joint_position=0.2Nm", "Nm is no unit of angle; joint_position needs one such as rad"),
        ("joint_position=0.2furlong", "furlong is no unit of angle"),
        ("joint_position=0", "positive and finite, not 0"),
        ("joint_position=-0.2mrad", "positive and finite, not -0.0002"),
        ("joint_position=1e999", "positive and finite, not inf"),
        ("joint_position", "write SIGNAL=SIZE"),
        ("joint_position=small", "write SIGNAL=SIZE"),
    ],
)
def test_refusals_are_one_sentence(text: str, says: str) -> None:
    with pytest.raises(MeasurementError, match=says) as refusal:
        parse_size(text)
    assert "\n" not in str(refusal.value)


def test_noise_that_is_given_is_taken(noisy: Measurement) -> None:
    given = noisy.with_noise({SIGNAL: 0.8 * NOISE})
    floor = given.noise[SIGNAL]
    assert (floor.sigma, floor.source, floor.kind) == (0.8 * NOISE, "given", "white")
    assert given.notes == ()  # they agree
    assert noisy.noise[SIGNAL].source == "spectrum"
    assert given.window(1.0, 5.0).noise[SIGNAL].sigma == 0.8 * NOISE


@pytest.mark.parametrize("factor", [0.2, 5.0])
def test_noise_that_the_recording_contradicts_is_told(noisy: Measurement, factor: float) -> None:
    given = noisy.with_noise({SIGNAL: factor * NOISE})
    (note,) = given.notes
    assert f"given as {factor * NOISE:.2g} rad, but its high frequencies show 0.001 rad" in note
    assert given.noise[SIGNAL].sigma == factor * NOISE


def test_steps_of_a_sensor_are_a_limit_to_what_is_given() -> None:
    step = 1e-3
    counted = recording(step * np.round(MOTION / step)).with_noise({SIGNAL: 1e-5})
    floor = counted.noise[SIGNAL]
    assert floor.sigma == pytest.approx(step / np.sqrt(12.0))
    assert (floor.kind, floor.source) == ("quantised", "given")
    (note,) = counted.notes
    assert "its steps alone make 0.00029 rad" in note


def test_noise_of_what_was_not_measured_or_is_none_is_refused(noisy: Measurement) -> None:
    with pytest.raises(MeasurementError, match="joint_torque was not measured"):
        noisy.with_noise({"joint_torque": 1.0})
    with pytest.raises(MeasurementError, match="positive"):
        noisy.with_noise({SIGNAL: 0.0})


def test_filtered_signal_is_told_until_its_noise_is_given(noisy: Measurement) -> None:
    smooth = recording(filtfilt(*butter(4, 0.08), noisy.signals[SIGNAL]))
    (note,) = smooth.noise_notes
    assert note.startswith("joint_position looks filtered")
    assert "at least" in note
    given = smooth.with_noise({SIGNAL: 0.45 * NOISE})
    assert given.noise_notes == ()
    (doubt,) = noisy.with_noise({SIGNAL: 9.0 * NOISE}).noise_notes
    assert "what was given is taken" in doubt
    assert given.notes == ()
    assert noisy.noise_notes == ()


def test_periods_and_spectrum_that_disagree_are_told() -> None:
    rng = np.random.default_rng(4)
    motor = np.sin(np.pi * TIME) + 0.3 * np.sin(5.0 * np.pi * TIME + 1.0)
    drift = 0.05 * np.sin(0.9 * TIME)
    signal = motor + drift + NOISE * rng.standard_normal(5000)
    (note,) = Measurement(TIME, motor, {SIGNAL: signal}, name="made.csv").noise_notes
    assert "from period to period" in note
    assert "the periods count" in note
