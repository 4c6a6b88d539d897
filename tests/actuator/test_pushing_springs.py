"""Springs that push too: a torsion spring or a shaft, whose tendons are never slack."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import elastic_tendon as et
from elastic_tendon.actuator.parameters import Model, load_model
from elastic_tendon.actuator.transmission import (
    characteristic_damping,
    characteristic_stiffness,
    characteristic_torque,
    deflection_limits,
    slack_boundaries,
)

RADIUS, STIFFNESS, DAMPING, CUBIC = 0.1, 50.0, 0.3, 4000.0
INERTIA, FRICTION = 5.4e-3, 2e-2


def shaft(slack: int = 0, **effects: dict[str, float]) -> Model:
    spring = {"stiffness": STIFFNESS, "damping": DAMPING, "max_deflection": 1.0}
    return load_model(
        {
            "name": "shaft",
            "transmission": {
                "joint_pulley_radius": RADIUS,
                "motor_pulley_radius": RADIUS,
                "pretension_force": 0.0,
                "slack": slack,
                "upper_spring": spring,
                "lower_spring": spring,
            },
            "link": {"inertia": INERTIA, "damping": FRICTION},
            "effects": effects,
        }
    )


def test_motion_is_that_of_a_spring_in_both_directions() -> None:
    """Duffing's equation, solved by another program."""
    model = shaft(spring_hardening={"cubic_stiffness": CUBIC})
    time = np.linspace(0.0, 3.0, 1501)
    start = {"joint_position": 0.05, "joint_velocity": 0.0}

    def motor(at):
        return 0.8 * np.sin(3.0 * at), 2.4 * np.cos(3.0 * at)

    def rates(at, state):
        angle, velocity = motor(at)
        stretched, faster = RADIUS * (angle - state[0]), RADIUS * (velocity - state[1])
        force = 2.0 * (STIFFNESS * stretched + CUBIC * stretched**3 + DAMPING * faster)
        return [state[1], (RADIUS * force - FRICTION * state[1]) / INERTIA]

    truth = solve_ivp(rates, (0.0, 3.0), [0.05, 0.0], t_eval=time, rtol=1e-10, atol=1e-12)
    found = et.simulate(
        model, time, motor(time)[0], initial_state=start, interpolation="cubic", tolerance=1e-9
    )
    assert np.ptp(truth.y[0]) > 1.0
    assert np.abs(found["joint_position"] - truth.y[0]).max() < 1e-7
    assert set(found["slack_state"]) == {3}


def test_without_pretension_tendons_that_only_pull_are_slack() -> None:
    """What the springs above do is due to `slack`."""
    time = np.linspace(0.0, 1.0, 501)
    found = et.simulate(shaft(slack=1), time, 0.5 * np.sin(6.0 * time))
    assert {1, 2} <= set(found["slack_state"])


def test_characteristic_is_a_straight_line() -> None:
    springs, deflection = shaft().transmission, np.array([-3.0, -0.2, 0.0, 0.2, 3.0])
    both = 2.0 * RADIUS**2
    assert characteristic_torque(deflection, springs) == pytest.approx(
        -both * STIFFNESS * deflection
    )
    assert characteristic_stiffness(deflection, springs) == pytest.approx(both * STIFFNESS)
    assert characteristic_damping(deflection, springs) == pytest.approx(both * DAMPING)
    assert slack_boundaries(springs) == deflection_limits(springs) == (-10.0, 10.0)


def test_it_is_linear_in_one_state_only() -> None:
    found = et.linearise(shaft(), "III")
    assert found.A[1, 0] == pytest.approx(-2.0 * RADIUS**2 * STIFFNESS / INERTIA)
    with pytest.raises(et.ElasticTendonError, match=r"springs push too .*state III"):
        et.linearise(shaft(), "I")


@pytest.mark.parametrize("value", [2, -1, True, 0.5])
def test_slack_is_yes_or_no(value: object) -> None:
    with pytest.raises(et.ModelError, match=r"transmission\.slack"):
        shaft(slack=value)
