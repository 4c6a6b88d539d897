"""Residuals, their derivatives, and how many facts a series of errors holds."""

import numpy as np
import pytest
from scipy.optimize import brentq

from elastic_tendon.actuator.parameters import load_model
from elastic_tendon.actuator.transmission import characteristic_torque
from elastic_tendon.comparison.initial_state import estimate_initial_state
from elastic_tendon.comparison.residuals import (
    InitialState,
    autocorrelation_time,
    effective_sigma,
    residuals_of,
    sensitivity,
    simulate_measurement,
)
from elastic_tendon.errors import SimulationError
from elastic_tendon.measurement import Measurement
from elastic_tendon.simulation.simulate import simulate

# central differences with a step of 1e-4 of the value, across slack crossings
DIFFERENCE_TOLERANCE = 1e-3


def autoregressive(rng: np.random.Generator, n: int, correlation: float) -> np.ndarray:
    values = rng.standard_normal(n)
    for index in range(1, n):
        values[index] += correlation * values[index - 1]
    return values


@pytest.mark.parametrize("correlation", [0.0, 0.5, 0.9])
def test_autocorrelation_time_of_an_autoregressive_series(correlation: float) -> None:
    series = autoregressive(np.random.default_rng(1), 100_000, correlation)
    exact = (1.0 + correlation) / (1.0 - correlation)
    # the truncated sum scatters by about sqrt(window / n)
    assert autocorrelation_time(series) == pytest.approx(exact, rel=0.1)


def test_constant_error_is_about_one_fact() -> None:
    n = 1000
    assert autocorrelation_time(np.ones(n)) > n / 3
    assert autocorrelation_time(np.zeros(n)) == 1.0


def test_effective_sigma_is_the_noise_where_the_model_is_right() -> None:
    noise = 0.1 * np.random.default_rng(2).standard_normal(20_000)
    assert effective_sigma(noise, 0.1) == pytest.approx(0.1, rel=0.1)
    assert effective_sigma(0.01 * noise, 0.1) >= 0.1


def test_derivatives_agree_with_differences(frictionless) -> None:
    known, recording = frictionless
    initial = InitialState(0.01, 0.1)
    path = "link.inertia"
    exact = sensitivity(known.model, recording, initial, [path]).derivatives["joint_position"]
    step = 1e-4 * known.model.values()[path]

    def position(model, state):
        trajectory = simulate_measurement(model, recording, state)
        return residuals_of(trajectory, recording)["joint_position"]

    value = known.model.values()[path]
    by_inertia = (
        position(known.model.with_values({path: value + step}), initial)
        - position(known.model.with_values({path: value - step}), initial)
    ) / (2.0 * step)
    by_velocity = (
        position(known.model, InitialState(0.01, 0.101))
        - position(known.model, InitialState(0.01, 0.099))
    ) / 0.002
    for column, difference in ((0, by_inertia), (2, by_velocity)):
        scale = np.max(np.abs(difference))
        error = np.max(np.abs(exact[:, column] - difference))
        assert error < DIFFERENCE_TOLERANCE * scale


def test_initial_state_in_motion_is_found(frictionless) -> None:
    known, recording = frictionless
    model = known.model.with_values(known.truth)
    middle = recording.window(2.0, None)
    found = estimate_initial_state(model, middle)
    trajectory = simulate_measurement(model, recording, estimate_initial_state(model, recording))
    index = int(np.searchsorted(recording.time, middle.time[0]))
    # 26 samples of 0.2 mrad noise over 0.1 s: about 0.1 mrad and a few mrad/s
    assert found.position == pytest.approx(trajectory["joint_position"][index], abs=5e-4)
    assert found.velocity == pytest.approx(trajectory["joint_velocity"][index], abs=2e-2)


@pytest.mark.parametrize("interpolation", ["hold", "linear", "cubic"])
def test_initial_state_is_estimated_with_the_recordings_own_interpolation(interpolation) -> None:
    """A fast motor: the wrong interpolation errs by 2 mrad and 0.1 rad/s.

    The samples are dense enough that the spline through the first 0.1 s is that of the whole.
    """
    model = load_model("biorob_x4_joint_3")
    time = np.arange(0.0, 1.0, 0.01)
    motor = 0.3 * np.sin(30.0 * time + 1.0)
    start = InitialState(0.2, 3.0)
    made = simulate(model, time, motor, initial_state=start.as_dict(), interpolation=interpolation)
    signals = {"joint_position": made["joint_position"]}
    recording = Measurement(time, motor, signals, interpolation=interpolation, name="made")
    found = estimate_initial_state(model, recording)
    assert found.position == pytest.approx(start.position, abs=1e-6)
    assert found.velocity == pytest.approx(start.velocity, abs=1e-4)


@pytest.mark.parametrize("delay", [0.03, 0.06, 0.2])
def test_a_late_sensor_does_not_spoil_the_initial_state(delay: float) -> None:
    """The window opens in motion; once the delay is over the right model moves as recorded."""
    model = load_model("biorob_x4_joint_3").with_effect("measurement_delay", {"delay": delay})
    time = np.arange(0.0, 3.0, 0.002)
    motor = 0.4 * np.sin(6.0 * time)
    made = simulate(model, time, motor, as_measured=True)
    position = made[made.measured("joint_position")]
    moving = Measurement(time, motor, {"joint_position": position}, name="made").window(1.1, None)
    trajectory = simulate_measurement(model, moving, estimate_initial_state(model, moving))
    after = moving.time - moving.time[0] > delay + 0.01
    error = residuals_of(trajectory, moving)["joint_position"][after]
    assert np.max(np.abs(error)) < 5e-4


def test_a_delay_longer_than_the_recording_is_no_obstacle() -> None:
    model = load_model("biorob_x4_joint_3").with_effect("measurement_delay", {"delay": 0.9})
    time = np.arange(0.0, 0.1, 0.01)
    position = {"joint_position": 0.1 + 0.0 * time}
    found = estimate_initial_state(model, Measurement(time, 0.0 * time, position, name="short"))
    assert np.isfinite([found.position, found.velocity]).all()


@pytest.mark.parametrize("damping", [0.0, 0.16])
def test_a_static_curve_starts_where_its_first_load_holds_the_joint(damping: float) -> None:
    model = load_model("biorob_x4_joint_3").with_values({"link.damping": damping})
    load = np.linspace(3.0, 4.0, 12)
    held = brentq(lambda q: characteristic_torque(q, model.transmission) + load[0], -1.0, 1.0)
    time = 10.0 * np.arange(12.0)
    # the machine is softer than the model, so that it was measured elsewhere
    signals = {"joint_position": 1.3 * load / 41.7}
    sweep = Measurement(time, 0.0 * time, signals, load_torque=load, static=True, name="sweep")
    found = estimate_initial_state(model, sweep)
    assert found.position == pytest.approx(held, abs=1e-5)
    assert found.velocity == 0.0


def test_what_swings_far_faster_than_the_samples_is_given_up() -> None:
    """It kept a refit for hours: a spring's mass without damping that tends to none."""
    model = load_model("biorob_x4_joint_3").with_effect("spring_mass", {"mass": 1e-15})
    time = np.linspace(0.0, 0.4, 81)
    recording = Measurement(time=time, motor_position=0.1 * np.sin(7.0 * time), signals={})
    with pytest.raises(SimulationError, match="far too many steps would be needed"):
        simulate_measurement(model, recording, InitialState(0.0, 0.0))
