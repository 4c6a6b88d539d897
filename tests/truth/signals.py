"""Inputs as functions of time with their rates, and the times at which they are not smooth.

All are right-continuous; the solver restarts at every breakpoint.
"""

import math
from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

# largest slope of the quintic 10 s³ - 15 s⁴ + 6 s⁵ from 0 to 1
SMOOTH_STEP_PEAK_RATE = 1.875


@dataclass(frozen=True)
class Signal:
    """A quantity over time (s), its rate (1/s), and where either jumps or kinks."""

    value: Callable[[float], float]
    rate: Callable[[float], float]
    breakpoints: tuple[float, ...] = ()


def constant(level: float) -> Signal:
    """A signal that stays at `level`."""
    return Signal(lambda _time: level, lambda _time: 0.0)


def total(*signals: Signal) -> Signal:
    """The sum of signals."""
    return Signal(
        lambda time: sum(signal.value(time) for signal in signals),
        lambda time: sum(signal.rate(time) for signal in signals),
        tuple(sorted({point for signal in signals for point in signal.breakpoints})),
    )


def product(first: Signal, second: Signal) -> Signal:
    """The product of two signals."""
    return Signal(
        lambda time: first.value(time) * second.value(time),
        lambda time: first.rate(time) * second.value(time) + first.value(time) * second.rate(time),
        tuple(sorted({*first.breakpoints, *second.breakpoints})),
    )


def scaled(signal: Signal, factor: float) -> Signal:
    """A signal times `factor`."""
    return Signal(
        lambda time: factor * signal.value(time),
        lambda time: factor * signal.rate(time),
        signal.breakpoints,
    )


def later(signal: Signal, delay: float) -> Signal:
    """A signal that stays at its first value for `delay` (s) and then runs its course."""
    return Signal(
        lambda time: signal.value(max(time - delay, 0.0)),
        lambda time: signal.rate(time - delay) if time >= delay else 0.0,
        (delay, *(point + delay for point in signal.breakpoints)),
    )


def sines(
    amplitudes: Sequence[float], frequencies: Sequence[float], phases: Sequence[float]
) -> Signal:
    """A sum of sines; `frequencies` in Hz, `phases` in rad."""
    terms = [
        (amplitude, 2.0 * math.pi * frequency, phase)
        for amplitude, frequency, phase in zip(amplitudes, frequencies, phases, strict=True)
    ]
    return Signal(
        lambda time: sum(a * math.sin(w * time + phase) for a, w, phase in terms),
        lambda time: sum(a * w * math.cos(w * time + phase) for a, w, phase in terms),
    )


def smooth_step(start: float, rise: float, height: float) -> Signal:
    """A step of `height` from `start` (s) within `rise` (s) along a quintic, smooth twice."""

    def share(time: float) -> float:
        return min(max((time - start) / rise, 0.0), 1.0)

    def value(time: float) -> float:
        s = share(time)
        return height * s**3 * (10.0 - 15.0 * s + 6.0 * s**2)

    def rate(time: float) -> float:
        s = share(time)
        return height / rise * 30.0 * s**2 * (1.0 - s) ** 2

    return Signal(value, rate, (start, start + rise))


def smooth_pulse(start: float, duration: float, height: float, edge: float) -> Signal:
    """A pulse of `height` whose edges take `edge` (s) each, inside `duration` (s)."""
    return total(
        smooth_step(start, edge, height), smooth_step(start + duration - edge, edge, -height)
    )


def rectangular_pulse(start: float, duration: float, height: float) -> Signal:
    """A pulse of `height` on start <= time < start + duration; its rate is zero."""
    end = start + duration
    return Signal(
        lambda time: height if start <= time < end else 0.0, lambda _time: 0.0, (start, end)
    )


def piecewise_linear(times: Sequence[float], values: Sequence[float]) -> Signal:
    """Straight lines between samples; continued beyond the first and the last."""
    slopes = [
        (values[i + 1] - values[i]) / (times[i + 1] - times[i]) for i in range(len(times) - 1)
    ]

    def interval(time: float) -> int:
        return min(max(bisect_right(times, time) - 1, 0), len(slopes) - 1)

    def value(time: float) -> float:
        i = interval(time)
        return values[i] + slopes[i] * (time - times[i])

    return Signal(value, lambda time: slopes[interval(time)], tuple(times))


@dataclass(frozen=True)
class Experiment:
    """What is done to an actuator for `duration` (s), from which initial state of the joint."""

    duration: float
    motor_position: Signal  # rad, at the motor pulley
    load_torque: Signal = field(default=constant(0.0))  # N·m on the joint, positive with q
    initial_position: float = 0.0  # rad
    initial_velocity: float = 0.0  # rad/s
