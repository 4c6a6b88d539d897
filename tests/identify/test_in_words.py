"""The sentence names what the truth hides, and claims nothing where nothing is hidden."""

from copy import deepcopy
from dataclasses import replace

import numpy as np
import pytest

from elastic_tendon.identify.compare import compare
from elastic_tendon.identify.locate import locate
from elastic_tendon.measurement import Measurement
from elastic_tendon.parameters import load_model
from elastic_tendon.transmission import characteristic_torque
from study_locate import moved, numbers_of, recording
from truth.experiments import Limits, multisine
from truth.noise import Sensor
from truth.signals import Signal, smooth_pulse

MODEL = load_model("biorob_x4_joint_3")
EXPERIMENT = multisine(31, Limits(0.2, 4.0, 4.0), 6.0)
NOISE = Sensor(white=2e-4)
HAND = smooth_pulse(3.0, duration=1.0, height=2.0, edge=0.1)


def record(
    effects: dict[str, dict[str, float]], link: dict[str, float], unknown: Signal | None
) -> Measurement:
    numbers = deepcopy(numbers_of(MODEL))
    numbers["link"].update(link)
    numbers["effects"] = effects
    return recording(moved(numbers, EXPERIMENT, 500.0, unknown), NOISE, 31)


def told(measurement: Measurement, signal: str = "joint_position") -> str:
    return locate(compare(MODEL, [measurement])).files[0].in_words[signal]


def static(extra: np.ndarray, deflection: np.ndarray) -> Measurement:
    load = -(characteristic_torque(deflection, MODEL.transmission) + extra)
    position = deflection + 5e-4 * np.random.default_rng(1).standard_normal(len(deflection))
    time = 10.0 * np.arange(len(deflection))
    signals = {"joint_position": position}
    return Measurement("sweep", time, 0.0 * time, signals, load_torque=load, static=True)


SWEEP = np.concatenate(
    [np.linspace(0.0, 0.3, 60), np.linspace(0.3, -0.3, 120), np.linspace(-0.3, 0.0, 60)]
)

CASES = {
    "nothing": ({}, {}, None, ["nothing stands out: the error is the noise"]),
    "hardening": (
        {"spring_hardening": {"cubic_stiffness": 4e7}},
        {},
        None,
        ["stiffer", "deflection", "in both directions"],
    ),
    "overstretch": (
        {"overstretch_protection": {"engagement": 0.4, "stiffness": 60000.0}},
        {},
        None,
        ["stiffer there than the model", "deflection"],
    ),
    "friction": (
        {"coulomb_friction": {"torque": 0.3}},
        {},
        None,
        ["the joint resists motion more than the model, by about 0.29 N·m"],
    ),
    "offset": (
        {"joint_encoder_offset": {"offset": 0.007}},
        {},
        None,
        ["a constant error of 7 mrad: an offset between the encoders would do this"],
    ),
    "delay": ({"measurement_delay": {"delay": 0.004}}, {}, None, ["later", "about 4 ms"]),
    "gravity": (
        {"gravity_load": {"torque": 1.0, "angle": 0.3}},
        {},
        None,
        ["motor position", "gravity"],
    ),
    "inertia": ({}, {"inertia": 0.036}, None, ["more inert", "by about 0.006 kg·m²"]),
    "damping": ({}, {"damping": 0.3}, None, ["damped more", "by about 0.14 N·m·s/rad"]),
    "ease": ({}, {"damping": 0.1}, None, ["damped less", "by about 0.06 N·m·s/rad"]),
    "hand": ({}, {}, HAND, ["acted on the joint in the positive direction from 3 to 3.9"]),
}


@pytest.mark.parametrize("case", CASES)
def test_the_sentence_names_what_is_hidden(case: str) -> None:
    effects, link, unknown, words = CASES[case]
    sentence = told(record(effects, link, unknown))
    assert all(word in sentence for word in words), sentence


def test_a_static_curve_that_stiffens_is_told_so() -> None:
    extra = -60.0 * np.sign(SWEEP) * np.maximum(np.abs(SWEEP) - 0.2, 0.0)
    sentence = told(static(extra, SWEEP))
    assert "stiffer there than the model" in sentence
    assert "deflection" in sentence
    assert "in both directions" in sentence
    assert "load" not in sentence


def test_a_static_curve_with_hysteresis_is_told_so() -> None:
    sentence = told(static(-0.2 * np.sign(np.gradient(SWEEP)), SWEEP))
    assert "resists motion more than the model, by about 0.2 N·m" in sentence


def test_a_static_curve_of_the_model_is_noise() -> None:
    assert told(static(0.0 * SWEEP, SWEEP)) == "nothing stands out: the error is the noise"


def test_an_offset_of_a_torque_sensor_is_told() -> None:
    made = record({}, {}, None)
    torque = compare(MODEL, [made]).files[0].trajectory["joint_torque"]
    noise = 1e-2 * np.random.default_rng(2).standard_normal(len(torque))
    signals = {**made.signals, "joint_torque": torque + 0.25 + noise}
    sentence = told(replace(made, signals=signals), "joint_torque")
    assert "a constant error of 250 mN·m" in sentence
