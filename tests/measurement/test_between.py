"""Whether inputs are smooth between their samples, however long the recording."""

import numpy as np
import pytest

from elastic_tendon.measurement.between import LONGEST, interpolation_of


@pytest.mark.parametrize("n", [2000, LONGEST + 1, 3 * LONGEST - 7])
def test_smooth_inputs_are_curves_and_steps_make_them_lines(n: int) -> None:
    time = 1e-3 * np.arange(n)
    smooth = np.sin(5.0 * time) + 0.3 * np.sin(40.0 * time)
    assert interpolation_of([smooth, np.ones(n)]) == "cubic"
    half = time > time[n // 2]  # of the recording
    assert interpolation_of([smooth + 0.3 * half * np.sign(np.sin(20.0 * time))]) == "linear"
    noise = 0.01 * np.random.default_rng(1).standard_normal(n)
    assert interpolation_of([smooth + half * noise]) == "linear"
