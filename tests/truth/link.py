"""What the actuator moves: the link, and the torques that its surroundings exert on it."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field

from truth.friction import Friction


def no_torque(_time: float, _position: float, _velocity: float) -> float:
    """Torque on the joint of nothing, N·m."""
    return 0.0


@dataclass(frozen=True)
class Gravity:
    """The link's weight, of potential energy -torque cos(q + angle)."""

    torque: float  # N·m, with the link horizontal
    angle: float = 0.0  # rad, of the link at q = 0 from hanging straight down

    def torque_at(self, position: float) -> float:
        """Torque on the joint, N·m."""
        return -self.torque * math.sin(position + self.angle)


@dataclass(frozen=True)
class StopMode:
    """Whether an end stop is reached, and whether it pushes (a damped one never pulls)."""

    reached: bool = False
    pushing: bool = True


@dataclass(frozen=True)
class Stop:
    """End stops, springs and dampers that push the joint back while it is beyond `lower`, `upper`.

    For a `side`, 1 the upper and -1 the lower, depth is how far the joint is beyond it.
    """

    lower: float  # rad
    upper: float  # rad
    stiffness: float  # N·m/rad
    damping: float = 0.0  # N·m s/rad

    def depth(self, side: int, position: float) -> float:
        """How far the joint is beyond the stop, rad; negative before it."""
        return side * (position - (self.upper if side > 0 else self.lower))

    def push(self, side: int, position: float, velocity: float) -> float:
        """Torque with which the stop would push the joint back, N·m; negative if it pulled."""
        return self.stiffness * self.depth(side, position) + self.damping * side * velocity


@dataclass(frozen=True)
class Link:
    """J q'' = jτ_e + τ_load - b q' - c q' |q'| + T + gravity + stops + extra - friction.

    Damping b is `damping` and half its `damping_difference` more forwards, as much less backwards.
    """

    inertia: float  # kg m²
    damping: float = 0.0  # N m s/rad
    friction: Friction | None = None
    # further torque on the joint, N·m, of time (s), position (rad) and velocity (rad/s); smooth
    extra_torque: Callable[[float, float, float], float] = field(default=no_torque)
    drag: float = 0.0  # c, N·m s²/rad²
    cubic_damping: float = 0.0  # N·m s³/rad³
    damping_difference: float = 0.0  # N m s/rad
    constant_torque: float = 0.0  # T, N·m
    gravity: Gravity | None = None
    stop: Stop | None = None
