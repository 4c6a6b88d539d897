"""A reading of the motor's torque whose zero is off."""

from types import SimpleNamespace

from elastic_tendon.effects.base import Contribution, Signal, Slot
from elastic_tendon.effects.readings import offset


def equations(
    _at: Signal, p: SimpleNamespace, _state: SimpleNamespace, _mode: SimpleNamespace
) -> Contribution:
    """What the sensor shows beyond the torque."""
    return Contribution(p.offset)


EFFECT = offset(
    id="motor_reading_offset",
    slot=Slot.MOTOR_TORQUE_SIGNAL,
    catalogue_order=362,
    equations=equations,
    physics="The amplifier that measures the motor's current has a zero that is off.",
    confirm="Without load let the motor come to its place from both sides: the mean of the two "
    "readings is the offset.",
)
