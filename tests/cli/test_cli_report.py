"""The option --report of compare and diagnose: what it writes, and what it refuses beforehand."""

from pathlib import Path

import pytest
from typer.testing import CliRunner

import elastic_tendon as et
from elastic_tendon import cli, demo
from hand_made_diagnosis import friction_found

MODEL = str(demo.DATA / "demo_model.toml")
FITTED, JUDGE = (str(demo.DATA / f"demo_{role}.csv") for role in ("fit", "validate"))


@pytest.fixture
def run(monkeypatch, tmp_path: Path):
    """Call a command in an empty folder; the diagnosis is made beforehand."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(et, "diagnose", lambda *_given, **_options: friction_found())
    return lambda *words: CliRunner().invoke(cli.app, list(words), env={"COLUMNS": "80"})


def files() -> list[str]:
    return sorted(path.name for path in Path().iterdir())


def test_a_comparison_is_a_page(run, monkeypatch) -> None:
    words = ("compare", MODEL, FITTED, "--report", "page.html")
    monkeypatch.setattr("sys.argv", ["elastic-tendon", *words])
    done = run(*words)
    assert done.exit_code == 0, done.output
    assert done.stdout.rstrip().endswith("The report is page.html.")
    text = Path("page.html").read_text(encoding="utf-8")
    assert text.startswith("<!DOCTYPE html>")
    assert f"elastic-tendon compare {MODEL}" in text


def test_a_diagnosis_is_a_page_with_what_to_do_next(run) -> None:
    done = run(
        *("diagnose", MODEL, FITTED, "--validate", JUDGE),
        *("--report", "page.html", "--save-model", "better.toml"),
    )
    assert done.exit_code == 0, done.output
    assert files() == ["better.toml", "page.html"]
    text = Path("page.html").read_text(encoding="utf-8")
    assert "elastic-tendon export better.toml -o better.fmu" in text
    for name, purpose in (("fit", "fitted"), ("validate", "held-out")):
        row = text[text.index(f"demo_{name}.csv</th>\n<td>{purpose}") :]
        assert "samples" not in row[:20]
    assert "The report is page.html." in done.stdout


@pytest.mark.parametrize("command", ["compare", "diagnose"])
def test_what_cannot_be_written_is_refused_before_the_work(run, monkeypatch, command: str) -> None:
    monkeypatch.setattr(et, "diagnose", lambda *_given, **_options: pytest.fail("worked"))
    Path("old.html").write_text("kept")
    for name, words in (
        ("page.pdf", "page.pdf: a report is a page for a browser; let its name end in .html"),
        ("old.html", "old.html: the file exists already"),
        ("nowhere/page.html", "there is no folder nowhere"),
    ):
        done = run(command, MODEL, FITTED, "--report", name)
        assert done.exit_code == 1
        assert words in " ".join(done.stderr.split())
        assert "Traceback" not in done.output
    assert Path("old.html").read_text() == "kept"
    assert files() == ["old.html"]


def test_two_outputs_need_two_names(run) -> None:
    done = run("diagnose", MODEL, FITTED, "--report", "one.html", "--json", "one.html")
    assert done.exit_code == 2
    assert "two outputs have the same name" in done.stderr


def test_a_page_that_exists_is_replaced_when_asked(run) -> None:
    Path("page.html").write_text("old")
    assert run("compare", MODEL, FITTED, "--report", "page.html", "--force").exit_code == 0
    assert Path("page.html").read_text(encoding="utf-8").startswith("<!DOCTYPE html>")
