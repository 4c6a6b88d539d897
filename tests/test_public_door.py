"""Everything that users do goes through ``import elastic_tendon as et``."""

import ast
import json
import logging
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import control
import mujoco
import numpy as np
import pandas as pd
import pytest

import elastic_tendon as et
from elastic_tendon.demo import DATA
from elastic_tendon.sweeps.fleet import Robot

ROOT = Path(__file__).parents[1]
MODEL = "biorob_x4_joint_3"
TIME = np.linspace(0.0, 4.0, 801)
MOTOR, LOAD = 0.4 * np.sin(8.0 * TIME), 7.0 * np.sin(2.0 * TIME)
LONGEST = 1500  # characters of a repr
FRICTION_OR_GRAVITY = et.Options(only=("coulomb_friction", "gravity_load"))


@pytest.fixture(scope="module")
def model() -> et.Model:
    return et.load_model(MODEL)


@pytest.fixture(scope="module")
def recording(model) -> et.Measurement:
    """Of a machine with dry friction."""
    machine = model.with_effect("coulomb_friction", {"torque": 0.3})
    run = et.simulate(machine, TIME, MOTOR, LOAD)
    noise = 1e-4 * np.random.default_rng(1).standard_normal(len(TIME))
    return et.Measurement(
        time=TIME,
        motor_position=MOTOR,
        signals={"joint_position": run["joint_position"] + noise},
        load_torque=LOAD,
    )


@pytest.fixture(scope="module")
def found(model, recording) -> et.Diagnosis:
    return et.diagnose(model, recording, options=FRICTION_OR_GRAVITY)


def test_the_door_says_what_it_has() -> None:
    assert set(et.__all__) == set(dir(et))
    assert re.fullmatch(r"\d+\.\d+\.\d+.*", et.__version__)
    for name in et.__all__:
        assert getattr(et, name) is not None


def test_importing_it_imports_nothing_heavy() -> None:
    code = (
        "import sys, elastic_tendon; print(sorted({'numpy', 'casadi', 'pandas'} & {*sys.modules}))"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout.strip() == "[]"


def test_models_are_listed_loaded_and_made(model, tmp_path) -> None:
    assert MODEL in et.models
    assert MODEL in list(et.models)
    assert getattr(et.models, MODEL) == model
    with pytest.raises(AttributeError, match="there is no bundled model nothing; there are bench"):
        _ = et.models.nothing
    (tmp_path / "own.toml").write_text(model.to_toml())
    assert et.load_model(tmp_path / "own.toml") == model
    assert et.load_model(model.model_dump()) == model


def test_effects_are_there_by_name() -> None:
    assert et.effects.coulomb_friction.id == "coulomb_friction"
    assert [getattr(et.effects, one.id) for one in et.effects.CATALOGUE] == [*et.effects.CATALOGUE]
    ripple = et.effects.load(ROOT / "examples" / "own_effect" / "tooth_ripple.py")
    assert et.effects.BY_ID[ripple.id] is ripple


def test_a_file_is_read_with_window_and_map(recording, tmp_path) -> None:
    table = pd.DataFrame(
        {
            "time_s": TIME,
            "motor_position_rad": MOTOR,
            "load_torque_Nm": LOAD,
            "enc2": -np.rad2deg(recording.signals["joint_position"]),
        }
    )
    table.to_csv(tmp_path / "run.csv", index=False)
    for data in (tmp_path / "run.csv", str(tmp_path / "run.csv"), table):
        read = et.read(data, window=(0.0, 2.0), map={"joint_position": "enc2:deg*-1"})
        assert len(read.time) == 401
        whole = recording.signals["joint_position"][:401]
        assert read.signals["joint_position"] == pytest.approx(whole, abs=1e-12)
        assert read.load_torque == pytest.approx(LOAD[:401])


def test_a_table_lacks_what_a_file_may_lack() -> None:
    with pytest.raises(et.MeasurementError, match="motor_position"):
        et.read(pd.DataFrame({"time_s": TIME, "joint_position_rad": TIME}))
    known = et.read(
        pd.DataFrame({"time_s": TIME, "motor_position_rad": MOTOR, "joint_position_rad": MOTOR}),
        noise={"joint_position": 2e-4},
    )
    assert known.noise["joint_position"].sigma == pytest.approx(2e-4)


def test_a_measurement_is_made_of_lists() -> None:
    made = et.Measurement(time=[0.0, 0.1], motor_position=[0.0, 1.0], signals={"a": [1, 2]})
    assert made.time.dtype == made.signals["a"].dtype == np.float64
    with pytest.raises(et.MeasurementError, match=r"motor_position has shape \(3,\), but time has"):
        et.Measurement(time=[0.0, 0.1], motor_position=[0.0, 1.0, 2.0])


def test_a_recording_is_simulated_as_its_inputs_are(model, recording) -> None:
    run = et.simulate(model, recording)
    start = {name: run[name][0] for name in ("joint_position", "joint_velocity")}
    between = recording.input_interpolation
    same = et.simulate(model, TIME, MOTOR, LOAD, initial_state=start, interpolation=between)
    assert run["joint_position"] == pytest.approx(same["joint_position"], abs=1e-6)
    with pytest.raises(ValueError, match="beside the time motor_position is needed"):
        et.simulate(model, TIME)


def test_actuators_are_stepped_by_another_simulator(model) -> None:
    held = model.at("joint")
    actuators = et.Actuators([held] * 2)
    actuators.step(TIME[1], 0.0, 0.0, joint_position=[0.0, 0.01], joint_velocity=0.0)
    torque = et.simulate(held, TIME[:2], [0.0, 0.0], joint_position=[0.0, 0.01])["joint_torque"]
    assert actuators["joint_torque"] == pytest.approx([0.0, torque[1]])


def test_an_arm_in_mujoco_has_elastic_joints(model) -> None:
    robot = mujoco.MjModel.from_xml_path(str(ROOT / "examples" / "arm" / "arm.xml"))
    arm = et.Arm(robot, {"elbow": model})
    arm.step(arm.motor_position, 0.0)
    assert arm.largest_stable_step() > robot.opt.timestep
    with pytest.raises(et.ArmError, match="no joint 'knee'"):
        et.Arm(robot, {"knee": model})
    assert et.largest_stable_step([[1.0]], [[4.0]], [[0.0]]) == pytest.approx(1.0)


def test_a_recording_of_an_arm_is_cut_into_joints(model, recording) -> None:
    robot = mujoco.MjModel.from_xml_string(
        '<mujoco><worldbody><body><joint name="joint"/><inertial pos="0 0 0" mass="1" '
        'diaginertia="0.03 0.03 0.03"/></body></worldbody></mujoco>'
    )
    alone = et.cut_into_joints(robot, {"joint": model}, {"joint": recording})["joint"]
    assert isinstance(alone, et.CutJoint)
    assert alone.model.link.inertia == pytest.approx(0.03)
    ends = np.searchsorted(recording.time, alone.recording.time)
    assert alone.recording.load_torque == pytest.approx(LOAD[ends], abs=1e-6)


def test_one_recording_or_several_everywhere(model, recording) -> None:
    for function in (et.compare, et.fit):
        assert repr(function(model, recording)) == repr(function(model, [recording]))
    fitted, heldout = recording.window(0.0, 2.0), recording.window(2.1, 4.0)
    added = et.add(model, "coulomb_friction", fitted, validate=heldout)
    assert added.ladder[-1].heldout_rmse


def test_a_diagnosis_says_what_is_missing(found) -> None:
    assert found.verdict == "missing_effect"
    assert found.added == ("coulomb_friction",)
    assert found.model.effects["coulomb_friction"]["torque"] == pytest.approx(0.3, abs=0.01)
    assert found.ladder[-1].rmse["joint_position"] == pytest.approx(1e-4, rel=0.1)
    assert found.next_experiment is None
    assert re.search(r"^\+ Coulomb friction +joint_position \S+ rad \(", repr(found), re.M)


def test_effects_are_added_one_or_several(model, recording) -> None:
    one = et.add(model, "coulomb_friction", recording)
    two = et.add(model, ["coulomb_friction", "gravity_load"], recording)
    assert set(one.model.effects) < set(two.model.effects)


def many(model) -> et.Many:
    """Of three runs the last fails."""
    parameters = {"link.inertia": [0.02, 0.03, np.nan]}
    return et.simulate_many(model, parameters, TIME, MOTOR, outputs=["joint_torque", "slack_state"])


def cycles(model) -> et.LimitCycles:
    """Of a loop whose spring pulls the wrong way where the tendons are stiff."""
    describing = et.describing_function(model, [0.1, 0.2, 0.4])

    def loop(stiffness: float, _: float) -> control.StateSpace:
        return control.ss([[0.0, 1.0], [-stiffness, stiffness - 35.0]], [[0], [1]], [[1, 0]], 0)

    return et.limit_cycles(describing, loop)


def shared(model) -> et.FleetFindings:
    """Of three robots that differ in their damping."""
    task = et.fleet(model, [Robot(name, (f"{name}.csv",)) for name in "abc"])
    table = pd.concat([task.failed(run, "") for run in range(3)]).assign(verdict="adequate")
    dampings = np.array([0.15, 0.16, 0.17])
    ends = {f"link.damping{end}": dampings + by for end, by in ((".low", -0.01), (".high", 0.01))}
    return et.fleet_findings(model, table.assign(**{"link.damping": dampings}, **ends))


def verified(model, recording) -> et.Verification:
    with tempfile.TemporaryDirectory() as folder:
        evidence = et.gather_evidence(model, recording)
        return et.verify(et.export_fmu(model, Path(folder) / "x.fmu", evidence=evidence))


RESULTS = {
    "Addition": lambda model, recording: et.add(model, "coulomb_friction", recording),
    "CharacteristicCurve": lambda model, _: et.characteristic_curves(model)[0],
    "Comparison": et.compare,
    "DescribingFunction": lambda model, _: et.describing_function(model, [0.1, 0.3]),
    "DesignTable": lambda model, _: et.design(model),
    "Diagnosis": lambda model, run: et.diagnose(model, run, options=FRICTION_OR_GRAVITY),
    "Evidence": et.gather_evidence,
    "FitResult": et.fit,
    "FleetFindings": lambda model, _: shared(model),
    "LimitCycles": lambda model, _: cycles(model),
    "LinearModel": lambda model, _: et.linearise(model, "I", inputs=["load_torque"]),
    "Location": lambda model, recording: et.locate(et.compare(model, [recording, recording])),
    "Many": lambda model, _: many(model),
    "Measurement": lambda _, recording: recording,
    "Sensitivities": lambda model, _: et.sensitivities(
        *(model, TIME, MOTOR), parameters=["link.inertia"], initial_states=["joint_velocity"]
    ),
    "Swept": lambda model, recording: et.sweep(
        model, vary={"link.inertia": "5%"}, runs=8, motion=recording
    ),
    "Trajectory": et.simulate,
    "Verification": verified,
}
# what users give or look at, and what they get back only within a result
NO_RESULTS = {
    *(
        "Actuators",
        "CutJoint",
        "Arm",
        "Drive",
        "LimitCycle",
        "Model",
        "Motion",
        "OperatingPoint",
        "Options",
        "Points",
    ),
    *("ReadOptions", "SlackState", "Task"),
}


def test_every_class_is_an_error_a_result_or_known_to_be_none() -> None:
    classes = {name for name in et.__all__ if isinstance(getattr(et, name), type)}
    errors = {name for name in classes if name.endswith("Error")}
    assert classes - errors - NO_RESULTS == RESULTS.keys()


@pytest.mark.parametrize("name", RESULTS)
def test_a_result_shows_itself_and_becomes_table_figure_and_data(
    name, model, recording, tmp_path
) -> None:
    result = RESULTS[name](model, recording)
    assert type(result) is getattr(et, name)
    assert 20 < len(repr(result)) < LONGEST
    assert result._repr_html_().startswith("<pre>")
    if not isinstance(result, et.LinearModel):  # matrices are no table
        assert len(result.to_dataframe()) > 0
    result.save_json(tmp_path / "result.json")
    assert json.loads((tmp_path / "result.json").read_text()) == result.to_dict()
    figure = result.plot()
    drawn = [axes for axes in figure.axes if axes.get_visible() and axes.axison]
    assert drawn
    first = [axes for axes in drawn if axes.get_subplotspec().is_first_col()]
    assert all(axes.get_xlabel() or axes.get_ylabel() for axes in first)
    figure.savefig(tmp_path / "result.png")


def test_what_is_given_to_functions_shows_itself_shortly(model, tmp_path) -> None:
    points = et.vary(model, {"link.inertia": "0.02:0.04:1000"})
    motion = et.Motion(TIME, MOTOR, LOAD)
    task = et.simulations(model, points, motion=motion)
    logs = [tmp_path / "a.csv", tmp_path / "b.csv"]
    for log in logs:
        log.touch()
    fleet = et.fleet(model, logs, et.ReadOptions())
    for given in (model, points, motion, task, fleet, et.OperatingPoint(), et.load_demo()):
        assert 10 < len(repr(given)) < LONGEST
    assert repr(fleet) == f"Fleet of 2 robots, to be diagnosed against {MODEL}"


def test_a_trajectory_prints_the_range_of_each_output_with_its_unit(model) -> None:
    lines = repr(et.simulate(model, TIME, MOTOR)).splitlines()
    torque = next(line.split() for line in lines if "joint_torque" in line)
    state = next(line.split() for line in lines if "slack_state" in line)
    assert torque[2] == "to"
    assert torque[4:] == ["N·m"]
    assert state[4:] == []  # it has none


def test_contracts_are_named(model, recording, found) -> None:
    assert found.to_dict()["schema"] == "elastic-tendon/diagnosis/2"
    assert et.compare(model, recording).to_dict()["schema"] == "elastic-tendon/comparison/1"


def test_runs_of_a_sweep_are_drawn_over_time(model) -> None:
    points = et.vary(model, {"link.inertia": "0.02,0.03"})
    motion = et.Motion(TIME, MOTOR)
    figure = et.sweep(et.simulations(model, points, motion=motion, keep="trajectories")).plot()
    assert [len(axes.get_lines()) for axes in figure.axes] == [2, 2, 2]
    assert figure.axes[0].get_ylabel() == "joint position\n(rad)"


def test_runs_that_failed_are_told_of(model) -> None:
    found = many(model)
    assert repr(found).startswith("3 runs of 801 samples, 1 failed\n  the first: stopped at 0 s")
    assert found.plot().get_suptitle() == "3 runs, 1 failed"


def test_limit_cycles_are_marked_where_they_are(model) -> None:
    found = cycles(model)
    lines = {line.get_label(): line for line in found.plot().axes[0].get_lines()}
    (cycle,) = found.cycles
    assert repr(found).startswith("attracting limit cycle: amplitude 0.")
    assert lines["attracting\nlimit cycle"].get_xydata().tolist() == [
        [cycle.amplitude, cycle.stiffness]
    ]


def test_a_trajectory_is_a_table_at_once(model, recording) -> None:
    run = et.simulate(model, recording)
    table = pd.DataFrame(run)
    assert list(table.columns)[:2] == ["time", "joint_torque"]
    assert table["joint_position"].to_numpy() == pytest.approx(run["joint_position"])


def test_a_report_and_an_fmu_are_written(found, model, recording, tmp_path) -> None:
    et.report(found, tmp_path / "diagnosis.html")
    et.report(et.compare(model, recording), tmp_path / "comparison.html")
    for name in ("diagnosis", "comparison"):
        assert (tmp_path / f"{name}.html").read_text().startswith("<!DOCTYPE html>")
    assert et.export_fmu(found.model, tmp_path / "actuator.fmu", fmi_version=3).is_file()


def test_every_error_is_of_one_class() -> None:
    errors = [getattr(et, name) for name in et.__all__ if name.endswith("Error")]
    assert len(errors) > 5
    assert all(issubclass(error, et.ElasticTendonError) for error in errors)


def test_nothing_is_printed_and_logging_has_a_null_handler(model, recording, capsys) -> None:
    et.compare(model, recording)
    assert capsys.readouterr() == ("", "")
    handlers = logging.getLogger("elastic_tendon").handlers
    assert any(isinstance(one, logging.NullHandler) for one in handlers)


# ---- what users read goes through the door alone -----------------------------------------------


def printed_code() -> dict[str, str]:
    """All Python that users are shown: scripts, cells of notebooks, blocks of the README."""
    examples = ROOT / "examples"
    code = {str(path.relative_to(ROOT)): path.read_text() for path in examples.rglob("*.py")}
    for path in examples.rglob("*.ipynb"):
        cells = json.loads(path.read_text())["cells"]
        text = "\n".join("".join(one["source"]) for one in cells if one["cell_type"] == "code")
        code[str(path.relative_to(ROOT))] = re.sub(r"^[%!].*$", "", text, flags=re.MULTILINE)
    blocks = re.findall(r"^```python\n(.*?)^```", (ROOT / "README.md").read_text(), re.M | re.S)
    return code | {f"README.md, block {number}": text for number, text in enumerate(blocks)}


def beyond_the_door(text: str) -> Iterator[str]:
    """What code takes of elastic_tendon that is not public."""
    doors, catalogues = set(), set()
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            for one in node.names:
                if one.name == "elastic_tendon":
                    doors.add(one.asname or one.name)
                elif one.name.startswith("elastic_tendon."):
                    yield one.name
        elif isinstance(node, ast.ImportFrom) and (node.module or "").startswith("elastic_tendon"):
            for one in node.names:
                if node.module != "elastic_tendon" or one.name not in et.__all__:
                    yield f"{node.module}.{one.name}"
                if one.name == "effects":
                    catalogues.add(one.asname or one.name)
    catalogues |= {f"{door}.effects" for door in doors}
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Attribute):
            of = ast.unparse(node.value)
            if of in doors and node.attr not in et.__all__:
                yield f"{of}.{node.attr}"
            if of in catalogues and not _is_public_of_effects(node.attr):
                yield f"{of}.{node.attr}"


def _is_public_of_effects(name: str) -> bool:
    thing = getattr(et.effects, name, None)
    return name == "symbolic" or not (thing is None or isinstance(thing, ModuleType))


@pytest.mark.parametrize("name", printed_code())
def test_users_are_shown_the_door_alone(name) -> None:
    assert list(beyond_the_door(printed_code()[name])) == []


@pytest.mark.parametrize(
    "code",
    [
        "import elastic_tendon.sweeps",
        "import elastic_tendon.sweeps as sweeps",
        "from elastic_tendon.comparison.compare import compare",
        "from elastic_tendon import comparison",
        "import elastic_tendon as et\net.reports.tables",
        "import elastic_tendon as et\net.effects.registry.Registry",
        "from elastic_tendon import effects\neffects.base.Effect",
    ],
)
def test_a_way_around_the_door_is_seen(code) -> None:
    assert list(beyond_the_door(code))


# ---- many runs, linear models, design ----------------------------------------------------------


def test_numbers_are_varied_and_swept_into_a_table(model, tmp_path) -> None:
    varied = et.vary(model, {"link.inertia": "0.02:0.04", "link.damping": "20%"}, "sobol", runs=8)
    motion = et.Motion(TIME, MOTOR, LOAD)
    task = et.simulations(model, varied, motion=motion, outputs=["joint_torque"])
    done = et.sweep(task, tmp_path / "runs.csv", workers=1)
    table = done.to_dataframe()
    assert repr(done) == f"Sweep of 8 runs, 0 failed; results in {tmp_path / 'runs.csv'}"
    assert done.to_dict()["runs"] == len(table) == 8
    run = model.with_values(
        {path: float(table[path].iloc[3]) for path in ("link.inertia", "link.damping")}
    )
    torque = et.simulate(run, TIME, MOTOR, LOAD)["joint_torque"]
    assert table["joint_torque.maximum_Nm"].iloc[3] == pytest.approx(torque.max(), rel=1e-9)


def test_a_model_is_swept_at_once(model, recording, tmp_path) -> None:
    spread = {"link.inertia": "5%"}
    swept = et.sweep(model, vary=spread, runs=8, motion=recording, workers=1)
    assert repr(swept) == "Sweep of 8 runs, 0 failed"
    assert swept.to_dict()["path"] is None
    table = swept.to_dataframe()
    assert table["link.inertia"].nunique() == 8
    assert (table["joint_position.rms_error_rad"] > 0.0).all()
    filed = et.sweep(model, tmp_path / "runs.csv", vary=spread, runs=8, motion=recording)
    pd.testing.assert_frame_equal(filed.to_dataframe(), table)
    stated = model.model_copy(update={"uncertainty": {"link.inertia": 0.2, "link.damping": 0.1}})
    assert {"link.inertia", "link.damping"} <= {*et.sweep(stated, runs=2).to_dataframe().columns}
    assert len(et.sweep(model, vary={"link.inertia": "0.02,0.03,0.04"}).to_dataframe()) == 3
    with pytest.raises(et.SweepError, match="a task says itself what varies"):
        et.sweep(et.simulations(model, et.vary(model, spread, runs=8)), runs=2)


def test_a_number_that_states_its_uncertainty_varies_by_it(model) -> None:
    assert et.vary(model, {"link.inertia": None}, runs=3).count == 3
    assert et.vary(model, {"link.inertia": "0.02,0.03"}, "grid").count == 2
    with pytest.raises(et.SweepError, match="how many runs"):
        et.vary(model, {"link.inertia": "5%"})


def test_a_fleet_is_of_files(tmp_path) -> None:
    model = et.load_demo().model
    shutil.copyfile(DATA / "demo_fit.csv", tmp_path / "007.csv")
    (tmp_path / "NA.csv").write_text("time_s\n0.0\n")
    task = et.fleet(model, [tmp_path / "007.csv", tmp_path / "NA.csv"], et.ReadOptions())
    swept = et.sweep(task, tmp_path / "fleet.csv", workers=1)
    table = swept.to_dataframe()
    assert list(table["robot"]) == ["007", "NA"]
    assert list(table["verdict"]) == ["missing_effect", ""]
    assert table["appeared"][0] == "coulomb_friction"
    assert table["effects.coulomb_friction.torque"][0] == pytest.approx(0.35, rel=0.01)
    assert swept.plot().axes


def test_the_demo_is_a_model_and_two_recordings() -> None:
    demo = et.load_demo()
    assert et.compare(demo.model, demo.recording).noise_ratio()["joint_position"] > 100.0
    assert not demo.recording.shares_samples(demo.validation)


def test_where_a_model_fails_is_told_and_tabled(model, recording) -> None:
    where = et.locate(et.compare(model, [recording, recording]))
    assert repr(where).startswith("recording 1, joint_position: ")
    table = where.to_dataframe()
    parts = table[(table["recording"] == 2) & (table["by"] == "slack_state")]
    assert parts["share"].sum() == pytest.approx(1.0)


def test_limit_cycles_and_curves_have_their_way_in(model) -> None:
    (curve,) = et.characteristic_curves(model, [model.transmission.pretension_force])
    assert curve.stiffness.max() == pytest.approx(et.design(model).stiffness_state_3)
    # a small oscillation meets the stiffness of both tendons, a large one less
    small, large = et.describing_function(model, [0.05, 0.3]).stiffness
    assert large < small == pytest.approx(curve.stiffness.max(), rel=1e-4)
    assert et.SlackState(3).label == "III: both tendons taut"
