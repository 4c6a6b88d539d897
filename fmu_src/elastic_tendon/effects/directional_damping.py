"""Viscous damping that differs with the direction of motion."""

from types import SimpleNamespace

from elastic_tendon.effects.base import Contribution, Effect, Joint, Parameter, Relation, Slot
from elastic_tendon.effects.symbolic import where


def equations(
    at: Joint, p: SimpleNamespace, _state: SimpleNamespace, mode: SimpleNamespace
) -> Contribution:
    """Torque -c |v|, so that damping is larger by c in one direction and smaller in the other."""
    speed = where(mode.forward, at.velocity, -at.velocity)
    return Contribution(-p.difference * speed, thresholds={"forward": at.velocity})


EFFECT = Effect(
    id="directional_damping",
    title="Directional damping",
    slot=Slot.JOINT_TORQUE,
    catalogue_order=45,
    physics="Viscous friction of a screw, gear or lip seal that runs harder in one direction than "
    "in the other: teeth, threads and seal lips meet the lubricant from another side.",
    in_data="A torque of the same sign in both directions that grows with the speed and vanishes "
    "at rest, in every slack state: at the same speed forth and back the joint lags by different "
    "angles. Slow motions agree with the model.",
    law="-difference |v|",
    confused_with="Constant torque: it is there at rest too. Viscous damping (link.damping): it "
    "changes its sign with the velocity. Quadratic drag: it changes its sign too, and grows with "
    "the square of the speed.",
    confirm="Move forth and back at the same constant speed, for several speeds, and plot the mean "
    "of the two torques against the speed: it is a line through the constant torque at rest, whose "
    "slope is the difference.",
    cure="In control lead the motor with the damping of each direction. Otherwise turn the seal "
    "round, or preload screw or gear to both sides alike.",
    magnitude="5 to 30 % of link.damping for ball screws and worm gears.",
    parameters=(
        Parameter(
            name="difference",
            unit="N.m.s/rad",
            meaning="damping for positive velocity less link.damping; half of what the directions "
            "differ by",
            null=0.0,
            lower=-1.0e4,
            upper=1.0e4,
            typical=lambda sizes: 0.05 * sizes.inertia * sizes.frequency,
        ),
    ),
    relations=(Relation("forward", "the joint moves in positive direction"),),
    equations=equations,
    reference="B. Armstrong-Hélouvry, P. Dupont, C. Canudas de Wit, A survey of models, analysis "
    "tools and compensation methods for the control of machines with friction, Automatica 30(7), "
    "1994",
)
