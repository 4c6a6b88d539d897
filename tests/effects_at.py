"""Effects of the catalogue by the interfaces at which they act."""

from elastic_tendon.actuator.interfaces import InterfaceKind
from elastic_tendon.actuator.parameters import Model
from elastic_tendon.actuator.variables import FORCE_READINGS
from elastic_tendon.effects import BY_ID, CATALOGUE
from elastic_tendon.effects.base import Effect, Slot

# where the motor's position is given; the others act on a rotor
AT_POSITION = tuple(effect for effect in CATALOGUE if InterfaceKind.POSITION.has_slot(effect.slot))
IDS_AT_POSITION = tuple(effect.id for effect in AT_POSITION)


def loaded_at_position() -> tuple[str, ...]:
    """Ids of these and of what other tests have loaded."""
    position = InterfaceKind.POSITION
    return tuple(effect.id for effect in BY_ID.values() if position.has_slot(effect.slot))


# of what measures something beside the positions of joint and motor
SENSORS = (
    *(Slot.DEFLECTION_SIGNAL, Slot.JOINT_TORQUE_SIGNAL, Slot.MOTOR_TORQUE_SIGNAL),
    *(Slot.UPPER_FORCE_SIGNAL, Slot.LOWER_FORCE_SIGNAL),
)


def seen_in_positions() -> tuple[str, ...]:
    """Those of `loaded_at_position` that show where only motor and joint position are measured."""
    return tuple(name for name in loaded_at_position() if BY_ID[name].slot not in SENSORS)


def searched_in_positions() -> tuple[str, ...]:
    """Those of them that a search tries unasked."""
    return tuple(name for name in seen_in_positions() if not BY_ID[name].on_request)


def shown_in(effect: Effect) -> str:
    """The signal in which an effect shows itself: the joint's position, or what its sensor
    measures."""
    return FORCE_READINGS.get(effect.slot, ("joint_position",))[0]


def placed(model: Model, effect: Effect | str) -> Model:
    """The model, with a rotor that a torque drives where the effect acts on that."""
    slot = (BY_ID[effect] if isinstance(effect, str) else effect).slot
    return model if model.kind.has_slot(slot) else model.at(InterfaceKind.TORQUE)
