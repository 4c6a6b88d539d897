"""A fleet of the independent simulator: who has drifted, in what, and what appeared."""

import pickle
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from elastic_tendon import effects
from elastic_tendon.actuator.parameters import load_model, parse_model
from elastic_tendon.effects import CATALOGUE
from elastic_tendon.effects.registry import Registry
from elastic_tendon.errors import MeasurementError
from elastic_tendon.measurement import ReadOptions
from elastic_tendon.sweeps import fleet as subject
from elastic_tendon.sweeps import results
from elastic_tendon.sweeps.fleet import (
    SIGNALS,
    Robot,
    error_columns,
    fleet,
    named,
    robots_of,
)
from elastic_tendon.sweeps.results import read_fleet, read_results
from elastic_tendon.sweeps.task import FAILURE, RUN, TEXTS
from hidden_effect.cases import Order, machine_of, recording_of
from hidden_effect.machines import get, with_effects, with_numbers
from hidden_effect.recordings import Noise

RIPPLE = Path(__file__).parents[2] / "examples" / "own_effect" / "tooth_ripple.py"
DAMPING = "link.damping"
FRICTION = 0.15  # N·m
COLUMNS = {
    "motor_position": "motor_position_rad",
    "load_torque": "load_torque_Nm",
    "joint_position": "joint_position_rad",
}


def write(path, measurement, *, without=()):
    held = {**measurement.inputs, **measurement.signals}
    table = {"time_s": measurement.time}
    table |= {COLUMNS[name]: values for name, values in held.items() if name not in without}
    pd.DataFrame(table).to_csv(path, index=False)
    return str(path)


@pytest.fixture(scope="module")
def machine():
    return machine_of(Order("nothing", seed=5, duration=4.0))


@pytest.fixture(scope="module")
def model(machine):
    return parse_model(machine.tree, "as it should be")


@pytest.fixture(scope="module")
def logs(machine, tmp_path_factory):
    """Logs of a machine with more damping, one with friction, and one without a column."""
    folder = tmp_path_factory.mktemp("logs")
    damped = with_numbers(machine.tree, {DAMPING: 1.4 * get(machine.tree, DAMPING)})
    rubbing = with_effects(machine.tree, [("coulomb_friction", {"torque": FRICTION})])
    written = []
    for seed, (name, truth) in enumerate({"damped": damped, "rubbing": rubbing}.items()):
        order = Order("nothing", seed=seed, duration=4.0)
        shown = recording_of(order, machine, truth, Noise("white", 2e-4), name)
        written.append(write(folder / f"{name}.csv", shown.measurement))
    without = ("joint_position",)
    return [*written, write(folder / "blind.csv", shown.measurement, without=without)]


@pytest.fixture(scope="module")
def task(model, logs):
    options = ReadOptions(interpolation="cubic")
    return pickle.loads(pickle.dumps(fleet(model, robots_of(logs), options)))


@pytest.fixture(scope="module")
def table(task):
    return task.rows(0, 2)


def test_the_number_that_drifted_is_told_with_its_interval(machine, table):
    row = table.iloc[0]
    truth = 1.4 * get(machine.tree, DAMPING)
    assert (row["robot"], row["verdict"], row["appeared"]) == ("damped", "wrong_parameter", "")
    assert row["drifted"] == DAMPING
    assert row[DAMPING + ".low"] < truth < row[DAMPING + ".high"]
    assert row[DAMPING] == pytest.approx(truth, rel=0.02)


def test_the_effect_that_appeared_is_told_with_its_size(table):
    row = table.iloc[1]
    assert (row["robot"], row["verdict"]) == ("rubbing", "missing_effect")
    assert named(row["appeared"]) == ("coulomb_friction",)
    torque = "effects.coulomb_friction.torque"
    assert row[torque] == pytest.approx(FRICTION, rel=0.05)
    assert row[torque + ".low"] < FRICTION < row[torque + ".high"]
    assert np.isnan(table.iloc[0][torque])


def test_errors_before_and_after_are_told(table):
    columns = error_columns("joint_position")
    before, after = (table[columns["noise_ratio", when]] for when in ("before", "after"))
    assert (before > 3.0).all()
    assert after.between(0.8, 1.2).all()
    assert columns["rmse", "after"] == "joint_position_rmse_after_rad"
    assert table[columns["rmse", "after"]].between(1.6e-4, 2.4e-4).all()
    assert table[error_columns("joint_torque")["rmse", "after"]].isna().all()


def test_columns_are_those_of_the_model_whatever_the_robot(task, table):
    failed = task.failed(2, "the reason")
    assert list(failed.columns) == list(table.columns)
    assert failed.dtypes.equals(table.dtypes)
    assert list(failed.columns)[:5] == [RUN, "robot", "verdict", "drifted", "appeared"]
    assert failed.columns[-1] == FAILURE
    assert failed.iloc[0][[RUN, "robot", FAILURE]].tolist() == [2, "blind", "the reason"]


def test_a_log_that_cannot_be_read_is_a_failed_run(task):
    with pytest.raises(MeasurementError, match="there is no column joint_position_rad"):
        task.rows(2, 3)


def test_an_interrupt_leaves_no_half_diagnosis(task, monkeypatch):
    monkeypatch.setattr(subject, "diagnose", lambda *_: SimpleNamespace(complete=False))
    with pytest.raises(KeyboardInterrupt):
        task.rows(0, 1)


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
def test_results_are_read_as_they_were(task, suffix, tmp_path):
    if suffix == ".parquet":
        pytest.importorskip("pyarrow")
    path = tmp_path / f"fleet{suffix}"
    row = task.failed(0, "the reason").assign(robot="007", verdict="NA")
    row.to_csv(path, index=False) if suffix == ".csv" else row.to_parquet(path, index=False)
    found = read_results(path, TEXTS)
    assert found.iloc[0][["robot", "verdict", "drifted"]].tolist() == ["007", "NA", ""]
    pd.testing.assert_frame_equal(found, row, check_dtype=False)


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
def test_a_fleet_read_in_pieces_is_the_same_table(table, suffix, tmp_path, monkeypatch):
    if suffix == ".parquet":
        pytest.importorskip("pyarrow")
    monkeypatch.setattr(results, "PIECE", table.shape[1])  # a robot at a time
    path = tmp_path / f"fleet{suffix}"
    table.to_csv(path, index=False) if suffix == ".csv" else table.to_parquet(path, index=False)
    found = read_fleet(path)
    stored = found.memory_usage()
    assert stored.filter(like="effects.").sum() < 0.1 * stored.sum()
    dense = found.astype({name: np.float64 for name in found if name.startswith("effects.")})
    pd.testing.assert_frame_equal(dense, read_results(path, TEXTS), check_dtype=False)


# ---- identity ----------------------------------------------------------------------------------


def test_identity_is_that_of_files_and_what_lies_beside_them(model, tmp_path):
    log = tmp_path / "a.csv"
    log.write_text("time\n")
    names = [str(log)]

    def identity(**options):
        return fleet(model, robots_of(names), ReadOptions(**options)).identity

    first = identity()
    assert identity() == first
    assert identity(resample=0.01) != first
    beside = tmp_path / "a.csv.toml"
    beside.write_text("x = 1")
    second = identity()
    log.write_text("time_s\n")
    assert len({str(known) for known in (first, second, identity())}) == 3


def test_data_is_named_for_any_working_folder(model, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.csv").write_text("time\n")
    task = fleet(model, robots_of(["./a.csv[1:5]"]))
    assert task.robots == (Robot("a", (f"{tmp_path / 'a.csv'}[1:5]",)),)


def test_effects_of_the_users_own_travel_as_candidates(model, monkeypatch):
    monkeypatch.setattr(effects, "BY_ID", Registry(CATALOGUE))
    robots = [Robot("a", ("a.csv",))]
    before = fleet(model, robots)
    effects.load(RIPPLE)
    after = fleet(model, robots)
    assert before.model.own_effects == ()
    assert after.model.own_effects == (("tooth_ripple.py", RIPPLE.read_bytes()),)
    assert after.identity["effects"] != before.identity["effects"]


# ---- robots ------------------------------------------------------------------------------------


def test_files_and_folders_are_robots(tmp_path):
    folder = tmp_path / "arm 7"
    folder.mkdir()
    for name in ("b.CSV", "a.parquet", "notes.md", "a.csv.toml", ".hidden.csv"):
        (folder / name).write_text("x")
    bag = tmp_path / "bag"
    bag.mkdir()
    (bag / "metadata.yaml").write_text("x")
    (bag / "bag.db3").write_text("x")
    log = tmp_path / "log.csv"
    log.write_text("x")
    assert robots_of([str(folder), str(bag), f"{log}[1:5]"]) == (
        Robot("arm 7", (str(folder / "a.parquet"), str(folder / "b.CSV"))),
        Robot("bag", (str(bag),)),
        Robot("log", (f"{log}[1:5]",)),
    )


def test_two_robots_of_one_name_are_refused(tmp_path):
    for folder in ("one", "two"):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "log.csv").write_text("x")
    names = [str(tmp_path / folder / "log.csv") for folder in ("one", "two")]
    with pytest.raises(MeasurementError, match="two robots are called log; rename"):
        robots_of(names)


def test_nothing_to_diagnose_is_refused(model, tmp_path):
    with pytest.raises(MeasurementError, match="no recordings are in this folder"):
        robots_of([str(tmp_path)])
    with pytest.raises(MeasurementError, match="there is no such file or folder"):
        robots_of([str(tmp_path / "none.csv")])
    with pytest.raises(MeasurementError, match="a fleet has no robots"):
        fleet(model, ())


# ---- words -------------------------------------------------------------------------------------


def diagnosis(**changes):
    """As much of a diagnosis as a row takes."""
    whole = {
        "verdict": "missing_effect",
        "added": ("coulomb_friction",),
        "indistinguishable": (("coulomb_friction", "lugre_friction", "stribeck_friction"),),
        "model": load_model("biorob_x4_joint_3").with_effect("coulomb_friction", {"torque": 0.3}),
        "learned": None,
    }
    return SimpleNamespace(**whole | changes)


def test_what_cannot_be_told_apart_is_named():
    assert list(subject._appearances(diagnosis())) == [
        "coulomb_friction: indistinguishable from lugre_friction and stribeck_friction"
    ]


def test_parts_of_a_large_fleet_hold_many_robots(model):
    robots = [Robot(f"{number}", ("a.csv",)) for number in range(30_000)]
    assert fleet(model, robots[:100]).batch() == 1
    assert fleet(model, robots).batch() == 20


def test_a_name_that_is_no_text_is_refused():
    with pytest.raises(MeasurementError, match=r"rob\\udcff.csv': this name is no text; rename"):
        robots_of(["rob\udcff.csv"])


def test_what_no_effect_explains_is_told():
    learned = SimpleNamespace(variables=("joint_position", "joint_velocity"))
    unknown = diagnosis(verdict="unexplained", added=(), learned=learned)
    (text,) = subject._appearances(unknown)
    assert text.endswith("which depends on joint_position, joint_velocity")
    assert named(text) == ("unknown",)


def test_all_signals_have_columns_of_their_own():
    columns = [name for signal in SIGNALS for name in error_columns(signal).values()]
    assert len(set(columns)) == 4 * len(SIGNALS)
    assert np.all([name.startswith(SIGNALS) for name in columns])
