"""Friction of tendons on the pulleys and guides around which they are wrapped."""

from types import SimpleNamespace

from elastic_tendon.effects.base import Alias, Effect, FrictionBounds, JointPulley, Parameter, Slot
from elastic_tendon.effects.symbolic import exp


def equations(
    at: JointPulley, p: SimpleNamespace, _state: SimpleNamespace, _mode: SimpleNamespace
) -> FrictionBounds:
    """Capstan equation: of a tension F the joint sees between F e^(-w) and F e^w."""
    more = exp(p.wrap_friction) - 1.0
    less = exp(-p.wrap_friction) - 1.0
    return FrictionBounds(
        lower=at.radius * (at.upper_tension * less - at.lower_tension * more),
        upper=at.radius * (at.upper_tension * more - at.lower_tension * less),
    )


EFFECT = Effect(
    id="tendon_guide_friction",
    title="Tendon guide friction",
    slot=Slot.TENDON_LOSS,
    catalogue_order=120,
    physics="A tendon wrapped around a pulley or through a sheath rubs on it and passes on less "
    "force than it is pulled with; the loss is a share of the tension, so it grows with pretension "
    "and load.",
    in_data="A friction that changes sign with the velocity, at any speed, and grows with the "
    "tension: in load torque against deflection the loop is equally high while both tendons are "
    "taut (state III, with equal springs), and opens with the load where one is slack (states I "
    "and II). More pretension makes the whole loop higher. At rest the joint holds somewhere "
    "inside the loop.",
    law="τ = R (F_1 exp(-s wrap_friction) - F_2 exp(s wrap_friction)), s = sgn(v); at rest the "
    "joint stays while some s from -1 to 1 balances",
    confused_with="Coulomb friction: its loop does not grow with tension; while both tendons stay "
    "taut the two cannot be distinguished. Spring hysteresis: its loop shrinks where a tendon is "
    "slack, where this one opens. Gear loss: it is lost at the motor and does not grow with the "
    "pretension.",
    confirm="Hold the motor and push the link slowly forth and back through a force gauge, far "
    "enough that a tendon goes slack: the loop opens towards the ends. Repeat with twice the "
    "pretension: its height in the middle doubles.",
    cure="Fewer turns and less wrap, pulleys on ball bearings instead of sliding guides, PTFE "
    "liners, coated ropes, less pretension. In control feed the friction forward from tension and "
    "sign of the velocity, and close the loop over the joint encoder.",
    magnitude="wrap_friction is the coefficient of friction times the angle of wrap. Pulleys on "
    "ball bearings: 0.005 to 0.03 each. Rope sliding half a turn on PTFE: 0.15 to 0.3; on dry "
    "steel: 0.3 to 0.6. Sheaths: 0.2 to 1. Of the force exp(-wrap_friction) arrives.",
    parameters=(
        Parameter(
            name="wrap_friction",
            unit="1",
            meaning="friction coefficient times angle of wrap in rad, the exponent of the capstan "
            "equation",
            null=0.0,
            lower=0.0,
            upper=10.0,
            typical=0.05,
        ),
    ),
    equations=equations,
    reference="G. Palli, G. Borghesan, C. Melchiorri, Modeling, identification, and control of "
    "tendon-based actuation systems, IEEE Transactions on Robotics 28(2), 2012",
    aliases=(
        Alias(
            of=("coulomb_friction",),
            when="both tendons stay taut and the springs are linear and alike: the friction of "
            "guides is then 2 R sinh(wrap_friction) times the pretension, and makes the springs "
            "cosh(wrap_friction) times as stiff",
        ),
    ),
)
