"""What remains is called significant where it comes with time, once or slowly, and not by chance.

How often, over many machines and noises: build_scripts/study_lack_of_fit.py.
"""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.signal import lsim, lti

from elastic_tendon.actuator.parameters import load_model
from elastic_tendon.diagnosis.data import data_of
from elastic_tendon.diagnosis.lack_of_fit import LackOfFit, _is_significant, regress
from elastic_tendon.diagnosis.options import Options
from elastic_tendon.diagnosis.search import Search
from elastic_tendon.estimation.fit import fit
from elastic_tendon.measurement import Measurement
from elastic_tendon.progress import silent
from elastic_tendon.simulation.simulate import simulate
from hidden_effect.cases import Order, build
from truth.noise import coloured_noise

GIVEN = load_model("biorob_x4_joint_3")
NOISE = 2e-4  # rad
TIME = np.arange(0.0, 8.0, 0.002)
MOTOR = 0.4 * np.sin(2 * np.pi * 0.7 * TIME) + 0.15 * np.sin(2 * np.pi * 1.9 * TIME)
LOAD = 3.0 * np.sin(2 * np.pi * 0.31 * TIME)  # N·m


def found_with(unknown: np.ndarray, noise: np.ndarray) -> LackOfFit:
    """What is said of a recording with a load, N·m, of which nobody knows, and noise, rad."""
    motion = simulate(GIVEN, TIME, MOTOR, LOAD + unknown)
    signals = {"joint_position": motion["joint_position"] + noise}
    recording = Measurement(TIME, MOTOR, signals, LOAD, name="made")
    return regress(fit(GIVEN, [recording])).found["joint_position"]


def white() -> np.ndarray:
    return NOISE * np.random.default_rng(11).standard_normal(len(TIME))


def test_a_pull_that_comes_once_is_significant() -> None:
    found = found_with(np.where(np.abs(TIME - 3.3) < 0.3, 0.4, 0.0), white())
    assert found.significant
    assert found.variables == ("time",)


def test_springs_that_warm_up_are_significant() -> None:
    torque = simulate(GIVEN, TIME, MOTOR, LOAD)["joint_torque"]
    found = found_with(0.02 * TIME / TIME[-1] * torque, white())
    assert found.significant
    assert found.variables == ("time", "elastic_torque")


def test_what_swings_on_the_link_is_significant() -> None:
    """A rod on a leaf spring, say: 6 Hz, hardly damped, integrated here by its own equation."""
    shaken = np.gradient(simulate(GIVEN, TIME, MOTOR, LOAD)["joint_velocity"], TIME)
    stiffness, damping = (2.0 * np.pi * 6.0) ** 2, 2.0 * 0.02 * 2.0 * np.pi * 6.0

    def slope(t: float, state: np.ndarray) -> list[float]:
        angle, rate = state
        return [rate, -stiffness * angle - damping * rate - float(np.interp(t, TIME, shaken))]

    rod = solve_ivp(slope, (TIME[0], TIME[-1]), [0.0, 0.0], t_eval=TIME, max_step=0.004).y
    pull = 0.001 * GIVEN.link.inertia * (stiffness * rod[0] + damping * rod[1])
    found = found_with(pull, white())
    assert found.significant
    assert found.variables == ("joint_acceleration", "history")


def test_a_drive_that_comes_late_is_significant() -> None:
    _, reached, _ = lsim(lti([1.0], [0.05, 1.0]), MOTOR, TIME)
    shown = simulate(GIVEN, TIME, reached, LOAD)["joint_position"] + white()
    recording = Measurement(TIME, MOTOR, {"joint_position": shown}, LOAD, name="made")
    found = regress(fit(GIVEN, [recording])).found["joint_position"]
    assert found.significant
    assert found.variables == ("motor_position", "history")


def test_what_pulls_shows_in_a_recording_without_a_load_column() -> None:
    pull = np.where(np.abs(TIME - 3.3) < 0.3, 0.4, 0.0)
    shown = simulate(GIVEN, TIME, MOTOR, pull)["joint_position"] + white()
    recording = Measurement(TIME, MOTOR, {"joint_position": shown}, name="made")
    found = regress(fit(GIVEN, [recording])).found["joint_position"]
    assert found.significant
    assert found.variables == ("time",)


@pytest.mark.parametrize("colour", [0.0, 0.9])
def test_noise_is_not_significant(colour: float) -> None:
    noise = coloured_noise(np.random.default_rng(12), len(TIME), NOISE, colour)
    assert not found_with(np.zeros(len(TIME)), noise).significant


def test_a_disturbance_is_not_significant() -> None:
    rng = np.random.default_rng(13)
    frequencies, phases = rng.uniform(0.3, 4.0, 30), rng.uniform(0.0, 2.0 * np.pi, 30)
    waves = np.cos(2.0 * np.pi * np.outer(TIME, frequencies) + phases).sum(axis=1)
    assert not found_with(0.01 * waves, white()).significant


@pytest.mark.parametrize(
    ("p_value", "ratio", "explains", "significant"),
    [
        (0.01, 1.1, 0.5, True),  # surely, and heard
        (0.01, 1.1, 0.1, False),  # surely, and too little
        (0.07, 1.5, 0.5, False),  # not surely, and little
        (0.07, 3.5, 0.5, True),  # not surely, and much
        (0.3, 8.0, 0.2, False),  # as a disturbance
        (0.3, 21.0, 0.2, True),  # larger than any
    ],
)
def test_the_more_is_left_the_less_sure_it_has_to_be(p_value, ratio, explains, significant) -> None:
    found = LackOfFit(p_value, False, (), explains)
    assert _is_significant(found, ratio**2, 1.0) is significant


def test_a_second_look_counts_only_where_it_leaves_no_doubt() -> None:
    first = LackOfFit(0.3, False, (), 0.1)
    doubtful, sure = (LackOfFit(p_value, True, (), 0.5) for p_value in (0.07, 0.004))
    assert first.or_surely(doubtful) is first
    assert first.or_surely(replace(sure, significant=False)) is first
    assert first.or_surely(sure) is sure


def test_a_strong_pull_that_comes_once_is_no_disturbance() -> None:
    """The parameters move towards it, so that its torque does not stand out from the others."""
    case = build(Order("outside", ("unseen load",), 3.0, "steps", seed=13))
    found = regress(fit(case.given, case.fit)).found["joint_position"]
    assert found.significant
    assert found.variables == ("time",)


def test_a_rough_spot_that_is_passed_few_times_shows_with_held_out_recordings() -> None:
    case = build(Order("outside", ("friction at a place",), 3.0, "steps", seed=12))
    seen: dict[str, bool] = {}
    for name, heldout in (("alone", ()), ("with others", case.validation)):
        search = Search.of(data_of(case.given, case.fit, heldout, Options()), silent)
        search.base()
        seen[name] = search.lack_of_fit(search.answer)["joint_position"].significant
    assert seen == {"alone": False, "with others": True}
