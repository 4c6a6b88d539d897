"""Overstretch protection of the springs (paper, Fig. 6)."""

from types import SimpleNamespace

from elastic_tendon.effects.base import (
    Contribution,
    Effect,
    Parameter,
    Relation,
    Scale,
    Slot,
    Spring,
)
from elastic_tendon.symbolic import where


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
    physics="A protective string in or around each spring becomes taut before the spring is "
    "overstretched and carries load beside it, so the characteristic curve turns progressive "
    "near the maximum deflection.",
    in_data="The joint is stiffer than the model beyond a certain deflection, in both directions "
    "where the springs are alike, and nowhere else: the corners of the torque-deflection curve "
    "(paper, Fig. 10).",
    parameters=(
        Parameter(
            name="engagement",
            unit="1",
            meaning="elongation at which the string is taut, as a share of max_deflection",
            null=1.0,
            lower=0.05,
            upper=2.0,
            typical=0.8,
        ),
        Parameter(
            name="stiffness",
            unit="N/m",
            meaning="stiffness that the string adds to one spring beyond the engagement",
            null=0.0,
            lower=0.0,
            upper=1.0e8,
            typical=3.0,
            scale=Scale.STIFFNESS,
        ),
    ),
    equations=equations,
    relations=(Relation("engaged", "the protective string is taut"),),
    reference="the paper, section II.E and Fig. 6",
)
