"""Which side of the actuator is given and which is computed.

The motor's side is its position, or its torque, which then moves the rotor. The joint's side is
the load torque, which moves the link, or the joint's position, where another simulator has the
link. A link without springs has no motor's side: interface load.
"""

from enum import StrEnum

from elastic_tendon.effects.base import Slot

_OF_ROTOR = (Slot.MOTOR_TORQUE, Slot.MOTOR_FRICTION)
_OF_LINK = (Slot.TENDON_LOSS, Slot.JOINT_TORQUE, Slot.DRY_FRICTION, Slot.SIGNAL_DELAY)
_WITHOUT_SPRINGS = (Slot.JOINT_TORQUE, Slot.DRY_FRICTION, Slot.JOINT_SIGNAL, Slot.SIGNAL_DELAY)


class InterfaceKind(StrEnum):
    """Value of ``interface.kind`` in model.toml."""

    POSITION = "position"
    TORQUE = "torque"
    JOINT = "joint"
    TORQUE_JOINT = "torque_joint"
    LOAD = "load"

    @property
    def has_springs(self) -> bool:
        """Whether springs connect the joint with a motor; else the load alone moves the link."""
        return self is not InterfaceKind.LOAD

    @property
    def has_link(self) -> bool:
        """Whether the link is integrated, moved by the load torque."""
        return self in (InterfaceKind.POSITION, InterfaceKind.TORQUE, InterfaceKind.LOAD)

    @property
    def has_rotor(self) -> bool:
        """Whether the motor's rotor is integrated, moved by the motor torque."""
        return self in (InterfaceKind.TORQUE, InterfaceKind.TORQUE_JOINT)

    def has_slot(self, slot: Slot) -> bool:
        """Whether effects of a slot have something to act on."""
        if not self.has_springs:
            return slot in _WITHOUT_SPRINGS
        if self.has_rotor and slot is Slot.MOTOR_TORQUE_SIGNAL:  # it is given
            return False
        return (self.has_rotor or slot not in _OF_ROTOR) and (self.has_link or slot not in _OF_LINK)

    def has_quantity(self, path: str) -> bool:
        """Whether the equations use the number at a dotted path of model.toml."""
        section = path.partition(".")[0]
        if not self.has_springs:
            return section not in ("transmission", "motor")
        return (self.has_rotor or section != "motor") and (self.has_link or section != "link")


# at which a recording is compared as it stands: of springs, and of none
AS_RECORDED = (InterfaceKind.POSITION, InterfaceKind.LOAD)

WITH_SPRINGS = tuple(kind for kind in InterfaceKind if kind.has_springs)


def kinds_with(slot: Slot) -> tuple[InterfaceKind, ...]:
    """Kinds of interface, of models with springs, at which effects of a slot can act."""
    return tuple(kind for kind in WITH_SPRINGS if kind.has_slot(slot))
