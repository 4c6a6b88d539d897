"""Where a machine rests, and the torque under which it follows a motion, as a model expects it.

Where a torque drives the machine, an experiment is a motion that its controller follows: a torque
that is played to it as it is would let it drift away. A controller of the velocity is a damper
towards the velocity wanted, so the model itself tells the torque, from a simulation with so much
more damping.
"""

from dataclasses import dataclass
from math import pi
from types import SimpleNamespace
from typing import Any

import numpy as np

from elastic_tendon.actuator.interfaces import InterfaceKind
from elastic_tendon.actuator.parameters import Model
from elastic_tendon.actuator.variables import LINK, ROTOR, Body, interface
from elastic_tendon.comparison.initial_state import estimate_initial_state
from elastic_tendon.comparison.residuals import Array, InitialState, simulate_measurement
from elastic_tendon.effects.base import Contribution, Motor, Slot
from elastic_tendon.measurement import Measurement

FASTER = 5.0  # times the frequency up to which the joint follows: the controller's bandwidth
PER_SAMPLE = 0.3  # rad of the controller's bandwidth at most, so that samples show its torque
ROUNDS = 4  # in which the motion wanted is corrected by what the controller missed


@dataclass(frozen=True)
class Drive:
    """What a torque moves: the body, and the names of the torque and of its section's damping."""

    body: Body
    torque: str
    damping: str


_OF_ROTOR = Drive(ROTOR, "motor_torque", "motor.damping")
_OF_LINK = Drive(LINK, "load_torque", "link.damping")


def drive_of(kind: InterfaceKind) -> Drive | None:
    """What a torque moves at an interface; None where the motor's position is given."""
    if not kind.has_springs:
        return _OF_LINK
    return _OF_ROTOR if kind.has_rotor else None


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
        wanted = wanted + motion - moved[drive.body.position]
    return np.asarray(gain * (rate - moved[drive.body.velocity]))


def _inertia(model: Model) -> float:
    """All that the drive moves, as it feels it, kg·m²."""
    if not model.kind.has_springs:
        return model.link.inertia
    link = model.link.inertia if model.kind.has_link else 0.0
    assert model.motor is not None  # as the interface says
    return model.motor.inertia + model.transmission.motor_share**2 * link


def _share_felt(model: Model) -> float:
    """Of a torque that is given, what the rotor feels: effects may make it more or less."""

    def added(torque: float) -> float:
        at = Motor(0.0, 0.0, torque, load=0.0)
        total = 0.0
        for effect in interface(*model.structure).effects:
            if effect.slot is Slot.MOTOR_TORQUE:
                numbers, none = SimpleNamespace(**model.effects[effect.id]), SimpleNamespace()
                contribution = effect.equations(at, numbers, none, none)
                assert isinstance(contribution, Contribution)  # as its slot says
                total += float(contribution.value)
        return total

    return 1.0 + added(1.0) - added(0.0)
