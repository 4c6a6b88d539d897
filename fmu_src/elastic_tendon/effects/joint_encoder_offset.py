"""A joint encoder whose zero is not the joint's."""

from types import SimpleNamespace

from elastic_tendon.effects.base import Alias, Contribution, Effect, Parameter, Signal, Slot


def equations(
    _at: Signal, p: SimpleNamespace, _state: SimpleNamespace, _mode: SimpleNamespace
) -> Contribution:
    """The encoder reads the joint position plus `offset`."""
    return Contribution(p.offset)


EFFECT = Effect(
    id="joint_encoder_offset",
    title="Joint encoder offset",
    slot=Slot.JOINT_SIGNAL,
    catalogue_order=160,
    physics="The joint encoder was mounted or zeroed a little beside the joint's true zero.",
    in_data="A constant error of the joint's position in every motion, at every speed, direction "
    "and load. Load torque against deflection is shifted along the deflection, and both slack "
    "boundaries with it.",
    law="measured joint position = q + offset",
    confused_with="Motor encoder offset: only what depends on the angle itself, as gravity, a stop "
    "or an eccentric pulley, distinguishes the two. Joint encoder gain: no error where the joint "
    "is at zero. Gravity load, constant torque: an error at rest too, but larger where a tendon is "
    "slack. Pulley eccentricity: alike over a small part of a turn of the motor, but not constant "
    "over the whole.",
    confirm="Without load let the joint come to rest from both sides, several times: the mean of "
    "joint position less r / R times motor position is the offset of the two encoders together. A "
    "pin or a spirit level that fixes the link at a known angle tells which of the two is wrong.",
    cure="Zero the encoder against a pin or jig and keep the number in the drive. In a recording "
    "subtract it: --map joint_position=column+offset takes the negative offset.",
    magnitude="Zeroed by eye 0.01 to 0.03 rad, against a pin 0.001 rad. Incremental encoders "
    "without an index lose their zero whenever power fails.",
    parameters=(
        Parameter(
            name="offset",
            unit="rad",
            meaning="reading less true joint position",
            null=0.0,
            lower=-7.0,
            upper=7.0,
            typical=0.01,
            of_recording=True,
        ),
    ),
    equations=equations,
    reference="B. W. Mooring, Z. S. Roth, M. R. Driels, Fundamentals of Manipulator Calibration, "
    "Wiley, 1991",
    aliases=(
        Alias(
            of=("motor_encoder_offset",),
            when="nothing depends on the angle itself, as gravity, stops and eccentricity do",
        ),
    ),
)
