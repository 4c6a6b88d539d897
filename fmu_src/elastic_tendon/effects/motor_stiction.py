"""What the dry friction of motor and gear has more at rest than in motion, with its load."""

from types import SimpleNamespace

from elastic_tendon.effects.base import (
    Effect,
    FrictionBounds,
    Motor,
    Parameter,
    Relation,
    Slot,
)
from elastic_tendon.effects.gear_loss import TORQUE_SCALE, UPWARDS, lost, shares, twist
from elastic_tendon.effects.symbolic import Symbol, absolute, exp, power, where


def equations(
    at: Motor, p: SimpleNamespace, _state: SimpleNamespace, mode: SimpleNamespace
) -> FrictionBounds:
    """The excess at rest, which falls with the speed as an exponential of its power."""
    fallen = exp(-power(absolute(at.velocity) / p.stribeck_velocity, p.exponent))
    torque = (p.torque + lost(at, p, mode) + _square(at, p, mode)) * fallen
    larger = (absolute(at.torque) - absolute(at.load)) / TORQUE_SCALE
    return FrictionBounds(
        lower=-torque, upper=torque, thresholds={"upwards": twist(at, p), "driving": larger}
    )


def _square(at: Motor, p: SimpleNamespace, mode: SimpleNamespace) -> Symbol:
    """Of the smaller of two torques that oppose each other, by who drives whom, N·m."""
    square = where(mode.driving, p.driving_square * at.load**2, p.driven_square * at.torque**2)
    return where(at.torque * at.load < 0, square, 0)


EFFECT = Effect(
    id="motor_stiction",
    title="Motor stiction",
    slot=Slot.MOTOR_FRICTION,
    catalogue_order=314,
    on_request=True,
    physics="Motor and gear hold at rest with more torque than they lose while moving, because "
    "slow surfaces touch and fast ones swim on their lubricant (Stribeck); under load teeth press "
    "harder, so a part of the excess grows with the torques at both sides of the gear, and in "
    "harmonic gears with their square.",
    in_data="The motor breaks away with a jerk and sticks and slips in slow motion, more so under "
    "load; above stribeck_velocity nothing of it is left. It is of the motor, so it is the same in "
    "every slack state.",
    law="-(torque + |motor_share τ - load_share τ_t| + s) exp(-|θ' / stribeck_velocity|^exponent) "
    "sgn(θ') while the motor moves, τ_t the torque of the tendons on it; s = driving_square τ_t² "
    "while τ is the larger of two opposed torques, driven_square τ² while τ_t is; at rest what "
    "balances the other torques, up to as much",
    confused_with="Motor friction: it stays at every speed, and only fast motion tells the two "
    "apart. Gear loss: it stays at every speed too. Stribeck friction: it is the joint's, and the "
    "springs lie between the two.",
    confirm="Turn the motor at constant speeds from very slow to fast, both ways, without load and "
    "with a mass that it lifts and lowers: the torque falls with the speed at first, and falls "
    "deeper with the mass.",
    cure="A lubricant against stick-slip, less preload of the gear. In control dither the torque "
    "a little, and avoid very slow motion under load.",
    magnitude="0.2 to 1 times the motor's friction at speed; shares of 0.02 to 0.2; squares below "
    "0.01 a N·m. stribeck_velocity is 0.1 to 1 rad/s behind the gear, exponent 0.5 to 2.",
    parameters=(
        Parameter(
            name="torque",
            unit="N.m",
            meaning="friction at rest without load beyond that in motion",
            null=0.0,
            lower=0.0,
            upper=1.0e4,
            typical=lambda sizes: 0.03 * sizes.torque,
        ),
        *shares("excess"),
        Parameter(
            name="driving_square",
            unit="1/(N.m)",
            meaning="excess over the square of the tendons' torque, while the motor drives them",
            null=0.0,
            lower=0.0,
            upper=10.0,
            typical=lambda sizes: 0.02 / sizes.torque,
        ),
        Parameter(
            name="driven_square",
            unit="1/(N.m)",
            meaning="excess over the square of the motor's torque, while the tendons drive it",
            null=0.0,
            lower=0.0,
            upper=10.0,
            typical=lambda sizes: 0.02 / sizes.torque,
        ),
        Parameter(
            name="stribeck_velocity",
            unit="rad/s",
            meaning="motor velocity at which the excess has fallen to 1/e",
            null=0.2,
            lower=1.0e-4,
            upper=1.0e3,
            typical=0.2,
            shape=True,
        ),
        Parameter(
            name="exponent",
            unit="1",
            meaning="how sharply the excess falls at stribeck_velocity",
            null=2.0,
            lower=0.5,
            upper=10.0,
            typical=2.0,
            shape=True,
        ),
    ),
    equations=equations,
    relations=(UPWARDS, Relation("driving", "the motor's torque is the larger one")),
    reference="M. Duclusaud, G. Passault, V. Padois, O. Ly, Extended friction models for the "
    "physics simulation of servo actuators, arXiv 2410.08650, 2024",
)
