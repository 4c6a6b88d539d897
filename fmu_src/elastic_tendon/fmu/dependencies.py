"""Which unknowns depend on which knowns, from CasADi's sparsity over all modes."""

from dataclasses import dataclass

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from elastic_tendon.model import HybridSystem

_Pattern = NDArray[np.bool_]


@dataclass(frozen=True)
class Dependencies:
    """Patterns with a row for each output and state derivative, a column for v = [x; u; p]."""

    outputs: _Pattern
    rates: _Pattern


def _pattern(expression: ca.SX, by: ca.SX) -> _Pattern:
    dense = ca.DM(ca.jacobian_sparsity(expression, by), 1).full()
    return np.asarray(dense, dtype=np.bool_)


def dependencies(system: HybridSystem) -> Dependencies:
    """Structural dependencies, direct ones and those through modes.

    A mode may change when what decides it changes, so whatever depends on the mode depends on
    that too.
    """
    v = ca.vertcat(system.x, system.u, system.p)
    modes_by_v = _pattern(system.next_modes, v)
    modes_by_modes = _pattern(system.next_modes, system.r)
    for _ in range(len(modes_by_v)):  # modes decide modes, in chains no longer than their number
        modes_by_v = modes_by_v | modes_by_modes @ modes_by_v
    return Dependencies(
        *(
            _pattern(expression, v) | _pattern(expression, system.r) @ modes_by_v
            for expression in (system.outputs, system.rates)
        )
    )
