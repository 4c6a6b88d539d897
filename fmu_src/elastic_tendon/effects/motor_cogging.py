"""Torque of the magnets of a motor, periodic in its angle."""

from types import SimpleNamespace

from elastic_tendon.effects.base import Contribution, Effect, Motor, Parameter, Slot, Spread
from elastic_tendon.effects.symbolic import sin


def equations(
    at: Motor, p: SimpleNamespace, _state: SimpleNamespace, _mode: SimpleNamespace
) -> Contribution:
    """One wave of the torque over the angle."""
    return Contribution(p.amplitude * sin(p.waves * at.position + p.phase))


EFFECT = Effect(
    id="motor_cogging",
    title="Motor cogging",
    slot=Slot.MOTOR_TORQUE,
    catalogue_order=320,
    physics="The magnets of the rotor are drawn to the teeth of the stator, so the motor without "
    "current has places where it likes to rest; a gear that runs out of round does the same.",
    in_data="A ripple of the motor torque that repeats over the motor's angle, so many times a "
    "turn of the motor pulley, and is the same in both directions, at every speed and in every "
    "slack state. In slow motion the motor moves in jerks; at one speed the ripple meets a "
    "resonance.",
    law="amplitude sin(waves θ + phase)",
    confused_with="Motor friction: it changes its sign with the direction, cogging does not. Motor "
    "torque offset: it is the same at every angle.",
    confirm="Turn the motor slowly at constant speed over several turns, forth and back, without "
    "load, and plot its torque over its angle: the waves of both directions lie above each other, "
    "apart by twice the friction.",
    cure="Skewed or slotless motors. In control subtract a table of the torque over the angle, or "
    "the sine that was found.",
    magnitude="1 to 5 % of the rated torque of a motor with iron teeth, nothing without. Waves a "
    "turn of the rotor: the least common multiple of poles and slots, times the gear ratio a turn "
    "of the pulley.",
    parameters=(
        Parameter(
            name="amplitude",
            unit="N.m",
            meaning="amplitude of the torque at the motor pulley",
            null=0.0,
            lower=0.0,
            upper=1.0e4,
            typical=lambda sizes: 0.05 * sizes.torque,
        ),
        Parameter(
            name="waves",
            unit="1",
            meaning="waves in a turn of the motor pulley",
            null=6.0,
            lower=0.1,
            upper=1.0e4,
            typical=6.0,
            shape=True,
        ),
        Parameter(
            name="phase",
            unit="rad",
            meaning="phase of the wave where the motor position is 0",
            null=0.0,
            lower=-3.141592653589793,
            upper=3.141592653589793,
            typical=0.8,
            shape=True,
            spread=Spread.TURN,
        ),
    ),
    equations=equations,
    reference="Z. Q. Zhu, D. Howe, Influence of design parameters on cogging torque in permanent "
    "magnet machines, IEEE Transactions on Energy Conversion 15(4), 2000",
)
