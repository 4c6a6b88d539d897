"""Recordings are read as they stand in the file; bad ones are refused in one sentence."""

import json
import re
import tomllib
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pandas as pd
import pytest
import tomli_w

from elastic_tendon.errors import MeasurementError
from elastic_tendon.measurement import (
    Measurement,
    Preparation,
    ReadOptions,
    read_measurement,
    read_measurements,
    read_prepared,
    rows,
)
from elastic_tendon.measurement.assembly import STATIC_STEP
from elastic_tendon.measurement.preparation import COMPARISON, check_preparation, preparation_json
from elastic_tendon.measurement.recording import Array

HEADER = "time_s,motor_position_rad,joint_position_rad"
ROWS = [f"{0.01 * i:.2f},{0.1 * i:.1f},{0.2 * i:.1f}" for i in range(12)]


def mapped(*mapping: str) -> ReadOptions:
    return ReadOptions(mapping=mapping)


@pytest.fixture
def write(tmp_path: Path):
    def write(*lines: str, name: str = "run.csv") -> str:
        path = tmp_path / name
        path.write_text("\n".join(lines) + "\n")
        return str(path)

    return write


def test_contract_columns_are_read_in_si(write) -> None:
    rows = [f"{row},{i},5" for i, row in enumerate(ROWS)]
    run = read_measurement(write(f"{HEADER},load_torque_Nm,joint_torque_Nm", *rows))
    assert run.name == "run.csv"
    assert run.time[[0, -1]].tolist() == [0.0, 0.11]
    assert run.motor_position[-1] == pytest.approx(1.1)
    assert set(run.signals) == {"joint_position", "joint_torque"}
    assert run.load_torque is not None
    assert run.load_torque[-1] == 11.0
    assert run.notes == ()


def test_missing_load_means_none_acts_and_extra_columns_are_noted(write) -> None:
    run = read_measurement(write(f"{HEADER},colour", *[f"{row},red" for row in ROWS]))
    assert run.load_torque is None
    assert run.notes == ("not used: colour",)


def test_time_starts_where_the_file_says(write) -> None:
    rows = [f"{5 + 0.01 * i:.2f},0,0" for i in range(12)]
    assert read_measurement(write(HEADER, *rows)).time[0] == 5.0


def test_units_by_suffix(write) -> None:
    rows = [f"{i},{i},{180 * i},{i}" for i in range(12)]
    header = "time_ms,motor_position_mrad,joint_position_deg,load_torque_mNm"
    run = read_measurement(write(header, *rows))
    assert run.time[2] == pytest.approx(0.002)
    assert run.motor_position[2] == pytest.approx(0.002)
    assert run.signals["joint_position"][2] == pytest.approx(2 * np.pi)
    assert run.load_torque is not None
    assert run.load_torque[2] == pytest.approx(0.002)


def test_map_takes_sign_scale_and_offset(write) -> None:
    lines = [HEADER.replace("joint_position_rad", "enc 2"), *ROWS]
    run = read_measurement(write(*lines), mapped("joint_position=enc 2*-2+1"))
    assert run.signals["joint_position"][1] == pytest.approx(1.0 - 2.0 * 0.2)


@pytest.mark.parametrize(
    ("window", "first", "last"),
    [("[0.01:0.1]", 0.01, 0.1), ("[0.01:]", 0.01, 0.11), ("[:0.1]", 0.0, 0.1)],
)
def test_window(write, window: str, first: float, last: float) -> None:
    run = read_measurement(write(HEADER, *ROWS) + window)
    assert run.time[[0, -1]].tolist() == [first, last]
    assert run.name == f"run.csv{window}"
    assert len(run.signals["joint_position"]) == len(run.motor_position) == len(run.time)


BAD_FILES = {
    "empty": ([], "the file is empty; it needs a header"),
    "header only": ([HEADER], "it holds a header and no samples"),
    "too short": ([HEADER, *ROWS[:4]], "it holds 4 samples"),
    "missing column": (
        ["time_s,theta,q", *ROWS],
        r"there is no column motor_position_rad \(found: time_s, theta, q\); name the right one "
        "with --map motor_position=COLUMN",
    ),
    "semicolons": (
        [line.replace(",", ";") for line in (HEADER, *ROWS)],
        "separated by semicolons; save it with commas",
    ),
    "text": (
        [HEADER, *ROWS[:3], "0.03,oops,1", *ROWS[4:]],
        "column motor_position_rad, row 5 holds 'oops'; every sample needs a finite number",
    ),
    "gap": ([HEADER, *ROWS[:3], "0.03,1,", *ROWS[4:]], "joint_position_rad, row 5 holds no number"),
    "blank line": ([HEADER, *ROWS[:3], "", *ROWS[3:]], "time_s, row 5 holds no number"),
    "infinite": ([HEADER, *ROWS[:3], "0.03,1,inf", *ROWS[4:]], "row 5 holds 'inf'"),
    "repeated time": (
        [HEADER, *ROWS[:3], "0.02,7,7", *ROWS[3:]],
        r"the time does not increase at row 5 \(0.02 s again, with another motor_position_rad\)",
    ),
    "ragged": ([HEADER, *ROWS[:3], "1.5,2.5,3.5,4.5", *ROWS[4:]], "row 5"),
    "twice": (
        [f"{HEADER},joint_position_deg", *[f"{row},1" for row in ROWS]],
        "joint_position comes twice, as joint_position_rad and joint_position_deg",
    ),
}


@pytest.mark.parametrize("case", BAD_FILES)
def test_bad_file_is_refused_in_one_sentence(write, case: str) -> None:
    lines, fragment = BAD_FILES[case]
    path = write(*lines)
    if not lines:
        Path(path).write_text("")
    with pytest.raises(MeasurementError, match=fragment) as refused:
        read_measurement(path)
    message = str(refused.value)
    assert message.startswith("run.csv: ")
    assert "\n" not in message


def test_missing_file_folder_and_binary(tmp_path: Path) -> None:
    with pytest.raises(MeasurementError, match="there is no such file"):
        read_measurement(str(tmp_path / "none.csv"))
    with pytest.raises(MeasurementError, match="this is a folder"):
        read_measurement(str(tmp_path))
    binary = tmp_path / "binary.csv"
    binary.write_bytes(bytes(range(256)) * 8)
    with pytest.raises(MeasurementError, match=r"binary\.csv: "):
        read_measurement(str(binary))


@pytest.mark.parametrize(
    ("window", "fragment"),
    [
        ("[5:6]", "the window holds 0 samples and needs 10; the recording runs from 0 s to 0.11 s"),
        ("[a:b]", r"the window \[a:b\] must be two numbers in s"),
    ],
)
def test_bad_window(write, window: str, fragment: str) -> None:
    with pytest.raises(MeasurementError, match=fragment):
        read_measurement(write(HEADER, *ROWS) + window)


def test_mapped_column_must_exist(write) -> None:
    with pytest.raises(MeasurementError, match="there is no column enc"):
        read_measurement(write(HEADER, *ROWS), mapped("joint_position=enc"))


def test_trailing_blank_lines_are_no_samples(write) -> None:
    assert len(read_measurement(write(HEADER, *ROWS, "", "")).time) == len(ROWS)


def signal(time: Array) -> tuple[Array, Array]:
    """Motor and joint position, rad, that differ at all times."""
    return np.sin(3.0 * time), np.sin(3.0 * time + 0.1) + 0.01 * np.sin(71.0 * time)


def table(time: Array, **columns: Array) -> pd.DataFrame:
    """Contract's table over some times."""
    motor, joint = signal(time)
    data = {"time_s": time, "motor_position_rad": motor, "joint_position_rad": joint}
    return pd.DataFrame(data | columns)


def saved(folder: Path, frame: pd.DataFrame, name: str = "run.csv") -> str:
    """Path of the table as CSV."""
    path = folder / name
    frame.to_csv(path, index=False)
    return str(path)


def assert_same_samples(first: Measurement, second: Measurement) -> None:
    """Bit for bit, in every array."""
    assert np.array_equal(first.time, second.time)
    assert np.array_equal(first.motor_position, second.motor_position)
    assert first.signals.keys() == second.signals.keys()
    assert all(np.array_equal(first.signals[name], second.signals[name]) for name in first.signals)
    assert (first.load_torque is None) == (second.load_torque is None)
    if first.load_torque is not None and second.load_torque is not None:
        assert np.array_equal(first.load_torque, second.load_torque)
    assert first.static == second.static
    assert first.preparation == second.preparation


def written_comparison(path: Path, measurements: Sequence[Measurement]) -> str:
    """Path of the JSON of a comparison, as far as it says how files were read."""
    files = [
        {
            "name": recording.name,
            "source": recording.source,
            "preparation": preparation_json(recording.preparation),
        }
        for recording in measurements
    ]
    path.write_text(json.dumps({"schema": COMPARISON, "files": files}))
    return str(path)


def runs_with_gaps(step: float = 0.01) -> pd.DataFrame:
    """Two runs whose time begins anew, the second with a gap of half a second."""
    time = step * np.arange(200) + 0.003
    late = np.where(np.arange(200) < 80, time, time + 0.5)
    frame = pd.concat([table(time, run=1 + 0 * time), table(late, run=2 + 0 * time)])
    frame["load_torque_mNm"] = np.linspace(0.0, 70.0, len(frame))
    return frame


PREPARATIONS: dict[str, dict[str, Any]] = {
    "nothing": {},
    "units and scale": {
        "columns": {
            "joint_position": {
                "column": "joint_position_rad",
                "unit": "deg",
                "sign": -1,
                "scale": 1.7,
                "offset": 0.1,
            }
        }
    },
    "window": {"window": [0.2, 1.5]},
    "one run": {"runs": [2]},
    "offset at the start": {"columns": {"joint_position": {"remove_offset": "start"}}},
    "mean offset": {"columns": {"motor_position": {"remove_offset": "mean", "offset": 0.3}}},
    "shift": {"time_shift": {"joint_position": 0.0123, "load_torque": -0.004}},
    "resampled, coarser": {"resample": 0.037},
    "all at once": {
        "columns": {
            "joint_position": {"remove_offset": "start", "scale": 0.3},
            "motor_position": {"remove_offset": "mean"},
        },
        "time_shift": {"joint_position": -0.0123},
        "resample": 0.023,
        "window": [0.11, 1.9],
        "runs": [2, 1],
    },
}


@pytest.mark.parametrize("case", PREPARATIONS)
def test_replay_gives_the_same_samples(tmp_path: Path, case: str) -> None:
    data = saved(tmp_path, runs_with_gaps())
    preparation = check_preparation(PREPARATIONS[case], case)
    for measurement in read_measurements(data, preparation):
        tree = json.loads(json.dumps(preparation_json(measurement.preparation)))
        (again,) = read_measurements(data, check_preparation(tree, "again"))
        assert_same_samples(again, measurement)
        tree = tomllib.loads(tomli_w.dumps(preparation_json(measurement.preparation)))
        (again,) = read_measurements(data, check_preparation(tree, "again"))
        assert_same_samples(again, measurement)


def test_comparison_of_an_earlier_run_replays_every_piece(tmp_path: Path) -> None:
    data = saved(tmp_path, runs_with_gaps())
    found = read_measurements(data)
    assert [recording.name for recording in found] == [
        "run.csv#1",
        "run.csv#2[0.003:0.793]",
        "run.csv#2[1.303:2.493]",
    ]
    earlier = tmp_path / "earlier.json"
    written_comparison(earlier, found)
    again = read_prepared(data, mapped(str(earlier)))
    assert len(again) == len(found)
    for first, second in zip(again, found, strict=True):
        assert_same_samples(first, second)


def test_files_of_one_name_are_told_apart_by_their_paths(tmp_path: Path) -> None:
    found = []
    for folder, column in (("a", "enc_rad"), ("b", "enc_deg")):
        (tmp_path / folder).mkdir()
        frame = table(0.01 * np.arange(50)).rename(columns={"joint_position_rad": column})
        data = saved(tmp_path / folder, frame)
        found += read_prepared(data, mapped(f"joint_position={column}"))
    earlier = written_comparison(tmp_path / "earlier.json", found)
    for measurement in found:
        (again,) = read_prepared(measurement.source, mapped(earlier))
        assert_same_samples(again, measurement)
    moved = saved(tmp_path, table(0.01 * np.arange(50)))
    with pytest.raises(MeasurementError, match=r"several files called run.csv \(.*a.run.csv, .*b"):
        read_prepared(moved, mapped(earlier))


def test_window_of_pieces_prepared_alike_is_read_once(tmp_path: Path) -> None:
    time = 0.01 * np.arange(100)
    time[50:] += 1.0
    data = saved(tmp_path, table(time))
    earlier = written_comparison(tmp_path / "earlier.json", read_measurements(data))
    (found,) = read_prepared(f"{data}[0.1:0.4]", mapped(earlier))
    assert found.time[[0, -1]] == pytest.approx([0.1, 0.4])
    assert found.name == "run.csv[0.1:0.4]"
    found, late = read_prepared(f"{data}[0.1:1.6]", mapped(earlier))
    assert (found.time[-1], late.time[0], late.time[-1]) == pytest.approx((0.49, 1.5, 1.6))


def test_a_part_compared_beside_its_whole_is_not_read_again(tmp_path: Path) -> None:
    data = saved(tmp_path, table(0.01 * np.arange(100)))
    whole, part = read_measurement(data), read_measurement(f"{data}[0.2:0.5]")
    earlier = written_comparison(tmp_path / "earlier.json", [whole, part])
    for again, once in ((data, whole), (f"{data}[0.2:0.5]", part)):
        (found,) = read_prepared(again, mapped(earlier))
        assert_same_samples(found, once)


def test_window_of_pieces_prepared_differently(tmp_path: Path) -> None:
    data = saved(tmp_path, table(0.01 * np.arange(100)))
    pieces = [
        read_prepared(data + window, ReadOptions(remove_offset=("joint_position",)))[0]
        for window in ("[0:0.4]", "[0.5:0.9]")
    ]
    earlier = written_comparison(tmp_path / "earlier.json", pieces)
    early, late = read_prepared(f"{data}[0.1:0.75]", mapped(earlier))
    assert (early.time[-1], late.time[0], late.time[-1]) == pytest.approx((0.4, 0.5, 0.75))
    assert early.preparation.columns == pieces[0].preparation.columns
    assert late.preparation.columns == pieces[1].preparation.columns
    with pytest.raises(MeasurementError, match="says nothing about this window"):
        read_prepared(f"{data}[0.95:0.99]", mapped(earlier))
    whole = read_prepared(data, ReadOptions(remove_offset=("joint_position",)))
    both = written_comparison(tmp_path / "both.json", [*whole, pieces[1]])
    with pytest.raises(MeasurementError, match="two ways to read a part of this window"):
        read_prepared(f"{data}[0.6:0.8]", mapped(both))


def test_whole_text_of_a_mapping_is_tried_as_a_column_first(tmp_path: Path) -> None:
    frame = table(0.01 * np.arange(50)).rename(columns={"joint_position_rad": "enc-2"})
    data = saved(tmp_path, frame)
    (found,) = read_prepared(data, mapped("joint_position=enc-2"))
    assert found.signals["joint_position"] == pytest.approx(signal(found.time)[1])
    frame["enc"] = 1.0
    (both,) = read_prepared(saved(tmp_path, frame, "both.csv"), mapped("joint_position=enc-2"))
    assert_same_samples(both, found)


@pytest.mark.parametrize("start", [0.0, 1.7e9, 1.7e9 + 1 / 3])
@pytest.mark.parametrize("step", [1e-3, 1 / 3000, 2e-5])
def test_printed_window_gives_the_same_samples(tmp_path: Path, start: float, step: float) -> None:
    time = start + step * np.arange(200)
    time[60:] += 50 * step
    data = saved(tmp_path, table(time))
    found = read_measurements(data)
    assert [len(recording.time) for recording in found] == [60, 140]
    for recording in found:
        (again,) = read_measurements(str(tmp_path / recording.name))
        assert np.array_equal(again.time, recording.time)
        assert again.name == recording.name


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


def test_column_of_blanks_is_named(tmp_path: Path) -> None:
    frame = table(0.01 * np.arange(50)).assign(joint_position_rad=np.nan)
    with pytest.raises(MeasurementError, match="column joint_position_rad holds no number"):
        read_measurements(saved(tmp_path, frame), Preparation(resample=0.01))


def test_preparation_beside_the_file_is_used_with_a_note(tmp_path: Path) -> None:
    data = saved(tmp_path, table(0.01 * np.arange(50)))
    (tmp_path / "run.csv.toml").write_text("[columns.joint_position]\nscale = 2.0\n")
    (found,) = read_prepared(data)
    assert found.signals["joint_position"] == pytest.approx(2.0 * signal(found.time)[1])
    assert "read as run.csv.toml beside it says" in found.notes
    (plain,) = read_measurements(data)
    assert plain.signals["joint_position"] == pytest.approx(signal(plain.time)[1])


def test_window_asked_for_comes_before_the_one_written_down(tmp_path: Path) -> None:
    data = saved(tmp_path, table(0.01 * np.arange(100)))
    (tmp_path / "run.csv.toml").write_text("window = [0.0, 0.2]\n")
    (found,) = read_prepared(data + "[0.5:0.8]")
    assert found.time[[0, -1]] == pytest.approx([0.5, 0.8])
    assert found.name == "run.csv[0.5:0.8]"


def test_two_preparations_are_refused(tmp_path: Path) -> None:
    with pytest.raises(MeasurementError, match="names two preparations"):
        read_prepared(str(tmp_path / "run.csv"), mapped("a.toml", "b.toml"))


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


def test_names_that_no_file_can_have() -> None:
    with pytest.raises(MeasurementError, match="holds no NUL"):
        read_prepared("a\0b.csv")
    with pytest.raises(MeasurementError, match="x: the file cannot be read"):
        read_prepared("x" * 5000)


def test_step_too_short_for_the_memory(tmp_path: Path) -> None:
    data = saved(tmp_path, table(0.01 * np.arange(50)))
    with pytest.raises(MeasurementError, match="resampled to 1e-09 s it has more than 12000000"):
        read_prepared(data, ReadOptions(resample=1e-9))


def test_shift_takes_back_what_a_sensor_is_late(tmp_path: Path) -> None:
    time = 0.001 * np.arange(3000)
    frame = table(time)
    frame["joint_position_rad"] = signal(time - 0.02)[1]
    data = saved(tmp_path, frame)
    (found,) = read_measurements(data, Preparation(time_shift={"joint_position": 0.02}))
    assert found.signals["joint_position"] == pytest.approx(signal(found.time)[1], abs=1e-9)
    assert found.motor_position == pytest.approx(signal(found.time)[0], abs=1e-5)


def test_shift_to_be_estimated_is_kept_for_the_comparison(tmp_path: Path) -> None:
    data = saved(tmp_path, table(0.01 * np.arange(50)))
    (found,) = read_measurements(data, Preparation(time_shift={"joint_position": "auto"}))
    assert found.preparation.time_shift == {"joint_position": "auto"}
    assert len(found.time) == 50


def test_what_was_done_is_noted(tmp_path: Path) -> None:
    frame = table(0.01 * np.arange(50)).rename(columns={"joint_position_rad": "enc2"})
    (found,) = read_prepared(
        saved(tmp_path, frame),
        ReadOptions(("joint_position=enc2:deg*-1",), remove_offset=("joint_position",)),
    )
    assert found.notes[0] == "joint_position was read from enc2 in deg, times -1"
    assert re.fullmatch(r"joint_position: an offset of -?[0-9.e-]+ was removed.*", found.notes[1])
    assert found.signals["joint_position"][:11].mean() == pytest.approx(0.0, abs=1e-15)


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


def test_progress_is_told(tmp_path: Path) -> None:
    shares: list[float] = []
    data = saved(tmp_path, table(0.001 * np.arange(5000)))
    read_prepared(data, progress=lambda _, share: shares.append(share))
    assert shares[-1] == pytest.approx(1.0)
    assert shares == sorted(shares)


BAD_TABLES: dict[str, tuple[Callable[[pd.DataFrame], pd.DataFrame], str]] = {
    "reversed time": (
        lambda frame: frame[::-1],
        "the time runs backwards at row 3 .0.48 s after 0.49 s.; sort the rows by time",
    ),
    "time jumps back": (
        lambda frame: pd.concat([frame.iloc[20:], frame.iloc[:20]]),
        r"the time does not increase at row 32 \(0 s after 0.49 s\); sort the rows",
    ),
    "only one signal": (
        lambda frame: frame.drop(columns="joint_position_rad"),
        "there is no column joint_position_rad",
    ),
    "nine samples": (lambda frame: frame[:9], "it holds 9 samples and needs at least 10"),
    "minus infinity": (
        lambda frame: frame.replace({"joint_position_rad": {frame.iloc[4, 2]: -np.inf}}),
        "joint_position_rad, row 6 holds '-inf'",
    ),
    "rows of nothing": (
        lambda frame: pd.concat([frame.iloc[:30], 0.0 * frame.iloc[:1] / 0.0, frame.iloc[30:]]),
        "column time_s, row 32 holds no number; every sample needs a finite number; drop the row, ",
    ),
}


@pytest.mark.parametrize("case", BAD_TABLES)
def test_bad_table_is_refused_in_one_sentence(tmp_path: Path, case: str) -> None:
    spoil, fragment = BAD_TABLES[case]
    data = saved(tmp_path, spoil(table(0.01 * np.arange(50))))
    with pytest.raises(MeasurementError, match=fragment) as refused:
        read_measurements(data)
    assert str(refused.value).startswith("run.csv: ")
    assert "\n" not in str(refused.value)


def test_bad_row_outside_the_window_does_not_matter(tmp_path: Path) -> None:
    frame = table(0.01 * np.arange(100))
    frame.loc[80, "joint_position_rad"] = np.nan
    assert len(read_measurements(saved(tmp_path, frame) + "[0:0.5]")[0].time) == 51


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


@pytest.mark.parametrize("values", [[True, False] * 25, [True, None] * 25])
@pytest.mark.parametrize("suffix", ["csv", "parquet"])
def test_truth_values_are_no_positions(tmp_path: Path, values: list[Any], suffix: str) -> None:
    frame = table(0.01 * np.arange(50)).assign(motor_position_rad=values)
    path = str(tmp_path / f"run.{suffix}")
    frame.to_csv(path, index=False) if suffix == "csv" else frame.to_parquet(path)
    with pytest.raises(MeasurementError, match="motor_position_rad holds truth values; motor_pos"):
        read_measurements(path)


def test_complex_numbers_are_no_positions(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    with h5py.File(path, "w") as file:
        for name, values in table(0.01 * np.arange(50)).items():
            file[str(name)] = values + (1j if name == "joint_position_rad" else 0.0)
    with pytest.raises(MeasurementError, match="joint_position_rad holds complex numbers"):
        read_measurements(str(path))


def test_times_with_a_unit_in_each_cell(tmp_path: Path) -> None:
    time = [f"{0.01 * i:g} sec" for i in range(50)]
    frame = table(0.01 * np.arange(50)).assign(time_s=time)
    with pytest.raises(MeasurementError, match=r"holds '0 sec'; .*write plain numbers without a"):
        read_measurements(saved(tmp_path, frame))


def test_labels_of_runs_are_one_where_their_numbers_are(tmp_path: Path) -> None:
    frame = table(0.01 * np.arange(60))
    frame["run"] = ["1.0", "1"] * 15 + ["01"] * 30
    frame.loc[59, "run"] = "end"
    found = read_measurements(saved(tmp_path, frame))
    assert [(recording.name, len(recording.time)) for recording in found] == [
        ("run.csv#1", 30),
        ("run.csv#01", 29),
    ]


def test_duration_of_parquet_is_in_s_whatever_its_name_says(tmp_path: Path) -> None:
    frame = table(0.01 * np.arange(50))
    frame.insert(0, "time_ms", pd.to_timedelta(frame.pop("time_s"), unit="s"))
    path = str(tmp_path / "run.parquet")
    frame.to_parquet(path)
    with pytest.raises(MeasurementError, match=r"file; say which with --map time=time_ms:s$"):
        read_measurements(path)
    (found,) = read_prepared(path, mapped("time=time_ms:s"))
    assert found.time == pytest.approx(0.01 * np.arange(50))


def test_samples_between_the_samples_are_refused(write) -> None:
    data = write(HEADER, *ROWS)
    with pytest.raises(MeasurementError, match=r"was sampled every 0\.01 s.* --resample 0\.01 or"):
        read_prepared(data, ReadOptions(resample=0.005))
    assert len(read_prepared(data, ReadOptions(resample=0.01))[0].time) == len(ROWS)


@pytest.mark.parametrize(("rows_at_rest", "moves"), [(1, True), (12, False)])
def test_an_offset_taken_from_a_motion_is_told(write, rows_at_rest: int, moves: bool) -> None:
    rows = [
        f"{0.01 * i:.2f},0,{0.3 + 0.1 * max(i - rows_at_rest, 0):.1f}"
        for i in range(rows_at_rest + 20)
    ]
    (run,) = read_prepared(write(HEADER, *rows), ReadOptions(remove_offset=("joint_position",)))
    (note,) = (note for note in run.notes if "an offset of" in note)
    assert ("though it moves by" in note) is moves
