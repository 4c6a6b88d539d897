"""The noise floor is found below a motion, whatever the sensor."""

import numpy as np
import pytest

from elastic_tendon.measurement import noise_sigma
from elastic_tendon.measurement.noise import quantisation_step

TIME = np.arange(5000) / 500.0
# a link of 6 Hz following a slow motion, rad
MOTION = 0.5 * np.sin(37.0 * TIME) + np.sin(2.0 * TIME)
# scatter of a standard deviation over 5000 samples of high differences is about 3 %
TOLERANCE = 0.1


@pytest.mark.parametrize("sigma", [1e-4, 1e-3, 1e-2])
def test_white_noise_below_a_motion(sigma: float) -> None:
    rng = np.random.default_rng(1)
    floor = noise_sigma(MOTION + sigma * rng.standard_normal(len(TIME)))
    assert floor.sigma == pytest.approx(sigma, rel=TOLERANCE)
    assert floor.kind == "white"


@pytest.mark.parametrize(("white", "kind"), [(0.0, "quantised"), (1e-3, "white")])
def test_encoder_counts(white: float, kind: str) -> None:
    step = 2.0 * np.pi / 2**12
    noisy = MOTION + white * np.random.default_rng(2).standard_normal(len(TIME))
    floor = noise_sigma(np.round(step * np.round(noisy / step), 6))
    assert floor.sigma == pytest.approx(np.hypot(white, step / np.sqrt(12.0)), rel=TOLERANCE)
    assert floor.kind == kind


def test_signal_at_rest_keeps_the_floor_of_its_counts() -> None:
    step = 1e-3
    signal = step * np.round(np.where(TIME > 9.0, MOTION - MOTION[4500], 0.0) / step)
    floor = noise_sigma(signal)
    assert floor.kind == "quantised"
    assert floor.sigma == pytest.approx(step / np.sqrt(12.0), rel=TOLERANCE)


def test_impacts_do_not_count_as_noise() -> None:
    rng = np.random.default_rng(3)
    jumps = np.floor(TIME / 2.0)
    floor = noise_sigma(MOTION + jumps + 1e-3 * rng.standard_normal(len(TIME)))
    assert floor.sigma == pytest.approx(1e-3, rel=TOLERANCE)


def test_constant_signal_has_a_floor_above_zero() -> None:
    assert noise_sigma(np.zeros(20)).sigma > 0.0


def test_step_of_floating_point_noise_is_none() -> None:
    assert quantisation_step(np.random.default_rng(4).standard_normal(500)) == 0.0
