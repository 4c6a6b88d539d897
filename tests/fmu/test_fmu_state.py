"""Roll-back, serialisation, several instances, threads, reset."""

from concurrent.futures import ThreadPoolExecutor

import pytest
from fmpy.fmi1 import FMICallException
from fmu_cases import BOTH, motion

from fmu_driver import ERROR

pytestmark = BOTH

KINDS = ["slave", "model"]


def _steps(slave, first, last):
    """Step from the one sample to the other, with changing input; all values at the end."""
    segments = motion(slave.version == 2)
    for i in range(first, last):
        slave.set("motor_position", segments.position[i])
        if segments.linear:
            slave.set_rate("motor_position", segments.slope[i])
        slave.advance(segments.time[i], segments.time[i + 1] - segments.time[i])
    return slave.everything()


@pytest.fixture(params=["effects", "implicit"])
def name(request):
    return request.param


@pytest.fixture
def slave(fmus, instances, name):
    slave = instances(fmus(name).slave())
    slave.begin({"motor_position": 0.2})
    return slave


def test_replay_after_roll_back_is_the_same_to_the_bit(slave):
    _steps(slave, 0, 20)
    kept = slave.get_state()
    first = _steps(slave, 20, 60)
    for _ in range(2):  # the state can be used again
        slave.set_state(kept)
        assert slave.get("time") == pytest.approx(0.2)
        assert _steps(slave, 20, 60) == first
    slave.free_state(kept)


def test_serialised_state_goes_on_in_another_instance(fmus, instances, slave, name):
    _steps(slave, 0, 20)
    data = slave.snapshot()
    other = instances(fmus(name).slave(name="other"))
    other.restore(data)
    assert other.snapshot() == data
    assert _steps(other, 20, 60) == _steps(slave, 20, 60)


def test_states_of_other_models_or_interfaces_are_refused(fmus, instances, slave, name):
    data = slave.snapshot()
    for stranger in (fmus("base").slave(), fmus(name).model()):
        stranger = instances(stranger)
        before = stranger.snapshot()
        with pytest.raises(FMICallException):
            stranger.restore(data)
        assert stranger.snapshot() == before
        assert stranger.log[-1].status == ERROR


def test_damaged_bytes_are_refused(slave):
    """One bit at any place."""
    data = slave.snapshot()
    for place in range(len(data)):
        damaged = bytearray(data)
        damaged[place] ^= 1 << place % 8
        with pytest.raises(FMICallException):
            slave.restore(bytes(damaged))
    assert slave.snapshot() == data
    with pytest.raises(FMICallException):
        slave.restore(data[:-1])


def test_interleaved_instances_do_not_disturb_each_other(fmus, instances, slave, name):
    others = [instances(fmus(name).slave(name=f"n{i}")) for i in range(2)]
    for other in others:
        other.begin({"motor_position": 0.2})
    for i in range(60):
        one, two = (_steps(other, i, i + 1) for other in others)
    assert one == two == _steps(slave, 0, 60)


def test_instances_in_threads_do_not_disturb_each_other(fmus, instances, slave, name):
    """Two threads at once, each with an instance whose motor moves and one whose motor rests."""
    expected = _steps(slave, 0, 60)

    def moving_beside_resting(number):
        one, other = (fmus(name).slave(name=f"{number}{i}") for i in range(2))
        for each in (instances(one), instances(other)):
            each.begin({"motor_position": 0.2})
        for i in range(60):
            end = _steps(one, i, i + 1)
            other.advance(0.01 * i, 0.01)
        return end

    with ThreadPoolExecutor(2) as pool:
        assert list(pool.map(moving_beside_resting, range(2))) == [expected] * 2


@pytest.mark.parametrize("kind", KINDS)
def test_reset_is_as_just_instantiated(fmus, instances, kind, name):
    instance = instances(getattr(fmus(name), kind)())
    fresh = instance.snapshot()
    start = {"link.inertia": 0.05, "joint_position": 0.1, "motor_velocity_connected": True}
    instance.begin(start | {"motor_position": 0.3}, tolerance=1e-5, start_time=1.0, stop_time=9.0)
    if kind == "slave":
        instance.set("load_torque", 3.0)
        instance.advance(1.0, 0.5)
    else:
        instance.fmu.setTime(2.0)
        instance.fmu.enterEventMode()
    assert instance.snapshot() != fresh
    instance.fmu.reset()
    assert instance.snapshot() == fresh


def test_reset_after_termination(slave):
    slave.fmu.terminate()
    assert slave.status(*slave.stepping(0.0, 0.1)) == ERROR
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
