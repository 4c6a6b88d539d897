"""A signal of opposite sign is told before any fit; missing effects and wrong numbers are not."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import bench_real_data
from elastic_tendon.actuator.parameters import Model, load_model
from elastic_tendon.actuator.transmission import characteristic_torque
from elastic_tendon.measurement import Measurement
from elastic_tendon.misreadings.signs import sign_errors
from misread_recordings import scaled, truth_case
from truth.actuator import Actuator, Link, Spring
from truth.experiments import Limits, multisine
from truth.friction import Coulomb
from truth.solver import simulate

BELIEVED = load_model("biorob_x4_joint_3")
# numbers that are wrong by one or two standard deviations of what is believed by default
WRONG = {"link.inertia": 1.6, "transmission.pretension_force": 0.7, "link.damping": 3.0}
WRONG |= {f"transmission.{side}_spring.stiffness": 1.2 for side in ("upper", "lower")}
SIGNALS = ("joint_position", "motor_position", "load_torque", "joint_torque", "motor_torque")
# seeds of recordings of other machines, with a hidden effect each and wrong numbers
HIDDEN_EFFECTS = (2, 4, 8, 16, 30, 34)
RATE, DURATION = 500, 6.0  # Hz, s


def wrong_model() -> Model:
    values = BELIEVED.values()
    return BELIEVED.with_values({path: by * values[path] for path, by in WRONG.items()})


@cache
def recorded() -> Measurement:
    """A machine with friction that the model lacks; all torques are measured."""
    spring = Spring(2.0 * 11580.0, 0.015)
    link = Link(0.03, 0.16, Coulomb(0.35))
    actuator = Actuator(0.03, 0.03, 80.0, spring, spring, link)
    time = np.arange(round(DURATION * RATE)) / RATE
    run = simulate(actuator, multisine(7, Limits(0.3, 4.0, 5.0), DURATION), time)
    rng = np.random.default_rng(1)
    noise = {"joint_position": 2e-4, "joint_torque": 0.05}
    signals = {key: run[key] + by * rng.standard_normal(len(time)) for key, by in noise.items()}
    signals["motor_torque"] = signals["joint_torque"].copy()  # equal pulleys, (9)
    return Measurement(time, run["motor_position"], signals, run["load_torque"], name="made.csv")


def flipped(measurement: Measurement, signal: str) -> Measurement:
    if signal in measurement.signals:
        turned = {**measurement.signals, signal: -measurement.signals[signal]}
        return replace(measurement, signals=turned)
    return replace(measurement, **{signal: -getattr(measurement, signal)})


@pytest.mark.parametrize("model", [BELIEVED, wrong_model()], ids=["right", "wrong"])
@pytest.mark.parametrize("signal", SIGNALS)
def test_a_flipped_signal_is_told(signal: str, model: Model) -> None:
    (found,) = sign_errors(model, [flipped(recorded(), signal)])
    assert found.signals == (signal,)
    assert found.recording == "made.csv"
    assert f"the {signal.replace('_', ' ')} looks as if it had the opposite sign" in found.sentence
    assert f"--map {signal}=COLUMN*-1" in found.sentence


@pytest.mark.parametrize("model", [BELIEVED, wrong_model()], ids=["right", "wrong"])
def test_what_is_read_rightly_is_not_accused(model: Model) -> None:
    assert sign_errors(model, [recorded()]) == []


def test_only_the_flipped_recording_is_told() -> None:
    (found,) = sign_errors(
        BELIEVED, [recorded(), replace(flipped(recorded(), "load_torque"), name="late.csv")]
    )
    assert found.recording == "late.csv"


def test_joint_and_motor_cannot_be_told_apart_without_a_load() -> None:
    case = truth_case(2)
    for signal in ("joint_position", "motor_position"):
        (found,) = sign_errors(case.model, [scaled(**{signal: -1.0})(case.measurement)])
        assert found.signals == ("joint_position", "motor_position")


@pytest.mark.parametrize("seed", HIDDEN_EFFECTS)
def test_hidden_effects_are_not_accused_and_hide_no_flip(seed: int) -> None:
    case = truth_case(seed)
    assert case.effect
    assert sign_errors(case.model, [case.measurement]) == []
    (found,) = sign_errors(case.model, [scaled(joint_position=-1.0)(case.measurement)])
    assert "joint_position" in found.signals


@pytest.mark.parametrize("signal", ["joint_position", "load_torque"])
def test_a_static_curve_that_falls_is_told(signal: str) -> None:
    deflection = 0.3 * np.sin(np.linspace(0.0, 2.0 * np.pi, 200))
    curve = Measurement(
        10.0 * np.arange(200),
        np.zeros(200),
        {"joint_position": deflection},
        -characteristic_torque(deflection, BELIEVED.transmission),
        static=True,
        name="static.csv",
    )
    assert sign_errors(BELIEVED, [curve]) == []
    (found,) = sign_errors(BELIEVED, [flipped(curve, signal)])
    assert found.signals == ("joint_torque", "joint_deflection")


@pytest.mark.skipif(
    not Path(bench_real_data.DATA).is_dir(), reason="the recordings are not at hand"
)
@pytest.mark.parametrize("name", bench_real_data.MODELS)
def test_real_machines_are_not_accused(name: str) -> None:
    model = load_model(bench_real_data.MODELS[name])
    assert sign_errors(model, [bench_real_data.read(bench_real_data.DATA, name)]) == []
