"""What all sensors of a torque or a force have in common: a gain, and a zero, that may be off.

Each measured quantity has a file for either, with its equations and what only it can say.
"""

from collections.abc import Callable
from typing import Any

from elastic_tendon.effects.base import Effect, Parameter, Sizes, Slot

_REFERENCE = (
    "G. A. Pratt, M. M. Williamson, Series elastic actuators, IEEE/RSJ International Conference on "
    "Intelligent Robots and Systems, 1995"
)


def gain(
    id: str,
    slot: Slot,
    catalogue_order: int,
    equations: Callable[..., Any],
    physics: str,
    confirm: str,
) -> Effect:
    """A sensor that shows more or less than there is."""
    of = _quantity(slot)
    return Effect(
        id=id,
        title=_title(id),
        slot=slot,
        catalogue_order=catalogue_order,
        equations=equations,
        in_data=f"The measured {of} is too large or too small by the same share everywhere: in "
        "every slack state, at every speed and in both directions. Positions agree.",
        law=f"measured {of} = (1 + error) times the true one",
        confused_with=f"{_title(id.removesuffix('gain') + 'offset')}: it is as large where there "
        f"is little {of}. A wrong stiffness of the springs: it changes the motion of the joint "
        "too.",
        cure="Calibrate the sensor with known loads over its range; put that into the scale of the "
        f"column (--map {of.replace(' ', '_')}=COLUMN:UNIT*FACTOR).",
        magnitude="0.1 to 1 % of a calibrated load cell, 5 to 30 % where a gain, a lever arm or a "
        "torque constant is of a data sheet.",
        parameters=(
            Parameter(
                name="error",
                unit="1",
                meaning=f"share by which the {of} is measured too large",
                null=0.0,
                lower=-0.9,
                upper=10.0,
                typical=0.1,
            ),
        ),
        reference=_REFERENCE,
        physics=physics,
        confirm=confirm,
    )


def offset(
    id: str,
    slot: Slot,
    catalogue_order: int,
    equations: Callable[..., Any],
    physics: str,
    confirm: str,
    beside: str = "",
) -> Effect:
    """A sensor whose zero is off; `beside` : what else it is confused with."""
    of = _quantity(slot)
    of_torque = of.endswith("torque")
    return Effect(
        id=id,
        title=_title(id),
        slot=slot,
        catalogue_order=catalogue_order,
        equations=equations,
        in_data=f"The measured {of} is off by a constant: in every slack state, at every speed and "
        "in both directions. Positions agree.",
        law=f"measured {of} = the true one + offset",
        confused_with=f"{_title(id.removesuffix('offset') + 'gain')}: its error vanishes where "
        f"there is no {of}.{beside}",
        cure="Set the sensor's zero when it is warm and nothing pulls at it; take it off the "
        f"column (--map {of.replace(' ', '_')}=COLUMN:UNIT+OFFSET, with the negative offset).",
        magnitude="0.1 to 2 % of the range of the sensor; it drifts while amplifiers warm up.",
        parameters=(
            Parameter(
                name="offset",
                unit="N.m" if of_torque else "N",
                meaning=f"what is measured as {of} where there is none",
                null=0.0,
                lower=-1.0e5,
                upper=1.0e5,
                typical=_share_of_torque if of_torque else _share_of_force,
                of_recording=True,
            ),
        ),
        reference=_REFERENCE,
        physics=physics,
        confirm=confirm,
    )


def _title(id: str) -> str:
    return id.replace("_", " ").capitalize()


def _quantity(slot: Slot) -> str:
    """What is measured, in words."""
    return {
        Slot.JOINT_TORQUE_SIGNAL: "joint torque",
        Slot.MOTOR_TORQUE_SIGNAL: "motor torque",
        Slot.UPPER_FORCE_SIGNAL: "upper spring force",
        Slot.LOWER_FORCE_SIGNAL: "lower spring force",
    }[slot]


def _share_of_torque(sizes: Sizes) -> float:
    return 0.02 * sizes.torque


def _share_of_force(sizes: Sizes) -> float:
    return 0.02 * sizes.parallel * sizes.force
