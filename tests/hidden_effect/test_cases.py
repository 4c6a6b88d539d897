"""What cases promise: the same again, R as ordered, the facts apart from what the tool gets."""

import numpy as np
import pytest

from hidden_effect import machines, motions
from hidden_effect.cases import (
    LARGEST_NOISE,
    SMALLEST_NOISE,
    Order,
    UnreachableError,
    build,
    rivals_of,
)
from hidden_effect.plan import orders
from hidden_effect.recordings import QUANTISED
from truth.catalogue import actuator_of
from truth.solver import simulate

SHORT = 3.0  # s


@pytest.fixture(scope="module")
def drag():
    return build(Order("effect", ("quadratic_drag",), 1.0, seed=3, duration=SHORT))


def test_a_case_is_the_same_again(drag):
    again = build(drag.order)
    for one, other in zip(drag.fit, again.fit, strict=True):
        np.testing.assert_array_equal(
            one.signals["joint_position"], other.signals["joint_position"]
        )
    assert again.given == drag.given


def test_the_noise_is_as_loud_as_ordered_beside_the_effect(drag):
    assert drag.facts.ratio == pytest.approx(1.0, rel=0.06)
    assert SMALLEST_NOISE <= drag.facts.noise.sigma <= LARGEST_NOISE
    assert drag.facts.floor["joint_position"] == pytest.approx(drag.facts.noise.sigma, rel=0.05)


@pytest.mark.parametrize("kind", motions.RICH)
def test_a_rich_experiment_lets_either_tendon_go_slack(kind):
    for seed in range(4):
        tree = machines.actuator(np.random.default_rng(seed))
        experiment = motions.experiment_of(kind, tree, seed)
        run = simulate(actuator_of(tree), experiment, np.arange(0.0, 10.0, 0.01), tolerance=1e-6)
        assert {1, 2, 3} <= set(run["slack_state"].astype(int))
        assert (
            np.max(np.abs(run["deflection"])) < motions.limits_of(actuator_of(tree), 1.0).deflection
        )


def test_the_tool_gets_neither_the_effect_nor_the_true_numbers(drag):
    assert not drag.given.effects
    truth, given = drag.facts.numbers, drag.given.values()
    assert truth["effects.quadratic_drag.coefficient"] > 0.0
    assert given["link.inertia"] != truth["link.inertia"]
    assert drag.fit[0].name != drag.validation[0].name
    assert not np.array_equal(drag.fit[0].motor_position, drag.validation[0].motor_position)


def test_rivals_cost_what_they_do_worse(drag):
    found = rivals_of(drag, "quadratic_drag")
    # R = 1: what the base model leaves is as large as the noise, in every sample
    samples = len(drag.fit[0].time)
    assert found[""] == pytest.approx(samples, rel=0.15)
    assert found["quadratic_drag"] == 0.0
    # springs that follow the joint know nothing of its speed
    assert found["spring_hardening"] > 100.0
    assert all(bic > -10.0 for bic in found.values())


def test_no_rival_beats_a_torque_that_acts_backwards():
    case = build(Order("effect", ("constant_torque",), 1.0, seed=1, duration=SHORT))
    assert case.facts.numbers["effects.constant_torque.torque"] < 0.0
    assert all(bic > -10.0 for bic in rivals_of(case, "constant_torque").values())


def test_a_nested_law_costs_its_additional_numbers():
    case = build(Order("effect", ("coulomb_friction",), 1.0, seed=4, duration=SHORT))
    found = rivals_of(case, "coulomb_friction")
    cost = np.log(len(case.fit[0].time))
    assert found["stribeck_friction"] == pytest.approx(2.0 * cost, abs=2.5)


def test_quantised_noise_stands_and_the_strength_follows():
    order = Order("effect", ("gravity_load",), 0.3, noise="quantised", seed=1, duration=SHORT)
    case = build(order)
    assert case.facts.noise.sigma == QUANTISED
    assert case.facts.ratio == pytest.approx(0.3, rel=0.06)


def test_an_effect_that_cannot_show_makes_no_case():
    # the motor is held, so its pulley does not turn
    with pytest.raises(UnreachableError, match="R is"):
        build(Order("effect", ("pulley_eccentricity",), 1.0, "free decay", seed=1))


def test_a_disturbance_is_not_in_the_floor_of_the_tool_and_not_in_its_load():
    quiet, disturbed = (
        build(Order("nothing", (), 0.0, noise=noise, seed=2, duration=SHORT))
        for noise in ("white", "disturbance")
    )
    assert disturbed.facts.floor["joint_position"] > 2.0 * disturbed.facts.noise.sigma
    np.testing.assert_array_equal(quiet.fit[0].load_torque, disturbed.fit[0].load_torque)


def test_reported_cases_share_no_seed_with_those_of_development():
    development, reported = (orders(2, reported) for reported in (False, True))
    assert max(one.seed for one in development) < 1000 <= min(one.seed for one in reported)
    assert len({one.name for one in reported}) == len(reported)
