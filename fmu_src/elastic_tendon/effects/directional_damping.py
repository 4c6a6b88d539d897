"""Viscous friction at the joint that differs between the two directions of motion."""

from types import SimpleNamespace

from elastic_tendon.effects.base import Contribution, Effect, Joint, Parameter, Relation, Slot
from elastic_tendon.effects.symbolic import where

VELOCITY_SCALE = 1.0  # rad/s


def equations(
    at: Joint, p: SimpleNamespace, _state: SimpleNamespace, mode: SimpleNamespace
) -> Contribution:
    """Half the difference on either side of link.damping, which is the mean."""
    half = 0.5 * p.difference
    return Contribution(
        where(mode.forward, -half, half) * at.velocity,
        thresholds={"forward": at.velocity / VELOCITY_SCALE},
    )


EFFECT = Effect(
    id="directional_damping",
    title="Directional damping",
    slot=Slot.JOINT_TORQUE,
    catalogue_order=190,
    on_request=True,
    physics="Viscous friction that differs between the two directions: lips of seals that point "
    "one way, oil that one flank of a tooth or thread drags along and the other wipes off, a "
    "screw whose nut is preloaded on one side. link.damping is the mean of both.",
    in_data="The joint lags more in one direction than in the other, by a torque that grows with "
    "the speed and is the same in every slack state and at every angle. At rest and in slow "
    "motion nothing is to be seen. Motion to and fro shifts the mean position: the farther, the "
    "faster it is.",
    law="-(difference / 2) |v|",
    confused_with="Constant torque: it is there at rest too; where the joint always moves at one "
    "speed, to and fro, the two are alike. Quadratic drag: it is alike in both directions. Coulomb "
    "friction: it changes its sign with the direction and does not grow with speed; together with "
    "a constant torque it is dry friction that differs by direction. Viscous damping "
    "(link.damping): the same in a motion that goes one way only.",
    confirm="Move the joint at several constant speeds forth and back and plot the torque over the "
    "velocity: two straight lines with different slopes that meet at rest. A step at rest is dry "
    "friction, a common shift is a constant torque.",
    cure="Seals in pairs that face each other, a preload from both sides. In control lead the "
    "motor by the damping of the direction in which it moves.",
    magnitude="5 to 30 % of the damping itself on axes with screws, seals or preloaded gears; it "
    "changes as the grease warms up. More than twice link.damping would drive the joint in one "
    "direction.",
    parameters=(
        Parameter(
            name="difference",
            unit="N.m.s/rad",
            meaning="damping in the positive direction less that in the negative one",
            null=0.0,
            lower=-1.0e5,
            upper=1.0e5,
            typical=lambda sizes: 0.05 * sizes.inertia * sizes.frequency,
        ),
    ),
    equations=equations,
    relations=(Relation("forward", "the joint moves in the positive direction"),),
    reference="B. Armstrong-Hélouvry, Control of Machines with Friction, Kluwer, 1991",
)
