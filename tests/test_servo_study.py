"""The study of a servo's friction finds what its page says, on few short logs."""

import numpy as np
import pytest

from study_servo_friction import LADDERS, NOISE, errors, log


def test_logs_move_the_pendulum_and_repeat() -> None:
    first, again = log(3, 0.5), log(3, 0.5)
    assert np.array_equal(first.motor_position, again.motor_position)
    assert np.ptp(first.motor_position) > 0.05


@pytest.mark.slow
def test_load_matters_most_then_stiction_and_both_leave_noise() -> None:
    found = errors(2, 3.0)
    without, stiction, loss, both = (found[names][1] for names in LADDERS)
    assert both < loss < stiction < without
    assert both < 1.5 * NOISE
