"""What was done to a recording is written down, and done again gives the same samples."""

import json
import re
import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
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
)
from elastic_tendon.measurement.preparation import COMPARISON, check_preparation, preparation_json
from written_tables import assert_same_samples, mapped, runs_with_gaps, saved, signal, table


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
