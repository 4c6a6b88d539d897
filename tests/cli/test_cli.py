"""The command line: exit status, one line for what is wrong, nothing overwritten unasked."""

import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from command_line import MODEL, only_line
from elastic_tendon import cli
from elastic_tendon.effects import CATALOGUE


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
