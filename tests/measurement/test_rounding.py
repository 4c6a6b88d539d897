"""An encoder that rests hides where within its step the joint is, however many samples say so."""

import numpy as np
import pytest

from elastic_tendon.comparison.residuals import beyond_rounding
from elastic_tendon.diagnosis.answer import refit
from elastic_tendon.estimation.fit import QUICK
from elastic_tendon.measurement import Measurement
from elastic_tendon.simulation.simulate import simulate
from smooth_motion import GIVEN

STEP = 4e-4  # rad, of the encoder
TIME = np.arange(0.0, 6.0, 0.002)


def counted(position: np.ndarray) -> Measurement:
    """What an encoder shows of a joint beside a motor that stands still."""
    return recorded(position, np.zeros_like(TIME))


def recorded(position: np.ndarray, load: np.ndarray) -> Measurement:
    signals = {"joint_position": STEP * np.round(position / STEP)}
    still = np.zeros_like(TIME)
    return Measurement(time=TIME, motor_position=still, signals=signals, load_torque=load)


@pytest.fixture(scope="module")
def decay() -> Measurement:
    """The joint swings for some seconds and then rests between two steps."""
    load = np.full_like(TIME, 0.013)  # N·m
    run = simulate(GIVEN, TIME, np.zeros_like(TIME), load, initial_state={"joint_position": 0.05})
    return recorded(run["joint_position"], load)


def test_only_rests_hide_something(decay) -> None:
    half = decay.rounding["joint_position"]
    resting = half > 0.0
    np.testing.assert_allclose(half[resting], 0.5 * STEP)
    assert resting[-1000:].all()
    assert not resting[:500].any()


@pytest.mark.parametrize(
    "position",
    [
        0.3 * np.sin(3.0 * TIME),
        5e-4 * TIME,  # every stretch of one value is long
        0.1 * np.exp(-TIME) + 2e-4 * np.random.default_rng(1).standard_normal(TIME.size),
    ],
    ids=["swings", "creeps", "noisy"],
)
def test_what_moves_or_is_noisy_hides_nothing(position) -> None:
    assert dict(counted(position).rounding) == {}


def test_errors_within_the_step_count_for_nothing_and_others_from_its_edge(decay) -> None:
    resting = decay.rounding["joint_position"] > 0.0
    for error, left in ((0.4 * STEP, 0.0), (-0.5 * STEP, 0.0), (-2.0 * STEP, -1.5 * STEP)):
        found = beyond_rounding({"joint_position": np.full(TIME.size, error)}, decay)
        np.testing.assert_allclose(found["joint_position"][resting], left, atol=1e-12)
        np.testing.assert_allclose(found["joint_position"][~resting], error)


def test_a_fit_is_not_drawn_to_the_middle_of_the_step(decay) -> None:
    answer = refit(GIVEN, (), [decay], effort=QUICK)
    moving = decay.rounding["joint_position"] == 0.0
    assert np.mean(answer.floored[moving] ** 2) == pytest.approx(1.0, abs=0.15)
    assert np.mean(answer.floored[~moving] ** 2) < 0.01
    hidden = answer.floored == 0.0
    assert np.mean(hidden[~moving]) > 0.9
    slopes = answer.result.problem.jacobian(answer.result.vector, answer.result.sigmas)
    assert not slopes[: TIME.size][hidden].any()
