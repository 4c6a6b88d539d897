"""The comparison's figures, over all and in each slack state."""

import numpy as np
import pytest

from elastic_tendon.actuator.parameters import load_model
from elastic_tendon.actuator.transmission import characteristic_torque, slack_boundaries
from elastic_tendon.comparison.compare import compare
from elastic_tendon.measurement import Measurement


def test_true_model_reaches_the_noise(frictionless) -> None:
    known, recording = frictionless
    error = compare(known.model.with_values(known.truth), [recording]).files[0].signals
    assert error["joint_position"].rmse == pytest.approx(known.noise, rel=0.1)
    assert error["joint_position"].noise_ratio == pytest.approx(1.0, abs=0.1)
    assert error["joint_position"].fit_percent > 99.0
    assert abs(error["joint_position"].bias) < 0.2 * known.noise


def test_figures_are_what_their_names_say(frictionless) -> None:
    known, recording = frictionless
    file = compare(known.model, [recording]).files[0]
    error = file.signals["joint_position"]
    measured = recording.signals["joint_position"]
    difference = file.trajectory["joint_position"] - measured
    assert error.rmse == pytest.approx(np.sqrt(np.mean(difference**2)))
    assert error.max_abs == pytest.approx(np.max(np.abs(difference)))
    assert error.bias == pytest.approx(np.mean(difference))
    spread = np.linalg.norm(measured - np.mean(measured))
    assert error.fit_percent == pytest.approx(100 * (1 - np.linalg.norm(difference) / spread))


def test_pooled_error_weighs_by_samples(sticking) -> None:
    known, first, second = sticking
    comparison = compare(known.model, [first, second])
    squares = [
        len(file.measurement.time) * file.signals["joint_position"].rmse ** 2
        for file in comparison.files
    ]
    expected = np.sqrt(sum(squares) / (len(first.time) + len(second.time)))
    assert comparison.rmse()["joint_position"] == pytest.approx(expected)


def test_slack_states_split_the_figures(frictionless) -> None:
    known, recording = frictionless
    file = compare(known.model, [recording]).files[0]
    error = file.signals["joint_position"]
    # the model and the machine reflect the motor alike; (14) at what was measured
    measured = recording.signals["joint_position"] - recording.motor_position
    low, high = slack_boundaries(known.model.transmission)
    states = np.where(measured > high, 2.0, np.where(measured < low, 1.0, 3.0))
    names = {1.0: "I", 2.0: "II", 3.0: "III"}
    assert set(error.slack_states) == {names[state] for state in np.unique(states)}
    assert len(error.slack_states) > 1
    assert sum(slack_state.count for slack_state in error.slack_states.values()) == error.count
    difference = file.trajectory["joint_position"] - recording.signals["joint_position"]
    taut = error.slack_states["III"]
    assert taut.rmse == pytest.approx(np.sqrt(np.mean(difference[states == 3.0] ** 2)))
    assert taut.max_abs == pytest.approx(np.max(np.abs(difference[states == 3.0])))
    assert taut.noise_ratio == pytest.approx(taut.rmse / error.noise.sigma)
    squares = sum(
        slack_state.count * slack_state.rmse**2 for slack_state in error.slack_states.values()
    )
    assert np.sqrt(squares / error.count) == pytest.approx(error.rmse)


def test_the_noise_is_the_measurements_own(frictionless) -> None:
    known, recording = frictionless
    error = compare(known.model, [recording]).files[0].signals["joint_position"]
    assert error.noise == recording.noise["joint_position"]


@pytest.mark.parametrize("torque_noise", [0.0, 0.03, 0.2])
def test_noise_of_a_static_curves_torque_belongs_to_its_floor(torque_noise: float) -> None:
    model = load_model("biorob_x4_joint_3")
    deflection = np.concatenate([np.linspace(0.3, -0.3, 200), np.linspace(-0.3, 0.3, 200)])
    rng = np.random.default_rng(12)
    load = -characteristic_torque(deflection, model.transmission)
    load += torque_noise * rng.standard_normal(400)
    position = deflection + 5e-4 * rng.standard_normal(400)
    time = 10.0 * np.arange(400.0)
    signals = {"joint_position": position}
    sweep = Measurement(time, 0.0 * time, signals, load_torque=load, static=True, name="sweep")
    error = compare(model, [sweep]).files[0].signals["joint_position"]
    assert error.noise_ratio == pytest.approx(1.0, abs=0.15)
