"""What a command reads is never replaced by what it writes, not even with --force."""

import shutil
from pathlib import Path

import pytest
from typer.testing import CliRunner

from elastic_tendon import cli
from elastic_tendon.demo import DATA

READ = ("model.html", "rec.csv", "judge.csv")


@pytest.fixture
def folder(monkeypatch, tmp_path: Path) -> Path:
    """A folder with a model, under a name that a report may have, and two recordings."""
    sources = ("demo_model.toml", "demo_fit.csv", "demo_validate.csv")
    for source, name in zip(sources, READ, strict=True):
        shutil.copy(DATA / source, tmp_path / name)
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize(
    "words",
    [
        "compare model.html rec.csv --json rec.csv",
        "compare model.html rec.csv[1:3] --json ./rec.csv",
        "compare model.html rec.csv --report model.html",
        "simulate model.html rec.csv -o rec.csv",
        "simulate model.html -o model.html",
        "add model.html coulomb_friction rec.csv --validate judge.csv -o new.toml --json judge.csv",
        "add model.html coulomb_friction -o model.html",
        "diagnose model.html rec.csv --validate judge.csv --json judge.csv",
        "diagnose model.html rec.csv --save-model model.html",
        "linearise model.html --json model.html",
    ],
)
def test_what_is_read_is_never_replaced(folder: Path, words: str) -> None:
    before = {name: (folder / name).read_bytes() for name in READ}
    result = CliRunner().invoke(cli.app, [*words.split(), "--force"])
    assert result.exit_code == 2
    assert "is read; give the output another name" in " ".join(result.stderr.split())
    assert {name: (folder / name).read_bytes() for name in READ} == before


@pytest.mark.parametrize("words", ["compare model.html rec.csv --json y.html --report ./y.html"])
def test_two_outputs_have_two_names(folder: Path, words: str) -> None:
    result = CliRunner().invoke(cli.app, words.split())
    assert result.exit_code == 2
    assert "two outputs have the same name" in " ".join(result.stderr.split())
    assert sorted(path.name for path in folder.iterdir()) == sorted(READ)
