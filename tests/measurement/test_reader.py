"""Recordings are read as they stand in the file; bad ones are refused in one sentence."""

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
)
from written_tables import assert_same_samples, mapped, saved, signal, table

HEADER = "time_s,motor_position_rad,joint_position_rad"


ROWS = [f"{0.01 * i:.2f},{0.1 * i:.1f},{0.2 * i:.1f}" for i in range(12)]


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


def test_whole_text_of_a_mapping_is_tried_as_a_column_first(tmp_path: Path) -> None:
    frame = table(0.01 * np.arange(50)).rename(columns={"joint_position_rad": "enc-2"})
    data = saved(tmp_path, frame)
    (found,) = read_prepared(data, mapped("joint_position=enc-2"))
    assert found.signals["joint_position"] == pytest.approx(signal(found.time)[1])
    frame["enc"] = 1.0
    (both,) = read_prepared(saved(tmp_path, frame, "both.csv"), mapped("joint_position=enc-2"))
    assert_same_samples(both, found)


def test_column_of_blanks_is_named(tmp_path: Path) -> None:
    frame = table(0.01 * np.arange(50)).assign(joint_position_rad=np.nan)
    with pytest.raises(MeasurementError, match="column joint_position_rad holds no number"):
        read_measurements(saved(tmp_path, frame), Preparation(resample=0.01))


def test_names_that_no_file_can_have() -> None:
    with pytest.raises(MeasurementError, match="holds no NUL"):
        read_prepared("a\0b.csv")
    with pytest.raises(MeasurementError, match="x: the file cannot be read"):
        read_prepared("x" * 5000)


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
