"""Roll-back, serialisation, several instances, reset."""

import pytest
from fmpy.fmi1 import FMICallException
from fmu_cases import motion

from fmu_driver import ERROR

KINDS = ["slave", "model"]


def _steps(slave, first, last):
    """Step from the one sample to the other, with changing input; all values at the end."""
    segments = motion(True)
    for i in range(first, last):
        slave.set("motor_position", segments.position[i])
        slave.set_rate("motor_position", segments.slope[i])
        slave.fmu.doStep(segments.time[i], segments.time[i + 1] - segments.time[i])
    return slave.everything()


@pytest.fixture
def slave(fmus, instances):
    slave = instances(fmus("effects").slave())
    slave.begin({"motor_position": 0.2})
    return slave


def test_replay_after_roll_back_is_the_same_to_the_bit(slave):
    _steps(slave, 0, 20)
    kept = slave.fmu.getFMUstate()
    first = _steps(slave, 20, 60)
    for _ in range(2):  # the state can be used again
        slave.fmu.setFMUstate(kept)
        assert slave.get("time") == pytest.approx(0.2)
        assert _steps(slave, 20, 60) == first
    slave.fmu.freeFMUstate(kept)


def test_serialised_state_goes_on_in_another_instance(fmus, instances, slave):
    _steps(slave, 0, 20)
    data = slave.snapshot()
    other = instances(fmus("effects").slave(name="other"))
    other.restore(data)
    assert other.snapshot() == data
    assert _steps(other, 20, 60) == _steps(slave, 20, 60)


def test_states_of_other_models_or_interfaces_are_refused(fmus, instances, slave):
    data = slave.snapshot()
    for stranger in (fmus("base").slave(), fmus("effects").model()):
        stranger = instances(stranger)
        before = stranger.snapshot()
        with pytest.raises(FMICallException):
            stranger.restore(data)
        assert stranger.snapshot() == before
        assert stranger.log[-1].status == ERROR


@pytest.mark.parametrize("place", [0, 4, 8, 20])
def test_damaged_bytes_are_refused(slave, place):
    data = bytearray(slave.snapshot())
    data[place] ^= 1
    with pytest.raises(FMICallException):
        slave.restore(bytes(data))


def test_interleaved_instances_do_not_disturb_each_other(fmus, instances, slave):
    others = [instances(fmus("effects").slave(name=f"n{i}")) for i in range(2)]
    for other in others:
        other.begin({"motor_position": 0.2})
    for i in range(60):
        one, two = (_steps(other, i, i + 1) for other in others)
    assert one == two == _steps(slave, 0, 60)


@pytest.mark.parametrize("kind", KINDS)
def test_reset_is_as_just_instantiated(fmus, instances, kind):
    instance = instances(getattr(fmus("effects"), kind)())
    fresh = instance.snapshot()
    start = {"link.inertia": 0.05, "joint_position": 0.1, "motor_velocity_connected": True}
    instance.begin(start | {"motor_position": 0.3}, tolerance=1e-5, start_time=1.0, stop_time=9.0)
    if kind == "slave":
        instance.set_rate("load_torque", 3.0)
        instance.fmu.doStep(1.0, 0.5)
    else:
        instance.fmu.setTime(2.0)
        instance.fmu.fmi2EnterEventMode(instance.fmu.component)
    assert instance.snapshot() != fresh
    instance.fmu.reset()
    assert instance.snapshot() == fresh


def test_reset_after_termination(slave):
    slave.fmu.terminate()
    assert slave.status("fmi2DoStep", 0.0, 0.1, 1) == ERROR
    slave.fmu.reset()
    slave.begin({"motor_position": 0.2})
    assert _steps(slave, 0, 3)["joint_position"] != 0


def test_looking_at_outputs_has_no_consequences(slave):
    """Outputs show the modes that the inputs of now will bring; only a step brings them."""
    before = slave.snapshot()
    assert slave.get("slack_state") == 1
    slave.set("motor_position", -0.2)
    assert slave.get("slack_state") == 2
    slave.set("motor_position", 0.2)
    assert slave.get("slack_state") == 1
    assert slave.snapshot() == before
