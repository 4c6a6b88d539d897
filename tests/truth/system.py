"""The equations of one mode, when a mode is left, and which follows.

A mode changes with a hysteresis far below any accuracy asked for: it makes each event a clean
change of sign, so none is met twice or passed over at a restart.
"""

import math
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from truth.actuator import Actuator
from truth.friction import guide_loss
from truth.layout import SIDES, Layout, Side, layout_of
from truth.link import StopMode
from truth.signals import Experiment
from truth.tendon import (
    FORCE_HYSTERESIS,
    LENGTH_HYSTERESIS,
    NEVER,
    Reach,
    TendonMode,
    leaving,
    relay,
)

Vector = NDArray[np.float64]

# half-widths of the hysteresis; each shifts an event by less than 1e-11 s at ordinary rates
VELOCITY_HYSTERESIS = 1e-12  # rad/s
TORQUE_HYSTERESIS = 1e-12  # N·m
ANGLE_HYSTERESIS = 1e-14  # rad
MOST_CHANGES = 20  # of mode at one instant; more is no instant but a fault


@dataclass(frozen=True)
class Mode:
    """What is frozen between events."""

    tendons: tuple[TendonMode, ...]  # in the order of `Layout.tendons`
    direction: int  # of friction: 1 or -1 the joint slides that way, 0 it sticks
    stops: tuple[StopMode, StopMode] = field(default=(StopMode(), StopMode()))  # upper, lower
    tooth: int = 0  # pulley's place in the play: 0 floating, -1 behind the motor, 1 ahead of it

    @property
    def taut(self) -> tuple[bool, bool]:
        """Whether the upper and the lower tendon pull at the joint."""
        half = len(self.tendons) // 2
        return self.tendons[half - 1].taut, self.tendons[-1].taut

    @property
    def engaged(self) -> tuple[bool, bool]:
        """Whether the upper and the lower exact overstretch kink is engaged, at the joint."""
        half = len(self.tendons) // 2
        return self.tendons[half - 1].engaged, self.tendons[-1].engaged


@dataclass(frozen=True)
class System:
    """An actuator with its inputs: the equations of one mode."""

    actuator: Actuator
    experiment: Experiment

    @cached_property
    def layout(self) -> Layout:
        """Where the parts stand in the state."""
        return layout_of(self.actuator)

    # ---- kinematics ------------------------------------------------------------------------

    def motor(self, time: float) -> tuple[float, float]:
        """Motor position (rad) and velocity (rad/s)."""
        signal = self.experiment.motor_position
        return signal.value(time), signal.rate(time)

    def driven(self, time: float) -> tuple[float, float]:
        """Angle (rad) and rate (rad/s) to which the motor turns the pulley, were there no play."""
        motor = self.motor(time)
        eccentricity = self.actuator.eccentricity
        return motor if eccentricity is None else eccentricity.driven(*motor)

    def tooth_travel(self, time: float, tooth: int) -> float:
        """Travel r φ of the pulley at one end of its play, m."""
        angle = self.driven(time)[0] + 0.5 * tooth * self.actuator.gap
        return self.actuator.motor_pulley_radius * angle

    def pulley(self, time: float, state: Vector, mode: Mode) -> Reach:
        """Travel of the motor pulley, m, and its rate, m/s."""
        radius = self.actuator.motor_pulley_radius
        place = self.layout.pulley
        if place is None or mode.tooth != 0:
            return Reach(self.tooth_travel(time, mode.tooth), radius * self.driven(time)[1])
        travel = float(state[place])
        return Reach(travel, self.floating_rate(state, mode, travel))

    def floating_rate(self, state: Vector, mode: Mode, travel: float) -> float:
        """Rate, m/s, at which a pulley without mass follows so that both sides pull alike."""
        reaches = self.reaches_from(state, Reach(travel, 0.0))
        stiffness = change = 0.0
        for side in self.layout.sides:
            number = side.tendons[0]
            tendon, place = self.layout.tendons[number]
            rise, fall = tendon.response(mode.tendons[number], reaches[number], state[place])
            stiffness += rise
            # what the pulley's own rate does not contribute to this tension, per sign
            change += side.sign * (rise * reaches[number].rate - fall)
        if stiffness == 0.0:
            return self.joint_travel(state).rate
        return -change / stiffness

    def joint_travel(self, state: Vector) -> Reach:
        """Travel R q of the joint pulley, m, and its rate, m/s."""
        radius = self.actuator.joint_pulley_radius
        return Reach(radius * float(state[0]), radius * float(state[1]))

    def reaches_from(self, state: Vector, pulley: Reach) -> list[Reach]:
        """How far each tendon is drawn, with the motor pulley where `pulley` says."""
        joint, found = self.joint_travel(state), []
        for side in self.layout.sides:
            motor_end = Reach(side.sign * pulley.length, side.sign * pulley.rate)
            joint_end = Reach(side.sign * joint.length, side.sign * joint.rate)
            points = [motor_end, joint_end]
            if side.mass is not None:
                points.insert(1, Reach(float(state[side.mass]), float(state[side.mass + 1])))
            rest = side.rest / len(side.tendons)
            found += [
                Reach(
                    rest + points[i].length - points[i + 1].length,
                    points[i].rate - points[i + 1].rate,
                )
                for i in range(len(points) - 1)
            ]
        return found

    def reaches(self, time: float, state: Vector, mode: Mode) -> list[Reach]:
        """How far each tendon is drawn beyond its rest."""
        return self.reaches_from(state, self.pulley(time, state, mode))

    # ---- forces ----------------------------------------------------------------------------

    def tensions_from(self, reaches: list[Reach], state: Vector, mode: Mode) -> list[float]:
        """Tension of each tendon, N."""
        return [
            tendon.tension(mode.tendons[i], reaches[i], state[place])
            for i, (tendon, place) in enumerate(self.layout.tendons)
        ]

    def tensions(self, time: float, state: Vector, mode: Mode) -> list[float]:
        """Tension of each tendon, N."""
        return self.tensions_from(self.reaches(time, state, mode), state, mode)

    def at_joint(self, tensions: list[float]) -> tuple[float, float]:
        """Tension of the upper and the lower tendon between spring and joint, N."""
        upper, lower = self.layout.sides
        return tensions[upper.tendons[-1]], tensions[lower.tendons[-1]]

    def elastic_torque(self, tensions: list[float]) -> float:
        """Torque (7) on the joint, what guides take not deducted, N·m."""
        upper, lower = self.at_joint(tensions)
        return self.actuator.joint_pulley_radius * (upper - lower)

    def stop_torque(self, state: Vector, mode: Mode) -> float:
        """Torque of the end stops on the joint, N·m."""
        stop = self.actuator.link.stop
        if stop is None:
            return 0.0
        return -sum(
            side * stop.push(side, float(state[0]), float(state[1]))
            for side, now in zip(SIDES, mode.stops, strict=True)
            if now.reached and now.pushing
        )

    def torque_without_dry_friction(
        self, time: float, state: Vector, mode: Mode, tensions: list[float]
    ) -> float:
        """All torques on the joint but what makes it stick, N·m."""
        link, position, velocity = self.actuator.link, float(state[0]), float(state[1])
        torque = (
            self.elastic_torque(tensions)
            + self.experiment.load_torque.value(time)
            + link.extra_torque(time, position, velocity)
            - (link.damping + 0.5 * link.damping_difference * mode.direction) * velocity
            - link.drag * mode.direction * velocity**2
            - link.cubic_damping * velocity**3
            + link.constant_torque
            + self.stop_torque(state, mode)
        )
        if link.gravity is not None:
            torque += link.gravity.torque_at(position)
        if link.friction is not None and not link.friction.sticks:
            torque -= link.friction.opposing(mode.direction, velocity, self.friction_state(state))
        return torque

    def friction_state(self, state: Vector) -> list[float]:
        """States of the law of friction."""
        return [float(value) for value in state[self.layout.friction]]

    @property
    def sticks(self) -> bool:
        """Whether anything can hold the joint still."""
        friction = self.actuator.link.friction
        return self.actuator.wrap_friction > 0.0 or (friction is not None and friction.sticks)

    @property
    def has_direction(self) -> bool:
        """Whether anything depends on the sign of the joint's velocity."""
        link = self.actuator.link
        signed = link.drag != 0.0 or link.damping_difference != 0.0
        return self.sticks or link.friction is not None or signed

    def guide_torque(self, direction: int, tensions: list[float]) -> float:
        """What the tendons' guides take of the torque, N·m, against positive motion."""
        loss = guide_loss(self.actuator.wrap_friction, direction, *self.at_joint(tensions))
        return self.actuator.joint_pulley_radius * loss

    def dry_torque(self, direction: int, velocity: float, tensions: list[float]) -> float:
        """Dry friction against positive motion, N·m; at velocity 0 the most it holds."""
        friction, torque = self.actuator.link.friction, 0.0
        if friction is not None and friction.sticks:
            torque = friction.opposing(direction, velocity, [])
        if self.actuator.wrap_friction > 0.0:
            torque += self.guide_torque(direction, tensions)
        return torque

    def friction_torque(
        self, time: float, state: Vector, mode: Mode, tensions: list[float]
    ) -> float:
        """Friction against positive motion, N·m; what balances the rest while the joint sticks."""
        friction = self.actuator.link.friction
        if mode.direction == 0:
            return self.torque_without_dry_friction(time, state, mode, tensions)
        velocity = float(state[1])
        if friction is not None and not friction.sticks:
            smooth = friction.opposing(mode.direction, velocity, self.friction_state(state))
        else:
            smooth = 0.0
        return smooth + self.dry_torque(mode.direction, velocity, tensions)

    def joint_torque(self, time: float, state: Vector, mode: Mode, tensions: list[float]) -> float:
        """Torque of the tendons on the joint, behind their guides, N·m.

        While the joint sticks by guides and by another friction, each bears its share of the bound.
        """
        torque = self.elastic_torque(tensions)
        if self.actuator.wrap_friction == 0.0:
            return torque
        if mode.direction != 0:
            return torque - self.guide_torque(mode.direction, tensions)
        held = self.torque_without_dry_friction(time, state, mode, tensions)
        towards = 1 if held >= 0.0 else -1
        bound = self.dry_torque(towards, 0.0, tensions)
        share = held / bound if bound != 0.0 else 0.0
        return torque - share * self.guide_torque(towards, tensions)

    def motor_torque(self, time: float, mode: Mode, tensions: list[float]) -> float:
        """Torque of the springs on the motor against positive motor motion, N·m.

        What the pulley does to the tendons is the work of the motor: where it turns faster than
        the motor its torque is larger, and a motor in its play bears none.
        """
        if self.layout.pulley is not None and mode.tooth == 0:
            return 0.0
        position = self.motor(time)[0]
        eccentricity = self.actuator.eccentricity
        faster = 1.0 if eccentricity is None else eccentricity.driven(position, 1.0)[1]
        upper, lower = self.layout.sides
        pull = tensions[upper.tendons[0]] - tensions[lower.tendons[0]]
        return self.actuator.motor_pulley_radius * pull * faster

    # ---- rates -----------------------------------------------------------------------------

    def rates(self, time: float, state: Vector, mode: Mode) -> Vector:
        """Time derivative of the state."""
        pulley = self.pulley(time, state, mode)
        reaches = self.reaches_from(state, pulley)
        tensions = self.tensions_from(reaches, state, mode)
        link, velocity = self.actuator.link, float(state[1])
        rates = np.zeros(self.layout.count)
        if not (self.has_direction and mode.direction == 0):
            torque = self.torque_without_dry_friction(time, state, mode, tensions)
            torque -= self.dry_torque(mode.direction, velocity, tensions)
            rates[:2] = velocity, torque / link.inertia
            if link.friction is not None and link.friction.state_count:
                rates[self.layout.friction] = link.friction.rates(
                    mode.direction, velocity, self.friction_state(state)
                )
        if self.layout.pulley is not None:
            rates[self.layout.pulley] = pulley.rate
        for side in self.layout.sides:
            if side.mass is not None:
                rates[side.mass : side.mass + 2] = self.mass_rates(side, state, pulley, tensions)
        for i, (tendon, place) in enumerate(self.layout.tendons):
            if place.start < place.stop:
                rates[place] = tendon.rates(mode.tendons[i], reaches[i], state[place])
        return rates

    def mass_rates(
        self, side: Side, state: Vector, pulley: Reach, tensions: list[float]
    ) -> tuple[float, float]:
        """Velocity (m/s) and acceleration (m/s²) of the mass of one side."""
        lumped = self.actuator.springs[SIDES.index(side.sign)].lumped
        assert lumped is not None
        assert side.mass is not None
        velocity = float(state[side.mass + 1])
        ends = 0.5 * side.sign * (pulley.rate + self.joint_travel(state).rate)
        to_motor, to_joint = (tensions[i] for i in side.tendons)
        return velocity, (to_motor - to_joint - lumped.damping * (velocity - ends)) / lumped.mass

    def pulley_imbalance(self, reaches: list[Reach], state: Vector, mode: Mode) -> float:
        """Upper less lower force at the motor pulley without dampers and before cut-off, N.

        The contract lets the pulley float where the springs pull alike, whatever dampers add.
        """
        forces = []
        for side in self.layout.sides:
            number = side.tendons[0]
            tendon, place = self.layout.tendons[number]
            forces.append(
                tendon.pull(mode.tendons[number], reaches[number], state[place], damped=False)
            )
        return forces[0] - forces[1]

    # ---- thresholds ------------------------------------------------------------------------

    def thresholds(self, time: float, state: Vector, mode: Mode) -> list[float]:
        """Numbers that are negative in `mode` and leave it at zero, rising; as many in a mode."""
        reaches = self.reaches(time, state, mode)
        found = [
            value
            for i, (tendon, place) in enumerate(self.layout.tendons)
            for value in tendon.thresholds(mode.tendons[i], reaches[i], state[place])
        ]
        if self.layout.pulley is not None:
            found += self.play_thresholds(time, state, mode, reaches)
        if self.actuator.link.stop is not None:
            found += self.stop_thresholds(state, mode)
        if self.has_direction:
            found += self.motion_thresholds(time, state, mode, reaches)
        return found

    def play_thresholds(
        self, time: float, state: Vector, mode: Mode, reaches: list[Reach]
    ) -> list[float]:
        """Leaving a tooth when the tendons would pull the pulley off, touching one when there."""
        if mode.tooth != 0:
            imbalance = self.pulley_imbalance(reaches, state, mode)
            return [mode.tooth * imbalance - FORCE_HYSTERESIS]
        travel = float(state[self.layout.pulley])
        return [
            tooth * (travel - self.tooth_travel(time, tooth)) - LENGTH_HYSTERESIS
            for tooth in (-1, 1)
        ]

    def stop_thresholds(self, state: Vector, mode: Mode) -> list[float]:
        """Reaching and leaving both stops, and beginning and ceasing to push."""
        stop = self.actuator.link.stop
        assert stop is not None
        position, velocity, found = float(state[0]), float(state[1]), []
        for side, now in zip(SIDES, mode.stops, strict=True):
            found.append(leaving(now.reached, stop.depth(side, position), ANGLE_HYSTERESIS))
            if now.reached and stop.damping > 0.0:
                push = stop.push(side, position, velocity)
                found.append(leaving(now.pushing, push, TORQUE_HYSTERESIS))
            else:
                found.append(NEVER)
        return found

    def motion_thresholds(
        self, time: float, state: Vector, mode: Mode, reaches: list[Reach]
    ) -> list[float]:
        """Coming to rest or turning; breaking away to either side."""
        if mode.direction != 0:
            return [-mode.direction * float(state[1]) - VELOCITY_HYSTERESIS]
        tensions = self.tensions_from(reaches, state, mode)
        torque = self.torque_without_dry_friction(time, state, mode, tensions)
        return [
            direction * (torque - self.dry_torque(direction, 0.0, tensions)) - TORQUE_HYSTERESIS
            for direction in (-1, 1)
        ]

    # ---- changes of mode -------------------------------------------------------------------

    def updated(
        self, time: float, state: Vector, mode: Mode, *, hysteresis: bool = True
    ) -> tuple[Mode, Vector]:
        """Mode and state right after `time`; without `hysteresis` the history does not count."""
        width = 1.0 if hysteresis else 0.0
        for _ in range(MOST_CHANGES):
            before = mode
            mode, state = self.with_tendons(time, state.copy(), mode, width)
            mode, state = self.with_play(time, state, mode)
            mode = self.with_stops(state, mode, width)
            mode, state = self.with_motion(time, state, mode)
            if mode == before:
                return mode, state
        raise RuntimeError(f"truth finds no mode at {time} s")

    def with_tendons(
        self, time: float, state: Vector, mode: Mode, width: float
    ) -> tuple[Mode, Vector]:
        """Slack, kinks and branches of every tendon."""
        reaches, modes = self.reaches(time, state, mode), list(mode.tendons)
        for i, (tendon, place) in enumerate(self.layout.tendons):
            modes[i], state[place] = tendon.updated(modes[i], reaches[i], state[place], width)
        return replace(mode, tendons=tuple(modes)), state

    def with_play(self, time: float, state: Vector, mode: Mode) -> tuple[Mode, Vector]:
        """Tooth at which the pulley lies; it lets go where the tendons pull it off."""
        place = self.layout.pulley
        if place is None:
            return mode, state
        if mode.tooth != 0:
            reaches = self.reaches(time, state, mode)
            state[place] = self.tooth_travel(time, mode.tooth)
            imbalance = mode.tooth * self.pulley_imbalance(reaches, state, mode)
            return (replace(mode, tooth=0) if imbalance > 0.5 * FORCE_HYSTERESIS else mode), state
        for tooth in (-1, 1):
            beyond = tooth * (float(state[place]) - self.tooth_travel(time, tooth))
            if beyond > 0.5 * LENGTH_HYSTERESIS:
                return replace(mode, tooth=tooth), state
        return mode, state

    def with_stops(self, state: Vector, mode: Mode, width: float) -> Mode:
        """Stops reached, and whether they push."""
        stop = self.actuator.link.stop
        if stop is None:
            return mode
        position, velocity, stops = float(state[0]), float(state[1]), list(mode.stops)
        for i, side in enumerate(SIDES):
            depth = stop.depth(side, position)
            reached = relay(stops[i].reached, depth, width * ANGLE_HYSTERESIS)
            pushing = True
            if reached and stop.damping > 0.0:
                push = stop.push(side, position, velocity)
                pushing = relay(stops[i].pushing, push, width * TORQUE_HYSTERESIS)
            stops[i] = StopMode(reached, pushing)
        return replace(mode, stops=(stops[0], stops[1]))

    def with_motion(self, time: float, state: Vector, mode: Mode) -> tuple[Mode, Vector]:
        """Direction of motion; a joint that stops sticks if friction can hold it."""
        if not self.has_direction:
            return mode, state
        if mode.direction != 0 and mode.direction * state[1] > -0.5 * VELOCITY_HYSTERESIS:
            return mode, state
        if not self.sticks:
            return replace(mode, direction=-mode.direction), state
        state[1] = 0.0
        tensions = self.tensions(time, state, mode)
        torque = self.torque_without_dry_friction(time, state, replace(mode, direction=0), tensions)
        for direction in (-1, 1):
            beyond = direction * (torque - self.dry_torque(direction, 0.0, tensions))
            if beyond >= 0.5 * TORQUE_HYSTERESIS:
                return replace(mode, direction=direction), state
        return replace(mode, direction=0), state

    # ---- start -----------------------------------------------------------------------------

    def initial_pulley(self) -> tuple[float, int]:
        """Travel (m) and tooth of the motor pulley at time zero, everything at rest before."""
        joint = self.actuator.joint_pulley_radius * self.experiment.initial_position

        def imbalance(displacement: float) -> float:
            forces = [0.0, 0.0]
            for i, side in enumerate(self.layout.sides):
                tendon = self.layout.tendons[side.tendons[0]][0]
                # a mass, at first in the middle, leaves each half half of the displacement
                length = (side.rest + side.sign * displacement) / len(side.tendons)
                reach = Reach(length, 0.0)
                mode, state = tendon.begin(reach)
                forces[i] = tendon.pull(mode, reach, np.array(state), damped=False)
            return forces[0] - forces[1]

        if self.layout.pulley is None:
            return self.tooth_travel(0.0, 0), 0
        widest = max(side.rest for side in self.layout.sides)
        free = joint + float(brentq(imbalance, -widest, widest, xtol=1e-16))
        low, high = self.tooth_travel(0.0, -1), self.tooth_travel(0.0, 1)
        if free < low:
            return low, -1
        return (high, 1) if free > high else (free, 0)

    def initial(self) -> tuple[Mode, Vector]:
        """Mode and state at time zero; friction states start at zero, springs relaxed."""
        start, layout = self.experiment, self.layout
        state = np.zeros(layout.count)
        state[:2] = start.initial_position, start.initial_velocity
        joint = self.joint_travel(state)
        travel, tooth = self.initial_pulley()
        floats = layout.pulley is not None and tooth == 0
        driven = self.actuator.motor_pulley_radius * self.driven(0.0)[1]
        pulley = Reach(travel, joint.rate if floats else driven)
        if layout.pulley is not None:
            state[layout.pulley] = travel
        for side in layout.sides:
            if side.mass is not None:
                state[side.mass] = 0.5 * side.sign * (travel + joint.length)
                state[side.mass + 1] = 0.5 * side.sign * (pulley.rate + joint.rate)
        modes = []
        for reach, (tendon, place) in zip(
            self.reaches_from(state, pulley), layout.tendons, strict=True
        ):
            mode, state[place] = tendon.begin(reach)
            modes.append(mode)
        if start.initial_velocity != 0.0:
            direction = int(math.copysign(1, start.initial_velocity))
        else:
            direction = 0 if self.sticks else 1
        whole = Mode(tuple(modes), direction, tooth=tooth)
        return self.updated(0.0, state, whole, hysteresis=False)
