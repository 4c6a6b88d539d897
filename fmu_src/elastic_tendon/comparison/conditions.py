"""Conditions that choose samples: ``slack_state=I``, ``joint_velocity>0``, ``time=3..5``."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastic_tendon.actuator.transmission import SlackState
from elastic_tendon.errors import MeasurementError
from elastic_tendon.measurement.units import factor_of

Array = NDArray[np.float64]
STATE = "slack_state"
STATES = {state.name: state for state in (SlackState.I, SlackState.II, SlackState.III)}
# quantity -> what its unit measures
DIMENSIONS = {
    "time": "time",
    "motor_position": "angle",
    "motor_velocity": "speed",
    "joint_position": "angle",
    "joint_velocity": "speed",
    "deflection": "angle",
    "load_torque": "torque",
    "joint_torque": "torque",
    "motor_torque": "torque",
}
_CONDITION = re.compile(r"\s*(?P<quantity>\w+)\s*(?P<relation>>=|<=|=|>|<)\s*(?P<value>\S.*?)\s*")
_SIZE = re.compile(
    r"\s*(?P<size>[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(?P<unit>(?![\d.]).*?)\s*"
)
_EXAMPLES = "slack_state=I, joint_velocity>0, deflection>=0.1rad or time=3..5"


@dataclass(frozen=True)
class Condition:
    """A quantity (SI) from `low` to `high`; `strict`: without these ends. `text`: as given."""

    text: str
    quantity: str
    low: float
    high: float
    strict: bool = False

    def holds(self, values: Array) -> NDArray[np.bool_]:
        """Where it holds, (n,), for (n,) values of the quantity, SI."""
        if self.strict:
            return np.asarray((values > self.low) & (values < self.high))
        return np.asarray((values >= self.low) & (values <= self.high))


@dataclass(frozen=True)
class Selection:
    """Samples of a recording, `chosen` (n,), for which all `conditions` hold."""

    conditions: tuple[Condition, ...]
    chosen: NDArray[np.bool_]

    @property
    def words(self) -> str:
        """The conditions, and how many samples they hold for."""
        count, n = int(np.count_nonzero(self.chosen)), len(self.chosen)
        return f"{in_words(self.conditions)}: {count} of {n} samples"


def in_words(conditions: Sequence[Condition]) -> str:
    """All conditions, as they were given."""
    return " and ".join(condition.text for condition in conditions)


def parse_condition(text: str) -> Condition:
    """Read a condition.

    Parameters
    ----------
    text : str; a slack state as ``slack_state=I``, a bound as ``joint_velocity>0``, a range with
        its ends as ``time=3..5``; numbers in SI units or with their own, as ``deflection<5deg``

    Raises
    ------
    MeasurementError : it is none, or its unit is none of the quantity
    """
    called = f"condition {text!r}"
    match = _CONDITION.fullmatch(text)
    if match is None:
        raise MeasurementError(f"{called}: write it as {_EXAMPLES}")
    quantity, relation, value = match["quantity"], match["relation"], match["value"]
    if quantity == STATE:
        if relation != "=" or value not in STATES:
            states = ", ".join(f"{STATE}={state}" for state in STATES)
            raise MeasurementError(f"{called}: a slack state is one of {states}")
        return Condition(text.strip(), STATE, float(STATES[value]), float(STATES[value]))
    if quantity not in DIMENSIONS:
        raise MeasurementError(
            f"{called}: there is no quantity {quantity}; take {STATE}, {', '.join(DIMENSIONS)}"
        )
    low, high = _ends(quantity, relation, value, called)
    return Condition(text.strip(), quantity, low, high, strict=relation in ("<", ">"))


def _ends(quantity: str, relation: str, value: str, called: str) -> tuple[float, float]:
    if relation != "=":
        size = _size(value, quantity, called)
        return (size, np.inf) if relation.startswith(">") else (-np.inf, size)
    first, separator, last = value.partition("..")
    if not separator:
        raise MeasurementError(
            f"{called}: a measured value hardly ever equals a number; give a range, as "
            f"{quantity}=3..5, or a bound, as {quantity}>0"
        )
    low, high = (_size(end, quantity, called) for end in (first, last))
    if low > high:
        raise MeasurementError(f"{called}: a range goes from its lower end to its upper end")
    return low, high


def _size(text: str, quantity: str, called: str) -> float:
    match = _SIZE.fullmatch(text)
    if match is None:
        raise MeasurementError(f"{called}: {text!r} is no number; write it as {_EXAMPLES}")
    return float(match["size"]) * factor_of(match["unit"], DIMENSIONS[quantity], quantity, called)


def select(
    conditions: Sequence[Condition], quantities: Mapping[str, Array], recording: str
) -> Selection:
    """Samples for which all conditions hold.

    Parameters
    ----------
    conditions : at least one
    quantities : (n,) arrays by name, SI; those that the recording has
    recording : its name, for messages

    Raises
    ------
    MeasurementError : a condition is on a quantity that the recording does not have
    """
    for condition in conditions:
        if condition.quantity not in quantities:
            raise MeasurementError(
                f"condition {condition.text!r}: {recording} has no {condition.quantity}; it has "
                f"{', '.join(quantities)}"
            )
    held = [condition.holds(quantities[condition.quantity]) for condition in conditions]
    return Selection(tuple(conditions), np.all(held, axis=0))
