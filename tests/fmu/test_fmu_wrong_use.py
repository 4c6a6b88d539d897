"""Illegal calls and bad values: an error and a message, and nothing has changed."""

from ctypes import c_char_p, c_double
from math import inf, nan

import pytest
from fmu_cases import BOTH
from refusals import NOTHING, check_refused, check_set_refused, functions_of_header

from fmu_driver import DISCARD, ERROR

pytestmark = BOTH

BETWEEN = {"slave": "between steps", "model": "in continuous-time mode"}
FIXED = ("transmission.joint_pulley_radius", "joint_torque", "time")


@pytest.fixture(params=["slave", "model"])
def kind(request):
    return request.param


@pytest.fixture
def running(base, instances, kind):
    """An instance between steps, or in continuous time."""
    instance = instances(getattr(base, kind)(name="arm 100%"))
    instance.begin({"motor_position": 0.1})
    return instance


def test_every_function_is_there_and_does_nothing_to_no_instance(base, instances, version):
    library = instances(base.slave()).fmu.dll
    names = functions_of_header(version)
    assert len(names) > 40
    for name in names:
        function = library[name]
        if name.endswith("FreeInstance"):
            function(None)
        elif "Instantiate" not in name and not name.endswith(("GetVersion", "GetTypesPlatform")):
            assert function(*NOTHING) == ERROR, name


def test_messages_name_instance_call_time_variable_and_value(base, instances, version):
    slave = instances(base.slave(name="#1 100%"))
    slave.begin()
    slave.advance(0.0, 0.25)
    check_set_refused(slave, "motor_position", nan)
    message = slave.log[-1]
    assert message.instance == "#1 100%"
    # number signs mark variables, and FMI 2 prints messages as formats: doubled, they are meant
    name, setter = {2: ("##1 100%%", "fmi2SetReal"), 3: ("##1 100%", "fmi3SetFloat64")}[version]
    assert message.text.startswith(f"{name}: {setter} at 0.25 s: motor_position = ")
    assert "nan is not finite" in message.text


def test_times_steps_and_sizes_that_cannot_be_are_refused(running):
    for time, h in ((0.5, 0.1), (0.0, 0.0), (0.0, -0.1), (nan, 0.1), (0.0, inf)):
        check_refused(running, *running.stepping(time, h))
    check_refused(running, *running.call("GetContinuousStates", None, 2))
    check_refused(running, *running.call("EnterInitializationMode", *NOTHING))
    check_refused(running, *running.call("ExitInitializationMode"))


def test_references_that_do_not_exist_or_are_of_another_type_are_refused(running):
    check_refused(running, *running.getting(10**6), telling=["1000000"])
    enumeration, real = running.references(["slack_state", "joint_torque"])
    check_refused(running, *running.getting(enumeration), telling=["Enumeration"])
    check_refused(running, *running.getting(real, "String"))


@pytest.mark.parametrize("value", [nan, inf, -inf])
def test_inputs_that_are_not_finite_are_refused(running, value):
    check_set_refused(running, "load_torque", value, telling=["load_torque"])


@pytest.mark.parametrize(
    ("kind", "name"),
    [
        *((kind, name) for kind in BETWEEN for name in FIXED),
        ("slave", "joint_position"),  # an integrator may set states
    ],
    indirect=["kind"],
)
def test_what_is_not_an_input_cannot_be_set_while_running(running, kind, name):
    check_set_refused(running, name, 1.0, telling=[name, BETWEEN[kind]])


@pytest.mark.parametrize(
    ("name", "value"),
    [("link.inertia", 0.0), ("link.damping", -1.0), ("transmission.pretension_force", inf)],
)
def test_parameters_outside_their_bounds_are_refused(base, instances, kind, name, value):
    instance = instances(getattr(base, kind)())
    check_set_refused(instance, name, value, telling=[name, f"{value:g}"])


def test_whole_numbers_have_bounds_and_type(base, instances):
    slave = instances(base.slave())
    name = "transmission.upper_spring.parallel"
    suffix, type_name = slave.access[slave.variables[name].type][0], slave.variables[name].type
    check_set_refused(slave, name, 0, suffix=suffix, telling=[name, "1 to 100"])
    check_set_refused(slave, name, 2.0, telling=[type_name])
    slave.set(name, 3)
    slave.set_up()
    assert slave.get(name) == 3


def test_one_bad_value_among_good_ones_sets_none(running):
    check_refused(running, *running.setting(["motor_position", "load_torque"], [0.7, nan]))
    assert running.get("motor_position") == 0.1


def test_calls_of_the_other_interface_are_refused(base, instances):
    slave, model = instances(base.slave()), instances(base.model())
    for instance in (slave, model):
        instance.set_up()
    for name in ("GetContinuousStates", "GetEventIndicators", "EnterContinuousTimeMode", "SetTime"):
        check_refused(slave, *slave.call(name, *NOTHING), telling=["co-simulation"])
    check_refused(model, *model.stepping(0.0, 0.1), telling=["model exchange"])


def test_a_category_that_does_not_exist_is_refused(running):
    names = (c_char_p * 1)(b"logNonsense")
    check_refused(running, *running.call("SetDebugLogging", 1, 1, names), telling=["logNonsense"])


def test_steps_past_the_stop_time_are_refused(base, instances):
    slave = instances(base.slave())
    slave.begin(stop_time=0.3)
    slave.advance(0.0, 0.1)
    slave.advance(0.1, 0.3 - 0.1 + 1e-13)  # rounding is no crime
    check_refused(slave, *slave.stepping(0.3, 0.1), telling=["stopTime"])


def test_communication_points_may_be_off_by_rounding(base, instances):
    slave = instances(base.slave())
    slave.begin()
    time = 0.0
    for i in range(1000):
        slave.advance(i / 1000, 0.001)
        time = i / 1000 + 0.001
    assert slave.get("time") == time


def test_a_step_that_cannot_be_taken_is_discarded(base, instances, version):
    """A load that no state bears: the rates overflow. FMI 3 may go on; FMI 2 must go back."""
    slave = instances(base.slave())
    slave.begin()
    slave.advance(0.0, 0.1)
    kept = slave.get_state()
    slave.set("load_torque", 1.7e308)
    assert slave.status(*slave.stepping(0.1, 0.1)) == DISCARD
    assert slave.log[-1].category == "logStatusDiscard"
    reached = slave.get("time")
    assert 0.1 <= reached < 0.2
    if version == 2:
        assert slave.fmu.getRealStatus(2) == reached
        assert not slave.fmu.getBooleanStatus(3)
        assert slave.status(*slave.stepping(reached, 0.1)) == ERROR
    slave.set_state(kept)
    slave.free_state(kept)
    slave.advance(0.1, 0.1)
    assert slave.get("time") == 0.2


def test_derivatives_that_overflow_are_discarded(base, instances):
    """So that an integrator may try a shorter step."""
    model = instances(base.model())
    model.begin()
    model.move(1.7e308, 0.0)
    function = {2: "GetDerivatives", 3: "GetContinuousStateDerivatives"}[model.version]
    assert model.status(*model.call(function, (c_double * 2)(), 2)) == DISCARD
    assert "joint_velocity" in model.log[-1].text


@pytest.mark.parametrize("token", ["{00000000}", "", "%s%n"])
def test_a_wrong_token_gives_no_instance(base, kind, token):
    with pytest.raises(Exception, match="instantiate"):
        getattr(base, kind)(token=token)


@pytest.mark.parametrize("name", ["", "  "])
def test_an_instance_needs_a_name(base, kind, name):
    with pytest.raises(Exception, match="instantiate"):
        getattr(base, kind)(name=name)


def test_events_are_logged_only_when_asked(base, instances):
    for logging in (False, True):
        slave = instances(base.slave(logging=logging))
        slave.begin({"motor_position": 0.5})
        slave.advance(0.0, 0.5)
        told = [message for message in slave.log if message.category == "logEvents"]
        assert bool(told) == logging
    assert any("lower_spring.taut" in message.text for message in told)


def test_categories_are_switched_one_by_one(base, instances, version):
    """What FMI 2 always logs, errors and warnings, FMI 3 logs when asked."""
    slave = instances(base.slave(logging=False))
    slave.begin({"motor_position": 0.5})

    def categories(on, names):
        slave.fmu.setDebugLogging(on, names)
        slave.log.clear()
        state = slave.get_state()
        slave.advance(0.0, 0.5)
        slave.status(*slave.stepping(0.0, 0.5))
        slave.set_state(state)
        slave.free_state(state)
        return {message.category for message in slave.log}

    always = {"logStatusError"} if version == 2 else set()
    assert categories(False, []) == always
    assert categories(True, ["logEvents"]) == {"logEvents"} | always
    assert categories(True, ["logStatusError"]) == {"logStatusError"}
    assert categories(True, ["logStatusError", "logEvents"]) == {"logEvents", "logStatusError"}
    assert categories(False, ["logEvents"]) == {"logStatusError"}
    assert categories(False, []) == always
    assert categories(True, []) == {"logEvents", "logStatusError"}
