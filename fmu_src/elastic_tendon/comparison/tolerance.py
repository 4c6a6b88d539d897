"""Whether every sample of a comparison lies within a tolerance that the user gives."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from elastic_tendon.comparison.residuals import residuals_of
from elastic_tendon.errors import MeasurementError

if TYPE_CHECKING:
    from elastic_tendon.comparison.comparison import Comparison


@dataclass(frozen=True)
class ToleranceCheck:
    """One signal of one recording, `static` or not, held against a tolerance, in its unit.

    `largest` is the largest magnitude of simulated less measured and `time` its place, s;
    `share_beyond` is the share of the samples beyond the tolerance, 0 to 1.
    """

    recording: str
    static: bool
    signal: str
    tolerance: float
    largest: float
    time: float
    share_beyond: float

    @property
    def met(self) -> bool:
        """Whether no sample lies beyond the tolerance."""
        return self.largest <= self.tolerance


def check_tolerances(
    comparison: "Comparison", tolerances: Mapping[str, float]
) -> tuple[ToleranceCheck, ...]:
    """Hold each signal that has a tolerance against it, in every recording that has the signal.

    Parameters
    ----------
    comparison : Comparison
    tolerances : name of a signal -> largest error that is accepted, rad or N·m, positive

    Returns
    -------
    tuple of ToleranceCheck

    Raises
    ------
    MeasurementError : no recording has one of the signals
    """
    measured = {name for file in comparison.files for name in file.signals}
    if missing := [name for name in tolerances if name not in measured]:
        raise MeasurementError(
            f"tolerance of {missing[0]}: no recording holds this signal; leave it out"
        )
    checks = []
    for file in comparison.files:
        errors = residuals_of(file.trajectory, file.measurement)
        chosen = slice(None) if file.selection is None else file.selection.chosen
        for name in filter(errors.__contains__, tolerances):
            error = np.abs(errors[name])[chosen]
            worst = int(error.argmax())
            checks.append(
                ToleranceCheck(
                    recording=file.measurement.name,
                    static=file.measurement.static,
                    signal=name,
                    tolerance=tolerances[name],
                    largest=float(error[worst]),
                    time=float(file.measurement.time[chosen][worst]),
                    share_beyond=float(np.mean(error > tolerances[name])),
                )
            )
    return tuple(checks)
