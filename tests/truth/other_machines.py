"""Machines of other kinds than the tendon arm, by their own equations: shafts, cables, laminates.

A motor end and a link with a transmission between them. Friction is Dahl's, which the product does
not have: stiff bristles that give way, Fc (1 - exp(-x)) from rest. It shares no code with it.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from math import copysign, exp

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

Array = NDArray[np.float64]
Motion = Callable[[float], tuple[float, float]]  # a value and its rate at a time
Drive = Callable[[float, float, float], float]  # torque at a time, position and speed of the motor


@dataclass(frozen=True)
class Friction:
    """Dahl's friction: torque that slides, share of a transmitted torque beside it, and more while
    slow; `stiffness` of the bristles as a share of that torque for each rad."""

    torque: float = 0.0
    share: float = 0.0
    more: float = 0.0
    slow: float = 0.05  # rad/s
    stiffness: float = 1e4

    def bound(self, transmitted: float, velocity: float) -> float:
        """Torque at which it slides, N·m."""
        stribeck = self.more * exp(-abs(velocity) / self.slow)
        return self.torque + stribeck + self.share * abs(transmitted)


@dataclass(frozen=True)
class Machine:
    """Numbers in SI units at the joint; motor and joint turn alike.

    `cubic`, `quintic` : of the spring, N·m/rad³ and N·m/rad⁵; `gap` : play in series with it, rad;
    `pull` : antagonistic cables of that pretension, N·m, instead of one spring; `gravity` : N·m,
    hanging at q = 0.
    """

    inertia: float
    damping: float
    stiffness: float
    spring_damping: float = 0.0
    cubic: float = 0.0
    quintic: float = 0.0
    gap: float = 0.0
    pull: float | None = None
    gravity: float = 0.0
    friction: Friction = field(default_factory=Friction)
    motor_inertia: float = 0.0
    motor_damping: float = 0.0
    motor_friction: Friction = field(default_factory=Friction)

    def transmitted(self, bent: float, rate: float) -> tuple[float, float]:
        """Torque that drives the link, and what presses on the guides, N·m; `bent` motor less
        joint, rad."""
        if self.pull is not None:
            upper = max(self.pull + 0.5 * (self.stiffness * bent + self.spring_damping * rate), 0.0)
            lower = max(self.pull - 0.5 * (self.stiffness * bent + self.spring_damping * rate), 0.0)
            return upper - lower, upper + lower
        played = copysign(max(abs(bent) - 0.5 * self.gap, 0.0), bent)
        touching = 1.0 if played else float(self.gap == 0.0)
        torque = self.stiffness * played + self.cubic * played**3 + self.quintic * played**5
        torque += touching * self.spring_damping * rate
        return torque, abs(torque)

    def link(
        self, angle: float, velocity: float, drive: float, press: float, bristle: float
    ) -> tuple[float, float]:
        """Torque on the link, and the rate at which friction nears its bound."""
        bound = self.friction.bound(press, velocity)
        torque = drive - self.damping * velocity - self.gravity * np.sin(angle) - bound * bristle
        return torque, _yield(self.friction, velocity, bristle)


def _yield(friction: Friction, velocity: float, bristle: float) -> float:
    """Rate at which Dahl's friction nears its bound, of which it is the share `bristle`."""
    direction = copysign(1.0, velocity) if velocity else 0.0
    return friction.stiffness * velocity * (1.0 - bristle * direction)


def unloaded(_at: float) -> tuple[float, float]:
    """No load, N·m."""
    return 0.0, 0.0


def driven_by_position(
    machine: Machine, time: Array, motor: Motion, load: Motion = unloaded
) -> Array:
    """Joint position, (n,) rad, from rest where the motor begins; `load` on the link, N·m."""

    def rates(at: float, state: Array) -> list[float]:
        angle, velocity, bristle = state
        position, speed = motor(at)
        drive, press = machine.transmitted(position - angle, speed - velocity)
        torque, yielding = machine.link(angle, velocity, drive + load(at)[0], press, bristle)
        return [velocity, torque / machine.inertia, yielding]

    position, speed = motor(float(time[0]))
    return np.asarray(_solved(rates, [position, speed, 0.0], time)[0])


def driven_by_torque(machine: Machine, time: Array, torque: Drive) -> tuple[Array, Array, Array]:
    """Motor and joint position, (n,) rad each, from rest at 0, and the motor torque, (n,) N·m."""

    def rates(at: float, state: Array) -> list[float]:
        turned, speed, held, angle, velocity, bristle = state
        drive, press = machine.transmitted(turned - angle, speed - velocity)
        friction = machine.motor_friction.bound(press, speed) * held
        push = torque(at, turned, speed) - drive - machine.motor_damping * speed - friction
        moved, yielding = machine.link(angle, velocity, drive, press, bristle)
        return [
            speed,
            push / machine.motor_inertia,
            _yield(machine.motor_friction, speed, held),
            velocity,
            moved / machine.inertia,
            yielding,
        ]

    states = _solved(rates, [0.0] * 6, time)
    pairs = zip(time, states[0], states[1], strict=True)
    return states[0], states[3], np.array([torque(*pair) for pair in pairs])


def _solved(rates: Callable[[float, Array], list[float]], start: list[float], time: Array) -> Array:
    span = float(time[0]), float(time[-1])
    solved = solve_ivp(
        rates, span, start, method="LSODA", t_eval=time, rtol=1e-7, atol=1e-10, max_step=2e-3
    )
    if not solved.success:
        raise ArithmeticError(solved.message)
    return np.asarray(solved.y)


def laminate(
    deflection: Array, stiffness: float, cubic: float, slips: Array, shares: Array
) -> Array:
    """Torque of a leaf spring over slow deflections, (n,) N·m: leaves that stick and slip.

    Each slip (rad) is a leaf that is elastic up to there and then slides, with its share of the
    stiffness: an operator of Prandtl and Ishlinskii.
    """
    torque = np.empty_like(deflection)
    stuck, before = np.zeros_like(slips), float(deflection[0])
    for index, bent in enumerate(deflection):
        stuck = np.clip(stuck + bent - before, -slips, slips)
        before = float(bent)
        torque[index] = stiffness * (bent + shares @ stuck) + cubic * bent**3
    return torque


def sines(
    rng: np.random.Generator, amplitude: float, low: float, high: float, count: int
) -> Motion:
    """Several sines from rest; amplitudes (rad) fall with the frequency (Hz)."""
    frequency = 2.0 * np.pi * np.geomspace(low, high, count) * rng.uniform(0.9, 1.1, count)
    size = amplitude * rng.uniform(0.6, 1.0, count) * (frequency[0] / frequency) ** 0.7
    phase = rng.uniform(0.0, 2.0 * np.pi, count)

    def motion(at: float) -> tuple[float, float]:
        turned = frequency * at + phase
        rise = 1.0 - exp(-at / 0.3)  # from rest
        whole = float(size @ (np.sin(turned) - np.sin(phase)))
        rate = float((size * frequency) @ np.cos(turned))
        return rise * whole, rise * rate + exp(-at / 0.3) / 0.3 * whole

    return motion
