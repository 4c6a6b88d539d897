"""A recording as the array of inputs that fmpy wants."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastic_tendon.actuator.variables import POSITION_OF, interface
from elastic_tendon.measurement.recording import Measurement


def fmpy_inputs(measurement: Measurement, *, hold: bool | None = None) -> NDArray[Any]:
    """Inputs of a recording for the argument `input` of ``fmpy.simulate_fmu``.

    All inputs are held from sample to sample, and each sample is there twice, before and after the
    inputs change. fmpy gives inputs to the FMU when it looks for events, not when its integrator
    asks for rates: in model exchange, inputs that move inside a step of the integrator seem to jump
    about, results are wrong, and at tight tolerances it stalls. No FMU can cure that; inputs that
    move only where fmpy begins a new step do. In co-simulation they are constant in a step anyway.

    Parameters
    ----------
    measurement : Measurement, of another interface than position as its method `at` makes it
    hold : True: each sample holds until the next, as ``interpolation="hold"`` of `simulate`. False:
        the mean of two neighbours holds between them; the motion is that of straight lines between
        the samples, but for errors of second order in their distance. None: as the recording's own
        interpolation is "hold" or not

    Returns
    -------
    structured array (2 n - 1,) for n samples
        ``time`` (s), positions (rad), each with its velocity (rad/s, from sample to sample), and
        torques (N·m): of interface position ``motor_position``, ``motor_velocity`` and
        ``load_torque``. The motor's velocity acts where the FMU's parameter
        ``motor_velocity_connected`` is true
    """
    if hold is None:
        hold = measurement.input_interpolation == "hold"
    time = measurement.time
    held: dict[str, NDArray[np.float64]] = {}
    for variable in interface((), measurement.kind).inputs:
        if position := POSITION_OF.get(variable.name):
            change = np.diff(measurement.inputs[position]) / np.diff(time)
            held[variable.name] = np.append(change, 0.0)
        else:
            values = measurement.inputs.get(variable.name, np.zeros_like(time))
            held[variable.name] = values if hold else _means(values)
    inputs = np.empty(2 * len(time) - 1, dtype=[(name, float) for name in ("time", *held)])
    inputs["time"] = np.repeat(time, 2)[1:]
    for name, values in held.items():
        inputs[name] = np.repeat(values, 2)[:-1]
    return inputs


def _means(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Means of neighbours, and the last value."""
    return np.append((values[1:] + values[:-1]) / 2, values[-1])
