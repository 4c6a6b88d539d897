"""The slopes of the spline through the inputs are those of scipy's, however long they are."""

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from elastic_tendon.simulation.simulate import spline_slopes


@pytest.mark.parametrize("n", [2, 3, 4, 5, 1000, 250_000])
def test_slopes_are_those_of_the_spline_through_all_samples(n: int) -> None:
    random = np.random.default_rng(n)
    time = np.cumsum(random.uniform(0.5e-3, 1.5e-3, n))
    samples = np.sin(3.0 * time) + 0.1 * random.standard_normal(n)
    wanted = CubicSpline(time, samples)(time, 1)
    size = float(np.max(np.abs(wanted)))
    np.testing.assert_allclose(spline_slopes(time, samples), wanted, atol=1e-12 * size)
