"""A motor torque that is off by a constant."""

from types import SimpleNamespace

from elastic_tendon.effects.base import Contribution, Effect, Motor, Parameter, Slot


def equations(
    _at: Motor, p: SimpleNamespace, _state: SimpleNamespace, _mode: SimpleNamespace
) -> Contribution:
    """What the motor exerts beyond the torque that is given."""
    return Contribution(p.offset)


EFFECT = Effect(
    id="motor_torque_offset",
    title="Motor torque offset",
    slot=Slot.MOTOR_TORQUE,
    catalogue_order=340,
    physics="The current sensor or the amplifier has a zero that is off, so that the motor exerts "
    "a small torque where none is said.",
    in_data="The motor drifts to one side, or holds its place with a torque that is not zero "
    "without load; the error is the same at every angle, speed and torque and in every slack "
    "state.",
    law="offset",
    confused_with="Motor friction: it changes its sign with the direction. Motor cogging: its mean "
    "over a turn is zero.",
    confirm="Without load and at rest, let the motor hold its place and come to it from both "
    "sides: the mean of the two torques is the offset.",
    cure="Set the zero of the amplifier when it is warm; take the mean at rest off the column "
    "(--remove-offset).",
    magnitude="0.5 to 2 % of the rated torque; it drifts as the amplifier warms up.",
    parameters=(
        Parameter(
            name="offset",
            unit="N.m",
            meaning="torque of the motor, at its pulley, where none is given",
            null=0.0,
            lower=-1.0e4,
            upper=1.0e4,
            typical=lambda sizes: 0.02 * sizes.torque,
            of_recording=True,
        ),
    ),
    equations=equations,
    reference="J. Swevers, W. Verdonck, J. De Schutter, Dynamic model identification for "
    "industrial robots, IEEE Control Systems Magazine 27(5), 2007",
)
