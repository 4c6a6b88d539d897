"""The command sweep: what it does in each run, what it refuses, and how it goes on."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

from elastic_tendon import cli, demo
from elastic_tendon.actuator.parameters import load_model
from elastic_tendon.simulation.excitation import default_excitation
from elastic_tendon.simulation.simulate import simulate
from elastic_tendon.sweeps.parts import folder_of

BUNDLED = "biorob_x4_joint_3"
MODEL = str(demo.DATA / "demo_model.toml")
RECORDING = str(demo.DATA / "demo_fit.csv")
INERTIA = "link.inertia"
PATIENCE = 60.0  # s


@pytest.fixture
def run(monkeypatch, tmp_path: Path):
    """Call the command in an empty folder."""
    monkeypatch.chdir(tmp_path)

    def run(*words: str):
        arguments = ["sweep", *words]
        return CliRunner().invoke(cli.app, arguments, env={"COLUMNS": "80"})

    return run


def _one_line(result) -> str:
    """The only line of an error."""
    assert "Traceback" not in result.output
    (line,) = result.stderr.strip().splitlines()
    return line


# ---- simulations ---------------------------------------------------------------------------


def test_a_grid_of_simulations_is_what_simulate_gives(run):
    done = run(BUNDLED, "-o", "runs.csv", "--vary", f"{INERTIA}=0.02,0.04", "--keep", "deflection")
    assert done.exit_code == 0, done.output
    assert "2 runs in runs.csv." in done.stdout
    table = pd.read_csv("runs.csv")
    model = load_model(BUNDLED)
    motion = default_excitation(model)
    for inertia, highest in zip(table[INERTIA], table["deflection.maximum_rad"], strict=True):
        alone = simulate(
            model.with_values({INERTIA: inertia}),
            *(motion.time, motion.motor_position, motion.load_torque),
            as_measured=True,
        )
        assert highest == pytest.approx(alone["deflection"].max(), rel=1e-14)


def test_the_table_on_the_terminal_says_what_varied_and_what_came_of_it(run):
    done = run(BUNDLED, "-o", "runs.csv", "--vary", f"{INERTIA}=0.02:0.04:3")
    lines = [line.split() for line in done.stdout.splitlines()]
    assert ["link.inertia,", "kg·m²", "0.02", *lines[lines.index(["joint", "position"]) - 2][3:]]
    assert ["joint", "position"] in lines
    assert any(line[:2] == ["share", "III"] for line in lines)
    assert max(map(len, done.stdout.splitlines())) <= 80


def test_stated_uncertainties_are_drawn_where_nothing_is_said(run):
    text = load_model(BUNDLED).to_toml() + f'\n[uncertainty]\n"{INERTIA}" = 0.1\n'
    Path("model.toml").write_text(text)
    done = run("model.toml", "-o", "runs.csv", "--runs", "400", "--seed", "3")
    assert done.exit_code == 0, done.output
    drawn = pd.read_csv("runs.csv")[INERTIA]
    assert len(drawn) == 400
    nominal = load_model(BUNDLED).link.inertia
    assert drawn.mean() == pytest.approx(nominal, rel=0.02)
    assert drawn.std() == pytest.approx(0.1 * nominal, rel=0.15)


def test_a_recording_drives_the_runs_and_tells_their_errors(run):
    done = run(MODEL, RECORDING, "-o", "runs.csv", "--vary", "link.damping=0.1:0.3:5")
    assert done.exit_code == 0, done.output
    table = pd.read_csv("runs.csv")
    assert table["joint_position.rms_error_rad"].between(1e-3, 0.1).all()
    assert "rms error, rad" in done.stdout


def test_the_same_seed_gives_the_same_file_with_any_number_of_workers(run):
    words = (BUNDLED, "--vary", f"{INERTIA}=20%", "--method", "sobol", "--runs", "64")
    for workers in ("1", "2"):
        assert run(*words, "-o", f"{workers}.csv", "--workers", workers).exit_code == 0
    run(*words, "-o", "other.csv", "--seed", "1")
    first = Path("1.csv").read_bytes()
    assert first == Path("2.csv").read_bytes()
    assert first != Path("other.csv").read_bytes()


def test_runs_that_fail_are_told_and_the_others_are_done(run):
    done = run(BUNDLED, "-o", "runs.csv", "--vary", "transmission.pretension_force=80,1e5")
    assert done.exit_code == 0, done.output
    assert "1 of 2 runs failed" in done.stderr
    assert "like run 1: transmission.pretension_force" in done.stderr
    failures = pd.read_csv("runs.csv", keep_default_na=False)["failure"]
    assert [bool(failure) for failure in failures] == [False, True]


def test_where_every_run_fails_the_exit_status_says_so(run):
    done = run(BUNDLED, "-o", "runs.csv", "--vary", "transmission.pretension_force=1e5,2e5")
    assert done.exit_code == 1
    assert Path("runs.csv").exists()


def test_trajectories_hold_every_sample(run):
    done = run(BUNDLED, "-o", "t.parquet", "--vary", f"{INERTIA}=0.02,0.04", "--trajectories")
    assert done.exit_code == 0, done.output
    table = pd.read_parquet("t.parquet")
    samples = len(default_excitation(load_model(BUNDLED)).time)
    assert table.groupby("run").size().tolist() == [samples, samples]
    assert {"time_s", "joint_position_rad", "joint_torque_Nm"} < set(table.columns)


@pytest.mark.parametrize("kept", [(), ("--trajectories",)])
def test_simulations_are_drawn(run, kept):
    words = ("--vary", f"{INERTIA}=0.02,0.04", "--plot", "s.png", *kept)
    done = run(BUNDLED, "-o", "s.parquet", *words)
    assert done.exit_code == 0, done.output
    assert Path("s.png").stat().st_size > 10_000


def test_nothing_is_drawn_where_all_runs_failed(run):
    words = ("--vary", "transmission.pretension_force=1e5,2e5", "--plot", "s.png")
    done = run(BUNDLED, "-o", "s.csv", *words)
    assert done.exit_code == 1
    assert "there is nothing to draw" in done.stderr
    assert not Path("s.png").exists()


def test_more_runs_are_added_to_a_finished_table(run):
    words = (BUNDLED, "--vary", f"{INERTIA}=20%", "--method", "sobol")
    for runs in ("32", "64"):
        assert run(*words, "-o", "runs.csv", "--runs", runs).exit_code == 0
    assert run(*words, "-o", "whole.csv", "--runs", "64").exit_code == 0
    assert Path("runs.csv").read_bytes() == Path("whole.csv").read_bytes()
    assert "exists already" in _one_line(run(*words, "-o", "runs.csv", "--runs", "64"))


def test_shares_are_joined(run):
    words = (BUNDLED, "-o", "runs.csv", "--vary", f"{INERTIA}=20%", "--runs", "20")
    done = run(*words, "--shard", "2/2")
    assert "Share 2/2 is done, 0 failed" in done.stdout
    assert "the first of them runs 0 to 9" in _one_line(run(*words, "--join"))
    assert run(*words, "--shard", "1/2").exit_code == 0
    assert run(*words, "--join").exit_code == 0
    assert pd.read_csv("runs.csv")["run"].tolist() == list(range(20))
    assert "write K/N" in run(*words, "--shard", "3").output


# ---- refits and diagnoses ------------------------------------------------------------------


def test_refits_give_intervals(run):
    done = run(MODEL, f"{RECORDING}[0:4]", "-o", "fits.csv", "--do", "fit", "--runs", "40")
    assert done.exit_code == 0, done.output
    assert "by refits" in done.stdout
    inertia = pd.read_csv("fits.csv")[INERTIA]
    assert len(inertia) == 40
    assert 0.0 < inertia.std() < 0.1 * inertia.mean()


def test_a_fleet_is_one_table(run):
    rows = Path(RECORDING).read_text().splitlines()[:2001]
    Path("anna.csv").write_text("\n".join(rows) + "\n")
    Path("bert.csv").write_text("time_s,motor_position_rad\n0,0\n")
    words = ("-o", "fleet.csv", "--do", "diagnose", "--plot", "fleet.png", "--about", "known.csv")
    Path("known.csv").write_text("robot,hours\nanna,5\n")
    refused = run(MODEL, "anna.csv", "bert.csv", *words)
    assert "no row for bert; add it" in refused.stderr
    assert not Path("fleet.csv").exists()
    Path("known.csv").write_text("robot,hours\nanna,5\nbert,\n")
    done = run(MODEL, "anna.csv", "bert.csv", *words)
    assert done.exit_code == 0, done.output
    assert Path("fleet.png").stat().st_size > 10_000
    assert done.stdout.startswith("coulomb_friction appeared: 1 robot (anna), torque 0.")
    assert "times noise" in done.stdout
    assert "1 of 2 runs failed" in done.stderr
    table = pd.read_csv("fleet.csv", keep_default_na=False)
    assert table["robot"].tolist() == ["anna", "bert"]
    assert "joint_position" in table["failure"][1]


# ---- wrong usage ---------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--vary", "link.inertias"], "did you mean link.inertia"),
        (["--vary", f"{INERTIA}=a:b"], "is not a number"),
        (["--vary", f"{INERTIA}=-1:1"], "outside"),
        (["--vary", f"{INERTIA}=1:2", "--method", "grid"], "a grid needs values"),
        ([], "nothing that could vary"),
        (["--vary", INERTIA, "--keep", "angle"], "not known"),
        (["--do", "fit"], "needs recordings"),
        (["--do", "diagnose"], "needs recordings"),
        ([RECORDING, "--do", "diagnose", "--runs", "3"], "says nothing"),
        ([RECORDING, "--do", "fit", "--vary", INERTIA], "says nothing"),
        (["--vary", INERTIA, "--about", "known.csv"], "says nothing without a fleet"),
        ([RECORDING, "--do", "fit", "--runs", "10"], "needs 39 refits"),
        ([RECORDING, RECORDING, "--vary", INERTIA], "one motion"),
        (["--vary", INERTIA, "--interpolation", "cubic"], "leave --interpolation out"),
        (["--vary", INERTIA, "--runs", "5", "--method", "grid"], "--method and --runs"),
        (["--vary", INERTIA, "--workers", "2", "--scheduler", "tcp://a:1"], "of its own"),
    ],
)
def test_wrong_usage_is_told_before_anything_is_written(run, words, told):
    done = run(BUNDLED, "-o", "runs.csv", *words)
    assert done.exit_code == 2
    assert told in " ".join(done.output.replace("│", " ").split())
    assert not list(Path().iterdir())


def test_outputs_are_checked_before_the_work(run):
    Path("there.csv").write_text("precious")
    varied = ("--vary", INERTIA)
    exists = run(BUNDLED, "-o", "there.csv", *varied)
    assert exists.exit_code == 1
    assert "exists already" in _one_line(exists)
    assert Path("there.csv").read_text() == "precious"
    unknown = run(BUNDLED, "-o", "runs.xlsx", *varied)
    assert unknown.exit_code == 1
    assert ".parquet" in _one_line(unknown)


def test_a_scheduler_that_is_not_there_is_told_in_one_line(run):
    words = ("--vary", INERTIA, "--scheduler", "tcp://127.0.0.1:9")
    done = run(BUNDLED, "-o", "runs.csv", *words)
    assert done.exit_code == 1
    assert "127.0.0.1:9" in _one_line(done)
    done = run(BUNDLED, "-o", "runs.csv", "--vary", INERTIA, "--scheduler", "host")
    assert done.exit_code == 1
    assert "as tcp://host:8786" in _one_line(done)


# ---- interrupted ---------------------------------------------------------------------------


def test_an_interrupted_sweep_goes_on_with_the_same_command(tmp_path):
    words = [BUNDLED, "-o", "runs.csv", "--vary", f"{INERTIA}=10%", "--runs", "5000"]
    command = [sys.executable, "-m", "elastic_tendon", "sweep", *words]
    settings = {"cwd": tmp_path, "env": os.environ | {"COLUMNS": "80"}, "text": True}
    parts = folder_of(tmp_path / "runs.csv")
    begun = subprocess.Popen(command, stderr=subprocess.PIPE, **settings)
    latest = time.monotonic() + PATIENCE
    while len(list(parts.glob("*.csv"))) < 2 and time.monotonic() < latest:
        time.sleep(0.05)
    begun.send_signal(signal.SIGINT)
    _, told = begun.communicate(timeout=PATIENCE)
    assert begun.returncode == 130, told
    assert "the same command goes on from there" in told
    kept = {path.name: path.stat().st_mtime_ns for path in parts.glob("*.csv")}
    assert len(kept) >= 2
    again = subprocess.run(command, capture_output=True, check=False, **settings)
    assert again.returncode == 0, again.stderr
    assert "of them done before" in again.stdout
    assert not parts.exists()
    runs = pd.read_csv(tmp_path / "runs.csv")["run"]
    np.testing.assert_array_equal(runs, np.arange(5000))
