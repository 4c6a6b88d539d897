"""Overstretch protection of the springs (paper, Fig. 6)."""

from types import SimpleNamespace

from elastic_tendon.effects.base import (
    Contribution,
    Effect,
    Parameter,
    Relation,
    Slot,
    Spread,
    Spring,
)
from elastic_tendon.effects.symbolic import where


def equations(
    at: Spring, p: SimpleNamespace, _state: SimpleNamespace, mode: SimpleNamespace
) -> Contribution:
    """A string beside the spring that is taut beyond `engagement` of the maximum deflection."""
    excess = at.elongation - p.engagement * at.max_deflection
    return Contribution(
        value=where(mode.engaged, p.stiffness * excess, 0.0),
        thresholds={"engaged": excess / at.max_deflection},
    )


EFFECT = Effect(
    id="overstretch_protection",
    title="Overstretch protection",
    slot=Slot.SPRING_LAW,
    catalogue_order=70,
    physics="A protective string in or around each spring becomes taut before the spring is "
    "overstretched and carries load beside it, so the characteristic curve turns progressive near "
    "the maximum deflection.",
    in_data="The joint is stiffer than the model beyond a certain deflection and nowhere else: the "
    "corners of the torque-deflection curve (paper, Fig. 10). By then the other tendon is slack as "
    "a rule (states I and II). Each spring makes a corner on its side; speed and direction of "
    "motion do not matter. Large swings are faster than small ones.",
    law="added force of one spring: stiffness max(0, e - engagement max_deflection)",
    confused_with="Spring hardening: it stiffens gradually and from small deflections on; data "
    "that hardly pass the corner cannot distinguish the two. Joint stop: it stands at one angle of "
    "the joint, the corners move with the motor.",
    confirm="Hold the motor and load the link slowly up to the largest deflection, in both "
    "directions. The slope of load torque against deflection jumps at one deflection on each side "
    "and is level before and after. From another motor position the corners are at the same "
    "deflections.",
    cure="It protects the springs: keep it and model it. Longer strings, longer springs or less "
    "pretension move the corners outward.",
    magnitude="Strings become taut at 70 to 100 % of the largest deflection and add 2 to 20 times "
    "the stiffness of the spring: textile less, steel wire more.",
    parameters=(
        Parameter(
            name="engagement",
            unit="1",
            meaning="elongation at which the string is taut, as a share of max_deflection",
            null=1.0,
            lower=0.05,
            upper=2.0,
            typical=0.8,
            shape=True,
            spread=Spread.ELONGATION,
        ),
        Parameter(
            name="stiffness",
            unit="N/m",
            meaning="stiffness that the string adds to one spring beyond the engagement",
            null=0.0,
            lower=0.0,
            upper=1.0e8,
            typical=lambda sizes: 3.0 * sizes.stiffness,
        ),
    ),
    equations=equations,
    relations=(Relation("engaged", "the protective string is taut"),),
    reference="Dynamic Modeling of Elastic Tendon Actuators with Tendon Slackening (the paper), "
    "Fig. 6, Fig. 10 and section IV",
)
