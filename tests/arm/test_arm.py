"""`Arm`: MuJoCo's links and our actuators in turns, against one solver for both, and by energy."""

import re
from itertools import pairwise

import mujoco
import numpy as np
import pytest
from arms import ACTUATORS, MJCF, robot

from elastic_tendon.actuator.parameters import load_model
from elastic_tendon.arm.arm import Arm
from elastic_tendon.errors import ArmError
from elastic_tendon.simulation.simulate import simulate

INERTIA, DAMPING, WEIGHT = 0.03, 0.16, 1.5  # kg m^2, N m s/rad, N m when level
PENDULUM = f"""
<mujoco>
  <option timestep="0.001" gravity="0 0 -10"/>
  <worldbody>
    <body>
      <joint name="joint" axis="0 -1 0" damping="{DAMPING}"/>
      <inertial pos="0 0 {-WEIGHT / 10}" mass="1"
        diaginertia="0.01 {INERTIA - (WEIGHT / 10) ** 2} 0.01"/>
    </body>
  </worldbody>
</mujoco>
"""
AMPLITUDE, RATE, DURATION = 0.4, 25.0, 1.0  # rad, rad/s, s; through slack


def _apart(step, **options):
    """Largest distance, rad, of the pendulum in MuJoCo from that of one solver."""
    pendulum = mujoco.MjModel.from_xml_string(PENDULUM)
    pendulum.opt.timestep = step
    model = load_model("biorob_x4_joint_3")
    arm = Arm(pendulum, {"joint": model}, **options)
    time = step * np.arange(1, round(DURATION / step) + 1)
    positions, slack = [], set()
    for motor, rate in zip(
        AMPLITUDE * (1 - np.cos(RATE * time)), AMPLITUDE * RATE * np.sin(RATE * time), strict=True
    ):
        arm.step([motor], [rate])
        positions.append(arm.joint_position[0])
        slack.add(int(arm.actuators["slack_state"][0]))
    assert slack == {1, 2, 3}
    whole = model.with_values({"link.inertia": INERTIA, "link.damping": DAMPING})
    whole = whole.with_effect("gravity_load", {"torque": WEIGHT, "angle": 0.0})
    time = np.append(0.0, time)
    motor = AMPLITUDE * (1 - np.cos(RATE * time))
    run = simulate(whole, time, motor, interpolation="cubic")
    return np.abs(run["joint_position"][1:] - positions).max()


@pytest.mark.parametrize("semi_implicit", [False, True])
def test_it_tends_to_one_solver_for_both_as_the_step_halves(semi_implicit):
    errors = [_apart(step, semi_implicit=semi_implicit) for step in (1e-3, 5e-4, 2.5e-4)]
    for longer, shorter in pairwise(errors):
        assert 1.8 < longer / shorter < 2.2  # of first order, as MuJoCo's step


def _energy(arm):
    """Of links and springs, J."""
    mujoco.mj_energyPos(arm.robot, arm.data)
    mujoco.mj_energyVel(arm.robot, arm.data)
    springs = 0.0
    for side in ("upper", "lower"):
        force = arm.actuators[f"{side}_spring_force"]
        for pull, model in zip(force, arm.actuators.models, strict=True):
            spring = getattr(model.transmission, f"{side}_spring")
            springs += pull**2 / (2 * spring.parallel * spring.stiffness)
    return sum(arm.data.energy) + springs


@pytest.mark.parametrize("passes", [None, {("elbow", "shoulder"): 0.6, ("wrist", "elbow"): -0.5}])
def test_energy_is_kept_also_where_tendons_pass_other_joints(passes):
    """Which holds only if what passes a joint turns it by the torque that the deflection costs."""
    drifts = []
    for step in (4e-4, 2e-4):
        free = robot()
        free.dof_damping[:] = 0.0
        free.opt.timestep = step
        arm = Arm(free, ACTUATORS, passes=passes)
        arm.data.qvel[:] = [2.0, -1.5, 3.0, 4.0]
        before, furthest = _energy(arm), 0.0
        for _ in range(round(0.4 / step)):
            arm.step(arm.motor_position, 0.0)
            furthest = max(furthest, abs(_energy(arm) - before))
        drifts.append(furthest / before)
    assert drifts[0] < 0.05
    assert drifts[1] < 0.6 * drifts[0]


def test_it_rests_where_its_motors_hold_it():
    arm = Arm(robot(), ACTUATORS)
    pose = np.array([0.4, -0.6, 1.0, 0.3])
    arm.reset(pose)
    for _ in range(500):
        arm.step(arm.motor_position, 0.0)
    assert arm.joint_position == pytest.approx(pose, abs=1e-9)
    assert np.abs(arm.actuators["deflection"]).max() > 0.02


def test_what_drove_an_arm_before_is_forgotten_at_reset():
    arm = Arm(robot(), ACTUATORS, semi_implicit=True)
    ways = []
    for _ in range(2):
        arm.reset()
        for _ in range(100):
            arm.step([0.1, 0.2, 0.3, 0.4], 0.0)
        ways.append(arm.joint_position)
    assert (ways[0] == ways[1]).all()


def test_one_elastic_joint_leaves_the_others_free():
    arm = Arm(robot(), {"shoulder": ACTUATORS["shoulder"]})
    assert repr(arm) == "Arm of 4 joints (base, shoulder, elbow, wrist), elastic: shoulder"
    hand = arm.data.qpos[3]
    for _ in range(200):
        arm.step(arm.motor_position, 0.0)
    assert abs(arm.joint_position[0]) < 0.2
    assert abs(arm.data.qpos[3] - hand) > 0.1


@pytest.mark.parametrize(
    ("actuators", "options", "words"),
    [
        ({}, {}, "no joint has an actuator; the robot has base, shoulder, elbow, wrist"),
        ({"knee": ACTUATORS["elbow"]}, {}, "no joint 'knee'; it has base, shoulder, elbow, wrist"),
        (
            ACTUATORS,
            {"passes": {("elbow", "knee"): 1.0}},
            "passes names 'knee', which has no actuator",
        ),
        (ACTUATORS, {"passes": {("elbow", "elbow"): 1.0}}, "the tendons of elbow end there"),
        (
            ACTUATORS,
            {"passes": {("elbow", "base"): 1.0}, "semi_implicit": True},
            "semi_implicit needs tendons that move one joint each",
        ),
    ],
)
def test_what_cannot_be_driven_is_refused_in_a_sentence(actuators, options, words):
    with pytest.raises(ArmError, match=words):
        Arm(robot(), actuators, **options)


def test_robots_that_cannot_be_driven_are_refused_in_a_sentence():
    runge_kutta = robot()
    runge_kutta.opt.integrator = mujoco.mjtIntegrator.mjINT_RK4
    with pytest.raises(ArmError, match=r"set robot\.opt\.integrator to Euler or implicitfast"):
        Arm(runge_kutta, ACTUATORS)
    slide = PENDULUM.replace('name="joint"', 'name="joint" type="slide"')
    with pytest.raises(ArmError, match="joint joint is no hinge"):
        Arm(mujoco.MjModel.from_xml_string(slide), {"joint": ACTUATORS["elbow"]})
    backwards = ACTUATORS["elbow"].with_effect("coulomb_friction", {"torque": 0.1})
    with pytest.raises(ArmError, match="at elbow has coulomb_friction, beyond the springs; give"):
        Arm(robot(), {"elbow": backwards})
    with pytest.raises(ArmError, match=r"shape \(2,\), but 4 joints have actuators \(base, "):
        Arm(robot(), ACTUATORS).reset([0.0, 0.0])


def test_the_example_for_your_own_arm_runs_as_printed(monkeypatch, capsys):
    monkeypatch.chdir(MJCF.parents[2])
    (block,) = re.findall(r"```python\n(.*?)```", MJCF.with_name("README.md").read_text(), re.S)
    exec(block, {})
    assert capsys.readouterr().out.startswith("[")


def test_without_mujoco_it_says_what_to_install(monkeypatch):
    import sys

    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(ArmError, match=r'pip install "elastic-tendon\[mujoco\]"'):
        Arm(None, ACTUATORS)
