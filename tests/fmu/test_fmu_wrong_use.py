"""Illegal calls and bad values: an error and a message, and nothing has changed."""

import re
from ctypes import c_char_p, c_double
from itertools import combinations
from math import inf, isfinite, nan

import pytest
from fmu_cases import BOTH
from refusals import NOTHING, check_refused, check_set_refused, functions_of_header

from fmu_driver import DISCARD, ERROR, OK

pytestmark = BOTH

BETWEEN = {"slave": "between steps", "model": "in continuous-time mode"}
CATEGORIES = {"logEvents", "logStatusWarning", "logStatusDiscard", "logStatusError"}
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


@pytest.mark.parametrize(
    ("name", "shown"),
    [
        ("a" * 150, "a" * 100),
        ("€" * 40, "€" * 33),  # three bytes each
        ("a" * 99 + "é", "a" * 99),
        ("a" * 98 + "é", "a" * 98 + "é"),
        ("é" * 20, "é" * 20),
    ],
    ids=["one byte", "three bytes", "inside the last", "after the last", "short"],
)
def test_a_long_name_is_cut_between_characters(base, instances, kind, name, shown):
    instance = instances(getattr(base, kind)(name=name))
    instance.begin()
    assert instance.status(*instance.setting(["motor_position"], [nan])) == ERROR
    assert instance.log[-1].text.startswith(f"{shown}: fmi")
    assert instance.log[-1].instance == name


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
    ("kind", "name", "when"),
    [
        ("slave", "transmission.joint_pulley_radius", "fixed when initialisation ends"),
        ("model", "link.inertia", "tuned in event mode"),
        ("slave", "joint_position", "set before initialisation ends"),
        ("slave", "joint_torque", "calculated"),
        ("slave", "time", "calculated"),
        ("model", "der(joint_velocity)", "calculated"),
    ],
    indirect=["kind"],
)
def test_a_setting_that_comes_too_late_is_told_when_it_can_be_made(running, name, when):
    check_set_refused(running, name, 1.0, telling=[f"{name} cannot be set", f"it is {when}"])


def test_an_option_is_fixed_when_initialisation_ends(running):
    name = "motor_velocity_connected"
    if not running.is_slave:
        running.fmu.enterEventMode()
    told = [name, "fixed when initialisation ends"]
    check_set_refused(running, name, 1, suffix="Boolean", telling=told)


def test_states_with_a_calculated_start_are_the_solvers_until_it_runs(fmus, instances, kind):
    instance = instances(getattr(fmus("implicit"), kind)())
    names = instance.named(initial="calculated", causality="local")
    names = [name for name in names if f"der({name})" in instance.variables]
    assert len(names) == 4
    for name in names:
        check_set_refused(instance, name, 0.001, telling=[name, "it is calculated"])
    instance.set_up()
    for name in names:
        check_set_refused(instance, name, 0.001, telling=[name, "it is calculated"])
    instance.fmu.exitInitializationMode()
    if kind == "model":
        instance.iterate_events()
        for name in names:
            instance.set(name, 0.001)  # as an integrator does
            assert instance.get(name) == 0.001


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


def test_communication_points_far_from_zero_are_told_apart_by_rounding(base, instances):
    """At 1e9 s, where neighbouring numbers are 0.1 µs apart: sums are accepted, half steps not."""
    slave, step, time = instances(base.slave()), 1e-5, 1e9
    slave.begin(start_time=time)
    for i in range(1000):
        slave.advance(time, step)
        time = 1e9 + (i + 1) * step
        if i % 100 == 0:
            for wrong in (time - step / 2, time + step / 2):
                check_refused(slave, *slave.stepping(wrong, step))
                numbers = re.findall(r"(\S+) s\b", slave.log[-1].text.partition("starts")[2])
                told, present, off = map(float, numbers)
                assert (told, present) == pytest.approx((wrong, time), abs=1e-5)
                assert off == pytest.approx(wrong - slave.get("time"), rel=0.01)
    assert slave.get("time") == pytest.approx(time, abs=1e-6)


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


# rad: numbers that overflow, and numbers that stay finite and never get near a solution
@pytest.mark.parametrize("position", [1e150, -1e150, 1e80])
def test_equations_that_do_not_converge_give_no_step(fmus, instances, position):
    """Nor outputs; an instance that goes back to a sane input goes on."""
    slave, other = (instances(fmus("implicit").slave()) for _ in range(2))
    for one in (slave, other):
        one.begin({"motor_position": 0.1})
        one.advance(0.0, 0.01)
    kept = slave.get_state()
    slave.set("motor_position", position)
    for name in ("joint_torque", "upper_spring_force", "der(joint_velocity)"):
        assert slave.status(*slave.getting(slave.reference(name))) in (DISCARD, ERROR)
        assert "finite" in slave.log[-1].text
    assert slave.status(*slave.stepping(0.01, 0.01)) == DISCARD
    assert "finite" in slave.log[-1].text
    assert slave.get("time") == 0.01
    slave.set_state(kept)
    slave.free_state(kept)
    for one in (slave, other):
        one.advance(0.01, 0.01)
    assert slave.everything() == other.everything()
    assert all(isfinite(value) for value in slave.everything().values())


@pytest.mark.parametrize("position", [1e150, 1e80])
def test_what_is_not_finite_is_discarded_by_name(fmus, instances, position):
    """In continuous time, where an integrator may try another point."""
    model = instances(fmus("implicit").model())
    model.begin()
    model.set("motor_position", position)
    for name in ("joint_torque", "upper_spring_force", "der(joint_velocity)"):
        assert model.status(*model.getting(model.reference(name))) == DISCARD
        message = model.log[-1]
        assert (message.status, message.category) == (DISCARD, "logStatusDiscard")
        assert re.search(rf"{re.escape(name)} = -?(nan|inf) is not finite", message.text)
    n = model.description.numberOfEventIndicators
    assert model.status(*model.call("GetEventIndicators", (c_double * n)(), n)) == DISCARD
    model.fmu.enterEventMode()
    function = {2: "newDiscreteStates", 3: "updateDiscreteStates"}[model.version]
    with pytest.raises(Exception, match="DiscreteStates"):
        getattr(model.fmu, function)()
    model.set("motor_position", 0.0)
    model.iterate_events()
    assert model.get("joint_torque") == pytest.approx(0.0, abs=1e-9)


def test_initial_equations_that_do_not_settle_are_an_error(fmus, instances, kind):
    instance = instances(getattr(fmus("implicit"), kind)())
    instance.set_up({"motor_position": 1e150})
    check_refused(instance, *instance.call("ExitInitializationMode"), telling=["do not settle"])
    instance.set("motor_position", 0.0)
    assert instance.status(*instance.call("ExitInitializationMode")) == OK


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


def _categories_told(slave):
    """Categories of the messages of events, a warning, an overload and a wrong time."""
    slave.log.clear()
    state = slave.get_state()
    slave.advance(0.0, 0.11)
    slave.set("load_torque", 1.7e308)
    assert slave.status(*slave.stepping(0.11, 0.1)) == DISCARD
    assert slave.status(*slave.stepping(nan, 0.1)) == ERROR
    slave.set_state(state)
    slave.free_state(state)
    return {message.category for message in slave.log}


@pytest.mark.parametrize("logging", [False, True])
@pytest.mark.parametrize(
    "chosen", [set(some) for n in range(1, 5) for some in combinations(sorted(CATEGORIES), n)]
)
def test_exactly_the_categories_named_are_told(base, instances, version, logging, chosen):
    """Whatever was on before. What is wrong is told in FMI 2 without being asked for."""
    always = CATEGORIES - {"logEvents"} if version == 2 else set()
    slave = instances(base.slave(logging=logging))
    slave.begin({"joint_velocity": 40.0})
    assert _categories_told(slave) == (CATEGORIES if logging else always)
    slave.fmu.setDebugLogging(True, sorted(chosen))
    assert _categories_told(slave) == chosen | always


def test_categories_are_switched_off_one_by_one(base, instances, version):
    always = CATEGORIES - {"logEvents"} if version == 2 else set()
    slave = instances(base.slave(logging=False))
    slave.begin({"joint_velocity": 40.0})
    left = set(CATEGORIES)
    slave.fmu.setDebugLogging(True, [])
    assert _categories_told(slave) == left
    for category in sorted(CATEGORIES):
        slave.fmu.setDebugLogging(False, [category])
        left.remove(category)
        assert _categories_told(slave) == left | always
    slave.fmu.setDebugLogging(True, [])
    slave.fmu.setDebugLogging(False, [])
    assert _categories_told(slave) == always
