"""The sentence names what the truth hides, and claims nothing where nothing is hidden."""

import re
from copy import deepcopy
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from elastic_tendon.actuator.parameters import load_model
from elastic_tendon.actuator.transmission import characteristic_torque
from elastic_tendon.comparison import patterns
from elastic_tendon.comparison.compare import compare
from elastic_tendon.comparison.locate import locate
from elastic_tendon.comparison.patterns import Pattern
from elastic_tendon.measurement import Measurement
from elastic_tendon.reports.comparison_tables import sample_shares, strongest
from study_locate import moved, numbers_of, recording
from truth.experiments import Limits, multisine, steps_with_load_pulses
from truth.noise import Sensor
from truth.signals import Experiment, Signal, constant, sines, smooth_pulse

MODEL = load_model("biorob_x4_joint_3")
EXPERIMENT = multisine(31, Limits(0.2, 4.0, 4.0), 6.0)
NOISE = Sensor(white=2e-4)
HAND = smooth_pulse(3.0, duration=1.0, height=2.0, edge=0.1)
FRICTION = {"effects": {"coulomb_friction": {"torque": 0.3}}}
SWING = Experiment(8.0, sines([0.6], [0.3], [0.0]))  # of the motor, slow against the joint


def record(
    effects: dict[str, dict[str, float]], link: dict[str, float], unknown: Signal | None
) -> Measurement:
    numbers = deepcopy(numbers_of(MODEL))
    numbers["link"].update(link)
    numbers["effects"] = effects
    return recording(moved(numbers, EXPERIMENT, 500.0, unknown), NOISE, 31)


def slow(
    numbers: dict[str, object], experiment: Experiment, unknown: Signal | None = None
) -> Measurement:
    """A recording without a load column."""
    made = moved({**numbers_of(MODEL), **numbers}, experiment, 200.0, unknown)
    return replace(recording(made, NOISE, 7), load_torque=None)


def told(measurement: Measurement, signal: str = "joint_position") -> str:
    return locate(compare(MODEL, [measurement])).files[0].in_words[signal]


def static(extra: np.ndarray, deflection: np.ndarray) -> Measurement:
    load = -(characteristic_torque(deflection, MODEL.transmission) + extra)
    position = deflection + 5e-4 * np.random.default_rng(1).standard_normal(len(deflection))
    time = 10.0 * np.arange(len(deflection))
    signals = {"joint_position": position}
    return Measurement(time, 0.0 * time, signals, load_torque=load, static=True, name="sweep")


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
        ["beyond -0.08", "in both directions", "stiffer there than the model", "about 10"],
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
        ["a constant error of 7 mrad, everywhere alike: an offset between the encoders would"],
    ),
    "delay": ({"measurement_delay": {"delay": 0.004}}, {}, None, ["later", "about 4 ms"]),
    "gravity": (
        {"gravity_load": {"torque": 1.0, "angle": 0.3}},
        {},
        None,
        ["the missing torque is a curve over the joint position", "gravity"],
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
    size = re.search(r"by about (\d+) N·m/rad", sentence)
    assert float(size[1]) == pytest.approx(60.0, rel=0.03)
    bounds = re.search(r"beyond (\S+) and (\S+) rad of deflection", sentence)
    assert [float(group) for group in bounds.groups()] == pytest.approx([-0.2, 0.2], abs=0.01)
    assert "load" not in sentence
    assert " s " not in sentence


def test_a_static_curve_with_hysteresis_is_told_so() -> None:
    sentence = told(static(-0.2 * np.sign(np.gradient(SWEEP)), SWEEP))
    assert "resists motion more than the model, by about 0.2 N·m" in sentence


def test_a_static_curve_that_is_softer_is_told_so() -> None:
    softer = -0.3 * characteristic_torque(SWEEP, MODEL.transmission)
    assert "softer than the model, by about 9.7 N·m/rad" in told(static(softer, SWEEP))


def test_a_static_curve_that_nothing_explains_is_placed_by_no_time() -> None:
    # a torque that went and came while it was measured
    passing = np.where(np.arange(len(SWEEP)) % 60 < 20, 0.5, 0.0) * np.sign(SWEEP - 0.1)
    sentence = told(static(passing, SWEEP))
    assert "no simple pattern explains it" in sentence
    assert not re.search(r"\d s\b| time", sentence)


@pytest.mark.parametrize("share", [0.6, 0.8])
def test_soft_springs_under_a_known_load_are_told(share: float) -> None:
    numbers = deepcopy(numbers_of(MODEL))
    for side in ("upper_spring", "lower_spring"):
        numbers["transmission"][side]["stiffness"] *= share
    sentence = told(recording(moved(numbers, EXPERIMENT, 500.0), NOISE, 31))
    assert "softer than the model" in sentence
    assert "look alike" not in sentence


@pytest.mark.parametrize(("force", "way"), [(50.0, "lower"), (110.0, "higher")])
def test_a_wrong_pretension_is_told_with_its_number(force: float, way: str) -> None:
    numbers = deepcopy(numbers_of(MODEL))
    numbers["transmission"]["pretension_force"] = force
    made = moved(numbers, multisine(47, Limits(0.25, 3.0, 6.0), 6.0), 500.0)
    sentence = told(recording(made, NOISE, 47))
    found = re.search(r"as if the pretension were (\S+) % (\w+), about (\d+) N", sentence)
    assert found, sentence
    assert found[2] == way
    assert float(found[3]) == pytest.approx(force, rel=0.05)


@pytest.mark.parametrize(
    ("sides", "words"),
    [
        (("upper_spring", "lower_spring"), "as if both springs were softer by about 10 %"),
        (("upper_spring",), "as if the upper spring were softer by about 10 %"),
    ],
)
def test_soft_springs_in_slow_motion_are_told_before_the_load(sides, words) -> None:
    numbers = deepcopy(numbers_of(MODEL))
    for side in sides:
        numbers["transmission"][side]["stiffness"] *= 0.9
    slowly = Experiment(12.0, constant(0.0), sines([7.0], [0.25], [0.0]))
    sentence = told(recording(moved(numbers, slowly, 200.0), NOISE, 48))
    assert words in sentence, sentence


def test_a_load_sensor_that_reads_too_little_is_named_beside_the_springs() -> None:
    slowly = Experiment(12.0, constant(0.0), sines([7.0], [0.25], [0.0]))
    made = recording(moved(numbers_of(MODEL), slowly, 200.0), NOISE, 49)
    sentence = told(replace(made, load_torque=made.load_torque / 1.1))
    softer = sentence.index("softer")
    assert softer < sentence.index("or the load acts more strongly than recorded by about 10 %")


def test_friction_of_a_joint_moved_in_steps_is_told() -> None:
    numbers = {**numbers_of(MODEL), **FRICTION}
    steps = steps_with_load_pulses(46, Limits(0.2, 2.0, 0.0), 10.0)
    sentence = told(recording(moved(numbers, steps, 500.0), NOISE, 46))
    found = re.search(r"resists motion more than the model, by about (\S+) N·m", sentence)
    assert float(found[1]) == pytest.approx(0.3, rel=0.15)


@pytest.mark.parametrize("kind", ["coulomb_friction", "stribeck_friction"])
def test_friction_that_depends_on_the_speed_is_not_the_same_at_any(kind: str) -> None:
    effects = {
        "coulomb_friction": {"torque": 0.3},
        "stribeck_friction": {
            "coulomb_torque": 0.3,
            "static_torque": 0.6,
            "stribeck_velocity": 0.15,
        },
    }
    slowly = Experiment(12.0, sines([0.4], [0.3], [0.0]), sines([4.0], [0.21], [0.0]))
    numbers = {**numbers_of(MODEL), "effects": {kind: effects[kind]}}
    sentence = told(recording(moved(numbers, slowly, 500.0), NOISE, 50))
    words = {"coulomb_friction": "at any speed", "stribeck_friction": "more at low speed"}
    assert words[kind] in sentence, sentence


@pytest.mark.parametrize(
    ("fit", "by", "limit"),
    [
        (patterns.acceleration, "joint_acceleration", MODEL.link.inertia),
        (patterns.velocity, "joint_velocity", MODEL.link.damping),
        (patterns.load, "load_torque", -1.0),
    ],
)
def test_a_number_that_no_machine_can_have_is_no_finding(fit, by: str, limit: float) -> None:
    values = np.sin(0.1 * np.arange(500.0))
    evidence = SimpleNamespace(variables={by: values}, model=MODEL)
    pattern = Pattern("any", by, fit, {})
    assert fit(pattern, 0.9 * limit * values, evidence).size == pytest.approx(0.9 * limit)
    assert fit(pattern, 1.1 * limit * values, evidence) is None


def test_what_no_pattern_explains_is_placed_where_it_is_densest() -> None:
    numbers = deepcopy(numbers_of(MODEL))
    numbers["effects"] = {
        "joint_stop": {"lower": -3.0, "upper": 0.2, "stiffness": 2e3, "damping": 5.0}
    }
    slowly = Experiment(9.0, sines([0.35], [0.4], [0.0]))
    made = recording(moved(numbers, slowly, 500.0), NOISE, 52)
    found = locate(compare(MODEL, [made])).files[0]
    bins = [bin_ for bin_ in found.bins["joint_position"] if bin_.stands_out]
    first = strongest(bins, sample_shares(found.bins["joint_position"]))[0].by
    sentence = found.in_words["joint_position"]
    assert first.replace("_", " ") in sentence, sentence
    assert "Hz" not in sentence


def test_soft_springs_without_a_load_look_like_an_inert_link() -> None:
    numbers = deepcopy(numbers_of(MODEL))
    for side in ("upper_spring", "lower_spring"):
        numbers["transmission"][side]["stiffness"] *= 0.8
    free = multisine(31, Limits(0.2, 4.0, 0.0), 6.0)
    sentence = told(recording(moved(numbers, free, 500.0), NOISE, 31))
    assert "softer than the model" in sentence
    assert "or its link more inert by a like share" in sentence


def test_friction_alone_that_deflects_the_joint_is_no_softness() -> None:
    sentence = told(slow(FRICTION, SWING))
    assert "the joint resists motion more than the model, by about 0.3 N·m" in sentence


def test_friction_goes_on_where_the_joint_rests() -> None:
    limits = Limits(0.2, 2.0, 0.0)
    sentence = told(slow(FRICTION, steps_with_load_pulses(5, limits, 10.0)))
    assert "resists motion more than the model, by about 0.28 N·m" in sentence


@pytest.mark.parametrize("motor", [constant(0.0), SWING.motor_position])
def test_an_unmeasured_load_is_no_softness(motor: Signal) -> None:
    load = sines([3.0, 2.0], [0.21, 0.37], [0.0, 1.0])
    sentence = told(slow({}, Experiment(8.0, motor), load))
    assert "stiffness cannot be its cause" in sentence
    assert "no load was recorded" in sentence
    assert "soft" not in sentence


@pytest.mark.parametrize("count", [1, 8])
def test_samples_at_which_the_sensor_jumped_are_no_torque(count: int) -> None:
    clean = record({}, {}, None)
    position = clean.signals["joint_position"].copy()
    spikes = np.random.default_rng(5).choice(len(position) - 200, count, replace=False) + 100
    position[spikes] += 0.3
    sentence = told(replace(clean, signals={"joint_position": position}))
    how_many = "a single sample holds" if count == 1 else f"{count} single samples hold"
    assert sentence.startswith(f"{how_many} 100 % of the squared error")
    assert "look whether the sensor jumped" in sentence


def test_no_pattern_goes_through_ten_samples() -> None:
    few = record(FRICTION["effects"], {}, None).samples(slice(0, 3000, 300))
    assert "accounts for" not in told(few)


def test_a_held_joint_is_told() -> None:
    time = np.arange(0.0, 8.0, 0.005)
    noise = 2e-4 * np.random.default_rng(3).standard_normal(len(time))
    motor = 0.2 * np.sin(2.0 * time)
    sentence = told(Measurement(time, motor, {"joint_position": noise}, name="held"))
    assert "the motor moves and the joint stays" in sentence
    assert "gravity" not in sentence


def test_a_static_curve_of_the_model_is_noise() -> None:
    assert told(static(0.0 * SWEEP, SWEEP)) == "nothing stands out: the error is the noise"


def test_an_offset_of_a_torque_sensor_is_told() -> None:
    made = record({}, {}, None)
    torque = compare(MODEL, [made]).files[0].trajectory["joint_torque"]
    noise = 1e-2 * np.random.default_rng(2).standard_normal(len(torque))
    signals = {**made.signals, "joint_torque": torque + 0.25 + noise}
    sentence = told(replace(made, signals=signals), "joint_torque")
    assert "a constant error of 250 mN·m" in sentence
