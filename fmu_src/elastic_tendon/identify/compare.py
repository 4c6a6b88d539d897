"""Compare a model with measurements: how large is the error, and where does it lie."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from elastic_tendon.compiled import Trajectory
from elastic_tendon.identify.initial_state import estimate_initial_state
from elastic_tendon.identify.residuals import (
    Array,
    InitialState,
    residuals_of,
    rms,
    simulate_measurement,
)
from elastic_tendon.identify.where import Bin, where_it_fails
from elastic_tendon.measurement import Measurement, NoiseFloor, noise_sigma
from elastic_tendon.parameters import Model

SCHEMA = "elastic-tendon/comparison/1"


@dataclass(frozen=True)
class SignalError:
    """Error of one signal in one recording, simulated less measured, in the signal's unit.

    `fit_percent` is 100 (1 - ||y - y_sim|| / ||y - mean(y)||), None where the signal is constant;
    `noise_ratio` is `rmse` over the noise floor.
    """

    rmse: float
    max_abs: float
    fit_percent: float | None
    bias: float
    noise_ratio: float
    noise: NoiseFloor
    where: tuple[Bin, ...]


@dataclass(frozen=True)
class FileComparison:
    """One recording beside its simulation."""

    measurement: Measurement
    initial_state: InitialState
    trajectory: Trajectory
    signals: Mapping[str, SignalError]


@dataclass(frozen=True)
class Comparison:
    """A model beside all recordings."""

    model: Model
    files: tuple[FileComparison, ...]

    def pooled(self, quantity: Callable[[SignalError], float]) -> dict[str, float]:
        """Root mean square over all samples of all files of a per-file figure, by signal.

        Parameters
        ----------
        quantity : e.g. ``lambda error: error.rmse``; the result has its unit
        """
        sums: dict[str, list[tuple[float, int]]] = {}
        for file in self.files:
            for name, error in file.signals.items():
                entry = (quantity(error) ** 2, len(file.measurement.time))
                sums.setdefault(name, []).append(entry)
        return {
            name: float(np.sqrt(sum(v * n for v, n in entries) / sum(n for _, n in entries)))
            for name, entries in sums.items()
        }

    def rmse(self) -> dict[str, float]:
        """Root mean square error over all files, by signal, in the signals' units."""
        return self.pooled(lambda error: error.rmse)

    def noise_ratio(self) -> dict[str, float]:
        """RMS error over RMS noise floor of all files, by signal."""
        floor = self.pooled(lambda error: error.noise.sigma)
        return {name: value / floor[name] for name, value in self.rmse().items()}

    def to_json(self) -> dict[str, Any]:
        """The contract ``elastic-tendon/comparison/1``."""
        return {
            "schema": SCHEMA,
            "model": self.model.name,
            "files": [
                {
                    "name": file.measurement.name,
                    "notes": list(file.measurement.notes),
                    "initial_state": file.initial_state.as_dict(),
                    "signals": {name: asdict(error) for name, error in file.signals.items()},
                }
                for file in self.files
            ],
        }


def compare(model: Model, measurements: Sequence[Measurement]) -> Comparison:
    """Simulate every recording with its own inputs and compare.

    Only the initial state is taken from the recording, estimated on its first 0.1 s.

    Parameters
    ----------
    model : Model
    measurements : sequence of Measurement

    Returns
    -------
    Comparison

    Raises
    ------
    SimulationError : the solver could not go on
    """
    return Comparison(model, tuple(_compare_one(model, one) for one in measurements))


def _compare_one(model: Model, measurement: Measurement) -> FileComparison:
    initial = estimate_initial_state(model, measurement)
    trajectory = simulate_measurement(model, measurement, initial)
    errors = residuals_of(trajectory, measurement)
    return FileComparison(
        measurement=measurement,
        initial_state=initial,
        trajectory=trajectory,
        signals={
            name: _signal_error(error, measurement.signals[name], trajectory)
            for name, error in errors.items()
        },
    )


def _signal_error(error: Array, measured: Array, trajectory: Trajectory) -> SignalError:
    noise = noise_sigma(measured)
    rmse = rms(error)
    spread = float(np.linalg.norm(measured - np.mean(measured)))
    return SignalError(
        rmse=rmse,
        max_abs=float(np.max(np.abs(error))),
        fit_percent=100.0 * (1.0 - float(np.linalg.norm(error)) / spread) if spread > 0 else None,
        bias=float(np.mean(error)),
        noise_ratio=rmse / noise.sigma,
        noise=noise,
        where=where_it_fails(error, trajectory, noise.sigma),
    )
