"""Coulomb friction against closed forms: sticking, break-away and stopping."""

import numpy as np
import pytest

from elastic_tendon.actuator.parameters import load_model
from elastic_tendon.actuator.system import HYSTERESIS
from elastic_tendon.simulation.simulate import simulate

TORQUE = 0.5  # N·m


@pytest.fixture
def model():
    base = load_model("biorob_x4_joint_3").with_values({"link.damping": 0.0})
    return base.with_effect("coulomb_friction", {"torque": TORQUE})


def stiffness(model):
    transmission = model.transmission
    return transmission.joint_pulley_radius**2 * (
        transmission.upper_spring.combined_stiffness + transmission.lower_spring.combined_stiffness
    )


def test_joint_holds_exactly_still_below_the_friction_torque(model):
    time = np.linspace(0.0, 1.0, 101)
    motion = simulate(model, time, 0 * time, 0.99 * TORQUE * time)
    assert not motion["joint_position"].any()
    assert not motion["joint_velocity"].any()


def test_breaks_away_when_the_load_exceeds_the_friction_torque(model):
    time = np.array([0.0, 1.0])
    motion = simulate(model, time, 0 * time, 2 * TORQUE * time)  # reaches it at 0.5 s
    transmission = model.transmission
    scale = transmission.joint_pulley_radius * transmission.upper_spring.largest_force
    dead_band = HYSTERESIS * scale / (2 * TORQUE)  # s, at this rate of loading
    assert motion.event_times[0] - 0.5 == pytest.approx(dead_band, rel=0.1)


def test_decays_by_twice_the_friction_angle_each_half_period_and_then_sticks(model):
    k = stiffness(model)
    frequency = np.sqrt(k / model.link.inertia)
    release = 0.1  # rad, inside the taut range
    time = np.linspace(0.0, 2.0, 2001)
    motion = simulate(
        model, time, 0 * time, initial_state={"joint_position": release}, tolerance=1e-11
    )
    friction_angle = TORQUE / k
    swings = int((release / friction_angle + 1) / 2)  # half periods until it sticks
    rest = (-1) ** swings * (release - 2 * swings * friction_angle)
    assert motion["joint_position"][-1] == pytest.approx(rest, abs=1e-9)
    assert motion["joint_velocity"][-1] == 0.0
    turns = np.arange(1, swings + 1) * np.pi / frequency
    assert np.allclose(motion.event_times[:swings], turns, atol=1e-9)


def test_sliding_against_a_constant_load_stops_where_energy_says(model):
    """A link so soft that springs do not matter slides v^2 J / (2 T)."""
    soft = model.with_values(
        {
            "transmission.upper_spring.stiffness": 20.0,
            "transmission.lower_spring.stiffness": 20.0,
            "transmission.pretension_force": 0.0,
            "transmission.joint_pulley_radius": 0.0005,
            "transmission.motor_pulley_radius": 0.0005,
        }
    )
    time = np.linspace(0.0, 1.0, 1001)
    motion = simulate(soft, time, 0 * time, initial_state={"joint_velocity": 2.0}, tolerance=1e-11)
    distance = 2.0**2 * soft.link.inertia / (2 * TORQUE)
    # the springs still hold 5e-6 N·m per rad against 0.5 N·m
    assert motion["joint_position"][-1] == pytest.approx(distance, rel=2e-5)
