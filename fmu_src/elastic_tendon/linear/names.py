"""What users call slack states, and units of the signals of a linear model."""

from elastic_tendon.actuator.transmission import SlackState
from elastic_tendon.actuator.variables import SIGNALS, Interface, interface
from elastic_tendon.effects import BY_ID
from elastic_tendon.effects.registry import kept_by_ids
from elastic_tendon.errors import LinearisationError
from elastic_tendon.linear.drive import DRIVE_TORQUE, MOTOR_TORQUE, SHIFTED

_STATES = {"I": SlackState.I, "II": SlackState.II, "III": SlackState.III, "both": SlackState.BOTH}


def slack_state(name: SlackState | str) -> SlackState:
    """The slack state of a name, "I", "II", "III" or "both".

    Raises
    ------
    LinearisationError
        for another name
    """
    if isinstance(name, SlackState):
        return name
    if name not in _STATES:
        raise LinearisationError(f"there is no slack state {name!r}; choose {', '.join(_STATES)}")
    return _STATES[name]


def state_name(state: SlackState) -> str:
    """Name of a slack state as `slack_state` takes it."""
    return next(name for name, known in _STATES.items() if known is state)


def unit_of(name: str) -> str | None:
    """Unit of a state, an input or an output; None of an effect that is not loaded."""
    return _units(tuple(BY_ID)).get(name.removesuffix(SHIFTED))


def all_effects() -> Interface:
    """States and modes of all effects that are loaded, whether or not they go together."""
    return interface(tuple(BY_ID))


@kept_by_ids
def _units(effect_ids: tuple[str, ...]) -> dict[str, str]:
    signals = (*interface(effect_ids).states, *SIGNALS.values())
    units = {signal.name: signal.unit for signal in signals}
    return units | {DRIVE_TORQUE: units[MOTOR_TORQUE]}
