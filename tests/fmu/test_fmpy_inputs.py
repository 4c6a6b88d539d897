"""fmpy, given a recording as `fmpy_inputs` has it, moves as `simulate` does."""

import numpy as np
import pytest
from fmpy import simulate_fmu
from fmu_cases import BOTH, MODELS

import elastic_tendon as et

TIME = np.arange(301) * 1e-3
MOTOR = 0.4 * np.sin(25.0 * TIME)
LOAD = 3.0 * np.sin(40.0 * TIME)


def _recording(interpolation):
    return et.Measurement(
        time=TIME, motor_position=MOTOR, load_torque=LOAD, interpolation=interpolation
    )


def _joint(fmu, inputs, kind, **options):
    """Joint position at the samples."""
    run = simulate_fmu(
        str(fmu.path),
        fmi_type=kind,
        stop_time=TIME[-1],
        output_interval=1e-3,
        record_events=False,
        input=inputs,
        output=["joint_position"],
        **options,
    )
    _, rows = np.unique(run["time"].round(9), return_index=True)
    return run["joint_position"][rows]


@BOTH
@pytest.mark.parametrize("name", ["base", "effects"])
@pytest.mark.parametrize("kind", ["CoSimulation", "ModelExchange"])
def test_held_samples_give_what_simulate_gives(fmus, name, kind):
    recording = _recording("hold")
    expected = et.simulate(MODELS[name], TIME, MOTOR, LOAD, interpolation="hold")
    inputs = et.fmpy_inputs(recording)
    found = _joint(fmus(name), inputs, kind, relative_tolerance=1e-10)
    assert np.ptp(found) > 0.5
    assert np.abs(found - expected["joint_position"]).max() < 1e-7


def test_straight_lines_are_nearly_what_simulate_gives(fmus):
    """With the velocity, which damped springs need; held samples are off by milliradians."""
    expected = et.simulate(MODELS["damped"], TIME, MOTOR, LOAD)["joint_position"]
    start = {"motor_velocity_connected": True}
    means, held = (
        _joint(fmus("damped"), inputs, "CoSimulation", start_values=start)
        for inputs in (
            et.fmpy_inputs(_recording("linear")),
            et.fmpy_inputs(_recording("linear"), hold=True),
        )
    )
    assert np.abs(means - expected).max() < 1e-4
    assert np.abs(held - expected).max() > 2e-3


def test_a_recording_without_load_has_none():
    inputs = et.fmpy_inputs(et.Measurement(time=[0.0, 1.0, 3.0], motor_position=[0.0, 2.0, 3.0]))
    assert inputs["time"].tolist() == [0.0, 1.0, 1.0, 3.0, 3.0]
    assert inputs["motor_position"].tolist() == [1.0, 1.0, 2.5, 2.5, 3.0]
    assert inputs["motor_velocity"].tolist() == [2.0, 2.0, 0.5, 0.5, 0.0]
    assert inputs["load_torque"].tolist() == [0.0] * 5
