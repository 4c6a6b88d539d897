"""Measurement tables with the column names of the product's contract."""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from truth.noise import Sensor, measured
from truth.solver import Trajectory

UNITS = {
    "motor_position": "rad",
    "motor_velocity": "rad_per_s",
    "joint_position": "rad",
    "load_torque": "Nm",
    "joint_torque": "Nm",
    "motor_torque": "Nm",
}


def sample(
    trajectory: Trajectory,
    sensors: Mapping[str, Sensor],
    seed: int,
    signals: Sequence[str] = ("motor_position", "joint_position", "load_torque"),
) -> dict[str, NDArray[np.float64]]:
    """The trajectory as a table: `time_s` and a column `signal_unit` for each signal.

    Parameters
    ----------
    sensors : for each noisy signal; the others are shown as they are
    seed : of the noise; each column has a stream of its own, so columns may come and go
    signals : names in `UNITS`
    """
    table = {"time_s": trajectory.time}
    for name in signals:
        rng = np.random.default_rng([seed, list(UNITS).index(name)])
        table[f"{name}_{UNITS[name]}"] = measured(
            trajectory[name], sensors.get(name, Sensor()), rng
        )
    return table
