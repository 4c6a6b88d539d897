"""Recordings of the independent simulator, and the models that are held against them."""

from dataclasses import dataclass

import numpy as np
import pytest

from elastic_tendon.actuator.parameters import Model, load_model
from elastic_tendon.measurement import Measurement
from truth.actuator import Actuator, Link, Spring
from truth.experiments import Limits, multisine
from truth.friction import Coulomb
from truth.noise import Sensor
from truth.sampling import sample
from truth.solver import simulate

NOISE = 2e-4  # rad, white
RATE = 500  # Hz; between slower samples the linear inputs err by more than the noise
DURATION = 5.0  # s
FRICTION = 0.35  # N·m


@dataclass(frozen=True)
class Machine:
    """What the recordings were made with, by dotted path; `model` believes other numbers.

    `noise` is the standard deviation of the recorded joint positions, rad.
    """

    truth: dict[str, float]
    model: Model
    noise: float = NOISE


def machine(friction: float) -> tuple[Machine, Actuator]:
    """BioRob-X4 joint 3 with parallel springs as one, numbers up to 12 % off the believed."""
    believed = load_model("biorob_x4_joint_3")
    truth = {
        "transmission.upper_spring.stiffness": 1.05 * 11580.0,
        "transmission.lower_spring.stiffness": 0.96 * 11580.0,
        "transmission.pretension_force": 0.9 * 80.0,
        "link.inertia": 1.12 * 0.03,
        "link.damping": 1.1 * 0.16,
    }
    if friction:
        truth["effects.coulomb_friction.torque"] = friction
    actuator = Actuator(
        joint_pulley_radius=0.03,
        motor_pulley_radius=0.03,
        pretension_force=truth["transmission.pretension_force"],
        upper=Spring(2.0 * truth["transmission.upper_spring.stiffness"], 0.015),
        lower=Spring(2.0 * truth["transmission.lower_spring.stiffness"], 0.015),
        link=Link(
            truth["link.inertia"],
            truth["link.damping"],
            Coulomb(friction) if friction else None,
        ),
    )
    return Machine(truth, believed), actuator


def record(actuator: Actuator, seed: int, *, load: float, start: float = 0.0) -> Measurement:
    """Multisine with load pulses, joint position with white noise."""
    experiment = multisine(seed, Limits(0.3, 4.0, load), DURATION)
    time = np.arange(round(DURATION * RATE)) / RATE
    table = sample(
        simulate(actuator, experiment, time), {"joint_position": Sensor(white=NOISE)}, seed
    )
    recording = Measurement(
        name=f"seed {seed}",
        time=table["time_s"],
        motor_position=table["motor_position_rad"],
        signals={"joint_position": table["joint_position_rad"]},
        load_torque=table["load_torque_Nm"] if load else None,
    )
    return recording.window(start, None) if start else recording


@pytest.fixture(scope="session")
def frictionless() -> tuple[Machine, Measurement]:
    """A machine that the model describes, but for its numbers."""
    known, actuator = machine(0.0)
    return known, record(actuator, 3, load=5.0)


@pytest.fixture(scope="session")
def sticking() -> tuple[Machine, Measurement, Measurement]:
    """A machine with Coulomb friction, which the model lacks; two recordings."""
    known, actuator = machine(FRICTION)
    return known, record(actuator, 4, load=5.0), record(actuator, 5, load=5.0, start=1.0)


@pytest.fixture(scope="session")
def unloaded() -> tuple[Machine, Measurement]:
    """The sticking machine moved by its motor alone: no load is known."""
    known, actuator = machine(FRICTION)
    return known, record(actuator, 6, load=0.0)
