"""Co-simulation without `motor_velocity`: its difference between communication points stands in."""

import numpy as np
import pytest
from fmu_cases import BOTH, FMI3

STEP = 1e-3  # s
N = 500
SPEED = 0.6  # rad/s


@pytest.fixture
def slave(fmus, instances):
    """Makes an instance of the damped model, begun."""

    def make(start=None, **options):
        made = instances(fmus("damped").slave(**options))
        made.begin(start or {}, tolerance=1e-8)
        return made

    return make


def _swing(slave, *, connected):
    """Joint position after each step of a motor that swings."""
    found = []
    for i in range(N):
        time = i * STEP
        slave.set("motor_position", 0.4 * np.sin(8.0 * time))
        if connected:
            slave.set("motor_velocity", 3.2 * np.cos(8.0 * time))
        slave.advance(slave.get("time"), STEP)
        found.append(slave.get("joint_position"))
    return np.array(found)


@BOTH
def test_it_is_nearly_as_good_as_the_velocity_itself(slave):
    connected, still = (slave({"motor_velocity_connected": True}) for _ in range(2))
    exact = _swing(connected, connected=True)
    derived = _swing(slave(), connected=False)
    assert np.abs(_swing(still, connected=False) - exact).max() > 5e-3
    assert np.abs(derived - exact).max() < 3e-4


@BOTH
def test_it_goes_back_with_the_state(slave):
    """And a step to a point that was tried before is no new point."""
    one = slave()
    _swing(one, connected=False)
    data, time = one.snapshot(), one.get("time")
    ends = []
    for _ in range(2):
        one.restore(data)
        for i in range(3):
            one.set("motor_position", 0.1 * i)
            one.advance(time + i * STEP, STEP)
        ends.append(one.everything())
    assert ends[0] == ends[1]


@BOTH
def test_a_motor_that_rests_has_none(slave):
    """Moved in one step, then held: as if held with the velocity 0 from one step later on."""
    one, still = slave(), slave({"motor_velocity_connected": True})
    for each in (one, still):
        for i in range(20):
            each.set("motor_position", 0.0 if i < 5 else 0.02)
            if each is still:
                each.set("motor_velocity", 0.02 / STEP if i == 5 else 0.0)
            each.advance(i * STEP, STEP)
    assert one.get("joint_position") == pytest.approx(still.get("joint_position"), abs=1e-12)


def _ramp(slave):
    """Joint position at the end of a ramp given at communication points; events met on the way."""
    events = 0
    for i in range(100):
        slave.set("motor_position", SPEED * i * STEP)
        time, goal = i * STEP, (i + 1) * STEP
        while time < goal:
            end = slave.advance(time, goal - time)
            time = end.time
            if end.event:
                events += 1
                slave.fmu.enterEventMode()
                slave.iterate_events()
    return slave.get("joint_position"), events


@FMI3
def test_it_outlives_an_event_in_the_middle_of_a_step(slave):
    start = {"joint_velocity": 8.0}
    inside, _ = _ramp(slave(start))
    found, events = _ramp(slave(start, event_mode=True, early_return=True))
    assert events > 0
    assert abs(found - inside) < 1e-6
    velocity = {"motor_velocity": SPEED, "motor_velocity_connected": True}
    assert abs(inside - _ramp(slave(start | velocity))[0]) < 1e-3


@FMI3
def test_a_position_set_inside_a_step_is_a_point_too(slave):
    def move(one, told):
        one.set("motor_position", SPEED * told.time)

    start = {"joint_velocity": 8.0}
    moved = slave(start, update=move, required=("motor_position",))
    moved.advance(0.0, 0.1)
    assert abs(moved.get("joint_position") - _ramp(slave(start))[0]) < 5e-3
    assert moved.get("joint_torque") != 0.0
