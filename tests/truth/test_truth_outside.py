"""Effects that are in no catalogue, and laws other than its own."""

import numpy as np
import pytest

from truth.actuator import Actuator, Link, Spring
from truth.experiments import Limits, multisine
from truth.fast import Inputs
from truth.friction import HessSoom, Stribeck
from truth.outside import MEANT_BY, OTHER_LAWS, OUTSIDE, TOLERANCE, foreign_run
from truth.solver import simulate

SPRING = Spring(stiffness=20_000.0, max_deflection=0.015)
ACTUATOR = Actuator(0.03, 0.03, 80.0, SPRING, SPRING, Link(inertia=0.03, damping=0.16))
EXPERIMENT = multisine(5, Limits(0.3, 4.0, 3.0), 0.8)
TIME = np.arange(0.0, 0.8, 0.004)
INPUTS = Inputs(TIME, np.zeros_like(TIME), np.zeros_like(TIME))
ELONGATION = 0.012  # m


@pytest.fixture(scope="module")
def bare() -> np.ndarray:
    """The motion of the actuator without any of them, rad."""
    return simulate(ACTUATOR, EXPERIMENT, TIME, tolerance=TOLERANCE)["joint_position"]


@pytest.mark.parametrize("name", [*OUTSIDE, *OTHER_LAWS])
def test_a_law_moves_the_joint_and_vanishes_with_its_strength(name, bare):
    law = (OUTSIDE | OTHER_LAWS)[name](np.random.default_rng(2), ACTUATOR, ELONGATION)
    tiny, full = (
        np.max(
            np.abs(foreign_run(law, strength, ACTUATOR, EXPERIMENT, INPUTS).joint_position - bare)
        )
        for strength in (1e-3, 1.0)
    )
    assert full > 1e-4
    assert tiny < 2e-2 * full


def test_every_other_law_says_what_it_is_one_of():
    assert MEANT_BY.keys() == OTHER_LAWS.keys()
    assert not OUTSIDE.keys() & OTHER_LAWS.keys()


def test_the_curve_of_hess_and_soom_meets_stribecks_at_rest_and_far_off():
    one, other = HessSoom(0.5, 0.8, 0.1), Stribeck(0.5, 0.8, 0.1)
    for direction in (-1, 1):
        at_rest = one.opposing(direction, 0.0, [])
        assert at_rest == pytest.approx(other.opposing(direction, 0.0, []))
        assert one.opposing(direction, 50.0, []) == pytest.approx(0.5 * direction, abs=1e-5)
    assert one.opposing(1, 0.1, []) == pytest.approx(0.5 + 0.3 / 2)
