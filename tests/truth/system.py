"""The equations of one mode, when a mode is left, and which follows.

A mode changes with a hysteresis far below any accuracy asked for: it makes each event a clean
change of sign, so none is met twice or passed over at a restart.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from truth.actuator import Actuator
from truth.signals import Experiment

Vector = NDArray[np.float64]

# half-widths of the hysteresis; each shifts an event by less than 1e-11 s at ordinary rates
FORCE_HYSTERESIS = 1e-10  # N
LENGTH_HYSTERESIS = 1e-14  # m
VELOCITY_HYSTERESIS = 1e-12  # rad/s
TORQUE_HYSTERESIS = 1e-12  # N·m


@dataclass(frozen=True)
class Mode:
    """What is frozen between events; pairs are (upper spring, lower spring)."""

    taut: tuple[bool, bool]
    engaged: tuple[bool, bool]  # exact overstretch kinks
    direction: int  # of friction: 1 or -1 the joint slides that way, 0 it sticks


@dataclass(frozen=True)
class System:
    """An actuator with its inputs: the equations of one mode."""

    actuator: Actuator
    experiment: Experiment

    def motor(self, time: float) -> tuple[float, float]:
        """Motor position (rad) and velocity (rad/s)."""
        signal = self.experiment.motor_position
        return signal.value(time), signal.rate(time)

    def forces(self, time: float, state: Vector, mode: Mode) -> tuple[float, float]:
        """Spring forces (3) before the step function, N."""
        joint = (float(state[0]), float(state[1]))
        return self.actuator.spring_forces(self.motor(time), joint, mode.engaged)

    def excess(self, time: float, state: Vector, side: int) -> float:
        """Elongation of one spring beyond its overstretch engagement, m."""
        spring = (self.actuator.upper, self.actuator.lower)[side]
        assert spring.overstretch is not None
        lengths = self.actuator.elongations(self.motor(time)[0], float(state[0]))
        return lengths[side] - spring.overstretch.engagement

    def joint_torque(self, time: float, state: Vector, mode: Mode) -> float:
        """Elastic torque on the joint (7), N·m."""
        upper, lower = self.forces(time, state, mode)
        return self.actuator.joint_pulley_radius * (upper * mode.taut[0] - lower * mode.taut[1])

    def torque_without_friction(self, time: float, state: Vector, mode: Mode) -> float:
        """All torques on the joint but friction, N·m."""
        link, position, velocity = self.actuator.link, float(state[0]), float(state[1])
        return (
            self.joint_torque(time, state, mode)
            + self.experiment.load_torque.value(time)
            + link.extra_torque(time, position, velocity)
            - link.damping * velocity
        )

    def friction_torque(self, time: float, state: Vector, mode: Mode) -> float:
        """Friction against positive motion, N·m; what balances the rest while the joint sticks."""
        friction = self.actuator.link.friction
        if friction is None:
            return 0.0
        if mode.direction == 0:
            return self.torque_without_friction(time, state, mode)
        return friction.opposing(mode.direction, state[2:].tolist())

    def rates(self, time: float, state: Vector, mode: Mode) -> list[float]:
        """Time derivative of the state (position, velocity, friction states)."""
        link = self.actuator.link
        if mode.direction == 0 and link.friction is not None:
            return [0.0] * len(state)
        velocity = float(state[1])
        torque = self.torque_without_friction(time, state, mode)
        torque -= self.friction_torque(time, state, mode)
        states = (
            []
            if link.friction is None
            else link.friction.rates(mode.direction, velocity, state[2:].tolist())
        )
        return [velocity, torque / link.inertia, *states]

    def kinked_sides(self) -> list[int]:
        """Springs with an exact overstretch kink: 0 the upper, 1 the lower."""
        springs = (self.actuator.upper, self.actuator.lower)
        return [
            side
            for side, spring in enumerate(springs)
            if spring.overstretch is not None and spring.overstretch.rounding == 0.0
        ]


def relay(on: bool, value: float, hysteresis: float) -> bool:
    """State of a two-valued mode that is on above and off below zero, with hysteresis.

    It changes at half the hysteresis, for which the solver stops at the whole: so the mode whose
    event was located changes in spite of rounding, and with it any that coincides.
    """
    return value > -0.5 * hysteresis if on else value >= 0.5 * hysteresis


def updated(
    system: System, time: float, state: Vector, mode: Mode, hysteresis: bool = True
) -> tuple[Mode, Vector]:
    """Mode and state right after `time`; without `hysteresis` the mode's history does not count."""
    state = state.copy()
    width = 1.0 if hysteresis else 0.0
    engaged = list(mode.engaged)
    for side in system.kinked_sides():
        excess = system.excess(time, state, side)
        engaged[side] = relay(engaged[side], excess, width * LENGTH_HYSTERESIS)
    mode = replace(mode, engaged=(engaged[0], engaged[1]))
    forces = system.forces(time, state, mode)
    taut = [relay(mode.taut[i], forces[i], width * FORCE_HYSTERESIS) for i in (0, 1)]
    mode = replace(mode, taut=(taut[0], taut[1]))
    friction = system.actuator.link.friction
    if friction is None:
        return mode, state
    slides_on = mode.direction * state[1] > -0.5 * VELOCITY_HYSTERESIS
    if mode.direction != 0 and slides_on:
        return mode, state
    if not friction.sticks:
        return replace(mode, direction=-mode.direction), state
    state[1] = 0.0
    torque = system.torque_without_friction(time, state, mode)
    held = abs(torque) < friction.torque + 0.5 * TORQUE_HYSTERESIS
    return replace(mode, direction=0 if held else int(math.copysign(1, torque))), state


def initial(system: System) -> tuple[Mode, Vector]:
    """Mode and state at time zero; friction states start at zero."""
    start, friction = system.experiment, system.actuator.link.friction
    extra = 0 if friction is None else friction.state_count
    state = np.array([start.initial_position, start.initial_velocity, *[0.0] * extra])
    if start.initial_velocity != 0.0:
        direction = int(math.copysign(1, start.initial_velocity))
    else:
        direction = 0 if friction is not None and friction.sticks else 1
    mode = Mode(taut=(True, True), engaged=(False, False), direction=direction)
    return updated(system, 0.0, state, mode, hysteresis=False)


def thresholds(system: System, mode: Mode) -> list[Callable[[float, Vector], float]]:
    """Functions of (time, state) that are negative in `mode` and leave it at zero, rising."""

    def leaves(
        quantity: Callable[[float, Vector], float], on: bool, hysteresis: float
    ) -> Callable[[float, Vector], float]:
        sign = -1.0 if on else 1.0
        return lambda time, state: sign * quantity(time, state) - hysteresis

    def force(side: int) -> Callable[[float, Vector], float]:
        return lambda time, state: system.forces(time, state, mode)[side]

    def excess(side: int) -> Callable[[float, Vector], float]:
        return lambda time, state: system.excess(time, state, side)

    found = [leaves(force(side), mode.taut[side], FORCE_HYSTERESIS) for side in (0, 1)]
    found += [
        leaves(excess(side), mode.engaged[side], LENGTH_HYSTERESIS)
        for side in system.kinked_sides()
    ]
    friction = system.actuator.link.friction
    if friction is None:
        return found
    if mode.direction == 0:
        limit = friction.torque + TORQUE_HYSTERESIS
        return [
            *found,
            lambda time, state: abs(system.torque_without_friction(time, state, mode)) - limit,
        ]
    return [
        *found,
        lambda _time, state: -mode.direction * float(state[1]) - VELOCITY_HYSTERESIS,
    ]
