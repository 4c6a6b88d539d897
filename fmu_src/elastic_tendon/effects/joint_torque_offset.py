"""A sensor of the joint torque whose zero is off."""

from types import SimpleNamespace

from elastic_tendon.effects.base import Contribution, Signal, Slot
from elastic_tendon.effects.readings import offset


def equations(
    _at: Signal, p: SimpleNamespace, _state: SimpleNamespace, _mode: SimpleNamespace
) -> Contribution:
    """What the sensor shows beyond the torque."""
    return Contribution(p.offset)


EFFECT = offset(
    id="joint_torque_offset",
    slot=Slot.JOINT_TORQUE_SIGNAL,
    catalogue_order=352,
    equations=equations,
    beside=" Constant torque: it moves the joint, and the measured torque only where that "
    "deflects the springs.",
    physics="The torque sensor at the joint was not zeroed, or was zeroed under a load, such as "
    "the weight of the link.",
    confirm="Let the joint come to rest without load from both sides: the mean of the two "
    "readings is the offset.",
)
