"""Torques and forces of tendons as measured signals, and what is wrong with their sensors.

Recordings are of `truth.recording`, which shares no code with the product.
"""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import elastic_tendon as et
from elastic_tendon.effects import BY_ID
from elastic_tendon.measurement import parse_size
from elastic_tendon.reports.diagnosis_figures import all_figures
from truth import signals
from truth.catalogue import CELLS, actuator_of, signal_maps_of
from truth.recording import record

pytestmark = pytest.mark.usefixtures("all_made_soon")  # short recordings, many sets of effects

TIME = np.arange(0.0, 4.0, 8e-3)
TREE = {
    "name": "with load cells",
    "transmission": {
        "joint_pulley_radius": 0.03,
        "motor_pulley_radius": 0.02,
        "pretension_force": 60.0,
        "upper_spring": {"stiffness": 9000.0, "max_deflection": 0.02},
        "lower_spring": {"stiffness": 9000.0, "max_deflection": 0.02},
    },
    "link": {"inertia": 0.03, "damping": 0.2},
}
COLUMNS = {  # signal -> its column, and the noise of its sensor
    "joint_position": ("joint_position_rad", 1e-4),
    "joint_torque": ("joint_torque_Nm", 0.02),
    "motor_torque": ("motor_torque_Nm", 0.02),
    "upper_spring_force": ("upper_spring_force_N", 0.5),
    "lower_spring_force": ("lower_spring_force_kN", 0.5),
}
OFF = {"gain": {"error": -0.1}, "offset": {"offset": 0.3}, "force_offset": {"offset": 8.0}}


def recorded(path: Path, effects: dict, measured: tuple[str, ...]) -> str:
    """A file of the machine of which everything is as given but for these effects."""
    motor = signals.sines([0.6, 0.2], [1.1, 2.7], [0.0, 0.0])
    load = signals.sines([1.2], [1.9], [0.0])
    experiment = signals.Experiment(TIME[-1], motor, load)
    tree = {**TREE, "effects": effects}
    run = record(actuator_of(tree), experiment, TIME, signal_maps_of(tree))
    random = np.random.default_rng(3)
    table = {
        "time_s": TIME,
        "motor_position_rad": [motor.value(time) for time in TIME],
        "load_torque_Nm": [load.value(time) for time in TIME],
    }
    for signal in measured:
        column, sigma = COLUMNS[signal]
        values = run[signal] + sigma * random.standard_normal(len(TIME))
        table[column] = values / 1e3 if column.endswith("kN") else values
    pd.DataFrame(table).to_csv(path, index=False)
    return str(path)


def off_by(effect_id: str) -> dict[str, float]:
    return OFF["force_offset" if "force_offset" in effect_id else effect_id.rpartition("_")[2]]


def test_forces_of_tendons_are_signals_with_their_own_noise(tmp_path):
    recording = et.read(recorded(tmp_path / "cells.csv", {}, tuple(COLUMNS)))
    assert set(recording.signals) == set(COLUMNS)
    for signal, (_, sigma) in COLUMNS.items():
        assert recording.noise[signal].sigma == pytest.approx(sigma, rel=0.2)
    ratios = et.compare(et.load_model(TREE), recording).noise_ratio()
    assert all(ratio == pytest.approx(1.0, abs=0.2) for ratio in ratios.values())
    assert parse_size("upper_spring_force=2N") == ("upper_spring_force", 2.0)


@pytest.mark.parametrize(
    ("scaled", "shifted"),
    [
        ("joint_torque", "upper_force"),
        ("upper_force", "joint_torque"),
        ("lower_force", "motor_reading"),
        ("motor_reading", "lower_force"),
    ],
)
def test_what_is_wrong_with_load_cells_is_named(scaled, shifted, tmp_path):
    """The gain of one and the zero of another, among all other candidates; the machine is as
    given."""
    hidden = {name: off_by(name) for name in (f"{scaled}_gain", f"{shifted}_offset")}
    measured = ("joint_position", CELLS[scaled], CELLS[shifted])
    found = et.diagnose(
        et.load_model(TREE), et.read(recorded(tmp_path / "cells.csv", hidden, measured))
    )
    assert set(found.added) == set(hidden)
    drawn = dict(all_figures(found))
    for effect_id, numbers in hidden.items():
        ((name, value),) = numbers.items()
        assert found.model.effects[effect_id][name] == pytest.approx(value, rel=0.05)
        assert BY_ID[effect_id].title in found.sentence
        assert f"explained_by_{effect_id}" not in drawn  # it changes no motion
    assert " are surely missing" in found.sentence
    assert all(ratio < 1.1 for ratio in found.ladder[-1].noise_ratio.values())
    et.report(found, tmp_path / "report.html")


def test_friction_is_named_beside_a_load_cell_that_is_off(tmp_path):
    hidden = {"coulomb_friction": {"torque": 0.3}, "joint_torque_gain": off_by("joint_torque_gain")}
    path = recorded(tmp_path / "cells.csv", hidden, ("joint_position", "joint_torque"))
    found = et.diagnose(et.load_model(TREE), et.read(path))
    assert set(found.added) == set(hidden)
    assert found.model.effects["joint_torque_gain"]["error"] == pytest.approx(-0.1, rel=0.05)


@pytest.mark.parametrize("hidden", [{}, {"joint_torque_gain": {"error": -0.1}}])
def test_evidence_proves_forces_and_what_sensors_make_of_them(hidden, tmp_path):
    path = recorded(tmp_path / "cells.csv", hidden, ("joint_torque", "upper_spring_force"))
    model = et.load_model({**TREE, "effects": hidden})
    proof = et.gather_evidence(model, et.read(path))
    fmu = et.export_fmu(model, tmp_path / "x.fmu", evidence=proof)
    found = et.verify(fmu)
    assert found.passed, found.faults
    errors = found.errors[et.read(path).name]
    assert set(errors) == {"joint_torque", "upper_spring_force"}
    assert all(again == pytest.approx(stated, rel=1e-6) for stated, again in errors.values())


def test_a_fleet_is_judged_by_load_cells_too(tmp_path):
    measured = ("joint_position", "upper_spring_force")
    hidden = {"upper_force_gain": off_by("upper_force_gain")}
    robots = [recorded(tmp_path / "robot.csv", hidden, measured)]
    done = et.sweep(et.fleet(et.load_model(TREE), robots), tmp_path / "runs.csv")
    found = pd.read_csv(done.path, keep_default_na=False).iloc[0]
    assert not found["failure"]
    assert found["appeared"].startswith("upper_force_gain")
    assert found["upper_spring_force_noise_ratio_after"] < 1.1
