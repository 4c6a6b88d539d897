"""Experiments as functions of a seed and of what the actuator may do."""

import math
from dataclasses import dataclass, replace

import numpy as np

from truth.actuator import Actuator
from truth.signals import (
    SMOOTH_STEP_PEAK_RATE,
    Experiment,
    Signal,
    constant,
    product,
    scaled,
    sines,
    smooth_pulse,
    smooth_step,
    total,
)
from truth.solver import simulate

FADE_IN = 0.5  # s, so that motions start at rest
SEARCH_STEP = 2e-3  # s, at which peaks are looked for
HALVINGS = 6  # of the size of an experiment, in search of the largest that fits
ROUGH = 1e-6  # tolerance that is good enough to find a peak deflection


@dataclass(frozen=True)
class Limits:
    """What the actuator may do: magnitudes of joint deflection, motor speed and load torque."""

    deflection: float  # rad
    speed: float  # rad/s, of the motor pulley
    torque: float  # N·m; 0 for experiments without load


def limits_of(actuator: Actuator, speed: float) -> Limits:
    """The deflection (16) that the springs bear to both sides, and its static torque (7)."""
    lower, upper = actuator.deflection_limits()
    deflection = min(-lower, upper)
    radius = actuator.joint_pulley_radius
    torques = [
        radius * abs(max(forces[0], 0.0) - max(forces[1], 0.0))
        for forces in (
            actuator.spring_forces((0.0, 0.0), (sign * deflection, 0.0), (True, True))
            for sign in (-1.0, 1.0)
        )
    ]
    return Limits(deflection, speed, min(torques))


def peak(signal: Signal, duration: float, of_rate: bool = False) -> float:
    """Largest magnitude of a signal or of its rate within `duration` (s)."""
    function = signal.rate if of_rate else signal.value
    return max(abs(function(float(time))) for time in np.arange(0.0, duration, SEARCH_STEP))


def load_pulses(rng: np.random.Generator, limits: Limits, duration: float) -> Signal:
    """Smooth pulses of either sign up to the torque limit, about one every 1.2 s."""
    if limits.torque == 0.0:
        return constant(0.0)
    starts = np.arange(0.8, duration - 0.8, 1.2)
    starts = starts + rng.uniform(0.0, 0.4, len(starts))
    return total(
        *[
            smooth_pulse(
                float(start),
                duration=float(rng.uniform(0.25, 0.6)),
                height=float(rng.choice([-1.0, 1.0]) * rng.uniform(0.3, 1.0)) * limits.torque,
                edge=float(rng.uniform(0.04, 0.12)),
            )
            for start in starts
        ]
    )


def multisine(seed: int, limits: Limits, duration: float = 10.0) -> Experiment:
    """Sines from 0.1 to 5 Hz at the motor, amplitudes falling with frequency, and load pulses."""
    rng = np.random.default_rng(seed)
    frequencies = np.geomspace(0.1, 5.0, 12) * rng.uniform(0.9, 1.1, 12)
    phases = rng.uniform(0.0, 2.0 * math.pi, 12)
    motion = product(
        smooth_step(0.0, FADE_IN, 1.0),
        sines((1.0 / frequencies).tolist(), frequencies.tolist(), phases.tolist()),
    )
    motion = scaled(motion, limits.speed / peak(motion, duration, of_rate=True))
    return Experiment(duration, motion, load_pulses(rng, limits, duration))


def steps_with_load_pulses(seed: int, limits: Limits, duration: float = 10.0) -> Experiment:
    """Smooth steps of the motor between random levels with rests between, and load pulses."""
    rng = np.random.default_rng(seed)
    level, start, steps = 0.0, 0.3, []
    while start < duration - 1.0:
        # a step takes at most 0.3 s at the speed limit
        target = float(rng.uniform(-1.0, 1.0)) * 0.15 * limits.speed / SMOOTH_STEP_PEAK_RATE
        rise = SMOOTH_STEP_PEAK_RATE * abs(target - level) / limits.speed
        rise *= float(rng.uniform(1.0, 1.5))
        steps.append(smooth_step(start, rise, target - level))
        level, start = target, start + rise + float(rng.uniform(0.3, 1.0))
    return Experiment(duration, total(*steps), load_pulses(rng, limits, duration))


def free_decay(seed: int, limits: Limits, duration: float = 5.0) -> Experiment:
    """The joint let go from a deflection of 60 to 100 % of the limit, the motor held."""
    rng = np.random.default_rng(seed)
    deflection = float(rng.choice([-1.0, 1.0]) * rng.uniform(0.6, 1.0)) * limits.deflection
    return Experiment(duration, constant(0.0), initial_position=deflection)


def slow_sweep(seed: int, limits: Limits, duration: float = 20.0) -> Experiment:
    """Two slow sines of the load torque up to 90 % of its limit, the motor held."""
    rng = np.random.default_rng(seed)
    load = sines([0.9 * limits.torque * float(rng.choice([-1.0, 1.0]))], [2.0 / duration], [0.0])
    return Experiment(duration, constant(0.0), load)


def within_deflection(actuator: Actuator, experiment: Experiment, deflection: float) -> Experiment:
    """The experiment, made as much smaller as it needs not to pass `deflection` (rad)."""
    time = np.arange(0.0, experiment.duration, SEARCH_STEP)

    def shrunk(share: float) -> Experiment:
        return replace(
            experiment,
            motor_position=scaled(experiment.motor_position, share),
            load_torque=scaled(experiment.load_torque, share),
            initial_position=share * experiment.initial_position,
            initial_velocity=share * experiment.initial_velocity,
        )

    def fits(share: float) -> bool:
        run = simulate(actuator, shrunk(share), time, tolerance=ROUGH)
        return float(np.max(np.abs(run["deflection"]))) <= deflection

    if fits(1.0):
        return experiment
    small, large = 0.0, 1.0
    for _ in range(HALVINGS):
        middle = 0.5 * (small + large)
        small, large = (middle, large) if fits(middle) else (small, middle)
    return shrunk(small)
