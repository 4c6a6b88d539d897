"""Preparations are strict, the same in TOML and JSON, and wrong ones are told by the field."""

import json
import tomllib
from pathlib import Path
from typing import Any

import pytest
import tomli_w

from elastic_tendon.errors import MeasurementError
from elastic_tendon.measurement.options import ReadOptions
from elastic_tendon.measurement.preparation import (
    COMPARISON,
    Preparation,
    SignalColumn,
    check_preparation,
    parse_map,
    preparation_json,
    read_preparations,
)

FULL: dict[str, Any] = {
    "columns": {
        "joint_position": {
            "column": "enc/2",
            "unit": "deg",
            "sign": -1,
            "scale": 0.1,
            "offset": 1 / 3,
            "remove_offset": "start",
        },
        "time": {"column": "t", "unit": "ms"},
    },
    "time_shift": {"joint_position": 0.003, "joint_torque": "auto"},
    "resample": 0.002,
    "window": [0.1, 2.0],
    "runs": [1, "second"],
}


def test_toml_and_json_hold_the_same_preparation() -> None:
    preparation = check_preparation(FULL, "full")
    tree = preparation_json(preparation)
    assert check_preparation(tomllib.loads(tomli_w.dumps(tree)), "toml") == preparation
    assert check_preparation(json.loads(json.dumps(tree)), "json") == preparation
    assert preparation.columns["joint_position"].offset == 1 / 3
    assert preparation.runs == (1, "second")


def test_nothing_to_prepare_is_an_empty_tree() -> None:
    assert preparation_json(Preparation()) == {}


@pytest.mark.parametrize(
    ("tree", "fragment"),
    [
        ([1], r"^p\.toml: \[1\] is found where a table with columns"),
        ({"colums": {}}, "colums: not known in a preparation; did you mean columns"),
        ({"columns": {"joint_position": {"colum": "a"}}}, "did you mean column[?]"),
        ({"columns": {"joint_positon": {}}}, "no signal 'joint_positon'; did you mean joint_pos"),
        ({"columns": {"joint_position": 3}}, "3 is found where a table such as"),
        ({"columns": {"joint_position": {"sign": 2}}}, "sign: 2 is found where 1 or -1"),
        ({"columns": {"joint_position": {"scale": 0.0}}}, "0 would leave nothing"),
        ({"columns": {"joint_position": {"scale": True}}}, "True is found where a number"),
        ({"columns": {"time": {"remove_offset": "start"}}}, "not for time"),
        ({"columns": {"load_torque": {"remove_offset": "end"}}}, '"start" or "mean" is expected'),
        ({"time_shift": {"joint_position": "guess"}}, "'guess' is found where a number of seconds"),
        ({"time_shift": {"time": 1.0}}, "'time' cannot be shifted"),
        ({"resample": 0.0}, "resample: 0.0 is found where a step in s, above 0"),
        ({"window": [1.0]}, r"window: \[1.0\] is found where a list of two times"),
        ({"window": [2.0, 1.0]}, "the window must end after it starts"),
        ({"window": [0.0, float("inf")]}, "window: inf is found"),
        ({"runs": []}, r"runs: \[\] is found where a list of values of the column run"),
        ({"runs": [1.5]}, "runs: 1.5 is found"),
    ],
)
def test_wrong_field_is_told(tree: Any, fragment: str) -> None:
    with pytest.raises(MeasurementError, match=fragment) as refused:
        check_preparation(tree, "p.toml")
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    ("item", "expected"),
    [
        ("joint_position=q", SignalColumn(column="q")),
        ("joint_position=q*-0.5+0.25", SignalColumn(column="q", scale=-0.5, offset=0.25)),
        (
            "joint_position=q:mrad*16-1e-2",
            SignalColumn(column="q", unit="mrad", scale=16.0, offset=-0.01),
        ),
        ("load_torque=F:mN.m", SignalColumn(column="F", unit="mN.m")),
        ("motor_velocity=w:rad/s", SignalColumn(column="w", unit="rad/s")),
        ("joint_position=enc 2:°", SignalColumn(column="enc 2", unit="°")),
        ("joint_position=/bag/topic/x[0]:deg", SignalColumn(column="/bag/topic/x[0]", unit="deg")),
        ("load_torque=enc-2", SignalColumn(column="enc", offset=-2.0)),
    ],
)
def test_map_item(item: str, expected: SignalColumn) -> None:
    assert parse_map(item) == (item.split("=")[0], expected)


@pytest.mark.parametrize(
    ("item", "fragment"),
    [
        ("joint_position", "write it as signal=column"),
        ("elbow=q", "there is no signal 'elbow'; choose one of time"),
        ("joint_positon=q", "did you mean joint_position"),
        ("joint_position=q*0", "a scale of 0"),
        ("joint_position=q*1e400", "a number in it is too large"),
        ("joint_position=q+1e400", "a number in it is too large"),
    ],
)
def test_bad_map_item(item: str, fragment: str) -> None:
    with pytest.raises(MeasurementError, match=fragment):
        parse_map(item)


def test_command_line_comes_before_the_file() -> None:
    options = ReadOptions(
        mapping=("joint_position=q",),
        time_shift={"joint_torque": 0.1},
        resample=0.01,
        remove_offset=("motor_position",),
    )
    merged = options.over(check_preparation(FULL, "full"))
    assert merged.columns["joint_position"] == SignalColumn(column="q")
    assert merged.columns["motor_position"] == SignalColumn(remove_offset="start")
    assert merged.columns["time"].unit == "ms"
    assert merged.time_shift == {"joint_position": 0.003, "joint_torque": 0.1}
    assert merged.resample == 0.01
    assert merged.window == (0.1, 2.0)


@pytest.mark.parametrize(
    ("changes", "fragment"),
    [
        ({"mapping": ("joint_position=a", "joint_position=b")}, "mapping: a signal is mapped twi"),
        ({"mapping": ("elbow=q",)}, "mapping: 'elbow=q': there is no signal 'elbow'"),
        ({"mapping": ("a.toml", "b.toml")}, "mapping: it names two preparations, a.toml and b.t"),
        ({"remove_offset": ("elbow",)}, "remove_offset: 'elbow' is none of motor_position, joint"),
        ({"time_shift": {"elbow": 1.0}}, "time_shift: 'elbow' is none of motor_position, joint_p"),
        ({"time_shift": {"load_torque": float("nan")}}, "time_shift: give load_torque a time in"),
        ({"resample": -1.0}, "resample: give a step in s, above 0"),
        (
            {"interpolation": "spline"},
            "'spline' is none of auto, hold, linear, cubic",
        ),
    ],
)
def test_wrong_option_is_told(changes: dict[str, Any], fragment: str) -> None:
    with pytest.raises(MeasurementError, match=fragment):
        ReadOptions(**changes)


def test_comparison_holds_a_preparation_for_each_run_and_piece(tmp_path: Path) -> None:
    path = tmp_path / "earlier.json"
    names = ["run.csv#1", "run.csv#2[0:1]", "run.csv.csv", "other.csv"]
    sources = ["a/run.csv", "a/run.csv", "a/run.csv.csv", "b/other.csv"]
    files = [
        {"name": name, "source": source, "preparation": {"resample": 0.1 * (i + 1)}}
        for i, (name, source) in enumerate(zip(names, sources, strict=True))
    ]
    path.write_text(json.dumps({"schema": COMPARISON, "files": files}))
    for data in ("run.csv", "a/run.csv", "moved/run.csv"):
        found = read_preparations(path, Path(data))
        assert [preparation.resample for preparation in found] == pytest.approx([0.1, 0.2])


@pytest.mark.parametrize(
    ("name", "content", "fragment"),
    [
        ("p.toml", "window = [", "p.toml: this is not valid TOML"),
        ("p.json", "{", "p.json: this is not valid JSON"),
        ("p.json", "[1]", "this is not the JSON of a comparison"),
        (
            "p.json",
            '{"schema": "elastic-tendon/comparison/1", "files": []}',
            r"nothing about run.csv \(found: none\)",
        ),
        ("p.json", '{"schema": "elastic-tendon/addition/1", "files": []}', "not the JSON of a com"),
        (
            "p.json",
            '{"schema": "elastic-tendon/comparison/1", "files": [{"name": "run.csv"}]}',
            "says how each file was read",
        ),
        ("p.toml", "\xe9".encode("latin-1"), "this is not a text file"),
        ("p.toml", None, "there is no such file"),
    ],
)
def test_bad_file_is_told(
    tmp_path: Path, name: str, content: str | bytes | None, fragment: str
) -> None:
    path = tmp_path / name
    if content is not None:
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
    with pytest.raises(MeasurementError, match=fragment) as refused:
        read_preparations(path, Path("run.csv"))
    assert "\n" not in str(refused.value)


def test_folder_as_preparation_is_told(tmp_path: Path) -> None:
    with pytest.raises(MeasurementError, match="cannot be read"):
        read_preparations(tmp_path, Path("run.csv"))


def test_column_of_that_name_comes_before_signs_in_it() -> None:
    item = "load_torque=enc-2"
    assert parse_map(item, {"enc-2", "enc"}) == ("load_torque", SignalColumn(column="enc-2"))
