"""What users call slack states, and units of the signals of a linear model."""

from functools import cache

from elastic_tendon.effects import BY_ID
from elastic_tendon.linear.drive import MOTOR_TORQUE, SHIFTED
from elastic_tendon.transmission import SlackState
from elastic_tendon.variables import INPUTS, OUTPUTS, READINGS, Interface, interface


def state_name(state: SlackState) -> str:
    """Name of a slack state as `linearise` takes it: "I", "II", "III" or "both"."""
    return "both" if state is SlackState.BOTH else state.name


def unit_of(name: str) -> str | None:
    """Unit of a state, an input or an output; None of an effect that is not loaded."""
    return _units(tuple(BY_ID)).get(name.removesuffix(SHIFTED))


def all_effects() -> Interface:
    """States and modes of all effects that are loaded, whether or not they go together."""
    return interface(tuple(BY_ID))


@cache
def _units(effect_ids: tuple[str, ...]) -> dict[str, str]:
    signals = (*interface(effect_ids).states, *INPUTS, *OUTPUTS, *READINGS)
    units = {one.name: one.unit for one in signals}
    return units | {"motor_drive_torque": units[MOTOR_TORQUE]}
