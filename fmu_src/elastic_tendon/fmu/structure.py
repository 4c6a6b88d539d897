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
    finder = _Finder(tuple(variables), dependencies)
    outputs = [variable for variable in finder.variables if variable.is_output]
    rates = finder.of_role(Role.DERIVATIVE)
    states = [variable for variable in finder.of_role(Role.STATE) if not variable.is_output]
    initial = [variable for variable in outputs + rates + states if variable.start is None]
    return Structure(
        outputs=tuple(map(finder.unknown, outputs)),
        derivatives=tuple(map(finder.unknown, rates)),
        initial_unknowns=tuple(
            finder.initial_unknown(variable)
            for variable in sorted(initial, key=lambda variable: variable.value_reference)
        ),
        event_indicators=tuple(map(finder.unknown, finder.of_role(Role.INDICATOR))),
    )


class _Finder:
    """Looks up rows and columns of `Dependencies` by variable."""

    def __init__(self, variables: tuple[FmuVariable, ...], dependencies: Dependencies) -> None:
        self.variables = variables
        self._columns = [
            variable
            for role in (Role.STATE, Role.INPUT, Role.PARAMETER, Role.OPTION)
            for variable in self.of_role(role)
        ]
        self._rows = {
            Role.OUTPUT: dependencies.outputs,
            Role.DERIVATIVE: dependencies.rates,
            Role.INDICATOR: dependencies.indicators,
        }
        self._starts = dependencies.starts

    def of_role(self, role: Role) -> list[FmuVariable]:
        """Variables of a role, in the model's order."""
        variables = (variable for variable in self.variables if variable.role is role)
        return sorted(variables, key=lambda variable: variable.index)

    def unknown(self, variable: FmuVariable) -> Unknown:
        """After initialisation, where what is fixed is no known any more."""
        row = self._row(variable)
        fixed = [known.variability == "fixed" for known in self._columns]
        return Unknown(variable, self._knowns(np.where(fixed, Dependence.NONE, row)))

    def initial_unknown(self, variable: FmuVariable) -> Unknown:
        """In initialisation: states whose start is calculated are unknowns themselves."""
        row = self._starts[variable.index] if variable.role is Role.STATE else self._row(variable)
        total = row.copy()
        for column, known in enumerate(self._columns):
            if known.role is Role.STATE and known.start is None and row[column]:
                through = np.where(self._starts[known.index] > 0, Dependence.DEPENDENT, 0)
                total = np.maximum(total, through)
                total[column] = Dependence.NONE
        # parameters are variable still, so what is more than constant is no factor
        return Unknown(variable, self._knowns(np.where(total > 1, Dependence.DEPENDENT, total)))

    def _row(self, variable: FmuVariable) -> _Kinds:
        if variable.role is Role.STATE:
            own = [known is variable for known in self._columns]
            return np.where(own, Dependence.CONSTANT, Dependence.NONE).astype(np.int8)
        if variable.role is Role.VALIDITY:
            return np.full(len(self._columns), Dependence.DEPENDENT, dtype=np.int8)
        row: _Kinds = self._rows[variable.role][variable.index]
        return row

    def _knowns(self, row: _Kinds) -> tuple[tuple[FmuVariable, Dependence], ...]:
        pairs = zip(self._columns, row, strict=True)
        dependences = ((known, Dependence(int(kind))) for known, kind in pairs if kind)
        return tuple(sorted(dependences, key=lambda pair: pair[0].value_reference))
