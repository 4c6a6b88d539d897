"""Stribeck friction at the joint: Coulomb friction that is larger at and near rest."""

from collections.abc import Mapping
from types import SimpleNamespace

from elastic_tendon.effects.base import Effect, FrictionBounds, Joint, Parameter, Slot
from elastic_tendon.effects.symbolic import Symbol, exp


def equations(
    at: Joint, p: SimpleNamespace, _state: SimpleNamespace, _mode: SimpleNamespace
) -> FrictionBounds:
    """The torque opposes motion, and holds up to `static_torque` at rest."""
    torque = stribeck_torque(at.velocity, p)
    return FrictionBounds(lower=-torque, upper=torque)


def stribeck_torque(velocity: Symbol, p: SimpleNamespace) -> Symbol:
    """Friction (N·m) that falls from `static_torque` to `coulomb_torque` with velocity (rad/s)."""
    share = exp(-((velocity / p.stribeck_velocity) ** 2))
    return p.coulomb_torque + (p.static_torque - p.coulomb_torque) * share


def cautions(p: Mapping[str, float]) -> str:
    """Warn of friction that rises where Stribeck friction falls."""
    if p["static_torque"] >= p["coulomb_torque"]:
        return ""
    return (
        f"static_torque {p['static_torque']:g} N.m is below coulomb_torque "
        f"{p['coulomb_torque']:g} N.m, so friction rises with speed where it usually falls"
    )


# of LuGre friction too, whose bristles slip at the same torque
PARAMETERS = (
    Parameter(
        name="coulomb_torque",
        unit="N.m",
        meaning="friction torque at speeds well above stribeck_velocity",
        null=0.0,
        lower=0.0,
        upper=1.0e4,
        typical=lambda sizes: 0.03 * sizes.torque,
    ),
    Parameter(
        name="static_torque",
        unit="N.m",
        meaning="largest friction torque at rest",
        null=0.0,
        lower=0.0,
        upper=1.0e4,
        typical=lambda sizes: 0.05 * sizes.torque,
    ),
    Parameter(
        name="stribeck_velocity",
        unit="rad/s",
        meaning="joint velocity at which the excess over coulomb_torque has fallen to 1/e",
        null=0.1,
        lower=1.0e-4,
        upper=1.0e3,
        typical=0.1,
        shape=True,
    ),
)

EFFECT = Effect(
    id="stribeck_friction",
    title="Stribeck friction",
    slot=Slot.DRY_FRICTION,
    catalogue_order=20,
    physics="Dry friction of a lubricated joint: at rest and at low speed the surfaces touch and "
    "the friction is largest; with speed the lubricant carries them and it falls to a constant.",
    in_data="The joint breaks away with a jerk, and in slow motion it sticks and slips; the jumps "
    "are longer where a tendon is slack, because the joint is softer there. The error is largest "
    "where the joint starts from rest or passes slowly through it, against the velocity in both "
    "directions. At speeds well above stribeck_velocity it looks like Coulomb friction.",
    law="-g(v) sgn(v) while the joint moves, g(v) = coulomb_torque + (static_torque - "
    "coulomb_torque) exp(-(v / stribeck_velocity)²); at rest what balances the other torques, up "
    "to ±static_torque",
    confused_with="Coulomb friction: lacks the excess near rest, so only slow motions tell the two "
    "apart. LuGre friction: yields elastically before it breaks away, which only very small "
    "motions show. Gear backlash: it too makes the joint late where a motion turns round, but lets "
    "it loose instead of holding it. Motor stiction: the springs lie between it and the joint.",
    confirm="Turn the motor at constant speeds from very slow to fast, in both directions and "
    "without load. The mean deflection times the joint's stiffness is the friction torque: it is "
    "largest at the lowest speeds and falls with speed. Sticking and slipping that ceases above a "
    "certain speed is the sure sign.",
    cure="A lubricant with additives against stick-slip, rolling instead of plain bearings, seals "
    "of PTFE. In control avoid very slow motions, add damping, or let the motor tremble a little "
    "(dither). Compensate less than the whole friction: too much makes the joint oscillate.",
    magnitude="static_torque is 1.2 to 2 times coulomb_torque, and this 1 to 5 % of the largest "
    "joint torque. stribeck_velocity is 0.01 to 0.5 rad/s; it is lower with thicker oil and with a "
    "larger radius of the rubbing surfaces.",
    parameters=PARAMETERS,
    equations=equations,
    reference="B. Armstrong-Hélouvry, P. Dupont, C. Canudas de Wit, A survey of models, analysis "
    "tools and compensation methods for the control of machines with friction, Automatica 30(7), "
    "1994",
    law_of="the joint's dry friction",
    cautions=cautions,
)
