"""The missing torque is recovered from the truth's recordings: its sign, its size, its band."""

from dataclasses import replace

import numpy as np
import pytest

from elastic_tendon.actuator.parameters import load_model
from elastic_tendon.actuator.transmission import characteristic_torque
from elastic_tendon.comparison import averaging
from elastic_tendon.comparison import missing_torque as module
from elastic_tendon.comparison.compare import compare
from elastic_tendon.comparison.missing_torque import Smoother, missing_torque, smoother_for
from elastic_tendon.errors import SimulationError
from elastic_tendon.measurement import Measurement, NoiseFloor
from elastic_tendon.measurement.assembly import STATIC_STEP
from elastic_tendon.simulation.simulate import simulate
from study_locate import moved, numbers_of, recording
from truth.experiments import Limits, multisine
from truth.noise import Sensor
from truth.signals import Signal, smooth_pulse

MODEL = load_model("biorob_x4_joint_3")
EXPERIMENT = multisine(21, Limits(0.2, 4.0, 3.0), 6.0)
NOISE = Sensor(white=2e-4)
PULSE = smooth_pulse(2.0, duration=1.0, height=-1.5, edge=0.1)  # N·m
FRICTION = 0.3  # N·m


def record(effects: dict[str, dict[str, float]], unknown: Signal | None = None) -> Measurement:
    numbers = {**numbers_of(MODEL), "effects": effects}
    return recording(moved(numbers, EXPERIMENT, 500.0, unknown), NOISE, 21)


def reconstruct(measurement: Measurement):
    return missing_torque(MODEL, compare(MODEL, [measurement]).files[0])


@pytest.fixture(scope="module")
def pushed() -> Measurement:
    """A recording in which a hand pushed for a second."""
    return record({}, PULSE)


@pytest.fixture(scope="module")
def rubbing() -> Measurement:
    """A recording of a joint with Coulomb friction."""
    return record({"coulomb_friction": {"torque": FRICTION}})


def check_pulse(measurement: Measurement, torque: np.ndarray, sigma: np.ndarray) -> None:
    expected = np.array([PULSE.value(float(time)) for time in measurement.time])
    error = torque - expected
    # at the ends nothing lies on the other side to smooth with
    inner = slice(25, -25)
    assert np.std(error[inner]) < 2.0 * np.mean(sigma)
    assert np.mean(np.abs(error[inner]) < 3.0 * sigma[inner]) > 0.95
    assert np.mean(sigma) < 0.05 * abs(np.min(expected))


def test_a_hidden_pulse_is_recovered_within_its_band(pushed) -> None:
    found, _, _ = reconstruct(pushed)
    check_pulse(pushed, found.torque, found.sigma)


def test_irregular_times_are_no_obstacle(pushed) -> None:
    keep = np.sort(np.random.default_rng(1).choice(len(pushed.time), 2700, replace=False))
    some = pushed.samples(keep)
    found, _, _ = reconstruct(some)
    expected = np.array([PULSE.value(float(time)) for time in some.time])
    assert np.std(found.torque - expected) < 0.05


def test_friction_is_a_torque_against_the_velocity(rubbing) -> None:
    found, _, _ = reconstruct(rubbing)
    curve = next(curve for curve in found.curves if curve.by == "joint_velocity")
    assert curve.mean[0] == pytest.approx(FRICTION, rel=0.05)
    assert curve.mean[-1] == pytest.approx(-FRICTION, rel=0.05)
    assert np.all(curve.low <= curve.mean)
    assert np.all(curve.mean <= curve.high)
    assert np.sum(curve.count) == len(rubbing.time)


def test_no_band_of_a_mean_is_wider_than_its_samples(rubbing) -> None:
    found, _, _ = reconstruct(rubbing)
    lowest = np.min(found.torque - 2.0 * found.sigma)
    highest = np.max(found.torque + 2.0 * found.sigma)
    assert len(found.curves) > 5
    for curve in found.curves:
        assert np.all((lowest <= curve.low) & (curve.low <= curve.mean))
        assert np.all((curve.mean <= curve.high) & (curve.high <= highest))


def test_variables_follow_the_measurement(rubbing) -> None:
    file = compare(MODEL, [rubbing]).files[0]
    _, variables, parts = missing_torque(MODEL, file)
    measured = rubbing.signals["joint_position"] - rubbing.motor_position
    before = np.std(file.trajectory["deflection"] - measured)
    after = np.std(variables["deflection"] - measured)
    assert after < 0.1 * before
    assert after < 2.0 * NOISE.white
    assert all(len(part.member) == len(rubbing.time) for part in parts.values())


def test_hardening_is_a_curve_over_the_deflection() -> None:
    stiff = 4e7  # N/m³, of one spring
    found, _, _ = reconstruct(record({"spring_hardening": {"cubic_stiffness": stiff}}))
    curve = next(curve for curve in found.curves if curve.by == "deflection")
    radius = MODEL.transmission.joint_pulley_radius
    spring = MODEL.transmission.upper_spring
    length = MODEL.transmission.pretension_force / spring.combined_stiffness

    def cubic(elongation: np.ndarray) -> np.ndarray:
        return spring.parallel * stiff * np.maximum(elongation, 0.0) ** 3

    # pretension is a force: the harder springs stretch less by it, so the middle is compared
    x = radius * curve.centre
    extra = radius * (cubic(length - x) - cubic(length + x))
    middle = np.abs(curve.centre) < 0.06
    assert np.polyfit(curve.centre[middle], curve.mean[middle], 1)[0] == pytest.approx(
        np.polyfit(curve.centre[middle], extra[middle], 1)[0], rel=0.25
    )


def test_a_static_curve_is_followed_by_its_stiffness_alone() -> None:
    deflection = np.concatenate([np.linspace(-0.3, 0.3, 80), np.linspace(0.3, -0.3, 80)])
    extra = -60.0 * np.sign(deflection) * np.maximum(np.abs(deflection) - 0.2, 0.0)
    load = -(characteristic_torque(deflection, MODEL.transmission) + extra)
    time = STATIC_STEP * np.arange(len(deflection))
    position = deflection + 5e-4 * np.random.default_rng(4).standard_normal(len(deflection))
    signals = {"joint_position": position}
    sweep = Measurement(time, 0.0 * time, signals, load_torque=load, static=True, name="sweep")
    found, _, parts = reconstruct(sweep)
    assert np.std(found.torque - extra) < 0.05
    # where nothing is missing the band is as narrow as its samples
    curve = next(curve for curve in found.curves if curve.by == "deflection")
    inner = np.abs(curve.centre) < 0.15
    assert np.all((curve.high - curve.low)[inner] < 0.15)
    assert "joint_acceleration" not in parts
    assert "velocity_sign" in parts


def test_nothing_is_found_where_nothing_is_missing() -> None:
    found, _, _ = reconstruct(record({}))
    assert np.std(found.torque) < 2.0 * np.mean(found.sigma)
    # the weakest torque that moves the joint by the noise
    assert np.std(found.torque) < 0.1


def test_a_failing_simulation_leaves_what_was_found_before(pushed, monkeypatch) -> None:
    file = compare(MODEL, [pushed]).files[0]
    whole = module.simulate_measurement
    calls = []

    def second_fails(*arguments):
        calls.append(arguments)
        if len(calls) > 1:
            raise SimulationError("stopped at 3 s")
        return whole(*arguments)

    monkeypatch.setattr(module, "simulate_measurement", second_fails)
    found, _, _ = missing_torque(MODEL, file)
    assert len(calls) == 2
    assert found.notes == (
        "the missing torque was found in 1 of up to 5 rounds, as the next failed: stopped at 3 s",
    )
    assert np.min(found.torque) < -1.0


def test_a_long_recording_takes_one_round(pushed, monkeypatch) -> None:
    monkeypatch.setattr(averaging, "LONG", 1000)
    found, variables, parts = reconstruct(pushed)
    assert len(pushed.time) == 3000
    assert len(found.torque) == len(variables["time"]) == 1000
    assert any("one round" in note and "each 3 neigh" in note for note in found.notes)
    assert np.min(found.torque) == pytest.approx(-1.5, abs=0.2)
    assert all(np.sum(part.counts) == 3000 for part in parts.values())


def test_a_late_sensor_does_not_break_the_loop() -> None:
    time = np.arange(0.0, 3.0, 0.002)
    motor = 0.4 * np.sin(5.0 * time)
    made = simulate(MODEL, time, motor)
    late = np.interp(time - 0.01, time, made["joint_position"])
    noise = 2e-4 * np.random.default_rng(2).standard_normal(len(time))
    measurement = Measurement(time, motor, {"joint_position": late + noise}, name="late")
    found, variables, _ = reconstruct(measurement)
    assert np.isfinite(found.torque).all()
    assert np.std(variables["deflection"] + motor - late) < 1e-3


def test_the_smoother_has_the_gain_that_it_says() -> None:
    step = 0.002
    smoother = Smoother(1e4, step)
    time = step * np.arange(4000)
    for frequency in (2.0, 20.0, 60.0):
        wave = np.sin(2.0 * np.pi * frequency * time)
        left = smoother.smooth(wave)[500:-500]
        gain = np.std(left) / np.std(wave[500:-500])
        expected = smoother.gain(np.array([2.0 * np.pi * frequency]))[0]
        assert gain == pytest.approx(expected, abs=0.02)


def test_smoothing_keeps_parabolas() -> None:
    time = np.linspace(-1.0, 1.0, 50)
    parabola = 1.0 + time - 3.0 * time**2
    assert Smoother(1e3, 0.04).smooth(parabola) == pytest.approx(parabola, abs=1e-8)


def test_louder_errors_are_smoothed_less() -> None:
    rng = np.random.default_rng(5)
    time = 0.002 * np.arange(5000)
    slow, fast = (np.sin(2.0 * np.pi * f * time) for f in (1.0, 20.0))
    noise = rng.standard_normal(len(time))
    floor = NoiseFloor(1.0, "white")
    weights = [
        smoother_for(signal + noise, floor, 0.002).weight
        for signal in (10.0 * slow, 10.0 * slow + 10.0 * fast)
    ]
    assert weights[1] < 1e-3 * weights[0]


def test_coloured_noise_is_not_taken_for_an_error() -> None:
    rng = np.random.default_rng(6)
    correlation = 0.9
    values = rng.standard_normal(6000)
    for index in range(1, len(values)):
        values[index] = correlation * values[index - 1] + np.sqrt(0.19) * values[index]
    white = NoiseFloor(1.0, "white")
    coloured = replace(white, kind="coloured", correlation=correlation)
    taken = smoother_for(values, white, 0.002).weight
    known = smoother_for(values, coloured, 0.002).weight
    assert known > 10.0 * taken


def test_a_torque_that_cannot_be_found_is_not_told_as_found() -> None:
    """The model has a stop that the machine lacks: no torque moves it through."""
    measurement = record({})
    reach = 0.3 * float(np.max(np.abs(measurement.signals["joint_position"])))
    numbers = {"lower": -reach, "upper": reach, "stiffness": 1e4, "damping": 10.0}
    stopped = MODEL.with_effect("joint_stop", numbers)
    file = compare(stopped, [measurement]).files[0]
    missing, _, _ = missing_torque(stopped, file)
    assert not missing.found
    assert any("no missing torque was found" in note for note in missing.notes)
    right, _, _ = reconstruct(measurement)
    assert right.found
