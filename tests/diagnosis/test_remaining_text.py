"""What is left, in words."""

from dataclasses import replace

import numpy as np

from elastic_tendon.actuator.parameters import load_model
from elastic_tendon.comparison.compare import Comparison, compare
from elastic_tendon.diagnosis.lack_of_fit import LackOfFit
from elastic_tendon.diagnosis.remaining_text import remaining_sentences
from elastic_tendon.measurement import Measurement
from elastic_tendon.simulation.simulate import simulate

GIVEN = load_model("biorob_x4_joint_3")
TIME = np.arange(0.0, 8.0, 0.002)
MOTOR = 0.4 * np.sin(2 * np.pi * 0.7 * TIME)
ONCE = LackOfFit(0.004, True, ("time",), 0.7)


def beside(error: np.ndarray) -> Comparison:
    """A recording whose joint errs so, rad."""
    noise = 2e-4 * np.random.default_rng(3).standard_normal(len(TIME))
    shown = simulate(GIVEN, TIME, MOTOR)["joint_position"] + noise + error
    return compare(GIVEN, [Measurement(TIME, MOTOR, {"joint_position": shown}, name="run.csv")])


def said(lack: LackOfFit, error: np.ndarray) -> list[str]:
    return list(remaining_sentences({"joint_position": lack}, beside(error)))


def test_what_comes_once_is_told_with_its_time() -> None:
    (sentence,) = said(ONCE, np.where(np.abs(TIME - 4.0) < 0.5, 5e-3, 0.0))
    start, end = (float(sentence.split(word)[1].split()[0]) for word in ("from ", " to "))
    assert 3.4 < start < 3.7
    assert 4.3 < end < 4.6
    assert sentence.startswith("Most of what is left of joint position comes at once, from ")
    assert sentence.endswith(" s of run.csv.")


def test_what_lasts_does_not_come_at_once() -> None:
    assert said(ONCE, 5e-3 * np.sin(3.0 * TIME)) == []


def test_on_what_it_depends_is_told_with_the_share() -> None:
    found = LackOfFit(0.004, True, ("joint_position", "velocity_sign"), 0.79)
    assert said(found, np.zeros(len(TIME))) == [
        "Of what is left of joint position, 79 % of the squared error can be predicted from joint "
        "position and the direction of motion, on stretches of time that were left out."
    ]


def test_chance_is_not_told() -> None:
    assert said(replace(ONCE, significant=False), np.where(TIME > 7.5, 5e-3, 0.0)) == []
