"""What a picture of torque over deflection shows, whatever draws it."""

from dataclasses import dataclass

import numpy as np

from elastic_tendon.actuator.parameters import Model
from elastic_tendon.actuator.transmission import characteristic_torque, slack_boundaries
from elastic_tendon.comparison.comparison import FileComparison
from elastic_tendon.comparison.locate import FileLocation
from elastic_tendon.comparison.residuals import Array
from elastic_tendon.measurement import Measurement
from elastic_tendon.reports.comparison_figures import static_torque

MARGIN = 0.15  # beside what was measured, as share of its range
POINTS = 200  # of the springs' curve
# where a torque is from
MEASURED, ESTIMATED = "measured", "of the model's springs + missing torque"


def torque_source(measurement: Measurement) -> str:
    """Where the torque of `measured_loop` is from."""
    given = measurement.static or "joint_torque" in measurement.signals
    return MEASURED if given else ESTIMATED


def measured_deflection(model: Model, file: FileComparison, location: FileLocation) -> Array:
    """Deflection of `measured_loop`, (n,) rad, of all samples; same arguments."""
    measurement = file.measurement
    if torque_source(measurement) == ESTIMATED:
        return location.variables["deflection"]
    position = {**measurement.inputs, **measurement.signals}["joint_position"]
    if measurement.static:
        return position
    return np.asarray(position - model.transmission.motor_share * measurement.motor_position)


def measured_loop(
    model: Model, file: FileComparison, location: FileLocation, kept: slice = slice(None)
) -> tuple[Array, Array]:
    """Torque of the tendons over deflection, as far as it was measured.

    Parameters
    ----------
    model : Model
    file : FileComparison
    location : FileLocation of the same recording
    kept : samples that are wanted, m of them

    Returns
    -------
    deflection (m,) rad, and torque (m,) N·m from where `torque_source` says
    """
    measurement = file.measurement
    deflection = measured_deflection(model, file, location)[kept]
    if measurement.static:
        return deflection, static_torque(measurement)[kept]
    if torque_source(measurement) == MEASURED:
        return deflection, measurement.signals["joint_torque"][kept]
    springs = characteristic_torque(deflection, model.transmission)
    return deflection, springs + location.missing_torque.torque[kept]


@dataclass(frozen=True)
class Springs:
    """Torque of a model's springs at rest: `deflection` and `torque` (k,), rad and N·m; the slack
    `boundaries` among them, rad; and the `ends` of an axis, rad.
    """

    deflection: Array
    torque: Array
    boundaries: tuple[float, ...]
    ends: tuple[float, float]


def springs_over(model: Model, deflection: Array) -> Springs:
    """The springs' own curve over the range of a motion; its deflection (n,) in rad."""
    low, high = float(np.min(deflection)), float(np.max(deflection))
    margin = MARGIN * (high - low) or MARGIN  # a joint may stand still against its motor
    boundaries = tuple(
        boundary for boundary in slack_boundaries(model.transmission) if low < boundary < high
    )
    across = np.unique(np.concatenate([np.linspace(low, high, POINTS), boundaries]))
    torque = characteristic_torque(across, model.transmission)
    return Springs(across, torque, boundaries, (low - margin, high + margin))
