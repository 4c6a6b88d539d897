"""Illegal calls of functions that FMI 3.0 alone has, or has with other arguments."""

import re
from ctypes import byref, c_bool, c_double, c_size_t, c_uint
from math import inf, nan

import pytest
from fmu_cases import FMI3
from refusals import (
    NOTHING,
    check_forbidden,
    check_refused,
    check_set_refused,
    functions_of_header,
)

from fmu_driver import DISCARD, ERROR

pytestmark = FMI3

# functions, without fmi3, that no phase of life forbids
ALWAYS = {
    *("SetDebugLogging", "Reset", "GetFMUState", "SetFMUState", "FreeFMUState"),
    *("SerializedFMUStateSize", "SerializeFMUState", "DeserializeFMUState"),
    *("GetNumberOfEventIndicators", "GetNumberOfContinuousStates"),
}
# functions of what the FMU does not have
NEVER = {
    *("ActivateModelPartition", "EnterConfigurationMode", "ExitConfigurationMode"),
    *("EvaluateDiscreteStates", "GetNumberOfVariableDependencies", "GetVariableDependencies"),
}
NO_INSTANCE = {"GetVersion", "FreeInstance"}
TYPES = {
    *("Float32", "Float64", "Int8", "Int16", "Int32", "Int64"),
    *("UInt8", "UInt16", "UInt32", "UInt64", "Boolean", "String", "Binary"),
}
GETTERS = {f"Get{one}" for one in TYPES}
AFTER_THE_END = GETTERS | {
    *("GetDirectionalDerivative", "GetAdjointDerivative", "GetOutputDerivatives"),
    *("GetContinuousStateDerivatives", "GetContinuousStates", "GetNominalsOfContinuousStates"),
    "GetEventIndicators",
}
BEFORE_THE_START = GETTERS | {f"Set{one}" for one in TYPES} | {"EnterInitializationMode"}


@pytest.fixture(params=["slave", "model"])
def kind(request):
    return request.param


@pytest.fixture
def instance(base, instances, kind):
    return instances(getattr(base, kind)())


def _but(allowed):
    names = [name.removeprefix("fmi3") for name in functions_of_header(3)]
    refused = set(names) - ALWAYS - NEVER - NO_INSTANCE - allowed
    return sorted(name for name in refused if "Instantiate" not in name)


@pytest.mark.parametrize("function", _but(BEFORE_THE_START))
def test_before_initialisation_is_refused(instance, function):
    check_forbidden(instance, f"fmi3{function}", "before initialisation")


@pytest.mark.parametrize("function", _but(AFTER_THE_END))
def test_after_termination_is_refused(instance, function):
    instance.begin()
    instance.fmu.terminate()
    check_forbidden(instance, f"fmi3{function}", "after termination")


@pytest.mark.parametrize("function", sorted(NEVER))
def test_what_is_not_there_is_refused_with_the_reason(instance, function):
    told = "there are no|those of the last update|not for scheduled execution|are scalars"
    check_refused(instance, f"fmi3{function}", *NOTHING)
    assert re.search(told, instance.log[-1].text)
    instance.begin()
    check_refused(instance, f"fmi3{function}", *NOTHING)
    assert re.search(told, instance.log[-1].text)


@pytest.mark.parametrize(
    ("function", "arguments"),
    [
        ("fmi3SetTime", (nan,)),
        ("fmi3GetEventIndicators", ((c_double * 5)(), 5)),
        ("fmi3SetContinuousStates", ((c_double * 2)(0.0, inf), 2)),
        ("fmi3SetContinuousStates", ((c_double * 2)(), 1)),
        ("fmi3GetContinuousStateDerivatives", (None, 2)),
        ("fmi3GetFloat64", (None, 1, (c_double * 1)(), 1)),
        ("fmi3GetFloat64", ((c_uint * 1)(4), 1, None, 1)),
        ("fmi3GetFloat64", ((c_uint * 1)(4), 1, (c_double * 2)(), 2)),
        ("fmi3SetFloat64", ((c_uint * 2)(1, 3), 2, (c_double * 2)(), 1)),
        ("fmi3GetFMUState", (None,)),
        ("fmi3SetFMUState", (None,)),
        ("fmi3GetNumberOfVariableDependencies", (4, byref(c_size_t()))),
        ("fmi3ActivateModelPartition", (4, 0.0)),
        ("fmi3EnterConfigurationMode", ()),
    ],
)
def test_calls_out_of_place_are_refused(instance, function, arguments):
    instance.begin({"motor_position": 0.1})
    check_refused(instance, function, *arguments)


@pytest.mark.parametrize("missing", range(3, 7))
def test_a_step_needs_a_place_for_each_result(base, instances, missing):
    slave = instances(base.slave())
    slave.begin()
    function, *arguments = slave.stepping(0.0, 0.1)
    arguments[missing] = None
    check_refused(slave, function, *arguments, telling=["NULL"])


@pytest.mark.parametrize("missing", range(6))
def test_an_update_needs_a_place_for_each_result(base, instances, missing):
    model = instances(base.model())
    model.set_up()
    model.fmu.exitInitializationMode()
    arguments = [byref(c_bool()) for _ in range(5)] + [byref(c_double())]
    arguments[missing] = None
    check_refused(model, "fmi3UpdateDiscreteStates", *arguments, telling=["NULL"])


def test_every_result_of_an_update_is_written(base, instances):
    model = instances(base.model())
    model.set_up()
    model.fmu.exitInitializationMode()
    flags, time = [c_bool(True) for _ in range(5)], c_double(7.0)
    assert model.status("fmi3UpdateDiscreteStates", *map(byref, flags), byref(time)) == 0
    assert [one.value for one in flags] == [False] * 5


@pytest.mark.parametrize(
    "experiment",
    [
        (0, 0.0, nan, 0, 0.0),
        (0, 0.0, 1.0, 1, 1.0),
        (1, 0.0, 0.0, 0, 0.0),
        (1, nan, 0.0, 0, 0.0),
        (0, 0.0, 0.0, 1, inf),
    ],
)
def test_experiments_that_cannot_be_are_refused(instance, experiment):
    check_refused(instance, "fmi3EnterInitializationMode", *experiment)


def test_before_initialisation_starts_are_got_and_nothing_calculated(fmus, instances, kind):
    instance = instances(getattr(fmus("implicit"), kind)())
    instance.set("joint_velocity", 0.7)
    assert instance.get("joint_velocity") == 0.7
    assert instance.get("link.inertia") == float(instance.variables["link.inertia"].start)
    assert instance.get("motor_position") == 0.0
    for name in ("joint_torque", "der(joint_velocity)", "upper_spring.elongation"):
        call = instance.getting(instance.reference(name))
        check_refused(instance, *call, telling=[name, "calculated"])
    call = instance.getting(instance.reference("slack_state"), "Int64")
    check_refused(instance, *call, telling=["slack_state"])


def test_variables_of_other_types_are_refused(instance):
    """The message says which type is right."""
    instance.begin()
    for suffix in ("Float32", "Int8", "UInt16", "UInt64", "Int32", "Boolean"):
        check_refused(instance, *instance.getting(instance.reference("joint_torque"), suffix))
    call = instance.getting(instance.reference("slack_state"), "Int32")
    check_refused(instance, *call, telling=["Enumeration"])
    name = "transmission.upper_spring.parallel"
    check_refused(instance, *instance.getting(instance.reference(name), "Int64"), telling=["Int32"])


def test_after_a_step_that_was_discarded_another_one_is_taken(base, instances):
    slave = instances(base.slave())
    slave.begin({"motor_position": 0.2})
    slave.set("load_torque", 1.7e308)
    assert slave.status(*slave.stepping(0.0, 0.1)) == DISCARD
    reached = slave.get("time")
    slave.set("load_torque", 0.0)
    end = slave.advance(reached, 0.1)
    assert (end.time, end.early, end.event) == (reached + 0.1, False, False)


def test_results_of_a_step_that_is_discarded_are_written(base, instances):
    slave = instances(base.slave(early_return=True, event_mode=True))
    slave.begin()
    slave.set("load_torque", 1.7e308)
    flags, last = [c_bool(True) for _ in range(3)], c_double(-1.0)
    arguments = (0.0, 0.1, 1, *map(byref, flags), byref(last))
    assert slave.status("fmi3DoStep", *arguments) == DISCARD
    assert [one.value for one in flags] == [False] * 3
    assert last.value == slave.get("time")


def test_without_logging_there_is_no_message(base, instances, kind):
    instance = instances(getattr(base, kind)(logging=False))
    instance.begin()
    assert instance.status(*instance.setting(["motor_position"], [nan])) == ERROR
    assert instance.log == []


def test_scheduled_execution_gives_no_instance(base, instances):
    library = instances(base.slave()).fmu.dll
    assert library["fmi3InstantiateScheduledExecution"](*NOTHING) == 0


def test_what_is_neither_input_nor_output_cannot_be_required(base):
    for name in ("link.inertia", "der(joint_position)", "slack_state"):
        with pytest.raises(Exception, match="instantiate"):
            base.slave(required=[name])


def test_tunable_parameters_change_between_steps_without_event_mode(base, instances):
    slave = instances(base.slave())
    slave.begin()
    slave.set("link.inertia", 0.05)
    check_set_refused(slave, "transmission.upper_spring.stiffness", 1e4, telling=["between steps"])
