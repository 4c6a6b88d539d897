"""The actuator of the paper: (1)-(25) with asymmetric springs, and the link it drives.

Symbols: R, r pulley radii; q joint position; eθ motor position; jθ = eθ r / R; F_p pretension;
l_p,i = F_p / k_i; index 1 the upper spring, 2 the lower. SI units, angles in rad.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field

from truth.friction import Coulomb, Dahl


@dataclass(frozen=True)
class Overstretch:
    """Protective string beside a spring (paper, Fig. 6): added force beyond `engagement`.

    With `rounding` w > 0 the string comes in smoothly, k w ln(1 + exp((e - engagement) / w));
    w = 0 is the limit: an exact kink, k max(e - engagement, 0), located by the solver.
    """

    engagement: float  # m, elongation from the spring's rest length
    stiffness: float  # N/m, of all parallel strings together
    rounding: float = 0.0  # m

    def force(self, elongation: float, engaged: bool) -> float:
        """Force of the string, N; `engaged` decides where the law is the exact kink."""
        excess = elongation - self.engagement
        if self.rounding == 0.0:
            return self.stiffness * excess if engaged else 0.0
        scaled = excess / self.rounding
        # the softplus function, written so that no exponential overflows
        softplus = max(scaled, 0.0) + math.log1p(math.exp(-abs(scaled)))
        return self.stiffness * self.rounding * softplus


@dataclass(frozen=True)
class Spring:
    """One side's spring; parallel springs are already added up (33), (34)."""

    stiffness: float  # N/m
    max_deflection: float = math.inf  # m
    damping: float = 0.0  # N s/m
    overstretch: Overstretch | None = None

    def force(self, elongation: float, rate: float, engaged: bool) -> float:
        """Force (3), N, of an `elongation` (m) from rest and its `rate` (m/s); may be negative."""
        force = self.stiffness * elongation + self.damping * rate
        if self.overstretch is not None:
            force += self.overstretch.force(elongation, engaged)
        return force


def no_torque(_time: float, _position: float, _velocity: float) -> float:
    """Torque on the joint of nothing, N·m."""
    return 0.0


@dataclass(frozen=True)
class Link:
    """What the actuator moves: J q'' = jτ_e + τ_load - b q' + extra - friction."""

    inertia: float  # kg m²
    damping: float = 0.0  # N m s/rad
    friction: Coulomb | Dahl | None = None
    # further torque on the joint, N·m, of time (s), position (rad) and velocity (rad/s); smooth
    extra_torque: Callable[[float, float, float], float] = field(default=no_torque)


@dataclass(frozen=True)
class Actuator:
    """The transmission of the paper and its link."""

    joint_pulley_radius: float  # R, m
    motor_pulley_radius: float  # r, m
    pretension_force: float  # F_p, N
    upper: Spring
    lower: Spring
    link: Link

    def elongations(self, motor_position: float, joint_position: float) -> tuple[float, float]:
        """Elongations from rest l_p,i + x_i of both springs, m: (1), (2) and (4)."""
        displacement = (
            self.motor_pulley_radius * motor_position - self.joint_pulley_radius * joint_position
        )
        return (
            self.pretension_force / self.upper.stiffness + displacement,
            self.pretension_force / self.lower.stiffness - displacement,
        )

    def spring_forces(
        self,
        motor: tuple[float, float],
        joint: tuple[float, float],
        engaged: tuple[bool, bool],
    ) -> tuple[float, float]:
        """Forces (3) of both springs before the tendons go slack, N.

        Parameters
        ----------
        motor, joint : position (rad) and velocity (rad/s) of each
        engaged : whether the upper and the lower exact overstretch kink is engaged
        """
        upper, lower = self.elongations(motor[0], joint[0])
        rate = self.motor_pulley_radius * motor[1] - self.joint_pulley_radius * joint[1]
        return (
            self.upper.force(upper, rate, engaged[0]),
            self.lower.force(lower, -rate, engaged[1]),
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
