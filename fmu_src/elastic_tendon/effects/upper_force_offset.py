"""A load cell in the upper tendon whose zero is off."""

from types import SimpleNamespace

from elastic_tendon.effects.base import Contribution, Signal, Slot
from elastic_tendon.effects.readings import offset


def equations(
    _at: Signal, p: SimpleNamespace, _state: SimpleNamespace, _mode: SimpleNamespace
) -> Contribution:
    """What the sensor shows beyond the force."""
    return Contribution(p.offset)


EFFECT = offset(
    id="upper_force_offset",
    slot=Slot.UPPER_FORCE_SIGNAL,
    catalogue_order=372,
    equations=equations,
    physics="The load cell in the upper tendon was zeroed while the tendon was pretensioned, or "
    "not at all.",
    confirm="Turn the motor until this tendon is slack: what the load cell reads then is the "
    "offset.",
)
