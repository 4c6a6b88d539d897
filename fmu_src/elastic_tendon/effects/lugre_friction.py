"""LuGre friction at the joint: bristles that bend before they slip."""

from collections.abc import Mapping
from types import SimpleNamespace

from elastic_tendon.effects.base import (
    Contribution,
    Effect,
    Joint,
    Parameter,
    Relation,
    Slot,
    State,
)
from elastic_tendon.effects.stribeck_friction import PARAMETERS, stribeck_torque
from elastic_tendon.effects.stribeck_friction import cautions as stribeck_cautions
from elastic_tendon.effects.symbolic import where

FARTHEST = 0.05  # rad, by which bristles bend


def cautions(p: Mapping[str, float]) -> str:
    """Warn of bristles that bend as no surface does, and of friction that rises with speed."""
    torque, stiffness = max(p["static_torque"], p["coulomb_torque"]), p["bristle_stiffness"]
    if torque <= FARTHEST * stiffness or not stiffness:
        return stribeck_cautions(p)
    return (
        f"bristle_stiffness {stiffness:g} N.m/rad lets the bristles bend by "
        f"{torque / stiffness:.2g} rad before they slip, where surfaces yield by 1e-5 to 1e-2 rad"
    )


def equations(
    at: Joint, p: SimpleNamespace, state: SimpleNamespace, mode: SimpleNamespace
) -> Contribution:
    """Friction is the force of bristles bent by `bending`; their tips slip at the Stribeck torque.

    ``z' = v - s0 |v| z / g(v)``, torque ``-(s0 z + s1 z')``.
    """
    slipping = stribeck_torque(at.velocity, p)
    present = slipping > 0
    speed = where(mode.forward, at.velocity, -at.velocity)
    slip = p.bristle_stiffness * speed * state.bending / where(present, slipping, 1.0)
    rate = where(present, at.velocity - slip, 0.0)
    torque = p.bristle_stiffness * state.bending + p.bristle_damping * rate
    return Contribution(
        value=where(present, -torque, 0.0),
        rates={"bending": rate},
        thresholds={"forward": at.velocity},
    )


EFFECT = Effect(
    id="lugre_friction",
    title="LuGre friction",
    slot=Slot.JOINT_TORQUE,
    catalogue_order=30,
    physics="Friction as the force of microscopic bristles between the surfaces: they bend like "
    "springs before they slip, so the joint yields a little before it breaks away, and friction "
    "lags behind the velocity.",
    in_data="Like Stribeck friction, but the joint never sticks quite: at rest it yields "
    "elastically by about static_torque / bristle_stiffness and returns, with a small loop in load "
    "torque against position. After a reversal of the velocity the friction grows over that angle "
    "instead of jumping. Oscillations smaller than that are faster. All this is alike in every "
    "slack state.",
    law="-(s0 z + s1 z'), z' = v - s0 |v| z / g(v), g(v) = coulomb_torque + (static_torque - "
    "coulomb_torque) exp(-(v / stribeck_velocity)²), s0 = bristle_stiffness, s1 = bristle_damping",
    confused_with="Coulomb friction and Stribeck friction: the same in all motions much larger "
    "than the bending of the bristles; only motion before the break-away distinguishes them. "
    "Spring hysteresis: its loop too has rounded corners, but belongs to the springs and is lower "
    "where a tendon is slack.",
    confirm="Hold the motor and load the link in small steps below the torque at which it breaks "
    "away. The joint moves a little at each step and comes back when the load is taken off; with "
    "Coulomb or Stribeck friction it would not move at all. The joint encoder must resolve a tenth "
    "of static_torque / bristle_stiffness.",
    cure="As for Stribeck friction. In control an observer of the bristles' bending compensates "
    "better than the sign of the velocity does; it needs a clean velocity.",
    magnitude="The bristles bend by 1e-5 to 1e-2 rad before they slip, so bristle_stiffness is ten "
    "to some thousand times the joint's stiffness. bristle_damping gives the small motion a "
    "damping ratio of 0.1 to 1. The torques are those of Stribeck friction.",
    parameters=(
        *PARAMETERS,
        Parameter(
            name="bristle_stiffness",
            unit="N.m/rad",
            meaning="stiffness of the joint before it breaks away, s0",
            null=0.0,
            lower=0.0,
            upper=1.0e8,
            typical=lambda sizes: 10.0 * sizes.joint_stiffness,
        ),
        Parameter(
            name="bristle_damping",
            unit="N.m.s/rad",
            meaning="damping of that small motion, s1",
            null=0.0,
            lower=0.0,
            upper=1.0e5,
            typical=lambda sizes: 0.5 * sizes.joint_stiffness / sizes.frequency,
        ),
    ),
    equations=equations,
    reference="C. Canudas de Wit, H. Olsson, K. J. Åström, P. Lischinsky, A new model for control "
    "of systems with friction, IEEE Transactions on Automatic Control 40(3), 1995",
    states=(State("bending", "rad", "mean deflection of the bristles", 1e-3),),
    relations=(Relation("forward", "the joint moves in positive direction"),),
    law_of="the joint's dry friction",
    singular_null=True,
    smallest_share=0.002,  # weak friction bends soft bristles
    cautions=cautions,
)
