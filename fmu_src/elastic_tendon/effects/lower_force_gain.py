"""A load cell in the lower tendon that shows more or less than there is."""

from types import SimpleNamespace

from elastic_tendon.effects.base import Contribution, Signal, Slot
from elastic_tendon.effects.readings import gain


def equations(
    at: Signal, p: SimpleNamespace, _state: SimpleNamespace, _mode: SimpleNamespace
) -> Contribution:
    """What the sensor shows beyond the force."""
    return Contribution(p.error * at.value)


EFFECT = gain(
    id="lower_force_gain",
    slot=Slot.LOWER_FORCE_SIGNAL,
    catalogue_order=380,
    equations=equations,
    physics="The load cell in the lower tendon, or between its spring and the frame, has another "
    "scale than the data sheet says, or the tendon does not pull straight at it.",
    confirm="Take the tendon off and hang known masses on the load cell: the slope of its reading "
    "over their weight is the gain.",
)
