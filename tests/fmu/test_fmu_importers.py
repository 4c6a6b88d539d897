"""Importers that we did not write: fmpy's own simulation, and a pythonfmu slave."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from fmpy import simulate_fmu
from fmpy.validation import validate_fmu
from fmu_cases import MODELS

from elastic_tendon.errors import ElasticTendonError
from elastic_tendon.fmu.export import export_fmu
from elastic_tendon.fmu.pythonfmu_flavour import export_pythonfmu
from elastic_tendon.parameters import bundled_models, load_model
from fmu_driver import ERROR, Fmu

SCRIPTS = Path(__file__).parents[2] / "build_scripts"


def _simulate(fmu, kind="CoSimulation", **options):
    start = {"motor_position": 0.3, "joint_velocity": 1.0}
    return simulate_fmu(str(fmu.path), fmi_type=kind, start_values=start, stop_time=1.0, **options)


@pytest.mark.parametrize("bundled", bundled_models())
def test_every_bundled_model_runs_in_fmpy(bundled, tmp_path):
    path = export_fmu(load_model(bundled), tmp_path / "x.fmu")
    assert validate_fmu(str(path)) == []
    runs = [
        simulate_fmu(str(path), fmi_type=kind, stop_time=0.5, output_interval=0.01, **options)
        for kind, options in (
            ("CoSimulation", {"relative_tolerance": 1e-8}),
            ("ModelExchange", {"relative_tolerance": 1e-8, "record_events": False}),
        )
    ]
    joint = [run["joint_position"] for run in runs]
    assert len(joint[0]) == 51
    assert np.abs(joint[0] - joint[1]).max() < 1e-6


@pytest.fixture(scope="module")
def flavour(tmp_path_factory):
    folder = tmp_path_factory.mktemp("pythonfmu")
    return Fmu(export_pythonfmu(MODELS["effects"], folder / "x.fmu"), folder / "unpacked")


def test_pythonfmu_flavour_has_the_same_variables(flavour, fmus):
    assert validate_fmu(str(flavour.path)) == []
    described = [
        [
            (one.name, one.type, one.unit, one.causality, one.start, one.min, one.max)
            for one in listed
        ]
        for listed in (
            flavour.description.modelVariables,
            fmus("effects").description.modelVariables,
        )
    ]
    assert described[0] == described[1]
    assert flavour.description.modelExchange is None


def test_pythonfmu_flavour_gives_the_same_numbers(flavour, fmus):
    found, expected = (_simulate(fmu, output_interval=0.01) for fmu in (flavour, fmus("effects")))
    assert found.dtype == expected.dtype
    assert len(set(expected["slack_state"])) > 1
    assert (found == expected).all()


@pytest.mark.parametrize("interval", [0.002, 0.01])
def test_fmpy_integrates_model_exchange_with_moving_inputs_by_default(fmus, interval):
    """fmpy applies inputs in its root function only, so its integrator sees them jump."""
    inputs = np.zeros(2001, dtype=[("time", float), ("motor_position", float)])
    inputs["time"] = np.linspace(0.0, 2.0, 2001)
    inputs["motor_position"] = 0.4 * np.sin(8.0 * inputs["time"])
    motion = simulate_fmu(
        str(fmus("base").path),
        fmi_type="ModelExchange",
        stop_time=2.0,
        output_interval=interval,
        input=inputs,
    )
    assert motion["time"][-1] == pytest.approx(2.0)
    assert np.abs(motion["joint_position"]).max() < 0.6


def test_pythonfmu_flavour_keeps_states(flavour, instances):
    slave = instances(flavour.slave())
    slave.begin({"motor_position": 0.2, "motor_velocity_connected": True})
    data = slave.snapshot()
    slave.fmu.doStep(0.0, 0.1)
    first = slave.everything()
    slave.restore(data)
    assert slave.get("time") == 0.0
    slave.fmu.doStep(0.0, 0.1)
    assert slave.everything() == first


@pytest.mark.skipif(
    sys.version_info >= (3, 13),
    reason="pythonfmu 0.7 calls the logger with a Python error set, which Python 3.13 refuses",
)
def test_pythonfmu_flavour_refuses_nonsense(flavour, instances):
    slave = instances(flavour.slave(logging=True))
    slave.begin({"motor_position": 0.2})
    with pytest.raises(Exception, match="fmi2SetReal"):
        slave.set("load_torque", float("nan"))
    assert [m.status for m in slave.log if "load_torque = nan" in m.text] == [ERROR]


def test_pythonfmu_flavour_leaves_the_importing_process_alone(tmp_path):
    path, modules = list(sys.path), "pythonfmu_slave" in sys.modules
    export_pythonfmu(MODELS["base"], tmp_path / "x.fmu")
    assert (sys.path, "pythonfmu_slave" in sys.modules) == (path, modules)
    with pytest.raises(ElasticTendonError, match="exists"):
        export_pythonfmu(MODELS["base"], tmp_path / "x.fmu")


@pytest.mark.parametrize(
    ("arguments", "status", "told"),
    [(["figure_8"], 0, "figure_8_pythonfmu.fmu"), (["no_such_model"], 1, "no_such_model")],
)
def test_script_for_the_pythonfmu_flavour(tmp_path, arguments, status, told):
    command = [sys.executable, str(SCRIPTS / "build_pythonfmu.py"), *arguments]
    run = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, check=False)
    assert run.returncode == status
    assert told in run.stdout + run.stderr
    assert "Traceback" not in run.stderr
    assert bool(list(tmp_path.glob("*.fmu"))) == (status == 0)


def test_script_for_all_bundled_models(tmp_path):
    command = [sys.executable, str(SCRIPTS / "build_fmus.py"), "--output", str(tmp_path)]
    subprocess.run(command, capture_output=True, check=True)
    made = {path.relative_to(tmp_path) for path in tmp_path.glob("*/*")}
    assert made == {Path(f"fmi{v}", f"{name}.fmu") for v in (2, 3) for name in bundled_models()}
