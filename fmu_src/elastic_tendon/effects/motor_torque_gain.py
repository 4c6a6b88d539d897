"""A motor torque that is larger or smaller than it is said to be."""

from types import SimpleNamespace

from elastic_tendon.effects.base import Contribution, Effect, Motor, Parameter, Slot


def equations(
    at: Motor, p: SimpleNamespace, _state: SimpleNamespace, _mode: SimpleNamespace
) -> Contribution:
    """What the motor exerts beyond the torque that is given."""
    return Contribution(p.error * at.torque)


EFFECT = Effect(
    id="motor_torque_gain",
    title="Motor torque gain",
    slot=Slot.MOTOR_TORQUE,
    catalogue_order=330,
    physics="The torque is known by the current only, and its constant, the gear ratio or the "
    "efficiency is not what the data sheet says: the motor exerts more or less than is said.",
    in_data="An error of the motor's acceleration, and of the load that it holds at rest, in "
    "proportion to the motor torque: the same in both directions, at every speed and in every "
    "slack state.",
    law="error τ",
    confused_with="Motor friction: its torque has one size, whatever the motor's is. A wrong "
    "inertia of the motor (motor.inertia): alike where the motor only accelerates; where the "
    "springs or a known load hold against it, only the gain is wrong. Gear loss: it opposes the "
    "motion, so it changes its side where the load drives the motor.",
    confirm="Hold the joint against a force gauge or hang a known mass on the link, let the motor "
    "hold it still, and compare its torque with that of the load, raised and lowered to cancel "
    "friction.",
    cure="Calibrate the torque constant with a known load; put it into the scale of the column "
    "(--map motor_torque=COLUMN:Nm*FACTOR).",
    magnitude="5 to 10 % tolerance of a torque constant, less of it when the magnets are warm; 10 "
    "to 30 % where a gear's efficiency was left out.",
    parameters=(
        Parameter(
            name="error",
            unit="1",
            meaning="share by which the torque of the motor is larger than what is given",
            null=0.0,
            lower=-0.9,
            upper=10.0,
            typical=0.1,
        ),
    ),
    equations=equations,
    reference="J. Swevers, W. Verdonck, J. De Schutter, Dynamic model identification for "
    "industrial robots, IEEE Control Systems Magazine 27(5), 2007",
)
