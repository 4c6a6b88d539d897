"""Resonances are told from noise, and from a spectrum that is not flat."""

import numpy as np
import pytest

from elastic_tendon.diagnosis.peaks import peaks

STEP, COUNT = 0.002, 6000  # s
LOWEST, HIGHEST = 60.0, 900.0  # rad/s


def noise(seed: int, falls: float = 0.0) -> np.ndarray:
    """Standard normal; where it falls, each sample keeps this share of the one before."""
    white = np.random.default_rng(seed).standard_normal(COUNT)
    for index in range(1, COUNT):
        white[index] += falls * white[index - 1]
    return white


def ringing(frequency: float, ratio: float) -> np.ndarray:
    """What a resonance (rad/s, damping ratio) makes of blows, RMS one."""
    time = STEP * np.arange(COUNT)
    blows = np.zeros(COUNT)
    blows[::700] = 1.0
    decay = np.exp(-ratio * frequency * time) * np.sin(frequency * time)
    rung = np.convolve(blows, decay)[:COUNT]
    return rung / np.sqrt(np.mean(rung**2))


@pytest.mark.parametrize("falls", [0.0, 0.9])
@pytest.mark.parametrize("frequency", [100.0, 230.0, 700.0])
def test_a_resonance_is_found_beneath_noise(frequency, falls) -> None:
    found = peaks(ringing(frequency, 0.01) + noise(1, falls), STEP, LOWEST, HIGHEST)
    assert found[0][0] == pytest.approx(frequency, rel=0.02)
    assert all(times > 1.0 for _, times in found)


@pytest.mark.parametrize("falls", [0.0, 0.9])
def test_noise_alone_has_hardly_any(falls) -> None:
    shown = [bool(peaks(noise(seed, falls), STEP, LOWEST, HIGHEST)) for seed in range(100)]
    assert np.mean(shown) < 0.1


def test_only_what_is_within_the_range_counts() -> None:
    assert peaks(ringing(40.0, 0.01) + noise(2), STEP, LOWEST, HIGHEST) == []


def test_a_recording_too_short_or_too_coarse_shows_none() -> None:
    assert peaks(np.zeros(10), STEP, LOWEST, HIGHEST) == []
    assert peaks(noise(3), 1.0, LOWEST, HIGHEST) == []
    assert peaks(ringing(230.0, 0.01)[:40], STEP, LOWEST, HIGHEST) == []
    assert peaks(noise(3), STEP, np.inf, 0.0) == []  # nothing typical is a frequency


def test_what_is_left_exactly_nothing_of_shows_none() -> None:
    assert peaks(np.zeros(COUNT), STEP, LOWEST, HIGHEST) == []
