"""Friction inside a spring: its force lags behind its elongation, at any speed."""

from types import SimpleNamespace

from elastic_tendon.effects.base import (
    Contribution,
    Effect,
    Parameter,
    Relation,
    Slot,
    Spread,
    Spring,
    State,
)
from elastic_tendon.effects.symbolic import absolute, power, where


def equations(
    at: Spring, p: SimpleNamespace, state: SimpleNamespace, mode: SimpleNamespace
) -> Contribution:
    """Bouc-Wen with beta = gamma = 1/2: ``z' = e'/y (1 - |z|^n)`` loading, else ``e'/y``."""
    yielding = where(mode.loading, 1.0 - power(absolute(state.lag), p.exponent), 1.0)
    return Contribution(
        value=p.force * state.lag,
        rates={"lag": at.rate / p.yield_length * yielding},
        thresholds={"loading": state.lag * at.rate / at.max_deflection},
    )


EFFECT = Effect(
    id="spring_hysteresis",
    title="Spring hysteresis",
    slot=Slot.SPRING_LAW,
    catalogue_order=90,
    physics="Friction between or inside the coils, strands or rubber of a spring: part of its "
    "force follows a change of elongation stiffly at first and then yields, so loading and "
    "unloading take different paths and each cycle loses energy, however slowly it is done.",
    in_data="Load torque against deflection forms a loop that does not depend on speed and rounds "
    "its corners after each reversal of the velocity. With equal springs it is half as high where "
    "a tendon is slack (states I and II) as where both are taut (III), because a slack spring adds "
    "nothing. Oscillations decay without any damping; very small ones are stiffer and decay less.",
    law="added force of one spring: force z, z' = (e' / yield_length) (1 - |z|^exponent) where "
    "e' z > 0, else e' / yield_length; z starts at 0",
    confused_with="Coulomb friction and LuGre friction: their loops are as high in every slack "
    "state. Tendon guide friction: its loop grows with the tension. Spring relaxation and spring "
    "damping: their loops close in slow motion.",
    confirm="Hold the motor and cycle the load slowly at two speeds, one ten times the other: the "
    "loop stays the same. Compare its height in the middle, with both tendons taut, with that near "
    "the ends, with one slack: it falls by about half. A single spring on a force gauge shows it "
    "best.",
    cure="Steel instead of rubber or rope; coils that touch neither each other nor a guide; firm "
    "hooks; grease between strands. In control do not reckon torque from deflection alone; close "
    "the loop over the joint encoder.",
    magnitude="force is about 0.5 % of the largest spring force for free steel coils, 2 to 5 % "
    "where coils or strands rub, 5 to 20 % for rubber and textile; yield_length is 1 to 10 % of "
    "max_deflection; exponent is 1 to 2.",
    parameters=(
        Parameter(
            name="force",
            unit="N",
            meaning="largest hysteretic force of one spring; the loop is twice as high",
            null=0.0,
            lower=0.0,
            upper=1.0e6,
            typical=lambda sizes: 0.05 * sizes.force,
        ),
        Parameter(
            name="yield_length",
            unit="m",
            meaning="change of elongation over which the hysteretic force develops",
            null=1.0e-3,
            lower=1.0e-7,
            upper=1.0,
            typical=lambda sizes: 0.05 * sizes.max_deflection,
            shape=True,
        ),
        Parameter(
            name="exponent",
            unit="1",
            meaning="how late and sharply the hysteretic force yields: 1 gradually, 5 at a corner",
            null=1.0,
            lower=0.5,
            upper=5.0,
            typical=2.0,
            shape=True,
            spread=Spread.NULL,
        ),
    ),
    equations=equations,
    reference="M. Ismail, F. Ikhouane, J. Rodellar, The hysteresis Bouc-Wen model, a survey, "
    "Archives of Computational Methods in Engineering 16(2), 2009",
    states=(State("lag", "1", "hysteretic force as a share of the largest", 1.0),),
    relations=(Relation("loading", "the hysteretic force grows in size"),),
)
