"""Inputs that are sampled so slowly that it matters what the motor did between the samples."""

from dataclasses import replace

import numpy as np

from elastic_tendon.actuator.parameters import Model
from elastic_tendon.comparison.compare import LOOKED_AT
from elastic_tendon.comparison.initial_state import residuals_from_beginning
from elastic_tendon.comparison.residuals import (
    Array,
    noise_floors,
)
from elastic_tendon.errors import SimulationError
from elastic_tendon.measurement import Measurement
from elastic_tendon.native.interpolation import Interpolation

MATTERS = 1.0  # difference between two interpolations, of the noise
BETTER = 0.8  # error with another interpolation, of that with linear inputs
SIGNAL = "joint_position"
OTHERS: dict[Interpolation, str] = {
    "cubic": "if the motor moves smoothly",
    "hold": "if the inputs stay as they are from one sample to the next",
}


def sampling_warnings(model: Model, measurement: Measurement) -> tuple[str, ...]:
    """What is to be said of inputs that are linear between their samples, a sentence if anything.

    It is said where another interpolation of the inputs moves the simulated joint by more than the
    noise and explains the measured one clearly better: a diagnosis would blame an effect for it.

    Parameters
    ----------
    model : Model
    measurement : Measurement; SI units, with ``joint_position``

    Returns
    -------
    tuple of str; empty, or one sentence
    """
    if measurement.static or measurement.input_interpolation != "linear":
        return ()
    start = measurement.samples(slice(LOOKED_AT))
    try:
        linear = _residual(model, start)
        left = {kind: _residual(model, replace(start, interpolation=kind)) for kind in OTHERS}
    except SimulationError:
        return ()
    best = min(left, key=lambda kind: _rms(left[kind]))
    noise = noise_floors(start)[SIGNAL]
    difference = _rms(left[best] - linear)
    if difference <= MATTERS * noise or _rms(left[best]) >= BETTER * _rms(linear):
        return ()
    return (
        f"the inputs are sampled slowly for this joint: with {best} instead of linear "
        f"interpolation its simulated position moves by {1e3 * difference:.3g} mrad, "
        f"{difference / noise:.3g} times the noise, and errs {_rms(left[best]) / _rms(linear):.2g} "
        f"times as much; add --interpolation {best} {OTHERS[best]}",
    )


def _residual(model: Model, measurement: Measurement) -> Array:
    return residuals_from_beginning(model, measurement)[SIGNAL]


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))
