"""A refit that ended in a wrong minimum finds the right one beside it."""

from dataclasses import replace

import numpy as np
import pytest

from elastic_tendon.diagnosis.answer import refit
from elastic_tendon.diagnosis.candidates import elsewhere
from elastic_tendon.diagnosis.data import data_of
from elastic_tendon.diagnosis.options import Options
from elastic_tendon.diagnosis.refits import EFFORT
from elastic_tendon.diagnosis.search import Search
from elastic_tendon.diagnosis.trajectory_screen import TrajectoryScreen
from elastic_tendon.measurement import Measurement
from elastic_tendon.progress import silent
from elastic_tendon.simulation.simulate import simulate
from smooth_motion import GIVEN

COULOMB, TORQUE = "coulomb_friction", 0.05  # N·m
TRUE = GIVEN.with_effect(COULOMB, {"torque": TORQUE})


@pytest.fixture(scope="module")
def decay() -> Measurement:
    """The joint let go beside a motor that rests: dry friction holds it after a few swings."""
    time = np.arange(0.0, 3.0, 0.002)
    still = np.zeros_like(time)
    run = simulate(TRUE, time, still, still, initial_state={"joint_position": 0.15})
    noise = 2e-4 * np.random.default_rng(1).standard_normal(time.size)
    signals = {"joint_position": run["joint_position"] + noise}
    return Measurement(
        name="decay", time=time, motor_position=still, signals=signals, load_torque=still
    )


@pytest.mark.parametrize("times", [0.6, 1.3, 2.0])
def test_each_number_of_swings_has_a_minimum_and_the_deepest_is_found(decay, times) -> None:
    start = TRUE.with_values({f"effects.{COULOMB}.torque": times * TORQUE})
    wrong = refit(GIVEN, (COULOMB,), [decay], [start], replace(EFFORT, scouted=1))
    assert wrong.mean_square > 4.0

    share, model = TrajectoryScreen(wrong).beside(
        elsewhere(wrong.result.model, wrong.added, [decay])
    )[0]
    nearer = model.effects[COULOMB]["torque"] / TORQUE
    assert share < 0.5
    assert abs(np.log(nearer)) < abs(np.log(wrong.values(COULOMB)["torque"] / TORQUE))

    search = Search.of(data_of(GIVEN, [decay], [], Options(only=(COULOMB,))), silent)
    found = search._from_other_minima(wrong, EFFORT, lambda _share: None)
    assert found.mean_square < 1.1
    assert found.values(COULOMB)["torque"] == pytest.approx(TORQUE, rel=0.05)
