"""Correlations find what an error follows, and their bounds hold where it follows nothing."""

from types import MappingProxyType

import numpy as np
import pytest

from elastic_tendon.comparison.comparison import FileComparison, SignalError
from elastic_tendon.comparison.correlations import correlations
from elastic_tendon.comparison.residuals import InitialState
from elastic_tendon.measurement import Measurement, NoiseFloor
from elastic_tendon.simulation.simulate import Trajectory

RATE = 200.0  # Hz
SAMPLES = 4000
RECORDINGS = 30
# of values outside 99 % bounds; a run has some hundred lags, of which neighbours are alike
ALLOWED = 0.03


def compared(
    error, motion, load, *, noise: float = 0.0, time=None, measured=None, step: float = 0.0
) -> FileComparison:
    """A recording of which the simulation is off by `error`; by a sensor that shows steps."""
    time = np.arange(len(error)) / RATE if time is None else time
    measured = np.zeros(len(error)) if measured is None else measured
    measurement = Measurement(time, motion, {"joint_position": measured}, load, name="made up")
    outputs = np.stack([measured + error], axis=1)
    names = ("joint_position",)
    trajectory = Trajectory(time, outputs[:, :0], outputs, (), names, np.array([]), {})
    floor = NoiseFloor(1.0, "coloured" if noise else "white", "high frequencies", noise)
    if step:
        floor = NoiseFloor(step / np.sqrt(12.0), "quantised")
    figures = SignalError(1.0, 1.0, 0.0, None, 1.0, len(error), floor, MappingProxyType({}))
    return FileComparison(
        measurement, InitialState(0.0, 0.0), trajectory, {"joint_position": figures}
    )


def coloured(rng, memory: float):
    """First-order autoregression of unit variance."""
    values = rng.standard_normal(SAMPLES)
    for index in range(1, SAMPLES):
        values[index] = memory * values[index - 1] + np.sqrt(1 - memory**2) * values[index]
    return values


def smooth(rng):
    """Motion of a multisine below 3 Hz."""
    time = np.arange(SAMPLES) / RATE
    return sum(
        np.sin(2.0 * np.pi * f * time + rng.uniform(0, 7)) / f for f in np.arange(0.2, 3.0, 0.1)
    )


NAMES = {"", "motor_position", "motor_velocity", "motor_acceleration", "load_torque"}


def judged(errors, *, noise: float = 0.0) -> tuple[dict[str, float], dict[str, int]]:
    """Share of values beyond their bounds, and in how many recordings any surely is, by input."""
    shares, alarms = dict.fromkeys(NAMES, 0.0), dict.fromkeys(NAMES, 0)
    for seed in range(RECORDINGS):
        rng = np.random.default_rng(seed)
        file = compared(errors(rng), smooth(rng), coloured(rng, 0.9), noise=noise)
        for found in correlations(file, "joint_position"):
            shares[found.signal] += float(np.mean(found.beyond)) / RECORDINGS
            alarms[found.signal] += int(found.surely_beyond.any())
    return shares, alarms


@pytest.mark.parametrize("memory", [0.0, 0.6, 0.9])
def test_noise_stays_within_its_bounds(memory: float) -> None:
    shares, alarms = judged(lambda rng: coloured(rng, memory), noise=memory)
    assert max(shares.values()) < ALLOWED, shares
    assert max(alarms.values()) <= 1, alarms


def test_an_error_that_hangs_together_follows_no_input_for_that() -> None:
    """Bounds of white noise would call every smooth input guilty of any smooth error."""
    shares, alarms = judged(lambda rng: coloured(rng, 0.95))
    assert alarms.pop("") == RECORDINGS
    assert max(alarms.values()) <= 1, alarms
    assert max(share for name, share in shares.items() if name) < ALLOWED, shares


def test_bounds_of_autoregressive_noise_are_bartletts() -> None:
    rng = np.random.default_rng(4)
    own, *_ = correlations(
        compared(coloured(rng, 0.8), smooth(rng), None, noise=0.8), "joint_position"
    )
    lags = RATE * own.lag
    squared = 0.8 ** (2.0 * lags)
    variance = (1.0 + 0.64) * (1.0 - squared) / (1.0 - 0.64) - 2.0 * lags * squared
    assert own.expected == pytest.approx(0.8**lags)
    # those of the first lags are no narrower than those of white noise
    expected = 2.576 * np.sqrt(np.maximum(variance, 1.0) / SAMPLES)
    assert own.bound == pytest.approx(expected, rel=1e-3)


def test_the_steps_of_an_encoder_are_no_residual_that_hangs_together() -> None:
    rng = np.random.default_rng(5)
    true = smooth(rng)
    # a step that the motion takes a tenth of a second to pass, so that its rounding is no noise
    step = 0.1 * float(np.max(np.abs(np.diff(true)))) * RATE
    measured = step * np.rint(true / step)
    error = true - measured
    as_noise, *_ = correlations(compared(error, true, None), "joint_position")
    of_steps, *others = correlations(
        compared(error, true, None, measured=measured, step=step), "joint_position"
    )
    assert as_noise.surely_beyond.any()
    assert not of_steps.surely_beyond.any()
    assert not any(found.surely_beyond.any() for found in others)


def test_how_many_lags_chance_puts_beyond_is_told() -> None:
    rng = np.random.default_rng(6)
    own, *_ = correlations(
        compared(rng.standard_normal(SAMPLES), smooth(rng), None), "joint_position"
    )
    assert own.beyond_by_chance == pytest.approx(0.01 * len(own.lag))
    assert own.beyond[own.strongest] == own.beyond.any()


def test_an_error_that_follows_the_load_is_found_with_its_lag() -> None:
    rng = np.random.default_rng(1)
    load = coloured(rng, 0.8)
    late = np.roll(load, 6) + 0.3 * rng.standard_normal(SAMPLES)
    found = {
        correlation.signal: correlation
        for correlation in correlations(compared(late, smooth(rng), load), "joint_position")
    }
    with_load = found["load_torque"]
    peak = int(np.argmax(with_load.values))
    assert with_load.lag[peak] == pytest.approx(6 / RATE)
    assert with_load.values[peak] > 0.9
    # the residual's own memory widens the band, but not until nothing leaves it
    assert np.max(with_load.bound) < 0.12
    assert with_load.strongest == peak
    assert with_load.surely_beyond[peak]
    assert not found["motor_velocity"].surely_beyond.any()


def test_uneven_sampling_is_made_even_and_still_inputs_are_left_out() -> None:
    rng = np.random.default_rng(2)
    time = np.sort(rng.uniform(0.0, 20.0, SAMPLES))
    error = np.sin(2.0 * np.pi * time)
    found = correlations(compared(error, np.zeros(SAMPLES), None, time=time), "joint_position")
    assert [correlation.signal for correlation in found] == [""]
    half = np.argmin(np.abs(found[0].lag - 0.5))
    assert found[0].values[half] == pytest.approx(-1.0, abs=0.1)
