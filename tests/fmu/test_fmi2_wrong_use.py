"""Illegal calls of functions that FMI 2.0 alone has, or has with other arguments."""

from ctypes import byref, c_char_p, c_double, c_int, c_uint
from math import inf, nan

import pytest
from fmpy.fmi2 import fmi2EventInfo
from refusals import check_forbidden, check_refused, functions_of_header

from fmu_driver import DISCARD, OK

# functions, without fmi2, that no phase of life forbids
ALWAYS = {
    *("SetDebugLogging", "Reset", "GetFMUstate", "SetFMUstate", "FreeFMUstate"),
    *("SerializedFMUstateSize", "SerializeFMUstate", "DeSerializeFMUstate"),
}
NO_INSTANCE = {"GetTypesPlatform", "GetVersion", "Instantiate", "FreeInstance"}
TYPES = {"Real", "Integer", "Boolean", "String"}
BEFORE_THE_START = {f"Set{one}" for one in TYPES} | {
    *("SetupExperiment", "EnterInitializationMode", "SetRealInputDerivatives"),
    "GetNominalsOfContinuousStates",
}
AFTER_THE_END = {f"Get{one}{end}" for one in TYPES for end in ("", "Status")} | {
    *("GetStatus", "GetRealOutputDerivatives", "GetDirectionalDerivative", "GetDerivatives"),
    *("GetContinuousStates", "GetNominalsOfContinuousStates", "GetEventIndicators"),
}


def _but(allowed):
    names = {name.removeprefix("fmi2") for name in functions_of_header(2)}
    return sorted(names - ALWAYS - NO_INSTANCE - allowed)


@pytest.fixture(params=["slave", "model"])
def kind(request):
    return request.param


@pytest.fixture
def running(base, instances, kind):
    """An instance between steps, or in continuous time."""
    instance = instances(getattr(base, kind)())
    instance.begin({"motor_position": 0.1})
    return instance


@pytest.mark.parametrize(
    ("function", "arguments"),
    [
        ("fmi2SetupExperiment", (0, 0.0, 0.0, 0, 0.0)),
        ("fmi2CancelStep", ()),
        ("fmi2SetTime", (nan,)),
        ("fmi2GetEventIndicators", ((c_double * 3)(), 3)),
        ("fmi2SetContinuousStates", ((c_double * 2)(0.0, inf), 2)),
        ("fmi2SetContinuousStates", ((c_double * 2)(), 1)),
        ("fmi2GetDerivatives", (None, 2)),
        ("fmi2NewDiscreteStates", (byref(fmi2EventInfo()),)),
        ("fmi2GetReal", (None, 1, (c_double * 1)())),
        ("fmi2GetReal", ((c_uint * 1)(4), 1, None)),
        ("fmi2GetString", ((c_uint * 1)(4), 1, (c_char_p * 1)())),
        ("fmi2GetFMUstate", (None,)),
        ("fmi2SetFMUstate", (None,)),
    ],
)
def test_calls_out_of_place_are_refused(running, function, arguments):
    check_refused(running, function, *arguments)


@pytest.mark.parametrize("function", _but(BEFORE_THE_START))
def test_before_initialisation_is_refused(base, instances, kind, function):
    instance = instances(getattr(base, kind)())
    check_forbidden(instance, f"fmi2{function}", "before initialisation")


@pytest.mark.parametrize("function", _but(AFTER_THE_END))
def test_after_termination_is_refused(running, function):
    running.fmu.terminate()
    check_forbidden(running, f"fmi2{function}", "after termination")


def test_the_status_of_the_last_step_can_be_asked_for(base, instances):
    slave = instances(base.slave())
    slave.begin({"joint_velocity": 40.0})

    def told():
        value = c_int(-1)
        assert slave.status("fmi2GetStatus", 0, byref(value)) == OK
        return value.value

    assert slave.status(*slave.stepping(0.0, 0.001)) == told() == OK
    assert slave.status(*slave.stepping(0.001, 0.109)) == told() == OK
    slave.set("load_torque", 1.7e308)
    assert slave.status(*slave.stepping(0.11, 0.1)) == told() == DISCARD


def test_event_information_is_written_in_full(base, instances):
    model = instances(base.model())
    model.set_up()
    model.fmu.exitInitializationMode()
    info = fmi2EventInfo(*[7] * 5, 7.0)
    assert model.status("fmi2NewDiscreteStates", byref(info)) == 0
    assert info.newDiscreteStatesNeeded == info.valuesOfContinuousStatesChanged == 0
    assert info.terminateSimulation == info.nominalsOfContinuousStatesChanged == 0
    assert info.nextEventTimeDefined == 0


def test_rates_of_inputs_are_for_co_simulation(base, instances):
    model = instances(base.model())
    model.set_up()
    rates = ((c_uint * 1)(1), 1, (c_int * 1)(1), (c_double * 1)(0.0))
    check_refused(model, "fmi2SetRealInputDerivatives", *rates, telling=["model exchange"])


def test_outputs_cannot_be_read_before_initialisation(base, instances, kind):
    instance = instances(getattr(base, kind)())
    check_refused(instance, "fmi2GetReal", (c_uint * 1)(4), 1, (c_double * 1)())


def test_initialisation_needs_an_experiment(base, instances, kind):
    instance = instances(getattr(base, kind)())
    check_refused(instance, "fmi2EnterInitializationMode")


@pytest.mark.parametrize(
    "experiment",
    [(0, 0.0, nan, 0, 0.0), (0, 0.0, 1.0, 1, 1.0), (1, 0.0, 0.0, 0, 0.0), (1, nan, 0.0, 0, 0.0)],
)
def test_experiments_that_cannot_be_are_refused(base, instances, experiment):
    check_refused(instances(base.slave()), "fmi2SetupExperiment", *experiment)
