"""The study of a servo's friction finds what its page says, on few short logs."""

import numpy as np
import pytest

from study_servo_friction import SERVOS, errors, log, row


def test_logs_move_the_pendulum_and_repeat() -> None:
    servo = SERVOS["round numbers"]
    first, again = log(servo, 3, 0.5), log(servo, 3, 0.5)
    assert np.array_equal(first.motor_position, again.motor_position)
    assert np.ptp(first.motor_position) > 0.05


@pytest.mark.parametrize("name", SERVOS)
def test_models_as_given_lack_all_friction_but_that_of_m1(name: str) -> None:
    given = SERVOS[name].given
    assert set(given.effects) == {"gravity_load", "motor_friction"}
    assert given.warnings() == []


def test_a_row_says_how_many_times_larger_the_error_of_m1_is() -> None:
    assert row("a drive", {"M1": 0.1, "M6": 0.02}) == "| a drive | 100 (1) | 20 (5) |"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "best"), [("MX-64", ("M5", "M6")), ("eRob80:50", ("M3",)), ("eRob80:100", ("M6",))]
)
def test_load_matters_most_and_the_same_model_is_best_as_reported(
    name: str, best: tuple[str, ...]
) -> None:
    found = errors(SERVOS[name], 2, 3.0)
    assert min(found, key=found.__getitem__) in best
    assert found["M3"] < 0.5 * found["M1"]
    assert found["M2"] > 0.9 * found["M1"]  # stiction alone does nothing
