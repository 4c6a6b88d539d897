"""Where inputs repeat, the noise is what a signal does differently in the next period."""

import numpy as np
import pytest

from elastic_tendon.measurement.noise import NoiseFloor, noise_floors
from elastic_tendon.measurement.repetition import period_of, repeated_noise
from truth.noise import coloured_noise

PERIOD = 500  # samples
SIGMA = 1e-3
INPUT_SIGMA = 2e-4


def motor(n: int, period: int = PERIOD) -> np.ndarray:
    phase = 2.0 * np.pi * np.arange(n) / period
    return np.sin(phase) + 0.3 * np.sin(3.0 * phase + 1.0)


def floor_of_response(n: int, correlation: float, seed: int) -> NoiseFloor:
    """Of an answer with a transient at the beginning, under a noisy motor position and a load."""
    rng = np.random.default_rng(seed)
    time = np.arange(n) / 500.0
    inputs = {
        "motor_position": motor(n) + INPUT_SIGMA * rng.standard_normal(n),
        "load_torque": np.zeros(n),
    }
    answer = 0.8 * motor(n) ** 3 + 0.5 * np.exp(-20.0 * time) * np.sin(30.0 * time)
    noisy = answer + coloured_noise(rng, n, SIGMA, correlation)
    return noise_floors(time, inputs, {"joint_position": noisy})["joint_position"]


@pytest.mark.parametrize("n", [2 * PERIOD, 3 * PERIOD + 70, 10 * PERIOD])
@pytest.mark.parametrize(("correlation", "tolerance"), [(0.0, 0.1), (0.9, 0.25)])
def test_noise_of_any_colour(n: int, correlation: float, tolerance: float) -> None:
    floor = floor_of_response(n, correlation, seed=n)
    assert floor.method == "repeated periods"
    assert floor.sigma == pytest.approx(SIGMA, rel=tolerance)
    assert floor.kind == ("coloured" if correlation else "white")
    assert floor.correlation == pytest.approx(correlation, abs=0.1)


def test_noise_of_two_periods_is_neither_too_small_nor_too_large() -> None:
    rng = np.random.default_rng(30)
    found = [
        repeated_noise(motor(2 * PERIOD) + SIGMA * rng.standard_normal(2 * PERIOD), PERIOD)
        for _ in range(30)
    ]
    # 30 estimates from 500 samples each: their mean is known to less than a percent
    assert np.mean([noise[0] for noise in found if noise]) == pytest.approx(SIGMA, rel=0.03)


def test_shortest_period_of_all_inputs_together() -> None:
    inputs = {"motor_position": motor(3000, 250), "load_torque": motor(3000, 750)}
    assert period_of(inputs, {"motor_position": 0.0, "load_torque": 0.0}) == 750
    assert period_of({"motor_position": inputs["motor_position"]}, {"motor_position": 0.0}) == 250


@pytest.mark.parametrize("noise", [0.0, 1e-4])
@pytest.mark.parametrize("period", [199_997, 12_345, 50_000])
def test_period_of_a_long_recording_is_exact(period: int, noise: float) -> None:
    n = 400_000 + 3
    rng = np.random.default_rng(period)
    values = motor(n, period) + noise * rng.standard_normal(n)
    assert period_of({"motor_position": values}, {"motor_position": noise}) == pytest.approx(
        period, abs=0 if noise == 0.0 else 3
    )


def test_motion_that_does_not_repeat_has_no_period() -> None:
    swept = np.sin(1e-5 * np.arange(4000.0) ** 2)
    assert period_of({"motor_position": swept}, {"motor_position": 1e-4}) is None


def test_half_a_repetition_is_none() -> None:
    assert period_of({"motor_position": motor(800)}, {"motor_position": 1e-4}) is None


def test_held_motor_repeats_nothing() -> None:
    rng = np.random.default_rng(1)
    held = 1e-3 * rng.standard_normal(2000)
    assert period_of({"motor_position": held}, {"motor_position": 1e-3}) is None


def test_transient_to_the_end_is_no_noise() -> None:
    time = np.arange(4 * PERIOD) / 500.0
    assert repeated_noise(np.exp(-3.0 * time), PERIOD) is None


def test_drift_is_noise_of_a_correlation_below_one() -> None:
    noise = repeated_noise(motor(4 * PERIOD) + np.linspace(0.0, 1.0, 4 * PERIOD), PERIOD)
    assert noise is not None
    assert 0.9 < noise[1] < 1.0


def test_signal_that_repeats_exactly_keeps_the_floor_of_its_counts() -> None:
    n, step = 4 * PERIOD, 1e-3
    signal = step * np.round(np.tile(motor(PERIOD), 4) / step)
    floors = noise_floors(np.arange(n) / 500.0, {"motor_position": motor(n)}, {"signal": signal})
    assert floors["signal"].kind == "quantised"
    assert floors["signal"].sigma == pytest.approx(step / np.sqrt(12.0), rel=0.01)
