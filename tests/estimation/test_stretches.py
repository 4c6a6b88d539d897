"""Stretches of time that are left out, against leaving them out by hand."""

from dataclasses import replace

import numpy as np
import pytest

from elastic_tendon.actuator.parameters import load_model
from elastic_tendon.estimation.stretches import independent_facts, left_out, stretch_numbers
from elastic_tendon.measurement import Measurement


def recording(samples: int, *, signals: int = 1, static: bool = False) -> Measurement:
    time = np.arange(samples) / 500.0
    names = ("joint_position", "joint_torque")[:signals]
    return Measurement(
        name="made",
        time=time,
        motor_position=np.zeros(samples),
        signals={name: np.zeros(samples) for name in names},
        load_torque=None,
        interpolation="cubic",
        static=static,
    )


def test_moves_are_those_of_least_squares_without_the_stretch() -> None:
    rng = np.random.default_rng(1)
    columns, errors = rng.standard_normal((60, 3)), rng.standard_normal(60)
    prior = 0.5 * np.eye(3)
    full, target = np.vstack([columns, prior]), np.concatenate([errors, np.zeros(3)])
    # at the optimum of all, as after a fit
    best = np.linalg.lstsq(full, -target)[0]
    at_best = target + full @ best
    numbers = np.arange(60) // 20
    moves = left_out(full, at_best, numbers)
    for stretch in range(3):
        kept = np.concatenate([numbers != stretch, np.ones(3, dtype=bool)])
        alone = np.linalg.lstsq(full[kept], -at_best[kept])[0]
        assert moves[stretch] == pytest.approx(alone, rel=1e-9)


def test_every_sample_is_in_one_stretch_and_signals_share_them() -> None:
    numbers = stretch_numbers([recording(5000, signals=2), recording(2500)], 1.0)
    assert len(numbers) == 12500
    assert np.array_equal(numbers[:5000], numbers[5000:10000])
    assert numbers[10000] == numbers[9999] + 1
    assert set(numbers) == set(range(int(numbers.max()) + 1))


def test_long_memory_makes_few_stretches_and_none_makes_many() -> None:
    one = [recording(5000)]
    assert stretch_numbers(one, 5000.0).max() + 1 == 10
    assert stretch_numbers(one, 1.0).max() + 1 == 20  # half a second each


def test_rows_of_a_static_curve_have_no_seconds() -> None:
    assert stretch_numbers([recording(200, static=True)], 1.0).max() + 1 == 20


def test_white_samples_are_facts_and_a_drift_is_few() -> None:
    model, one = load_model("biorob_x4_joint_3"), recording(5000)
    rng = np.random.default_rng(2)
    white = rng.standard_normal(5000)
    assert independent_facts(model, [one], white) == pytest.approx(5000, rel=0.1)
    drift = np.linspace(1.0, 2.0, 5000)
    assert independent_facts(model, [one], drift) < 60
    # of a tenth of the noise that was given the high frequencies know, of the rest nobody
    noisy = replace(
        one, signals={"joint_position": 1e-3 * white}, given_noise={"joint_position": 3e-3}
    )
    assert independent_facts(model, [noisy], white) == pytest.approx(5000 / 9, rel=0.15)
