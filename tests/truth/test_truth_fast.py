"""The truth on a fixed step against the truth that locates every event."""

import copy
from dataclasses import replace

import numpy as np
import pytest

from truth.catalogue import CELLS, actuator_of, signal_maps_of
from truth.every_effect import EFFECTS
from truth.experiments import Limits, multisine
from truth.fast import Inputs, Player, TruthError
from truth.recording import SignalMaps, record
from truth.solver import simulate

# far below the smallest noise in a study, 2e-5 rad, and below what a kink costs on a fixed step
AGREEMENT = 6e-6  # rad
TORQUE_AGREEMENT = 1e-3  # N·m
# a tenth of that noise
PAIR_AGREEMENT = 2e-6  # rad

TREE = {
    "transmission": {
        "joint_pulley_radius": 0.031,
        "motor_pulley_radius": 0.0223,
        "pretension_force": 63.0,
        "upper_spring": {"stiffness": 9100.0, "parallel": 2, "max_deflection": 0.0163},
        "lower_spring": {"stiffness": 5200.0, "parallel": 3, "max_deflection": 0.0141},
    },
    "link": {"inertia": 0.027, "damping": 0.11},
}
TIME = np.arange(0.0, 1.0, 0.002)
EXPERIMENT = multisine(3, Limits(0.4, 5.0, 4.0), 1.0)
TRUE = SignalMaps()  # sensors that show what there is
# it plays no load cells: what they make of a torque or a force moves nothing
PLAYED = [name for name in EFFECTS if name.rpartition("_")[0] not in CELLS]


def tree_with(effects: dict, damping: float) -> dict:
    tree = copy.deepcopy(TREE) | {"effects": effects}
    for side in ("upper_spring", "lower_spring"):
        tree["transmission"][side]["damping"] = damping
    return tree


def inputs(maps: SignalMaps = TRUE) -> Inputs:
    """What the sensors show of the experiment."""
    motor = np.array([EXPERIMENT.motor_position.value(time) for time in TIME])
    load = np.array([EXPERIMENT.load_torque.value(time) for time in TIME])
    return Inputs(TIME, maps.read_of_motor(motor), load)


# what acts on each half beside a mass, and what memory does in series with a tendon and in a play
PAIRS = [
    (("spring_relaxation", "spring_mass"), 0.0),
    (("spring_hysteresis", "spring_mass"), 0.0),
    (("tendon_compliance", "spring_mass"), 0.0),
    (("gear_backlash", "spring_mass"), 0.0),
    (("spring_hysteresis", "tendon_compliance"), 0.0),
    (("spring_relaxation", "gear_backlash"), 3.1),
]
SHORT = TIME[:250]


@pytest.mark.parametrize("effect", PLAYED)
def test_every_effect_agrees_with_the_located_events(effect):
    tree = tree_with({effect: EFFECTS[effect]}, 0.0)
    maps = signal_maps_of(tree)
    exact = record(actuator_of(tree), EXPERIMENT, TIME, maps)
    fast = Player(inputs(maps)).run(tree, (0.0, 0.0))
    np.testing.assert_allclose(fast.joint_position, exact["joint_position"], rtol=0, atol=AGREEMENT)
    np.testing.assert_allclose(
        fast.joint_torque, exact["joint_torque"], rtol=0, atol=TORQUE_AGREEMENT
    )
    # an effect that does nothing would agree as well
    bare = Player(inputs(maps)).run(tree_with({}, 0.0), (0.0, 0.0))
    assert np.max(np.abs(bare.joint_position - fast.joint_position)) > 1e-3


@pytest.mark.parametrize(("pair", "damping"), PAIRS)
def test_pairs_agree_that_act_on_one_another(pair, damping):
    tree = tree_with({effect: EFFECTS[effect] for effect in pair}, damping)
    start = (0.004, 0.3)  # not where the masses and the pulley are in their middle
    experiment = replace(EXPERIMENT, initial_position=start[0], initial_velocity=start[1])
    exact = simulate(actuator_of(tree), experiment, SHORT)["joint_position"]
    fast = Player(inputs()).run(tree, start).joint_position[: SHORT.size]
    np.testing.assert_allclose(fast, exact, rtol=0, atol=PAIR_AGREEMENT)


def test_damped_springs_agree_too():
    tree = tree_with({}, 3.1)
    exact = simulate(actuator_of(tree), EXPERIMENT, TIME)
    fast = Player(inputs()).run(tree, (0.0, 0.0))
    np.testing.assert_allclose(fast.joint_position, exact["joint_position"], rtol=0, atol=AGREEMENT)


def test_a_joint_that_runs_away_is_refused():
    tree = tree_with({"spring_hardening": {"cubic_stiffness": -1e9}}, 0.0)
    with pytest.raises(TruthError, match="ran away"):
        Player(inputs()).run(tree, (3.0, 0.0))
