"""The largest stable step, against closed forms and against arms that run beside it."""

import re

import numpy as np
import pytest
from arms import ACTUATORS, robot

from elastic_tendon.arm.arm import Arm
from elastic_tendon.arm.stability import largest_stable_step
from elastic_tendon.errors import ArmError, SimulationError

KICK = 1e-6  # rad/s; so small that no tendon goes slack while it grows
BOUNDED, GROWN = 5.0, 1e3  # times the largest deviation of the first steps


@pytest.fixture(autouse=True)
def _beside(monkeypatch, tmp_path):
    """MuJoCo writes of what is unstable into the folder where it runs."""
    monkeypatch.chdir(tmp_path)


def test_one_joint_without_damping_takes_twice_its_natural_time():
    assert largest_stable_step([[0.03]], [[40.0]], [[0.0]]) == pytest.approx(
        2 / np.sqrt(40.0 / 0.03), rel=1e-6
    )


def test_damping_of_one_joint_shortens_the_step_as_the_closed_form_says():
    """h² k/m + 2 h d/m = 4, where the eigenvalue -1 appears."""
    mass, stiffness, damping = 0.03, 40.0, 0.7
    squared, linear = stiffness / mass, 2 * damping / mass
    expected = (-linear + np.sqrt(linear**2 + 16 * squared)) / (2 * squared)
    found = largest_stable_step([[mass]], [[stiffness]], [[damping]])
    assert found == pytest.approx(expected, rel=1e-6)


def test_of_many_joints_the_fastest_mode_decides():
    mass = np.array([[0.5, 0.1], [0.1, 0.05]])
    stiffness = np.diag([50.0, 40.0])
    fastest = np.sqrt(np.linalg.eigvals(np.linalg.solve(mass, stiffness)).max())
    assert largest_stable_step(mass, stiffness, 0 * mass) == pytest.approx(2 / fastest, rel=1e-6)


def test_a_step_that_is_told_the_slope_is_always_stable():
    matrices = ([[0.03]], [[40.0]], [[0.7]])
    told = {"given_stiffness": matrices[1], "given_damping": matrices[2]}
    assert largest_stable_step(*matrices, **told) == np.inf
    assert largest_stable_step([[1.0]], [[0.0]], [[0.0]]) == np.inf


def deviation(arm, step, steps=400):
    """Largest deviation from rest, rad, in the first three steps and in the last ones."""
    arm.robot.opt.timestep = step
    rest, motor = arm.joint_position, arm.motor_position
    arm.data.qvel[:] = KICK
    far = []
    for _ in range(steps):
        arm.step(motor, 0.0)
        far.append(np.abs(arm.joint_position - rest).max())
    return max(far[:3]), max(far[-20:])


def grows(arm, step):
    try:
        first, last = deviation(arm, step)
    except SimulationError:
        return True
    assert last < BOUNDED * first or last > GROWN * first  # nothing between
    return bool(last > GROWN * first)


@pytest.mark.parametrize("pose", [(0.0, 0.0, 0.0, 0.0), (0.3, -0.4, 0.9, 0.5)])
def test_the_arm_is_stable_below_the_step_and_unstable_above(pose):
    for share, unstable in ((0.97, False), (1.03, True)):
        arm = Arm(robot(), ACTUATORS)
        arm.reset(pose)
        assert grows(arm, share * arm.largest_stable_step()) is unstable


def test_semi_implicit_it_is_stable_where_explicit_it_is_not():
    arm = Arm(robot(), ACTUATORS, semi_implicit=True)
    limit = arm.largest_stable_step(semi_implicit=False)
    assert arm.largest_stable_step() == np.inf
    assert grows(Arm(robot(), ACTUATORS), 1.03 * limit)
    assert not grows(arm, 10 * limit)


def test_what_hysteresis_adds_in_a_step_limits_a_semi_implicit_one():
    model = ACTUATORS["elbow"].with_effect(
        "spring_hysteresis", {"force": 60.0, "yield_length": 1e-3, "exponent": 1.0}
    )
    sides = []
    for share in (0.95, 1.05):
        arm = Arm(robot(), ACTUATORS | {"elbow": model}, semi_implicit=True)
        limit = arm.largest_stable_step()
        assert arm.largest_stable_step(semi_implicit=False) < limit < np.inf
        sides.append(grows(arm, share * limit))
    assert sides == [False, True]


def test_a_step_that_is_unstable_is_refused_with_both_figures():
    long = robot()
    long.opt.timestep = 0.05
    limit = re.escape(f"{1e3 * Arm(robot(), ACTUATORS).largest_stable_step():.3g}")
    words = rf"step of 50 ms is longer than {limit} ms.*let the arm be semi_implicit"
    with pytest.raises(ArmError, match=words):
        Arm(long, ACTUATORS)
    assert len(Arm(long, ACTUATORS, semi_implicit=True).joints) == 4


def test_an_arm_that_becomes_unstable_says_when():
    arm = Arm(robot(), ACTUATORS)
    with pytest.raises(SimulationError, match=r"unstable at .* s; set robot\.opt\.timestep to"):
        deviation(arm, 0.05, 2000)
