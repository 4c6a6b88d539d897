"""What the actuator was doing in a recording, as the fitted model has it."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from elastic_tendon.actuator.parameters import Model, sizes_of
from elastic_tendon.actuator.transmission import prestretched_length
from elastic_tendon.comparison.residuals import (
    Array,
    InitialState,
    residuals_of,
    simulate_measurement,
)
from elastic_tendon.measurement import Measurement
from elastic_tendon.simulation.simulate import Trajectory


def per_angle(model: Model, measurement: Measurement) -> float:
    """What an angle of the joint does to the signal that is looked at first, its unit per rad."""
    if measurement.first_signal.endswith("position"):
        return 1.0
    return sizes_of(model.transmission, model.link).joint_stiffness


@dataclass(frozen=True)
class Motion:
    """One recording replayed by a model; every property is an (n,) array in SI units."""

    model: Model
    measurement: Measurement
    initial: InitialState

    @cached_property
    def trajectory(self) -> Trajectory:
        """Simulated states and outputs."""
        return simulate_measurement(self.model, self.measurement, self.initial)

    @cached_property
    def errors(self) -> dict[str, Array]:
        """Simulated less measured, by signal."""
        return residuals_of(self.trajectory, self.measurement)

    @property
    def _has_springs(self) -> bool:
        return self.model.kind.has_springs

    @property
    def motor_position(self) -> Array:
        """Motor position as recorded, rad."""
        return self.measurement.motor_position

    @property
    def load_torque(self) -> Array:
        """Load torque, N·m; zero where none acts."""
        load = self.measurement.load_torque
        return np.zeros(len(self.measurement.time)) if load is None else load

    @property
    def time(self) -> Array:
        """Time since the first sample, s."""
        return np.asarray(self.measurement.time - self.measurement.time[0])

    @property
    def position(self) -> Array:
        """Joint position, rad; as recorded where it is given."""
        if not self.model.kind.has_link:
            return self.measurement.joint_position
        return self.trajectory["joint_position"]

    @cached_property
    def velocity(self) -> Array:
        """Joint velocity, rad/s."""
        if not self.model.kind.has_link:
            return np.gradient(self.position, self.measurement.time)
        return self.trajectory["joint_velocity"]

    @property
    def speed(self) -> Array:
        """Magnitude of the joint velocity, rad/s."""
        return np.abs(self.velocity)

    @cached_property
    def acceleration(self) -> Array:
        """Acceleration of the joint, rad/s²."""
        return np.gradient(self.velocity, self.measurement.time)

    @property
    def deflection(self) -> Array:
        """Deflection of the joint from the motor's position, rad; without springs 0."""
        return self.trajectory["deflection"] if self._has_springs else np.zeros(len(self.time))

    @cached_property
    def deflection_rate(self) -> Array:
        """Its rate, rad/s."""
        return np.gradient(self.deflection, self.measurement.time)

    @property
    def tensions(self) -> tuple[Array, Array]:
        """Tension of the upper and the lower tendon, N; without springs 0."""
        if not self._has_springs:
            return np.zeros(len(self.time)), np.zeros(len(self.time))
        return self.trajectory["upper_spring_force"], self.trajectory["lower_spring_force"]

    @property
    def elastic_torque(self) -> Array:
        """Torque of the tendons on the joint, N·m."""
        upper, lower = self.tensions
        return self.model.transmission.joint_pulley_radius * (upper - lower)

    @property
    def tension(self) -> Array:
        """Both tensions one after the other, (2 n,), N."""
        return np.concatenate(self.tensions)

    @cached_property
    def elongations(self) -> tuple[Array, Array]:
        """Elongation of the upper and the lower spring from rest, m; 0 where it is slack, or is
        not there."""
        if not self._has_springs:
            return self.tensions
        transmission = self.model.transmission
        found = []
        for sign, spring in ((-1.0, transmission.upper_spring), (1.0, transmission.lower_spring)):
            rest = prestretched_length(transmission.pretension_force, spring.combined_stiffness)
            reach = rest + sign * transmission.joint_pulley_radius * self.deflection
            found.append(np.maximum(reach, 0.0))
        return found[0], found[1]

    @property
    def elongation(self) -> Array:
        """Both elongations one after the other, (2 n,), m."""
        return np.concatenate(self.elongations)
