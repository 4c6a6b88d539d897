"""What an effect declares: data and pure functions, nothing else.

Effects fill *slots* of fixed order along the chain motor -> springs -> joint, so any subset
composes in any listing order. The equations of a slot are a function
``equations(at, p, state, mode)`` where

* ``at`` is the place in the chain, a class of this module, see `Slot`;
* ``p``, ``state``, ``mode`` carry the effect's parameters, states and relation modes by name.

It returns a `Contribution`, whose ``value`` means what `Slot` says, or for friction
`FrictionBounds` and for a spring's mass `HalfTensions`. It is called once with symbols, so it
chooses with `symbolic.where`, never with ``if``.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import Enum, IntEnum
from math import sqrt

from elastic_tendon.effects.symbolic import Symbol


class Slot(IntEnum):
    """Places along the chain, in the order in which they act; effects of a slot add up."""

    MOTOR_SIGNAL = 1  # Signal -> error of the motor encoder, rad
    ANGLE_MAP = 2  # MotorAngle -> angle of the motor pulley, rad; one effect after the other
    SERIES_ELEMENT = 3  # Tendon -> compliance in series with the springs of a side, m/N
    SPRING_LAW = 4  # Spring -> added force of one spring, N
    SPRING_MASS = 5  # SpringHalves -> HalfTensions; one effect at most
    TENDON_LOSS = 6  # JointPulley -> FrictionBounds of what is lost between tendon and joint
    JOINT_TORQUE = 7  # Joint -> smooth torque added on the joint, N·m
    DRY_FRICTION = 8  # Joint -> FrictionBounds, with the losses one stick relation of the joint
    JOINT_SIGNAL = 9  # Signal -> error of the joint encoder, rad
    SIGNAL_DELAY = 10  # None -> delay of the signals measured at the joint, s
    DEFLECTION_SIGNAL = 13  # Signal -> error of the deflection sensor, rad
    JOINT_TORQUE_SIGNAL = 14  # Signal -> error of the measured joint torque, N·m
    MOTOR_TORQUE_SIGNAL = 15  # Signal -> error of the motor torque, where it is measured, N·m
    UPPER_FORCE_SIGNAL = 16  # Signal -> error of the measured force of the upper tendon, N
    LOWER_FORCE_SIGNAL = 17  # Signal -> error of that of the lower tendon, N
    MOTOR_TORQUE = 11  # Motor -> smooth torque added on the rotor, N·m
    MOTOR_FRICTION = 12  # Motor -> FrictionBounds, one stick relation of the rotor


@dataclass(frozen=True)
class Sizes:
    """Characteristic sizes of an actuator, by which typical magnitudes are measured."""

    torque: float  # largest torque on the joint, R k l_max, N·m
    stiffness: float  # of one of the softer springs, N/m
    max_deflection: float  # of the shorter spring, m
    joint_stiffness: float  # of the joint with both tendons taut, (25), N·m/rad
    inertia: float  # of the link, kg·m²
    radius: float  # of the joint pulley, m
    parallel: int  # springs side by side

    @property
    def force(self) -> float:
        """Force of one spring at its largest deflection, N."""
        return self.stiffness * self.max_deflection

    @property
    def frequency(self) -> float:
        """Natural angular frequency of the joint with both tendons taut, rad/s."""
        return sqrt(self.joint_stiffness / self.inertia)


class Spread(Enum):
    """Over what a search for a shape spreads its first tries."""

    TYPICAL = "multiples of the typical magnitude"
    NULL = "the null alone, from which a fit finds the rest"
    TURN = "a whole turn"
    ELONGATION = "the elongations that the springs reach, as shares of the largest"
    JOINT_RANGE = "the ends of the range of the joint, the lower one where the null is below 0"


@dataclass(frozen=True)
class Parameter:
    """A number of an effect, as it stands in model.toml.

    `null` is the value at which the effect vanishes (or the default, where another parameter
    makes it vanish). `typical` is a typical magnitude on a real actuator, in `unit`. `shape` marks
    a number that says where or how fast the effect acts; the others are its strength, and grow
    together. Strengths may change while the machine runs, shapes may not. `spread`: where a search
    for a shape begins. `of_recording`: a zero or a load that may change from one recording to the
    next, and is estimated for each. `at_frequency`: of a number that sets at which angular
    frequency, rad/s, the effect swings: its value for that.
    """

    name: str
    unit: str
    meaning: str
    null: float
    lower: float
    upper: float
    typical: float | Callable[[Sizes], float]
    shape: bool = False
    spread: Spread = Spread.TYPICAL
    of_recording: bool = False
    at_frequency: Callable[[Sizes, float], float] | None = None

    def typical_for(self, sizes: Sizes) -> float:
        """Typical magnitude on an actuator of these sizes, in `unit`."""
        return self.typical(sizes) if callable(self.typical) else self.typical


@dataclass(frozen=True)
class State:
    """A continuous state that the effect adds; in a spring's slot one for each spring.

    `start` None: the effect's equations give it, in `Contribution.starts`.
    """

    name: str
    unit: str
    meaning: str
    nominal: float
    start: float | None = 0.0


@dataclass(frozen=True)
class Relation:
    """A two-valued mode: 1 where the effect's threshold of the same name is positive, else 0."""

    name: str
    meaning: str


@dataclass(frozen=True)
class Alias:
    """What no measurement of the joint can distinguish the effect from, while `when` holds.

    Said by one of two effects; `Registry.aliases_of` tells it of both.

    `of` are ids of effects or dotted paths of model.toml.
    """

    of: tuple[str, ...]
    when: str


# ---- places --------------------------------------------------------------------------------


@dataclass(frozen=True)
class Signal:
    """Where a sensor reads: the true value, in the unit of what is measured."""

    value: Symbol


@dataclass(frozen=True)
class Motor:
    """Where the rotor is moved: position (rad), velocity (rad/s), torques on it (N·m).

    `torque` : that is given; in the slot of friction with what the slot before it adds. `load` :
    of the tendons, which against the motor's torque is negative. All count at the motor pulley.
    """

    position: Symbol
    velocity: Symbol
    torque: Symbol
    load: Symbol


@dataclass(frozen=True)
class MotorAngle:
    """Where an angle map acts: angles at the motor pulley, rad."""

    motor_position: Symbol
    free_position: Symbol  # at which both tendons pull the pulley alike


@dataclass(frozen=True)
class Tendon:
    """Where a series element acts: the tendon of one side."""

    stiffness: Symbol  # of its springs together, N/m


@dataclass(frozen=True)
class Spring:
    """Where a spring law acts: one spring, `elongation` from its rest length (m), rate (m/s);
    `sign` is 1 of the upper tendon and -1 of the lower.

    The law's value and state rates must be affine in `rate`, given the modes. A slack spring
    sees the elongation at which it carries no force, not what the kinematics would ask of it.
    """

    elongation: Symbol
    rate: Symbol
    stiffness: Symbol
    max_deflection: Symbol
    sign: float


@dataclass(frozen=True)
class SpringHalves:
    """Where a spring's mass acts: between its halves.

    Positions (m) and rates (m/s) along the tendon, towards the motor. `motor_half` and
    `joint_half` give the tension (N, of all parallel springs, never negative) of a half whose
    inner end has the given position and rate.
    """

    motor_end: Symbol
    motor_rate: Symbol
    joint_end: Symbol
    joint_rate: Symbol
    parallel: Symbol
    motor_half: Callable[[Symbol, Symbol], Symbol]
    joint_half: Callable[[Symbol, Symbol], Symbol]


@dataclass(frozen=True)
class JointPulley:
    """Where tendons lose force to the joint pulley and guides: tensions (N), radius (m)."""

    upper_tension: Symbol
    lower_tension: Symbol
    radius: Symbol


@dataclass(frozen=True)
class Joint:
    """Where joint torques and dry friction act: position (rad), velocity (rad/s)."""

    position: Symbol
    velocity: Symbol


# ---- what equations return -----------------------------------------------------------------


@dataclass(frozen=True)
class Contribution:
    """What an effect adds in its slot.

    `value`: what `Slot` says. `rates`: time derivative of each state. `starts`: the states
    that do not start from a constant. `thresholds`: for each relation the quantity whose
    sign is its mode, divided by its natural scale so that it is of order one.
    """

    value: Symbol
    rates: Mapping[str, Symbol] = field(default_factory=dict)
    starts: Mapping[str, Symbol] = field(default_factory=dict)
    thresholds: Mapping[str, Symbol] = field(default_factory=dict)


@dataclass(frozen=True)
class FrictionBounds:
    """Range of dry friction torque at this velocity, N·m; ``lower <= 0 <= upper``.

    `thresholds`: as of `Contribution`, where the bounds have a corner.
    """

    lower: Symbol
    upper: Symbol
    thresholds: Mapping[str, Symbol] = field(default_factory=dict)


@dataclass(frozen=True)
class HalfTensions:
    """Tensions at the two ends of a spring with a mass, N; rates and starts of its states."""

    motor: Symbol
    joint: Symbol
    rates: Mapping[str, Symbol]
    starts: Mapping[str, Symbol] = field(default_factory=dict)


Answer = Contribution | FrictionBounds | HalfTensions
Equations = Callable[..., Answer]  # (at, p, state, mode), see above
Check = Callable[[Mapping[str, float]], str]  # numbers by name -> a sentence, "" where all is well


# what the letters in `Effect.law` stand for
LAW_SYMBOLS = (
    "In the laws q and v are position and velocity of the joint, θ is the angle of the motor, τ "
    "the torque that it is given, e the elongation of one spring, a prime means a time derivative, "
    "and names are those of the effect's parameters."
)


def _all_well(_numbers: Mapping[str, float]) -> str:
    return ""


@dataclass(frozen=True)
class Effect:
    """One physical effect; see the module's text for the signature of `equations`.

    Texts are sentences. `law_of`: of what the effect is the whole law; a model takes one law of
    each. `limit`: id of the simpler effect that it comes to where it varies little.
    `singular_null`: at its null the effect is structurally absent, so its derivative
    there says nothing. `smallest_share`: of the typical strength, where such an effect, or a stop,
    is still sought. `on_request`: a rare one, which a search tries only where it is asked for,
    or where all others leave much; unless `common_without_slack`, where springs push too, as a
    shaft does. `catalogue_order`: effects of the catalogue are listed, and act within a slot, by it
    and then by id; the more common come first. `refuses` and `cautions` judge the numbers of
    model.toml together.
    """

    id: str
    title: str
    slot: Slot
    physics: str  # what it is
    in_data: str  # how it shows itself in measurements
    parameters: tuple[Parameter, ...]
    equations: Equations
    reference: str
    law: str = ""  # the equations as a formula, see LAW_SYMBOLS
    confused_with: str = ""  # what else looks like it, and what distinguishes them
    confirm: str = ""  # how to make sure on the machine
    cure: str = ""  # how to be rid of it
    magnitude: str = ""  # what is typical, and on what it depends
    states: tuple[State, ...] = ()
    relations: tuple[Relation, ...] = ()
    law_of: str = ""
    limit: str = ""
    aliases: tuple[Alias, ...] = ()
    catalogue_order: int = 1000
    singular_null: bool = False
    smallest_share: float = 0.03
    on_request: bool = False
    common_without_slack: bool = False
    refuses: Check = _all_well
    cautions: Check = _all_well

    @property
    def signed(self) -> bool:
        """Whether it may be there with either sign, and grows in proportion from nothing."""
        strengths = [parameter for parameter in self.parameters if not parameter.shape]
        return not self.singular_null and all(part.lower < part.null for part in strengths)

    @property
    def of_recording(self) -> bool:
        """Whether it is a zero or a load that may change from one recording to the next."""
        return any(parameter.of_recording for parameter in self.parameters)

    @property
    def strength(self) -> Parameter:
        """The parameter that tells how much of the effect there is: the first that is no shape."""
        return next(parameter for parameter in self.parameters if not parameter.shape)
