"""The command diagnose: what it writes, in which order, and what it refuses beforehand."""

import json
import sys
import time
import tomllib
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

import elastic_tendon as et
from elastic_tendon import cli, demo
from elastic_tendon.actuator.parameters import load_model
from elastic_tendon.cli import diagnosis as command
from elastic_tendon.diagnosis.options import Options
from elastic_tendon.effects import BY_ID
from elastic_tendon.errors import MeasurementError
from hand_made_diagnosis import COULOMB, friction_found, nothing_missing, something_unknown

MODEL = str(demo.DATA / "demo_model.toml")
FITTED, JUDGE = (str(demo.DATA / f"demo_{role}.csv") for role in ("fit", "validate"))


@pytest.fixture
def run(monkeypatch, tmp_path: Path):
    """Call the command in an empty folder, with a loop that finds what is given."""
    monkeypatch.chdir(tmp_path)

    def run(*options: str, found=friction_found, loop=None, data=(FITTED,), **settings):
        calls = []

        def diagnose(*arguments, **others):
            calls.append((arguments, others))
            return found() if loop is None else loop(*arguments, **others)

        monkeypatch.setattr(et, "diagnose", diagnose)
        result = CliRunner().invoke(
            *(cli.app, ["diagnose", MODEL, *data, *options]), env={"COLUMNS": "80"}, **settings
        )
        result.calls = calls
        return result

    return run


def files() -> list[str]:
    return sorted(path.name for path in Path().iterdir())


def test_recordings_reach_the_loop_and_the_answer_comes_first(run) -> None:
    done = run("--validate", JUDGE)
    assert done.exit_code == 0, done.output
    ((model, fitted, heldout), others) = done.calls[0]
    assert model == load_model(MODEL)
    assert [recording.name for recording in fitted] == ["demo_fit.csv"]
    assert [recording.name for recording in heldout] == ["demo_validate.csv"]
    assert others["ask"] is None
    assert done.stdout.startswith("Coulomb friction is surely missing")
    order = [
        done.stdout.index(words)
        for words in ("cannot distinguish", "after each step", "does better", "Round 1")
    ]
    assert order == sorted(order)
    assert files() == []


def test_everything_asked_for_is_written(run) -> None:
    done = run(
        *("--save-model", "better.toml", "--json", "d.json", "--figures", "drawn"),
        *("--next-experiment", "next.csv"),
    )
    assert done.exit_code == 0, done.output
    assert files() == ["better.toml", "d.json", "drawn", "next.csv"]
    found = friction_found()
    assert load_model("better.toml") == found.model
    content = json.loads(Path("d.json").read_text())
    assert content["schema"] == "elastic-tendon/diagnosis/2"
    assert content["learned"] is None
    table = pd.read_csv("next.csv")
    assert table["motor_position_rad"].to_numpy() == pytest.approx(
        found.next_experiment.motor_position, abs=1e-6
    )
    assert Path("drawn/ladder_joint_position.png").read_bytes().startswith(b"\x89PNG")
    assert "elastic-tendon export better.toml -o better.fmu" in done.stdout


def test_the_saved_model_says_where_it_comes_from(run) -> None:
    assert run("--save-model", "better.toml", "--validate", JUDGE).exit_code == 0
    text = Path("better.toml").read_text(encoding="utf-8")
    head = text[: text.index("name =")]
    assert all(line.startswith("#") for line in head.strip().splitlines())
    for words in ("fitted: demo_fit.csv", "held out: demo_validate.csv", "coulomb_friction"):
        assert words in head
    assert "Added: Coulomb friction, torque 0.3" in head
    assert tomllib.loads(text)["uncertainty"]["link.inertia"] > 0.0


def test_names_of_files_cannot_break_the_comments(run, monkeypatch) -> None:
    odd = "od\nd\udcff.csv"
    monkeypatch.setattr(sys, "argv", ["elastic-tendon", "diagnose", odd])
    assert run("--save-model", "better.toml").exit_code == 0
    assert load_model("better.toml") == friction_found().model


def test_a_learned_term_is_written_beside_the_model(run) -> None:
    done = run("--save-model", "better.toml", "--json", "d.json", found=something_unknown)
    assert done.exit_code == 0, done.output
    assert files() == ["better.toml", "better_learned.py", "d.json"]
    assert "EFFECT = Effect(" in Path("better_learned.py").read_text()
    assert json.loads(Path("d.json").read_text())["learned"]["file"] == "better_learned.py"
    assert "--effect better_learned.py" in done.stdout
    assert "learned_torque" not in BY_ID  # it is offered, not added


def test_without_a_proposal_no_experiment_is_written_and_that_is_said(run) -> None:
    done = run("--next-experiment", "next.csv", found=nothing_missing)
    assert done.exit_code == 0
    assert "no experiment is proposed, so next.csv was not written" in done.stderr
    assert files() == []


@pytest.mark.parametrize(
    ("option", "name", "taken"),
    [
        ("--json", "out", "out"),
        ("--save-model", "better.toml", "better.toml"),
        ("--save-model", "better.toml", "better_learned.py"),
        ("--next-experiment", "next.csv", "next.csv"),
        ("--figures", "file", "file"),
    ],
)
def test_nothing_is_overwritten_and_that_is_known_before_the_work(
    run, option: str, name: str, taken: str
) -> None:
    Path(taken).write_text("precious")
    done = run(option, name)
    assert done.exit_code == 1
    assert done.calls == []
    assert done.stdout == ""
    assert len(done.stderr.strip().splitlines()) == 1
    assert taken in done.stderr
    assert Path(taken).read_text() == "precious"


def test_a_recording_is_never_replaced(run) -> None:
    done = run("--json", FITTED, "--force")
    assert done.exit_code == 2
    assert done.calls == []
    assert "give the output another name" in " ".join(done.stderr.split())


def test_two_outputs_of_one_name_are_wrong_usage(run) -> None:
    done = run("--json", "out", "--next-experiment", "./out")
    assert done.exit_code == 2
    assert done.calls == []
    assert "two outputs have the same name" in " ".join(done.stderr.split())


def test_what_the_loop_refuses_is_one_line_and_nothing_is_written(run) -> None:
    def refuse(*_arguments, **_others):
        raise MeasurementError("demo_fit.csv: it is held out but shares samples with itself")

    done = run("--json", "out", loop=refuse)
    assert done.exit_code == 1
    assert done.stderr.strip().splitlines() == [
        "elastic-tendon: demo_fit.csv: it is held out but shares samples with itself"
    ]
    assert files() == []


def test_an_interrupted_diagnosis_is_shown_and_saved(run) -> None:
    done = run("--json", "d.json", found=lambda: friction_found(complete=False))
    assert done.exit_code == cli.INTERRUPTED
    assert " ".join(done.stdout.split()).startswith(friction_found().sentence)
    assert json.loads(Path("d.json").read_text())["complete"] is False


def test_all_candidates_are_shown_on_request(run) -> None:
    assert "Joint stop" not in run().stdout
    assert "Joint stop" in run("--all-candidates").stdout


def test_step_needs_a_terminal(run) -> None:
    done = run("--step")
    assert done.exit_code == 2
    assert done.calls == []
    assert "there is none" in " ".join(done.stderr.split())


@pytest.mark.parametrize(("typed", "going_on"), [("y\n", True), ("n\n", False), ("", False)])
def test_step_shows_each_round_and_asks(run, monkeypatch, typed: str, going_on: bool) -> None:
    monkeypatch.setattr(command, "_is_terminal", lambda: True)
    answers = []

    def loop(*_arguments, progress, ask, **_options):
        progress("screening", 0.1)
        answers.append(ask(friction_found().rounds[0]))
        progress("refitting", 0.2)  # the bar is there again
        return friction_found()

    done = run("--step", loop=loop, input=typed)
    assert done.exit_code == 0, done.output
    assert answers == [going_on]
    assert done.stdout.startswith("Round 1: Coulomb friction explains 98 %")


def test_options_of_reading_come_back_in_the_next_commands(run) -> None:
    table = pd.read_csv(FITTED)
    table["joint_position_rad"] = np.rad2deg(table["joint_position_rad"])
    table.rename(columns={"joint_position_rad": "q2"}).to_csv("odd.csv", index=False)
    mapping = "joint_position=q2:deg"
    done = run("--map", mapping, "--next-experiment", "n.csv", data=("odd.csv",))
    assert done.exit_code == 0, done.output
    assert f"odd.csv new_recording.csv --map {mapping}" in done.stdout


def test_what_is_asked_of_the_search_reaches_it_and_comes_back(run) -> None:
    done = run(
        *("--only", COULOMB, "--without", "gear_backlash", "--without", "spring_mass"),
        *("--relevance", "5%", "--horizon", "0.5", "--time-limit", "60"),
        *("--next-experiment", "n.csv"),
    )
    assert done.exit_code == 0, done.output
    options = done.calls[0][1]["options"]
    assert options == Options(
        only=(COULOMB,),
        without=("gear_backlash", "spring_mass"),
        relevance=0.05,
        horizon=0.5,
        time_limit=60.0,
    )
    again = f"--only {COULOMB} --without gear_backlash --without spring_mass --relevance 5%"
    assert f"new_recording.csv {again} --horizon 0.5" in done.stdout


def test_noise_that_is_known_is_that_of_all_recordings(run) -> None:
    done = run("--noise", "joint_position=0.2mrad", "--validate", JUDGE)
    assert done.exit_code == 0, done.output
    (_, fitted, heldout), _ = done.calls[0]
    for recording in (*fitted, *heldout):
        floor = recording.noise["joint_position"]
        assert (floor.sigma, floor.source) == (pytest.approx(2e-4), "given")
    missing = run("--noise", "joint_torque=0.1Nm")
    assert missing.exit_code == 1
    assert missing.calls == []
    assert "no recording holds this signal" in " ".join(missing.stderr.split())


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (("--noise", "joint_position"), "write SIGNAL=SIZE"),
        (("--noise", "joint_position=1mrad", "--noise", "joint_position=2mrad"), "noise twice"),
        (("--relevance", "5 percent"), "write a share from 0 to below 1"),
        (("--relevance", "200%"), "write a share from 0 to below 1"),
        (("--horizon", "0"), "above 0"),
        (("--time-limit", "nan"), "above 0"),
    ],
)
def test_options_that_mean_nothing_are_wrong_usage(run, options, told: str) -> None:
    done = run(*options)
    assert done.exit_code == 2
    assert done.calls == []
    assert told in " ".join(done.stderr.replace("│", " ").split())


@pytest.mark.parametrize("option", ["--only", "--without"])
def test_an_effect_that_does_not_exist_is_one_line(run, option: str) -> None:
    done = run(option, "magic")
    assert done.exit_code == 1
    assert done.calls == []
    assert "there is no effect 'magic'" in done.stderr


def test_a_time_limit_that_ends_the_search_is_no_failure(run) -> None:
    def stopped():
        time.sleep(0.01)
        return friction_found(complete=False)

    assert run("--time-limit", "0.005", found=stopped).exit_code == 0
    assert run("--time-limit", "60", found=stopped).exit_code == cli.INTERRUPTED
