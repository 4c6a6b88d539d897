"""Slots and powers that no effect of the catalogue uses yet, with effects made for the purpose.

Each is compared with scipy on equations written out here.
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from elastic_tendon import effects
from elastic_tendon.actuator.parameters import load_model
from elastic_tendon.effects.base import Contribution, Effect, Parameter, Slot, State
from elastic_tendon.effects.symbolic import where
from elastic_tendon.simulation.simulate import simulate

TIME = np.arange(0.0, 1.5, 0.01)
RADIUS, STIFFNESS, PRETENSION, INERTIA, DAMPING = 0.03, 23160.0, 80.0, 0.03, 0.16
AGREEMENT = 1e-8  # rad, of two integrators at 1e-11


def _number(name, unit):
    return Parameter(name, unit, "of a test", 0.0, 0.0, 1e6, 1.0)


def _effect(name, slot, parameters, equations, **more):
    return Effect(name, name, slot, "Test.", "Test.", parameters, equations, "none", **more)


TILT = _effect(
    "tilt",
    Slot.JOINT_TORQUE,
    (_number("torque", "N.m"),),
    lambda at, p, _state, _mode: Contribution(-p.torque * at.position),
)
RIPPLE = _effect(
    "ripple",
    Slot.ANGLE_MAP,
    (_number("amplitude", "rad"),),
    lambda at, p, _state, _mode: Contribution(
        at.motor_position + p.amplitude * at.motor_position**2
    ),
)
MAXWELL = _effect(
    "maxwell",
    Slot.SPRING_LAW,
    (_number("stiffness", "N/m"), _number("time_constant", "s")),
    lambda at, p, state, _mode: Contribution(
        p.stiffness * (at.elongation - state.creep),
        rates={
            "creep": where(p.time_constant > 0, (at.elongation - state.creep) / p.time_constant, 0)
        },
    ),
    states=(State("creep", "m", "elongation of the damper", 0.01),),
)


@pytest.fixture
def model(monkeypatch):
    def with_effect(effect, numbers):
        monkeypatch.setitem(effects.BY_ID, effect.id, effect)
        return load_model("biorob_x4_joint_3").with_effect(effect.id, numbers)

    return with_effect


def motor(time):
    return 0.2 * np.sin(9.0 * time)


def reference(spring_force, torque=lambda _q: 0.0, angle=lambda theta: theta, extra=0):
    """Joint position from scipy; `spring_force(elongation, memory)` gives force and memory rate."""

    def rates(time, state):
        q, velocity, *memory = state
        stretch = RADIUS * (angle(motor(time)) - q)
        sides = [(1, memory[:extra]), (-1, memory[extra:])]
        forces, memory_rates = [], []
        for sign, own in sides:
            force, rate = spring_force(PRETENSION / STIFFNESS + sign * stretch, own)
            forces.append(max(force, 0.0))
            memory_rates += rate
        pull = RADIUS * (forces[0] - forces[1]) + torque(q) - DAMPING * velocity
        return [velocity, pull / INERTIA, *memory_rates]

    start = np.zeros(2 + 2 * extra)
    return solve_ivp(
        rates, (0, TIME[-1]), start, "DOP853", TIME, rtol=1e-11, atol=1e-12, max_step=1e-3
    ).y[0]


def simulated(model):
    # inputs as dense as makes the spline exact to the agreement asked for
    fine = np.linspace(0.0, TIME[-1], 10 * (TIME.size - 1) + 1)
    motion = simulate(model, fine, motor(fine), interpolation="cubic", tolerance=1e-11)
    return motion["joint_position"][::10]


def linear(elongation, _memory):
    return STIFFNESS * elongation, []


def test_joint_torque(model):
    expected = reference(linear, torque=lambda q: -6.0 * q)
    assert np.abs(simulated(model(TILT, {"torque": 6.0})) - expected).max() < AGREEMENT


def test_angle_map(model):
    expected = reference(linear, angle=lambda theta: theta + 0.5 * theta**2)
    assert np.abs(simulated(model(RIPPLE, {"amplitude": 0.5})) - expected).max() < AGREEMENT


def test_spring_law_with_a_state_in_each_spring(model):
    branch, time_constant = 3000.0, 0.05  # N/m of one spring, of two side by side

    def force(elongation, memory):
        (creep,) = memory
        own = STIFFNESS * elongation + 2 * branch * (elongation - creep)
        return own, [(elongation - creep) / time_constant]

    numbers = {"stiffness": branch, "time_constant": time_constant}
    expected = reference(force, extra=1)
    assert np.abs(simulated(model(MAXWELL, numbers)) - expected).max() < AGREEMENT
