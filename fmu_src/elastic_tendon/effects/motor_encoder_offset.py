"""A motor encoder whose zero is not the motor's."""

from types import SimpleNamespace

from elastic_tendon.effects.base import Contribution, Effect, Parameter, Signal, Slot


def equations(
    _at: Signal, p: SimpleNamespace, _state: SimpleNamespace, _mode: SimpleNamespace
) -> Contribution:
    """The encoder reads the motor position plus `offset`."""
    return Contribution(p.offset)


EFFECT = Effect(
    id="motor_encoder_offset",
    title="Motor encoder offset",
    slot=Slot.MOTOR_SIGNAL,
    catalogue_order=170,
    physics="The motor's zero was set where both tendons do not pull alike: the true motor "
    "position is the measured one less the offset.",
    in_data="The joint rests beside where the motor says it should, by offset r / R, the same at "
    "every angle, speed, direction and load. The whole motion is shifted, and the slack boundaries "
    "over the measured deflection with it.",
    law="true motor position = measured one - offset",
    confused_with="Joint encoder offset: only what depends on the angle itself, as gravity, a stop "
    "or an eccentric pulley, distinguishes the two. Motor encoder gain: no error where the motor "
    "is at zero. Gear backlash under a load that never changes sign: it shifts the joint by half "
    "the gap. Gravity load: its error is larger where a tendon is slack. Pulley eccentricity: "
    "alike over a small part of a turn of the motor, but not constant over the whole.",
    confirm="Fix the link at its true zero with a pin and turn the motor until both springs are as "
    "long as at rest (equal springs: until both tendons sound alike when plucked). What the motor "
    "encoder reads there is the offset.",
    cure="Set the motor's zero with the link on its pin, and again whenever a tendon was "
    "tensioned. In a recording subtract it: --map motor_position=column+offset takes the negative "
    "offset.",
    magnitude="0.005 to 0.05 rad at the motor pulley. Tensioning one of two equal springs by 0.5 "
    "mm shifts it by 0.5 mm / (2 r), 0.008 rad at r = 30 mm.",
    parameters=(
        Parameter(
            name="offset",
            unit="rad",
            meaning="reading less true motor position, at the motor pulley",
            null=0.0,
            lower=-7.0,
            upper=7.0,
            typical=0.01,
            of_recording=True,
        ),
    ),
    equations=equations,
    reference="J. M. Hollerbach, C. W. Wampler, The calibration index and taxonomy for robot "
    "kinematic calibration methods, International Journal of Robotics Research 15(6), 1996",
)
