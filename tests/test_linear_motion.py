"""``motion = "linear"``: the equations of a rotary machine in metres and newtons, everywhere."""

import re
import zipfile
from dataclasses import replace
from io import StringIO

import control
import fmpy
import numpy as np
import pandas as pd
import pytest
from matplotlib.text import Text
from rich.console import Console

import elastic_tendon as et
from elastic_tendon.actuator.motion_kind import MotionKind
from elastic_tendon.comparison.simulated import default_table
from elastic_tendon.diagnosis.candidates import candidates
from elastic_tendon.evidence.gather import PARAMETERS
from elastic_tendon.reports.fleet_figure import fleet_figure
from elastic_tendon.reports.fleet_tables import pooled_table, robots_table
from elastic_tendon.reports.write import report
from elastic_tendon.sweeps.factors import parse_factor
from elastic_tendon.sweeps.fleet import fleet
from elastic_tendon.sweeps.points import points
from elastic_tendon.sweeps.simulations import simulations

TIME = np.arange(0.0, 2.0, 0.005)
LOAD = 60.0 * np.sin(2.0 * TIME) + 40.0 * np.sin(5.1 * TIME + 1.0)
CONTENT = {
    "name": "axis",
    "link": {"inertia": 95.0, "damping": 203.0},
    "effects": {"coulomb_friction": {"torque": 20.0}, "quadratic_drag": {"coefficient": 5.0}},
}
ROTARY = et.load_model(CONTENT)
LINEAR = et.load_model({**CONTENT, "motion": "linear"})
# units of a machine that turns, as no text of one that slides has them; a phase may be in degrees
TURNING = re.compile(r"\bm?rad\b|N·m\b|kg·m²|\bN\.m\b|\bkg\.m2\b|_rad\b|_Nm\b|(?<!phase \()°")


def recording(**units):
    names = {"load_torque": "N", "joint_position": "mm"} | units
    values = {"load_torque": LOAD, "joint_position": 1e3 * np.cumsum(LOAD) * 1e-6}
    columns = {f"{signal}_{unit}": values[signal] for signal, unit in names.items()}
    return pd.DataFrame({"time_s": TIME, **columns})


def test_its_numbers_are_those_of_the_rotary_model_bit_for_bit():
    turned, moved = (et.simulate(model, TIME, load_torque=LOAD) for model in (ROTARY, LINEAR))
    assert np.array_equal(turned.outputs, moved.outputs)
    assert np.ptp(moved["joint_position"]) > 0.05
    with_springs = et.models.figure_7.model_dump(exclude_none=True)
    turned, moved = (
        et.simulate(et.load_model({**with_springs, "motion": kind}), TIME, 0.1 * np.sin(TIME))
        for kind in ("rotary", "linear")
    )
    assert np.array_equal(turned.outputs, moved.outputs)


def test_units_of_its_numbers():
    units = {quantity.path: quantity.unit for quantity in LINEAR.quantities()}
    assert units == {
        "link.inertia": "kg",
        "link.damping": "N.s/m",
        "effects.coulomb_friction.torque": "N",
        "effects.quadratic_drag.coefficient": "N.s2/m2",
    }
    assert not any(TURNING.search(unit) for unit in units.values())
    assert et.load_model(LINEAR.model_dump()) == LINEAR
    assert "motion" in LINEAR.to_toml()
    assert "motion" not in ROTARY.to_toml()


@pytest.mark.parametrize(
    ("rotary", "linear"),
    [
        ("about 20 N·m at any speed", "about 20 N at any speed"),
        ("damping 3 N·m·s/rad, J 2 kg·m²", "damping 3 N·s/m, J 2 kg"),
        ("RMS 0.3 mrad; 0.1 to 0.2 rad", "RMS 0.3 mm; 0.1 to 0.2 m"),
        ("Constant torque of the joint torque", "Constant force of the joint force"),
        ("joint_torque, effects.constant_torque.torque, interface torque", ...),
        ("stiffness 3 N/m, gradient, radius 2 m", ...),
        ("natural frequency (rad/s); speed 3 rad/s", "natural frequency (1/s); speed 3 m/s"),
        ("poles 1.5 ± 3j rad/s", "poles 1.5 ± 3j 1/s"),
        ("coulomb_friction.\ntorque", ...),
    ],
)
def test_words_and_units_change_and_names_do_not(rotary, linear):
    expected = rotary if linear is ... else linear
    assert MotionKind.LINEAR.words(rotary) == expected
    assert MotionKind.ROTARY.words(rotary) == rotary


def test_errors_in_a_model_name_its_units():
    with pytest.raises(et.ModelError, match=r"link.inertia: -1.0 is outside 1e-09 to 10000 kg$"):
        et.load_model({**CONTENT, "motion": "linear", "link": {"inertia": -1.0}})
    with pytest.raises(et.ModelError, match="motion: 'straight' is refused: input should be 'rot"):
        et.load_model({**CONTENT, "motion": "straight"})


def test_files_in_metres_are_read_and_those_of_a_machine_that_turns_refused():
    read = et.read(recording())
    assert read.motion is MotionKind.LINEAR
    assert read.load_torque == pytest.approx(LOAD)
    assert et.compare(LINEAR, read).rmse()["joint_position"] > 0.0
    with pytest.raises(et.MeasurementError, match='write motion = "linear" at the top of the mod'):
        et.compare(ROTARY, read)
    turned = et.read(recording(load_torque="Nm", joint_position="mrad"))
    with pytest.raises(et.MeasurementError, match='write motion = "rotary" at the top of the mod'):
        et.compare(LINEAR, turned)
    with pytest.raises(et.MeasurementError, match="is in mm, as of a linear machine, and load_tor"):
        et.read(recording(load_torque="Nm"))


def test_a_recording_without_units_is_of_any_machine():
    measured = et.Measurement(TIME, load_torque=LOAD, signals={"joint_position": 0.01 * LOAD})
    assert et.compare(ROTARY, measured).rmse() == et.compare(LINEAR, measured).rmse()


def test_tables_figures_and_reports_have_its_units(tmp_path):
    assert list(default_table(LINEAR)) == [
        *("time_s", "load_torque_N", "joint_position_m", "joint_velocity_m_per_s")
    ]
    compared = et.compare(LINEAR, et.read(recording()))
    drawn = " ".join(text.get_text() for text in compared.plot().findobj(Text))
    assert "joint position (m)" in drawn
    assert re.search(r"joint_position: RMS error \S+ m, ", compared.summary())
    assert not TURNING.search(drawn)
    assert not TURNING.search(et.locate(compared).summary())
    assert not TURNING.search(str(compared.to_dict()["files"][0]["signals"]))
    report(compared, tmp_path / "x.html")
    page = re.sub("<script.*?</script>", "", (tmp_path / "x.html").read_text("utf-8"), flags=re.S)
    assert " mm" in page
    assert not TURNING.search(page[page.index("<body") :])


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.usefixtures("made_soon")
def test_units_and_terminals_of_its_fmu(version, tmp_path):
    path = et.export_fmu(LINEAR, tmp_path / "x.fmu", fmi_version=version)
    described = fmpy.read_model_description(str(path))
    units = {variable.name: variable.unit for variable in described.modelVariables}
    assert units["joint_position"] == "m"
    assert units["joint_velocity"] == "m/s"
    assert units["load_torque"] == "N"
    assert units["link.inertia"] == "kg"
    assert units["link.damping"] == "N.s/m"
    defined = {unit.name: unit.baseUnit for unit in described.unitDefinitions}
    assert (defined["N"].kg, defined["N"].m, defined["N"].s) == (1, 1, -2)
    assert "rad" not in " ".join(defined)
    with zipfile.ZipFile(path) as archive:
        page = archive.read("documentation/index.html").decode()
        assert not TURNING.search(page)
        if version == 3:
            terminals = archive.read("terminalsAndIcons/terminalsAndIcons.xml").decode()
            assert "Mechanics.Translational.Interfaces.Flange_b" in terminals
            assert "Rotational" not in terminals


@pytest.mark.usefixtures("made_soon")
def test_the_evidence_of_its_fmu_counts_in_metres(tmp_path):
    straight = replace(et.read(recording()).window(0.0, 1.0), interpolation="linear")
    evidence = et.gather_evidence(LINEAR, straight)
    path = et.export_fmu(LINEAR, tmp_path / "x.fmu", evidence=evidence)
    found = et.verify(path, inputs=straight)
    assert found.passed, found.faults
    assert not re.search("not replayed", str(found))
    assert re.search(r"joint_position -?\S+ to \S+ m, joint_velocity \S+ to \S+ m/s", str(found))
    assert 'unit="kg"' in evidence.files[PARAMETERS].decode()
    drawn = " ".join(text.get_text() for text in found.plot().findobj(Text))
    for text in (str(found), str(evidence), evidence.files[PARAMETERS].decode(), drawn):
        assert not TURNING.search(text)


WITH_SPRINGS = et.load_model(
    {**et.models.figure_7.model_dump(exclude_none=True), "motion": "linear"}
)


def _loop(stiffness, edge):
    """A loop that keeps an oscillation up where it meets this stiffness."""
    return control.ss([[0.0, 1.0], [-stiffness, stiffness - edge]], [[0], [1]], [[1, 0]], 0)


@pytest.fixture(scope="module")
def results():
    """Of a machine with springs, what can be printed and drawn."""
    motor, load = 0.2 * np.sin(9.0 * TIME), 2.0 * np.sin(14.0 * TIME)
    moved = et.simulate(WITH_SPRINGS, TIME, motor, load)
    noisy = moved["joint_position"] + 1e-4 * np.random.default_rng(1).standard_normal(len(TIME))
    table = {"motor_position_m": motor, "load_torque_N": load, "joint_position_mm": 1e3 * noisy}
    measured = et.read(pd.DataFrame({"time_s": TIME, **table}))
    compared = et.compare(WITH_SPRINGS.with_values({"link.damping": 0.3}), measured)
    varied = points([parse_factor(WITH_SPRINGS, "link.inertia=5%")], "monte-carlo", 2)
    describing = et.describing_function(WITH_SPRINGS, [0.05, 0.3], frequency=5.0)
    return {
        "trajectory": moved,
        "recording": measured,
        "location": et.locate(compared),
        "design": et.design(WITH_SPRINGS),
        "linear": et.linearise(WITH_SPRINGS, "III"),
        "describing": describing,
        "no cycle": et.limit_cycles(describing, lambda stiffness, _: _loop(stiffness, 1.0)),
        "cycle": et.limit_cycles(
            describing, lambda stiffness, _: _loop(stiffness, sum(describing.stiffness) / 2)
        ),
        "curve": et.characteristic_curves(WITH_SPRINGS)[0],
        "many": et.simulate_many(
            *(WITH_SPRINGS, {"link.damping": [0.1, 0.3]}, TIME, motor, load),
            outputs=["joint_position", "joint_torque"],
        ),
        "sensitivities": et.sensitivities(
            *(WITH_SPRINGS, TIME, motor, load),
            parameters=["link.inertia"],
            initial_states=["joint_velocity"],
        ),
        "fit": et.fit(WITH_SPRINGS, measured, free=["link.damping"]),
        "sweep": et.sweep(simulations(WITH_SPRINGS, varied)),
    }


def test_what_is_printed_and_drawn_counts_in_metres(results):
    for name, result in results.items():
        drawn = " ".join(text.get_text() for text in result.plot().findobj(Text))
        for text in (result.summary(), drawn):
            assert not TURNING.search(text), (name, text)
    units = {row.unit for row in results["design"].rows().values()}
    assert units == {"m", "N", "N/m", "N.s/m", "kg", "1/s"}
    assert "m/s" not in results["linear"].summary()
    assert results["cycle"].cycles
    assert results["no cycle"].reason


def test_only_what_turns_is_drawn_in_degrees_too(results):
    drawn = {name: results[name].plot() for name in ("curve", "describing")}
    turning = et.characteristic_curves(et.models.figure_7)[0].plot()
    assert "(°)" in " ".join(text.get_text() for text in turning.findobj(Text))
    for figure in drawn.values():
        assert not any("°" in text.get_text() for text in figure.findobj(Text))


def test_what_turns_is_no_candidate_for_a_machine_that_slides():
    measured = et.Measurement(TIME, load_torque=LOAD, signals={"joint_position": 0.01 * LOAD})
    bare = [model.without(model.effect_ids) for model in (ROTARY, LINEAR)]
    turned, moved = (candidates(model, [measured.for_model(model)]) for model in bare)
    assert set(turned) - set(moved) == {"gravity_load"}
    assert "constant_torque" in moved


def test_the_command_line_says_metres(tmp_path, monkeypatch):
    from typer.testing import CliRunner

    from elastic_tendon.cli import app

    monkeypatch.chdir(tmp_path)
    (tmp_path / "axis.toml").write_text(LINEAR.to_toml(), "utf-8")
    recording().to_csv("run.csv", index=False)
    result = CliRunner().invoke(app, ["compare", "axis.toml", "run.csv"])
    assert result.exit_code == 0, result.output
    assert "joint position, mm" in result.stdout
    assert not TURNING.search(result.stdout)


def test_a_sweep_counts_in_metres(tmp_path):
    masses = points([parse_factor(LINEAR, "link.inertia=5%")], "monte-carlo", 4)
    table = pd.read_csv(et.sweep(simulations(LINEAR, masses), tmp_path / "runs.csv").path)
    assert "joint_position.rms_m" in table
    assert not any(TURNING.search(column) for column in table)


def test_a_fleet_counts_in_newtons(tmp_path):
    moved = et.simulate(LINEAR, TIME, load_torque=LOAD)["joint_position"]
    random = np.random.default_rng(2)
    for robot in ("first", "second"):
        noisy = recording()
        noisy["joint_position_mm"] = 1e3 * (moved + 1e-5 * random.standard_normal(len(TIME)))
        noisy.to_csv(tmp_path / f"{robot}.csv", index=False)
    table = fleet(LINEAR, sorted(map(str, tmp_path.glob("*.csv")))).rows(0, 2)
    assert not any(table["failure"])
    assert table["joint_position_rmse_after_m"].max() < 1.1e-5
    assert not any(TURNING.search(column) for column in table)
    found = et.fleet_findings(LINEAR, table)
    tables = robots_table(LINEAR, table), pooled_table(found)
    drawn = " ".join(text.get_text() for text in fleet_figure(LINEAR, table).findobj(Text))
    with (console := Console(width=200, record=True, file=StringIO())).capture():
        for one in filter(None, tables):
            console.print(one)
    for text in (drawn, str(found), console.export_text()):
        assert not TURNING.search(text)
