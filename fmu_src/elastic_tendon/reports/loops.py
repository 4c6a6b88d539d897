"""What a picture of torque over deflection shows, whatever draws it."""

from dataclasses import dataclass

import numpy as np

from elastic_tendon.actuator.parameters import Model
from elastic_tendon.actuator.transmission import (
    characteristic_torque,
    reflected_motor_position,
    slack_boundaries,
)
from elastic_tendon.comparison.comparison import FileComparison
from elastic_tendon.comparison.locate import FileLocation
from elastic_tendon.comparison.residuals import Array
from elastic_tendon.reports.comparison_figures import static_torque

MARGIN = 0.15  # beside what was measured, as share of its range
POINTS = 200  # of the springs' curve
MEASURED = "measured"  # where a torque is from


def measured_loop(
    model: Model, file: FileComparison, location: FileLocation
) -> tuple[Array, Array, str]:
    """Torque of the tendons over deflection, as far as it was measured.

    Parameters
    ----------
    model : Model
    file : FileComparison
    location : FileLocation of the same recording

    Returns
    -------
    deflection (n,) rad, torque (n,) N·m, and where the torque is from
    """
    measurement = file.measurement
    transmission = model.transmission
    position = {**measurement.inputs, **measurement.signals}["joint_position"]
    if measurement.static:
        return position, static_torque(measurement), MEASURED
    if "joint_torque" in measurement.signals:
        reflected = reflected_motor_position(
            measurement.motor_position,
            transmission.joint_pulley_radius,
            transmission.motor_pulley_radius,
        )
        return position - reflected, measurement.signals["joint_torque"], MEASURED
    deflection = location.variables["deflection"]
    torque = characteristic_torque(deflection, transmission) + location.missing_torque.torque
    return deflection, torque, "of the model's springs + missing torque"


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
