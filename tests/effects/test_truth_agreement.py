"""Every physical effect of the product against the truth, alone and together.

The truth shares no code with the product and formulates most effects otherwise: hysteresis as
curves between reversals, relaxation by the force of its branch, play by the path of the floating
pulley, friction of guides by sum and difference of the tensions. Both read the same model.toml.
"""

import copy
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
import pytest

from elastic_tendon.actuator.parameters import parse_model
from elastic_tendon.simulation.simulate import simulate
from truth import signals, solver
from truth.catalogue import CELLS, actuator_of, signal_maps_of
from truth.every_effect import EFFECTS as EVERY_EFFECT
from truth.recording import SignalMaps, record
from truth.solver import Event, Trajectory

STEP = 0.01  # s, between samples compared
DENSER = 20  # samples of the product between those: its spline then errs by less than 1e-10 rad
# Both solve the same equations, the product to 1e-10 and the truth to 1e-11 a step, and locate
# every event: what is left is what steps gather in a second or two. A wrong law, even in the
# rarest mode, is off by more than 1e-7.
AGREEMENT = 1e-9  # rad
# the same through the stiffest tendons that occur, 100 N·m/rad
TORQUE_AGREEMENT = 1e-7  # N·m
TOLERANCE = 1e-10  # of the product
# an effect must move the joint by far more than what is asked of the agreement
VISIBLE = 1e-3  # rad
# of the truth, s: z of Bouc-Wen turns within y / x', 3 ms, which longer steps estimate badly
LONGEST_STEP = 0.004

JOINT_RADIUS, MOTOR_RADIUS = 0.031, 0.0223  # m
TREE = {
    "name": "truth",
    "transmission": {
        "joint_pulley_radius": JOINT_RADIUS,
        "motor_pulley_radius": MOTOR_RADIUS,
        "pretension_force": 63.0,
        "upper_spring": {
            "stiffness": 9100.0,
            "parallel": 2,
            "damping": 3.1,
            "max_deflection": 0.0163,
        },
        "lower_spring": {
            "stiffness": 5200.0,
            "parallel": 3,
            "damping": 1.7,
            "max_deflection": 0.0141,
        },
    },
    "link": {"inertia": 0.027, "damping": 0.11},
}
EFFECTS = EVERY_EFFECT | {"spring_mass": {"mass": 0.03, "damping": 2.0}}


def tree_with(*ids: str, dampings: tuple[float, float] | None = None) -> dict:
    """The content of a model.toml with these effects; `dampings` of one spring of each side."""
    tree = copy.deepcopy(TREE)
    if dampings is not None:
        for side, damping in zip(("upper_spring", "lower_spring"), dampings, strict=True):
            tree["transmission"][side]["damping"] = damping
    tree["effects"] = {effect_id: dict(EFFECTS[effect_id]) for effect_id in ids}
    return tree


def excitation(tree: Mapping, duration: float, share: float = 1.0) -> signals.Experiment:
    """Motor motion and load; with `share` 1 they take both tendons through slack."""
    limits = actuator_of(tree).deflection_limits()
    transmission = tree["transmission"]
    ratio = transmission["joint_pulley_radius"] / transmission["motor_pulley_radius"]
    wide = 1.8 * share * (limits[1] - limits[0]) * ratio
    motor = signals.sines([0.4 * wide, 0.15 * wide], [1.1, 2.7], [0.0, 0.0])
    return signals.Experiment(duration, motor, signals.sines([1.6 * share], [1.9], [0.0]))


def moves_with_rests(tree: Mapping, duration: float) -> signals.Experiment:
    """Motor moves to and fro with rests, in which dry friction brings the joint to a stop."""
    limits = actuator_of(tree).deflection_limits()
    wide = 0.9 * (limits[1] - limits[0]) * JOINT_RADIUS / MOTOR_RADIUS
    motor = signals.total(
        signals.smooth_step(0.05, 0.15, wide), signals.smooth_step(0.75, 0.2, -2.0 * wide)
    )
    return signals.Experiment(duration, motor, signals.sines([0.4], [1.3], [0.0]))


def sample_times(duration: float) -> np.ndarray:
    return np.arange(round(duration / STEP) + 1) * STEP


def expected_of(tree: Mapping, experiment: signals.Experiment) -> Trajectory:
    """The truth's run."""
    return solver.simulate(
        actuator_of(tree),
        experiment,
        sample_times(experiment.duration),
        longest_step=LONGEST_STEP,
    )


def actual_of(
    tree: Mapping,
    experiment: signals.Experiment,
    tolerance: float = TOLERANCE,
    as_measured: bool = False,
) -> dict[str, np.ndarray]:
    """The product's outputs at the truth's samples."""
    times = sample_times(experiment.duration)
    fine = np.linspace(0.0, times[-1], DENSER * (times.size - 1) + 1)
    maps = signal_maps_of(tree) if as_measured else SignalMaps()
    motion = simulate(
        parse_model(tree, "truth"),
        fine,
        maps.read_of_motor(np.array([experiment.motor_position.value(time) for time in fine])),
        [experiment.load_torque.value(time) for time in fine],
        initial_state={
            "joint_position": experiment.initial_position,
            "joint_velocity": experiment.initial_velocity,
        },
        interpolation="cubic",
        tolerance=tolerance,
        as_measured=as_measured,
    )
    return {name: motion[name][::DENSER] for name in motion.output_names}


def without_effects(case: "Case") -> np.ndarray:
    """Joint position, rad, of the same motion of the actuator that has no effects."""
    return expected_of(tree_with(dampings=case.dampings), case.experiment)["joint_position"]


# ---- what a run must have met for the comparison to mean anything ------------------------------


Met = Callable[[tuple[Event, ...]], bool]


def anything(_events: tuple[Event, ...]) -> bool:
    return True


def sticking(events: tuple[Event, ...]) -> bool:
    """Came to rest after motion, and broke loose in both directions."""
    came_to_rest = any(e.after.direction == 0 != e.before.direction for e in events)
    broke_loose = {e.after.direction for e in events if e.before.direction == 0}
    return came_to_rest and broke_loose >= {-1, 1}


def turning(events: tuple[Event, ...]) -> bool:
    return {event.after.direction for event in events} == {-1, 1}


def both_stops_released(events: tuple[Event, ...]) -> bool:
    """Each stop pushed, and let go before the joint had left it, as damping has it."""
    return all(
        any(event.after.stops[i].reached and not event.after.stops[i].pushing for event in events)
        for i in (0, 1)
    )


def strings(events: tuple[Event, ...]) -> bool:
    return all(any(event.after.engaged[i] for event in events) for i in (0, 1))


def loops(events: tuple[Event, ...]) -> bool:
    """Both springs turned round several times, some of them while unloading."""
    turns = [
        tendon.branch
        for event in events
        for before, tendon in zip(event.before.tendons, event.after.tendons, strict=True)
        if tendon.branch and before.branch and tendon.branch.direction != before.branch.direction
    ]
    return len(turns) > 8 and any(abs(turn.levels[0]) < 0.9 for turn in turns)


def one_half_slack(events: tuple[Event, ...]) -> bool:
    """A mass pulled from one end only."""
    return any(
        event.after.tendons[i].taut != event.after.tendons[i + 1].taut
        for event in events
        for i in (0, 2)
    )


def whole_play(events: tuple[Event, ...]) -> bool:
    return {event.after.tooth for event in events} == {-1, 0, 1}


@dataclass(frozen=True)
class Case:
    """Effects held against the truth in a motion of `duration` (s)."""

    ids: tuple[str, ...]
    met: Met = anything
    dampings: tuple[float, float] | None = None  # N s/m of one spring; None for TREE's
    duration: float = 1.5

    @property
    def experiment(self) -> signals.Experiment:
        """Rests where something sticks, else sines."""
        tree = self.tree
        if self.met is sticking:
            return moves_with_rests(tree, self.duration)
        return excitation(tree, self.duration)

    @property
    def tree(self) -> dict:
        return tree_with(*self.ids, dampings=self.dampings)

    def __str__(self) -> str:
        return "+".join(self.ids) + ("" if self.dampings is None else f"-damped{self.dampings}")


UNDAMPED = (0.0, 0.0)
# overstretch protection alone: tests/test_against_truth.py
ALONE = [
    Case(("coulomb_friction",), sticking),
    Case(("stribeck_friction",), sticking),
    Case(("lugre_friction",), turning, duration=0.6),
    # these act on different things and share a library
    Case(("quadratic_drag", "gravity_load", "constant_torque", "pulley_eccentricity"), turning),
    Case(("joint_stop",), both_stops_released),
    Case(("spring_hardening",)),
    Case(("spring_hysteresis",), loops),
    Case(("spring_hysteresis",), loops, UNDAMPED),
    Case(("spring_relaxation",)),
    Case(("spring_relaxation",), dampings=UNDAMPED),
    Case(("spring_mass",), one_half_slack, duration=0.4),
    Case(("tendon_guide_friction",), sticking),
    Case(("tendon_compliance",), dampings=UNDAMPED),
    Case(("gear_backlash",), whole_play),
    Case(("gear_backlash",), whole_play, UNDAMPED),
]
TOGETHER = [
    Case(("overstretch_protection", "spring_hardening"), strings),
    Case(("spring_hysteresis", "spring_relaxation"), loops),
    Case(("spring_hardening", "tendon_compliance"), dampings=UNDAMPED),
    Case(("spring_hysteresis", "tendon_compliance"), loops, UNDAMPED),
    Case(("spring_relaxation", "tendon_compliance"), dampings=UNDAMPED),
    Case(("spring_hardening", "gear_backlash"), whole_play),
    Case(("spring_relaxation", "gear_backlash"), whole_play, UNDAMPED),
    Case(("spring_hardening", "spring_mass"), one_half_slack, duration=0.3),
    Case(("spring_hysteresis", "spring_mass"), one_half_slack, duration=0.3),
    Case(("spring_relaxation", "spring_mass"), one_half_slack, duration=0.3),
    Case(("tendon_compliance", "spring_mass"), one_half_slack, UNDAMPED, duration=0.3),
    Case(("gear_backlash", "spring_mass"), whole_play, duration=0.4),
    Case(("coulomb_friction", "tendon_guide_friction"), sticking),
    Case(
        (
            *("stribeck_friction", "gravity_load", "joint_stop", "tendon_guide_friction"),
            *("pulley_eccentricity", "gear_backlash"),
        ),
        lambda events: sticking(events) and both_stops_released(events) and whole_play(events),
    ),
]
# a tendon that yields in series with a damped spring: taut all the time, and through slack
SERIES_DAMPINGS = (30.0, 20.0)  # N s/m


def assert_agree(tree: Mapping, expected: Trajectory, actual: Mapping[str, np.ndarray]) -> None:
    """Joint position and torques of both sides; at rest only friction as a whole is determined."""
    compared = {
        "joint_position": AGREEMENT,
        "joint_torque": TORQUE_AGREEMENT,
        "motor_torque": TORQUE_AGREEMENT,
    }
    laws_at_rest = {"coulomb_friction", "stribeck_friction", "tendon_guide_friction"}
    two_laws = len(laws_at_rest & tree["effects"].keys()) > 1
    for name, tolerance in compared.items():
        shared = name == "joint_torque" and two_laws
        determined = expected["joint_velocity"] != 0.0 if shared else slice(None)
        np.testing.assert_allclose(
            actual[name][determined],
            expected[name][determined],
            rtol=0,
            atol=tolerance,
            err_msg=name,
        )


@pytest.mark.parametrize("case", ALONE + TOGETHER, ids=str)
def test_product_agrees_with_the_truth(case):
    tree, experiment = case.tree, case.experiment
    expected = expected_of(tree, experiment)
    assert set(expected["slack_state"]) == {1, 2, 3}
    assert case.met(expected.events)
    apart = expected["joint_position"] - without_effects(case)
    assert np.abs(apart).max() > VISIBLE
    assert_agree(tree, expected, actual_of(tree, experiment))


@pytest.mark.parametrize("dampings", [(0.0, 11.0), (40.0, 25.0)])
def test_a_spring_that_its_damper_slackens_keeps_its_length(dampings):
    # it fades within 1.2 ms: free at once, it would be taut again at once, over and over
    tree = tree_with("spring_relaxation", dampings=dampings)
    tree["effects"]["spring_relaxation"] = {"stiffness": 6000.0, "time_constant": 0.0012}
    experiment = excitation(tree, 0.8)
    expected = expected_of(tree, experiment)
    assert any(part.spans for event in expected.events for part in event.after.tendons)
    assert len(expected.events) < 60
    assert_agree(tree, expected, actual_of(tree, experiment))


# those of the cases above whose modes depend most on the numbers
RANDOM = [
    ("spring_hysteresis", "spring_relaxation"),
    ("spring_hysteresis", "tendon_compliance"),
    ("spring_relaxation", "tendon_compliance"),
    ("spring_hardening", "gear_backlash"),
    ("coulomb_friction", "tendon_guide_friction"),
    ("joint_stop",),
]


def random_tree(seed: int, ids: tuple[str, ...]) -> dict:
    """Another actuator, its effects up to e times weaker or stronger; numbers off any grid."""
    rng = np.random.default_rng(seed)
    tree = tree_with(*ids)
    transmission = tree["transmission"]
    transmission["joint_pulley_radius"] = rng.uniform(0.02, 0.05)
    transmission["motor_pulley_radius"] = rng.uniform(0.01, 0.04)
    transmission["pretension_force"] = rng.uniform(20.0, 60.0)
    # dampers in series are cases of their own
    largest = 0.0 if "tendon_compliance" in ids else rng.choice([0.0, 5.0, 60.0])
    for side in ("upper_spring", "lower_spring"):
        transmission[side] = {
            "stiffness": rng.uniform(6e3, 1.5e4),
            "parallel": int(rng.integers(1, 4)),
            "damping": rng.uniform(0.0, largest),
            "max_deflection": rng.uniform(0.01, 0.02),
        }
    tree["link"] = {"inertia": rng.uniform(0.02, 0.06), "damping": rng.uniform(0.02, 0.3)}
    for numbers in tree["effects"].values():
        for name in numbers.keys() - {"lower", "upper"}:
            numbers[name] *= float(np.exp(rng.uniform(-1.0, 1.0)))
    return tree


# one machine each in CI; another is a study
@pytest.mark.parametrize("seed", [0, pytest.param(1, marks=pytest.mark.slow)])
@pytest.mark.parametrize("ids", RANDOM, ids="+".join)
def test_product_agrees_with_the_truth_for_other_numbers(ids, seed):
    tree = random_tree(seed, ids)
    # a joint that starts off its middle, so that a tendon may be slack from the start
    experiment = replace(excitation(tree, 0.8), initial_position=(-0.06, 0.06)[seed])
    expected = expected_of(tree, experiment)
    assert len(set(expected["slack_state"])) > 1
    assert_agree(tree, expected, actual_of(tree, experiment))


@pytest.mark.parametrize("exponent", [0.5, 1.0, 5.0])
def test_hysteresis_agrees_with_the_truth_for_every_exponent(exponent):
    tree = tree_with("spring_hysteresis")
    tree["effects"]["spring_hysteresis"]["exponent"] = exponent
    experiment = excitation(tree, 0.8)
    assert_agree(tree, expected_of(tree, experiment), actual_of(tree, experiment))


def test_taut_damped_springs_in_series_with_the_tendons():
    tree = tree_with("tendon_compliance", dampings=SERIES_DAMPINGS)
    experiment = excitation(tree, 0.5, share=0.15)
    expected = expected_of(tree, experiment)
    assert set(expected["slack_state"]) == {3}
    assert_agree(tree, expected, actual_of(tree, experiment))


def test_slack_damped_springs_in_series_with_the_tendons():
    # a slack tendon cannot push its spring, which then returns as its own damper lets it
    tree = tree_with("tendon_compliance", dampings=SERIES_DAMPINGS)
    experiment = excitation(tree, 0.5)
    expected = expected_of(tree, experiment)
    assert set(expected["slack_state"]) == {1, 2, 3}
    assert_agree(tree, expected, actual_of(tree, experiment))


def test_a_slack_damped_spring_in_series_starts_free():
    # the lower tendon hangs by 0.4 mm; its spring, which nothing pushes, has its rest length
    tree = tree_with("spring_hysteresis", "tendon_compliance", dampings=SERIES_DAMPINGS)
    experiment = replace(excitation(tree, 0.3), initial_position=-0.17)
    expected = expected_of(tree, experiment)
    assert expected["slack_state"][0] == 1
    assert set(expected["slack_state"]) > {1}
    assert_agree(tree, expected, actual_of(tree, experiment))


SIGNAL_EFFECTS = {
    "joint_encoder_offset": {"offset": 0.0},
    "motor_encoder_offset": {"offset": 0.0},
    "joint_encoder_gain": {"error": 0.0},
    "motor_encoder_gain": {"error": 0.0},
    "measurement_delay": {"delay": 0.0},
    "deflection_gain": {"error": 0.0},
}


def recorded(effects: Mapping) -> tuple[Trajectory, dict[str, np.ndarray], np.ndarray]:
    """What truth and product record with these effects on signals; the true joint position."""
    tree = tree_with("coulomb_friction")
    moving = excitation(tree, 0.8)
    experiment = signals.Experiment(0.8, moving.motor_position, moving.load_torque, 0.05, 0.7)
    times = sample_times(experiment.duration)
    true = solver.simulate(actuator_of(tree), experiment, times)["joint_position"]
    tree["effects"] |= SIGNAL_EFFECTS | effects
    expected = record(actuator_of(tree), experiment, times, signal_maps_of(tree))
    return expected, actual_of(tree, experiment, as_measured=True), true


def assert_recorded_alike(expected: Trajectory, actual: Mapping[str, np.ndarray]) -> None:
    pairs = {
        "measured_joint_position": ("joint_position", AGREEMENT),
        "measured_motor_position": ("motor_position", AGREEMENT),
        **{
            actual_name: (
                signal,
                100.0 * TORQUE_AGREEMENT if "force" in signal else TORQUE_AGREEMENT,
            )
            for signal in CELLS.values()
            for actual_name in (f"measured_{signal}" if f"measured_{signal}" in actual else signal,)
        },
    }
    for name, (true_name, tolerance) in pairs.items():
        np.testing.assert_allclose(
            actual[name], expected[true_name], rtol=0, atol=tolerance, err_msg=name
        )


def test_encoders_with_offsets():
    offsets = {
        "joint_encoder_offset": {"offset": 0.013},
        "motor_encoder_offset": {"offset": -0.021},
    }
    expected, actual, true = recorded(offsets)
    np.testing.assert_allclose(expected["joint_position"] - true, 0.013, rtol=0, atol=1e-12)
    assert_recorded_alike(expected, actual)


def test_encoders_with_gains_and_offsets():
    """An offset is added to what a gain has enlarged."""
    wrong = {
        "joint_encoder_gain": {"error": 0.06},
        "joint_encoder_offset": {"offset": 0.3},
        "motor_encoder_gain": {"error": -0.2},
        "motor_encoder_offset": {"offset": 0.4},
    }
    expected, actual, true = recorded(wrong)
    np.testing.assert_allclose(expected["joint_position"], 1.06 * true + 0.3, rtol=0, atol=1e-12)
    assert_recorded_alike(expected, actual)


def test_a_deflection_that_is_read_too_large():
    expected, actual, true = recorded({"deflection_gain": {"error": 0.15}})
    assert np.abs(expected["joint_position"] - true).max() > 0.01
    assert_recorded_alike(expected, actual)


@pytest.mark.parametrize("cell", CELLS)
def test_a_load_cell_with_another_scale_and_zero(cell):
    """What it shows; the machine moves as it would."""
    ids = f"{cell}_gain", f"{cell}_offset"
    expected, actual, true = recorded({name: EVERY_EFFECT[name] for name in ids})
    np.testing.assert_allclose(expected["joint_position"], true, rtol=0, atol=1e-12)
    apart = actual[f"measured_{CELLS[cell]}"] - actual[CELLS[cell]]
    assert np.ptp(apart) > 0.01
    assert_recorded_alike(expected, actual)


def test_a_late_joint_side():
    # not a multiple of the samples' distance, so that nothing is hidden by them
    expected, actual, true = recorded({"measurement_delay": {"delay": 0.0137}})
    assert np.abs(expected["joint_position"] - true).max() > 0.01
    assert_recorded_alike(expected, actual)
