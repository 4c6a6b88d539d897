"""The noise of the motor's encoder is taken away, its motion is not."""

from dataclasses import replace

import numpy as np
import pytest

from elastic_tendon.comparison.residuals import rms
from elastic_tendon.diagnosis.inputs import smoothed
from elastic_tendon.measurement import Measurement
from truth.experiments import Limits, multisine, steps_with_load_pulses

LIMITS = Limits(0.2, 4.0, 3.0)
NOISE = 5e-4  # rad
COUNT = 2.0 * np.pi / 2**14


def recording(experiment) -> Measurement:
    time = np.arange(round(experiment.duration * 500)) / 500.0
    motion = np.array([experiment.motor_position.value(float(one)) for one in time])
    return Measurement(
        name="made",
        time=time,
        motor_position=motion,
        signals={"joint_position": motion},
        load_torque=None,
        interpolation="cubic",
    )


@pytest.mark.parametrize("make", [multisine, steps_with_load_pulses])
def test_noise_is_taken_away(make) -> None:
    clean = recording(make(7, LIMITS))
    noise = NOISE * np.random.default_rng(7).standard_normal(len(clean.time))
    noisy = replace(clean, motor_position=np.round((clean.motor_position + noise) / COUNT) * COUNT)
    left = rms(smoothed(noisy).motor_position - clean.motor_position)
    assert left < 0.5 * rms(noisy.motor_position - clean.motor_position)


@pytest.mark.parametrize("make", [multisine, steps_with_load_pulses])
def test_a_motion_without_noise_is_kept(make) -> None:
    clean = recording(make(8, LIMITS))
    assert rms(smoothed(clean).motor_position - clean.motor_position) < 2e-6


def with_jerk(clean: Measurement) -> Measurement:
    """The motor moves on by some counts from one sample to the next."""
    later = np.where(clean.time > 5.003, 5.0 * COUNT, 0.0)
    return replace(clean, motor_position=clean.motor_position + later)


def test_a_jerk_is_no_noise() -> None:
    jerky = with_jerk(recording(multisine(8, LIMITS)))
    taken = smoothed(jerky).motor_position - jerky.motor_position
    assert np.max(np.abs(taken)) < 1e-5


def test_noise_beside_a_jerk_is_taken_away() -> None:
    clean = with_jerk(recording(multisine(8, LIMITS)))
    noise = NOISE / 5.0 * np.random.default_rng(8).standard_normal(len(clean.time))
    noisy = replace(clean, motor_position=clean.motor_position + noise)
    left = smoothed(noisy).motor_position - clean.motor_position
    assert np.max(np.abs(left)) < 5.0 * NOISE / 5.0
    assert rms(left) < 0.6 * rms(noise)


def test_static_curves_short_and_uneven_recordings_come_back_as_they_are() -> None:
    clean = recording(multisine(9, LIMITS))
    static = replace(clean, static=True)
    uneven = clean.samples(np.flatnonzero(np.arange(len(clean.time)) % 7))
    short = clean.samples(slice(0, 50))
    assert all(smoothed(one) is one for one in (static, uneven, short))
