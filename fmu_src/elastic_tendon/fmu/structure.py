"""The model's structure as FMI lists it: unknowns, and the knowns that each depends on."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastic_tendon.fmu.dependencies import Dependence, Dependencies
from elastic_tendon.native.layout import FmuVariable, Role

_Kinds = NDArray[np.int8]


@dataclass(frozen=True)
class Unknown:
    """A variable that is calculated, and how it depends on knowns, ordered by value reference."""

    variable: FmuVariable
    knowns: tuple[tuple[FmuVariable, Dependence], ...]


@dataclass(frozen=True)
class Structure:
    """Unknowns in the order of FMI's lists.

    Knowns are inputs, states and tunable parameters; of `initial_unknowns` inputs and all that has
    an exact start.
    """

    outputs: tuple[Unknown, ...]
    derivatives: tuple[Unknown, ...]
    initial_unknowns: tuple[Unknown, ...]
    event_indicators: tuple[Unknown, ...]


def structure(variables: Iterable[FmuVariable], dependencies: Dependencies) -> Structure:
    """Structure of an FMU.

    Parameters
    ----------
    variables : from `layout`
    dependencies : of the same system
    """
    found = _Finder(tuple(variables), dependencies)
    outputs = [one for one in found.variables if one.is_output]
    rates = found.of_role(Role.DERIVATIVE)
    states = [one for one in found.of_role(Role.STATE) if not one.is_output]
    initial = [one for one in outputs + rates + states if one.start is None]
    return Structure(
        outputs=tuple(map(found.unknown, outputs)),
        derivatives=tuple(map(found.unknown, rates)),
        initial_unknowns=tuple(
            found.initial_unknown(one)
            for one in sorted(initial, key=lambda one: one.value_reference)
        ),
        event_indicators=tuple(map(found.unknown, found.of_role(Role.INDICATOR))),
    )


class _Finder:
    """Looks up rows and columns of `Dependencies` by variable."""

    def __init__(self, variables: tuple[FmuVariable, ...], dependencies: Dependencies) -> None:
        self.variables = variables
        self._columns = [
            one
            for role in (Role.STATE, Role.INPUT, Role.PARAMETER, Role.OPTION)
            for one in self.of_role(role)
        ]
        self._rows = {
            Role.OUTPUT: dependencies.outputs,
            Role.DERIVATIVE: dependencies.rates,
            Role.INDICATOR: dependencies.indicators,
        }
        self._starts = dependencies.starts

    def of_role(self, role: Role) -> list[FmuVariable]:
        """Variables of a role, in the model's order."""
        found = (one for one in self.variables if one.role is role)
        return sorted(found, key=lambda one: one.index)

    def unknown(self, one: FmuVariable) -> Unknown:
        """After initialisation, where what is fixed is no known any more."""
        row = self._row(one)
        fixed = [known.variability == "fixed" for known in self._columns]
        return Unknown(one, self._knowns(np.where(fixed, Dependence.NONE, row)))

    def initial_unknown(self, one: FmuVariable) -> Unknown:
        """In initialisation: states whose start is calculated are unknowns themselves."""
        row = self._starts[one.index] if one.role is Role.STATE else self._row(one)
        total = row.copy()
        for column, known in enumerate(self._columns):
            if known.role is Role.STATE and known.start is None and row[column]:
                through = np.where(self._starts[known.index] > 0, Dependence.DEPENDENT, 0)
                total = np.maximum(total, through)
                total[column] = Dependence.NONE
        # parameters are variable still, so what is more than constant is no factor
        return Unknown(one, self._knowns(np.where(total > 1, Dependence.DEPENDENT, total)))

    def _row(self, one: FmuVariable) -> _Kinds:
        if one.role is Role.STATE:
            own = [known is one for known in self._columns]
            return np.where(own, Dependence.CONSTANT, Dependence.NONE).astype(np.int8)
        row: _Kinds = self._rows[one.role][one.index]
        return row

    def _knowns(self, row: _Kinds) -> tuple[tuple[FmuVariable, Dependence], ...]:
        pairs = zip(self._columns, row, strict=True)
        found = ((known, Dependence(int(kind))) for known, kind in pairs if kind)
        return tuple(sorted(found, key=lambda pair: pair[0].value_reference))
