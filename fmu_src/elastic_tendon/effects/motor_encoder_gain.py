"""A motor encoder that shows more or less than the motor turns."""

from types import SimpleNamespace

from elastic_tendon.effects.base import Alias, Contribution, Effect, Parameter, Signal, Slot


def equations(
    at: Signal, p: SimpleNamespace, _state: SimpleNamespace, _mode: SimpleNamespace
) -> Contribution:
    """What the encoder shows beyond the motor position; its offset is not enlarged with it."""
    return Contribution(p.error * at.value)


EFFECT = Effect(
    id="motor_encoder_gain",
    title="Motor encoder gain",
    slot=Slot.MOTOR_SIGNAL,
    catalogue_order=172,
    on_request=True,
    physics="The motor's position is counted before a gear or a belt whose ratio is not what was "
    "set, or with other counts a turn, or is read by a potentiometer of another scale: the true "
    "motor position is the measured one, less the offset, over 1 + error.",
    in_data="The joint turns by more or less than the motor says it should, by the same share at "
    "every speed, in every slack state and in both directions: right where the motor is at zero, "
    "and most wrong at the ends of its range. What a load deflects is as it should be.",
    law="true motor position = (measured one - offset) / (1 + error)",
    confused_with="Joint encoder gain: alike, by a share of the other sign, but for what a load "
    "deflects, as far as stiffness and inertia are known. Motor encoder offset: it is as large "
    "where the motor is at zero. A wrong radius of the motor pulley: the same, unless the motor's "
    "torque is known. Pulley eccentricity: alike over less than half a turn of the motor.",
    confirm="Turn the motor's pulley by whole turns, told by a mark on it, and compare what the "
    "encoder counts with them. Measure the pulley with the tendon on it, as far as the middle of "
    "the tendon, to rule out its radius.",
    cure="Correct the ratio of the gear or the counts a turn in the drive; put the gain into the "
    "scale of the column (--map motor_position=COLUMN:rad*FACTOR).",
    magnitude="None for an encoder that counts on the pulley's own shaft; 1 to 3 % for the pitch "
    "radius of a belt or a rounded gear ratio, and any ratio where a number of teeth or counts is "
    "wrong.",
    parameters=(
        Parameter(
            name="error",
            unit="1",
            meaning="share by which the reading of the motor position is too large",
            null=0.0,
            lower=-0.9,
            upper=10.0,
            typical=0.02,
        ),
    ),
    equations=equations,
    reference="J. M. Hollerbach, C. W. Wampler, The calibration index and taxonomy for robot "
    "kinematic calibration methods, International Journal of Robotics Research 15(6), 1996",
    aliases=(
        Alias(
            of=("transmission.motor_pulley_radius",),
            when="the motor's torque is neither given nor measured and nothing depends on the "
            "motor's angle itself, as eccentricity and backlash do: a radius 1 + error times as "
            "small is then the same",
        ),
    ),
)
