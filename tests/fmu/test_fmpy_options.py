"""What FMI offers an importer beside plain steps, used by fmpy's own simulation loop."""

from ctypes import c_double, c_uint

import numpy as np
import pytest
from fmpy import simulate_fmu
from fmpy.fmi3 import FMU3Slave, fmi3IntermediateUpdateCallback
from fmpy.simulation import instantiate_fmu
from fmu_cases import BOTH, FMI3, MODELS

import elastic_tendon as et

STOP = 0.3  # s
START = {"motor_position": 0.3}
TOLERANCE = 1e-8


def _expected(time, name="base"):
    held = np.full(len(time), START["motor_position"])
    return et.simulate(MODELS[name], time, held, tolerance=TOLERANCE)


def _run(fmu, **options):
    return simulate_fmu(
        str(fmu.path),
        fmi_type="CoSimulation",
        stop_time=STOP,
        relative_tolerance=TOLERANCE,
        output=["joint_position"],
        **options,
    )


@BOTH
def test_steps_of_varying_length(base):
    """fmpy shortens its steps where inputs jump between its communication points."""
    time = np.array([0.0, 0.0137, 0.1, 0.10001, 0.2503, STOP])
    motor = np.array([0.3, 0.1, -0.2, 0.25, 0.0, 0.1])
    recording = et.Measurement(time=time, motor_position=motor, interpolation="hold")
    run = _run(base, output_interval=0.02, input=et.fmpy_inputs(recording))
    lengths = np.diff(np.unique(run["time"]))
    assert lengths.max() == pytest.approx(0.02)
    assert lengths.min() < 2e-5
    expected = et.simulate(MODELS["base"], time, motor, interpolation="hold", tolerance=TOLERANCE)
    found = run["joint_position"][-1]
    assert found == pytest.approx(expected["joint_position"][-1], abs=1e-7)


@FMI3
def test_event_mode_and_early_return(base):
    """Steps end at the events, and the motion is the same."""
    run = _run(
        base,
        output_interval=0.01,
        start_values=START,
        use_event_mode=True,
        early_return_allowed=True,
    )
    time, rows = np.unique(run["time"], return_index=True)
    expected = _expected(time)
    events = expected.event_times
    assert len(events) > 2
    assert np.abs(time[:, None] - events).min(axis=0).max() < 1e-6
    assert np.abs(run["joint_position"][rows] - expected["joint_position"]).max() < 1e-6


@FMI3
def test_intermediate_update(base):
    """What fmpy's slave sees inside steps of 0.1 s is the motion too."""
    reference = next(
        one.valueReference
        for one in base.description.modelVariables
        if one.name == "joint_position"
    )
    seen = []

    def look(_environment, time, _set, get, *_rest):
        value = c_double()
        assert get
        slave.fmi3GetFloat64(slave.component, (c_uint * 1)(reference), 1, value, 1)
        seen.append((time, value.value))

    slave = instantiate_fmu(
        *(str(base.folder), base.description, "CoSimulation"),
        intermediate_update=fmi3IntermediateUpdateCallback(look),
        required_intermediate_variables=[reference],
    )
    assert isinstance(slave, FMU3Slave)
    try:
        _run(base, output_interval=0.1, start_values=START, fmu_instance=slave)
    finally:
        slave.freeInstance()
    time, position = np.array([(0.0, 0.0), *seen]).T
    time, rows = np.unique(time, return_index=True)
    assert len(time) > 20
    assert np.abs(position[rows] - _expected(time)["joint_position"]).max() < 1e-6
