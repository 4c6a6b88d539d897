"""Functions that work alike on numbers, numpy arrays and CasADi symbols.

The model's equations are written once with these; numpy evaluates them for plots
and tests, CasADi turns them into derivatives and C.
"""

from collections.abc import Callable
from functools import wraps
from threading import RLock
from typing import Any, ParamSpec, TypeAlias, TypeVar

import numpy as np

Symbol: TypeAlias = Any  # float | numpy.ndarray | casadi.SX; CasADi is not imported for numbers
P = ParamSpec("P")
T = TypeVar("T")
_ALONE = RLock()
NEARLY_NOTHING = 1e-9  # base of a power below which its derivatives may have no bound


def one_at_a_time(build: Callable[P, T]) -> Callable[P, T]:
    """Let one thread at a time build expressions: CasADi shares their nodes between all of them,
    and two threads that build some crash the program now and then."""

    @wraps(build)
    def alone(*args: P.args, **kwargs: P.kwargs) -> T:
        with _ALONE:
            return build(*args, **kwargs)

    return alone


def _is_casadi(value: Symbol) -> bool:
    return type(value).__module__.startswith("casadi")


def where(condition: Symbol, then: Symbol, otherwise: Symbol) -> Symbol:
    """Choose between two expressions; the branch not chosen may be non-finite.

    Parameters
    ----------
    condition : bool, (n,) array or SX
    then, otherwise : float, (n,) array or SX; any unit, the same for both

    Returns
    -------
    float, (n,) array or SX; `then` where `condition` is not zero
    """
    if any(_is_casadi(value) for value in (condition, then, otherwise)):
        import casadi

        return casadi.if_else(condition, then, otherwise)
    return np.where(condition, then, otherwise)


def both(first: Symbol, second: Symbol) -> Symbol:
    """Logical and of two conditions."""
    if _is_casadi(first) or _is_casadi(second):
        import casadi

        return casadi.logic_and(first, second)
    return np.logical_and(first, second)


def sin(value: Symbol) -> Symbol:
    """Sine of an angle in rad."""
    return _elementary("sin", value)


def exp(value: Symbol) -> Symbol:
    """Exponential function."""
    return _elementary("exp", value)


def absolute(value: Symbol) -> Symbol:
    """Absolute value."""
    return _elementary("fabs", value)


def power(base: Symbol, exponent: Symbol) -> Symbol:
    """Power of a `base` >= 0 to an `exponent` > 0, with finite derivatives by both at base 0.

    Below `NEARLY_NOTHING` it is a straight line; the first power is the base to the last bit.
    """
    return base * where(base > NEARLY_NOTHING, base, NEARLY_NOTHING) ** (exponent - 1.0)


def _elementary(name: str, value: Symbol) -> Symbol:
    """A function that numpy and CasADi call by the same name."""
    if _is_casadi(value):
        import casadi

        return getattr(casadi, name)(value)
    return getattr(np, name)(value)
