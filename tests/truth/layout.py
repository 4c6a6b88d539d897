"""Where in the state of a system each of its parts stands."""

from dataclasses import dataclass

from truth.actuator import Actuator
from truth.tendon import Tendon

SIDES = (1, -1)  # upper, lower: sign with which pulley travel stretches the spring


@dataclass(frozen=True)
class Side:
    """A tendon from pulley to pulley: one piece, or two with a mass between them.

    `tendons` are numbers into `Layout.tendons`, from the motor to the joint; `mass` is the place
    of the mass's position in the state, its velocity follows.
    """

    sign: int
    rest: float  # m
    tendons: tuple[int, ...]
    mass: int | None


@dataclass(frozen=True)
class Layout:
    """State: joint position (rad) and velocity, friction, pulley travel (m), masses, tendons."""

    friction: slice
    pulley: int | None
    sides: tuple[Side, Side]
    tendons: tuple[tuple[Tendon, slice], ...]
    scales: tuple[float, ...]  # ordinary size of each state

    @property
    def count(self) -> int:
        """Number of states."""
        return len(self.scales)


def layout_of(actuator: Actuator) -> Layout:
    """Layout of the state of an actuator."""
    scales = [1.0, 1.0]
    friction = actuator.link.friction
    scales += [1.0] * (0 if friction is None else friction.state_count)
    friction_places = slice(2, len(scales))
    pulley = len(scales) if actuator.gap > 0.0 else None
    scales += [] if pulley is None else [0.01]
    pieces: list[tuple[Tendon, slice]] = []
    sides: list[Side] = []
    assert (actuator.upper.lumped is None) == (actuator.lower.lumped is None), "one mass of two"
    for sign, spring in zip(SIDES, actuator.springs, strict=True):
        mass = len(scales) if spring.lumped is not None else None
        if mass is not None:
            scales += [0.01, 1.0]
        numbers = []
        for part in [spring] if mass is None else [spring.half()] * 2:
            tendon = Tendon(part)
            numbers.append(len(pieces))
            pieces.append((tendon, slice(len(scales), len(scales) + len(tendon.scales))))
            scales += tendon.scales
        sides.append(Side(sign, actuator.rest_length(spring), tuple(numbers), mass))
    return Layout(friction_places, pulley, (sides[0], sides[1]), tuple(pieces), tuple(scales))
