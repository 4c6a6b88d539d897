"""What encoders with offsets, load cells and a late joint side record of a motion."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from truth.actuator import Actuator
from truth.signals import Experiment, later
from truth.solver import Trajectory, simulate

Vector = NDArray[np.float64]

# signals that come from the joint's side, and so late; forces of tendons are those at its pulley
JOINT_SIDE = (
    *("joint_position", "joint_velocity", "joint_torque"),
    *("upper_spring_force", "lower_spring_force"),
)


@dataclass(frozen=True)
class SignalMaps:
    """Offsets that encoders add (rad), the share by which they read too much before, the `delay`
    (s) of the joint's side, and the share of its deflection that is read too much where that is
    measured. `cells`: of a torque or a force by name, the share that is read too much, and what is
    read where there is none."""

    joint_offset: float = 0.0
    motor_offset: float = 0.0
    delay: float = 0.0
    joint_share: float = 0.0
    motor_share: float = 0.0
    deflection_share: float = 0.0
    cells: Mapping[str, tuple[float, float]] = field(default_factory=dict)

    def read_of_motor(self, position: Vector) -> Vector:
        """What the motor's encoder shows of true positions (n,), rad."""
        return (1.0 + self.motor_share) * position + self.motor_offset


def waiting(experiment: Experiment, delay: float) -> Experiment:
    """The experiment after a wait of `delay` (s) at its first inputs, from the same state."""
    return replace(
        experiment,
        duration=experiment.duration + delay,
        motor_position=later(experiment.motor_position, delay),
        load_torque=later(experiment.load_torque, delay),
    )


def record(
    actuator: Actuator, experiment: Experiment, time: Vector, maps: SignalMaps
) -> Trajectory:
    """Simulate as `solver.simulate` and show at `time` (s) what is recorded.

    What the joint's side records at zero is the initial state, as of a run that began a delay
    earlier with its inputs at rest; the motor's side is recorded as it happens.
    """
    run = simulate(
        actuator,
        waiting(experiment, maps.delay),
        np.unique(np.concatenate([time, time + maps.delay])),
    )
    late, present = (np.searchsorted(run.time, one) for one in (time, time + maps.delay))
    columns = {
        name: column[late if name in JOINT_SIDE else present]
        for name, column in run.columns.items()
    }
    ratio = actuator.motor_pulley_radius / actuator.joint_pulley_radius
    deflection = columns["joint_position"] - ratio * columns["motor_position"]
    columns["joint_position"] = (
        (1.0 + maps.joint_share) * columns["joint_position"]
        + maps.joint_offset
        + maps.deflection_share * deflection
    )
    columns["motor_position"] = maps.read_of_motor(columns["motor_position"])
    for name, (share, zero) in maps.cells.items():
        columns[name] = columns[name] * (1.0 + share) + zero
    return replace(run, time=time, columns=columns)
