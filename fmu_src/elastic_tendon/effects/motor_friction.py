"""Dry friction of the motor and its gear, with true sticking."""

from types import SimpleNamespace

from elastic_tendon.effects.base import Effect, FrictionBounds, Motor, Parameter, Slot


def equations(
    _at: Motor, p: SimpleNamespace, _state: SimpleNamespace, _mode: SimpleNamespace
) -> FrictionBounds:
    """Friction torque opposes motion with `torque`, and holds up to `torque` at rest."""
    return FrictionBounds(lower=-p.torque, upper=p.torque)


EFFECT = Effect(
    id="motor_friction",
    title="Motor friction",
    slot=Slot.MOTOR_FRICTION,
    catalogue_order=310,
    physics="Dry friction of the motor's bearings, brushes, seals and gear: a torque of constant "
    "size against the motion of the rotor, which holds it still while the other torques stay "
    "below it. What grows with the speed is motor.damping.",
    in_data="A part of the motor torque that changes its sign with the motor's velocity and with "
    "nothing else, the same in every slack state: motor torque over motor velocity has a step at "
    "zero. Small torques do not move the motor at all; after a motion it stays where it is, with "
    "the springs loaded.",
    law="-torque sgn(θ') while the motor moves; at rest what balances the other torques, up to "
    "±torque",
    confused_with="Motor torque gain: its error grows with the torque. Motor torque offset: it is "
    "the same in both directions. Motor cogging: it repeats over the motor's angle. Viscous "
    "damping of the motor (motor.damping): it grows with the speed. Gear loss: it grows with the "
    "torque that the motor bears. Motor stiction: it falls with the speed.",
    confirm="Take the tendons off or let the joint hang free, raise the motor torque slowly until "
    "the motor moves, in both directions and at several angles: half the difference is the "
    "friction torque. At several constant speeds the torque has the same intercept.",
    cure="Better bearings, less preload of the gear, warm grease. In control add friction torque "
    "in the direction of the wanted motion, somewhat less than was found.",
    magnitude="1 to 5 % of the rated torque for a direct drive, 5 to 20 % behind a gear with a "
    "high ratio. It falls as the grease warms up.",
    parameters=(
        Parameter(
            name="torque",
            unit="N.m",
            meaning="friction torque at the motor pulley while moving, and the largest at rest",
            null=0.0,
            lower=0.0,
            upper=1.0e4,
            typical=lambda sizes: 0.05 * sizes.torque,
        ),
    ),
    equations=equations,
    reference="B. Armstrong-Hélouvry, P. Dupont, C. Canudas de Wit, A survey of models, analysis "
    "tools and compensation methods for the control of machines with friction, Automatica 30(7), "
    "1994",
    law_of="the motor's dry friction",
)
