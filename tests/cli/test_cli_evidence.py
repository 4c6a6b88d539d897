"""export --with-evidence, and verify at another place."""

import json
import shutil
import zipfile
from pathlib import Path

import pytest
from typer.testing import CliRunner

from elastic_tendon import cli
from elastic_tendon.demo import DATA
from made_soon import not_optimised


def _run(words: str):
    return CliRunner().invoke(cli.app, words.split())


@pytest.fixture(scope="module")
def exported(tmp_path_factory) -> Path:
    """Folder with an FMU, its model and its recording."""
    folder = tmp_path_factory.mktemp("alices_machine")
    for name in ("demo_model.toml", "demo_fit.csv"):
        shutil.copy(DATA / name, folder / name)
    words = (
        f"export {folder}/demo_model.toml -o {folder}/x.fmu "
        f"--with-evidence {folder}/demo_fit.csv[0:2]"
    )
    with not_optimised(), pytest.MonkeyPatch.context() as patch:
        patch.setattr("sys.argv", ["elastic-tendon", *words.split()])
        result = _run(words)
    assert result.exit_code == 0, result.output
    assert "verdict: no diagnosis was given" in result.output
    return folder


def test_verify_says_it_in_five_lines(exported, monkeypatch, tmp_path) -> None:
    monkeypatch.chdir(tmp_path)
    shutil.copy(exported / "x.fmu", "y.fmu")
    result = _run("verify y.fmu --json y.json")
    assert result.exit_code == 0, result.output
    assert len(result.stdout.splitlines()) == 5
    assert json.loads(Path("y.json").read_text())["passed"] is True
    whole = bytearray(Path("y.fmu").read_bytes())
    whole[5000] ^= 1
    Path("y.fmu").write_bytes(whole)
    assert _run("verify y.fmu").exit_code == 1


def test_a_planned_motion_that_leaves_the_range_is_told(exported) -> None:
    result = _run(f"verify {exported}/x.fmu --inputs {exported}/demo_fit.csv")
    assert result.exit_code == 1
    assert "leave the range of validity" in result.stdout


def test_a_planned_motion_is_read_as_it_is_mapped(exported, tmp_path) -> None:
    planned = tmp_path / "planned.csv"
    rows = "".join(f"{i / 50},{-0.6 * i}\n" for i in range(51))
    planned.write_text(f"time_s,angle\n{rows}")
    words = f"verify {exported}/x.fmu --inputs {planned}"
    refused = _run(words)
    assert refused.exit_code == 1
    assert "--map motor_position=COLUMN" in refused.output
    result = _run(f"{words} --map motor_position=angle:deg")
    assert "planned inputs: " in result.stdout
    assert "motor_position from" not in result.stdout  # 30 rad would leave the range


def test_the_command_is_kept_without_folders(exported) -> None:
    with zipfile.ZipFile(exported / "x.fmu") as archive:
        (name,) = (one for one in archive.namelist() if one.endswith("evidence.json"))
        told = json.loads(archive.read(name))["provenance"]["command"]
    wanted = "export demo_model.toml -o x.fmu --with-evidence 'demo_fit.csv[0:2]'"
    assert told == f"elastic-tendon {wanted}"


@pytest.mark.parametrize(
    ("words", "status", "told"),
    [
        ("export biorob_x4_joint_3 -o x.fmu --sign key.pem", 2, "name a recording"),
        ("export biorob_x4_joint_3 -o x.fmu --diagnosis f.json", 2, "name a recording"),
        ("export biorob_x4_joint_3 -o x.fmu --with-evidence a.csv --evidence some", 2, "hashes"),
        ("verify absent.fmu", 1, "absent.fmu: cannot be read"),
        ("verify x.fmu --importer none", 2, "libcosim"),
    ],
)
def test_wrong_use_is_said(words, status, told, monkeypatch, tmp_path) -> None:
    monkeypatch.chdir(tmp_path)
    result = _run(words)
    assert (result.exit_code, "Traceback" in result.output) == (status, False)
    assert told in result.output
    assert not list(tmp_path.iterdir())
