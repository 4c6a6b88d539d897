"""The least-squares problem of a fit: one vector in, whitened residuals and derivatives out.

The vector holds the fit's variables of the free parameters (see `coordinates`), of which a zero or
a load may be each recording's own, then the state at the first sample of each recording: position
and velocity of what the interface moves. The residual vector holds every recording and signal
divided by its sigma, then the prior of each free parameter.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from elastic_tendon.actuator.interfaces import InterfaceKind
from elastic_tendon.actuator.parameters import Model
from elastic_tendon.actuator.variables import moved_states
from elastic_tendon.comparison.initial_state import estimate_initial_state
from elastic_tendon.comparison.residuals import (
    Array,
    InitialState,
    beyond_rounding,
    effective_sigma,
    noise_floors,
    residuals_of,
    rms,
    sensitivity,
    simulate_measurement,
    slopes_beyond_rounding,
    stack,
)
from elastic_tendon.errors import ModelError, SimulationError
from elastic_tendon.estimation.coordinates import (
    Coordinates,
    Limits,
    declared_quantities,
    own_path,
    parameter_of,
)
from elastic_tendon.measurement import Measurement

# for each recording: signal -> one sigma in its unit
Sigmas = tuple[Mapping[str, float], ...]
# of the solver: it then errs by 1e-9 to 1e-6 rad in most machines, below what an encoder resolves,
# and quick dynamics, of bristles or of masses on springs, take half the time
TOLERANCE = 1e-6
FINER = 0.01  # times that, where it errs by more
ON_BOUND = 1e-9  # of an optimum, in prior sigmas
STEEPEST = 1e100  # derivative of an error beyond which there is nothing to descend along


@dataclass(frozen=True)
class Problem:
    """Fit of a model's free parameters and every recording's initial state.

    m free parameters, f recordings with s initial states each (2 at interface position); vectors
    have m + s f entries. `tolerance` : of the solver.
    """

    coordinates: Coordinates
    measurements: tuple[Measurement, ...]
    tolerance: float = TOLERANCE

    @property
    def kind(self) -> InterfaceKind:
        """What is given and what is computed."""
        return self.coordinates.given.kind

    @property
    def states(self) -> int:
        """Number of initial states of a recording."""
        return len(moved_states(self.kind))

    def start(self, model: Model) -> Array:
        """Vector at a model of the same effects, initial states estimated with it.

        Raises
        ------
        SimulationError : this model cannot be simulated
        """
        values = model.values()
        states = [self.begun(model, measurement) for measurement in self.measurements]
        for part, state in zip(self.measurements, states, strict=True):
            values |= {own_path(path, part.recording): value for path, value in state.own.items()}
        paths = self.coordinates.paths
        free = np.array([values.get(path, values[parameter_of(path)]) for path in paths])
        return np.concatenate(
            [self.coordinates.variables(free)]
            + [list(state.as_dict(self.kind).values()) for state in states]
        )

    def begun(self, model: Model, measurement: Measurement) -> InitialState:
        """State at the first sample of a recording, estimated with a model; and what it has of its
        own where that is not the model's, from one step along the derivatives.

        Raises
        ------
        SimulationError : this model cannot be simulated
        """
        coordinates = self.coordinates
        state = estimate_initial_state(model, measurement)
        known = state.own or measurement.recording == coordinates.recordings[0]
        if known or not coordinates.of_recording:
            return state
        found = sensitivity(model, measurement, state, coordinates.of_recording, self.tolerance)
        floors = [noise_floors(measurement)]
        slopes, errors = stack([found.derivatives], floors), stack([found.residuals], floors)
        step = np.linalg.lstsq(slopes, -errors)[0]
        values, declared = model.values(), declared_quantities(model)
        own = {
            path: float(np.clip(values[path] + change, declared[path].lower, declared[path].upper))
            for path, change in zip(coordinates.of_recording, step.tolist(), strict=False)
        }
        return estimate_initial_state(model, measurement, own)

    def bounds(self) -> tuple[Array, Array]:
        """Lowest and highest vector; initial states are free."""
        lower, upper = self.coordinates.bounds()
        free = np.full(self.states * len(self.measurements), np.inf)
        return np.concatenate([lower, -free]), np.concatenate([upper, free])

    def off_bounds(self, vector: Array) -> NDArray[np.bool_]:
        """Which entries of a vector are on none of their bounds, (m + s f,)."""
        lower, upper = self.bounds()
        return (vector > lower + ON_BOUND) & (vector < upper - ON_BOUND)

    def numbers(self, vector: Array) -> Array:
        """Part of the vector that holds the variables of the free parameters, (m,)."""
        return vector[: len(self.coordinates.paths)]

    def model(self, vector: Array) -> Model:
        """The model at a vector.

        Raises
        ------
        ModelError : the values together are no model
        """
        return self.coordinates.model(self.numbers(vector))

    def model_with_recordings(self, vector: Array) -> Model:
        """The model at a vector, with what recordings have of their own.

        Raises
        ------
        ModelError : the values together are no model
        """
        coordinates, numbers = self.coordinates, self.numbers(vector)
        if not coordinates.of_recording:
            return self.model(vector)
        model = self.model(vector)
        first = {path: model.values()[path] for path in coordinates.of_recording}
        own = {name: coordinates.own(numbers, name) for name in coordinates.recordings}
        return model.with_recordings({**own, coordinates.recordings[0]: first})

    def initial_states(self, vector: Array) -> list[InitialState]:
        """State at the first sample of each recording, rad and rad/s."""
        states = vector[len(self.coordinates.paths) :].reshape(len(self.measurements), self.states)
        numbers = self.numbers(vector)
        return [
            replace(
                InitialState.of(self.kind, row), own=self.coordinates.own(numbers, part.recording)
            )
            for row, part in zip(states, self.measurements, strict=True)
        ]

    def errors(self, vector: Array) -> list[dict[str, Array]]:
        """For each recording, signal -> (n,) simulated less measured, the signal's unit, see
        `beyond_rounding`.

        Raises
        ------
        ModelError, SimulationError : there is no trajectory here
        """
        model = self.model(vector)
        pairs = zip(self.measurements, self.initial_states(vector), strict=True)
        found = []
        for part, initial in pairs:
            trajectory = simulate_measurement(model, part, initial, self.tolerance)
            found.append(beyond_rounding(residuals_of(trajectory, part), part))
        return found

    def sigmas(self, vector: Array, *, independent: bool = False) -> Sigmas:
        """Weights that the errors at this vector call for, see `effective_sigma`.

        Parameters
        ----------
        vector : (m + s f,) array
        independent : take the errors of samples as independent
        """
        return tuple(
            {
                name: max(rms(error), floors[name])
                if independent
                else effective_sigma(error, floors[name])
                for name, error in errors.items()
            }
            for errors, floors in zip(
                self.errors(vector), map(noise_floors, self.measurements), strict=True
            )
        )

    def residuals(self, vector: Array, sigmas: Sigmas) -> Array:
        """Whitened errors and prior; infinite where there is no trajectory.

        Returns
        -------
        (N + m,) array
        """
        try:
            data = stack(self.errors(vector), sigmas)
        except (ModelError, SimulationError):
            count = sum(part.time.size * len(part.signals) for part in self.measurements)
            data = np.full(count, np.inf)
        return np.concatenate([data, self._prior(vector)])

    def mean_square(self, vector: Array) -> float:
        """Mean square of the errors at this vector, in the noise's."""
        floors = tuple(map(noise_floors, self.measurements))
        return float(np.mean(stack(self.errors(vector), floors) ** 2))

    def jacobian(self, vector: Array, sigmas: Sigmas) -> Array:
        """Derivatives of `residuals` to the vector, (N + m, m + s f).

        Raises
        ------
        SimulationError : the solver could not go on, or derivatives grow without bound
        """
        count = len(self.coordinates.paths)
        chain = self.coordinates.derivatives(self.numbers(vector))
        data = self.data_jacobian(vector, sigmas)
        if not np.max(np.abs(data)) < STEEPEST:
            raise SimulationError("the motion is unstable: its derivatives grow without bound")
        data[:, :count] = data[:, :count] @ chain
        prior = np.zeros((count, data.shape[1]))
        prior[:, :count] = chain / self.coordinates.sigma[:, np.newaxis]
        return np.vstack([data, prior])

    def data_jacobian(self, vector: Array, sigmas: Sigmas) -> Array:
        """Derivatives of the whitened errors to the free parameters, each in its own unit, and
        to the initial states; no prior.

        Returns
        -------
        (N, m + s f) array
        """
        model = self.model(vector)
        states = self.initial_states(vector)
        count, paths = len(self.coordinates.paths), self.coordinates.of_model
        blocks = []
        for index, measurement in enumerate(self.measurements):
            found = sensitivity(model, measurement, states[index], paths, self.tolerance)
            slopes = slopes_beyond_rounding(found.derivatives, found.residuals, measurement)
            own = stack([slopes], [sigmas[index]])
            block = np.zeros((len(own), count + self.states * len(self.measurements)))
            block[:, :count] = self.coordinates.columns(own[:, : len(paths)], measurement.recording)
            first = count + self.states * index
            block[:, first : first + self.states] = own[:, len(paths) :]
            if measurement.static:
                # long forgotten by the second row; a trace of it would scale its steps to infinity
                block[:, first + 1] = 0.0
            blocks.append(block)
        return np.vstack(blocks)

    def _prior(self, vector: Array) -> Array:
        values = self.coordinates.values(self.numbers(vector))
        return (values - self.coordinates.centre) / self.coordinates.sigma


def problem_of(
    given: Model,
    measurements: Sequence[Measurement],
    paths: Sequence[str],
    limits: Limits | None = None,
) -> Problem:
    """Problem of fitting some parameters of a model, the prior centred on the model as given.

    `limits` are bounds beside those of the quantities.

    Raises
    ------
    MeasurementError : a recording does not hold what the model's interface needs
    """
    measurements = tuple(part.to_compare(given) for part in measurements)
    coordinates = Coordinates.of(given, paths, limits, measurements)
    return Problem(coordinates, measurements)
