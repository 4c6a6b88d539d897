"""A reading of the motor's torque that shows more or less than there is."""

from types import SimpleNamespace

from elastic_tendon.effects.base import Contribution, Signal, Slot
from elastic_tendon.effects.readings import gain


def equations(
    at: Signal, p: SimpleNamespace, _state: SimpleNamespace, _mode: SimpleNamespace
) -> Contribution:
    """What the sensor shows beyond the torque."""
    return Contribution(p.error * at.value)


EFFECT = gain(
    id="motor_reading_gain",
    slot=Slot.MOTOR_TORQUE_SIGNAL,
    catalogue_order=360,
    equations=equations,
    physics="The torque of the motor is read from its current, by a constant, a gear ratio and an "
    "efficiency of which one is not what the data sheet says.",
    confirm="Hold the joint against a force gauge, let the motor pull at it slowly both ways, and "
    "plot what is read over the force, as the mean of both: its slope is the gain.",
)
