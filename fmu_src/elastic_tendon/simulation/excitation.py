"""A motion to look at an actuator with, where the user has none."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastic_tendon.actuator.design import DesignTable, design
from elastic_tendon.actuator.motion_kind import MotionKind
from elastic_tendon.actuator.parameters import Model, sizes_of

Array = NDArray[np.float64]

DURATION = 10.0  # s
RATE = 500.0  # samples per s
RAMP = 1.0  # s in which the motion fades in, so that it starts from rest
MOTOR_AMPLITUDE = 0.3  # rad at the joint, of a machine that turns
# shares of the natural frequency with both tendons taut: slow enough to follow, fast enough
# to show the dynamics
MOTOR_FREQUENCIES = (0.05, 0.13, 0.31)
LOAD_FREQUENCY = 0.3  # Hz; the load comes and goes slowly, in both directions
BEYOND_SLACK = 1.3  # the load reaches this multiple of the torque at which a tendon goes slack
LARGEST_SHARE = 0.8  # ... but no more than this share of the largest torque


@dataclass(frozen=True)
class Excitation:
    """`time` (n,) s, `motor_position` (n,) rad at the motor pulley, `load_torque` (n,) N·m."""

    time: Array
    motor_position: Array
    load_torque: Array


def motor_amplitude(table: DesignTable) -> float:
    """How far a motor moves its joint to show what an actuator does, rad or m.

    How long the way of a machine that slides is, nothing says: as far as its springs may stretch.

    Parameters
    ----------
    table : DesignTable
    """
    if table.model.motion is MotionKind.ROTARY:
        return MOTOR_AMPLITUDE
    return min(abs(table.negative_max_deflection), abs(table.positive_max_deflection))


def default_excitation(model: Model) -> Excitation:
    """Ten seconds of smooth multisine on the motor and a slow load that slackens the tendons;
    without springs, of the load alone.

    Parameters
    ----------
    model : Model; its natural frequency and slack boundaries set the scale

    Returns
    -------
    Excitation with 5001 samples
    """
    time = np.arange(int(DURATION * RATE) + 1) / RATE
    ramp = np.sin(0.5 * np.pi * np.minimum(time / RAMP, 1.0)) ** 2
    swing = np.sin(2.0 * np.pi * LOAD_FREQUENCY * time)
    if not model.kind.has_springs:
        largest = sizes_of(model.transmission, model.link).torque
        return Excitation(time, np.zeros(len(time)), LARGEST_SHARE * largest * ramp * swing)
    table = design(model)
    sines = [
        np.sin(share * table.frequency_state_3 * time) / len(MOTOR_FREQUENCIES)
        for share in MOTOR_FREQUENCIES
    ]
    transmission = model.transmission
    ratio = transmission.joint_pulley_radius / transmission.motor_pulley_radius  # n_t, (9)
    slack = table.stiffness_state_3 * min(
        -table.negative_slack_boundary, table.positive_slack_boundary
    )
    largest = min(abs(table.negative_max_torque), abs(table.positive_max_torque))
    load = min(BEYOND_SLACK * slack, LARGEST_SHARE * largest)
    return Excitation(
        time=time,
        motor_position=ratio * motor_amplitude(table) * ramp * np.sum(sines, axis=0),
        load_torque=load * ramp * swing,
    )
