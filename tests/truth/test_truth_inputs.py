"""Signals, experiments, sensors and tables of the truth."""

import math
from collections.abc import Callable

import numpy as np
import pytest

from truth.actuator import Actuator, Link, Spring
from truth.experiments import (
    Limits,
    free_decay,
    limits_of,
    multisine,
    peak,
    slow_sweep,
    steps_with_load_pulses,
    within_deflection,
)
from truth.noise import Sensor, coloured_noise, counts, measured
from truth.sampling import sample
from truth.signals import (
    Experiment,
    Signal,
    constant,
    piecewise_linear,
    product,
    scaled,
    sines,
    smooth_pulse,
    smooth_step,
    total,
)
from truth.solver import simulate

SPRING = Spring(stiffness=23_160.0, max_deflection=0.015)
ACTUATOR = Actuator(0.03, 0.03, 80.0, SPRING, SPRING, Link(inertia=0.03, damping=0.16))
LIMITS = Limits(deflection=0.3, speed=4.0, torque=5.0)

SIGNALS = {
    "constant": constant(0.4),
    "sines": sines([1.0, 0.5], [0.7, 2.0], [0.1, 1.0]),
    "step": smooth_step(0.2, 0.5, -2.0),
    "pulse": smooth_pulse(0.1, 0.7, 1.5, 0.2),
    "lines": piecewise_linear([0.0, 0.4, 1.0], [0.0, 1.0, -1.0]),
    "composed": total(
        scaled(sines([1.0], [1.0], [0.0]), 0.3),
        product(smooth_step(0.0, 0.5, 1.0), sines([1.0], [2.0], [0.0])),
    ),
}


@pytest.mark.parametrize("signal", SIGNALS.values(), ids=SIGNALS.keys())
def test_rates_are_derivatives(signal: Signal) -> None:
    # the second derivative of none is above 1e3, so the difference is good to 1e-6
    step = 1e-5
    for time in np.linspace(0.013, 0.987, 60):
        difference = (signal.value(time + step) - signal.value(time - step)) / (2 * step)
        assert signal.rate(time) == pytest.approx(difference, abs=1e-6)


@pytest.mark.parametrize("experiment", [multisine, steps_with_load_pulses, free_decay, slow_sweep])
def test_experiments_follow_from_seed_and_limits(
    experiment: Callable[[int, Limits], Experiment],
) -> None:
    first, again, other = experiment(3, LIMITS), experiment(3, LIMITS), experiment(4, LIMITS)
    times = np.arange(0.0, first.duration, 0.01).tolist()

    def everything(of: Experiment) -> list[float]:
        inputs = [of.motor_position.value(t) + 10 * of.load_torque.value(t) for t in times]
        return [of.initial_position, *inputs]

    assert everything(first) == everything(again)
    assert experiment is slow_sweep or everything(first) != everything(other)
    assert peak(first.motor_position, first.duration, of_rate=True) <= LIMITS.speed * (1 + 1e-9)
    # no two load pulses overlap
    assert peak(first.load_torque, first.duration) <= LIMITS.torque
    assert abs(first.initial_position) <= LIMITS.deflection


def test_motions_use_the_speed_they_may() -> None:
    for experiment in (multisine(1, LIMITS), steps_with_load_pulses(1, LIMITS)):
        speed = peak(experiment.motor_position, experiment.duration, of_rate=True)
        assert speed > 0.9 * LIMITS.speed


def test_limits_of_an_actuator_are_the_papers() -> None:
    # (37), and R k l_max of the table of numbers to reproduce
    limits = limits_of(ACTUATOR, speed=4.0)
    assert limits.deflection == pytest.approx(0.385, abs=5e-4)
    assert limits.torque == pytest.approx(10.42, abs=5e-3)


def test_a_motion_is_made_to_fit_the_deflection_limit() -> None:
    wild = multisine(1, Limits(deflection=0.1, speed=8.0, torque=8.0), duration=3.0)
    time = np.arange(0.0, 3.0, 0.002)
    before = simulate(ACTUATOR, wild, time)["deflection"]
    after = simulate(ACTUATOR, within_deflection(ACTUATOR, wild, 0.1), time)["deflection"]
    assert np.max(np.abs(before)) > 0.15
    # the search is at 1e-6 and need not go below 80 % of what is allowed
    assert 0.08 < np.max(np.abs(after)) < 0.1 + 1e-5


def test_noise_is_what_it_says() -> None:
    n = 40_000
    white = measured(np.zeros(n), Sensor(white=2e-4), np.random.default_rng(1))
    assert np.std(white) == pytest.approx(2e-4, rel=0.02)
    assert abs(np.corrcoef(white[1:], white[:-1])[0, 1]) < 0.02
    coloured = coloured_noise(np.random.default_rng(2), n, 3e-4, 0.9)
    # 40 000 samples of this correlation count for 2 000
    assert np.std(coloured) == pytest.approx(3e-4, rel=0.06)
    assert np.corrcoef(coloured[1:], coloured[:-1])[0, 1] == pytest.approx(0.9, abs=0.01)
    # stationary from the first sample on
    firsts = [coloured_noise(np.random.default_rng(seed), 1, 1.0, 0.9)[0] for seed in range(2000)]
    assert np.std(firsts) == pytest.approx(1.0, rel=0.06)


def test_an_encoder_shows_whole_counts() -> None:
    step = counts(14)
    assert step == pytest.approx(2 * math.pi / 16_384)
    ramp = np.linspace(0.0, 0.1, 5001)
    shown = measured(ramp, Sensor(step=step), np.random.default_rng(0))
    np.testing.assert_allclose(shown / step, np.round(shown / step), rtol=0, atol=1e-9)
    assert np.max(np.abs(shown - ramp)) <= 0.5 * step * (1 + 1e-9)
    assert np.std(shown - ramp) == pytest.approx(step / math.sqrt(12), rel=0.02)


def test_a_table_has_the_contracts_columns_and_noise_only_where_asked() -> None:
    run = simulate(ACTUATOR, multisine(1, LIMITS, duration=2.0), np.arange(0.0, 2.0, 0.01))
    sensors = {"joint_position": Sensor(white=1e-4)}
    table = sample(run, sensors, seed=5)
    assert list(table) == [
        "time_s",
        "motor_position_rad",
        "joint_position_rad",
        "load_torque_Nm",
    ]
    np.testing.assert_array_equal(table["motor_position_rad"], run["motor_position"])
    noise = table["joint_position_rad"] - run["joint_position"]
    assert 0.5e-4 < np.std(noise) < 2e-4
    more = sample(run, sensors, seed=5, signals=("joint_torque", "joint_position"))
    np.testing.assert_array_equal(more["joint_position_rad"], table["joint_position_rad"])
    np.testing.assert_array_equal(more["joint_torque_Nm"], run["joint_torque"])
    other = sample(run, sensors, seed=6)["joint_position_rad"]
    assert not np.array_equal(other, table["joint_position_rad"])
