"""The transmission's functions against the paper's numbers, closed forms and CasADi."""

from collections.abc import Callable
from typing import Any

import casadi as ca
import numpy as np
import pytest

from elastic_tendon.actuator import transmission as tendons
from elastic_tendon.actuator.parameters import Model, load_model, models
from elastic_tendon.actuator.transmission import SlackState

ROUNDING = 1e-12  # a few operations in double precision
R, r = 0.05, 0.02


@pytest.fixture(params=models)
def model(request: pytest.FixtureRequest) -> Model:
    """Each bundled model, with springs that damp unlike each other."""
    damping = {
        "transmission.upper_spring.damping": 30.0,
        "transmission.lower_spring.damping": 5.0,
    }
    return load_model(request.param).with_values(damping)


def asymmetric(pretension: float = 30.0) -> Model:
    return load_model("figure_7").with_values({"transmission.pretension_force": pretension})


# ---- numpy and CasADi say the same ----

FUNCTIONS: list[tuple[Callable[..., Any], int]] = [
    (tendons.reflected_motor_position, 3),
    (tendons.displacement, 3),
    (tendons.prestretched_length, 2),
    (tendons.spring_force, 4),
    (tendons.tension, 1),
    (tendons.joint_torque, 3),
    (tendons.motor_torque, 3),
    (tendons.slack_state_by_force, 2),
    (tendons.slack_state_by_length, 2),
]


@pytest.mark.parametrize(("function", "count"), FUNCTIONS)
def test_numpy_and_casadi_agree(function: Callable[..., Any], count: int) -> None:
    samples = np.random.default_rng(1).uniform(-2.0, 2.0, (count, 50))
    symbols = [ca.SX.sym(f"x{index}") for index in range(count)]
    compiled = ca.Function("f", symbols, [function(*symbols)])
    by_casadi = [float(compiled(*column)) for column in samples.T]
    by_floats = [float(function(*map(float, column))) for column in samples.T]
    np.testing.assert_allclose(function(*samples), by_casadi, rtol=ROUNDING)
    np.testing.assert_allclose(by_floats, by_casadi, rtol=ROUNDING)


# ---- kinematics and torques ----


def test_a_joint_that_follows_its_motor_does_not_stretch_the_springs() -> None:
    reflected = tendons.reflected_motor_position(1.5, R, r)
    assert reflected == pytest.approx(1.5 * r / R, rel=ROUNDING)  # (10)
    assert tendons.displacement(reflected, reflected, R) == 0.0


def test_displacement_is_that_of_the_pulleys() -> None:
    q, motor = 0.3, -0.4
    x_1 = tendons.displacement(q, tendons.reflected_motor_position(motor, R, r), R)
    assert x_1 == pytest.approx(-R * q + r * motor, rel=ROUNDING)  # (1)


def test_prestretched_lengths_are_inverse_to_the_stiffnesses() -> None:
    ratio = tendons.prestretched_length(80.0, 2e4) / tendons.prestretched_length(80.0, 1e4)
    assert ratio == pytest.approx(1e4 / 2e4, rel=ROUNDING)  # (5)


def test_tendons_only_pull() -> None:
    np.testing.assert_array_equal(tendons.tension(np.array([-5.0, 0.0, 5.0])), [0.0, 0.0, 5.0])


def test_power_passes_from_motor_to_joint_without_loss() -> None:
    torque, motor_velocity = 3.0, 2.0
    at_motor = tendons.motor_torque(torque, R, r) * motor_velocity
    at_joint = torque * tendons.reflected_motor_position(motor_velocity, R, r)
    assert at_motor == pytest.approx(at_joint, rel=ROUNDING)  # (8) to (10)


# ---- slack ----


@pytest.mark.parametrize(
    ("upper", "lower", "state"),
    [
        (1.0, -1.0, SlackState.I),
        (-1.0, 1.0, SlackState.II),
        (1.0, 1.0, SlackState.III),
        (-1.0, -1.0, SlackState.BOTH),
        (0.0, 0.0, SlackState.III),  # sigma(0) = 1
    ],
)
def test_slack_states_have_the_contract_s_numbers(
    upper: float, lower: float, state: SlackState
) -> None:
    assert tendons.slack_state_by_force(upper, lower) == state
    assert tendons.slack_state_by_length(upper, lower) == state
    assert state.label


def test_slack_states_are_one_to_four() -> None:
    assert [state.value for state in SlackState] == [1, 2, 3, 4]


def test_erratum_1_a_spring_is_slack_below_its_rest_length() -> None:
    """Slack is x_i < -l_p,i; by the text after (5), x_i < l_p,i, the spring at rest would be."""
    transmission = asymmetric().transmission
    for spring in (transmission.upper_spring, transmission.lower_spring):
        length = tendons.prestretched_length(30.0, spring.combined_stiffness)
        opposite = 1.0
        assert tendons.slack_state_by_length(length, opposite) == SlackState.III
        just_slack = length - 1.0001 * length
        assert tendons.slack_state_by_length(just_slack, opposite) == SlackState.II


def test_dynamic_slack_of_both_tendons() -> None:
    """Damping takes the upper tendon's tension while the lower spring is below its rest length."""
    k, rest = 1000.0, 0.005
    shift = 1.2 * rest  # the lower spring is below its rest length, the upper far above
    upper = tendons.spring_force(k, rest + shift, 100.0, -1.0)  # 11 N less 100 N
    lower = tendons.spring_force(k, rest - shift, 0.0, 1.0)  # -1 N
    assert tendons.slack_state_by_force(upper, lower) == SlackState.BOTH
    assert tendons.slack_state_by_length(rest + shift, rest - shift) == SlackState.I


def test_slack_boundary_is_where_the_static_state_changes() -> None:
    transmission = asymmetric().transmission
    low, high = tendons.slack_boundaries(transmission)
    k_1 = transmission.upper_spring.combined_stiffness
    k_2 = transmission.lower_spring.combined_stiffness
    deflection = np.array([low * 1.001, low * 0.999, high * 0.999, high * 1.001])
    x_1 = tendons.displacement(deflection, 0.0, transmission.joint_pulley_radius)
    states = tendons.slack_state_by_length(30.0 / k_1 + x_1, 30.0 / k_2 - x_1)
    np.testing.assert_array_equal(states, [1, 3, 3, 2])  # (13), (14)


def test_without_pretension_one_tendon_is_slack_at_any_deflection() -> None:
    transmission = asymmetric(0.0).transmission
    assert tendons.slack_boundaries(transmission) == (0.0, 0.0)
    square = transmission.joint_pulley_radius**2
    stiffness = tendons.characteristic_stiffness([-0.01, 0.01], transmission)
    np.testing.assert_allclose(stiffness, square * np.array([22820.0, 17115.0]), rtol=ROUNDING)


# ---- erratum 2: deflection limits ----


def test_erratum_2_the_springs_are_at_their_limit_at_the_corrected_deflections(
    model: Model,
) -> None:
    """Elongation l_p,i + x_i is l_max,i there, (15); with the signs printed in (16) it is not."""
    transmission = model.transmission
    low, high = tendons.deflection_limits(transmission)
    radius, force = transmission.joint_pulley_radius, transmission.pretension_force
    upper, lower = transmission.upper_spring, transmission.lower_spring
    at_low = force / upper.combined_stiffness + tendons.displacement(low, 0.0, radius)
    at_high = force / lower.combined_stiffness - tendons.displacement(high, 0.0, radius)
    assert at_low == pytest.approx(upper.max_deflection, rel=ROUNDING)
    assert at_high == pytest.approx(lower.max_deflection, rel=ROUNDING)
    printed = -upper.max_deflection / radius - force / (upper.combined_stiffness * radius)
    assert printed < low


# ---- characteristic curves ----


def test_torque_of_each_state_is_the_paper_s(model: Model) -> None:
    transmission = model.transmission
    low, high = tendons.slack_boundaries(transmission)
    radius, force = transmission.joint_pulley_radius, transmission.pretension_force
    upper, lower = transmission.upper_spring, transmission.lower_spring
    k_1, k_2 = upper.combined_stiffness, lower.combined_stiffness

    def at_rest(deflection: float) -> float:
        return float(tendons.characteristic_torque(deflection, transmission))

    state_1, state_2, state_3 = 1.1 * low, 1.1 * high, 0.5 * high
    assert at_rest(state_1) == pytest.approx(radius * force - k_1 * radius**2 * state_1)  # (18)
    assert at_rest(state_2) == pytest.approx(-radius * force - k_2 * radius**2 * state_2)  # (22)
    assert at_rest(state_3) == pytest.approx(-(radius**2) * (k_1 + k_2) * state_3)  # (24)


def test_damped_torque_in_state_three(model: Model) -> None:
    transmission = model.transmission
    rate = 0.01  # rad/s: slow enough that no tendon goes slack
    d = transmission.upper_spring.combined_damping + transmission.lower_spring.combined_damping
    torque = float(tendons.characteristic_torque(0.0, transmission, rate))
    expected = -(transmission.joint_pulley_radius**2) * d * rate
    assert torque == pytest.approx(expected, rel=1e-9)  # difference of two pretensions


def test_stiffness_and_damping_are_slopes_of_the_torque(model: Model) -> None:
    transmission = model.transmission
    low, high = tendons.slack_boundaries(transmission)
    deflection = np.array([1.2 * low, 0.5 * low, 0.5 * high, 1.2 * high])
    step = 1e-4 * high

    def torque(at: np.ndarray, rate: float = 0.0) -> np.ndarray:
        return tendons.characteristic_torque(at, transmission, rate)

    slope = -(torque(deflection + step) - torque(deflection - step)) / (2 * step)
    stiffness = tendons.characteristic_stiffness(deflection, transmission)
    np.testing.assert_allclose(stiffness, slope, rtol=1e-9)  # exact but for cancellation

    slow = 1e-6  # rad/s, keeps every tendon in its static state
    slope = -(torque(deflection, slow) - torque(deflection, -slow)) / (2 * slow)
    damping = tendons.characteristic_damping(deflection, transmission)
    np.testing.assert_allclose(damping, slope, rtol=1e-5)  # cancellation at so slow a rate


def test_torque_is_continuous_at_the_slack_boundaries(model: Model) -> None:
    transmission = model.transmission
    for boundary in tendons.slack_boundaries(transmission):
        around = boundary * np.array([1 - 1e-9, 1 + 1e-9])
        before, after = tendons.characteristic_torque(around, transmission)
        assert before == pytest.approx(after, rel=1e-8)  # a jump would be of order one
