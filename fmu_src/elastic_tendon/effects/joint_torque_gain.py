"""A sensor of the joint torque that shows more or less than there is."""

from types import SimpleNamespace

from elastic_tendon.effects.base import Contribution, Signal, Slot
from elastic_tendon.effects.readings import gain


def equations(
    at: Signal, p: SimpleNamespace, _state: SimpleNamespace, _mode: SimpleNamespace
) -> Contribution:
    """What the sensor shows beyond the torque."""
    return Contribution(p.error * at.value)


EFFECT = gain(
    id="joint_torque_gain",
    slot=Slot.JOINT_TORQUE_SIGNAL,
    catalogue_order=350,
    equations=equations,
    physics="The torque sensor at the joint, or a load cell at a known lever arm, has another "
    "scale than the data sheet says, or another arm than was measured.",
    confirm="Hold the motor, hang known masses on the link at a known arm and plot the reading "
    "over their torque: its slope is the gain.",
)
