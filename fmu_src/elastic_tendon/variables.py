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
from elastic_tendon.effects.base import Effect, Slot
from elastic_tendon.parameters import quantities

SPRINGS = ("upper_spring", "lower_spring")


class Kind(Enum):
    """Type of a variable as FMI sees it; inside, all are stored as double."""

    REAL = "Real"
    INTEGER = "Integer"
    BOOLEAN = "Boolean"
    SLACK_STATE = "Enumeration"


@dataclass(frozen=True)
class Variable:
    """One named number: unit as in FMI (``N.m``, ``rad/s``), bounds inclusive."""

    name: str
    unit: str
    meaning: str
    kind: Kind = Kind.REAL
    start: float = 0.0
    nominal: float = 1.0
    lower: float = -inf
    upper: float = inf

    @property
    def discrete(self) -> bool:
        """Whether it changes at events only."""
        return self.kind is not Kind.REAL


@dataclass(frozen=True)
class Mode:
    """Value of a relation, frozen between events: 0 or 1, or -1, 0, 1 for the sign of a motion."""

    name: str
    meaning: str
    start: float
    values: tuple[int, ...] = (0, 1)

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
    Variable("joint_torque", "N.m", "torque of the tendons on the joint, (7)"),
    Variable(
        "slack_state",
        "1",
        "which tendon is slack: I lower, II upper, III none, or both (Fig. 4)",
        Kind.SLACK_STATE,
        start=3.0,
        lower=1.0,
        upper=4.0,
    ),
    Variable("joint_position", "rad", "angle of the joint, q", nominal=0.1),
    Variable("joint_velocity", "rad/s", "angular velocity of the joint"),
    Variable("deflection", "rad", "joint position less reflected motor position, (11)"),
    Variable("motor_torque", "N.m", "torque of the tendons on the motor pulley, (8)"),
    Variable("upper_spring_force", "N", "tension of the upper tendon", nominal=100.0),
    Variable("lower_spring_force", "N", "tension of the lower tendon", nominal=100.0),
    Variable(
        "overstretched",
        "1",
        "a spring is stretched beyond max_deflection, (15)",
        Kind.BOOLEAN,
        lower=0.0,
        upper=1.0,
    ),
)

_BASE_STATES = OUTPUTS[2:4]  # joint position and velocity are outputs and states alike

JOINT_MOTION = Mode("joint_motion", "sign of the motion; 0 while the joint sticks", 0.0, (-1, 0, 1))


def catalogue_order(effect_ids: Sequence[str]) -> tuple[Effect, ...]:
    """Effects of the given ids in the catalogue's order, whatever the order of listing."""
    return tuple(effect for effect in catalogue.BY_ID.values() if effect.id in effect_ids)


def places(effect: Effect) -> tuple[str, ...]:
    """Prefixes of the effect's states and modes: one for each spring where it acts on springs."""
    if effect.slot is Slot.SPRING_LAW:
        return tuple(f"{spring}.{effect.id}" for spring in SPRINGS)
    return (effect.id,)


def _effect_states(effect: Effect) -> tuple[Variable, ...]:
    return tuple(
        Variable(
            f"{place}.{state.name}",
            state.unit,
            state.meaning,
            start=state.start,
            nominal=state.nominal,
        )
        for place in places(effect)
        for state in effect.states
    )


def _modes(effects: tuple[Effect, ...]) -> tuple[Mode, ...]:
    taut = [Mode(f"{spring}.taut", f"the {spring[:5]} tendon is taut", 1.0) for spring in SPRINGS]
    stretched = [
        Mode(f"{spring}.overstretched", f"the {spring[:5]} spring exceeds max_deflection", 0.0)
        for spring in SPRINGS
    ]
    of_effects = [
        Mode(f"{place}.{relation.name}", relation.meaning, 0.0)
        for effect in effects
        for place in places(effect)
        for relation in effect.relations
    ]
    sticks = any(effect.slot is Slot.DRY_FRICTION for effect in effects)
    return (*taut, *stretched, *of_effects, *([JOINT_MOTION] if sticks else []))


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
        )
        for quantity in quantities(tuple(effect.id for effect in effects))
    )
    return Interface(
        effects=effects,
        states=_BASE_STATES + tuple(s for effect in effects for s in _effect_states(effect)),
        inputs=INPUTS,
        outputs=OUTPUTS,
        parameters=parameters,
        modes=_modes(effects),
    )
