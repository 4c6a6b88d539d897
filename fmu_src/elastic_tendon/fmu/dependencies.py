"""Which unknowns depend on which knowns, and how, from CasADi's expressions over all modes."""

from collections.abc import Callable
from dataclasses import dataclass
from enum import IntEnum

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from elastic_tendon.actuator.system import HybridSystem
from elastic_tendon.actuator.variables import MOTOR_VELOCITY
from elastic_tendon.effects.symbolic import one_at_a_time

_Pattern = NDArray[np.bool_]
_Kinds = NDArray[np.int8]


class Dependence(IntEnum):
    """How a known enters an unknown: by a factor that is constant, fixed..., or otherwise.

    In the order of generality, so that of several ways the largest covers all.
    """

    NONE = 0
    CONSTANT = 1
    FIXED = 2
    TUNABLE = 3
    DISCRETE = 4
    DEPENDENT = 5


@dataclass(frozen=True)
class Dependencies:
    """How outputs, state derivatives, event indicators and calculated starts depend on knowns.

    A row for each of these, in it a `Dependence` on each of v = [x; u; p] and, last, where the
    motor velocity is an input, on whether it is connected. Rows of `starts` hold no calculated
    start but what it comes from.
    `jumps` tells of each state whether an event may change it.
    """

    outputs: _Kinds
    rates: _Kinds
    indicators: _Kinds
    starts: _Kinds
    jumps: tuple[bool, ...]


@dataclass(frozen=True)
class _Seen:
    """Expressions of a system as its FMU has them, and the symbols they are made of.

    `factors` are the symbols that make a factor more than constant.
    """

    v: ca.SX
    w: ca.SX
    r: ca.SX
    factors: tuple[tuple[Dependence, ca.SX], ...]
    expressions: dict[str, ca.SX]


def _seen(system: HybridSystem) -> _Seen:
    interface, x, u, w, r = system.interface, system.x, system.u, system.w, system.r
    n = len(interface.parameters)
    p, as_measured = system.p[:n], system.p[n:]
    optional = [i for i, variable in enumerate(interface.inputs) if variable is MOTOR_VELOCITY]
    connected, rate = ca.SX.sym("connected", len(optional)), _column(u[optional])
    names = ("outputs", "rates", "indicators", "starts", "next_modes", "residuals")
    columns = ca.substitute(
        [getattr(system, name) for name in names],
        [rate, as_measured],
        [connected * rate, ca.SX.zeros(as_measured.shape)],  # an FMU is given the true position
    )
    tunable = np.array([parameter.tunable for parameter in interface.parameters])
    factors = (
        (Dependence.FIXED, ca.vertcat(p[np.flatnonzero(~tunable).tolist()], connected)),
        (Dependence.TUNABLE, p[np.flatnonzero(tunable).tolist()]),
        (Dependence.DISCRETE, r),
        (Dependence.DEPENDENT, ca.vertcat(x, u, w)),
    )
    v = ca.vertcat(x, u, p, connected)
    return _Seen(v, w, r, factors, dict(zip(names, columns, strict=True)))


def _column(symbols: ca.SX) -> ca.SX:
    """As a column; CasADi takes nothing of one for a row."""
    return symbols if symbols.numel() else ca.SX(0, 1)


@one_at_a_time
def dependencies(system: HybridSystem) -> Dependencies:
    """Structural dependencies, direct ones, through implicit unknowns and through modes.

    A mode may change when what decides it changes, so whatever depends on the mode depends on
    that too.
    """
    seen = _seen(system)
    how = _how(seen)
    outputs, rates, indicators, starts = (
        how(seen.expressions[name]) for name in ("outputs", "rates", "indicators", "starts")
    )
    calculated = [i for i, state in enumerate(system.interface.states) if state.start is None]
    return Dependencies(
        *(outputs, rates, indicators),
        starts=_resolved(starts, calculated),
        jumps=tuple(bool(row.any()) for row in _pattern(system.reset, system.r_next)),
    )


def _how(seen: _Seen) -> Callable[[ca.SX], _Kinds]:
    """Function that says how an expression depends on v."""
    residuals, next_modes = seen.expressions["residuals"], seen.expressions["next_modes"]
    among = _pattern(residuals, seen.w)
    unknowns_by_v = _transitive(among, _pattern(residuals, seen.v))
    unknowns_by_modes = _transitive(among, _pattern(residuals, seen.r))

    def by_unknowns(expression: ca.SX) -> _Pattern:
        return _pattern(expression, seen.w) @ unknowns_by_v

    def by_modes(expression: ca.SX) -> _Pattern:
        return _pattern(expression, seen.r) | _pattern(expression, seen.w) @ unknowns_by_modes

    modes_by_v = _transitive(
        by_modes(next_modes), _pattern(next_modes, seen.v) | by_unknowns(next_modes)
    )

    def how(expression: ca.SX) -> _Kinds:
        kinds = _direct(expression, seen)
        kinds[by_unknowns(expression)] = Dependence.DEPENDENT
        moved = by_modes(expression) @ modes_by_v
        # a factor that changes at events is one still; what acts through events alone is not
        kinds[moved & (kinds > 0)] = np.maximum(kinds[moved & (kinds > 0)], Dependence.DISCRETE)
        kinds[moved & (kinds == 0)] = Dependence.DEPENDENT
        return kinds

    return how


def _direct(expression: ca.SX, seen: _Seen) -> _Kinds:
    """How an expression depends on v, modes and implicit unknowns held."""
    jacobian = ca.jacobian(expression, seen.v)
    entries = ca.SX(ca.Sparsity.dense(jacobian.nnz(), 1), jacobian.nz[:])
    kinds = np.full(jacobian.nnz(), Dependence.CONSTANT, dtype=np.int8)
    for kind, symbols in seen.factors:
        kinds[_pattern(entries, symbols).any(axis=1)] = kind
    # whose derivative is zero enters by comparisons
    kinds[[entry.is_zero() for entry in ca.vertsplit(entries)]] = Dependence.DEPENDENT
    dense = np.where(_pattern(expression, seen.v), Dependence.DEPENDENT, 0).astype(np.int8)
    rows, columns = jacobian.sparsity().get_triplet()
    dense[rows, columns] = kinds
    return dense


def _resolved(starts: _Kinds, calculated: list[int]) -> _Kinds:
    """Starts by what they come from, calculated starts of other states put in."""
    pattern = starts > 0
    among = np.zeros_like(pattern[:, : len(pattern)])
    among[:, calculated] = pattern[:, calculated]
    through = _transitive(among, pattern) & ~pattern
    kinds = np.where(through, Dependence.DEPENDENT, starts).astype(np.int8)
    kinds[:, calculated] = Dependence.NONE
    return kinds


def _pattern(expression: ca.SX, by: ca.SX) -> _Pattern:
    dense = ca.DM(ca.jacobian_sparsity(expression, by), 1).full()
    return np.asarray(dense, dtype=np.bool_)


def _transitive(among: _Pattern, direct: _Pattern) -> _Pattern:
    """Dependencies of things that depend on each other, in chains no longer than their number."""
    for _ in range(len(direct)):
        direct = direct | among @ direct
    return direct
