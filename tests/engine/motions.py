"""What is done to the machines: motions of the motor and a known load on the joint."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Signal = Callable[[Array], Array]

KINDS = ("waves", "stairs")
FADE = 0.6  # s, so that all begins at rest
SPEED = 4.0  # rad/s, largest of the motor's waves
PEAK_SLOPE = 1.875  # of the quintic from 0 to 1


def rise(time: Array) -> Array:
    """From 0 to 1 within 0 to 1 along a quintic, smooth twice."""
    s = np.clip(time, 0.0, 1.0)
    return np.asarray(s**3 * (10.0 - 15.0 * s + 6.0 * s**2))


@dataclass(frozen=True)
class Steps:
    """A level that changes smoothly."""

    starts: Array  # s
    durations: Array  # s
    heights: Array

    def __call__(self, time: Array) -> Array:
        """Values at times, s."""
        found = np.zeros_like(time)
        for start, duration, height in zip(self.starts, self.durations, self.heights, strict=True):
            found += height * rise((time - start) / duration)
        return found


@dataclass(frozen=True)
class Waves:
    """Sines that fade in."""

    amplitudes: Array
    frequencies: Array  # Hz
    phases: Array

    def __call__(self, time: Array) -> Array:
        """Values at times, s."""
        angles = 2.0 * math.pi * np.outer(time, self.frequencies) + self.phases
        return np.asarray(rise(time / FADE) * (np.sin(angles) @ self.amplitudes))


def total(parts: tuple[Signal, ...], time: Array) -> Array:
    """The sum of signals at times."""
    return np.asarray(np.sum([part(time) for part in parts], axis=0), dtype=np.float64)


@dataclass(frozen=True)
class Motion:
    """Motor position (rad, at its pulley) and load on the joint (N·m) as sums of signals."""

    duration: float  # s
    motor_parts: tuple[Signal, ...]
    load_parts: tuple[Signal, ...]
    motor_share: float = 1.0
    load_share: float = 1.0

    def motor(self, time: Array) -> Array:
        """Motor position at times, rad."""
        return self.motor_share * total(self.motor_parts, time)

    def load(self, time: Array) -> Array:
        """Load at times, N·m."""
        return self.load_share * total(self.load_parts, time)

    def scaled(self, share: float) -> "Motion":
        """A smaller or larger one."""
        return replace(
            self, motor_share=share * self.motor_share, load_share=share * self.load_share
        )


def waves(
    rng: np.random.Generator, lowest: float, highest: float, count: int, slope: float
) -> Waves:
    """Sines between two frequencies (Hz), the slower the larger, of a largest rate `slope`."""
    frequencies = np.geomspace(lowest, highest, count) * rng.uniform(0.9, 1.1, count)
    phases = rng.uniform(0.0, 2.0 * math.pi, count)
    # 2.2 rms rates: about the largest
    amplitude = slope / (2.2 * 2.0 * math.pi * math.sqrt(0.5 * count))
    return Waves(amplitude / frequencies, frequencies, phases)


def steps(
    rng: np.random.Generator, times: Array, levels: Array, quickest: float, slowest: float
) -> Steps:
    """From level to level, each change within `quickest` to `slowest` (s)."""
    return Steps(times, rng.uniform(quickest, slowest, len(times)), np.diff(levels, prepend=0.0))


def pulses(rng: np.random.Generator, duration: float, every: float, height: float) -> Steps:
    """A load that is put on and taken off, either way."""
    starts = np.arange(0.7, duration - 0.8, every) + rng.uniform(0.0, 0.3 * every)
    signs = np.where(np.arange(len(starts)) % 2 == 0, 1.0, -1.0)
    heights = signs * rng.uniform(0.4, 1.0, len(starts)) * height
    lengths = rng.uniform(0.3, 0.6, len(starts)) * every
    edges = np.repeat(rng.uniform(0.05, 0.15, len(starts)), 2)
    return Steps(
        np.column_stack([starts, starts + lengths]).ravel(),
        edges,
        np.column_stack([heights, -heights]).ravel(),
    )


def motion_of(kind: str, seed: int, duration: float, torque: float) -> Motion:
    """A motion of a kind in `KINDS`.

    Parameters
    ----------
    seed : of the random numbers
    duration : s
    torque : load that is about the largest, N·m
    """
    rng = np.random.default_rng([KINDS.index(kind), seed])
    if kind == "waves":
        times = np.sort(rng.uniform(1.0, duration - 1.0, 4))
        jumps = steps(rng, times, rng.uniform(-0.25, 0.25, 4), 0.15, 0.4)
        motor: tuple[Signal, ...] = (waves(rng, 0.3, 4.0, 10, SPEED), jumps)
        swell = waves(rng, 0.1, 1.0, 4, 1.5 * torque)
        return Motion(duration, motor, (pulses(rng, duration, 1.3, 0.8 * torque), swell))
    times = np.arange(0.4, duration - 0.8, 0.9) + rng.uniform(0.0, 0.3)
    levels = rng.uniform(-0.8, 0.8, len(times))
    motor = (steps(rng, times, levels, 0.2, 0.7),)
    return Motion(duration, motor, (pulses(rng, duration, 1.7, torque),))
