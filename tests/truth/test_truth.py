"""The truth is right about what has a closed form: springs, slack, energy, loads, convergence."""

import ast
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from truth.actuator import Actuator, Link, Overstretch, Spring
from truth.signals import Experiment, constant, piecewise_linear, rectangular_pulse, sines
from truth.solver import simulate

# integration error at the default tolerance of 1e-11 gathered over some seconds, rad
POSITION_ERROR = 1e-9
# events are located within the hysteresis and the position error, over ordinary rates
EVENT_TIME_ERROR = 1e-10

ASYMMETRIC = Actuator(
    joint_pulley_radius=0.04,
    motor_pulley_radius=0.025,
    pretension_force=60.0,
    upper=Spring(stiffness=9000.0),
    lower=Spring(stiffness=6500.0),
    link=Link(inertia=0.025),
)


def angular_frequency(actuator: Actuator, *springs: Spring) -> float:
    """Natural frequency while only these springs are taut: (19), (23), (25), rad/s."""
    stiffness = actuator.joint_pulley_radius**2 * sum(spring.stiffness for spring in springs)
    return math.sqrt(stiffness / actuator.link.inertia)


def spring_energy(spring: Spring, elongation: np.ndarray) -> np.ndarray:
    """Energy of a taut spring and of its exactly kinked string, J."""
    energy: np.ndarray = 0.5 * spring.stiffness * np.maximum(elongation, 0.0) ** 2
    if spring.overstretch is not None:
        excess = np.maximum(elongation - spring.overstretch.engagement, 0.0)
        energy += 0.5 * spring.overstretch.stiffness * excess**2
    return energy


def test_shares_no_code_with_the_product() -> None:
    imported = set()
    for file in Path(__file__).parent.glob("*.py"):
        for node in ast.walk(ast.parse(file.read_text())):
            if isinstance(node, ast.Import):
                imported |= {alias.name.split(".")[0] for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and node.module:
                imported.add(node.module.split(".")[0])
    assert "truth" in imported
    assert "elastic_tendon" not in imported


@pytest.mark.parametrize(
    "overstretch", [None, Overstretch(engagement=0.018, stiffness=30_000.0)], ids=["plain", "kink"]
)
def test_undamped_energy_stays_through_slack(overstretch: Overstretch | None) -> None:
    actuator = replace(
        ASYMMETRIC,
        upper=replace(ASYMMETRIC.upper, overstretch=overstretch),
        lower=replace(ASYMMETRIC.lower, overstretch=overstretch),
    )
    motor = 0.3
    held = Experiment(10.0, constant(motor), initial_position=-0.2, initial_velocity=3.0)
    run = simulate(actuator, held, np.linspace(0.0, 10.0, 2001))
    displacement = 0.025 * motor - 0.04 * run["joint_position"]
    energy = 0.5 * actuator.link.inertia * run["joint_velocity"] ** 2
    energy += spring_energy(actuator.upper, 60.0 / 9000.0 + displacement)
    energy += spring_energy(actuator.lower, 60.0 / 6500.0 - displacement)
    assert set(run["slack_state"]) == {1.0, 2.0, 3.0}
    if overstretch is not None:
        assert any(event.after.engaged != (False, False) for event in run.events)
    assert np.ptp(energy) < 1e-9 * energy[0]


def test_vibrates_with_both_springs_while_taut() -> None:
    motor, amplitude = -0.5, 0.1
    rest = motor * 0.025 / 0.04
    held = Experiment(5.0, constant(motor), initial_position=rest + amplitude)
    run = simulate(ASYMMETRIC, held, np.linspace(0.0, 5.0, 1001))
    frequency = angular_frequency(ASYMMETRIC, ASYMMETRIC.upper, ASYMMETRIC.lower)
    expected = rest + amplitude * np.cos(frequency * run.time)
    assert not run.events
    np.testing.assert_allclose(run["joint_position"], expected, rtol=0, atol=POSITION_ERROR)


def test_damped_springs_follow_the_motor_as_the_transfer_function_says() -> None:
    upper, lower = replace(ASYMMETRIC.upper, damping=8.0), replace(ASYMMETRIC.lower, damping=3.0)
    link = Link(inertia=0.025, damping=0.3)
    actuator = replace(ASYMMETRIC, upper=upper, lower=lower, link=link)
    amplitude, frequency = 0.05, 3.0
    s = 2j * math.pi * frequency
    stiffness, damping = 0.04**2 * (9000.0 + 6500.0), 0.04**2 * (8.0 + 3.0)
    elastic = stiffness + damping * s
    response = (0.025 / 0.04) * elastic / (0.025 * s**2 + (0.3 + damping) * s + stiffness)
    moving = Experiment(6.0, sines([amplitude], [frequency], [0.0]))
    time = np.linspace(4.5, 6.0, 301)
    run = simulate(actuator, moving, time)
    expected = amplitude * np.imag(response * np.exp(s * time))
    # what is left of the transient after 4.5 s: exp(-(b + d) t / 2 J)
    transient = math.exp(-(0.3 + damping) / (2 * 0.025) * 4.5)
    assert transient < POSITION_ERROR
    np.testing.assert_allclose(run["joint_position"], expected, rtol=0, atol=POSITION_ERROR)


def test_slack_crossings_as_in_closed_form() -> None:
    # from rest at the motor's position with this speed: state III, then II (upper slack), then III
    speed = 8.0
    boundary = 60.0 / (0.04 * 9000.0)
    assert ASYMMETRIC.slack_boundaries()[1] == pytest.approx(boundary)
    taut = angular_frequency(ASYMMETRIC, ASYMMETRIC.upper, ASYMMETRIC.lower)
    leaving = math.asin(boundary * taut / speed) / taut
    speed_there = math.sqrt(speed**2 - (boundary * taut) ** 2)
    # in state II the joint swings about -F_p / (R k_2), where the lower spring would be at rest
    slack = angular_frequency(ASYMMETRIC, ASYMMETRIC.lower)
    away = boundary + 60.0 / (0.04 * 6500.0)
    half = math.atan2(speed_there / slack, away) / slack
    run = simulate(
        ASYMMETRIC,
        Experiment(0.2, constant(0.0), initial_velocity=speed),
        np.array([0.0, leaving, leaving + half, 0.2]),
    )
    first, second = run.events[:2]
    assert first.time == pytest.approx(leaving, abs=EVENT_TIME_ERROR)
    assert second.time == pytest.approx(leaving + 2 * half, abs=EVENT_TIME_ERROR)
    assert first.after.taut == (False, True)
    assert second.after.taut == (True, True)
    highest = -60.0 / (0.04 * 6500.0) + math.hypot(away, speed_there / slack)
    assert run["joint_position"][2] == pytest.approx(highest, abs=POSITION_ERROR)


def test_a_tendon_slack_for_an_instant_is_not_passed_over() -> None:
    # just over the boundary, and back within a hundredth of a step
    boundary = 60.0 / (0.04 * 9000.0)
    frequency = angular_frequency(ASYMMETRIC, ASYMMETRIC.upper, ASYMMETRIC.lower)
    beyond = 1.0 + 1e-6
    slack_time = 2 * math.acos(1.0 / beyond) / frequency
    assert slack_time < 1e-4
    swing = Experiment(0.1, constant(0.0), initial_velocity=beyond * boundary * frequency)
    run = simulate(ASYMMETRIC, swing, np.array([0.0, 0.1]))
    left, entered = run.events
    assert left.after.taut == (False, True)
    # the position error, divided by the small speed at which the boundary is passed
    assert entered.time - left.time == pytest.approx(slack_time, rel=1e-3)


def test_dynamic_slack_is_a_matter_of_force() -> None:
    # (7): with damping a tendon goes slack where k e + d e' = 0, not where e = 0
    damped = replace(ASYMMETRIC, upper=replace(ASYMMETRIC.upper, damping=40.0))
    let_go = Experiment(0.3, constant(0.0), initial_velocity=8.0)
    run = simulate(damped, let_go, np.linspace(0.0, 0.3, 30_001))
    slack = run["slack_state"] == 2.0
    elongation = 60.0 / 9000.0 - 0.04 * run["joint_position"]
    first = int(np.argmax(slack))
    assert elongation[first] > 1e-4
    force = 9000.0 * elongation - 40.0 * 0.04 * run["joint_velocity"]
    np.testing.assert_allclose(run["upper_spring_force"][~slack], force[~slack], rtol=0, atol=1e-8)
    assert np.all(force[slack] <= 0.0)
    assert np.all(run["upper_spring_force"][slack] == 0.0)


def test_unlike_relaxation_times_can_leave_both_tendons_slack() -> None:
    # (3): thrown back from a large deflection, the damped upper spring cannot follow its own end
    actuator = replace(
        ASYMMETRIC,
        upper=replace(ASYMMETRIC.upper, damping=500.0),
        lower=replace(ASYMMETRIC.lower, damping=0.0),
    )
    thrown = Experiment(0.5, constant(0.0), initial_position=-0.3, initial_velocity=20.0)
    run = simulate(actuator, thrown, np.linspace(0.0, 0.5, 501))
    assert 4.0 in run["slack_state"]
    at = run["slack_state"] == 4.0
    assert np.all(run["joint_torque"][at] == 0.0)


def test_a_rectangular_load_pulse_acts_from_its_first_to_its_last_instant() -> None:
    torque, start, length = 1.5, 0.1234, 0.05
    run = simulate(
        ASYMMETRIC,
        Experiment(1.0, constant(0.0), rectangular_pulse(start, length, torque)),
        np.linspace(0.0, 1.0, 501),
    )
    frequency = angular_frequency(ASYMMETRIC, ASYMMETRIC.upper, ASYMMETRIC.lower)
    static = torque / (0.025 * frequency**2)

    def step_response(since: np.ndarray) -> np.ndarray:
        return np.where(since > 0.0, static * (1.0 - np.cos(frequency * since)), 0.0)

    expected = step_response(run.time - start) - step_response(run.time - start - length)
    np.testing.assert_allclose(run["joint_position"], expected, rtol=0, atol=POSITION_ERROR)


def test_straight_lines_between_samples_are_followed_exactly() -> None:
    # a ramp of the motor from rest: q = n V (t - sin(w t) / w)
    ramp = piecewise_linear([0.0, 0.13, 0.2, 0.5], [0.0, 0.13, 0.2, 0.5])
    run = simulate(ASYMMETRIC, Experiment(0.5, ramp), np.linspace(0.0, 0.5, 101))
    frequency = angular_frequency(ASYMMETRIC, ASYMMETRIC.upper, ASYMMETRIC.lower)
    expected = 0.625 * (run.time - np.sin(frequency * run.time) / frequency)
    np.testing.assert_allclose(run["joint_position"], expected, rtol=0, atol=POSITION_ERROR)


def test_smooth_overstretch_tends_to_the_kink() -> None:
    held = Experiment(1.0, constant(0.0), initial_position=0.5)
    time = np.linspace(0.0, 1.0, 201)

    def positions(rounding: float) -> np.ndarray:
        string = Overstretch(engagement=0.02, stiffness=20_000.0, rounding=rounding)
        actuator = replace(
            ASYMMETRIC,
            upper=replace(ASYMMETRIC.upper, overstretch=string),
            lower=replace(ASYMMETRIC.lower, overstretch=string),
        )
        return simulate(actuator, held, time)["joint_position"]

    kinked = positions(0.0)
    coarse, fine = (float(np.max(np.abs(positions(w) - kinked))) for w in (2e-4, 1e-4))
    # the area between rounded and sharp knee is of second order in the rounding
    assert 3.5 < coarse / fine < 4.5
    assert coarse < 5e-3


def test_error_falls_with_the_tolerance_and_with_another_method_too() -> None:
    damped = replace(ASYMMETRIC, link=Link(inertia=0.025, damping=0.1))
    experiment = Experiment(2.0, sines([0.4, 0.2], [1.3, 3.7], [0.0, 1.0]), initial_velocity=2.0)
    time = np.linspace(0.0, 2.0, 401)

    def positions(tolerance: float, method: str = "DOP853") -> np.ndarray:
        # steps as long as the tolerance allows, so that it is the tolerance that is tested
        run = simulate(
            damped, experiment, time, tolerance=tolerance, longest_step=0.5, method=method
        )
        assert {1.0, 2.0, 3.0} == set(run["slack_state"])
        return run["joint_position"]

    finest = positions(1e-12)
    errors = [float(np.max(np.abs(positions(t) - finest))) for t in (1e-5, 1e-7, 1e-9)]
    assert errors[0] > 10 * errors[1] > 100 * errors[2]
    assert errors[2] < 1e-7
    assert float(np.max(np.abs(positions(1e-9, "Radau") - finest))) < 1e-7


def test_numbers_of_the_paper() -> None:
    spring = Spring(stiffness=2 * 11_580.0, max_deflection=0.015)
    biorob = Actuator(0.03, 0.03, 80.0, spring, spring, Link(inertia=0.03))
    # (36) and (37) round to three digits
    assert biorob.slack_boundaries() == pytest.approx((-0.115, 0.115), abs=5e-4)
    assert biorob.deflection_limits() == pytest.approx((-0.385, 0.385), abs=5e-4)
