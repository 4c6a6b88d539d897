"""The state at the first sample, estimated on the beginning of a recording."""

import numpy as np
from scipy.optimize import least_squares

from elastic_tendon.errors import SimulationError
from elastic_tendon.identify.residuals import Array, InitialState, sensitivity
from elastic_tendon.measurement import Measurement
from elastic_tendon.parameters import Model

WINDOW = 0.1  # s; held-out data gives its initial state on this stretch and nothing else
MINIMUM_SAMPLES = 5  # for slow recordings, where the window would hold fewer


def estimate_initial_state(model: Model, measurement: Measurement) -> InitialState:
    """Least squares on the joint position over the first 0.1 s.

    The start is a parabola through the samples; the model then says which position and velocity
    fit best. Where it cannot tell (a sticking joint hides its velocity) the parabola's answer
    stays.

    Parameters
    ----------
    model : Model
    measurement : Measurement

    Returns
    -------
    InitialState, rad and rad/s

    Raises
    ------
    SimulationError : the solver could not go on
    """
    beginning = _beginning(measurement)
    measured = beginning.signals["joint_position"]
    fit = np.polynomial.Polynomial.fit(beginning.time - beginning.time[0], measured, 2).convert()
    # a parabola through samples that all agree comes back shorter
    start = np.append(fit.coef, [0.0, 0.0])[:2]

    def evaluate(x: Array) -> tuple[Array, Array]:
        result = sensitivity(model, beginning, InitialState(x[0], x[1]), ())
        return result.residuals["joint_position"], result.derivatives["joint_position"]

    def jacobian(x: Array) -> Array:
        return evaluate(x)[1]

    def residual(x: Array) -> Array:
        try:
            return evaluate(x)[0]
        except SimulationError:
            return np.full(len(measured), np.inf)

    evaluate(start)  # let a model that cannot be simulated say so itself
    span = float(beginning.time[-1] - beginning.time[0])
    solution = least_squares(
        residual,
        start,
        jac=jacobian,
        # a position and a velocity that move the joint by like amounts
        x_scale=[1.0, 1.0 / span],
        max_nfev=20,
    )
    return InitialState(float(solution.x[0]), float(solution.x[1]))


def _beginning(measurement: Measurement) -> Measurement:
    count = int(np.searchsorted(measurement.time, measurement.time[0] + WINDOW, side="right"))
    return measurement.samples(slice(0, max(count, MINIMUM_SAMPLES)))
