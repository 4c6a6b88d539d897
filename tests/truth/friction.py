"""Laws of dry friction at the joint; the solver locates every change of direction and of sticking.

A law says whether it `sticks` (a torque at rest up to `torque` holds the joint), how many states it
`state_count` has, and for a `direction` of motion (-1 or 1) its opposing torque and state rates.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar


@dataclass(frozen=True)
class Coulomb:
    """Constant torque against the motion; sticks while the other torques are not larger."""

    torque: float  # N·m
    sticks: ClassVar[bool] = True
    state_count: ClassVar[int] = 0

    def opposing(self, direction: int, _state: Sequence[float]) -> float:
        """Torque against positive motion, N·m."""
        return self.torque * direction

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

    def opposing(self, _direction: int, state: Sequence[float]) -> float:
        """Torque against positive motion, N·m; `state` is the bristle's deflection z, rad."""
        return self.stiffness * state[0]

    def rates(self, direction: int, velocity: float, state: Sequence[float]) -> list[float]:
        """Rate of the bristle's deflection, rad/s."""
        return [velocity * (1.0 - direction * self.stiffness * state[0] / self.torque)]
