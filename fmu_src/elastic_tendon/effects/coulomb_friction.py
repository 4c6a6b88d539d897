"""Coulomb friction at the joint, with true sticking."""

from types import SimpleNamespace

from elastic_tendon.effects.base import Effect, FrictionBounds, Joint, Parameter, Scale, Slot


def equations(
    _at: Joint, p: SimpleNamespace, _state: SimpleNamespace, _mode: SimpleNamespace
) -> FrictionBounds:
    """Friction torque opposes motion with `torque`, and holds up to `torque` at rest."""
    return FrictionBounds(lower=-p.torque, upper=p.torque)


EFFECT = Effect(
    id="coulomb_friction",
    title="Coulomb friction",
    slot=Slot.DRY_FRICTION,
    physics="Dry friction of bearings and seals at the joint: a torque of constant size against "
    "the motion, which holds the joint still while the other torques stay below it.",
    in_data="The joint stops short of its target and stays there; the error changes sign with the "
    "velocity and does not depend on its size; torque against deflection forms a loop whose height "
    "is twice the friction torque at any speed.",
    parameters=(
        Parameter(
            name="torque",
            unit="N.m",
            meaning="friction torque while moving, and the largest it holds at rest",
            null=0.0,
            lower=0.0,
            upper=1.0e4,
            typical=0.03,
            scale=Scale.TORQUE,
        ),
    ),
    equations=equations,
    reference="H. Olsson et al., Friction models and friction compensation, "
    "European Journal of Control 4(3), 1998",
)
