"""The frequency at which what an answer leaves rings."""

from types import SimpleNamespace

import numpy as np
import pytest

from elastic_tendon.diagnosis.candidates import resonant_starts
from elastic_tendon.diagnosis.ringing import ringing
from elastic_tendon.effects import BY_ID
from smooth_motion import GIVEN

RATE, SECONDS = 500.0, 8.0
RING = 61.3  # Hz; no multiple of the spectrum's step
TIME = np.arange(int(RATE * SECONDS)) / RATE


def answer(*errors, static: bool = False) -> SimpleNamespace:
    """What is left of some recordings of the joint's position."""
    recording = SimpleNamespace(time=TIME, static=static)
    return SimpleNamespace(
        errors=[{"joint_position": error} for error in errors],
        result=SimpleNamespace(
            model=GIVEN, problem=SimpleNamespace(measurements=[recording] * len(errors))
        ),
    )


def left(amplitude: float) -> np.ndarray:
    """Noise, a slow error that is far larger, and a tone that dies away."""
    noise = np.random.default_rng(3).standard_normal(len(TIME))
    tone = np.sin(2.0 * np.pi * RING * TIME) * np.exp(-TIME / 2.0)
    return 20.0 * np.sin(2.0 * np.pi * 0.7 * TIME) + noise + amplitude * tone


def test_a_tone_is_found_beside_a_larger_slow_error() -> None:
    (found,) = ringing(answer(left(3.0)))
    assert found == pytest.approx(2.0 * np.pi * RING, rel=2e-3)


def test_what_rings_now_and_then_and_is_damped_is_found_too() -> None:
    noise = np.random.default_rng(5).standard_normal(len(TIME))
    strokes = np.zeros(len(TIME))
    strokes[np.random.default_rng(6).integers(len(TIME), size=8)] = 1.0
    ring = np.sin(2.0 * np.pi * RING * TIME) * np.exp(-0.02 * 2.0 * np.pi * RING * TIME)
    (found,) = ringing(answer(noise + 3.0 * np.convolve(strokes, ring)[: len(TIME)]))
    assert found == pytest.approx(2.0 * np.pi * RING, rel=2e-2)


def test_noise_rings_one_in_three_times() -> None:
    noises = np.random.default_rng(7).standard_normal((100, len(TIME)))
    assert sum(len(ringing(answer(noise))) for noise in noises) <= 40


def test_each_recording_has_its_own_and_static_ones_have_none() -> None:
    assert len(ringing(answer(left(3.0), left(3.0)))) == 2
    assert ringing(answer(left(3.0), static=True)) == []


def test_what_does_not_ring_has_no_frequency() -> None:
    assert ringing(answer(np.zeros(len(TIME)))) == []
    assert ringing(answer(20.0 * np.sin(2.0 * np.pi * 0.7 * TIME))) == []


def test_starts_swing_at_about_the_frequency_that_was_seen() -> None:
    frequency = 2.0 * np.pi * RING
    starts = list(resonant_starts(GIVEN, BY_ID["spring_mass"], [frequency]))
    stiffness = GIVEN.transmission.upper_spring.stiffness
    swings = [np.sqrt(4.0 * stiffness / start["mass"]) for start in starts]
    assert min(abs(swing / frequency - 1.0) for swing in swings) < 1e-3
    assert len({start["damping"] / start["mass"] for start in starts}) > 1
    assert list(resonant_starts(GIVEN, BY_ID["coulomb_friction"], [frequency])) == []
