"""Runs, gaps, rates and static curves: which recordings a file becomes."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pandas as pd
import pytest

from elastic_tendon.errors import MeasurementError
from elastic_tendon.measurement import (
    Preparation,
    ReadOptions,
    read_measurement,
    read_measurements,
    read_prepared,
    rows,
)
from elastic_tendon.measurement.assembly import STATIC_STEP
from written_tables import assert_same_samples, mapped, runs_with_gaps, saved, signal, table


def test_runs_that_are_too_short_are_left_out_with_a_note(tmp_path: Path) -> None:
    data = saved(tmp_path, pd.concat([runs_with_gaps(), runs_with_gaps().head(4).assign(run=3)]))
    found = read_measurements(data)
    assert {recording.name.partition("[")[0] for recording in found} == {"run.csv#1", "run.csv#2"}
    note = "1 runs with less than 10 samples were left out: 3"
    assert all(note in recording.notes for recording in found)
    (late,) = read_measurements(f"{data}[2.1:2.4]")
    assert late.name == "run.csv#2[2.1:2.4]"
    assert "2 runs with less than 10 samples in the window were left out: 1, 3" in late.notes
    with pytest.raises(MeasurementError, match=r"#1\[7:8\]: the window holds 0 samples"):
        read_measurements(f"{data}[7:8]")


def test_one_recording_is_wanted_where_there_are_several(tmp_path: Path) -> None:
    data = saved(tmp_path, runs_with_gaps())
    with pytest.raises(MeasurementError, match=r"holds 3 recordings \(run.csv#1, run.csv#2"):
        read_measurement(data)


def test_runs_are_told_apart_by_number_or_text(tmp_path: Path) -> None:
    time = 0.01 * np.arange(30)
    frame = pd.concat([table(time), table(time)])
    frame["run"] = ["slow"] * 30 + ["fast"] * 30
    data = saved(tmp_path, frame)
    assert [recording.name for recording in read_measurements(data)] == [
        "run.csv#slow",
        "run.csv#fast",
    ]
    (fast,) = read_measurements(data, Preparation(runs=("fast",)))
    assert fast.preparation.runs == ("fast",)
    with pytest.raises(MeasurementError, match=r"no run 'idle' \(found: slow, fast\)"):
        read_measurements(data, Preparation(runs=("idle",)))


def test_run_asked_for_where_there_are_none(tmp_path: Path) -> None:
    data = saved(tmp_path, table(0.01 * np.arange(30)))
    with pytest.raises(MeasurementError, match=r"no run 3 \(no column is named run"):
        read_measurements(data, Preparation(runs=(3,)))


def test_row_without_run_is_refused(tmp_path: Path) -> None:
    frame = runs_with_gaps()
    frame.iloc[7, frame.columns.get_loc("run")] = np.nan
    with pytest.raises(MeasurementError, match="column run, row 9 is blank"):
        read_measurements(saved(tmp_path, frame))


def test_gap_splits_and_short_pieces_are_left_out(tmp_path: Path) -> None:
    time = 0.01 * np.arange(100)
    time[40:] += 1.0
    time[45:] += 1.0
    found = read_measurements(saved(tmp_path, table(time)))
    assert [len(recording.time) for recording in found] == [40, 55]
    assert any("was split into 3 pieces" in note for note in found[0].notes)
    note = "1 pieces with less than 10 samples of every signal were left out, 5 samples over 0.04 s"
    assert note in found[0].notes


def test_jitter_is_used_as_it_stands(tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    time = 0.01 * np.arange(300) + rng.uniform(-0.004, 0.004, 300)
    (found,) = read_measurements(saved(tmp_path, table(time)))
    assert np.array_equal(found.time, time)
    assert any(note.startswith("sampled unevenly, every ") for note in found.notes)


@pytest.mark.parametrize("to_stamps", [np.round, np.floor])
def test_rounded_time_stamps_are_taken_as_even(
    tmp_path: Path, to_stamps: Callable[[Any], Any]
) -> None:
    time = np.arange(600) / 120.0
    (found,) = read_measurements(saved(tmp_path, table(to_stamps(1e3 * time) / 1e3)))
    assert np.ptp(np.diff(found.time)) < 1e-9
    assert np.abs(np.diff(found.time) - 1.0 / 120.0).max() < 1e-5
    assert any("time stamps are rounded; taken as every 8.33" in note for note in found.notes)


def test_steps_of_two_lengths_that_wander_are_used_as_they_stand(tmp_path: Path) -> None:
    time = np.cumsum(np.random.default_rng(1).choice([0.008, 0.009], 600))
    (found,) = read_measurements(saved(tmp_path, table(time)))
    assert np.array_equal(found.time, time)


def test_repeated_rows_are_dropped_with_a_note(tmp_path: Path) -> None:
    frame = table(0.01 * np.arange(50))
    doubled = pd.concat([frame.iloc[:20], frame.iloc[19:30], frame.iloc[29:]])
    (found,) = read_measurements(saved(tmp_path, doubled))
    assert np.array_equal(found.time, frame["time_s"])
    assert "2 rows that repeat the row before were dropped" in found.notes


def test_times_since_1970_keep_their_precision(tmp_path: Path) -> None:
    time = 1.7e9 + 0.001 * np.arange(100)
    (found,) = read_measurements(saved(tmp_path, table(time)))
    assert np.array_equal(found.time, time)
    assert found.notes == ()


def test_resampling_averages_what_is_finer(tmp_path: Path) -> None:
    rng = np.random.default_rng(2)
    time = 0.001 * np.arange(20_000)
    frame = table(time)
    noise = 1e-2 * rng.standard_normal(len(time))
    frame["joint_position_rad"] += noise
    (found,) = read_measurements(saved(tmp_path, frame), Preparation(resample=0.01))
    assert np.diff(found.time) == pytest.approx(0.01)
    error = found.signals["joint_position"] - signal(found.time)[1]
    # ten samples in each mean, and a little curvature within it
    assert np.std(error) == pytest.approx(1e-2 / np.sqrt(10.0), rel=0.15)
    assert "resampled to steps of 10 ms" in found.notes


def test_resampling_bridges_blanks_which_else_are_refused(tmp_path: Path) -> None:
    frame = table(0.01 * np.arange(200))
    frame.loc[[50, 51, 120], "joint_position_rad"] = np.nan
    data = saved(tmp_path, frame)
    with pytest.raises(MeasurementError, match=r"rad, row 52 holds no number; .*--resample STEP"):
        read_measurements(data)
    (found,) = read_measurements(data, Preparation(resample=0.01))
    assert len(found.time) == 200
    assert found.signals["joint_position"] == pytest.approx(signal(found.time)[1], abs=3e-2)
    assert found.motor_position == pytest.approx(signal(found.time)[0], abs=1e-9)


def test_resampling_does_not_bridge_a_gap(tmp_path: Path) -> None:
    frame = table(0.01 * np.arange(200))
    frame.loc[50:100, "joint_position_rad"] = np.nan
    found = read_measurements(saved(tmp_path, frame), Preparation(resample=0.01))
    assert [recording.time[-1] for recording in found] == pytest.approx([0.49, 1.99])
    assert any(note.startswith("the recording has gaps or long blanks") for note in found[0].notes)


@pytest.fixture
def two_rates(tmp_path: Path) -> str:
    """Motor at 1 kHz, joint at 100 Hz, load at 20 Hz, each in a group of its own."""
    fast, middle, slow = 0.001 * np.arange(3000), 0.0005 + 0.01 * np.arange(290), np.arange(61) / 20
    path = tmp_path / "rates.h5"
    with h5py.File(path, "w") as file:
        for group, time, name, values in (
            ("motor", fast, "motor_position_rad", signal(fast)[0]),
            ("joint", middle, "joint_position_rad", signal(middle)[1]),
            ("load", slow, "load_torque_Nm", 0.2 * slow),
        ):
            file[f"{group}/time_s"] = time
            file[f"{group}/{name}"] = values
    return str(path)


def test_rates_are_brought_to_the_clock_of_the_joint(two_rates: str) -> None:
    (found,) = read_measurements(two_rates)
    assert found.time == pytest.approx(0.0005 + 0.01 * np.arange(290))
    assert np.array_equal(found.signals["joint_position"], signal(found.time)[1])
    assert found.motor_position == pytest.approx(signal(found.time)[0], abs=1e-3)
    assert found.load_torque == pytest.approx(0.2 * found.time, abs=1e-12)
    assert any(
        note.startswith("motor_position, sampled every 1 ms, was av") for note in found.notes
    )
    assert any(note.startswith("load_torque, sampled every 50 ms, was int") for note in found.notes)


@pytest.mark.parametrize("resample", [None, 0.013])
@pytest.mark.parametrize("window", [None, (0.5, 2.2)])
def test_rates_replay(
    two_rates: str, resample: float | None, window: tuple[float, float] | None
) -> None:
    (found,) = read_measurements(two_rates, Preparation(resample=resample, window=window))
    (again,) = read_measurements(two_rates, found.preparation)
    assert_same_samples(again, found)


def test_groups_without_common_time_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "apart.h5"
    with h5py.File(path, "w") as file:
        for group, name, start in (("a", "motor_position_rad", 0), ("b", "joint_position_rad", 50)):
            file[f"{group}/time_s"] = start + 0.01 * np.arange(100)
            file[f"{group}/{name}"] = np.arange(100.0)
    with pytest.raises(MeasurementError, match="no stretch without gaps holds 10 samples of every"):
        read_measurements(str(path))


def test_static_curve_is_a_slow_sweep_of_the_load(tmp_path: Path) -> None:
    deflection = np.concatenate([np.linspace(-0.3, 0.3, 20), np.linspace(0.3, -0.3, 20)])
    frame = pd.DataFrame(
        {"joint_deflection_deg": np.degrees(deflection), "joint_torque_Nm": -16.0 * deflection}
    )
    data = saved(tmp_path, frame, "curve.csv")
    (found,) = read_measurements(data)
    assert found.static
    assert found.signals["joint_position"] == pytest.approx(deflection)
    assert found.load_torque == pytest.approx(16.0 * deflection)
    assert not np.any(found.motor_position)
    assert np.array_equal(found.time, STATIC_STEP * np.arange(40))
    (again,) = read_measurements(data, found.preparation)
    assert_same_samples(again, found)


@pytest.mark.parametrize(
    ("window", "preparation", "fragment"),
    [
        ("[0:1]", Preparation(), "read it without a window"),
        ("", Preparation(resample=0.1), "read it without --resample"),
        ("", Preparation(time_shift={"joint_position": 0.1}), "read it without --shift"),
    ],
)
def test_static_curve_has_no_time(
    tmp_path: Path, window: str, preparation: Preparation, fragment: str
) -> None:
    values = np.arange(20.0)
    frame = pd.DataFrame({"joint_deflection_rad": values, "joint_torque_Nm": values})
    with pytest.raises(MeasurementError, match=f"a static curve, it has no time; {fragment}"):
        read_measurements(saved(tmp_path, frame) + window, preparation)


def test_offset_at_the_start_needs_a_time(tmp_path: Path) -> None:
    values = np.arange(20.0)
    frame = pd.DataFrame({"joint_deflection_rad": values, "joint_torque_Nm": values})
    with pytest.raises(MeasurementError, match="read it without --remove-offset"):
        read_prepared(saved(tmp_path, frame), ReadOptions(remove_offset=("joint_deflection",)))


def test_mapping_meant_for_a_time_series_is_noted_at_a_static_curve(tmp_path: Path) -> None:
    values = np.arange(20.0)
    frame = pd.DataFrame({"joint_deflection_rad": values, "joint_torque_Nm": values})
    (found,) = read_prepared(saved(tmp_path, frame), mapped("joint_position=enc"))
    note = "said of columns and not used, as this is a static curve: joint_position"
    assert note in found.notes


def test_step_too_short_for_the_memory(tmp_path: Path) -> None:
    data = saved(tmp_path, table(0.01 * np.arange(50)))
    with pytest.raises(MeasurementError, match="resampled to 1e-09 s it has more than 12000000"):
        read_prepared(data, ReadOptions(resample=1e-9))


def test_more_samples_than_the_memory_is_meant_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(rows, "MAXIMUM_SAMPLES", 1000)
    data = saved(tmp_path, table(0.001 * np.arange(5000)))
    with pytest.raises(
        MeasurementError,
        match=r"more than 1000 samples; read a part of it with run.csv\[start:end\] in s, or aver",
    ):
        read_measurements(data)
    assert len(read_measurements(data + "[0:0.5]")[0].time) == 501
    assert len(read_measurements(data, Preparation(resample=0.01))[0].time) == 499


def test_coarse_times_are_averaged_by_resampling(tmp_path: Path) -> None:
    fine = 0.001 * np.arange(3000)
    frame = table(fine).assign(time_s=0.01 * (np.arange(3000) // 10))
    data = saved(tmp_path, frame)
    with pytest.raises(MeasurementError, match="or average with --resample STEP"):
        read_measurements(data)
    (found,) = read_measurements(data, Preparation(resample=0.01))
    assert found.signals["joint_position"] == pytest.approx(
        frame["joint_position_rad"].to_numpy().reshape(-1, 10).mean(axis=1), abs=1e-9
    )


def test_labels_of_runs_are_one_where_their_numbers_are(tmp_path: Path) -> None:
    frame = table(0.01 * np.arange(60))
    frame["run"] = ["1.0", "1"] * 15 + ["01"] * 30
    frame.loc[59, "run"] = "end"
    found = read_measurements(saved(tmp_path, frame))
    assert [(recording.name, len(recording.time)) for recording in found] == [
        ("run.csv#1", 30),
        ("run.csv#01", 29),
    ]
