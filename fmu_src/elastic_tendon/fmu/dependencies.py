"""Which unknowns depend on which knowns, from CasADi's sparsity over all modes."""

from dataclasses import dataclass

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from elastic_tendon.system import HybridSystem

_Pattern = NDArray[np.bool_]


@dataclass(frozen=True)
class Dependencies:
    """Patterns with a row for each output, state derivative and calculated start of a state.

    Columns are v = [x; u; p]. Rows of `starts` hold no calculated start but what it comes from.
    """

    outputs: _Pattern
    rates: _Pattern
    starts: _Pattern


def _pattern(expression: ca.SX, by: ca.SX) -> _Pattern:
    dense = ca.DM(ca.jacobian_sparsity(expression, by), 1).full()
    return np.asarray(dense, dtype=np.bool_)


def dependencies(system: HybridSystem) -> Dependencies:
    """Structural dependencies, direct ones, through implicit unknowns and through modes.

    A mode may change when what decides it changes, so whatever depends on the mode depends on
    that too.
    """
    p = system.p[: len(system.interface.parameters)]
    v = ca.vertcat(system.x, system.u, p)
    unknowns_by_v = _closed(system.residuals, system.w, _pattern(system.residuals, v))
    unknowns_by_modes = _closed(system.residuals, system.w, _pattern(system.residuals, system.r))

    def by_v(expression: ca.SX) -> _Pattern:
        return _pattern(expression, v) | _pattern(expression, system.w) @ unknowns_by_v

    def by_modes(expression: ca.SX) -> _Pattern:
        return _pattern(expression, system.r) | _pattern(expression, system.w) @ unknowns_by_modes

    modes_by_v = _transitive(by_modes(system.next_modes), by_v(system.next_modes))
    outputs, rates, starts = (
        by_v(expression) | by_modes(expression) @ modes_by_v
        for expression in (system.outputs, system.rates, system.starts)
    )
    calculated = [i for i, state in enumerate(system.interface.states) if state.start is None]
    among = np.zeros_like(starts[:, : len(starts)])
    among[:, calculated] = starts[:, calculated]
    starts = _transitive(among, starts)
    starts[:, calculated] = False
    return Dependencies(outputs, rates, starts)


def _closed(residuals: ca.SX, unknowns: ca.SX, direct: _Pattern) -> _Pattern:
    """What unknowns depend on, through their own equations and each other's."""
    return _transitive(_pattern(residuals, unknowns), direct)


def _transitive(among: _Pattern, direct: _Pattern) -> _Pattern:
    """Dependencies of things that depend on each other, in chains no longer than their number."""
    for _ in range(len(direct)):
        direct = direct | among @ direct
    return direct
