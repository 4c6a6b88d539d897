"""Simulations as a task: numbers as of one `simulate` each, whatever the batch; failures told."""

import pickle
import tracemalloc
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from elastic_tendon import load_model, simulate, sweep
from elastic_tendon.comparison.simulated import measured_table
from elastic_tendon.errors import SimulationError, SweepError
from elastic_tendon.measurement import Measurement
from elastic_tendon.simulation.excitation import default_excitation
from elastic_tendon.sweeps import simulations as module
from elastic_tendon.sweeps.factors import Factor, Uniform, Values, parse_factor
from elastic_tendon.sweeps.points import points
from elastic_tendon.sweeps.simulations import (
    Motion,
    default_motion,
    measured_motion,
    simulations,
)
from elastic_tendon.sweeps.summary import summarise

OUTPUTS = ("joint_position", "joint_torque", "slack_state", "overstretched")
UNITS = {"joint_position": "rad", "joint_torque": "Nm"}
VARIED = ("link.damping=0.05:0.5", "transmission.pretension_force=5:60")
PRETENSION = "transmission.pretension_force"


@pytest.fixture(scope="module")
def model():
    return load_model("figure_7")


@pytest.fixture(scope="module")
def motion(model):
    excitation = default_excitation(model)
    half = slice(0, 1001)
    return Motion(
        excitation.time[half], excitation.motor_position[half], excitation.load_torque[half]
    )


def _drawn(model, count, *texts):
    return points([parse_factor(model, text) for text in texts or VARIED], "monte-carlo", count)


def _one_by_one(model, motion, points):
    for values in points.rows(0, points.count):
        paths = [factor.path for factor in points.factors]
        changed = model.with_values(dict(zip(paths, values, strict=True)))
        yield simulate(
            changed,
            motion.time,
            motion.motor_position,
            motion.load_torque,
            initial_state=dict(motion.initial_state),
            interpolation=motion.interpolation,
            as_measured=True,
        )


def test_statistics_are_those_of_one_simulation_each(model, motion):
    drawn = _drawn(model, 12)
    table = simulations(model, drawn, motion=motion, outputs=OUTPUTS).rows(0, 12)
    for row, trajectory in zip(table.itertuples(), _one_by_one(model, motion, drawn), strict=True):
        found = table.loc[row.Index]
        for name, unit in UNITS.items():
            values = trajectory[name]
            expected = {
                "minimum": min(values),
                "maximum": max(values),
                "mean": sum(values) / len(values),
                "rms": np.linalg.norm(values) / np.sqrt(len(values)),
                "final": values[-1],
            }
            for statistic, number in expected.items():
                assert found[f"{name}.{statistic}_{unit}"] == pytest.approx(number, rel=1e-12)
        states = trajectory["slack_state"].tolist()
        for number, state in enumerate(("I", "II", "III", "both"), start=1):
            share = states.count(float(number)) / len(states)
            assert found[f"slack_state.share_{state}"] == pytest.approx(share, abs=1e-12)
        assert found["overstretched.share"] == trajectory["overstretched"].mean()
    assert table["slack_state.share_II"].between(0.01, 0.9).any()
    assert (table["failure"] == "").all()


def test_a_run_is_the_same_bit_for_bit_in_any_batch(model, motion, monkeypatch):
    task = simulations(model, _drawn(model, 40), motion=motion, outputs=OUTPUTS)
    whole = task.rows(0, 40)
    parts = [task.rows(0, 1), task.rows(1, 17), task.rows(17, 40)]
    pd.testing.assert_frame_equal(pd.concat(parts, ignore_index=True), whole, check_exact=True)
    monkeypatch.setattr(module, "MEMORY", 100_000)  # bytes; some runs at once
    pd.testing.assert_frame_equal(task.rows(0, 40), whole, check_exact=True)
    travelled = pickle.loads(pickle.dumps(task))
    pd.testing.assert_frame_equal(travelled.rows(3, 9), task.rows(3, 9), check_exact=True)
    assert travelled.identity == task.identity


def test_trajectories_have_a_row_each_sample(model, motion):
    drawn = _drawn(model, 5)
    task = simulations(model, drawn, motion=motion, outputs=OUTPUTS, keep="trajectories")
    table = task.rows(0, 5)
    samples = len(motion.time)
    assert table["run"].tolist() == np.repeat(np.arange(5), samples).tolist()
    for run, trajectory in enumerate(_one_by_one(model, motion, drawn)):
        rows = table[table["run"] == run]
        assert (rows["link.damping"] == drawn.rows(run, run + 1)[0, 0]).all()
        np.testing.assert_array_equal(rows["time_s"], motion.time)
        np.testing.assert_allclose(rows["joint_torque_Nm"], trajectory["joint_torque"], rtol=1e-12)
        np.testing.assert_array_equal(rows["slack_state"], trajectory["slack_state"])


@pytest.mark.parametrize("keep", ["statistics", "trajectories"])
def test_runs_that_fail_are_told_beside_those_that_do_not(model, motion, keep):
    """A pretension that the springs cannot bear is within its bounds, but no model."""
    limit = model.transmission.largest_pretension
    varied = [
        Factor(PRETENSION, Values((30.0, 2.0 * limit))),
        Factor("link.damping", Values((0.16, 0.2))),
    ]
    task = simulations(model, points(varied, "grid"), motion=motion, keep=keep)
    table = task.rows(0, 4)
    first = table.drop_duplicates("run").set_index("run")
    results = first.columns[2:-1]
    for run in range(4):
        failed = run >= 2
        assert (first.loc[run, "failure"] != "") == failed
        assert first.loc[run, results].isna().all() == failed
        assert (table["run"] == run).sum() == (1 if failed or keep == "statistics" else 1001)
    assert f"{2.0 * limit:g} N is above" in first.loc[2, "failure"]
    pd.testing.assert_frame_equal(task.rows(2, 3), task.failed(2, first.loc[2, "failure"]))
    assert (task.rows(0, 1).dtypes == task.failed(3, "lost").dtypes).all()
    assert task.failed(3, "lost")["failure"].tolist() == ["lost"]


def test_a_run_that_the_solver_gives_up_has_its_reason(model, motion):
    """The load is too much: no step is small enough."""
    wild = Motion(motion.time, motion.motor_position, np.full_like(motion.time, 1e300))
    drawn = points([Factor("link.damping", Values((0.1, 0.2)))], "grid")
    with pytest.raises(SimulationError) as stopped:
        list(_one_by_one(model, wild, drawn))
    table = simulations(model, drawn, motion=wild).rows(0, 2)
    assert str(stopped.value).endswith(table["failure"][0])
    assert table["failure"].str.startswith("stopped at").all()
    assert table["joint_position.rms_rad"].isna().all()


@pytest.fixture(scope="module")
def recording(model, motion):
    true = model.with_values({"link.damping": 0.3})
    moved = Measurement(motion.time, motion.motor_position, {}, motion.load_torque, name="bench")
    position = measured_table(true, moved)["joint_position_rad"].to_numpy()
    noisy = position + 1e-4 * np.random.default_rng(5).standard_normal(len(position))
    signals = {"joint_position": noisy}
    return Measurement(
        motion.time, motion.motor_position, signals, motion.load_torque, name="bench"
    )


def test_recording_gives_motion_initial_state_and_error(model, recording):
    motion = measured_motion(model, recording)
    drawn = points([parse_factor(model, "link.damping=0.1,0.2,0.3,0.4")], "grid")
    table = simulations(model, drawn, motion=motion).rows(0, 4)
    errors = table["joint_position.rms_error_rad"]
    for error, trajectory in zip(errors, _one_by_one(model, motion, drawn), strict=True):
        apart = trajectory["joint_position"] - recording.signals["joint_position"]
        assert error == pytest.approx(np.sqrt(np.mean(apart**2)), rel=1e-12)
    assert errors.idxmin() == 2
    assert errors.min() < 3e-4
    assert "joint_torque.rms_error_Nm" not in table


def test_error_is_that_of_what_the_sensor_reads(model, recording):
    shifted = model.with_effect("joint_encoder_offset", {"offset": 0.01})
    motion = measured_motion(shifted, recording)
    drawn = points([parse_factor(shifted, "effects.joint_encoder_offset.offset=0.01,0.02")], "grid")
    table = simulations(shifted, drawn, motion=motion, outputs=("joint_position",)).rows(0, 2)
    for error, trajectory in zip(
        table["joint_position.rms_error_rad"], _one_by_one(shifted, motion, drawn), strict=True
    ):
        apart = trajectory["measured_joint_position"] - recording.signals["joint_position"]
        assert error == pytest.approx(np.sqrt(np.mean(apart**2)), rel=1e-12)
    assert not any("measured" in name for name in table.columns)


def test_batch_is_bounded_by_time_runs_and_memory(model, motion):
    task = simulations(model, _drawn(model, 1_000_000), motion=motion)
    assert 1 <= task.batch() <= module.MOST_RUNS
    assert simulations(model, _drawn(model, 3), motion=motion).batch() <= 3
    long = simulations(model, _drawn(model, 1_000_000), motion=motion, keep="trajectories")
    count = long.batch()
    assert 1 <= count < module.MOST_RUNS
    assert count / 10 * len(long.rows(0, 10).to_csv()) < 1.2 * module.PART


def test_memory_does_not_grow_with_the_runs_of_a_batch(model, motion, monkeypatch):
    """Of statistics: but for the table, which has some hundred bytes a run."""
    monkeypatch.setattr(module, "MEMORY", 4_000_000)
    task = simulations(model, _drawn(model, 600), motion=motion)
    task.rows(0, 2)
    peaks = []
    for count in (300, 600):
        tracemalloc.start()
        task.rows(0, count)
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert peaks[1] < 1.1 * peaks[0] + 3e5
    assert peaks[1] < 4 * module.MEMORY


@pytest.mark.parametrize("keep", ["statistics", "trajectories"])
def test_swept_table_is_the_same_whatever_the_workers_and_summed_up(model, motion, tmp_path, keep):
    limit = model.transmission.largest_pretension
    drawn = _drawn(model, 30, "link.damping=0.05:0.5", f"{PRETENSION}=5:{1.5 * limit}")
    task = simulations(model, drawn, motion=motion, keep=keep)
    paths = [
        sweep(task, tmp_path / f"{workers}.csv", workers=workers, batch=batch).path
        for workers, batch in ((1, 30), (2, 7))
    ]
    assert paths[0].read_bytes() == paths[1].read_bytes()
    expected = task.rows(0, 30)
    pd.testing.assert_frame_equal(
        pd.read_csv(paths[0]).fillna({"failure": ""}), expected, rtol=1e-14, check_dtype=False
    )
    found = summarise(paths[0])
    failed = int((expected["failure"] != "").sum())
    assert 0 < failed < 30
    assert (found.runs, found.failed, found.reasons[0].count) == (30, failed, failed)


def test_identity_tells_sweeps_apart(model, motion):
    drawn = _drawn(model, 10)
    moved = Motion(motion.time, motion.motor_position + 1e-12, motion.load_torque)
    base = simulations(model, drawn, motion=motion)
    others = [
        simulations(model.with_values({"link.inertia": 0.04}), drawn, motion=motion),
        simulations(model, replace(drawn, seed=1), motion=motion),
        simulations(model, _drawn(model, 10, *VARIED[:1]), motion=motion),
        simulations(model, drawn, motion=moved),
        simulations(model, drawn),
        simulations(model, drawn, motion=motion, outputs=("joint_position",)),
        simulations(model, drawn, motion=motion, keep="trajectories"),
        simulations(model, drawn, motion=motion, tolerance=1e-6),
    ]
    assert not any(changed.identity == base.identity for changed in others)
    for count in (10, 11):  # more runs go on where fewer ended
        assert base.identity == simulations(model, _drawn(model, count), motion=motion).identity
    assert base.threads
    assert base.runs == 10


def test_default_motion_is_the_default_excitation(model):
    excitation = default_excitation(model)
    np.testing.assert_array_equal(default_motion(model).load_torque, excitation.load_torque)
    drawn = points([Factor("link.damping", Uniform(0.1, 0.2))], "sobol", 1)
    assert simulations(model, drawn).motion.fingerprint == default_motion(model).fingerprint


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"outputs": ("joint_positon",)}, "did you mean joint_position?"),
        ({"outputs": ()}, "choose some of joint_torque"),
        ({"keep": "all"}, "choose one of statistics, trajectories"),
        ({"tolerance": 0.5}, "outside 1e-14 to 0.01"),
    ],
)
def test_what_cannot_be_simulated_is_told_in_one_sentence(model, options, said):
    with pytest.raises(SweepError) as refused:
        simulations(model, _drawn(model, 2), **options)
    assert said in str(refused.value)


def test_a_motion_has_to_drive_the_model_at_its_interface(model):
    motion = default_motion(model)
    rotor = load_model(model.model_dump() | {"motor": {"inertia": 0.01}}).at("torque")
    drawn = points([Factor("transmission.pretension_force", Uniform(50.0, 60.0))], "sobol", 1)
    words = "interface torque, which motor_torque and load_torque drive; the motion has motor_posit"
    with pytest.raises(SweepError, match=words):
        simulations(rotor, drawn, motion=motion)
    assert set(default_motion(rotor).inputs) == {"motor_torque", "load_torque"}
    assert set(default_motion(model.at("joint")).inputs) == {"motor_position", "joint_position"}
