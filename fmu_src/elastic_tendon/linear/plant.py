"""What a linearisation needs of an actuator, be it equations or an FMU."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple, Protocol

from elastic_tendon.actuator.motion_kind import MotionKind
from elastic_tendon.actuator.sections import Transmission
from elastic_tendon.actuator.transmission import SlackState
from elastic_tendon.linear.result import Array


class Jacobians(NamedTuple):
    """Derivatives of rates and outputs by states and inputs: A, B, C, D."""

    A: Array
    B: Array
    C: Array
    D: Array


@dataclass(frozen=True)
class Regime:
    """Modes that are held while rates and derivatives are taken.

    `modes` by name; `slack_state` follows from them. `reached_at`: states and inputs at which they
    are active, by which an FMU is brought into them.
    """

    slack_state: SlackState
    modes: Mapping[str, int]
    reached_at: tuple[Array, Array]


class Plant(Protocol):
    """States x (n,), inputs u (3,): motor_position, motor_velocity, load_torque; outputs y (m,).

    The first two states are joint_position and joint_velocity. `nominal` (n,) are sizes of the
    states, `transmission` the paper's numbers, `motion` whether the actuator turns or slides.
    """

    name: str
    motion: MotionKind
    transmission: Transmission
    states: tuple[str, ...]
    outputs: tuple[str, ...]
    nominal: Array

    def start(self, u: Array, joint_position: float) -> Array:
        """States at rest from which an equilibrium is sought."""
        ...

    def settle(self, x: Array, u: Array) -> Regime:
        """The regime that is active at a point."""
        ...

    def sliding(self, regime: Regime, direction: int) -> Regime:
        """The regime with dry friction of the joint sliding: 1 up, -1 down; 0: sticking."""
        ...

    def rates(self, x: Array, u: Array, regime: Regime) -> Array:
        """Time derivatives (n,) of the states, the regime held."""
        ...

    def output(self, x: Array, u: Array, regime: Regime) -> Array:
        """Outputs (m,), the regime held."""
        ...

    def jacobians(self, x: Array, u: Array, regime: Regime) -> Jacobians:
        """Derivatives, the regime held."""
        ...
