"""Operating points: what is given of them, and that nothing moves there."""

import numpy as np
import pytest
from linear_cases import with_typical

from elastic_tendon import load_model, simulate
from elastic_tendon.actuator.transmission import characteristic_torque
from elastic_tendon.errors import LinearisationError
from elastic_tendon.linear.equations import Equations
from elastic_tendon.linear.equilibrium import equilibrium
from elastic_tendon.linear.result import OperatingPoint

RATIO = 0.4  # r / R of the model below


@pytest.fixture(scope="module")
def model():
    """Asymmetric, with a gear ratio between the pulleys and gravity."""
    asymmetric = load_model("figure_7")
    radius = asymmetric.transmission.joint_pulley_radius
    changed = asymmetric.with_values({"transmission.motor_pulley_radius": RATIO * radius})
    return changed.with_effect("gravity_load", {"torque": 3.0, "angle": 0.3})


GIVEN = [
    {},
    {"load_torque": 4.0},
    {"motor_position": 0.7},
    {"joint_position": 0.2},
    {"deflection": -0.03},
    {"load_torque": -3.0, "motor_position": 0.7},
    {"load_torque": -3.0, "joint_position": 0.2},
    {"motor_position": 0.7, "joint_position": 0.3},
    {"motor_position": 0.7, "deflection": 0.05},
    {"joint_position": -0.4, "deflection": 0.05},
    {"joint_position": -0.4, "deflection": 0.05, "joint_velocity": 0.3},
]


@pytest.mark.parametrize("given", GIVEN, ids=lambda given: " ".join(given) or "nothing")
def test_what_is_given_holds_and_torques_balance(model, given):
    point = equilibrium(Equations(model), OperatingPoint(**given))
    motor, _, load = point.u
    joint, velocity = point.x
    values = {"motor_position": motor, "load_torque": load, "joint_position": joint}
    values |= {"deflection": joint - RATIO * motor, "joint_velocity": velocity}
    assert {name: values[name] for name in given} == pytest.approx(given, abs=1e-12)
    elastic = characteristic_torque(values["deflection"], model.transmission)
    gravity = -3.0 * np.sin(joint + 0.3)
    still = elastic + load + gravity - model.link.damping * velocity
    assert still == pytest.approx(0.0, abs=1e-9)


def test_the_missing_load_comes_before_the_missing_motor(model):
    point = equilibrium(Equations(model), OperatingPoint(joint_position=0.2))
    assert point.u[2] == 0.0
    point = equilibrium(Equations(model), OperatingPoint(load_torque=4.0))
    assert point.u[0] == 0.0


def test_nothing_moves_there(model):
    point = equilibrium(Equations(model), OperatingPoint(load_torque=4.0, motor_position=0.2))
    time = np.linspace(0.0, 1.0, 101)
    motion = simulate(
        *(model, time, np.full(101, point.u[0]), np.full(101, point.u[2])),
        initial_state={"joint_position": point.x[0]},
    )
    assert np.abs(motion["joint_position"] - point.x[0]).max() < 1e-9


def test_friction_is_none_in_the_middle_of_where_the_joint_sticks():
    base = load_model("biorob_x4_joint_3")
    rough = base.with_effect("coulomb_friction", {"torque": 0.35})
    point = OperatingPoint(load_torque=3.0)
    assert np.allclose(
        equilibrium(Equations(rough), point).x, equilibrium(Equations(base), point).x, atol=1e-12
    )
    moved = equilibrium(Equations(rough), OperatingPoint(load_torque=3.0, joint_velocity=0.2))
    expected = (3.0 - 0.35 - 0.2 * base.link.damping) / 41.688
    assert moved.x[0] == pytest.approx(expected)
    assert moved.u[1] == pytest.approx(0.2)


def test_a_play_does_not_stop_the_search():
    base = load_model("biorob_x4_joint_3")
    play = base.with_effect("gear_backlash", {"gap": 0.02})
    asked = OperatingPoint(load_torque=3.0)
    without, within = (equilibrium(Equations(machine), asked).x[0] for machine in (base, play))
    assert within - without == pytest.approx(0.01)


@pytest.mark.parametrize("effect_id", ["gear_backlash", "spring_relaxation", "spring_hardening"])
@pytest.mark.parametrize("load", [-8.7, 2.0, 5.0])
def test_load_and_joint_position_lead_back_to_the_motor(effect_id, load):
    plant = Equations(with_typical(load_model("biorob_x4_joint_3"), effect_id))
    there = equilibrium(plant, OperatingPoint(load_torque=load, motor_position=0.1))
    asked = OperatingPoint(load_torque=load, joint_position=float(there.x[0]))
    assert equilibrium(plant, asked).u[0] == pytest.approx(0.1, abs=1e-9)


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"load_torque": 1.0, "deflection": 0.1}, "the deflection follows from the load_torque"),
        (
            {"load_torque": 1.0, "motor_position": 0.1, "joint_position": 0.1},
            "load_torque, motor_position, joint_position are given, but two of them",
        ),
        ({"load_torque": float("nan")}, "load_torque is nan; give a finite number"),
        ({"load_torque": 200.0, "joint_velocity": float("inf")}, "joint_velocity is inf"),
        ({"load_torque": 1e300}, "no equilibrium is found with load_torque 1e\\+300"),
    ],
)
def test_what_cannot_be_given_is_told(model, given, told):
    with pytest.raises(LinearisationError, match=told):
        equilibrium(Equations(model), OperatingPoint(**given))
