"""Where a machine rests, and the torque under which it follows a motion, as a model expects it.

Where a torque drives the machine, an experiment is a motion that its controller follows: a torque
that is played to it as it is would let it drift away. A controller of the velocity is a damper
towards the velocity wanted, so the model itself tells the torque, from a simulation with so much
more damping.
"""

from math import pi
from typing import Any

import numpy as np

from elastic_tendon.actuator.interfaces import InterfaceKind
from elastic_tendon.actuator.parameters import Model
from elastic_tendon.actuator.variables import LINK, ROTOR, Body
from elastic_tendon.comparison.initial_state import contributed, estimate_initial_state
from elastic_tendon.comparison.residuals import Array, InitialState, simulate_measurement
from elastic_tendon.effects.base import Motor, Slot
from elastic_tendon.measurement import Measurement

FASTER = 5.0  # times the frequency up to which the joint follows: the controller's bandwidth
PER_SAMPLE = 0.3  # rad of the controller's bandwidth at most, so that samples show its torque
ROUNDS = 4  # in which the motion wanted is corrected by what the controller missed


def drive_of(kind: InterfaceKind) -> Body | None:
    """What a torque moves at an interface; None where the motor's position is given."""
    if not kind.has_springs:
        return LINK
    return ROTOR if kind.has_rotor else None


def at_rest(model: Model, start: float) -> InitialState:
    """State in which the model rests without load while the motor is held, or a link without
    springs.

    Parameters
    ----------
    model : Model
    start : position of the motor, or of a link without springs, rad

    Returns
    -------
    InitialState

    Raises
    ------
    SimulationError : the solver could not go on
    """
    kind = model.kind
    if not kind.has_springs:
        return InitialState(start)
    rotor = start if kind.has_rotor else 0.0
    if not kind.has_link:
        return InitialState(motor_position=rotor)
    unloaded = model.transmission.motor_share * start
    resting = Measurement(
        name="rest",
        time=np.arange(2.0),
        motor_position=np.full(2, start),
        signals={"joint_position": np.full(2, unloaded)},
        static=True,
    )
    held = estimate_initial_state(model.at_position(), resting)
    return InitialState(held.position, motor_position=rotor)


def following(
    model: Model, experiment: Measurement, initial: InitialState, motion: Array, frequency: float
) -> Array:
    """Torque of the drive under which the model follows a motion.

    Parameters
    ----------
    model : at an interface that a torque drives
    experiment : what else acts, at even times; its torque of the drive is not used
    initial : where the model starts, at rest
    motion : (n,) array, rad, of the motor or of a link without springs
    frequency : up to which the joint follows, Hz

    Returns
    -------
    (n,) array, N·m

    Raises
    ------
    SimulationError : the solver could not go on
    """
    drive = drive_of(model.kind)
    assert drive is not None  # as the interface says
    time = experiment.time
    bandwidth = min(2.0 * pi * FASTER * frequency, PER_SAMPLE / float(time[1] - time[0]))
    gain = _inertia(model) * bandwidth
    felt = _share_felt(model)
    values = model.values()
    damped = model.with_values({drive.damping: values[drive.damping] + felt * gain})
    wanted = motion
    for _ in range(ROUNDS):
        rate = np.gradient(wanted, time)
        given: dict[str, Any] = {drive.torque: gain * rate}
        moved = simulate_measurement(damped, experiment, initial, **given)
        wanted = wanted + motion - moved[drive.position]
    return np.asarray(gain * (rate - moved[drive.velocity]))


def _inertia(model: Model) -> float:
    """All that the drive moves, as it feels it, kg·m²."""
    if not model.kind.has_springs:
        return model.link.inertia
    link = model.link.inertia if model.kind.has_link else 0.0
    assert model.motor is not None  # as the interface says
    return model.motor.inertia + model.transmission.motor_share**2 * link


def _share_felt(model: Model) -> float:
    """Of a torque that is given, what the rotor feels: effects may make it more or less."""
    idle, driven = (
        contributed(model, Slot.MOTOR_TORQUE, Motor(0.0, 0.0, torque, load=0.0))
        for torque in (0.0, 1.0)
    )
    return 1.0 + driven - idle
