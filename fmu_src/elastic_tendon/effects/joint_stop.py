"""Elastic stops at the ends of the joint's range."""

from collections.abc import Mapping
from types import SimpleNamespace

from elastic_tendon.effects.base import (
    Contribution,
    Effect,
    Joint,
    Parameter,
    Relation,
    Slot,
    Spread,
)
from elastic_tendon.effects.symbolic import both, where


def equations(
    at: Joint, p: SimpleNamespace, _state: SimpleNamespace, mode: SimpleNamespace
) -> Contribution:
    """A spring and a damper beyond each end; a stop pushes and never pulls."""
    # a stop without force pushes wherever it is touched, so that its derivative tells of it
    weak = both(p.stiffness <= 0, p.damping <= 0)
    scale = where(p.stiffness > 0, p.stiffness, 1.0)
    depth = {"upper": at.position - p.upper, "lower": p.lower - at.position}
    speed = {"upper": at.velocity, "lower": -at.velocity}
    push = {end: p.stiffness * depth[end] + p.damping * speed[end] for end in depth}
    active = {
        "upper": both(mode.upper_touched, mode.upper_pushing),
        "lower": both(mode.lower_touched, mode.lower_pushing),
    }
    torque = {end: where(active[end], push[end], 0.0) for end in push}
    return Contribution(
        value=torque["lower"] - torque["upper"],
        thresholds={f"{end}_touched": depth[end] for end in depth}
        | {f"{end}_pushing": where(weak, depth[end], push[end] / scale) for end in push},
    )


def refuses(p: Mapping[str, float]) -> str:
    """Refuse stops that leave the joint no room."""
    if p["lower"] < p["upper"]:
        return ""
    return (
        f"lower {p['lower']:g} rad is not below upper {p['upper']:g} rad; "
        "the joint moves between the two"
    )


EFFECT = Effect(
    id="joint_stop",
    title="Joint stop",
    slot=Slot.JOINT_TORQUE,
    catalogue_order=60,
    smallest_share=0.002,  # a bumper is soft
    physics="Mechanical ends of the joint's range, slightly elastic, which push the link back and "
    "let it go again.",
    in_data="The joint hardly passes a certain angle, whatever the motor does, and rebounds there. "
    "While it leans on the stop the motor can move on, so the deflection and the torque of the "
    "tendons grow and one tendon goes slack. Inside the range the model agrees at any speed and "
    "load.",
    law="-max(0, stiffness (q - upper) + damping v) where q > upper; max(0, stiffness (lower - q) "
    "- damping v) where q < lower; else 0",
    confused_with="Overstretch protection and spring hardening: they depend on the deflection and "
    "so move with the motor, while a stop stands at one angle of the joint. Coulomb friction: it "
    "holds the joint too, but anywhere, and without a rebound.",
    confirm="Drive the motor slowly past the suspected angle and back, without load. Joint "
    "position against motor position bends sharply, at the same joint angle forth and back and "
    "from every start; the link pushed there by hand stops at that angle too.",
    cure="End the motor's range earlier, with a margin for the overshoot of the soft joint, and "
    "brake before the end. A rubber bumper with much damping hurts less than a hard stop.",
    magnitude="A stop is 5 to 1000 times as stiff as the joint: rubber at the lower end, steel at "
    "the upper. The joint leaves it with 30 to 90 % of the speed at which it came. The angles are "
    "in the drawing.",
    parameters=(
        Parameter(
            name="lower",
            unit="rad",
            meaning="joint position of the lower stop",
            null=-3.141592653589793,
            lower=-1.0e3,
            upper=1.0e3,
            typical=-0.4,
            shape=True,
            spread=Spread.JOINT_RANGE,
        ),
        Parameter(
            name="upper",
            unit="rad",
            meaning="joint position of the upper stop",
            null=3.141592653589793,
            lower=-1.0e3,
            upper=1.0e3,
            typical=0.4,
            shape=True,
            spread=Spread.JOINT_RANGE,
        ),
        Parameter(
            name="stiffness",
            unit="N.m/rad",
            meaning="stiffness of each stop",
            null=0.0,
            lower=0.0,
            upper=1.0e8,
            typical=lambda sizes: 20.0 * sizes.joint_stiffness,
        ),
        Parameter(
            name="damping",
            unit="N.m.s/rad",
            meaning="damping of each stop while it pushes",
            null=0.0,
            lower=0.0,
            upper=1.0e5,
            typical=lambda sizes: 0.5 * sizes.joint_stiffness / sizes.frequency,
        ),
    ),
    equations=equations,
    reference="G. Gilardi, I. Sharf, Literature survey of contact dynamics modelling, Mechanism "
    "and Machine Theory 37(10), 2002",
    relations=(
        Relation("upper_touched", "the joint is beyond the upper stop"),
        Relation("upper_pushing", "the upper stop would push"),
        Relation("lower_touched", "the joint is beyond the lower stop"),
        Relation("lower_pushing", "the lower stop would push"),
    ),
    refuses=refuses,
)
