"""Recordings of the deflection instead of the joint position, as series elastic joints have."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

import elastic_tendon as et
from elastic_tendon.actuator.parameters import load_model
from elastic_tendon.measurement import parse_size
from elastic_tendon.misreadings.belief import believed
from elastic_tendon.misreadings.signs import sign_errors
from elastic_tendon.misreadings.suspicion import suspicions
from elastic_tendon.progress import silent

GIVEN = load_model("biorob_x4_joint_3")
RATIO = 0.75  # of motor to joint pulley, so that a wrong share of the motor's motion would show
MODEL = GIVEN.with_values({"transmission.motor_pulley_radius": RATIO * 0.03})


@pytest.fixture(scope="module")
def joint(sticking) -> et.Measurement:
    """A recording of the joint position; the motor's pulley is smaller."""
    _, recording, _ = sticking
    return replace(recording, motor_position=recording.motor_position / RATIO)


@pytest.fixture
def file(joint, tmp_path) -> str:
    bent = joint.signals["joint_position"] - RATIO * joint.motor_position
    columns = {
        "time_s": joint.time,
        "motor_position_rad": joint.motor_position,
        "load_torque_Nm": joint.load_torque,
        "joint_deflection_mrad": 1e3 * bent,
    }
    path = tmp_path / "series_elastic.csv"
    pd.DataFrame({name: values for name, values in columns.items() if values is not None}).to_csv(
        path, index=False
    )
    return str(path)


def test_it_is_compared_by_the_joint_position_that_follows(joint, file) -> None:
    recording = et.read(file)
    assert "joint_deflection" in recording.signals
    seen, measured = et.compare(MODEL, recording), et.compare(MODEL, joint)
    assert seen.rmse() == pytest.approx(measured.rmse(), rel=1e-9)
    assert seen.noise_ratio() == pytest.approx(measured.noise_ratio(), rel=1e-3)


def test_parameters_are_fitted_alike(joint, file) -> None:
    seen, measured = et.fit(MODEL, et.read(file)), et.fit(MODEL, joint)
    assert seen.model.values() == pytest.approx(measured.model.values(), rel=1e-5, abs=1e-9)


def test_it_is_read_at_the_door_of_every_command(file) -> None:
    (recording,) = believed(MODEL, [et.read(file)], silent)
    assert list(recording.signals) == ["joint_position"]
    assert parse_size("joint_deflection=1mrad") == ("joint_position", 1e-3)
    assert recording.with_noise({"joint_deflection": 1e-3}).given_noise == {"joint_position": 1e-3}
    assert et.read(file).with_noise({"joint_deflection": 1e-3}).for_model(MODEL).given_noise == {
        "joint_position": 1e-3
    }


def test_a_joint_position_beside_it_comes_first(joint, file) -> None:
    table = pd.read_csv(file)
    table["joint_position_rad"] = joint.signals["joint_position"]
    table.to_csv(file, index=False)
    recording = et.read(file)
    assert list(recording.signals) == ["joint_position"]
    assert any("joint_deflection" in note for note in recording.notes)


def test_both_at_once_are_refused(joint) -> None:
    bent = {**joint.signals, "joint_deflection": joint.signals["joint_position"]}
    with pytest.raises(et.MeasurementError, match="one follows from the other"):
        et.compare(MODEL, replace(joint, signals=bent))


COLUMNS = {
    "joint_deflection": "joint_deflection_mrad:mrad",
    "motor_position": "motor_position_rad:rad",
}


@pytest.mark.parametrize("signal", COLUMNS)
def test_a_flipped_signal_is_told(file, signal: str) -> None:
    mapping = {signal: f"{COLUMNS[signal]}*-1"}
    recording = et.read(file, map=mapping).with_joint_position(MODEL)
    (found,) = sign_errors(MODEL, [recording])
    assert signal in found.signals
    assert f"--map {signal}=" in found.sentence


def test_what_is_read_rightly_is_not_accused(file) -> None:
    recording = et.read(file).with_joint_position(MODEL)
    assert sign_errors(MODEL, [recording]) == []
    assert suspicions(MODEL, recording) == ()


def test_a_wrong_unit_is_told(file) -> None:
    mapping = {"joint_deflection": "joint_deflection_mrad:rad"}
    table = pd.read_csv(file)
    table["joint_deflection_mrad"] *= 180.0 / np.pi / 1e3  # it is in degrees
    table.to_csv(file, index=False)
    recording = et.read(file, map=mapping).with_joint_position(MODEL)
    (sentence,) = suspicions(MODEL, recording)
    assert "if it is in degrees read it with --map joint_deflection=" in sentence
    assert "gear" not in sentence
