"""Roll-back, serialisation, several instances, threads, reset."""

from concurrent.futures import ThreadPoolExecutor

import pytest
from fmpy.fmi1 import FMICallException
from fmu_cases import BOTH, motion
from refusals import check_refused

from fmu_driver import DISCARD, ERROR

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


@pytest.mark.parametrize("kind", KINDS)
def test_a_state_set_shows_at_once(fmus, instances, kind, name):
    """What is read next belongs to the state, not to what was read before."""
    instance = instances(getattr(fmus(name), kind)())
    instance.begin({"motor_position": 0.2})
    taken, kept, data = instance.everything(), instance.get_state(), instance.snapshot()
    for go_back in (lambda: instance.set_state(kept), lambda: instance.restore(data)):
        if kind == "slave":
            instance.advance(0.0, 0.1)
        else:
            instance.fmu.setTime(0.1)
            instance.set("joint_velocity", 3.0)
        moved = instance.everything()
        assert moved["der(joint_velocity)"] != taken["der(joint_velocity)"]
        go_back()
        assert instance.everything() == taken
    instance.free_state(kept)


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


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("other", ["damped", "effects"])
def test_states_of_models_of_the_same_or_another_size_are_refused(fmus, instances, kind, other):
    """The damped model has the effects of the base model, and other numbers."""
    one, stranger = (instances(getattr(fmus(name), kind)()) for name in ("base", other))
    function = stranger.call({2: "SetFMUstate", 3: "SetFMUState"}[stranger.version])
    state, own = one.get_state(), stranger.get_state()
    check_refused(stranger, *function, state, telling=["another model"])
    data, expected = one.serialise(state), len(stranger.serialise(own))
    assert (len(data) == expected) == (other == "damped")
    with pytest.raises(FMICallException):
        stranger.restore(data)
    told = "another model" if other == "damped" else f"{expected} bytes, not {len(data)}"
    assert told in stranger.log[-1].text
    one.free_state(state)
    stranger.free_state(own)


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
    assert f"has {len(data)} bytes, not {len(data) - 1}" in slave.log[-1].text


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


@pytest.mark.parametrize("kind", KINDS)
def test_reset_forgets_rates_of_inputs_failures_and_jumps(fmus, instances, kind, name):
    instance, fresh = (instances(getattr(fmus(name), kind)()) for _ in range(2))
    instance.begin({"joint_velocity": 0.5})
    if kind == "slave":
        if instance.version == 2:
            instance.set_rate("motor_position", 0.5)
        instance.advance(0.0, 0.1)
        instance.set("load_torque", 1.7e308)
        assert instance.status(*instance.stepping(0.1, 0.1)) == DISCARD
    instance.fmu.reset()
    assert instance.snapshot() == fresh.snapshot()
    for one in (instance, fresh):
        one.begin({"motor_position": 0.1})
        if kind == "slave":
            one.advance(0.0, 0.1)
    assert instance.everything() == fresh.everything()


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
