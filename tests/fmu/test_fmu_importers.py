"""Importers that we did not write (`build_scripts/importers.py`), and a pythonfmu slave."""

import os
import re
import subprocess
import sys
import zipfile
from dataclasses import replace
from pathlib import Path

import casadi as ca
import numpy as np
import pytest
from fmpy import simulate_fmu
from fmpy.validation import validate_fmu
from fmu_cases import MODELS

import build_fmus
import importers as script
from elastic_tendon.actuator.parameters import load_model, models
from elastic_tendon.effects import CATALOGUE
from elastic_tendon.errors import ElasticTendonError
from elastic_tendon.fmu.pythonfmu_flavour import export_pythonfmu
from fmu_driver import ERROR, Fmu
from importers import IMPORTERS, Importer, Outcome, outcome
from made_soon import not_optimised

SCRIPTS = Path(__file__).parents[2] / "build_scripts"


def _simulate(fmu, kind="CoSimulation", **options):
    start = {"motor_position": 0.3, "joint_velocity": 1.0}
    return simulate_fmu(str(fmu.path), fmi_type=kind, start_values=start, stop_time=1.0, **options)


# ---- every importer, every flavour ---------------------------------------------------------

EFFECTS = script.several_effects()


@pytest.fixture(scope="module")
def flavours(tmp_path_factory):
    """FMU of several effects by flavour, exported when first asked for."""
    made = {}

    def get(flavour):
        if flavour not in made:
            folder = tmp_path_factory.mktemp("flavour")
            made[flavour] = script.export(EFFECTS, flavour, folder)
        return made[flavour]

    return get


def _skip_where_absent(importer):
    if not importer.installed:
        pytest.skip(f"{importer.package} is not installed")


@pytest.mark.parametrize(
    ("importer", "flavour"),
    [(importer, flavour) for importer in IMPORTERS for flavour in importer.flavours],
    ids=lambda one: getattr(one, "name", one),
)
def test_importer_agrees_with_simulate_through_slack(flavours, importer, flavour):
    _skip_where_absent(importer)
    assert outcome(importer, flavours(flavour), EFFECTS).failure == ""


@pytest.mark.parametrize(
    "importer",
    [importer for importer in IMPORTERS if importer.allowed],
    ids=lambda importer: importer.name,
)
def test_an_fmu_of_another_model_does_not_pass(flavours, importer):
    _skip_where_absent(importer)
    other = EFFECTS.with_values({"link.inertia": 0.030001})
    assert "rad from simulate" in outcome(importer, flavours(importer.flavours[0]), other).failure


@pytest.mark.parametrize(("importer", "told"), [("fmpy rules", "guid"), ("toolbox", "guid")])
def test_a_description_against_the_rules_does_not_pass(flavours, tmp_path, importer, told):
    (chosen,) = (one for one in IMPORTERS if one.name == importer)
    _skip_where_absent(chosen)
    path = tmp_path / "x.fmu"
    with zipfile.ZipFile(flavours("FMI 2")) as given, zipfile.ZipFile(path, "w") as changed:
        for name in given.namelist():
            changed.writestr(name, given.read(name).replace(b" guid=", b" uuid="))
    assert told in outcome(chosen, path, EFFECTS).failure


def _slack_states_by_ecos(path, model):
    """Raise where they are not those of `simulate`; Ecos has no enumerations."""
    script.load_tbb()
    from ecospy import EcosSimulation, EcosSimulationStructure

    start, found = script.start_of(model), []
    with EcosSimulationStructure() as structure:
        structure.add_model("one", str(path))
        structure.add_parameter_set("start", {f"one::{name}": start[name] for name in start})
        with EcosSimulation(script.STEP, structure=structure) as simulation:
            simulation.init(parameter_set="start")
            for _ in range(500):
                simulation.step()
                found.append(simulation.get_integer("one::slack_state_number"))
            simulation.terminate()
    time = np.arange(501) * script.STEP
    wanted = script.expected(model, time, start)["slack_state"][1:]
    if found != wanted.astype(int).tolist() or len(set(found)) < 2:
        raise script.ImporterError(f"slack states {set(found)}, and not those of simulate")


@pytest.mark.parametrize("flavour", ["FMI 2", "FMI 3"])
def test_an_importer_without_enumerations_reads_the_number_of_the_slack_state(flavours, flavour):
    ecos = Importer("slack states in Ecos", "ecospy", _slack_states_by_ecos)
    _skip_where_absent(ecos)
    assert outcome(ecos, flavours(flavour), EFFECTS).failure == ""


def _die(_path, _model):
    os.write(2, b"some reason\n")
    os.abort()


def test_an_importer_that_dies_is_told(flavours):
    found = outcome(Importer("dying", "fmpy", _die), flavours("FMI 2"), EFFECTS)
    assert (found.cell, found.failure) == ("FAILED", "the importer's process died; some reason")


def _solver_errs(_path, _model):
    return script.Found(apart=10.0 * script.TOLERANCE, step_time=1e-6)


def _fmu_errs(_path, _model):
    return script.Found(apart=1e-7, step_time=1e-6)


def test_what_errs_too_much_fails_and_is_told_with_a_smaller_tolerance(flavours):
    """Which tells the error of a solver from one of the FMU."""
    found = (
        outcome(Importer("x", "fmpy", errs, allowed=1e-8), flavours("FMI 2"), EFFECTS)
        for errs in (_solver_errs, _fmu_errs)
    )
    told = "1e-07 rad from simulate, 1e-08 allowed; {} where both have a tolerance of 1e-10"
    for one, finer in zip(found, ("1e-09", "1e-07"), strict=True):
        assert (one.cell, one.failure) == ("FAILED", told.format(finer))


def test_a_wrong_jacobian_is_told():
    x, u = ca.SX.sym("x", 2), ca.SX.sym("u")
    exact = ca.Function("rates", [x, u], [ca.vertcat(x[1], u - 3 * ca.sin(x[0]))])
    at = (np.array([0.2, 0.1]), np.array([0.4]))
    script.compare_jacobian(exact, *at)
    wrong = ca.Function("rates", [x, u], [ca.vertcat(x[1], u - 3 * x[0])])

    class Rates:
        jacobian = wrong.jacobian

        def __call__(self, *arguments):
            return exact(*arguments)

    with pytest.raises(script.ImporterError, match="Jacobian"):
        script.compare_jacobian(Rates(), *at)


def test_the_models_of_the_script_go_slack():
    time = np.linspace(0.0, 1.0, 1001)
    on_a_rotor = dict(script.chosen([], each_effect=True))["motor_friction"]
    for model in (*map(load_model, models), EFFECTS, on_a_rotor):
        assert len(set(script.expected(model, time, script.start_of(model))["slack_state"])) > 1


@pytest.mark.parametrize(("failure", "status"), [("", 0), ("it fell over", 1)])
def test_script_prints_one_table(monkeypatch, capsys, failure, status):
    found = [Outcome("cell", failure) for _ in IMPORTERS]
    monkeypatch.setattr(script, "outcomes", lambda *_: iter(found))
    assert script.main(["figure_8"]) == status
    printed = capsys.readouterr().out
    assert printed.count("cell") == 2 * 3 * len(IMPORTERS)  # the model and that of several effects
    assert ("figure_8, FMI 3, Ecos CS: it fell over" in printed) == bool(failure)
    assert "several effects: coulomb_friction" in printed


def test_script_writes_a_page(monkeypatch, tmp_path):
    """All effects, times, versions, and what each importer lacks."""
    installed = [one for one in IMPORTERS if one.installed]
    found = [Outcome("1e-15", step_time=12.3e-6) for _ in installed]
    monkeypatch.setattr(script, "outcomes", lambda *_: iter(found))
    monkeypatch.setattr(script, "IMPORTERS", installed)
    assert script.main(["figure_8", "--effects", "-o", str(tmp_path / "page.md")]) == 0
    page = (tmp_path / "page.md").read_text()
    assert "1e-15; 12 µs" in page
    assert "| figure_8, pythonfmu |" in page
    for effect in CATALOGUE:
        assert f"| {effect.id}, FMI 3 |" in page
    assert re.search(r"fmpy CS \(\w+ \d+\.\d+", page)
    assert all(importer.lacks for importer in IMPORTERS)


@pytest.mark.parametrize("package", ["fmpy", "no_such_package"])
def test_table_is_narrow_and_told_once_how_to_get_an_importer(monkeypatch, capsys, package):
    importers = [replace(one, package=package) for one in IMPORTERS]
    monkeypatch.setattr(script, "IMPORTERS", importers)
    monkeypatch.setattr(script, "export", lambda *_: None)
    monkeypatch.setattr(script, "outcome", lambda *_: Outcome("4e-16"))
    assert script.main([]) == 0
    printed = capsys.readouterr().out
    assert max(map(len, printed.splitlines())) <= 120
    assert printed.count('pip install ".[test]"') == (package != "fmpy")


def test_script_says_what_it_does_not_know(capsys):
    assert script.main(["no_such_model"]) == 1
    assert "no_such_model" in capsys.readouterr().err


# ---- fmpy ----------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def of_bundled_models(tmp_path_factory):
    """Folder with what the script makes of all bundled models."""
    folder = tmp_path_factory.mktemp("bundled")
    with not_optimised(), pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys, "argv", ["build_fmus.py", "--output", str(folder)])
        assert build_fmus.main() == 0
    return folder


def test_script_for_all_bundled_models(of_bundled_models):
    made = {path.relative_to(of_bundled_models) for path in of_bundled_models.glob("*/*")}
    assert made == {Path(f"fmi{v}", f"{name}.fmu") for v in (2, 3) for name in models}


@pytest.mark.parametrize("bundled", models)
def test_every_bundled_model_runs_in_fmpy(bundled, of_bundled_models):
    path = of_bundled_models / "fmi2" / f"{bundled}.fmu"
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


# ---- the pythonfmu flavour -----------------------------------------------------------------


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


@pytest.mark.parametrize(
    ("wrong", "told"),
    [
        (lambda slave: slave.set("load_torque", float("nan")), "load_torque = nan"),
        (lambda slave: slave.fmu.setReal([999], [0.0]), "999"),
        (lambda slave: slave.fmu.getReal([999]), "999"),
        (lambda slave: slave.fmu.setString([999], ["text"]), "999"),
        (lambda slave: slave.fmu.getString([999]), "999"),
        (lambda slave: slave.restore(b"no state"), "state"),
    ],
    ids=["number", "set", "get", "set string", "get string", "state"],
)
def test_pythonfmu_flavour_refuses_nonsense(flavour, instances, wrong, told):
    """By the log and by discarding what follows; see `pythonfmu_slave` for why not by a status."""
    slave = instances(flavour.slave(logging=True))
    slave.begin({"motor_position": 0.2})
    before = slave.everything()
    wrong(slave)
    assert [m.status for m in slave.log if told in m.text] == [ERROR]
    assert slave.everything() == before
    with pytest.raises(Exception, match="fmi2DoStep"):
        slave.fmu.doStep(0.0, 0.1)
    assert "failed before" in slave.log[-1].text
    assert slave.everything() == before
    slave.fmu.reset()
    slave.begin({"motor_position": 0.2})
    slave.fmu.doStep(0.0, 0.1)
    assert slave.get("time") == 0.1


BROKEN_MEMORY = """
import gc, sys
from fmu_driver import Fmu
flavour = Fmu(sys.argv[1], sys.argv[2])
for _ in range(20):
    slave = flavour.slave(logging=True)
    slave.begin({"motor_position": 0.2})
    for _ in range(20):
        slave.set("load_torque", float("nan"))
    slave.free()
    gc.collect()
print("alive")
"""


def test_pythonfmu_flavour_leaves_the_memory_whole_when_it_refuses(flavour, tmp_path):
    """In a process of its own whose memory is checked."""
    run = subprocess.run(
        [sys.executable, "-c", BROKEN_MEMORY, str(flavour.path), str(tmp_path / "unpacked")],
        env=os.environ | {"PYTHONMALLOC": "debug", "PYTHONPATH": str(Path(__file__).parents[1])},
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.returncode == 0, run.stderr[-2000:]
    assert run.stdout.endswith("alive\n")


def test_pythonfmu_flavour_hides_no_package_from_who_loads_it(flavour):
    """Its resources stay on the search path, which further processes inherit."""
    flavour.slave()
    run = subprocess.run(
        [sys.executable, "-c", f"import sys; sys.path[:] = {sys.path!r}; import elastic_tendon"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.returncode == 0, run.stderr


@pytest.mark.usefixtures("made_soon")
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
