"""Laws of dry friction at the joint; the solver locates every change of direction and of sticking.

A law says whether it `sticks` (its opposing torques at velocity 0 are then the bounds within which
it holds the joint), how many states it `state_count` has, and for a `direction` of motion (-1 or 1)
its opposing torque and state rates.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, Protocol


class Friction(Protocol):
    """A law of friction; `state` is its part of the state."""

    sticks: ClassVar[bool]
    state_count: ClassVar[int]

    def opposing(self, direction: int, velocity: float, state: Sequence[float]) -> float:
        """Torque against positive motion, N·m."""

    def rates(self, direction: int, velocity: float, state: Sequence[float]) -> list[float]:
        """Time derivative of the state."""


@dataclass(frozen=True)
class Coulomb:
    """Constant torque against the motion; sticks while the other torques are not larger."""

    torque: float  # N·m
    sticks: ClassVar[bool] = True
    state_count: ClassVar[int] = 0

    def opposing(self, direction: int, _velocity: float, _state: Sequence[float]) -> float:
        """See `Friction`."""
        return self.torque * direction

    def rates(self, _direction: int, _velocity: float, _state: Sequence[float]) -> list[float]:
        """No states, no rates."""
        return []


def stribeck_torque(coulomb: float, static: float, velocity: float, scale: float) -> float:
    """Torque of steady sliding, N·m: falls from `static` to `coulomb` within `scale` (rad/s)."""
    return coulomb + (static - coulomb) * math.exp(-((velocity / scale) ** 2))


@dataclass(frozen=True)
class Stribeck:
    """Sticks up to the static torque; sliding, falls towards the Coulomb torque with velocity."""

    coulomb_torque: float  # N·m
    static_torque: float  # N·m
    stribeck_velocity: float  # rad/s
    sticks: ClassVar[bool] = True
    state_count: ClassVar[int] = 0

    def opposing(self, direction: int, velocity: float, _state: Sequence[float]) -> float:
        """See `Friction`."""
        return direction * stribeck_torque(
            self.coulomb_torque, self.static_torque, velocity, self.stribeck_velocity
        )

    def rates(self, _direction: int, _velocity: float, _state: Sequence[float]) -> list[float]:
        """No states, no rates."""
        return []


@dataclass(frozen=True)
class HessSoom:
    """Stribeck's curve as Hess and Soom write it: the excess falls as 1 / (1 + (v / v_s)²)."""

    coulomb_torque: float  # N·m
    static_torque: float  # N·m
    stribeck_velocity: float  # v_s, rad/s
    sticks: ClassVar[bool] = True
    state_count: ClassVar[int] = 0

    def opposing(self, direction: int, velocity: float, _state: Sequence[float]) -> float:
        """See `Friction`."""
        excess = self.static_torque - self.coulomb_torque
        share = 1.0 / (1.0 + (velocity / self.stribeck_velocity) ** 2)
        return direction * (self.coulomb_torque + excess * share)

    def rates(self, _direction: int, _velocity: float, _state: Sequence[float]) -> list[float]:
        """No states, no rates."""
        return []


@dataclass(frozen=True)
class Dahl:
    """Dahl's law: a bristle of torsional `stiffness` that yields smoothly towards `torque`.

    z' = v - |v| σ z / T with the torque σ z against the motion; it creeps and never sticks.
    For σ to infinity it is Coulomb friction.
    """

    torque: float  # T, N·m
    stiffness: float  # σ, N·m/rad
    sticks: ClassVar[bool] = False
    state_count: ClassVar[int] = 1

    def opposing(self, _direction: int, _velocity: float, state: Sequence[float]) -> float:
        """See `Friction`; the state is the bristle's deflection z, rad."""
        return self.stiffness * state[0]

    def rates(self, direction: int, velocity: float, state: Sequence[float]) -> list[float]:
        """Rate of the bristle's deflection, rad/s."""
        return [velocity * (1.0 - direction * self.stiffness * state[0] / self.torque)]


@dataclass(frozen=True)
class LuGre:
    """LuGre: bristles whose tips slip at the Stribeck torque g(v); never sticks.

    Written for the bristles' torque b = σ_0 z: b' = σ_0 v (1 - sgn(v) b / g(v)), torque
    b + (σ_1 / σ_0) b'. For stiff bristles it is `Stribeck`.
    """

    coulomb_torque: float  # N·m
    static_torque: float  # N·m
    stribeck_velocity: float  # rad/s
    stiffness: float  # σ_0, N·m/rad
    damping: float  # σ_1, N·m s/rad
    sticks: ClassVar[bool] = False
    state_count: ClassVar[int] = 1

    def opposing(self, direction: int, velocity: float, state: Sequence[float]) -> float:
        """See `Friction`."""
        (rate,) = self.rates(direction, velocity, state)
        return state[0] + self.damping / self.stiffness * rate

    def rates(self, direction: int, velocity: float, state: Sequence[float]) -> list[float]:
        """Rate of the bristles' torque, N·m/s."""
        slipping = stribeck_torque(
            self.coulomb_torque, self.static_torque, velocity, self.stribeck_velocity
        )
        return [self.stiffness * velocity * (1.0 - direction * state[0] / slipping)]


def guide_loss(wrap: float, direction: int, upper: float, lower: float) -> float:
    """Tension lost at the guides between tendons and joint, N, against positive motion.

    By the capstan equation a guide with μ φ = `wrap` passes on F exp(-w) of a tension against
    which its tendon moves and F exp(w) of one with which it does. Of the sum and the difference of
    both tensions, friction takes (F_1 + F_2) sinh w in the direction of motion and adds
    (F_1 - F_2) (cosh w - 1) to the difference.

    Parameters
    ----------
    direction : of the joint, -1 or 1
    upper, lower : tensions between spring and guide, N
    """
    # cosh w - 1 without cancellation
    gain = 2.0 * math.sinh(0.5 * wrap) ** 2
    return direction * (upper + lower) * math.sinh(wrap) - (upper - lower) * gain
