"""Illegal calls and bad values: an error and a message, and nothing has changed."""

import shutil
import subprocess
from ctypes import byref, c_char_p, c_double, c_int, c_uint
from math import inf, nan

import pytest
from fmpy.fmi2 import fmi2EventInfo
from fmu_cases import MODELS

from elastic_tendon import compiler
from elastic_tendon.fmu.binary import write_sources
from elastic_tendon.fmu.layout import layout
from elastic_tendon.model import build
from fmu_driver import DISCARD, ERROR

BETWEEN = {"slave": "between steps", "model": "in continuous-time mode"}


@pytest.fixture(params=["slave", "model"])
def kind(request):
    return request.param


@pytest.fixture
def running(base, instances, kind):
    """An instance between steps, or in continuous time."""
    instance = instances(getattr(base, kind)(name="arm 100%"))
    instance.begin({"motor_position": 0.1})
    return instance


def _check_refused(instance, function, *arguments, telling=()):
    before, messages = instance.snapshot(), len(instance.log)
    assert instance.status(function, *arguments) == ERROR
    assert instance.snapshot() == before
    assert len(instance.log) == messages + 1
    message = instance.log[-1]
    assert (message.status, message.category) == (ERROR, "logStatusError")
    for part in (function, *telling):
        assert part in message.text


def _check_set(instance, name, value, *, number=c_double, function="fmi2SetReal", **expected):
    reference = (c_uint * 1)(instance.reference(name))
    _check_refused(instance, function, reference, 1, (number * 1)(value), **expected)


@pytest.mark.parametrize(
    ("function", "arguments"),
    [
        ("fmi2SetupExperiment", (0, 0.0, 0.0, 0, 0.0)),
        ("fmi2EnterInitializationMode", ()),
        ("fmi2ExitInitializationMode", ()),
        ("fmi2CancelStep", ()),
        ("fmi2SetTime", (nan,)),
        ("fmi2GetEventIndicators", ((c_double * 3)(), 3)),
        ("fmi2SetContinuousStates", ((c_double * 2)(0.0, inf), 2)),
        ("fmi2SetContinuousStates", ((c_double * 2)(), 1)),
        ("fmi2GetDerivatives", (None, 2)),
        ("fmi2NewDiscreteStates", (byref(fmi2EventInfo()),)),
        ("fmi2DoStep", (0.5, 0.1, 1)),
        ("fmi2DoStep", (0.0, 0.0, 1)),
        ("fmi2DoStep", (0.0, -0.1, 1)),
        ("fmi2DoStep", (nan, 0.1, 1)),
        ("fmi2DoStep", (0.0, inf, 1)),
        ("fmi2GetReal", (None, 1, (c_double * 1)())),
        ("fmi2GetReal", ((c_uint * 1)(4), 1, None)),
        ("fmi2GetReal", ((c_uint * 1)(10**6), 1, (c_double * 1)())),
        ("fmi2GetReal", ((c_uint * 1)(5), 1, (c_double * 1)())),  # an enumeration
        ("fmi2GetString", ((c_uint * 1)(4), 1, (c_char_p * 1)())),
        ("fmi2GetFMUstate", (None,)),
        ("fmi2SetFMUstate", (None,)),
        ("fmi2SetDebugLogging", (1, 1, (c_char_p * 1)(b"logNonsense"))),
    ],
)
def test_calls_out_of_place_are_refused(running, function, arguments):
    _check_refused(running, function, *arguments)


def test_message_names_instance_call_time_variable_and_value(base, instances):
    slave = instances(base.slave(name="arm 100%"))
    slave.begin()
    slave.fmu.doStep(0.0, 0.25)
    _check_set(slave, "motor_position", nan)
    message = slave.log[-1]
    assert message.instance == "arm 100%"
    # doubled, because importers print it as a format
    assert message.text.startswith("arm 100%%: fmi2SetReal at 0.25 s: motor_position = ")
    assert "nan is not finite" in message.text


@pytest.mark.parametrize("value", [nan, inf, -inf])
def test_inputs_that_are_not_finite_are_refused(running, value):
    _check_set(running, "load_torque", value, telling=["load_torque"])


@pytest.mark.parametrize("name", ["transmission.joint_pulley_radius", "joint_torque", "time"])
def test_what_is_not_an_input_cannot_be_set_while_running(running, kind, name):
    _check_set(running, name, 1.0, telling=[name, BETWEEN[kind]])


def test_states_cannot_be_set_between_steps(base, instances):
    slave = instances(base.slave())
    slave.begin()
    _check_set(slave, "joint_position", 1.0, telling=["joint_position", BETWEEN["slave"]])


@pytest.mark.parametrize(
    ("name", "value"),
    [("link.inertia", 0.0), ("link.damping", -1.0), ("transmission.pretension_force", inf)],
)
def test_parameters_outside_their_bounds_are_refused(base, instances, kind, name, value):
    instance = instances(getattr(base, kind)())
    _check_set(instance, name, value, telling=[name, f"{value:g}"])


def test_whole_numbers_have_bounds_and_type(base, instances):
    slave = instances(base.slave())
    name = "transmission.upper_spring.parallel"
    _check_set(slave, name, 0, number=c_int, function="fmi2SetInteger", telling=[name, "1 to 100"])
    _check_set(slave, name, 2.0, telling=["Integer"])
    slave.set(name, 3)
    slave.set_up()
    assert slave.get(name) == 3


def test_one_bad_value_among_good_ones_sets_none(running):
    references = [running.reference(name) for name in ("motor_position", "load_torque")]
    values = (c_double * 2)(0.7, nan)
    _check_refused(running, "fmi2SetReal", (c_uint * 2)(*references), 2, values)
    assert running.get("motor_position") == 0.1


def test_calls_of_the_other_interface_are_refused(base, instances):
    slave, model = instances(base.slave()), instances(base.model())
    for instance in (slave, model):
        instance.set_up()
    _check_refused(slave, "fmi2GetContinuousStates", (c_double * 2)(), 2, telling=["co-simulation"])
    rates = ((c_uint * 1)(1), 1, (c_int * 1)(1), (c_double * 1)(0.0))
    _check_refused(model, "fmi2SetRealInputDerivatives", *rates, telling=["model exchange"])


@pytest.mark.parametrize(("order", "value"), [(0, 1.0), (2, 1.0), (1, nan)])
def test_only_finite_first_derivatives_of_inputs(base, instances, order, value):
    slave = instances(base.slave())
    slave.begin()
    arguments = ((c_uint * 1)(1), 1, (c_int * 1)(order), (c_double * 1)(value))
    _check_refused(slave, "fmi2SetRealInputDerivatives", *arguments, telling=["motor_position"])


def test_outputs_cannot_be_read_before_initialisation(base, instances, kind):
    instance = instances(getattr(base, kind)())
    _check_refused(instance, "fmi2GetReal", (c_uint * 1)(4), 1, (c_double * 1)())


def test_initialisation_needs_an_experiment(base, instances, kind):
    instance = instances(getattr(base, kind)())
    _check_refused(instance, "fmi2EnterInitializationMode")


@pytest.mark.parametrize(
    "experiment",
    [(0, 0.0, nan, 0, 0.0), (0, 0.0, 1.0, 1, 1.0), (1, 0.0, 0.0, 0, 0.0), (1, nan, 0.0, 0, 0.0)],
)
def test_experiments_that_cannot_be_are_refused(base, instances, experiment):
    _check_refused(instances(base.slave()), "fmi2SetupExperiment", *experiment)


def test_steps_past_the_stop_time_are_refused(base, instances):
    slave = instances(base.slave())
    slave.begin(stop_time=0.3)
    slave.fmu.doStep(0.0, 0.1)
    slave.fmu.doStep(0.1, 0.3 - 0.1 + 1e-13)  # rounding is no crime
    _check_refused(slave, "fmi2DoStep", 0.3, 0.1, 1, telling=["stopTime"])


def test_communication_points_may_be_off_by_rounding(base, instances):
    slave = instances(base.slave())
    slave.begin()
    time = 0.0
    for i in range(1000):
        slave.fmu.doStep(i / 1000, 0.001)
        time = i / 1000 + 0.001
    assert slave.get("time") == time


def test_a_step_that_cannot_be_taken_is_discarded(base, instances):
    """A load that no state bears: the rates overflow."""
    slave = instances(base.slave())
    slave.begin()
    slave.fmu.doStep(0.0, 0.1)
    kept = slave.fmu.getFMUstate()
    slave.set("load_torque", 1.7e308)
    assert slave.status("fmi2DoStep", 0.1, 0.1, 1) == DISCARD
    assert slave.log[-1].category == "logStatusDiscard"
    assert 0.1 <= slave.fmu.getRealStatus(2) < 0.2
    assert not slave.fmu.getBooleanStatus(3)
    assert slave.status("fmi2DoStep", 0.1, 0.1, 1) == ERROR
    slave.fmu.setFMUstate(kept)
    slave.fmu.freeFMUstate(kept)
    slave.fmu.doStep(0.1, 0.1)
    assert slave.get("time") == 0.2


def test_derivatives_that_overflow_are_discarded(base, instances):
    """So that an integrator may try a shorter step."""
    model = instances(base.model())
    model.begin()
    model.fmu.setContinuousStates((c_double * 2)(1.7e308, 0.0), 2)
    assert model.status("fmi2GetDerivatives", (c_double * 2)(), 2) == DISCARD
    assert "joint_velocity" in model.log[-1].text


def test_a_wrong_token_gives_no_instance(base):
    with pytest.raises(Exception, match="instantiate"):
        base.slave(guid="{00000000}")


def test_an_instance_needs_a_name(base):
    with pytest.raises(Exception, match="instantiate"):
        base.slave(name="")


def test_nothing_happens_to_no_instance(base, instances):
    library = instances(base.slave()).fmu.dll
    library.fmi2FreeInstance(None)
    assert library.fmi2Terminate(None) == ERROR


def test_events_are_logged_only_when_asked(base, instances):
    for logging in (False, True):
        slave = instances(base.slave(logging=logging))
        slave.begin({"motor_position": 0.5})
        slave.fmu.doStep(0.0, 0.5)
        told = [message for message in slave.log if message.category == "logEvents"]
        assert bool(told) == logging
    assert any("lower_spring.taut" in message.text for message in told)


@pytest.mark.skipif(shutil.which("gcc") is None, reason="gcc is not installed")
def test_sanitizers_find_nothing_in_random_calls(request, tmp_path):
    """gcc's, because zig's do not link; warnings of the hand-written C are errors here too."""
    system = build(("coulomb_friction", "overstretch_protection"))
    variables = layout(system.interface, MODELS["effects"].values())
    write_sources(tmp_path, system, variables, token="token", tolerance=1e-8)
    sources = [compiler.RUNTIME / "library.c", request.path.parent / "fuzz.c"]
    folders = [tmp_path, compiler.RUNTIME, compiler.fmi_headers()]
    command = [
        *("gcc", "-std=c11", "-O1", "-g", "-Wall", "-Wextra"),
        *("-fsanitize=address,undefined", "-fno-sanitize-recover=all"),
        *(f"-I{folder}" for folder in folders),
        *(*map(str, sources), "-o", str(tmp_path / "fuzz"), "-lm"),
    ]
    built = subprocess.run(command, capture_output=True, text=True, check=False)
    assert built.returncode == 0, built.stderr
    warnings = [line for line in built.stderr.splitlines() if "warning:" in line]
    assert [line for line in warnings if "model.c" not in line] == []
    run = subprocess.run(
        [str(tmp_path / "fuzz"), "token", "20000"], capture_output=True, text=True, check=False
    )
    assert (run.returncode, run.stdout) == (0, "20000 calls\n"), run.stderr
