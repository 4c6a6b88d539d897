"""The actuator of the paper: (1)-(25) with asymmetric springs, and the link it drives.

Symbols: R, r pulley radii; q joint position; eθ motor position; jθ = eθ r / R; F_p pretension;
l_p,i = F_p / k_i; index 1 the upper spring, 2 the lower. SI units, angles in rad.
"""

import math
from dataclasses import dataclass

from truth.link import Link
from truth.spring import Overstretch, Spring

__all__ = ["Actuator", "Eccentricity", "Link", "Overstretch", "Spring"]


@dataclass(frozen=True)
class Eccentricity:
    """A motor pulley off its axis: turns by θ + amplitude (sin(θ + phase) - sin(phase))."""

    amplitude: float  # rad
    phase: float = 0.0  # rad

    def driven(self, position: float, velocity: float) -> tuple[float, float]:
        """Angle (rad) and rate (rad/s) of the pulley, of those of the motor."""
        turned = self.amplitude * (math.sin(position + self.phase) - math.sin(self.phase))
        rate = velocity * (1.0 + self.amplitude * math.cos(position + self.phase))
        return position + turned, rate


@dataclass(frozen=True)
class Actuator:
    """The transmission of the paper and its link."""

    joint_pulley_radius: float  # R, m
    motor_pulley_radius: float  # r, m
    pretension_force: float  # F_p, N
    upper: Spring
    lower: Spring
    link: Link
    wrap_friction: float = 0.0  # μ φ of the tendons' guides
    gap: float = 0.0  # rad at the motor pulley, play between it and the motor
    eccentricity: Eccentricity | None = None

    @property
    def springs(self) -> tuple[Spring, Spring]:
        """The upper and the lower spring."""
        return self.upper, self.lower

    def rest_length(self, spring: Spring) -> float:
        """Elongation of a spring and its tendon at pretension, m: l_p,i and the tendon's own."""
        return self.pretension_force * (1.0 / spring.stiffness + spring.compliance)

    def elongations(self, motor_position: float, joint_position: float) -> tuple[float, float]:
        """Elongations from rest l_p,i + x_i of both sides, m: (1), (2) and (4)."""
        displacement = (
            self.motor_pulley_radius * motor_position - self.joint_pulley_radius * joint_position
        )
        return (
            self.rest_length(self.upper) + displacement,
            self.rest_length(self.lower) - displacement,
        )

    def spring_forces(
        self,
        motor: tuple[float, float],
        joint: tuple[float, float],
        engaged: tuple[bool, bool],
    ) -> tuple[float, float]:
        """Forces (3) of both springs alone before the tendons go slack, N.

        Parameters
        ----------
        motor, joint : position (rad) and velocity (rad/s) of each
        engaged : whether the upper and the lower exact overstretch kink is engaged
        """
        upper, lower = self.elongations(motor[0], joint[0])
        rate = self.motor_pulley_radius * motor[1] - self.joint_pulley_radius * joint[1]
        return (
            self.upper.static_force(upper, engaged[0]) + self.upper.damping * rate,
            self.lower.static_force(lower, engaged[1]) - self.lower.damping * rate,
        )

    def slack_boundaries(self) -> tuple[float, float]:
        """Deflections q - jθ between which no tendon is statically slack (14), rad."""
        return (
            -self.pretension_force / (self.joint_pulley_radius * self.lower.stiffness),
            self.pretension_force / (self.joint_pulley_radius * self.upper.stiffness),
        )

    def deflection_limits(self) -> tuple[float, float]:
        """Deflections q - jθ that the springs bear (15), rad; (16) with its signs put right."""
        upper, lower = self.elongations(0.0, 0.0)
        return (
            (upper - self.upper.max_deflection) / self.joint_pulley_radius,
            (self.lower.max_deflection - lower) / self.joint_pulley_radius,
        )
