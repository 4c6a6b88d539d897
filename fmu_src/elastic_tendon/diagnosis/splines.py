"""The smooth functions of which a learned curve is made; its effect file holds their text."""

from elastic_tendon.effects.symbolic import Symbol, absolute, where


def bump(u: Symbol) -> Symbol:
    """Cubic B-spline of the integers: 2/3 at 0, nothing beyond -2 and 2; smooth twice."""
    a = absolute(u)
    return where(a < 1, 2 / 3 - a**2 + a**3 / 2, where(a < 2, (2 - a) ** 3 / 6, 0))


def rise(u: Symbol) -> Symbol:
    """Integral of `bump` from 0: from -1/2 to 1/2, never falling."""
    a = absolute(u)
    half = where(
        a < 1,
        2 / 3 * a - a**3 / 3 + a**4 / 8,
        where(a < 2, 1 / 2 - (2 - a) ** 4 / 24, 1 / 2),
    )
    return where(u < 0, -half, half)
