"""Recordings are read as they stand in the file; bad ones are refused in one sentence."""

from pathlib import Path

import numpy as np
import pytest

from elastic_tendon.errors import MeasurementError
from elastic_tendon.measurement import read_measurement

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
    run = read_measurement(write(*lines), ["joint_position=enc 2*-2+1"])
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
        r"the time does not increase at row 5 \(0.02 s again, with another motor_position_rad\); drop",
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
        read_measurement(write(HEADER, *ROWS), ["joint_position=enc"])


def test_trailing_blank_lines_are_no_samples(write) -> None:
    assert len(read_measurement(write(HEADER, *ROWS, "", "")).time) == len(ROWS)
