"""The command `linearise`: what it shows, writes and refuses."""

import json
from pathlib import Path

import pytest
import tomli_w
from scipy.io import loadmat
from typer.testing import CliRunner

from elastic_tendon import cli
from elastic_tendon.actuator.parameters import load_model
from elastic_tendon.fmu.export import export_fmu

MODEL = "biorob_x4_joint_3"
SLACK = str(80.0 / (0.03 * 2 * 11580.0))  # rad, (36)


@pytest.fixture
def run(monkeypatch, tmp_path: Path):
    """Call the command in an empty folder; both streams come back apart."""
    monkeypatch.chdir(tmp_path)
    runner = CliRunner()

    def run(*arguments: str, columns: str = "100"):
        return runner.invoke(cli.app, ["linearise", *arguments], env={"COLUMNS": columns})

    return run


@pytest.fixture
def rough(tmp_path: Path) -> str:
    """The bundled arm with dry friction and a damped spring."""
    model = load_model(MODEL).with_effect("coulomb_friction", {"torque": 0.3})
    model = model.with_values({"transmission.upper_spring.damping": 3.0})
    path = tmp_path / "rough.toml"
    path.write_text(tomli_w.dumps(model.model_dump(exclude_none=True)))
    return str(path)


def row(text: str, label: str) -> list[str]:
    (line,) = [line for line in text.splitlines() if line.strip().startswith(label)]
    return line.strip().removeprefix(label).split()


def assert_refused(result, status: int, *words: str) -> None:
    """Told on stderr, nothing on stdout, no traceback."""
    assert result.exit_code == status
    assert result.stdout == ""
    told = " ".join(result.stderr.replace("│", " ").split())
    for word in words:
        assert word in told
    assert "Traceback" not in told


def test_all_states_are_shown_each_where_it_is_active(run) -> None:
    result = run(MODEL)
    assert result.exit_code == 0
    assert row(result.stdout, "tendons' stiffness (N·m/rad)") == ["20.84", "20.84", "41.69"]
    assert row(result.stdout, "active there") == ["yes", "yes", "yes"]
    assert "spans 26.4 to 37.3 rad/s, a factor 1.41" in " ".join(result.stdout.split())
    assert result.stderr == ""


def test_files_hold_what_was_selected(run, tmp_path: Path) -> None:
    files = ("--json", "joint.json", "--mat", "joint.mat", "--plot", "joint.png")
    chosen = ("--input", "load_torque", "--output", "joint_velocity", "--output", "deflection")
    result = run(MODEL, "--state", "III", "--state", "I", *files, *chosen)
    assert result.exit_code == 0
    content = json.loads((tmp_path / "joint.json").read_text())
    assert [linear_model["state"] for linear_model in content["models"]] == ["III", "I"]
    assert [output["name"] for output in content["models"][0]["outputs"]] == [
        "joint_velocity",
        "deflection",
    ]
    struct = loadmat("joint.mat", simplify_cells=True)["state_III"]
    assert struct["B"].shape == (2,)  # one input
    assert struct["C"].tolist() == [[0.0, 1.0], [1.0, 0.0]]
    assert (tmp_path / "joint.png").read_bytes().startswith(b"\x89PNG")
    assert "→ joint velocity" in result.stdout
    assert_refused(run(MODEL, "--mat", "joint.mat"), 1, "joint.mat", "exists already", "--force")
    assert run(MODEL, "--mat", "joint.mat", "--force").exit_code == 0


def test_with_an_operating_point_the_active_state_is_shown(run) -> None:
    result = run(MODEL, "--load", "6.5", "--motor-position", "0.2")
    assert result.exit_code == 0
    assert "upper tendon slack" in result.stdout
    assert "both tendons taut" not in result.stdout
    assert row(result.stdout, "load torque") == ["6.5", "N·m"]
    assert row(result.stdout, "motor position") == ["0.2", "rad"]


def test_on_a_boundary_both_sides_are_shown(run) -> None:
    result = run(MODEL, "--deflection", SLACK, "--json", "joint.json")
    assert result.exit_code == 0
    assert row(result.stdout, "tendons' stiffness (N·m/rad)") == ["41.69", "20.84"]
    assert "(upper tendon goes slack): the models of both sides are given." in " ".join(
        result.stdout.split()
    )
    (linear_model,) = json.loads(Path("joint.json").read_text())["models"]
    assert [side["state"] for side in linear_model["sides"]] == ["III", "II"]


def test_friction_slides_unless_it_is_held(run, rough: str) -> None:
    sliding = run(rough, "--state", "III")
    assert "counts as sliding" in sliding.stdout
    assert "--drive position or velocity joins them" in " ".join(sliding.stdout.split())
    sticking = run(rough, "--state", "III", "--mode", "joint_motion=0", "--drive", "velocity")
    assert row(sticking.stdout, "static stiffness (N·m/rad)") == ["inf"]
    moving = run(rough, "--joint-velocity", "0.5")
    assert row(moving.stdout, "joint velocity") == ["0.5", "rad/s"]


def test_an_fmu_says_what_its_model_says(run, tmp_path: Path, rough: str) -> None:
    export_fmu(load_model(rough), tmp_path / "rough.fmu")
    for arguments in (("--state", "I", "--state", "III"), ("--load", "6.0")):
        of_model, of_fmu = run(rough, *arguments), run("rough.fmu", *arguments)
        assert of_fmu.exit_code == 0, of_fmu.stderr
        for label in ("deflection", "poles (rad/s)", "tendons' damping (N·m·s/rad)"):
            assert row(of_fmu.stdout, label) == row(of_model.stdout, label)
    assert_refused(run("rough.fmu", "--mode", "joint_motion=0"), 2, "need a model.toml")
    assert_refused(run("no.fmu"), 1, "no.fmu", "no such file")


def test_the_describing_function_is_drawn(run, monkeypatch) -> None:
    from elastic_tendon.linear import describing_function as module

    few = module.default_amplitudes(load_model(MODEL))[[5, 20, 40]]
    monkeypatch.setattr(module, "default_amplitudes", lambda *_: few)
    result = run(MODEL, "--state", "III", "--describe", "describing.png")
    assert result.exit_code == 0, result.stderr
    assert Path("describing.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--state", "IV"), ("'IV'", "I, II, III, both")),
        (("--drive", "current"), ("'current'", "position, source, torque, velocity")),
        (("--mode", "joint_motion"), ("NAME=VALUE",)),
        (("--mode", "joint_motion=slow"), ("whole number",)),
    ],
)
def test_wrong_usage_names_what_is_allowed(run, arguments, words) -> None:
    assert_refused(run(MODEL, *arguments), 2, *words)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--load", "1", "--deflection", "0.1"), ("deflection follows",)),
        (("--input", "current"), ("no input 'current'", "motor_position")),
        (("--mode", "stop=1"), ("no mode 'stop'", "lower_spring.taut")),
        (("--json", "nowhere/x.json"), ("there is no folder nowhere",)),
        (("--plot", "x.bmp"), ("x.bmp", ".png")),
    ],
)
def test_what_cannot_be_done_is_one_line(run, arguments, words) -> None:
    result = run(MODEL, *arguments)
    assert_refused(result, 1, *words)
    assert result.stderr.count("\n") == 1


def test_a_torque_needs_a_rotor(run, tmp_path: Path) -> None:
    model = load_model(MODEL).model_dump(exclude_none=True)
    model.pop("motor", None)
    (tmp_path / "bare.toml").write_text(tomli_w.dumps(model))
    assert_refused(run("bare.toml", "--drive", "torque"), 1, "[motor]")
