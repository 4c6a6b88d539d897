"""Names, units, bounds and order of everything that crosses the model's border.

Python arrays, the compiled library and the FMU's description take order and names from here.
Nothing here needs CasADi, so a cached library is used without importing it.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from functools import cached_property, lru_cache
from math import inf

from elastic_tendon import effects as catalogue
from elastic_tendon.actuator.parameters import quantities
from elastic_tendon.effects.base import Effect, Slot

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
    """Ordered variables of a structure (a set of effects)."""

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
    def parameter_names(self) -> tuple[str, ...]:
        """Dotted paths of the parameters, in the order in which the library takes them."""
        return tuple(parameter.name for parameter in self.parameters)


INPUTS = (
    Variable("motor_position", "rad", "angle of the motor at the motor pulley"),
    Variable(
        "motor_velocity",
        "rad/s",
        "rate of motor_position; used by spring damping and effects that need the rate",
        nominal=10.0,
    ),
    Variable("load_torque", "N.m", "external torque on the joint, positive with joint_position"),
)

OUTPUTS = (
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
    Variable("joint_position", "rad", "angle of the joint, q", nominal=0.1),
    Variable("joint_velocity", "rad/s", "angular velocity of the joint"),
    Variable("deflection", "rad", "joint position less reflected motor position, paper (11)"),
    Variable(
        "motor_torque",
        "N.m",
        "torque that the motor has to exert on its pulley against the tendons, paper (8)",
        at_motor=True,
    ),
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

_BASE_STATES = OUTPUTS[2:4]  # joint position and velocity are outputs and states alike

SIGNAL_SLOTS = (Slot.MOTOR_SIGNAL, Slot.JOINT_SIGNAL, Slot.SIGNAL_DELAY)
STICTION_SLOTS = (Slot.TENDON_LOSS, Slot.DRY_FRICTION)

JOINT_MOTION = Mode("joint_motion", "sign of the motion; 0 while the joint sticks", 0.0, (-1, 0, 1))


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


def _states(effects: tuple[Effect, ...]) -> tuple[Variable, ...]:
    series = [
        Variable(
            series_elongation(strand), "m", "elongation of one spring", start=None, nominal=1e-2
        )
        for strand in strands(effects)
        if _has(effects, Slot.SERIES_ELEMENT)
    ]
    return (
        *_BASE_STATES,
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


def _modes(effects: tuple[Effect, ...]) -> tuple[Mode, ...]:
    taut = [
        Mode(f"{strand}.taut", f"the {strand[:5]} tendon is taut", 1.0)
        for strand in strands(effects)
    ]
    stretched = [
        Mode(
            *(f"{spring}.overstretched", f"the {spring[:5]} spring exceeds max_deflection", 0.0),
            warns=True,
        )
        for spring in SPRINGS
    ]
    of_effects = [
        Mode(f"{place}.{relation.name}", relation.meaning, 0.0)
        for effect in effects
        for place in places(effect, effects)
        for relation in effect.relations
    ]
    sticks = [JOINT_MOTION] if _has(effects, *STICTION_SLOTS) else []
    return (*taut, *stretched, *of_effects, *sticks)


@lru_cache
def interface(effect_ids: tuple[str, ...]) -> Interface:
    """Variables of the model with these effects.

    Parameters
    ----------
    effect_ids : tuple of catalogue ids, in any order

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
        for quantity in quantities(tuple(effect.id for effect in effects))
    )
    return Interface(
        effects=effects,
        states=_states(effects),
        inputs=INPUTS,
        outputs=OUTPUTS + (READINGS if _has(effects, *SIGNAL_SLOTS) else ()),
        parameters=parameters,
        modes=_modes(effects),
    )
