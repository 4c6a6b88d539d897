"""Commands that hold recordings against a model: simulate, compare, add."""

import json
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import elastic_tendon as et
from command_line import MODEL, RATE, only_line
from effects_at import AT_POSITION
from elastic_tendon import cli
from elastic_tendon.actuator.parameters import load_model
from elastic_tendon.actuator.transmission import characteristic_torque


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
    assert f"{1e3 * signal['max_abs']:#.3g} mrad at " in words
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
    torques = {"joint_torque", "motor_torque"}
    forces = {"upper_spring_force", "lower_spring_force"}
    assert set(file["signals"]) == {"joint_position", *torques, *forces}
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
    words = ("compare", "model.toml", "run.csv", "curve.csv", "--tolerance", "joint_position=1e-9")
    result = run(*words, "--figures", "f", "--json", "c.json")
    assert result.exit_code == 1
    assert "curve.csv beside" in result.stdout
    assert "curve.csv: deflection exceeds the tolerance of" in " ".join(result.stdout.split())
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


@pytest.mark.parametrize("effect", AT_POSITION, ids=lambda effect: effect.id)
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


@pytest.fixture
def driven_by_torque() -> str:
    """A recording of a machine whose motor a torque drives, in the folder of the test."""
    machine = load_model(MODEL).at("torque")
    time = np.arange(0.0, 1.5, 5e-3)
    torque, load = 0.6 * np.sin(5.0 * time), 1.5 * np.sin(3.0 * time)
    moved = et.simulate(machine, time, load_torque=load, motor_torque=torque)
    columns = {
        "time_s": time,
        "motor_position_rad": moved["motor_position"],
        "joint_position_rad": moved["joint_position"],
        "joint_torque_Nm": moved["joint_torque"],
        "load_torque_Nm": load,
        "motor_torque_Nm": torque,
    }
    pd.DataFrame(columns).to_csv("driven.csv", index=False)
    return "driven.csv"


@pytest.mark.parametrize("kind", ["torque", "joint", "torque_joint"])
def test_every_interface_goes_through_the_commands(run, driven_by_torque: str, kind: str) -> None:
    chosen = ("--interface", kind)
    for command in (
        ("simulate", MODEL, "-o", "plain.csv"),
        ("simulate", MODEL, driven_by_torque, "-o", "moved.csv"),
        ("compare", MODEL, driven_by_torque, "--json", "c.json"),
        ("linearise", MODEL),
        ("export", MODEL, "-o", "x.fmu"),
        ("add", MODEL, "spring_hardening", driven_by_torque, "-o", "new.toml"),
    ):
        done = run(*command, *chosen)
        assert done.exit_code == 0, done.output
    (compared,) = json.loads(Path("c.json").read_text())["files"]
    # the model is the machine; only a motor torque is another where the rotor is not computed
    fits = {name: signal["fit_percent"] for name, signal in compared["signals"].items()}
    assert min(fit for name, fit in fits.items() if name != "motor_torque") > 99.0
    assert load_model("new.toml").kind == kind


def test_an_interface_that_there_is_not_is_refused(run, driven_by_torque: str) -> None:
    refused = run("compare", MODEL, driven_by_torque, "--interface", "tork")
    assert refused.exit_code == 1
    assert "should be 'position', 'torque', 'joint', 'torque_joint' or 'load'" in refused.stderr


def test_errors_are_told_where_conditions_hold(run, recording: str) -> None:
    options = ("--where", "joint_velocity>0", "--where", "time=0.5..1.5", "--json", "c.json")
    result = run("compare", MODEL, recording, *options, "--plot", "c.png")
    assert result.exit_code == 0, result.output
    (file,) = json.loads(Path("c.json").read_text())["files"]
    count = file["signals"]["joint_position"]["count"]
    assert 0 < count < file["samples"]
    words = " ".join(result.stdout.split())
    told = f"only where joint_velocity>0 and time=0.5..1.5: {count} of {file['samples']} samples"
    assert told in words
    assert "What is left of the joint position is" in words


@pytest.mark.parametrize(
    ("condition", "status", "says"),
    [
        ("slack_state=5", 2, "a slack state is one of slack_state=I"),
        ("time>99", 1, "no sample of run.csv meets time>99"),
        ("load_torque>0", 1, "run.csv has no load_torque; it has time, slack_state"),
    ],
)
def test_a_condition_that_cannot_hold_is_refused(
    run, recording: str, condition: str, status: int, says: str
) -> None:
    result = run("compare", MODEL, recording, "--where", condition, columns="300")
    assert result.exit_code == status
    assert says in result.stderr
