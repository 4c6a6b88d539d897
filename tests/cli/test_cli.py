"""The command line: exit status, one line for what is wrong, nothing overwritten unasked."""

import json
import os
import subprocess
import sys
import zipfile
from collections.abc import Callable
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

from elastic_tendon import cli
from elastic_tendon.actuator.parameters import load_model
from elastic_tendon.actuator.transmission import characteristic_torque
from elastic_tendon.effects import CATALOGUE
from elastic_tendon.measurement import rows
from elastic_tendon.simulation.excitation import default_excitation
from elastic_tendon.simulation.simulate import simulate

MODEL = "biorob_x4_joint_3"
RATE = 200  # Hz


@pytest.fixture
def run(monkeypatch, tmp_path: Path):
    """Call the command in an empty folder; both streams come back apart."""
    monkeypatch.chdir(tmp_path)
    runner = CliRunner()

    def run(*arguments: str, columns: str = "100"):
        return runner.invoke(cli.app, list(arguments), env={"COLUMNS": columns})

    return run


@pytest.fixture
def recording(tmp_path: Path) -> str:
    """Two seconds of a machine with a heavier link than the model, without noise."""
    model = load_model(MODEL)
    heavier = model.with_values({"link.inertia": 1.1 * model.link.inertia})
    time = np.arange(2 * RATE) / RATE
    motion = 0.3 * np.sin(7.0 * time) * np.minimum(time, 1.0)
    trajectory = simulate(heavier, time, motion)
    columns = {
        "time_s": time,
        "motor_position_rad": motion,
        "joint_position_rad": trajectory["joint_position"].round(6),
    }
    path = tmp_path / "run.csv"
    pd.DataFrame(columns).to_csv(path, index=False)
    return str(path)


def only_line(result) -> str:
    """The one line on stderr; there must be no other and nothing on stdout."""
    assert result.stdout == ""
    (line,) = result.stderr.strip().splitlines()
    return line


def test_help_lists_the_commands(run) -> None:
    result = run("--help")
    assert result.exit_code == 0
    for command in (
        *("demo", "diagnose", "simulate", "compare", "add"),
        *("export", "design", "effects", "cache", "linearise", "app"),
    ):
        assert command in result.stdout


@pytest.mark.parametrize("command", ["compare", "add", "diagnose"])
def test_help_shows_the_time_window(run, command: str) -> None:
    assert "[start:end]" in run(command, "--help").stdout


def test_help_imports_nothing_heavy() -> None:
    script = (
        "import sys; from elastic_tendon import cli; "
        "print(sorted({'numpy', 'scipy', 'casadi', 'pandas', 'matplotlib'} & sys.modules.keys()))"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert done.stdout.strip() == "[]"


def test_compare_writes_contract_and_picture(run, recording: str) -> None:
    result = run("compare", MODEL, recording, "--json", "c.json", "--plot", "c.png")
    assert result.exit_code == 0
    assert "run.csv" in result.stdout
    content = json.loads(Path("c.json").read_text())
    assert content["schema"] == "elastic-tendon/comparison/1"
    assert Path("c.png").read_bytes().startswith(b"\x89PNG")
    assert sorted(path.name for path in Path().iterdir()) == ["c.json", "c.png", "run.csv"]


@pytest.mark.parametrize("angle", [0.0, 0.1])
@pytest.mark.parametrize("swing", [0.0, 0.3])
def test_a_joint_that_stands_still_is_compared(run, angle: float, swing: float) -> None:
    time = np.arange(2 * RATE) / RATE
    columns = {
        "time_s": time,
        "motor_position_rad": angle + swing * np.sin(7.0 * time),
        "joint_position_rad": np.full(len(time), angle),
    }
    pd.DataFrame(columns).to_csv("still.csv", index=False)
    result = run("compare", MODEL, "still.csv", "--json", "out.json", "--figures", "figures")
    assert result.exit_code == 0, result.output
    (file,) = json.loads(Path("out.json").read_text())["files"]
    assert file["signals"]["joint_position"]["fit_percent"] is None


def test_a_tolerance_decides_the_exit_status(run, recording: str) -> None:
    result = run("compare", MODEL, recording, "--tolerance", "joint_position=1rad")
    assert result.exit_code == 0
    assert "joint position keeps the tolerance of 1000 mrad" in result.stdout
    options = ("--tolerance", "joint_position=0.1 mrad", "--json", "c.json", "--plot", "c.png")
    result = run("compare", MODEL, recording, *options)
    assert result.exit_code == 1
    words = " ".join(result.stdout.split())
    assert "run.csv: joint position exceeds the tolerance of 0.100 mrad in " in words
    signal = json.loads(Path("c.json").read_text())["files"][0]["signals"]["joint_position"]
    found = signal["tolerance"]
    assert not found["met"]
    assert found["value"] == pytest.approx(1e-4)
    assert 0.0 < found["share_beyond"] <= 1.0
    assert f"{1e3 * signal['max_abs']:.3g} mrad at " in words
    assert Path("c.png").stat().st_size > 0


@pytest.mark.parametrize(
    ("tolerance", "status", "says"),
    [
        ("joint_torque=1Nm", 1, "tolerance of joint_torque: no recording holds this signal"),
        ("joint_position", 2, "write SIGNAL=SIZE"),
        ("joint_position=-1mrad", 2, "positive and finite, not -0.001"),
    ],
)
def test_a_tolerance_that_is_none_is_refused(
    run, recording: str, tolerance: str, status: int, says: str
) -> None:
    result = run("compare", MODEL, recording, "--tolerance", tolerance, columns="300")
    assert result.exit_code == status
    assert says in result.stderr


def test_add_writes_a_model_that_compares_better(run, recording: str) -> None:
    done = run(
        *("add", MODEL, "coulomb_friction", f"{recording}[0:1.4]"),
        *("--validate", f"{recording}[1.4:2]", "--interpolation", "cubic"),
        *("-o", "new.toml", "--json", "a.json", "--plot", "a.svg"),
    )
    assert done.exit_code == 0
    assert "held-out" in done.stdout
    ladder = json.loads(Path("a.json").read_text())["ladder"]
    assert [step["added"] for step in ladder] == [None, None, "coulomb_friction"]
    assert ladder[1]["rmse"]["joint_position"] < 0.1 * ladder[0]["rmse"]["joint_position"]
    assert "coulomb_friction" in load_model(Path("new.toml")).effect_ids
    assert run("compare", "new.toml", recording).exit_code == 0


def test_add_takes_several_effects_before_the_data(run, recording: str) -> None:
    done = run(
        *("add", MODEL, "coulomb_friction", "overstretch_protection", f"{recording}[0:1.4]"),
        *("-o", "new.toml", "--json", "a.json"),
    )
    assert done.exit_code == 0, done.output
    content = json.loads(Path("a.json").read_text())
    added = ["coulomb_friction", "overstretch_protection"]
    assert content["effects"] == added
    assert [step["added"] for step in content["ladder"]] == [None, None, *added]
    assert set(load_model("new.toml").effects) == set(added)


def test_add_tells_a_misspelt_effect_from_data(run, recording: str) -> None:
    done = run("add", MODEL, "coulomb_friction", "gear_backlsh", recording, "-o", "new.toml")
    assert done.exit_code == 1
    assert "there is no effect 'gear_backlsh'" in done.stderr
    typical = run("add", MODEL, "coulomb_friction", "gear_backlash", "-o", "new.toml")
    assert typical.exit_code == 0, typical.output
    assert "coulomb_friction and gear_backlash are in new.toml" in " ".join(typical.stdout.split())


def test_add_without_data_takes_typical_values(run) -> None:
    result = run("add", MODEL, "overstretch_protection", "-o", "new.toml")
    assert result.exit_code == 0
    assert "nothing was fitted" in result.stdout.replace("\n", " ")
    values = load_model(Path("new.toml")).values()
    assert values["effects.overstretch_protection.stiffness"] > 0.0


def test_simulate_without_data_crosses_into_slack_and_can_be_compared(run) -> None:
    assert run("simulate", MODEL, "-o", "out.csv").exit_code == 0
    table = pd.read_csv("out.csv")
    assert set(table["slack_state"]) == {1.0, 2.0, 3.0}
    result = run("compare", MODEL, "out.csv", "--json", "c.json")
    assert result.exit_code == 0
    (file,) = json.loads(Path("c.json").read_text())["files"]
    assert set(file["signals"]) == {"joint_position", "joint_torque", "motor_torque"}
    # the same model on its own table: only the estimate of the initial state differs
    assert file["signals"]["joint_position"]["rmse"] < 1e-6


def test_simulate_with_motor_motion_alone_starts_at_rest(run, recording: str) -> None:
    table = pd.read_csv(recording).drop(columns="joint_position_rad")
    table["motor_position_rad"] += 0.2
    table.to_csv("motor.csv", index=False)
    assert run("simulate", MODEL, "motor.csv", "-o", "out.csv").exit_code == 0
    out = pd.read_csv("out.csv")
    assert len(out) == len(table)
    assert out["joint_position_rad"][0] == pytest.approx(0.2)
    assert out["joint_torque_Nm"][0] == pytest.approx(0.0, abs=1e-9)


def test_simulate_without_the_joint_starts_in_equilibrium_under_the_first_load(run) -> None:
    time = np.arange(400) / RATE
    columns = {
        "time_s": time,
        "motor_position_rad": np.full(400, 0.2),
        "load_torque_Nm": np.full(400, 3.0),
    }
    pd.DataFrame(columns).to_csv("held.csv", index=False)
    assert run("simulate", MODEL, "held.csv", "-o", "out.csv").exit_code == 0
    out = pd.read_csv("out.csv")
    assert out["joint_position_rad"][0] > 0.25
    assert np.ptp(out["joint_position_rad"]) < 1e-6
    assert out["joint_torque_Nm"].to_numpy() == pytest.approx(-3.0, abs=1e-5)


def test_design_prints_the_papers_numbers(run) -> None:
    result = run("design", MODEL, "--plot", "curves.png")
    assert result.exit_code == 0
    assert "41.69" in result.stdout
    assert "173.7" in result.stdout
    assert Path("curves.png").stat().st_size > 10_000


def test_effects_come_from_the_catalogue(run) -> None:
    listed = run("effects").stdout
    for effect in CATALOGUE:
        assert effect.id in listed
        assert effect.title in listed


def test_effect_is_explained_and_drawn(run) -> None:
    picture = Path("effect_coulomb_friction.png")
    for _ in range(2):  # its own picture of the first call is replaced
        done = run("effects", "coulomb_friction")
        assert done.exit_code == 0
        assert "effects.coulomb_friction.torque" in done.stdout
        assert f"The picture is {picture}" in done.stdout
        assert picture.read_bytes().startswith(b"\x89PNG")
    picture.write_text("a user's own")
    assert "exists already" in only_line(run("effects", "coulomb_friction"))
    assert picture.read_text() == "a user's own"


@pytest.mark.parametrize(
    ("arguments", "fragment"),
    [
        (("compare", "no_model", "run.csv"), "no_model: there is no such file"),
        (("compare", MODEL, "none.csv"), "none.csv: there is no such file"),
        (("compare", MODEL, "run.csv[7:9]"), "the recording runs from 0 s to 1.995 s"),
        (
            ("compare", MODEL, "run.csv", "--plot", "c.xyz"),
            "no picture is written with this suffix",
        ),
        (("add", MODEL, "magic", "run.csv", "-o", "new.toml"), "there is no effect 'magic'"),
        (("simulate", MODEL, "none.csv", "-o", "o.csv"), "none.csv: there is no such file"),
        (("simulate", MODEL, "-o", "no/o.csv"), "there is no folder no; create it first"),
        (("design", "no_model"), "no_model: there is no such file"),
        (("effects", "magic"), "there is no effect 'magic'"),
        (("design", MODEL, "--effect", "none.py"), "none.py: there is no such file"),
        (("design", MODEL, "--effect", "run.csv"), "run.csv: an effect is a Python file"),
        (("export", MODEL, "-o", "."), "name a file in it that ends in .fmu"),
    ],
)
def test_what_cannot_be_done_is_one_line_and_status_1(
    run, recording: str, arguments: tuple[str, ...], fragment: str
) -> None:
    assert Path(recording).is_file()
    before = sorted(path.name for path in Path().iterdir())
    result = run(*arguments)
    assert result.exit_code == 1
    assert fragment in only_line_at_end(result)
    assert "Traceback" not in result.output
    assert sorted(path.name for path in Path().iterdir()) == before


def only_line_at_end(result) -> str:
    line = result.stderr.strip().splitlines()[-1]
    assert line.startswith("elastic-tendon: ")
    return line


@pytest.mark.parametrize(
    "arguments",
    [
        ("compare", MODEL),
        ("compare",),
        ("simulate", MODEL),
        ("add", MODEL, "coulomb_friction"),
        ("nonsense",),
        ("cache", "--nonsense"),
        ("effects", "--plot", "e.png"),
        ("add", MODEL, "coulomb_friction", "-o", "new.toml", "--json", "a.json"),
    ],
)
def test_wrong_usage_is_status_2(run, arguments: tuple[str, ...]) -> None:
    result = run(*arguments)
    assert result.exit_code == 2
    assert not list(Path().iterdir())


@pytest.mark.parametrize(
    ("options", "fragment"),
    [
        (("--resample", "0"), "Invalid value for --resample: give a step in s, above 0"),
        (("--resample", "-1"), "Invalid value for --resample"),
        (("--resample", "nan"), "Invalid value for --resample"),
        (("--shift", "foo=1"), "Invalid value for --shift: 'foo' is none of motor_position"),
        (("--shift", "=1"), "Invalid value for --shift: '' is none of"),
        (("--shift", "joint_position=soon"), "signal=auto"),
        (
            ("--shift", "load_torque=0.1", "--shift", "load_torque=0.2"),
            "Invalid value for --shift: a signal is shifted twice",
        ),
        (("--remove-offset", "foo"), "Invalid value for --remove-offset: 'foo' is none of"),
        (("--remove-offset", "time"), "Invalid value for --remove-offset: 'time' is none of"),
        (("--map", "elbow=q"), "Invalid value for --map: 'elbow=q': there is no signal 'elbow'"),
        (("--map", "joint_position="), "Invalid value for --map: 'joint_position='"),
        (
            ("--map", "time=a", "--map", "time=b"),
            "Invalid value for --map: a signal is mapped twice",
        ),
    ],
)
@pytest.mark.parametrize("command", ["compare", "add", "simulate"])
def test_wrong_options_of_reading_are_status_2_and_named(
    run, command: str, options: tuple[str, ...], fragment: str
) -> None:
    before = {
        "compare": ("compare", MODEL, "run.csv"),
        "add": ("add", MODEL, "coulomb_friction", "run.csv", "-o", "new.toml"),
        "simulate": ("simulate", MODEL, "run.csv", "-o", "out.csv"),
    }
    result = run(*before[command], *options, columns="300")
    assert result.exit_code == 2
    assert fragment in result.stderr
    assert not list(Path().iterdir())


@pytest.mark.parametrize(
    ("arguments", "target"),
    [
        (("simulate", MODEL, "-o", "out.csv"), "out.csv"),
        (("add", MODEL, "coulomb_friction", "-o", "new.toml"), "new.toml"),
        (("compare", MODEL, "run.csv", "--json", "c.json"), "c.json"),
        (("design", MODEL, "--plot", "d.png"), "d.png"),
        (("effects", "coulomb_friction", "--plot", "e.png"), "e.png"),
        (("demo",), "elastic_tendon_demo.png"),
    ],
)
def test_nothing_is_overwritten_unasked(
    run, recording: str, arguments: tuple[str, ...], target: str
) -> None:
    assert Path(recording).is_file()
    Path(target).write_text("mine")
    result = run(*arguments)
    assert result.exit_code == 1
    assert f"{target}: the file exists already" in only_line(result)
    assert Path(target).read_text() == "mine"
    if target != "elastic_tendon_demo.png":
        assert run(*arguments, "--force").exit_code == 0
        assert Path(target).read_bytes() != b"mine"


def test_failure_while_writing_leaves_nothing(run, monkeypatch) -> None:
    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "replace", full)
    result = run("add", MODEL, "coulomb_friction", "-o", "new.toml")
    assert result.exit_code == 1
    assert "new.toml: cannot be written (No space left on device)" in only_line(result)
    assert not list(Path().iterdir())


def test_design_draws_unasked_and_replaces_only_its_own_picture(run) -> None:
    picture = Path("characteristic_curves.png")
    for _ in range(2):
        assert run("design", MODEL).exit_code == 0
        assert picture.read_bytes().startswith(b"\x89PNG")
    picture.write_text("a user's own")
    assert "exists already" in only_line(run("design", MODEL))
    assert picture.read_text() == "a user's own"


def test_interrupt_is_one_line(run, monkeypatch) -> None:
    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(cli.models, "load", interrupted)
    result = run("design", MODEL)
    assert result.exit_code == cli.INTERRUPTED
    assert only_line(result) == "elastic-tendon: stopped, nothing was written"


def test_interrupt_after_a_file_was_written_says_so(run, recording: str, monkeypatch) -> None:
    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(cli.measurements, "_show_comparison", interrupted)
    result = run("compare", MODEL, recording, "--figures", "f", "--json", "c.json")
    assert result.exit_code == cli.INTERRUPTED
    assert only_line_at_end(result) == "elastic-tendon: stopped, but f, c.json had been written"
    assert Path("f").is_dir()
    assert Path("c.json").is_file()


def test_interrupt_before_a_command_begins_has_no_traceback(monkeypatch) -> None:
    def interrupted() -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(cli, "app", interrupted)
    with pytest.raises(SystemExit) as stopped:
        cli.main()
    assert stopped.value.code == cli.INTERRUPTED


def test_comparing_tells_how_far_it_is(run, recording: str, monkeypatch) -> None:
    told: list[tuple[str, float]] = []

    @contextmanager
    def telling():
        yield lambda text, share: told.append((text, share))

    monkeypatch.setattr(cli.measurements, "progress_bar", telling)
    assert run("compare", MODEL, recording, f"{recording}[0:1]").exit_code == 0
    simulating = [call for call in told if call[0].endswith(": simulating")]
    assert [share for _, share in simulating] == [0.0, 0.5]
    assert simulating[0][0].startswith("run.csv")


def test_demo_falls_to_the_noise_and_knows_its_own_picture(run) -> None:
    first = run("demo")
    assert first.exit_code == 0
    assert "+ Coulomb friction" in first.stdout
    picture = Path("elastic_tendon_demo.png")
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert "The picture of this is elastic_tendon_demo.png" in first.stdout
    second = run("demo")
    assert second.exit_code == 0
    # figures of fits are the same from run to run
    assert second.stdout == first.stdout


def test_cache_shows_its_folder(run, monkeypatch, tmp_path: Path) -> None:
    monkeypatch.setenv("ELASTIC_TENDON_CACHE", str(tmp_path / "libraries"))
    result = run("cache", "--clear")
    assert result.exit_code == 0
    assert "0 compiled libraries deleted" in result.stdout
    assert "libraries" in result.stdout


def test_a_recording_of_sensors_is_met_by_its_own_model(run) -> None:
    """`compare` takes what the encoders read where a table has it beside what is true."""
    model = load_model("biorob_x4_joint_3")
    for effect, numbers in (
        ("joint_encoder_offset", {"offset": 0.02}),
        ("motor_encoder_offset", {"offset": 0.03}),
        ("measurement_delay", {"delay": 0.0031}),
    ):
        model = model.with_effect(effect, numbers)
    Path("sensors.toml").write_text(model.to_toml(), "utf-8")
    assert run("simulate", "sensors.toml", "-o", "sensors.csv").exit_code == 0
    assert run("compare", "sensors.toml", "sensors.csv", "--json", "c.json").exit_code == 0
    (comparison,) = json.loads(Path("c.json").read_text())["files"]
    assert comparison["signals"]["joint_position"]["rmse"] < 1e-6


# ---- export --------------------------------------------------------------------------------


def test_export_for_other_platforms_with_sources(run) -> None:
    result = run(
        *("export", MODEL, "-o", "x.fmu", "--fmi", "3.0", "--source"),
        *("--platform", "aarch64-darwin,x86_64-linux", "--platform", "aarch64-linux"),
    )
    assert (result.exit_code, result.stderr) == (0, "")  # no bar where there is no terminal
    assert result.stdout == (
        f"{MODEL} is in x.fmu, FMI 3.0, for x86_64-linux, aarch64-linux, aarch64-darwin\n"
    )
    with zipfile.ZipFile("x.fmu") as archive:
        folders = {name.rpartition("/")[0] for name in archive.namelist()}
    names = ("aarch64-darwin", "x86_64-linux", "aarch64-linux")
    assert folders >= {"sources", *(f"binaries/{name}" for name in names)}


@pytest.mark.parametrize(
    ("option", "value", "known"),
    [("--platform", "amiga", "aarch64-darwin"), ("--fmi", "1", "choose 2 or 3")],
)
def test_export_tells_what_it_knows(run, option, value, known) -> None:
    result = run("export", MODEL, "-o", "x.fmu", option, value)
    assert result.exit_code == 2
    assert value in result.stderr
    assert known in result.stderr
    assert "Value error" not in result.stderr
    assert list(Path().iterdir()) == []


# ---- data that cannot be used, or is not believed ------------------------------------------


@pytest.fixture(scope="module")
def table() -> pd.DataFrame:
    """Ten seconds in which mostly the motor moves the joint, and a small load."""
    model = load_model(MODEL)
    excitation = default_excitation(model)
    inputs = (excitation.motor_position, 0.2 * excitation.load_torque)
    trajectory = simulate(model, excitation.time, *inputs)
    return pd.DataFrame(
        {
            "time_s": excitation.time,
            "motor_position_rad": inputs[0],
            "joint_position_rad": trajectory["joint_position"].round(6),
            "load_torque_Nm": inputs[1],
        }
    )


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


# ---- how data is read, and read again ------------------------------------------------------


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


# ---- compare shows and draws ---------------------------------------------------------------


def static_curve(path: str) -> None:
    """A measured characteristic, softer than the model's."""
    deflection = np.concatenate([np.linspace(-0.2, 0.2, 200), np.linspace(0.2, -0.2, 200)])
    torque = 0.9 * characteristic_torque(deflection, load_model(MODEL).transmission)
    columns = {"joint_deflection_rad": deflection, "joint_torque_Nm": torque}
    pd.DataFrame(columns).to_csv(path, index=False)


def test_series_and_static_curve_are_compared_together_with_all_figures(run, table) -> None:
    model = load_model(MODEL).with_values({"link.inertia": 0.04})
    Path("model.toml").write_text(model.to_toml(), "utf-8")
    table.to_csv("run.csv", index=False)
    static_curve("curve.csv")
    result = run(
        "compare", "model.toml", "run.csv", "curve.csv", "--figures", "f", "--json", "c.json"
    )
    assert result.exit_code == 0
    assert "curve.csv beside" in result.stdout
    assert "deflection, mrad" in result.stdout
    files = json.loads(Path("c.json").read_text())["files"]
    assert [file["static"] for file in files] == [False, True]
    names = {path.name for path in Path("f").iterdir()}
    each = ("overlay", "torque_over_deflection", "missing_torque", "joint_position_share_of_error")
    moving = ("error_maps", "joint_position_correlation")
    assert names == {
        *(f"{file}_{figure}.png" for file in ("run", "curve") for figure in each),
        *(f"run_{figure}.png" for figure in moving),
    }
    assert all(path.read_bytes().startswith(b"\x89PNG") for path in Path("f").iterdir())
    assert sorted(path.name for path in Path().iterdir()) == [
        *("c.json", "curve.csv", "f", "model.toml", "run.csv")
    ]


def test_an_exact_static_curve_of_few_rows_is_met(run) -> None:
    deflection = np.linspace(-0.2, 0.2, 12)
    torque = characteristic_torque(deflection, load_model(MODEL).transmission)
    columns = {"joint_deflection_rad": deflection, "joint_torque_Nm": torque}
    for name, order in {"up": slice(None), "down": slice(None, None, -1)}.items():
        pd.DataFrame(columns)[order].to_csv(f"{name}.csv", index=False)
    assert run("compare", MODEL, "up.csv", "down.csv", "--json", "c.json").exit_code == 0
    files = json.loads(Path("c.json").read_text())["files"]
    assert len(files) == 2
    assert all(file["signals"]["joint_position"]["max_abs"] < 1e-5 for file in files)


def test_names_with_dollars_are_drawn_as_they_are(run, recording: str) -> None:
    Path(recording).rename("a$b$c_{.csv")
    model = load_model(MODEL).to_toml().replace(f'name = "{MODEL}"', r'name = "cost $x_{$"')
    Path("model.toml").write_text(model, "utf-8")
    done = run("compare", "model.toml", "a$b$c_{.csv", "--figures", "f", "--plot", "p.svg")
    assert done.exit_code == 0
    assert len(list(Path("f").iterdir())) == 6
    assert run("design", "model.toml").exit_code == 0


def test_figures_replace_nothing_unasked(run, recording: str) -> None:
    assert Path(recording).is_file()
    Path("f").mkdir()
    Path("f/run_overlay.png").write_text("mine")
    refused = run("compare", MODEL, "run.csv", "--figures", "f")
    assert refused.exit_code == 1
    assert "f: the folder is not empty" in only_line(refused)
    assert Path("f/run_overlay.png").read_text() == "mine"
    Path("file").write_text("mine")
    assert "this is a file" in only_line(run("compare", MODEL, "run.csv", "--figures", "file"))
    missing = run("compare", MODEL, "run.csv", "--figures", "no/f")
    assert "there is no folder no" in only_line(missing)
    assert run("compare", MODEL, "run.csv", "--figures", "f", "--force").exit_code == 0
    assert Path("f/run_overlay.png").read_bytes().startswith(b"\x89PNG")


def test_all_bins_shows_more_and_80_columns_suffice(run, recording: str) -> None:
    shown = {}
    for options in ((), ("--all-bins",)):
        result = run("compare", MODEL, recording, *options, columns="80")
        assert result.exit_code == 0
        assert "…" not in result.stdout
        assert max(len(line) for line in result.stdout.splitlines()) <= 80
        shown[options] = result.stdout
    assert "Joint position: " in shown[()]
    assert len(shown["--all-bins",].splitlines()) > len(shown[()].splitlines())


@pytest.mark.parametrize("effect", CATALOGUE, ids=lambda effect: effect.id)
def test_add_writes_json_whatever_the_effect(run, recording: str, effect) -> None:
    """A short stretch suffices: the numbers mean little, but there are all kinds of them."""
    result = run(
        *("add", MODEL, effect.id, f"{recording}[0:0.4]"),
        *("-o", "new.toml", "--json", "a.json"),
    )
    assert result.exit_code == 0, result.stderr
    content = json.loads(Path("a.json").read_text())
    assert content["effects"] == [effect.id]
    assert [step["added"] for step in content["ladder"]] == [None, None, effect.id]
    fitted = {estimate["path"]: estimate for estimate in content["parameters"]}
    assert {
        f"effects.{effect.id}.{parameter.name}" for parameter in effect.parameters
    } <= fitted.keys()
    assert {type(estimate["determined"]) for estimate in fitted.values()} == {bool}
    assert content["model"]["effects"].keys() == {effect.id}
