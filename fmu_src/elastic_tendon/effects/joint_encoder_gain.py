"""A joint encoder that shows more or less than the joint turns."""

from types import SimpleNamespace

from elastic_tendon.effects.base import Alias, Contribution, Effect, Parameter, Signal, Slot


def equations(
    at: Signal, p: SimpleNamespace, _state: SimpleNamespace, _mode: SimpleNamespace
) -> Contribution:
    """What the encoder shows beyond the joint position; its offset is not enlarged with it."""
    return Contribution(p.error * at.value)


EFFECT = Effect(
    id="joint_encoder_gain",
    title="Joint encoder gain",
    slot=Slot.JOINT_SIGNAL,
    catalogue_order=162,
    on_request=True,
    physics="The joint is read by a potentiometer whose scale is not what the data sheet says, or "
    "by an encoder behind a belt or a gear of another ratio, or with other counts a turn, than was "
    "set: it shows more or less than the joint turns.",
    in_data="The joint's position is too large or too small by the same share at every speed, in "
    "every slack state and in both directions: right at zero, and most wrong at the ends of the "
    "range. Without load the joint seems to turn by more or less than r / R of the motor.",
    law="measured joint position = (1 + error) q, then plus the encoder's offset",
    confused_with="Motor encoder gain: alike, by a share of the other sign, but for what a load "
    "deflects, as far as stiffness and inertia are known. Joint encoder offset: it is as large "
    "where the joint is at zero. A wrong radius of the joint pulley: alike beside another "
    "stiffness and inertia. A wrong inertia (link.inertia): alike where there are no springs and "
    "the load alone moves the link.",
    confirm="Turn the link between two angles that a jig or a spirit level tells, as far apart as "
    "it can, and compare the difference of the readings with that of the angles.",
    cure="Calibrate the encoder at two known angles, or correct its ratio and counts in the drive; "
    "put the gain into the scale of the column (--map joint_position=COLUMN:rad*FACTOR).",
    magnitude="None for an encoder on the joint's own shaft, which counts exactly; 1 to 5 % for a "
    "potentiometer, 1 to 3 % for the pitch radius of a belt, and any ratio where a number of teeth "
    "or counts is wrong.",
    parameters=(
        Parameter(
            name="error",
            unit="1",
            meaning="share by which the reading of the joint position is too large",
            null=0.0,
            lower=-0.9,
            upper=10.0,
            typical=0.02,
        ),
    ),
    equations=equations,
    reference="B. W. Mooring, Z. S. Roth, M. R. Driels, Fundamentals of Manipulator Calibration, "
    "Wiley, 1991",
    aliases=(
        Alias(
            of=("motor_encoder_gain",),
            when="stiffness and damping of springs and inertia and damping of the link are not "
            "known, and nothing depends on the angle itself, as gravity, stops and eccentricity "
            "do: with each of them 1 + error times as small, the motor's error is -error / "
            "(1 + error)",
        ),
    ),
)
