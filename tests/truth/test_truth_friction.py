"""The truth's dry friction against closed forms of sliders."""

import math
from dataclasses import replace

import numpy as np
import pytest

from truth.actuator import Actuator, Link, Spring
from truth.friction import Coulomb, Dahl
from truth.signals import Experiment, constant, piecewise_linear, sines
from truth.solver import simulate

POSITION_ERROR = 1e-9  # rad, at the default tolerance of 1e-11
EVENT_TIME_ERROR = 1e-9  # s; a release grows with the square of time, so its instant is soft

INERTIA, TORQUE = 0.04, 0.5
SPRING = Spring(stiffness=8000.0)
SLIDER = Actuator(0.05, 0.05, 500.0, SPRING, SPRING, Link(INERTIA, friction=Coulomb(TORQUE)))
STIFFNESS = 0.05**2 * 2 * 8000.0  # state III (25), N·m/rad
FREQUENCY = math.sqrt(STIFFNESS / INERTIA)  # rad/s


def test_a_body_on_friction_stops_after_its_stopping_distance() -> None:
    # springs so weak that they move the stop by less than the position error
    weak = Spring(stiffness=1e-7)
    body = replace(SLIDER, pretension_force=1e-6, upper=weak, lower=weak)
    speed = 3.0
    run = simulate(
        body, Experiment(1.0, constant(0.0), initial_velocity=speed), np.linspace(0.0, 1.0, 101)
    )
    (stop,) = run.events
    assert stop.after.direction == 0
    assert stop.time == pytest.approx(speed * INERTIA / TORQUE, abs=EVENT_TIME_ERROR)
    distance = INERTIA * speed**2 / (2 * TORQUE)
    assert run["joint_position"][-1] == pytest.approx(distance, abs=POSITION_ERROR)
    assert np.all(run["joint_velocity"][run.time > stop.time] == 0.0)


def test_a_spring_slider_loses_the_same_at_every_turn_and_then_sticks() -> None:
    start, lost = 0.11, 2 * TORQUE / STIFFNESS
    held = Experiment(2.0, constant(0.0), initial_position=start)
    turns = math.ceil((start - lost / 2) / lost)  # until the spring is below the friction
    time = np.append(np.arange(turns + 1) * math.pi / FREQUENCY, 2.0)
    run = simulate(SLIDER, held, time)
    expected = [(-1) ** n * (start - n * lost) for n in range(turns + 1)]
    np.testing.assert_allclose(
        run["joint_position"], [*expected, expected[-1]], rtol=0, atol=POSITION_ERROR
    )
    assert len(run.events) == turns
    assert run.events[-1].after.direction == 0
    assert run.events[-1].time == pytest.approx(turns * math.pi / FREQUENCY, abs=EVENT_TIME_ERROR)
    # at rest friction carries exactly what the springs pull
    assert run["friction_torque"][-1] == pytest.approx(-STIFFNESS * expected[-1], abs=1e-7)


def test_a_driven_slider_breaks_loose_when_the_spring_reaches_the_friction() -> None:
    speed = 0.2
    release = TORQUE / (STIFFNESS * speed)
    ramp = piecewise_linear([0.0, 1.0], [0.0, speed])
    end = release + 1.5 * math.pi / FREQUENCY
    time = np.linspace(0.0, end, 401)
    run = simulate(SLIDER, Experiment(end, ramp), time)
    assert run.events[0].before.direction == 0
    assert run.events[0].time == pytest.approx(release, abs=EVENT_TIME_ERROR)
    since = np.maximum(time - release, 0.0)
    expected = speed * (since - np.sin(FREQUENCY * since) / FREQUENCY)
    np.testing.assert_allclose(run["joint_position"], expected, rtol=0, atol=POSITION_ERROR)


def test_friction_obeys_its_law_in_every_sample() -> None:
    experiment = Experiment(4.0, sines([0.03, 0.02], [0.7, 2.9], [0.0, 0.4]))
    run = simulate(SLIDER, experiment, np.linspace(0.0, 4.0, 4001))
    velocity, friction = run["joint_velocity"], run["friction_torque"]
    stuck = velocity == 0.0
    assert 0.05 < np.mean(stuck) < 0.95
    assert np.all(np.abs(friction[stuck]) <= TORQUE + 1e-9)
    np.testing.assert_array_equal(friction[~stuck], TORQUE * np.sign(velocity[~stuck]))


def test_dahl_friction_saturates_exponentially_with_travel() -> None:
    # one way only: torque = T (1 - exp(-σ q / T)) whatever the speed
    sigma = 20.0
    slider = replace(SLIDER, link=Link(INERTIA, friction=Dahl(TORQUE, sigma)))
    ramp = piecewise_linear([0.0, 1.0], [0.0, 0.5])
    run = simulate(slider, Experiment(0.5, ramp), np.linspace(0.0, 0.5, 101))
    assert np.all(run["joint_velocity"] >= 0.0)
    expected = TORQUE * (1.0 - np.exp(-sigma * run["joint_position"] / TORQUE))
    np.testing.assert_allclose(run["friction_torque"], expected, rtol=0, atol=1e-7)
    assert run["friction_torque"][-1] > 0.9 * TORQUE


def test_a_stiffer_dahl_bristle_comes_nearer_to_coulomb() -> None:
    experiment = Experiment(1.0, sines([0.15], [1.5], [0.0]))
    time = np.linspace(0.0, 1.0, 201)
    coulomb = simulate(SLIDER, experiment, time)["joint_position"]

    def difference(sigma: float) -> float:
        slider = replace(SLIDER, link=Link(INERTIA, friction=Dahl(TORQUE, sigma)))
        return float(np.max(np.abs(simulate(slider, experiment, time)["joint_position"] - coulomb)))

    # the bristle turns the last velocity into a swing; what that shifts falls as 1 / sqrt(σ)
    soft, stiff = difference(500.0), difference(5000.0)
    assert soft / stiff == pytest.approx(math.sqrt(10.0), rel=0.1)


def test_no_friction_and_vanishing_friction_agree() -> None:
    experiment = Experiment(1.0, sines([0.1], [1.1], [0.0]))
    time = np.linspace(0.0, 1.0, 101)
    none, tiny = (
        simulate(replace(SLIDER, link=Link(INERTIA, friction=friction)), experiment, time)
        for friction in (None, Coulomb(1e-9))
    )
    np.testing.assert_allclose(
        none["joint_position"], tiny["joint_position"], rtol=0, atol=POSITION_ERROR
    )
