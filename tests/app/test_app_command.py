"""The command that starts the app: what it prints, and how it ends."""

import os
import re
import signal
import subprocess
import sys
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.abc import MetaPathFinder
from pathlib import Path

import pytest
from typer.testing import CliRunner

from elastic_tendon import cli

RECORDING = "time_s,motor_position_rad,joint_position_rad\n" + "".join(
    f"{i / 100},{i / 1000},{i / 1001}\n" for i in range(50)
)


@pytest.fixture
def run(monkeypatch, tmp_path: Path):
    monkeypatch.chdir(tmp_path)
    return lambda *arguments: CliRunner().invoke(cli.app, ["app", "--no-browser", *arguments])


@contextmanager
def started(folder: Path, *arguments: str) -> Iterator[tuple[subprocess.Popen[str], str]]:
    """The app as a process of its own, and its URL."""
    command = [sys.executable, "-m", "elastic_tendon", "app", "--no-browser", *arguments]
    process = subprocess.Popen(
        command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    try:
        assert process.stdout is not None
        url = re.search(r"http\S+", process.stdout.readline())
        assert url is not None
        yield process, url.group()
    finally:
        process.kill()
        process.communicate()


def test_it_prints_a_url_that_is_answered_and_ends_on_interrupt(tmp_path: Path) -> None:
    (tmp_path / "run.csv").write_text(RECORDING)
    with started(tmp_path, "biorob_x4_joint_3", "run.csv[0.1:0.4]") as (process, url):
        with urllib.request.urlopen(url, timeout=60) as answer:
            assert "elastic-tendon" in answer.read().decode()
        assert process.stdout is not None
        assert process.stdout.readline() == "Ctrl-C ends it.\n"
        os.kill(process.pid, signal.SIGINT)
        _, errors = process.communicate(timeout=60)
    assert (process.returncode, errors) == (0, "")


def test_other_machines_come_in_only_where_it_was_said(tmp_path: Path) -> None:
    with started(tmp_path) as (_, url):
        assert url.startswith("http://127.0.0.1:")
    with started(tmp_path, "--open-to-the-network", "127.0.0.2") as (process, url):
        assert url.startswith("http://127.0.0.2:")
        os.kill(process.pid, signal.SIGINT)
        _, errors = process.communicate(timeout=60)
    assert "not encrypted" in errors


def test_the_demo_brings_its_own_data(run) -> None:
    result = run("--demo", "biorob_x4_joint_3")
    assert result.exit_code == 2
    assert "leave yours out" in result.stderr


def test_a_model_that_is_not_there_is_told_at_once(run) -> None:
    result = run("nowhere.toml")
    assert result.exit_code == 1
    assert result.stderr.startswith("elastic-tendon: nowhere.toml: there is no such file")


def test_without_its_packages_it_says_what_to_install(run, monkeypatch) -> None:
    class NoDash(MetaPathFinder):
        def find_spec(self, name: str, *_rest: object) -> None:
            if name == "dash":
                raise ModuleNotFoundError("No module named 'dash'", name="dash")

    for name in [name for name in sys.modules if name.split(".")[0] == "dash"]:
        monkeypatch.delitem(sys.modules, name)
    for name in [name for name in sys.modules if name.startswith("elastic_tendon.app")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setattr(sys, "meta_path", [NoDash(), *sys.meta_path])
    result = run()
    assert result.exit_code == 1
    expected = 'the app needs dash, which is not installed; pip install "elastic-tendon[app]"'
    assert expected in " ".join(result.stderr.split())
