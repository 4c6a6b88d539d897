"""Play between motor and motor pulley."""

from types import SimpleNamespace

from elastic_tendon.effects.base import Contribution, Effect, MotorAngle, Parameter, Relation, Slot
from elastic_tendon.effects.symbolic import where


def equations(
    at: MotorAngle, p: SimpleNamespace, _state: SimpleNamespace, mode: SimpleNamespace
) -> Contribution:
    """The massless pulley floats where it has no torque, within half the gap of the motor."""
    lead = at.free_position - at.motor_position
    floating = where(p.gap > 0, at.free_position, at.motor_position)
    behind = where(mode.behind, at.motor_position - 0.5 * p.gap, floating)
    return Contribution(
        value=where(mode.ahead, at.motor_position + 0.5 * p.gap, behind),
        thresholds={"ahead": lead - 0.5 * p.gap, "behind": -lead - 0.5 * p.gap},
    )


EFFECT = Effect(
    id="gear_backlash",
    title="Gear backlash",
    slot=Slot.ANGLE_MAP,
    catalogue_order=150,
    physics="Play in the gear: while the torque changes sign the teeth lose touch and the motor "
    "turns through the gap without moving the pulley.",
    in_data="Where the torque of the tendons changes sign, which happens only while both are taut "
    "(state III), motor and joint move against each other by the gap without any force; the sign "
    "of the velocity does not matter. Load torque against deflection has a level piece at zero "
    "torque, gap r / R wide. Around rest the joint floats: small oscillations are slow, large ones "
    "are hardly changed. A load that never changes sign hides it.",
    law="pulley angle = the one at which both tendons pull alike, kept between θ - gap / 2 and θ + "
    "gap / 2",
    confused_with="Measurement delay: it too makes the joint late where a motion turns round, but "
    "the more the faster the motion; backlash does so by the same angle at any speed. Coulomb "
    "friction and Stribeck friction: they make a dead zone too, but hold the joint still where "
    "backlash lets it loose. Motor encoder offset: a load that never changes sign makes backlash "
    "one of half the gap.",
    confirm="Hold the motor and rock the link gently by hand: it moves freely by gap r / R and "
    "then meets the springs, on either side. Move the motor slowly forth and back: where it turns "
    "round, the joint waits until the gap is crossed; with a constant load that keeps the teeth on "
    "one side it does not.",
    cure="A preloaded or split gear, a strain wave gear or a belt; a weight or a light spring that "
    "keeps the teeth on one side. In control close the loop over the joint encoder, lead the motor "
    "through the gap when the torque changes sign, and keep gains low around zero torque.",
    magnitude="Planetary gearheads 0.005 to 0.03 rad at the output, precision ones 0.0003 to "
    "0.002, strain wave gears almost none, worn spur gears 0.05 rad and more. It grows with wear.",
    parameters=(
        Parameter(
            name="gap",
            unit="rad",
            meaning="whole play, at the motor pulley",
            null=0.0,
            lower=0.0,
            upper=1.0,
            typical=0.01,
        ),
    ),
    equations=equations,
    reference="M. Nordin, P.-O. Gutman, Controlling mechanical systems with backlash, a survey, "
    "Automatica 38(10), 2002",
    relations=(
        Relation("ahead", "the pulley leans on the upper end of the gap"),
        Relation("behind", "the pulley leans on the lower end of the gap"),
    ),
)
