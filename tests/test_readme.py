"""The README's commands and code, run in order in an empty folder as a newcomer would."""

import os
import re
import signal
import subprocess
import sys
import urllib.request
from pathlib import Path

from elastic_tendon import load_model
from elastic_tendon.measurement.preparation import read_preparations

ROOT = Path(__file__).parents[1]
APP = "elastic-tendon app "  # it runs until it is stopped
PATIENCE = 120.0  # s
BLOCK = re.compile(r"^```(sh|python|toml)\n(.*?)^```", re.MULTILINE | re.DOTALL)


def _blocks() -> list[tuple[str, str]]:
    return [(kind, text) for kind, text in BLOCK.findall((ROOT / "README.md").read_text())]


def _environment() -> dict[str, str]:
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    # "true" is asked to open the page, and does nothing
    return os.environ | {"PATH": path, "MPLBACKEND": "Agg", "BROWSER": "true"}


def test_tour_runs_as_printed(tmp_path):
    ran = 0
    for kind, text in _blocks():
        if kind == "toml":
            continue  # see below
        if text.startswith("pip install"):
            continue  # the set-up commands, which .ci/run runs
        if text.startswith(APP):
            continue  # see below
        command = ["bash", "-ec", text] if kind == "sh" else [sys.executable, "-c", text]
        run = subprocess.run(
            command,
            cwd=tmp_path,
            env=_environment(),
            capture_output=True,
            text=True,
            check=False,
        )
        assert run.returncode == 0, f"{text}\n{run.stdout}\n{run.stderr}"
        ran += 1
    assert ran >= 6


def test_app_starts_as_printed(tmp_path):
    (command,) = (text for _, text in _blocks() if text.startswith(APP))
    process = subprocess.Popen(
        ["bash", "-ec", f"exec {command}"],
        cwd=tmp_path,
        env=_environment(),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        url = re.search(r"http\S+", process.stdout.readline())
        assert url is not None
        with urllib.request.urlopen(url.group(), timeout=PATIENCE) as answer:
            assert "elastic-tendon" in answer.read().decode()
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=PATIENCE)
    finally:
        process.kill()
    assert (process.returncode, errors) == (0, "")


def test_model_and_preparation_are_accepted(tmp_path):
    model, preparation = (text for kind, text in _blocks() if kind == "toml")
    for name, text in (("my_joint.toml", model), ("recording.csv.toml", preparation)):
        (tmp_path / name).write_text(text)
    assert load_model(tmp_path / "my_joint.toml").name == "my_joint"
    (read,) = read_preparations(tmp_path / "recording.csv.toml", "recording.csv")
    assert read.columns["joint_position"].unit == "deg"


def test_pictures_exist():
    pictures = re.findall(r"!\[.*?\]\((.*?)\)", (ROOT / "README.md").read_text())
    assert pictures
    assert all((ROOT / picture).is_file() for picture in pictures)


def test_links_lead_somewhere_and_it_is_short():
    text = (ROOT / "README.md").read_text()
    links = re.findall(r"\]\(([^)]*?)\)", text)
    assert len(links) > 10
    assert all((ROOT / link).exists() for link in links)
    assert len(text.splitlines()) < 200
