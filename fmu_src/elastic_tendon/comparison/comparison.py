"""A model beside recordings: the errors, over all samples and in each slack state."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from elastic_tendon.actuator.parameters import Model
from elastic_tendon.actuator.transmission import SlackState, slack_boundaries
from elastic_tendon.actuator.variables import with_unit
from elastic_tendon.comparison.conditions import Selection, in_words
from elastic_tendon.comparison.residuals import Array, InitialState, residuals_of, rms
from elastic_tendon.comparison.tolerance import ToleranceCheck, check_tolerances
from elastic_tendon.measurement import Measurement, NoiseFloor
from elastic_tendon.result import Result
from elastic_tendon.simulation.simulate import Trajectory

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

ROUNDING = 1e-12  # relative: what a sum of equal numbers is off by
# by the number of `transmission.SlackState`
SLACK_STATES = {1: "I", 2: "II", 3: "III"}


@dataclass(frozen=True)
class ErrorFigures:
    """Error of one signal over `count` samples, simulated less measured, in the signal's unit.

    `fit_percent` is 100 (1 - ||y - y_sim|| / ||y - mean(y)||), None where the signal is constant;
    `noise_ratio` is `rmse` over the noise floor.
    """

    rmse: float
    max_abs: float
    bias: float
    fit_percent: float | None
    noise_ratio: float
    count: int


@dataclass(frozen=True)
class SignalError(ErrorFigures):
    """Error of one signal in one recording, also by the slack state of the measured deflection.

    `slack_states`, see `slack_states_measured`, holds the states that occur, by the names "I",
    "II" and "III"; both tendons at once are slack in motion only.
    """

    noise: NoiseFloor
    slack_states: Mapping[str, ErrorFigures]


@dataclass(frozen=True)
class FileComparison:
    """One recording beside its simulation; errors over the samples selected, None: over all."""

    measurement: Measurement
    initial_state: InitialState
    trajectory: Trajectory
    signals: Mapping[str, SignalError]
    selection: Selection | None = None


@dataclass(frozen=True, repr=False)
class Comparison(Result):
    """A model beside all recordings."""

    model: Model
    files: tuple[FileComparison, ...]

    @property
    def condition(self) -> str:
        """What holds for the samples that were compared; "" where these are all."""
        selection = self.files[0].selection if self.files else None
        return in_words(selection.conditions) if selection else ""

    def pooled(self, quantity: Callable[[SignalError], float]) -> dict[str, float]:
        """Root mean square over all samples of all files of a per-file figure, by signal.

        Parameters
        ----------
        quantity : e.g. ``lambda error: error.rmse``; the result has its unit
        """
        sums: dict[str, list[tuple[float, int]]] = {}
        for file in self.files:
            for name, error in file.signals.items():
                sums.setdefault(name, []).append((quantity(error) ** 2, error.count))
        return {
            name: float(np.sqrt(sum(v * n for v, n in entries) / sum(n for _, n in entries)))
            for name, entries in sums.items()
        }

    def summary(self) -> str:
        """Error of each signal over all recordings."""
        ratio = self.noise_ratio()
        count = len(self.files)
        where = f", where {self.condition}" if self.condition else ""
        lines = [f"{self.model.name} beside {count} recording{'' if count == 1 else 's'}{where}"]
        for name, rmse in self.rmse().items():
            error = with_unit(name, rmse, self.model.motion)
            lines.append(f"  {name}: RMS error {error}, {ratio[name]:.3g} times the noise")
        return "\n".join(lines)

    def to_dataframe(self) -> "pd.DataFrame":
        """Error of each signal in each recording, a row each, SI."""
        import pandas as pd

        columns = ("rmse", "max_abs", "bias", "fit_percent", "noise_ratio", "count")
        return pd.DataFrame(
            [
                {"recording": file.measurement.name, "signal": name}
                | {column: getattr(error, column) for column in columns}
                for file in self.files
                for name, error in file.signals.items()
            ]
        )

    def to_dict(self) -> dict[str, Any]:
        """As of the contract ``elastic-tendon/comparison/1``."""
        from elastic_tendon.comparison.comparison_json import comparison_json
        from elastic_tendon.comparison.locate import locate

        return comparison_json(self, locate(self))

    def plot(self) -> "Figure":
        """Draw measured and simulated signals, and the residual below each."""
        from elastic_tendon.reports.comparison_figures import overlay
        from elastic_tendon.reports.worded import worded_figure

        return worded_figure(overlay(self), self.model.motion)

    def within(self, tolerances: Mapping[str, float]) -> tuple[ToleranceCheck, ...]:
        """Hold every sample against tolerances, rad or N·m by signal: see `check_tolerances`."""
        return check_tolerances(self, tolerances)

    def rmse(self) -> dict[str, float]:
        """Root mean square error over all files, by signal, in the signals' units."""
        return self.pooled(lambda error: error.rmse)

    def noise_ratio(self) -> dict[str, float]:
        """RMS error over RMS noise floor of all files, by signal."""
        floor = self.pooled(lambda error: error.noise.sigma)
        return {name: value / floor[name] for name, value in self.rmse().items()}


def deflection_measured(model: Model, trajectory: Trajectory, measurement: Measurement) -> Array:
    """Deflection that was measured, (n,) rad, of a model with springs.

    Errors of position, taken from the simulated deflection, leave the measured one, whatever
    offsets the model knows.
    """
    errors = residuals_of(trajectory, measurement)
    ratio = model.transmission.motor_share
    motor_error = ratio * errors.get("motor_position", 0.0)  # reflected, (10)
    return np.asarray(trajectory["deflection"] - (errors.get("joint_position", 0.0) - motor_error))


def slack_states_measured(model: Model, trajectory: Trajectory, measurement: Measurement) -> Array:
    """Slack state at rest, by (14), at the deflection that was measured; (n,) `SlackState`.

    It is the machine's state as far as its deflection tells. The state in which the model is
    follows from the model's error too, and would file the error by its own consequence.

    Parameters
    ----------
    model : Model
    trajectory : Trajectory of n samples
    measurement : Measurement

    Returns
    -------
    (n,) array; 0 where the model has no springs
    """
    if not model.kind.has_springs:
        return np.zeros(len(trajectory.time))
    deflection = deflection_measured(model, trajectory, measurement)
    lower_end, upper_end = slack_boundaries(model.transmission)
    states = np.full(len(deflection), float(SlackState.III))
    # beyond its end the upper spring is shorter than at rest, and so on the other side
    states[deflection > upper_end] = SlackState.II
    states[deflection < lower_end] = SlackState.I
    return states


def signal_error(error: Array, measured: Array, states: Array, noise: NoiseFloor) -> SignalError:
    """Figures of error of one signal, over all samples given and by slack state; (n,) arrays."""
    masks = {name: states == number for number, name in SLACK_STATES.items()}
    return SignalError(
        **vars(_figures(error, measured, noise)),
        noise=noise,
        slack_states={
            name: _figures(error[mask], measured[mask], noise)
            for name, mask in masks.items()
            if mask.any()
        },
    )


def _figures(error: Array, measured: Array, noise: NoiseFloor) -> ErrorFigures:
    rmse = rms(error)
    spread = rms(measured - np.mean(measured))
    # the mean of a constant is off by rounding
    moves = spread > ROUNDING * rms(measured)
    return ErrorFigures(
        rmse=rmse,
        max_abs=float(np.max(np.abs(error))),
        bias=float(np.mean(error)),
        fit_percent=100.0 * (1.0 - rmse / spread) if moves else None,
        noise_ratio=rmse / noise.sigma,
        count=len(error),
    )
