"""A motor pulley whose axis is not in its centre."""

from types import SimpleNamespace

from elastic_tendon.effects.base import Contribution, Effect, MotorAngle, Parameter, Slot, Spread
from elastic_tendon.effects.symbolic import sin


def equations(
    at: MotorAngle, p: SimpleNamespace, _state: SimpleNamespace, _mode: SimpleNamespace
) -> Contribution:
    """Once-per-turn error, zero where the motor position is zero."""
    error = p.amplitude * (sin(at.motor_position + p.phase) - sin(p.phase))
    return Contribution(at.motor_position + error)


EFFECT = Effect(
    id="pulley_eccentricity",
    title="Pulley eccentricity",
    slot=Slot.ANGLE_MAP,
    catalogue_order=140,
    physics="The motor pulley, or a gear before it, turns about an axis beside its centre, so the "
    "tendon moves a little more than it should in one half of a turn and less in the other.",
    in_data="An error of the joint's position that repeats with every turn of the motor pulley, "
    "the same in both directions of motion, at any load and in every slack state. When the motor "
    "turns fast it shakes the joint once per turn, most at the natural frequency.",
    law="pulley angle = θ + amplitude (sin(θ + phase) - sin(phase))",
    confused_with="Gravity load: a sine of the joint's angle, not of the motor's; its sag grows "
    "where a tendon is slack, this error does not. Joint encoder offset and motor encoder offset: "
    "alike over a small part of a turn. A wrong radius of a pulley and motor encoder gain: alike "
    "over less than half a turn.",
    confirm="Turn the motor slowly through a whole turn, or as far as the tendons allow, forth and "
    "back and without load. Plot joint position less r / R times motor position against motor "
    "position: one sine a turn, the same forth and back. Mounted a quarter of a turn further, the "
    "pulley shows the sine shifted by that quarter.",
    cure="Centre the pulley with a dial gauge, or bore it anew. In control subtract a table of the "
    "error over the motor's angle.",
    magnitude="Eccentricity over radius: 0.05 mm on a turned pulley of 20 mm radius makes 0.0025 "
    "rad, 0.4 mm on a printed or loosely fitted one 0.02 rad.",
    parameters=(
        Parameter(
            name="amplitude",
            unit="rad",
            meaning="amplitude of the error at the motor pulley: eccentricity over radius",
            null=0.0,
            lower=0.0,
            upper=0.5,
            typical=0.02,
        ),
        Parameter(
            name="phase",
            unit="rad",
            meaning="angle of the eccentricity where the motor position is 0",
            null=0.0,
            lower=-3.141592653589793,
            upper=3.141592653589793,
            typical=0.8,
            shape=True,
            spread=Spread.TURN,
        ),
    ),
    equations=equations,
    reference="W. D. Mark, Performance-Based Gear Metrology: Kinematic-Transmission-Error "
    "Computation and Diagnosis, Wiley, 2013",
)
