"""The machines of MuJoCo are what they are said to be: the product agrees where it has the law."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

pytest.importorskip("mujoco")

from elastic_tendon.comparison.compare import compare
from engine.cases import FIRST_REPORTED_SEED, Order, build, orders, true_model
from engine.machines import MACHINES, machine_of
from engine.motions import KINDS, motion_of
from engine.play import motion_for, play, recorded

SHORT = 4.0  # s
SEED = 3  # of development
SIGMA = 2e-4  # rad
CLOSE = 1.05  # times the noise
# a pulley that is light instead of massless; dampers in springs that pull at the joint too
NEARLY = {"loose_gear": 1.6, "heavy_springs": 1.3}
NAMED = [name for name in MACHINES if true_model(machine_of(name, SEED)) is not None]


@cache
def recording(name, bare=False, kind="stairs"):
    machine = machine_of(name, SEED)
    machine = machine.bare if bare else machine
    run = play(machine, motion_for(machine, kind, SEED, SHORT))
    rng = np.random.default_rng(SEED)
    return machine, run, recorded(name, run, SIGMA, rng)


@cache
def built(machine, motion, bare=False):
    return build(Order(machine, motion, SEED, bare))


def noise_ratio(machine, run, measurement):
    """Error of the true model in units of the noise."""
    model = true_model(machine)
    noise = measurement.signals["joint_position"] - run.joint_position
    return compare(model, [measurement]).rmse()["joint_position"] / np.std(noise)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", ["bundled", "other_numbers", "strung"])
def test_without_anything_hidden_the_true_numbers_agree_to_the_noise(name, kind):
    assert noise_ratio(*recording(name, bare=True, kind=kind)) < CLOSE


@pytest.mark.parametrize("name", NAMED)
def test_the_law_of_the_catalogue_is_what_hides(name):
    assert noise_ratio(*recording(name)) < NEARLY.get(name, CLOSE)


@pytest.mark.parametrize(
    "name", [name for name in MACHINES if "nothing" not in repr(MACHINES[name])]
)
def test_what_hides_matters(name):
    machine, run, _ = recording(name)
    bare = play(machine.bare, motion_for(machine, "stairs", SEED, SHORT))
    difference = run.joint_position - bare.joint_position
    assert np.sqrt(np.mean(difference**2)) > 5.0 * SIGMA


@pytest.mark.parametrize("name", ["bundled", "strung"])
def test_either_tendon_goes_slack_and_no_spring_breaks(name):
    machine, run, _ = recording(name, bare=True, kind="waves")
    deflection = run.joint_position - machine.base.ratio * run.motor_position
    assert -np.min(deflection) > machine.base.slack_deflection
    assert np.max(deflection) > machine.base.slack_deflection
    assert np.max(np.abs(deflection)) < machine.base.largest_deflection


def test_a_finer_step_of_the_engine_changes_nothing_that_shows():
    machine = machine_of("dry_joint", SEED)
    motion = motion_for(machine, "stairs", SEED, SHORT)
    finer = play(machine, motion, step=2.5e-5)
    difference = play(machine, motion).joint_position - finer.joint_position
    assert np.sqrt(np.mean(difference**2)) < 0.2 * SIGMA


def test_a_case_is_always_the_same():
    first, again = built("dry_joint", "waves"), build(Order("dry_joint", "waves", SEED))
    assert first.given == again.given
    for one, two in zip(first.fit + first.validation, again.fit + again.validation, strict=True):
        assert np.array_equal(one.signals["joint_position"], two.signals["joint_position"])
        assert np.array_equal(one.motor_position, two.motor_position)


def test_a_case_is_asked_with_wrong_numbers_and_other_seeds_are_other_cases():
    case = built("dry_joint", "waves")
    assert case.given.link.inertia != case.true.link.inertia
    assert not case.given.effects
    other = machine_of("dry_joint", SEED + 1)
    assert other.base != machine_of("dry_joint", SEED).base
    assert not case.fit[0].shares_samples(case.validation[0])


def test_a_bare_case_has_the_machine_without_what_hides():
    case = built("dry_joint", "waves", bare=True)
    assert case.true is not None
    assert case.accepted == {frozenset()}
    assert compare(case.true, case.fit).rmse()["joint_position"] < CLOSE * case.floor_rmse


def test_an_answer_is_right_when_it_names_what_hides_and_reaches_the_noise():
    case = replace(built("dry_joint", "waves"), accepted=frozenset({frozenset({"gravity_load"})}))
    gravity, floor = frozenset({"gravity_load"}), case.floor_rmse
    assert case.right("missing_effect", gravity, 1.05 * floor)
    assert not case.right("missing_effect", gravity, 1.2 * floor)
    assert case.names_right("missing_effect", gravity)
    assert not case.right("adequate", frozenset(), floor)
    assert not case.right("unexplained", gravity, floor)
    assert replace(case, unknown=True).right("unexplained", frozenset(), 5.0 * floor)


def test_orders_of_development_and_of_the_report_share_no_seed():
    development, reported = list(orders(False)), list(orders(True))
    assert len({one.name for one in development}) == len(development)
    assert all(one.seed < FIRST_REPORTED_SEED for one in development)
    assert all(one.seed >= FIRST_REPORTED_SEED for one in reported)


def test_motions_begin_at_rest():
    time = np.array([0.0, 1e-4])
    for kind in KINDS:
        motion = motion_of(kind, SEED, SHORT, 5.0)
        assert np.max(np.abs(motion.motor(time))) < 1e-9
        assert np.max(np.abs(motion.load(time))) < 1e-9
