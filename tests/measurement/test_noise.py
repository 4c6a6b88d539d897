"""The noise floor is found below a motion, whatever the sensor."""

from functools import partial

import numpy as np
import pytest
from scipy.signal import butter, filtfilt, lfilter, savgol_filter

import study_noise
from elastic_tendon.measurement.noise import NoiseFloor, noise_floors, quantisation_step
from truth.noise import coloured_noise

TIME = np.arange(5000) / 500.0
# a link of 6 Hz following a slow motion, rad
MOTION = 0.5 * np.sin(37.0 * TIME) + np.sin(2.0 * TIME)
# scatter of a standard deviation that is estimated from half the spectrum of 5000 samples is 3 %
TOLERANCE = 0.1
# of coloured noise most lies where the motion hides it
COLOURED_TOLERANCE = 0.35
FILTERED_TOLERANCE = 0.15


def floor_of(signal: np.ndarray, time: np.ndarray = TIME) -> NoiseFloor:
    """Of a signal under inputs that tell nothing."""
    return noise_floors(time, {}, {"signal": signal})["signal"]


@pytest.mark.parametrize("offset", [0.0, 1e6])
@pytest.mark.parametrize("sigma", [1e-4, 1e-3, 1e-2])
def test_white_noise_below_a_motion(sigma: float, offset: float) -> None:
    rng = np.random.default_rng(1)
    floor = floor_of(offset + MOTION + sigma * rng.standard_normal(len(TIME)))
    assert floor.sigma == pytest.approx(sigma, rel=TOLERANCE)
    assert (floor.kind, floor.correlation) == ("white", 0.0)
    assert floor.method == "high frequencies"


@pytest.mark.parametrize("correlation", [0.5, 0.8, 0.9])
def test_coloured_noise_below_a_motion(correlation: float) -> None:
    rng = np.random.default_rng(5)
    floor = floor_of(MOTION + coloured_noise(rng, len(TIME), 1e-3, correlation))
    assert floor.sigma == pytest.approx(1e-3, rel=COLOURED_TOLERANCE)
    assert floor.kind == "coloured"
    assert floor.correlation == pytest.approx(correlation, abs=0.1)


def test_coloured_noise_of_a_sensor_with_counts() -> None:
    rng = np.random.default_rng(6)
    noisy = MOTION + coloured_noise(rng, len(TIME), 1e-3, 0.9)
    step = 3e-4
    floor = floor_of(step * np.round(noisy / step))
    assert floor.sigma == pytest.approx(np.hypot(1e-3, step / np.sqrt(12)), rel=COLOURED_TOLERANCE)
    assert floor.kind == "coloured"


@pytest.mark.parametrize(("white", "kind"), [(0.0, "quantised"), (1e-3, "white")])
def test_encoder_counts(white: float, kind: str) -> None:
    step = 2.0 * np.pi / 2**12
    noisy = MOTION + white * np.random.default_rng(2).standard_normal(len(TIME))
    floor = floor_of(np.round(step * np.round(noisy / step), 6))
    assert floor.sigma == pytest.approx(np.hypot(white, step / np.sqrt(12.0)), rel=TOLERANCE)
    assert floor.kind == kind


def test_whole_numbers_are_counts() -> None:
    floor = floor_of(np.round(100.0 * MOTION).astype(int))
    assert floor.sigma == pytest.approx(1.0 / np.sqrt(12.0), rel=TOLERANCE)
    assert floor.kind == "quantised"


def test_signal_at_rest_keeps_the_floor_of_its_counts() -> None:
    step = 1e-3
    signal = step * np.round(np.where(TIME > 9.0, MOTION - MOTION[4500], 0.0) / step)
    floor = floor_of(signal)
    assert floor.kind == "quantised"
    assert floor.sigma == pytest.approx(step / np.sqrt(12.0), rel=TOLERANCE)


def test_sawtooth_of_slow_counts_is_not_coloured_noise() -> None:
    step = 1e-3
    floor = floor_of(step * np.round(0.1 * np.sin(0.6 * TIME) / step))
    assert floor.kind == "quantised"
    assert floor.sigma == pytest.approx(step / np.sqrt(12.0), rel=TOLERANCE)


def test_impacts_do_not_count_as_noise() -> None:
    rng = np.random.default_rng(3)
    jumps = np.floor(TIME / 2.0)
    floor = floor_of(MOTION + jumps + 1e-3 * rng.standard_normal(len(TIME)))
    assert floor.sigma == pytest.approx(1e-3, rel=TOLERANCE)
    assert floor.kind == "white"


def test_noise_that_swells_with_the_motion_counts_as_noise() -> None:
    rng = np.random.default_rng(7)
    noise = 1e-3 * (1.0 + np.sin(2.0 * TIME)) * rng.standard_normal(len(TIME))
    # the median over segments is less than the root mean square, but of its order
    assert floor_of(MOTION + noise).sigma == pytest.approx(np.std(noise), rel=0.5)


def test_saturation_does_not_hide_the_noise() -> None:
    rng = np.random.default_rng(8)
    noisy = MOTION + 1e-3 * rng.standard_normal(len(TIME))
    floor = floor_of(np.where(TIME > 3.0, 2.0, noisy))
    assert floor.sigma == pytest.approx(1e-3, rel=2 * TOLERANCE)


@pytest.mark.parametrize("n", [10, 20, 300, 5000])
def test_constant_signal_has_a_floor_above_zero(n: int) -> None:
    floor = floor_of(np.full(n, 3.0), TIME[:n])
    assert 0.0 < floor.sigma < 1e-6


def test_few_samples() -> None:
    rng = np.random.default_rng(9)
    ratios = [
        floor_of(MOTION[:10] + 0.1 * rng.standard_normal(10), TIME[:10]).sigma / 0.1
        for _ in range(200)
    ]
    # ten samples tell little, but are not far off on average
    assert 0.6 < np.median(ratios) < 1.4


def uneven(kind: str, rng: np.random.Generator) -> np.ndarray:
    if kind == "jitter":
        return TIME + rng.uniform(-0.2, 0.2, len(TIME)) / 500.0
    if kind == "samples lost":
        return TIME[rng.uniform(size=len(TIME)) > 0.05]
    return np.cumsum(rng.exponential(1.0 / 500.0, len(TIME)))


@pytest.mark.parametrize("kind", ["jitter", "samples lost", "at random"])
def test_uneven_samples_are_not_taken_for_noise(kind: str) -> None:
    rng = np.random.default_rng(10)
    time = uneven(kind, rng)
    motion = 0.5 * np.sin(37.0 * time) + np.sin(2.0 * time)
    floor = floor_of(motion + 1e-3 * rng.standard_normal(len(time)), time)
    assert floor.sigma == pytest.approx(1e-3, rel=TOLERANCE)
    assert floor.kind == "white"


def test_step_of_floating_point_noise_is_none() -> None:
    assert quantisation_step(np.random.default_rng(4).standard_normal(500)) == 0.0
    steady = 0.057 * np.arange(60) + 1e-4 * np.random.default_rng(4).standard_normal(60)
    assert quantisation_step(steady) == 0.0  # a constant speed is no encoder's step
    encoder = np.round(np.sin(np.linspace(0.0, 900.0, 2_500_001)) / 1e-3) * 1e-3
    assert quantisation_step(encoder) == pytest.approx(1e-3)
    assert quantisation_step(np.random.default_rng(5).standard_normal(2_500_001)) == 0.0


def test_actuators_with_kinks() -> None:
    """A small sample of build_scripts/study_noise.py, on motions and noise of its own."""
    rng = np.random.default_rng(4200)
    found = {noise.name: [] for noise in study_noise.NOISES[:3]}
    for index, name in enumerate(["Coulomb friction", "play"]):
        columns = study_noise.motion(study_noise.EFFECTS[name], "multisine", 4200 + index, rate=500)
        for noise in study_noise.NOISES[:3]:
            found[noise.name] += [
                study_noise.estimate(columns, "joint_position", noise, size, rng)
                for size in (3e-4, 1e-3, 3e-3)
            ]
    ratios = {
        name: [floor.sigma / sigma for floor, sigma in floors] for name, floors in found.items()
    }
    assert ratios["white"] == pytest.approx(np.ones(6), rel=TOLERANCE)
    assert not any(floor.kind == "coloured" for floor, _ in found["white"])
    assert np.median(ratios["AR 0.5"]) == pytest.approx(1.0, rel=TOLERANCE)
    assert np.median(ratios["AR 0.9"]) == pytest.approx(1.0, rel=COLOURED_TOLERANCE)
    assert min(ratios["AR 0.9"]) > 0.5
    assert all(floor.kind == "coloured" for floor, _ in found["AR 0.9"])


# ---- signals that were filtered -------------------------------------------------------------


@pytest.mark.parametrize("corner", [0.1, 0.2, 0.3])
@pytest.mark.parametrize("order", [2, 4])
def test_noise_of_a_filtered_signal_shows_below_where_the_filter_falls(
    order: int, corner: float
) -> None:
    noise = 1e-3 * np.random.default_rng(11).standard_normal(len(TIME))
    filtered = partial(lfilter, *butter(order, 2.0 * corner))
    floor, left = floor_of(filtered(MOTION + noise)), filtered(noise)
    assert not floor.is_least
    assert floor.sigma == pytest.approx(np.std(left), rel=FILTERED_TOLERANCE)
    assert floor.kind == "coloured"
    assert floor.correlation == pytest.approx(np.corrcoef(left[1:], left[:-1])[0, 1], abs=0.05)


def test_noise_of_a_filtered_signal_is_not_known_where_the_motion_covers_it() -> None:
    rng = np.random.default_rng(11)
    noisy = MOTION + 1e-3 * rng.standard_normal(len(TIME))
    corner = 0.05
    floor = floor_of(lfilter(*butter(4, 2.0 * corner), noisy - noisy[0]))
    assert floor.is_least
    assert floor.falls_above > 0.1 * 500.0
    # what the filter left: a share of the noise that is less than its pass band
    assert floor.sigma < 1e-3 * np.sqrt(2.0 * corner)


@pytest.mark.parametrize("window", [5, 7, 11, 21])
@pytest.mark.parametrize("order", [0, 2])
def test_noise_of_averaged_samples_is_not_known(window: int, order: int) -> None:
    """Moving averages, of order 0, and the smoothing of Savitzky and Golay."""
    noisy = MOTION + 1e-3 * np.random.default_rng(16).standard_normal(len(TIME))
    floor = floor_of(savgol_filter(noisy, window, order))
    assert floor.is_least
    assert floor.sigma < 1e-3


@pytest.mark.parametrize(("samples", "size"), [(300, 0.0), (1000, 0.0), (5000, 3e-3)])
def test_noise_with_lines_or_few_samples_is_not_called_averaged(samples: int, size: float) -> None:
    lines = size * (np.sin(2.0 * np.pi * 100.0 * TIME) + np.sin(2.0 * np.pi * 150.0 * TIME))
    for seed in range(20):
        noisy = MOTION + lines + 1e-3 * np.random.default_rng(seed).standard_normal(len(TIME))
        assert not floor_of(noisy[:samples], TIME[:samples]).is_least


def test_an_excitation_that_ends_below_the_sampling_rate_is_no_noise() -> None:
    """As of the Silverbox: a response to noise up to a third of the sampling rate."""
    rng = np.random.default_rng(12)
    excitation = filtfilt(*butter(8, 0.6), rng.standard_normal(len(TIME)))
    response = lfilter([1.0], [1.0, -1.4, 0.95], excitation)
    floor = floor_of(response + 1e-4 * rng.standard_normal(len(TIME)))
    assert floor.is_least
    assert floor.sigma == pytest.approx(1e-4, rel=0.5)


@pytest.mark.parametrize("correlation", [0.0, 0.5, 0.9])
def test_noise_that_was_not_filtered_is_not_called_so(correlation: float) -> None:
    rng = np.random.default_rng(13)
    floor = floor_of(MOTION + coloured_noise(rng, len(TIME), 1e-3, correlation))
    assert floor.falls_above is None
    assert not floor.is_least


def test_filtered_signal_keeps_the_floor_of_its_steps() -> None:
    step = 1e-4
    noisy = MOTION + 1e-3 * np.random.default_rng(14).standard_normal(len(TIME))
    smooth = filtfilt(*butter(4, 0.2), noisy)
    assert floor_of(step * np.round(smooth / step)).sigma >= step / np.sqrt(12.0)


def test_periods_are_the_source_where_the_inputs_repeat() -> None:
    rng = np.random.default_rng(15)
    motor = np.sin(np.pi * TIME) + 0.3 * np.sin(5.0 * np.pi * TIME + 1.0)
    signal = motor + 1e-3 * rng.standard_normal(5000)
    floor = noise_floors(TIME, {"motor_position": motor}, {"signal": signal})["signal"]
    assert floor.source == "periods"
    assert floor.sigma == pytest.approx(1e-3, rel=TOLERANCE)
    assert floor_of(MOTION + 1e-3 * rng.standard_normal(5000)).source == "spectrum"
