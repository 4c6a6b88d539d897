"""Coulomb friction at the joint, with true sticking."""

from types import SimpleNamespace

from elastic_tendon.effects.base import Effect, FrictionBounds, Joint, Parameter, Slot


def equations(
    _at: Joint, p: SimpleNamespace, _state: SimpleNamespace, _mode: SimpleNamespace
) -> FrictionBounds:
    """Friction torque opposes motion with `torque`, and holds up to `torque` at rest."""
    return FrictionBounds(lower=-p.torque, upper=p.torque)


EFFECT = Effect(
    id="coulomb_friction",
    title="Coulomb friction",
    slot=Slot.DRY_FRICTION,
    catalogue_order=10,
    physics="Dry friction of bearings and seals at the joint: a torque of constant size against "
    "the motion, which holds the joint still while the other torques stay below it.",
    in_data="The joint stops short of its target and stays there, by up to the friction torque "
    "over the joint's stiffness, so farther where a tendon is slack. The error changes sign with "
    "the velocity and depends neither on speed nor on load. In slow motion load torque against "
    "deflection forms a loop of the same height in every slack state, twice the friction torque. "
    "The swings of a free oscillation shrink by the same angle each time, until the joint sticks.",
    law="-torque sgn(v) while the joint moves; at rest what balances the other torques, up to "
    "±torque",
    confused_with="Stribeck friction and LuGre friction: the same while the joint moves fast; near "
    "rest Stribeck friction is larger and LuGre friction yields elastically. Tendon guide "
    "friction: its loop grows with the tension of the tendons. Spring hysteresis: its loop has "
    "rounded corners and is lower where a tendon is slack. Quadratic drag and viscous damping: "
    "they vanish in slow motion. Constant torque: it is the same in both directions. Gear "
    "backlash: it makes a dead zone too, but lets the joint loose instead of holding it. Joint "
    "stop: it holds the joint at one angle only. Directional damping: it grows with the speed.",
    confirm="Hold the motor and push the link slowly forth and back through a force gauge. The "
    "loop of load torque against joint position is as high at every deflection and every slow "
    "speed, and stays so with more pretension. Without a gauge: approach the same motor position "
    "slowly from both sides; the two rest positions of the joint differ by up to twice the "
    "friction torque over the stiffness.",
    cure="Better bearings, less bearing preload, seals that touch less. In control lead the motor "
    "by friction torque over joint stiffness in the direction of motion. Integral action alone "
    "makes the joint hunt around its target.",
    magnitude="1 to 5 % of the largest joint torque with ball bearings; more with contact seals, "
    "plain bearings or cables that bend with the joint. It grows with the load of the bearings and "
    "changes with temperature and wear.",
    parameters=(
        Parameter(
            name="torque",
            unit="N.m",
            meaning="friction torque while moving, and the largest it holds at rest",
            null=0.0,
            lower=0.0,
            upper=1.0e4,
            typical=lambda sizes: 0.03 * sizes.torque,
        ),
    ),
    equations=equations,
    reference="H. Olsson, K. J. Åström, C. Canudas de Wit, M. Gäfvert, P. Lischinsky, Friction "
    "models and friction compensation, European Journal of Control 4(3), 1998",
    law_of="the joint's dry friction",
)
