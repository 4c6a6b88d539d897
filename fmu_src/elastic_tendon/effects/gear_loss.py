"""Friction of the motor's gear or screw, a share of the torques that it transmits."""

from types import SimpleNamespace

from elastic_tendon.effects.base import (
    Effect,
    FrictionBounds,
    Motor,
    Parameter,
    Relation,
    Slot,
)
from elastic_tendon.effects.symbolic import Symbol, where

TORQUE_SCALE = 1.0  # N·m
# beside each share, so that its derivative is right where it vanishes: far below any real one
SMALLEST = 1e-12


def equations(
    at: Motor, p: SimpleNamespace, _state: SimpleNamespace, mode: SimpleNamespace
) -> FrictionBounds:
    """Shares of the torques at both sides, which add up where these oppose each other."""
    torque = lost(at, p, mode)
    return FrictionBounds(lower=-torque, upper=torque, thresholds={"upwards": twist(at, p)})


def lost(at: Motor, p: SimpleNamespace, mode: SimpleNamespace) -> Symbol:
    """Torque (N·m) that is lost between the motor's side of a gear and its load's."""
    difference = p.motor_share * at.torque - p.load_share * at.load
    return where(mode.upwards, difference, -difference)


def twist(at: Motor, p: SimpleNamespace) -> Symbol:
    """Which way the teeth are pressed: positive where the motor's side presses upwards."""
    before, behind = p.motor_share + SMALLEST, p.load_share + SMALLEST
    return (before * at.torque - behind * at.load) / ((before + behind) * TORQUE_SCALE)


UPWARDS = Relation("upwards", "the motor presses the teeth in the positive direction")


def shares(what: str) -> tuple[Parameter, ...]:
    """Parameters of a friction by the torques at both sides of the gear."""
    of_motor, of_load = "the motor's torque", "the torque of the tendons on the motor"
    return tuple(
        Parameter(
            name=name,
            unit="1",
            meaning=f"{what} as a share of {torque}",
            null=0.0,
            lower=0.0,
            upper=upper,
            typical=0.05,
        )
        for name, torque, upper in (
            ("motor_share", of_motor, 0.99),
            ("load_share", of_load, 10.0),
        )
    )


EFFECT = Effect(
    id="gear_loss",
    title="Gear loss",
    slot=Slot.MOTOR_FRICTION,
    catalogue_order=312,
    on_request=True,
    physics="Teeth or threads rub under the torque that they transmit, so a gear or screw loses a "
    "share of it. Where the motor drives the load the efficiency is (1 - motor_share) / (1 + "
    "load_share), where the load drives the motor (1 - load_share) / (1 + motor_share): with a "
    "load_share of 1 or more the gear locks itself.",
    in_data="A friction of the motor that grows with the torque it bears, at every speed: lifting "
    "a load takes more torque than holding it, and holding more than lowering it, and the heavier "
    "the load the more. In slow motion motor torque over load torque is a wedge that opens from "
    "zero load, alike in every slack state.",
    law="-|motor_share τ - load_share τ_t| sgn(θ') while the motor moves, τ_t the torque of the "
    "tendons on it; at rest what balances the other torques, up to as much",
    confused_with="Motor friction: its size is the same at every load, so only loads of several "
    "sizes tell the two apart. Motor torque gain: alike while the motor always drives its load; "
    "where the load drives the motor the loss changes its side, a gain does not. Motor stiction: "
    "it goes with speed. Tendon guide friction: it is lost at the joint and grows with the "
    "pretension too.",
    confirm="Hang masses on the link and let the motor lift and lower each at a constant slow "
    "speed. Half the difference of the two motor torques is the friction: its intercept over the "
    "load is motor friction, its slope the loss, and the mean of both lines bends off the load by "
    "what driving and being driven differ.",
    cure="Ground and hardened teeth, rolling instead of sliding screws, thin oil. In control add "
    "the loss of the wanted direction to the torque.",
    magnitude="Both shares together: 1 to 3 % a stage of spur and planetary gears and ball screws, "
    "20 to 40 % for small plastic or harmonic gears, over half for worm gears and trapezoidal "
    "screws.",
    parameters=shares("friction"),
    equations=equations,
    relations=(UPWARDS,),
    reference="P. Hamon, M. Gautier, P. Garrec, Dynamic identification of robots with a dry "
    "friction model depending on load and velocity, IEEE/RSJ International Conference on "
    "Intelligent Robots and Systems, 2010",
)
