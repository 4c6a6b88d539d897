"""A linear axis that nearly integrates: a mass that a controller drives to and fro.

Viscous and dry friction and a constant force, which models have too, and one thing more that they
lack. Plain steps of 0.1 ms, far shorter than anything in it; dry friction rises steeply with the
velocity instead of holding.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from math import copysign, exp, pi, sin, sqrt, tanh

import numpy as np
from numpy.typing import NDArray

RATE, STEPS = 1000, 10  # samples a s, steps a sample
MASS, VISCOUS, DRY, CONSTANT = 95.0, 203.0, 20.4, 3.2  # kg, N s/m, N, N; opposed to the force
MOST = 350.0  # N, of the drive
STIFFNESS, DAMPING = 11_700.0, 4_000.0  # of its controller, N/m, N s/m
CREEPING = 2e-4  # m/s, at which dry friction is nearly all there
NOISE = 2e-7  # m, of the encoder
TURN = 2.0 * pi

# more of the force that opposes the motion, N, at time, position and velocity, from a phase on
Lacking = Callable[[float, float, float, float], float]
LACKING: dict[str, Lacking] = {
    "nothing": lambda _t, _x, _v, _phase: 0.0,
    "the constant force wanders": lambda t, _x, _v, phase: 0.3 * sin(TURN * t / 60.0 + phase),
    "pitch of the screw": lambda _t, x, _v, phase: 2.0 * sin(TURN * x / 0.01 + phase),
    "more friction when slow": lambda _t, _x, v, _phase: (
        0.15 * DRY * exp(-((v / 0.02) ** 2)) * tanh(v / CREEPING)
    ),
    "other friction backwards": lambda _t, _x, v, _phase: (
        0.08 * (VISCOUS * v - DRY * tanh(v / CREEPING)) if v < 0.0 else 0.0
    ),
    "less damping when fast": lambda _t, _x, v, _phase: -1.5 * VISCOUS * abs(v) * v,
}


@dataclass(frozen=True)
class Recorded:
    """Time (s), measured position (m) and force of the drive (N), (n,) each."""

    time: NDArray[np.float64]
    position: NDArray[np.float64]
    force: NDArray[np.float64]


def recorded(
    lacking: str, random: np.random.Generator, seconds: float = 25.0, late: float = 0.0
) -> Recorded:
    """One run of the axis, which begins at rest; recorded so many s `late`, in full motion."""
    phase = random.uniform(0.0, TURN)
    goals = _moves(random, int((seconds + late) * RATE))
    return followed(goals, lacking, random, phase, late)


def followed(
    goals: NDArray[np.float64],
    lacking: str,
    random: np.random.Generator,
    phase: float = 0.0,
    late: float = 0.0,
) -> Recorded:
    """The run in which the controller follows these goals, m, a sample each."""
    law = LACKING[lacking]
    speeds = np.gradient(goals, 1.0 / RATE)
    position, force = np.empty_like(goals), np.empty_like(goals)
    x = v = 0.0
    step = 1.0 / (RATE * STEPS)
    for i, (goal, speed) in enumerate(zip(goals.tolist(), speeds.tolist(), strict=True)):
        drive = min(max(STIFFNESS * (goal - x) + DAMPING * (speed - v), -MOST), MOST)
        position[i], force[i] = x, drive
        for _ in range(STEPS):
            opposed = CONSTANT + DRY * tanh(v / CREEPING) + VISCOUS * v
            v += step * (drive - opposed - law(i / RATE, x, v, phase)) / MASS
            x += step * v
    first = int(late * RATE)
    measured = position + NOISE * random.standard_normal(len(position))
    return Recorded(np.arange(len(goals) - first) / RATE, measured[first:], force[first:])


def _moves(random: np.random.Generator, samples: int) -> NDArray[np.float64]:
    """Goals (n,) of moves from place to place with pauses, m: speed up, go on, slow down."""
    found: list[float] = []
    place = 0.0
    while len(found) < samples:
        goal = random.uniform(-0.12, 0.12)
        found += (place + copysign(part, goal - place) for part in _way(random, abs(goal - place)))
        found += [goal] * int(random.uniform(0.0, 0.4) * RATE)
        place = goal
    return np.array(found[:samples])


def _way(random: np.random.Generator, length: float) -> Iterator[float]:
    """Way from 0 to a length, m, a sample each."""
    fastest, steepest = random.uniform(0.05, 0.25), random.uniform(0.3, 1.5)  # m/s, m/s^2
    rising = min(fastest / steepest, sqrt(length / steepest))
    whole = rising + length / (steepest * rising)
    for i in range(int(whole * RATE) + 1):
        t = i / RATE
        if t < rising:
            yield 0.5 * steepest * t**2
        elif t < whole - rising:
            yield steepest * rising * (t - 0.5 * rising)
        else:
            yield length - 0.5 * steepest * (whole - t) ** 2
