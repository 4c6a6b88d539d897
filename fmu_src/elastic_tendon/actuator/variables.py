"""Names, units, bounds and order of everything that crosses the model's border.

Python arrays, the compiled library and the FMU's description take order and names from here.
Nothing here needs CasADi, so a cached library is used without importing it.
"""

from collections.abc import Container, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from functools import cached_property
from math import inf

from elastic_tendon import effects as catalogue
from elastic_tendon.actuator.interfaces import InterfaceKind
from elastic_tendon.actuator.motion_kind import MotionKind
from elastic_tendon.actuator.parameters import quantities
from elastic_tendon.actuator.quantity import unit_text
from elastic_tendon.effects.base import Effect, Slot
from elastic_tendon.effects.registry import kept_by_ids

SPRINGS = ("upper_spring", "lower_spring")


class Kind(Enum):
    """Type of a variable as FMI sees it; inside, all are stored as double."""

    REAL = "Real"
    INTEGER = "Integer"
    BOOLEAN = "Boolean"
    SLACK_STATE = "Enumeration"


@dataclass(frozen=True)
class Variable:
    """One named number: unit as in FMI (``N.m``, ``rad/s``), bounds inclusive.

    `start` None: calculated, from the numbers that have one. `at_motor`: a signal measured at the
    motor, not at the joint. `tunable`: a parameter that may change while the model runs.
    """

    name: str
    unit: str
    meaning: str
    kind: Kind = Kind.REAL
    start: float | None = 0.0
    nominal: float = 1.0
    lower: float = -inf
    upper: float = inf
    at_motor: bool = False
    tunable: bool = False

    @property
    def discrete(self) -> bool:
        """Whether it changes at events only."""
        return self.kind is not Kind.REAL


@dataclass(frozen=True)
class Mode:
    """Value of a relation, frozen between events: 0 or 1, or -1, 0, 1 for the sign of a motion.

    `warns`: the user is told when it becomes 1, for the machine would suffer.
    """

    name: str
    meaning: str
    start: float
    values: tuple[int, ...] = (0, 1)
    warns: bool = False

    @property
    def indicators(self) -> int:
        """Number of event indicators: one for each border between neighbouring values."""
        return len(self.values) - 1


@dataclass(frozen=True)
class Interface:
    """Ordered variables of a structure: an interface with a set of effects."""

    kind: InterfaceKind
    effects: tuple[Effect, ...]
    states: tuple[Variable, ...]
    inputs: tuple[Variable, ...]
    outputs: tuple[Variable, ...]
    parameters: tuple[Variable, ...]
    modes: tuple[Mode, ...]

    @cached_property
    def reads_signals(self) -> bool:
        """Whether an effect acts on measured signals, which then are outputs of their own.

        The library then takes one more parameter, after all others: 1 where the motor position
        given is what the encoder reads and delays are exact (comparison), 0 where it is true.
        """
        return _has(self.effects, *SIGNAL_SLOTS)

    @cached_property
    def state_names(self) -> tuple[str, ...]:
        """Names of the states, in the order of the columns of simulated states."""
        return tuple(state.name for state in self.states)

    @cached_property
    def output_names(self) -> tuple[str, ...]:
        """Names of the outputs, in the order of the columns of simulated outputs."""
        return tuple(output.name for output in self.outputs)

    @cached_property
    def input_names(self) -> tuple[str, ...]:
        """Names of the inputs, in the order in which the library takes them."""
        return tuple(variable.name for variable in self.inputs)

    @cached_property
    def parameter_names(self) -> tuple[str, ...]:
        """Dotted paths of the parameters, in the order in which the library takes them."""
        return tuple(parameter.name for parameter in self.parameters)


MOTOR_POSITION = Variable("motor_position", "rad", "angle of the motor at the motor pulley")
MOTOR_VELOCITY = Variable(
    "motor_velocity",
    "rad/s",
    "rate of motor_position; used by spring damping and effects that need the rate",
    nominal=10.0,
)
LOAD_TORQUE = Variable(
    "load_torque", "N.m", "external torque on the joint, positive with joint_position"
)
JOINT_POSITION = Variable("joint_position", "rad", "angle of the joint, q", nominal=0.1)
JOINT_VELOCITY = Variable("joint_velocity", "rad/s", "angular velocity of the joint")
MOTOR_TORQUE = Variable(
    "motor_torque",
    "N.m",
    "torque that the motor has to exert on its pulley against the tendons, paper (8)",
    at_motor=True,
)
HOLDING_TORQUE = replace(
    LOAD_TORQUE,
    meaning="torque that holds the joint against the tendons from outside, -joint_torque",
)
DRIVING_TORQUE = replace(
    MOTOR_TORQUE, meaning="torque that the motor exerts on its rotor, counted at the motor pulley"
)
INPUTS = (MOTOR_POSITION, MOTOR_VELOCITY, LOAD_TORQUE)  # of InterfaceKind.POSITION
# inputs that are the rate of another one: the position by the velocity's name
POSITION_OF = {"motor_velocity": "motor_position", "joint_velocity": "joint_position"}

OUTPUTS = (  # of InterfaceKind.POSITION
    Variable("joint_torque", "N.m", "torque of the tendons on the joint, paper (7)"),
    Variable(
        "slack_state",
        "1",
        "which tendon is slack: 1 lower (I), 2 upper (II), 3 none (III), 4 both; paper Fig. 4",
        Kind.SLACK_STATE,
        start=3.0,
        lower=1.0,
        upper=4.0,
    ),
    JOINT_POSITION,
    JOINT_VELOCITY,
    Variable("deflection", "rad", "joint position less reflected motor position, paper (11)"),
    MOTOR_TORQUE,
    Variable("upper_spring_force", "N", "tension of the upper tendon", nominal=100.0, lower=0.0),
    Variable("lower_spring_force", "N", "tension of the lower tendon", nominal=100.0, lower=0.0),
    Variable(
        "overstretched",
        "1",
        "a spring is stretched beyond max_deflection, paper (15)",
        Kind.BOOLEAN,
        lower=0.0,
        upper=1.0,
    ),
)

READINGS = (
    Variable(
        "measured_joint_position",
        "rad",
        "what the joint encoder reads; a delay T is applied as q - T q', off by no more than "
        "T^2/2 times the largest joint acceleration",
        nominal=0.1,
    ),
    Variable("measured_motor_position", "rad", "what the motor encoder reads", at_motor=True),
)

# what is measured of torques and forces, where an effect makes it other than the true one: slot of
# such effects -> the output, and what is read of it
FORCE_READINGS = {
    slot: (name, Variable(f"measured_{name}", unit, f"what is measured as {name}", at_motor=motor))
    for slot, name, unit, motor in (
        (Slot.JOINT_TORQUE_SIGNAL, "joint_torque", "N.m", False),
        (Slot.MOTOR_TORQUE_SIGNAL, "motor_torque", "N.m", True),
        (Slot.UPPER_FORCE_SIGNAL, "upper_spring_force", "N", False),
        (Slot.LOWER_FORCE_SIGNAL, "lower_spring_force", "N", False),
    )
}

# rotor and link, whose position and velocity are outputs and states alike
_ROTOR = (
    replace(MOTOR_POSITION, at_motor=True),
    replace(MOTOR_VELOCITY, at_motor=True, meaning="rate of motor_position"),
)
_LINK = (JOINT_POSITION, JOINT_VELOCITY)

# everything that is measured, driven or computed at some interface, by name
SIGNALS = {
    variable.name: variable
    for variable in (
        *(*INPUTS, *_ROTOR, *OUTPUTS, *READINGS),
        *(reading for _, reading in FORCE_READINGS.values()),
    )
}


def with_unit(signal: str, value: float, motion: MotionKind) -> str:
    """A value of a signal with its SI unit, as "0.0113 rad"; of a machine that slides in m."""
    return f"{value:.4g} {unit_text(motion.unit(SIGNALS[signal].unit))}"


SIGNAL_SLOTS = (
    Slot.MOTOR_SIGNAL,
    Slot.JOINT_SIGNAL,
    Slot.DEFLECTION_SIGNAL,
    Slot.SIGNAL_DELAY,
)
STICTION_SLOTS = (Slot.TENDON_LOSS, Slot.DRY_FRICTION)

JOINT_MOTION = Mode("joint_motion", "sign of the motion; 0 while the joint sticks", 0.0, (-1, 0, 1))
MOTOR_MOTION = Mode("motor_motion", "sign of the motion; 0 while the motor sticks", 0.0, (-1, 0, 1))


@dataclass(frozen=True)
class Body:
    """What a torque moves: names of that, of its states and of the mode in which it sticks, paths
    of its inertia and its damping."""

    position: str
    velocity: str
    motion: str
    inertia: str
    damping: str
    torque: str


LINK = Body(
    *("joint_position", "joint_velocity", JOINT_MOTION.name),
    *("link.inertia", "link.damping", LOAD_TORQUE.name),
)
ROTOR = Body(
    *("motor_position", "motor_velocity", MOTOR_MOTION.name),
    *("motor.inertia", "motor.damping", DRIVING_TORQUE.name),
)


def catalogue_order(effect_ids: Sequence[str]) -> tuple[Effect, ...]:
    """Effects of the given ids in the catalogue's order, whatever the order of listing."""
    return tuple(effect for effect in catalogue.BY_ID.values() if effect.id in effect_ids)


def _has(effects: tuple[Effect, ...], *slots: Slot) -> bool:
    return any(effect.slot in slots for effect in effects)


def motor_half(spring: str) -> str:
    """Name of the half at the motor of a spring with a mass; the other has the spring's name."""
    return f"{spring}.motor_half"


def strands(effects: tuple[Effect, ...]) -> tuple[str, ...]:
    """Names of all pieces that pull: the springs, and with masses between, both their halves."""
    halves = SPRINGS if _has(effects, Slot.SPRING_MASS) else ()
    return (*SPRINGS, *(motor_half(spring) for spring in halves))


def series_elongation(strand: str) -> str:
    """Name of the state of a damped spring in series with a compliance."""
    return f"{strand}.elongation"


def places(effect: Effect, effects: tuple[Effect, ...]) -> tuple[str, ...]:
    """Prefixes of the effect's states and modes, one for each place where it acts."""
    if effect.slot is Slot.SPRING_LAW:
        return tuple(f"{strand}.{effect.id}" for strand in strands(effects))
    if effect.slot in (Slot.SERIES_ELEMENT, Slot.SPRING_MASS):
        return tuple(f"{spring}.{effect.id}" for spring in SPRINGS)
    return (effect.id,)


def _inputs(kind: InterfaceKind) -> tuple[Variable, ...]:
    if not kind.has_springs:
        return (LOAD_TORQUE,)
    at_motor = (DRIVING_TORQUE,) if kind.has_rotor else (MOTOR_POSITION, MOTOR_VELOCITY)
    return (*at_motor, *((LOAD_TORQUE,) if kind.has_link else _LINK))


def _outputs(kind: InterfaceKind, effects: tuple[Effect, ...]) -> tuple[Variable, ...]:
    """Outputs in the order of `OUTPUTS`, what is moved in place of the link; no input is one."""
    torque_and_slack, rest = OUTPUTS[:2], OUTPUTS[4:]
    read = _has(effects, *SIGNAL_SLOTS)
    if not kind.has_springs:
        return (*_LINK, *(reading for reading in READINGS if read and not reading.at_motor))
    return (
        *torque_and_slack,
        *_moved(kind),
        *(output for output in rest if not (kind.has_rotor and output is MOTOR_TORQUE)),
        *(() if kind.has_link else (HOLDING_TORQUE,)),
        *(reading for reading in READINGS if read and (kind.has_link or reading.at_motor)),
        *(reading for slot, (_, reading) in FORCE_READINGS.items() if _has(effects, slot)),
    )


def _moved(kind: InterfaceKind) -> tuple[Variable, ...]:
    """States of link and rotor."""
    return (*(_LINK if kind.has_link else ()), *(_ROTOR if kind.has_rotor else ()))


def moved_states(kind: InterfaceKind) -> tuple[str, ...]:
    """Names of position and velocity of what is moved: the link, the rotor, both or nothing."""
    return tuple(state.name for state in _moved(kind))


def _states(kind: InterfaceKind, effects: tuple[Effect, ...]) -> tuple[Variable, ...]:
    series = [
        Variable(
            series_elongation(strand), "m", "elongation of one spring", start=None, nominal=1e-2
        )
        for strand in strands(effects)
        if _has(effects, Slot.SERIES_ELEMENT)
    ]
    return (
        *_moved(kind),
        *series,
        *(s for effect in effects for s in _effect_states(effect, effects)),
    )


def _effect_states(effect: Effect, effects: tuple[Effect, ...]) -> tuple[Variable, ...]:
    return tuple(
        Variable(
            f"{place}.{state.name}",
            state.unit,
            state.meaning,
            start=state.start,
            nominal=state.nominal,
        )
        for place in places(effect, effects)
        for state in effect.states
    )


def _modes(kind: InterfaceKind, effects: tuple[Effect, ...]) -> tuple[Mode, ...]:
    of_effects = [
        Mode(f"{place}.{relation.name}", relation.meaning, 0.0)
        for effect in effects
        for place in places(effect, effects)
        for relation in effect.relations
    ]
    sticks = [JOINT_MOTION] if _has(effects, *STICTION_SLOTS) else []
    sticks += [MOTOR_MOTION] if _has(effects, Slot.MOTOR_FRICTION) else []
    of_springs = _spring_modes(effects) if kind.has_springs else ()
    return (*of_springs, *of_effects, *sticks)


def _spring_modes(effects: tuple[Effect, ...]) -> tuple[Mode, ...]:
    taut = [
        Mode(f"{strand}.taut", f"the {strand[:5]} tendon is taut", 1.0)
        for strand in strands(effects)
    ]
    memory = any(effect.slot is Slot.SPRING_LAW and effect.states for effect in effects)
    spans = [
        Mode(f"{strand}.spans", f"the {strand[:5]} spring spans its slack tendon", 0.0)
        for strand in strands(effects)
        if memory
    ]
    stretched = [
        Mode(
            *(f"{spring}.overstretched", f"the {spring[:5]} spring exceeds max_deflection", 0.0),
            warns=True,
        )
        for spring in SPRINGS
    ]
    return (*taut, *spans, *stretched)


@kept_by_ids
def interface(
    effect_ids: tuple[str, ...], kind: InterfaceKind = InterfaceKind.POSITION
) -> Interface:
    """Variables of the model with these effects.

    Parameters
    ----------
    effect_ids : tuple of catalogue ids, in any order
    kind : what is given and what is computed

    Returns
    -------
    Interface
    """
    effects = catalogue_order(effect_ids)
    parameters = tuple(
        Variable(
            quantity.path,
            quantity.unit,
            quantity.meaning,
            Kind.INTEGER if quantity.integer else Kind.REAL,
            quantity.default,
            quantity.nominal,
            quantity.lower,
            quantity.upper,
            tunable=quantity.tunable,
        )
        for quantity in quantities(tuple(effect.id for effect in effects), kind)
    )
    return Interface(
        kind=kind,
        effects=effects,
        states=_states(kind, effects),
        inputs=_inputs(kind),
        outputs=_outputs(kind, effects),
        parameters=parameters,
        modes=_modes(kind, effects),
    )


def reading_of(signal: str, output_names: Container[str]) -> str:
    """Name of the output that shows what the sensor of a signal reads, among those there are: its
    own, where an effect makes that other than the true value."""
    reading = f"measured_{signal}"
    return reading if reading in output_names else signal
