"""Correlations find what an error follows, and their bounds hold where it follows nothing."""

from types import MappingProxyType

import numpy as np
import pytest

from elastic_tendon.comparison.compare import FileComparison, SignalError
from elastic_tendon.comparison.correlations import correlations
from elastic_tendon.comparison.residuals import InitialState
from elastic_tendon.measurement import Measurement, NoiseFloor
from elastic_tendon.simulation.simulate import Trajectory

RATE = 200.0  # Hz
SAMPLES = 4000
# of values outside 99 % bounds; a run has some hundred lags, of which neighbours are alike
ALLOWED = 0.03


def compared(error, motion, load, *, noise: float = 0.0, time=None) -> FileComparison:
    """A recording of which the simulation is off by `error`."""
    time = np.arange(len(error)) / RATE if time is None else time
    nothing = np.zeros(len(error))
    measurement = Measurement(time, motion, {"joint_position": nothing}, load, name="made up")
    outputs = np.stack([error], axis=1)
    names = ("joint_position",)
    trajectory = Trajectory(time, outputs[:, :0], outputs, (), names, np.array([]), {})
    floor = NoiseFloor(1.0, "coloured" if noise else "white", "high frequencies", noise)
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


def outside(found) -> float:
    return float(np.mean(np.abs(found.values - found.expected) > found.bound))


@pytest.mark.parametrize("memory", [0.0, 0.6, 0.9])
def test_noise_stays_within_its_bounds(memory: float) -> None:
    shares: dict[str, list[float]] = {}
    for seed in range(30):
        rng = np.random.default_rng(seed)
        file = compared(coloured(rng, memory), smooth(rng), smooth(rng), noise=memory)
        for found in correlations(file, "joint_position"):
            shares.setdefault(found.signal, []).append(outside(found))
    assert set(shares) == {"", "motor_velocity", "motor_acceleration", "load_torque"}
    assert all(np.mean(values) < ALLOWED for values in shares.values()), shares


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
    # an error that is no noise must not widen the band until nothing leaves it
    assert np.max(with_load.bound) < 0.1


def test_uneven_sampling_is_made_even_and_still_inputs_are_left_out() -> None:
    rng = np.random.default_rng(2)
    time = np.sort(rng.uniform(0.0, 20.0, SAMPLES))
    error = np.sin(2.0 * np.pi * time)
    found = correlations(compared(error, np.zeros(SAMPLES), None, time=time), "joint_position")
    assert [correlation.signal for correlation in found] == [""]
    half = np.argmin(np.abs(found[0].lag - 0.5))
    assert found[0].values[half] == pytest.approx(-1.0, abs=0.1)
