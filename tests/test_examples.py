"""Every example runs and writes the pictures it speaks of."""

import importlib.util
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

# python-control 0.10 makes static gains so; numpy warns since 2.5
SHAPE_OF_GAINS = "ignore:Setting the shape on a NumPy array:DeprecationWarning:control.statesp"
SCRIPTS = Path(__file__).parents[1] / "examples"
EXAMPLES = sorted(SCRIPTS.glob("*/run.py"))
MADE = {  # by those that make their folder: what is in it then
    "arm": {".png"},
    "drive_fmu": {".png"},
    "system_simulation": {".png", ".ssp"},
    "tolerance_study": {".png"},
}


def _check_system_simulation(printed):
    """A tendon goes slack; both simulators of the SSP step alike, so they differ by rounding."""
    assert float(re.search(r"slack for (\d+) ms", printed)[1]) > 0
    apart = [float(one) for one in re.findall(r"joint (\S+) rad from fmpy's", printed)]
    assert len(apart) == (2 if importlib.util.find_spec("ecospy") else 0)
    assert all(one < 1e-12 for one in apart)


def _check_paper_figures(printed):
    """The paper's numbers, and the corners of Fig. 10 found where the protection engages."""
    assert "(36), rad: 0.1151" in printed
    assert "(37), rad: 0.3849" in printed
    assert "(38), N·m/rad: 41.69" in printed
    assert "(39), N·m/rad: 20.84" in printed
    corners = re.search(
        r"static_curve.csv: .*?(0\.\d+) rad.* in both directions.* stiffer", printed
    )
    assert 0.25 < float(corners[1]) < 0.32


def _check_diagnose(printed):
    """The hidden effect is found with the size that the script gave it."""
    found = re.search(r"Added: Gravity load, torque (\S+) ± \S+ N·m, angle (\S+) ±", printed)
    assert abs(float(found[1]) - 0.8) < 0.01
    assert abs(float(found[2]) - 0.3) < 0.01


def _check_controller_design(printed):
    """One state's design fails in slack, the robust one is proven; the FMU does as predicted."""
    damping = {
        (name, state): float(numbers.split()[4])
        for name, state, numbers in re.findall(r"^([a-z ]+?) +(I{1,3}) +(\S.*)$", printed, re.M)
        if len(numbers.split()) == 6
    }
    free = float(re.search(r"^free joint II +(\S+)", printed, re.M)[1])
    assert damping["taut only", "III"] > 3.0 * free > 3.0 * damping["taut only", "II"] > 0.0
    assert min(damping["robust", state] for state in ("I", "II", "III")) > 0.3
    proof = re.search(r"^robust +(\S+) +(\S+)  I.*?quarter of a sample: \S+$", printed, re.M | re.S)
    assert 0.0 < float(proof[1]) < float(proof[2])
    largest = [float(one) for one in re.findall(r": (-?\d\.\d+)", proof[0])]
    assert len(largest) == 4
    assert max(largest) < 0.0
    across = printed[printed.index("III to II") :]
    settled = {
        name: float(re.search(rf"{name} +\S+ +\S+ +(\S+)", across)[1])
        for name in ("taut only", "scheduled", "robust")
    }
    assert settled["taut only"] > 3.0 * max(settled["scheduled"], settled["robust"])
    assert float(re.search(r"FMU and linear model are within (\S+) mrad", printed)[1]) < 1e-6
    cycles = re.findall(r"(?:deflection|FMU:) (\S+) mrad, (\S+) rad/s", printed)
    (amplitude, frequency), (seen, heard) = ((float(a), float(b)) for a, b in cycles)
    assert seen == pytest.approx(amplitude, rel=0.05)
    assert heard == pytest.approx(frequency, rel=0.02)


def _check_tolerance_study(printed):
    """The paper's closed form holds on all machines, to first order too; designs are told apart."""
    moved = dict(re.findall(r"^(deflection|torque) .*?((?: +[+-]\d+\.\d+%){3})$", printed, re.M))
    shares = {
        name: [float(one) for one in re.findall(r"[+-][\d.]+", moved[name])] for name in moved
    }
    assert shares["deflection"] == pytest.approx([-5.0, 0.0, 10.0], abs=0.1)
    assert shares["torque"] == pytest.approx([-2.5, 2.5, 10.0], abs=0.1)
    within = re.findall(r"within (\S+) % of the paper's closed form", printed)
    assert len(within) == 2
    assert max(map(float, within)) < 0.2
    short = float(re.search(r"^(\S+) % of the machines go slack below", printed, re.M)[1])
    assert 4.0 < short < 7.0
    assert float(re.search(r"within (\S+) of those that linearise gives", printed)[1]) < 1e-12
    rows = re.findall(r"^(taut|slack|softer)((?: +\d+\.\d+){5})$", printed, re.M)
    loops = {name: [float(one) for one in numbers.split()] for name, numbers in rows}
    assert loops["taut"][0] == pytest.approx(0.077, abs=0.001)  # as in controller_design
    assert loops["slack"][0] == pytest.approx(0.366, abs=0.001)
    assert loops["taut"][4] == 100.0
    assert 0.0 < loops["slack"][4] < 3.0
    assert loops["softer"][4] == 0.0


def _check_fleet(printed):
    """Of six robots three differ, each in what the script gave it; one log cannot be read."""
    lines = printed.splitlines()
    assert "adequate: 2 robots (ada, emil)" in lines
    assert "not diagnosed: 1 robot (finn)" in lines
    drifted = re.findall(r"^(\S+) drifted: 1 robot \((\w+)\), now (\S+) ", printed, re.M)
    assert {(path, robot) for path, robot, _ in drifted} == {
        ("link.damping", "bela"),
        ("transmission.upper_spring.stiffness", "cora"),
    }
    sizes = {robot: float(size) for _, robot, size in drifted}
    assert sizes == pytest.approx({"bela": 1.6 * 0.16, "cora": 0.85 * 11580.0}, rel=0.01)
    (friction,) = re.findall(
        r"^coulomb_friction appeared: 1 robot \(dora\), torque (\S+) N·m", printed, re.M
    )
    assert float(friction) == pytest.approx(0.3, rel=0.01)
    assert "finn: finn.csv: there is no column joint_position_rad" in printed


def _check_arm(printed):
    """The coupling is of first order, explicit; a step that is told the slopes is always stable."""
    assert 10 < float(re.search(r"stable step, explicit: (\S+) ms", printed)[1]) < 100
    assert "stable step, semi-implicit: any" in printed
    moved = [float(one) for one in re.findall(r"explicit, .* move by (\S+) mrad", printed)]
    assert moved[0] / moved[1] == pytest.approx(2.0, rel=0.1)
    assert moved[1] / moved[2] == pytest.approx(2.0, rel=0.1)
    assert max(float(one) for one in re.findall(r"slack for (\d+) %", printed)) > 20


CHECKS = {
    "arm": _check_arm,
    "controller_design": _check_controller_design,
    "diagnose": _check_diagnose,
    "fleet": _check_fleet,
    "paper_figures": _check_paper_figures,
    "system_simulation": _check_system_simulation,
    "tolerance_study": _check_tolerance_study,
}


def _run(script, folder, *arguments):
    command = [sys.executable, "-W", "error", "-W", SHAPE_OF_GAINS, str(script), *arguments]
    return subprocess.run(
        command,
        cwd=folder,
        env=os.environ | {"MPLBACKEND": "Agg"},
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.mark.parametrize("script", EXAMPLES, ids=lambda script: script.parent.name)
def test_example_runs(script, tmp_path):
    name = script.parent.name
    folder = tmp_path / ("new/folder" if name in MADE else "")
    run = _run(script, tmp_path, str(folder))
    assert run.returncode == 0, run.stdout + run.stderr
    assert run.stdout
    made = {path.suffix for path in folder.iterdir()}
    assert ".png" in made
    assert made == MADE.get(name, made)
    if check := CHECKS.get(name):
        check(run.stdout)


def test_arm_of_fmus_tends_to_that_of_one_process(tmp_path):
    run = _run(SCRIPTS / "arm" / "system.py", tmp_path, str(tmp_path))
    assert run.returncode == 0, run.stdout + run.stderr
    assert (tmp_path / "arm.ssp").is_file()
    apart = [float(one) for one in re.findall(r"joints (\S+) mrad apart", run.stdout)]
    assert apart[0] < 20
    assert apart[0] / apart[1] == pytest.approx(2.0, rel=0.1)
    assert apart[1] / apart[2] == pytest.approx(2.0, rel=0.1)


@pytest.mark.parametrize("name", MADE)
def test_example_says_why_it_cannot_make_its_folder(name, tmp_path):
    script = SCRIPTS / name / "run.py"
    (tmp_path / "file").write_text("precious")
    assert "FOLDER" in _run(script, tmp_path, "--help").stdout
    refused = _run(script, tmp_path, "file/below")
    assert refused.returncode == 2
    assert "cannot be made a folder" in refused.stderr.splitlines()[-1]


def test_there_are_examples():
    assert EXAMPLES
