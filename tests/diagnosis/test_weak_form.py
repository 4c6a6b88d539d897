"""The weak form: without noise nothing is left of it, with noise what was foreseen."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from elastic_tendon.actuator.parameters import Model
from elastic_tendon.diagnosis.torque_balance import torque_balance
from elastic_tendon.diagnosis.weak_form import smooth, weak_form
from elastic_tendon.estimation.coordinates import free_parameters
from elastic_tendon.measurement import Measurement
from smooth_motion import GIVEN, Array, played, typical_model

NOISE = 2e-4  # rad, ordinary
SEEDS = range(3)
STARTING = 20  # residuals
HIDDEN = ((), ("gravity_load",), ("spring_hardening", "quadratic_drag"))


def torques_of(model: Model, recording: Measurement):
    """Weak form of a recording and the model's torques along it."""
    weak = weak_form(recording)
    balance = torque_balance(model.effect_ids, free_parameters(model), tuple(weak.shown))
    return weak, balance.torques(model.values(), weak.motion)


def whitened(model: Model, recording: Measurement) -> Array:
    """Whitened residuals of a model."""
    weak, torques = torques_of(model, recording)
    values = model.values()
    return weak.whitener(values, torques)(weak.residuals(values, torques))


def correlation(residuals: Array, lag: int) -> float:
    return float(np.corrcoef(residuals[lag:], residuals[:-lag])[0, 1])


@pytest.mark.parametrize("effect_ids", HIDDEN, ids="+".join)
def test_without_noise_next_to_nothing_is_left(effect_ids: tuple[str, ...]) -> None:
    model = typical_model(*effect_ids)
    quiet = played(model).recording().with_noise({"joint_position": NOISE})
    # torques are evaluated every 4 ms; the load begins at once, which smoothing rounds off
    left = whitened(model, quiet)[STARTING:]
    assert np.sqrt(np.mean(left**2)) < 0.1


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("effect_ids", HIDDEN, ids="+".join)
def test_noise_of_the_true_model_is_white_and_of_variance_one(
    effect_ids: tuple[str, ...], seed: int
) -> None:
    model = typical_model(*effect_ids)
    noisy = played(model).recording(NOISE, seed).with_noise({"joint_position": NOISE})
    left = whitened(model, noisy)
    assert np.mean(left**2) == pytest.approx(1.0, abs=0.1)
    # 3 sigma of a correlation by chance, and a little
    assert all(abs(correlation(left, lag)) < 3.5 / np.sqrt(len(left)) for lag in (1, 2, 3, 5))


def test_a_missing_effect_is_left() -> None:
    noisy = played(typical_model("gravity_load")).recording(NOISE)
    assert np.mean(whitened(GIVEN, noisy) ** 2) > 10.0


@pytest.mark.parametrize("name", ["joint_torque", "motor_torque"])
def test_a_measured_torque_is_a_second_half_of_residuals(name: str) -> None:
    model, level = GIVEN, 0.02
    run = played(model)
    torques = torque_balance((), (), (name,)).torques(model.values(), run.motion)
    noisy = run.recording(NOISE)
    shown = torques.shown[name].value
    shown = shown + level * np.random.default_rng(3).standard_normal(len(shown))
    both = replace(noisy, signals={**noisy.signals, name: shown})
    left = whitened(model, both)
    assert len(left) == 2 * len(whitened(model, noisy))
    for half in np.split(left, 2):
        assert np.mean(half**2) == pytest.approx(1.0, abs=0.15)


def test_derivatives_are_those_of_the_residuals() -> None:
    model = GIVEN
    weak, torques = torques_of(model, played(model).recording())
    paths = free_parameters(model)
    balance = torque_balance((), paths)
    jacobian = weak.jacobian(torques, paths)
    for number, path in enumerate(paths):
        step = 1e-6 * abs(model.values()[path]) or 1e-6 * model.uncertainty_of(path)
        beside = []
        for sign in (1.0, -1.0):
            values = {**model.values(), path: model.values()[path] + sign * step}
            along = balance.torques(values, weak.motion)
            beside.append(weak.residuals(values, along))
        difference = (beside[0] - beside[1]) / (2.0 * step)
        size = np.max(np.abs(jacobian[:, number]))
        # smoothing takes a little of the motion, which the derivatives leave out
        assert np.quantile(np.abs(difference - jacobian[:, number]), 0.95) < 0.02 * size


def static_curve(rows: int = 60) -> Measurement:
    """Deflection under a slow load, both tendons taut, with noise."""
    stiffness = 2.0 * 2.0 * 11580.0 * 0.03**2
    load = 1.5 * np.sin(np.linspace(0.0, 2.0 * np.pi, rows))
    noise = NOISE * np.random.default_rng(4).standard_normal(rows)
    time = 1000.0 * np.arange(rows)
    signals = {"joint_position": load / stiffness + noise}
    curve = Measurement(time, 0.0 * time, signals, load_torque=load, static=True, name="curve")
    return curve.with_noise({"joint_position": NOISE})


def test_every_row_of_a_static_curve_is_a_balance() -> None:
    curve = static_curve()
    weak, torques = torques_of(GIVEN, curve)
    assert weak.test.shape[0] == len(curve.time)
    assert np.mean(whitened(GIVEN, curve) ** 2) == pytest.approx(1.0, abs=0.5)
    paths = free_parameters(GIVEN)
    by_inertia = weak.jacobian(torques, paths)[:, paths.index("link.inertia")]
    assert not np.any(by_inertia)  # nothing accelerates


def test_uneven_samples_are_brought_to_even_ones() -> None:
    run = played(GIVEN)
    rng = np.random.default_rng(5)
    moved = run.time.copy()
    moved[1:-1] += 0.3 * 0.002 * rng.uniform(-1.0, 1.0, len(moved) - 2)
    noise = NOISE * rng.standard_normal(len(moved))
    uneven = Measurement(
        name="uneven",
        time=moved,
        motor_position=CubicSpline(run.time, run.motor)(moved),
        signals={"joint_position": run.joint(moved) + noise},
        load_torque=CubicSpline(run.time, run.load)(moved),
        interpolation="cubic",
    ).with_noise({"joint_position": NOISE})
    # interpolation takes a part of the noise, so that less than one is left
    assert 0.4 < np.mean(whitened(GIVEN, uneven) ** 2) < 1.1


@pytest.mark.parametrize("samples", [60, 200])
def test_short_recordings_have_residuals_too(samples: int) -> None:
    short = played(GIVEN).recording(NOISE).samples(slice(0, samples))
    left = whitened(GIVEN, short.with_noise({"joint_position": NOISE}))
    assert len(left) > 3
    assert np.isfinite(left).all()
    assert np.mean(left**2) < 3.0


@pytest.mark.parametrize("n", [50, 3000])
def test_a_line_stays_as_it_is(n: int) -> None:
    line = np.linspace(0.3, -1.7, n)
    smoothed, gain = smooth(line)
    np.testing.assert_allclose(smoothed, line, rtol=0, atol=1e-12)
    assert gain[0] == 1.0
    assert np.all(np.diff(gain) <= 0.0)


def test_smoothing_takes_noise_away_and_keeps_the_motion() -> None:
    run = played(GIVEN)
    true = run.joint(run.time)
    smoothed, _ = smooth(run.recording(NOISE).signals["joint_position"])
    assert np.std(smoothed - true) < 0.5 * NOISE
