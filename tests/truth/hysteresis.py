"""Rate-independent friction inside a spring, as curves between points of reversal.

A spring remembers where its elongation last turned round and what it then carried. From there the
force is a closed function of the elongation, a `Branch`, until the next turn or until the curve
itself changes (`Branch.end`); the solver locates both.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.special import digamma, factorial, poch
from scipy.stats import gamma

Vector = NDArray[np.float64]

SAME_LENGTH = 1e-15  # m, within which elements of a Maxwell-slip model slip together
SATURATED = 36.0  # -ln of what is missing to z = 1, beyond which it is rounding
MOST_STEPS = 50  # of Newton's method, which takes about five
TERMS = np.arange(60.0)  # of a power series of at most 1/2


@dataclass(frozen=True)
class Branch:
    """A piece of a hysteresis curve along which the elongation moves one way."""

    direction: int  # 1 while the spring is being stretched, -1 while it shortens
    start: float  # m, elongation at which the piece begins
    levels: tuple[float, ...]  # what was carried there; meaning and unit as the law says
    end: float  # m, elongation at which the curve changes; infinite where it does not


class Hysteresis(Protocol):
    """A law of hysteresis; forces in N, elongations from the spring's rest length in m."""

    def begin(self, elongation: float) -> Branch:
        """Branch of a spring that carries nothing yet."""

    def force(self, branch: Branch, elongation: float) -> float:
        """Force on a branch, N."""

    def slope(self, branch: Branch, elongation: float) -> float:
        """Derivative of the force by the elongation, N/m."""

    def continued(self, branch: Branch, elongation: float, start: float, direction: int) -> Branch:
        """Branch from `start` on in `direction`, with what was carried at `elongation`."""

    def passed(self, branch: Branch) -> Branch:
        """The branch that follows at the end of one."""

    def halved(self) -> "Hysteresis":
        """Law of half the spring, which bears the same force at half the elongation."""


@dataclass(frozen=True)
class FirstLoading:
    """Bouc-Wen's z over the travel x / y from z = 0: the inverse of x / y = ∫ dz / (1 - z^n).

    With t = z^n that is ∫ t^(1/n - 1) / (1 - t) dt / n, an incomplete beta function, by its power
    series in t or in 1 - t.
    """

    exponent: float  # n

    def travel(self, z: float) -> float:
        """Travel over y at which z (0 to 1) is reached; infinite for 1."""
        if z in (0.0, 1.0):
            return z and math.inf
        logarithm = self.exponent * math.log(z)
        if logarithm < math.log(0.5):
            return z * float(np.sum(math.exp(logarithm) ** TERMS / (1.0 + self.exponent * TERMS)))
        missing = -math.expm1(logarithm)
        constant, factors = _around_one(1.0 / self.exponent)
        series = float(np.sum(factors * missing ** TERMS[1:]))
        return (constant - math.log(missing) - series) / self.exponent

    def lag(self, travel: float) -> float:
        """The z that is reached after a travel over y."""
        # Newton's method in u = -ln(1 - z), in which the travel is nearly a straight line
        u = travel
        for _ in range(MOST_STEPS):
            if not 0.0 < u < SATURATED:
                break
            z = -math.expm1(-u)
            missing = -math.expm1(self.exponent * math.log(z))
            step = (travel - self.travel(z)) * missing / (1.0 - z)
            u = max(u + step, 0.1 * u)
            if abs(step) * (1.0 - z) <= 1e-15 * z:
                break
        return -math.expm1(-u)


@cache
def _around_one(share: float) -> tuple[float, Vector]:
    """Limit of ∫ t^(a - 1) / (1 - t) dt + ln(1 - t) at t = 1, a = `share`; factors of 1 - t."""
    orders = TERMS[1:]
    return -float(digamma(share)) - np.euler_gamma, poch(1.0 - share, orders) / (
        orders * factorial(orders)
    )


@dataclass(frozen=True)
class BoucWen:
    """Bouc-Wen's law with β = γ = 1/2, integrated between reversals.

    Unloading, z is a straight line down to z = 0; loading, it follows `FirstLoading`; with n = 1
    what is missing to ±1 fades with exp(-travel / y). `Branch.levels` holds z. The force is f z.
    """

    largest_force: float  # f, N
    yield_length: float  # y, m
    exponent: float = 1.0  # n

    def begin(self, elongation: float) -> Branch:
        """See `Hysteresis`."""
        return self._branch(1, elongation, 0.0)

    def _branch(self, direction: int, start: float, z: float) -> Branch:
        unloading = z * direction < 0.0
        end = start - z * self.yield_length if unloading else direction * math.inf
        return Branch(direction, start, (z,), end)

    def lag(self, branch: Branch, elongation: float) -> float:
        """Share z of the largest force, -1 to 1.

        Before its start, where only trial steps of an integrator come, a curve is its tangent.
        """
        (z,) = branch.levels
        travel = (elongation - branch.start) / self.yield_length
        if math.isfinite(branch.end):
            return z + travel
        if branch.direction * travel < 0.0:
            return z + travel * self._yielding(z)
        if self.exponent == 1.0:
            return branch.direction - (branch.direction - z) * math.exp(-branch.direction * travel)
        loading = FirstLoading(self.exponent)
        return branch.direction * loading.lag(loading.travel(abs(z)) + branch.direction * travel)

    def _yielding(self, z: float) -> float:
        """Share of the initial slope that is left while loading."""
        return 1.0 - float(abs(z) ** self.exponent)

    def force(self, branch: Branch, elongation: float) -> float:
        """See `Hysteresis`."""
        return self.largest_force * self.lag(branch, elongation)

    def slope(self, branch: Branch, elongation: float) -> float:
        """See `Hysteresis`."""
        initial = self.largest_force / self.yield_length
        if math.isfinite(branch.end):
            return initial
        ahead = branch.direction * (elongation - branch.start) >= 0.0
        z = self.lag(branch, elongation if ahead else branch.start)
        return initial * self._yielding(z)

    def continued(self, branch: Branch, elongation: float, start: float, direction: int) -> Branch:
        """See `Hysteresis`."""
        return self._branch(direction, start, self.lag(branch, elongation))

    def passed(self, branch: Branch) -> Branch:
        """See `Hysteresis`."""
        return self._branch(branch.direction, branch.end, 0.0)

    def halved(self) -> "BoucWen":
        """See `Hysteresis`."""
        return replace(self, yield_length=0.5 * self.yield_length)


@dataclass(frozen=True)
class MaxwellSlip:
    """Parallel elements of a spring and a dry slider each (Prandtl-Ishlinskii).

    An element's force grows with its stiffness until it slips and then stays. `Branch.levels`
    holds the force of each element, N.
    """

    stiffnesses: tuple[float, ...]  # N/m
    slip_forces: tuple[float, ...]  # N

    def begin(self, elongation: float) -> Branch:
        """See `Hysteresis`."""
        return self._branch(1, elongation, [0.0] * len(self.stiffnesses))

    def _slips_at(self, direction: int, start: float, levels: Sequence[float]) -> list[float]:
        """Elongation at which each element begins to slip; infinite where it slips already."""
        return [
            direction * math.inf
            if direction * level >= limit
            else start + (direction * limit - level) / stiffness
            for level, stiffness, limit in zip(
                levels, self.stiffnesses, self.slip_forces, strict=True
            )
        ]

    def _branch(self, direction: int, start: float, levels: Sequence[float]) -> Branch:
        slips = self._slips_at(direction, start, levels)
        end = min(slips) if direction > 0 else max(slips)
        return Branch(direction, start, tuple(levels), end)

    def _levels(self, branch: Branch, elongation: float) -> list[float]:
        travel = elongation - branch.start
        return [
            level if branch.direction * level >= limit else level + stiffness * travel
            for level, stiffness, limit in zip(
                branch.levels, self.stiffnesses, self.slip_forces, strict=True
            )
        ]

    def force(self, branch: Branch, elongation: float) -> float:
        """See `Hysteresis`."""
        return sum(self._levels(branch, elongation))

    def slope(self, branch: Branch, _elongation: float) -> float:
        """See `Hysteresis`."""
        return sum(
            stiffness
            for level, stiffness, limit in zip(
                branch.levels, self.stiffnesses, self.slip_forces, strict=True
            )
            if branch.direction * level < limit
        )

    def continued(self, branch: Branch, elongation: float, start: float, direction: int) -> Branch:
        """See `Hysteresis`."""
        return self._branch(direction, start, self._levels(branch, elongation))

    def passed(self, branch: Branch) -> Branch:
        """See `Hysteresis`."""
        slips = self._slips_at(branch.direction, branch.start, branch.levels)
        levels = [
            branch.direction * limit if abs(slip - branch.end) <= SAME_LENGTH else level
            for level, slip, limit in zip(
                self._levels(branch, branch.end), slips, self.slip_forces, strict=True
            )
        ]
        return self._branch(branch.direction, branch.end, levels)

    def halved(self) -> "MaxwellSlip":
        """See `Hysteresis`."""
        return MaxwellSlip(tuple(2.0 * k for k in self.stiffnesses), self.slip_forces)


def exponential_slip(largest_force: float, yield_length: float, count: int) -> MaxwellSlip:
    """Maxwell-slip elements whose first loading curve is f (1 - exp(-e / y)), in steps.

    The curve belongs to slip lengths η with density f η exp(-η / y) / y² of the force, a gamma
    distribution. It is cut into `count` parts of equal force, each lumped at its mean slip
    length, so that a loop in which every element slips has the area of the continuous law,
    4 f (A - 2 y) for an amplitude A (m).
    """
    edges = [float(gamma.ppf(i / count, 2.0)) for i in range(count + 1)]
    means = [
        2.0 * count * float(gamma.cdf(edges[i + 1], 3.0) - gamma.cdf(edges[i], 3.0))
        for i in range(count)
    ]
    part = largest_force / count
    return MaxwellSlip(tuple(part / (mean * yield_length) for mean in means), (part,) * count)
