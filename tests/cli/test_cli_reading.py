"""How commands read data: what is refused or not believed, and what is read again the same way."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from command_line import MODEL, only_line
from elastic_tendon.measurement import rows


def csv(change: Callable[[pd.DataFrame], object], **settings):
    """Writer of the table with a change made to it."""

    def write(table: pd.DataFrame, path: Path) -> None:
        changed = table.astype(object) if settings.get("text") else table.copy()
        change(changed)
        kept = {name: value for name, value in settings.items() if name != "text"}
        changed.to_csv(path, index=False, **kept)

    return write


def put(column: str, value: Callable[[pd.DataFrame], object]):
    def change(table: pd.DataFrame) -> None:
        table[column] = value(table)

    return change


def swap(table: pd.DataFrame) -> None:
    motor, joint = "motor_position_rad", "joint_position_rad"
    table[[motor, joint]] = table[[joint, motor]].to_numpy()


def put_cell(row: int, value: object):
    def change(table: pd.DataFrame) -> None:
        table.loc[row, "joint_position_rad"] = value

    return change


def many_columns(table: pd.DataFrame, path: Path) -> None:
    names = ",".join(f"c{index}" for index in range(1_000_000))
    path.write_text(f"{','.join(table.columns)},{names}\n" + "1," * 1_000_003 + "1\n")


def truncated(table: pd.DataFrame, path: Path) -> None:
    table.to_parquet(path)
    path.write_bytes(path.read_bytes()[:-200])


def nothing(_: pd.DataFrame) -> None:
    pass


# file name, how it is written, and what the one sentence about it holds
BAD_FILES = {
    "empty": ("run.csv", lambda _, path: path.write_bytes(b""), ("run.csv", "empty")),
    "header only": (
        "run.csv",
        lambda table, path: table[:0].to_csv(path, index=False),
        ("run.csv", "no samples"),
    ),
    "other delimiter": ("run.csv", csv(nothing, sep="|"), ("run.csv", "vertical bars", "commas")),
    "decimal commas": ("run.csv", csv(nothing, sep=";", decimal=","), ("run.csv", "comma")),
    "text in numbers": (
        "run.csv",
        csv(put_cell(7, "off"), text=True),
        ("joint_position_rad", "row 9", "'off'"),
    ),
    "missing rows": (
        "run.csv",
        csv(put_cell(12, np.nan)),
        ("joint_position_rad", "row 14", "--resample"),
    ),
    "swapped columns": ("run.csv", csv(swap), ("run.csv", "swapped", "--as-declared")),
    "opposite sign": (
        "run.csv",
        csv(put("joint_position_rad", lambda table: -table["joint_position_rad"])),
        ("run.csv", "sign", "--as-declared"),
    ),
    "gear ratio": (
        "run.csv",
        csv(put("motor_position_rad", lambda table: 16.0 * table["motor_position_rad"])),
        ("run.csv", "gear ratio of 1", "--as-declared"),
    ),
    "degrees as radians": (
        "run.csv",
        csv(put("joint_position_rad", lambda table: np.rad2deg(table["joint_position_rad"]))),
        ("run.csv", "in degrees", ":deg", "--as-declared"),
    ),
    "milliseconds as seconds": (
        "run.csv",
        csv(put("time_s", lambda table: 1000.0 * table["time_s"])),
        ("run.csv", "in milliseconds", ":ms", "--as-declared"),
    ),
    "reversed time": (
        "run.csv",
        csv(put("time_s", lambda table: table["time_s"].to_numpy()[::-1])),
        ("run.csv", "row 3", "time"),
    ),
    "a million columns": ("run.csv", many_columns, ("run.csv", "columns")),
    "folder": ("run.csv", lambda _, path: path.mkdir(), ("run.csv", "folder")),
    "truncated Parquet": ("run.parquet", truncated, ("run.parquet",)),
}


@pytest.mark.parametrize("kind", BAD_FILES)
def test_bad_data_is_one_sentence_and_nothing_is_written(run, table, kind: str) -> None:
    name, write, fragments = BAD_FILES[kind]
    write(table, Path(name))
    result = run("compare", MODEL, name, "--json", "c.json", "--plot", "c.png", "--figures", "f")
    assert result.exit_code == 1
    line = only_line(result)
    assert line.startswith("elastic-tendon: ")
    for fragment in fragments:
        assert fragment in line
    assert [path.name for path in Path().iterdir()] == [name]


def test_all_files_that_cannot_be_used_are_told_at_once(run, table) -> None:
    table.to_csv("good.csv", index=False)
    Path("text.csv").write_text("nothing\n")
    names = "text.csv", "good.csv", "gone.csv"
    line = only_line(run("compare", MODEL, *names, "--json", "c.json"))
    assert line.startswith("elastic-tendon: text.csv: ")
    assert "; gone.csv: " in line
    assert "good.csv" not in line
    assert not Path("c.json").exists()


def test_a_file_of_too_many_rows_is_refused_with_what_to_do(run, table, monkeypatch) -> None:
    monkeypatch.setattr(rows, "MAXIMUM_SAMPLES", 1000)
    table.to_csv("run.csv", index=False)
    line = only_line(run("compare", MODEL, "run.csv", "--json", "c.json"))
    assert "run.csv" in line
    assert "--resample" in line
    assert [path.name for path in Path().iterdir()] == ["run.csv"]


def test_data_that_look_misread_are_taken_as_declared_where_told(run, table) -> None:
    csv(put("joint_position_rad", lambda table: -table["joint_position_rad"]))(
        table, Path("run.csv")
    )
    result = run("compare", MODEL, "run.csv", "--as-declared", "--json", "c.json")
    assert result.exit_code == 0
    assert "sign" in result.stderr
    (file,) = json.loads(Path("c.json").read_text())["files"]
    assert any("sign" in note for note in file["notes"])


def test_options_of_reading_are_kept_in_the_json_and_replayed(run, table) -> None:
    changed = table.rename(columns={"joint_position_rad": "encoder"})
    changed["encoder"] = 0.3 - np.rad2deg(changed["encoder"])
    changed["motor_position_rad"] += 0.25
    changed.to_csv("run.csv", index=False)
    read = ("--map", "joint_position=encoder:deg*-1", "--shift", "load_torque=0.004")
    more = ("--resample", "0.01", "--remove-offset", "motor_position", "--as-declared")
    assert run("compare", MODEL, "run.csv[0:8]", *read, *more, "--json", "a.json").exit_code == 0
    first = json.loads(Path("a.json").read_text())["files"]
    preparation = first[0]["preparation"]
    assert preparation["columns"]["joint_position"]["column"] == "encoder"
    assert preparation["time_shift"] == {"load_torque": 0.004}
    assert preparation["resample"] == 0.01
    again = run("compare", MODEL, "run.csv", "--map", "a.json", "--as-declared", "--json", "b.json")
    assert again.exit_code == 0
    second = json.loads(Path("b.json").read_text())["files"]
    assert second[0]["signals"] == first[0]["signals"]
    assert second[0]["preparation"] == preparation


def test_a_preparation_in_toml_is_taken(run, table) -> None:
    table.rename(columns={"joint_position_rad": "encoder"}).to_csv("run.csv", index=False)
    Path("how.toml").write_text('[columns.joint_position]\ncolumn = "encoder"\nunit = "rad"\n')
    assert run("compare", MODEL, "run.csv", "--map", "how.toml").exit_code == 0
    Path("how.toml").rename("run.csv.toml")
    unasked = run("compare", MODEL, "run.csv")
    assert unasked.exit_code == 0
    assert "run.csv.toml" in unasked.stderr


def test_simulate_reads_as_compare_does(run, table) -> None:
    table.rename(columns={"motor_position_rad": "drive"}).to_csv("run.csv", index=False)
    asked = ("--map", "motor_position=drive:rad", "--resample", "0.05", "-o", "out.csv")
    assert run("simulate", MODEL, "run.csv", *asked).exit_code == 0
    out = pd.read_csv("out.csv")
    assert np.diff(out["time_s"]) == pytest.approx(0.05)
    assert out["joint_position_rad"].std() > 0.1


def test_an_estimated_shift_is_told_and_kept(run, table) -> None:
    late = np.interp(table["time_s"] - 0.008, table["time_s"], table["joint_position_rad"])
    table.assign(joint_position_rad=late).to_csv("run.csv", index=False)
    result = run("compare", MODEL, "run.csv", "--shift", "joint_position=auto", "--json", "c.json")
    assert result.exit_code == 0
    (file,) = json.loads(Path("c.json").read_text())["files"]
    assert file["preparation"]["time_shift"]["joint_position"] == pytest.approx(0.008, abs=5e-4)
    assert any("joint_position" in note for note in file["notes"])
    (warning,) = [
        line for line in result.stderr.splitlines() if line.startswith("warning: run.csv: ")
    ]
    assert "joint_position is taken as 8.0" in warning
    assert "standard error 0." in warning
    assert "friction that it lacks or a wrong inertia passes for a delay" in warning
