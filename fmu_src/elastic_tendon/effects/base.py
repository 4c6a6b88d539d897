"""What an effect declares: data and pure functions, nothing else.

Effects fill *slots* of fixed order along the chain motor -> springs -> joint, so any subset
composes in any listing order. The equations of a slot are a function
``equations(at, p, state, mode)`` where

* ``at`` is the place in the chain: `MotorAngle`, `Spring` or `Joint`;
* ``p``, ``state``, ``mode`` carry the effect's parameters, states and relation modes by name.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import Enum, IntEnum

from elastic_tendon.symbolic import Symbol


class Slot(IntEnum):
    """Places along the chain, in the order in which they act."""

    ANGLE_MAP = 1  # motor position -> angle of the motor pulley; effects act one after the other
    SPRING_LAW = 2  # added force of one spring; used for the upper and the lower spring
    JOINT_TORQUE = 3  # smooth torque added on the joint
    DRY_FRICTION = 4  # torque bounds, summed into the one stick relation of the joint


class Scale(Enum):
    """Characteristic size of the actuator by which a typical magnitude is measured."""

    ONE = "1"
    TORQUE = "maximum joint torque R k l_max"
    STIFFNESS = "stiffness of the softer spring"


@dataclass(frozen=True)
class Parameter:
    """A number of an effect, as it stands in model.toml.

    `null` is the value at which the effect vanishes (or the default, where another parameter
    makes it vanish). `typical` times `scale` is a typical magnitude on a real actuator.
    """

    name: str
    unit: str
    meaning: str
    null: float
    lower: float
    upper: float
    typical: float
    scale: Scale = Scale.ONE


@dataclass(frozen=True)
class State:
    """A continuous state that the effect adds; in a spring's slot one for each spring."""

    name: str
    unit: str
    meaning: str
    nominal: float
    start: float = 0.0


@dataclass(frozen=True)
class Relation:
    """A two-valued mode: 1 where the effect's threshold of the same name is positive, else 0."""

    name: str
    meaning: str


@dataclass(frozen=True)
class MotorAngle:
    """Where an angle map acts: angles at the motor pulley, rad."""

    motor_position: Symbol
    joint_position: Symbol  # joint angle seen at the motor pulley, n_t q


@dataclass(frozen=True)
class Spring:
    """Where a spring law acts: one spring, `elongation` from its rest length (m), rate (m/s)."""

    elongation: Symbol
    rate: Symbol
    stiffness: Symbol
    max_deflection: Symbol


@dataclass(frozen=True)
class Joint:
    """Where joint torques and dry friction act: position (rad), velocity (rad/s)."""

    position: Symbol
    velocity: Symbol


@dataclass(frozen=True)
class Contribution:
    """What an effect adds in its slot.

    `value`: the mapped angle (rad), the force of one spring (N) or the joint torque (N·m).
    `rates`: time derivative of each state. `thresholds`: for each relation the quantity whose
    sign is its mode, divided by its natural scale so that it is of order one.
    """

    value: Symbol
    rates: Mapping[str, Symbol] = field(default_factory=dict)
    thresholds: Mapping[str, Symbol] = field(default_factory=dict)


@dataclass(frozen=True)
class FrictionBounds:
    """Range of dry friction torque on the joint at this velocity, N·m; ``lower <= 0 <= upper``."""

    lower: Symbol
    upper: Symbol


Equations = Callable[..., Contribution | FrictionBounds]  # (at, p, state, mode), see above


@dataclass(frozen=True)
class Effect:
    """One physical effect; see the module's text for the signature of `equations`."""

    id: str
    title: str
    slot: Slot
    physics: str  # what it is
    in_data: str  # how it shows itself in measurements
    parameters: tuple[Parameter, ...]
    equations: Equations
    reference: str
    states: tuple[State, ...] = ()
    relations: tuple[Relation, ...] = ()
