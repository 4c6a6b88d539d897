"""FMUs at every interface: the simulated model, in an importer that is not ours."""

import re

import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu

import elastic_tendon as et
from elastic_tendon.actuator.interfaces import WITH_SPRINGS
from elastic_tendon.actuator.model import build
from elastic_tendon.actuator.variables import interface
from elastic_tendon.fmu.documentation import documentation
from elastic_tendon.fmu.export import describe
from elastic_tendon.native.layout import layout
from elastic_tendon.simulation.simulate import simulate

TIME = np.arange(0.0, 0.5, 2e-3)
AGREEMENT = 1e-6  # rad, and N·m of a joint that is given
MOTION = {
    "motor_position": 0.3 * np.sin(9.0 * TIME),
    "load_torque": 3.0 * np.sin(7.0 * TIME),
    "motor_torque": 0.8 * np.sin(9.0 * TIME),
    "joint_position": 0.2 * np.sin(6.0 * TIME),
}
CASES = [(kind, version) for kind in WITH_SPRINGS for version in (2, 3)]


def driven(kind):
    """A model with memory, and with friction where the interface has a rotor to rub."""
    model = et.models.biorob_x4_joint_3.at(kind)
    numbers = {"force": 10.0, "yield_length": 1e-3, "exponent": 1.5}
    model = model.with_effect("spring_hysteresis", numbers)
    return model.with_effect("motor_friction", {"torque": 0.2}) if kind.has_rotor else model


@pytest.mark.parametrize(("kind", "version"), CASES, ids=lambda part: str(part))
@pytest.mark.usefixtures("made_soon")
def test_an_fmu_moves_as_simulated(kind, version, tmp_path):
    model = driven(kind)
    path = et.export_fmu(model, tmp_path / "x.fmu", fmi_version=version)
    assert validate_fmu(str(path)) == []
    variables = interface(*model.structure)
    recording = et.Measurement(
        time=TIME,
        motor_position=MOTION["motor_position"],
        load_torque=MOTION["load_torque"],
        signals={
            "joint_position": MOTION["joint_position"],
            "motor_torque": MOTION["motor_torque"],
            "joint_torque": 0.0 * TIME,
        },
        interpolation="hold",
    ).at(kind)
    given = {name: MOTION[name] for name in variables.input_names if name in MOTION}
    expected = simulate(model, TIME, interpolation="hold", tolerance=1e-9, **given)
    inputs = et.fmpy_inputs(recording)
    # held from sample to sample: no velocity in between
    for name in inputs.dtype.names:
        if name.endswith("velocity"):
            inputs[name] = 0.0
    names = [name for name in ("joint_position", "motor_position") if name in variables.state_names]
    for kind_of_fmu in ("CoSimulation", "ModelExchange"):
        found = fmpy.simulate_fmu(
            str(path),
            fmi_type=kind_of_fmu,
            input=inputs,
            output=[*names, "joint_torque"],
            output_interval=2e-3,
            start_values={"motor_velocity_connected": True} if not kind.has_rotor else {},
            stop_time=TIME[-1],
            relative_tolerance=1e-9,
        )
        # of an event's two rows the last is after it
        at = np.searchsorted(found["time"], TIME - 1e-6)[1:]
        for name in (*names, *(() if names else ("joint_torque",))):
            # inputs change after the row of a sample, and the torque of a given joint with them
            late = slice(None, -1) if name == "joint_torque" else slice(1, None)
            error = np.abs(found[name][at] - expected[name][late])
            assert np.ptp(expected[name]) > 1e-2
            assert error.max() < AGREEMENT, (kind_of_fmu, name)


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("kind", WITH_SPRINGS)
def test_the_documentation_says_what_to_connect_and_to_read(kind, version):
    model = driven(kind)
    variables = interface(*model.structure)
    rows = layout(variables, model.values())
    page = documentation(model, rows, version)["documentation/index.html"].decode()
    connect = " ".join(page[page.index("Connect it") : page.index("<nav>")].split())
    give, read = re.findall(r"<li>(?:Give|Read) (.*?)</li>", connect)
    asked = set(re.findall(r"<code>(\w+)</code>", give))
    assert asked == {*variables.input_names} - {"motor_velocity"}
    assert {*re.findall(r"<code>(\w+)</code>", read)} <= {
        variable.name for variable in rows if variable.is_output
    }
    for told in ("motor_velocity_connected", "in model exchange it counts as 0 else"):
        assert (told in connect) == ("motor_velocity" in variables.input_names)
    assert ("motor.inertia" in page[page.index("Equations</h2>") :]) == kind.has_rotor


def test_each_interface_of_a_model_has_a_name_of_its_own():
    models = [et.models.biorob_x4_joint_3.at(kind) for kind in WITH_SPRINGS]
    names = [describe(model, build(*model.structure), 3).name for model in models]
    assert names[0] == "biorob_x4_joint_3"
    assert len(set(names)) == len(names)


@pytest.mark.parametrize("kind", WITH_SPRINGS)
@pytest.mark.usefixtures("made_soon")
def test_names_of_inputs_and_outputs_are_those_of_the_interface(kind, tmp_path):
    path = et.export_fmu(
        et.models.figure_7.at(kind) if not kind.has_rotor else driven(kind),
        tmp_path / "x.fmu",
        fmi_version=3,
    )
    described = fmpy.read_model_description(str(path))
    causality = {variable.name: variable.causality for variable in described.modelVariables}
    on_flanges = ("motor_position", "motor_velocity", "motor_torque")
    on_flanges += ("joint_position", "joint_velocity", "load_torque")
    # position, velocity and torque of both flanges are there at every interface, given or computed
    assert all(causality[name] in ("input", "output") for name in on_flanges)
    assert (causality["motor_torque"] == "input") == kind.has_rotor
    assert (causality["joint_position"] == "input") == (not kind.has_link)
    assert causality["joint_torque"] == causality["slack_state"] == "output"
    assert ("motor_velocity_connected" in causality) == (not kind.has_rotor)
