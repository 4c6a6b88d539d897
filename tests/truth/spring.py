"""One side's spring and what may belong to it; parallel springs are already added up (33), (34)."""

import math
from dataclasses import dataclass, replace

from truth.hysteresis import Hysteresis


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

    def slope(self, elongation: float, engaged: bool) -> float:
        """Derivative of the force by the elongation, N/m."""
        if self.rounding == 0.0:
            return self.stiffness if engaged else 0.0
        # the logistic function, likewise
        return (
            0.5
            * self.stiffness
            * (1.0 + math.tanh(0.5 * (elongation - self.engagement) / self.rounding))
        )


@dataclass(frozen=True)
class Relaxation:
    """A Maxwell branch beside the spring: its force F_m obeys F_m' = k_m e' - F_m / T."""

    stiffness: float  # k_m, N/m, of all parallel branches together
    time_constant: float  # T, s


@dataclass(frozen=True)
class LumpedMass:
    """Mass in the middle of the spring, of all parallel springs together."""

    mass: float  # kg
    damping: float = 0.0  # N s/m, against motion relative to the mean of the spring's ends


@dataclass(frozen=True)
class Spring:
    """One side's spring; forces and stiffnesses are sums over the parallel springs."""

    stiffness: float  # N/m
    max_deflection: float = math.inf  # m
    damping: float = 0.0  # N s/m
    overstretch: Overstretch | None = None
    square_stiffness: float = 0.0  # N/m²
    cubic_stiffness: float = 0.0  # N/m³
    hysteresis: Hysteresis | None = None
    relaxation: Relaxation | None = None
    compliance: float = 0.0  # m/N, of the tendon in series with the spring
    lumped: LumpedMass | None = None

    @property
    def remembers(self) -> bool:
        """Whether its force depends on what went before."""
        return self.hysteresis is not None or self.relaxation is not None

    def static_force(self, elongation: float, engaged: bool) -> float:
        """Elastic force, N, of an `elongation` (m) from rest; negative where it would push."""
        force = self.stiffness * elongation
        force += self.square_stiffness * elongation**2 + self.cubic_stiffness * elongation**3
        if self.overstretch is not None:
            force += self.overstretch.force(elongation, engaged)
        return force

    def static_slope(self, elongation: float, engaged: bool) -> float:
        """Derivative of the elastic force by the elongation, N/m."""
        slope = self.stiffness + 2.0 * self.square_stiffness * elongation
        slope += 3.0 * self.cubic_stiffness * elongation**2
        if self.overstretch is not None:
            slope += self.overstretch.slope(elongation, engaged)
        return slope

    def half(self) -> "Spring":
        """Half of the spring and of its tendon: the same force at half the elongation."""
        return replace(
            self,
            stiffness=2.0 * self.stiffness,
            max_deflection=0.5 * self.max_deflection,
            damping=2.0 * self.damping,
            overstretch=self.overstretch
            and Overstretch(
                0.5 * self.overstretch.engagement,
                2.0 * self.overstretch.stiffness,
                0.5 * self.overstretch.rounding,
            ),
            square_stiffness=4.0 * self.square_stiffness,
            cubic_stiffness=8.0 * self.cubic_stiffness,
            hysteresis=self.hysteresis and self.hysteresis.halved(),
            relaxation=self.relaxation
            and replace(self.relaxation, stiffness=2.0 * self.relaxation.stiffness),
            compliance=0.5 * self.compliance,
            lumped=None,
        )
