"""A constant that explains a recording's error is told; a missing effect is no constant."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from elastic_tendon.actuator.parameters import load_model
from elastic_tendon.measurement import Measurement, read_measurement
from elastic_tendon.misreadings.constants import explained_by
from misread_recordings import scaled, truth_case

LOADED = (5, 8, 27)  # seeds of recordings whose motor and load move
UNLOADED = 20
REAL_DATA = Path(__file__).parents[3] / "shared" / "data"


def earlier(measurement: Measurement, by: float) -> Measurement:
    """Inputs that come so much (s) before the joint that answers them."""
    time, load = measurement.time, measurement.load_torque
    return replace(
        measurement,
        motor_position=np.interp(time + by, time, measurement.motor_position),
        load_torque=None if load is None else np.interp(time + by, time, load),
    )


def offset_joint(measurement: Measurement, by: float) -> Measurement:
    return replace(
        measurement, signals={"joint_position": measurement.signals["joint_position"] + by}
    )


# kind, its value, and what makes a recording need it
CONSTANTS: dict[str, tuple[float, Callable[[Measurement], Measurement]]] = {
    "offset": (0.01, lambda recording: offset_joint(recording, 0.01)),
    "load": (0.4, lambda recording: replace(recording, load_torque=recording.load_torque - 0.4)),
    "gain": (0.95, scaled(motor_position=1.0 / 0.95)),
    "delay": (0.008, lambda recording: earlier(recording, 0.008)),
}


@pytest.mark.parametrize("seed", LOADED)
@pytest.mark.parametrize("kind", CONSTANTS)
def test_the_constant_is_told(kind: str, seed: int) -> None:
    case = truth_case(seed, hidden=False)
    value, change = CONSTANTS[kind]
    found = explained_by(case.model, change(case.measurement))
    assert found is not None
    assert found.kind == kind
    assert found.value == pytest.approx(value, rel=0.02)
    assert found.rmse_after < 0.1 * found.rmse_before
    assert found.sentence.startswith(case.measurement.name)


@pytest.mark.parametrize("signal", ["joint_position", "motor_position", "load_torque"])
def test_a_sign_is_told(signal: str) -> None:
    case = truth_case(LOADED[0], hidden=False)
    found = explained_by(case.model, scaled(**{signal: -1.0})(case.measurement))
    assert found is not None
    assert found.kind == "sign"
    assert signal.replace("_", " ") in found.sentence


def test_other_springs_are_told() -> None:
    case = truth_case(LOADED[0], hidden=False)
    stiffer = {path: 1.15 * k for path, k in case.model.values().items() if "stiffness" in path}
    found = explained_by(case.model.with_values(stiffer), case.measurement)
    assert found is not None
    assert found.kind == "stiffness"
    assert found.value == pytest.approx(1.0 / 1.15, rel=0.01)


def test_zeros_of_the_encoders_are_one_answer() -> None:
    """They are equal but where something depends on the angle itself."""
    case = truth_case(UNLOADED, hidden=False)
    moved = replace(case.measurement, motor_position=case.measurement.motor_position + 0.02)
    found = explained_by(case.model, moved)
    assert found is not None
    assert found.kind == "offset"
    assert "motor encoder" in found.sentence


@pytest.mark.parametrize("seed", [*LOADED, UNLOADED])
def test_a_model_that_is_right_needs_no_constant(seed: int) -> None:
    case = truth_case(seed, hidden=False)
    assert explained_by(case.model, case.measurement) is None


# the truth of a mass in a spring, seed 11, takes ten seconds; the others hide a weight, a stop,
# strings and an eccentric pulley
@pytest.mark.parametrize("seed", [5, 14, 26, 27, pytest.param(11, marks=pytest.mark.slow)])
def test_a_missing_effect_is_no_constant(seed: int) -> None:
    case = truth_case(seed)
    assert case.effect
    assert explained_by(case.model, case.measurement) is None


@pytest.mark.skipif(not REAL_DATA.is_dir(), reason="the recordings are not at hand")
@pytest.mark.parametrize(
    ("model", "name"),
    [
        ("bench_actuator", "muir_position_loop_tracking.csv"),
        ("mrd_jaw", "mrd_run_04.csv"),
        ("mrd_jaw", "mrd_run_44.csv"),
    ],
)
def test_friction_of_real_machines_is_no_constant(model: str, name: str) -> None:
    assert explained_by(load_model(model), read_measurement(str(REAL_DATA / name))) is None
