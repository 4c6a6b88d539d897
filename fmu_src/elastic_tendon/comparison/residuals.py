"""Simulated less measured signals, their derivatives, and how much information they hold."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastic_tendon.actuator.interfaces import InterfaceKind
from elastic_tendon.actuator.parameters import Model
from elastic_tendon.actuator.variables import interface, moved_states
from elastic_tendon.measurement import Measurement
from elastic_tendon.native.library import DEFAULT_TOLERANCE
from elastic_tendon.simulation.simulate import Trajectory, sensitivities, simulate
from elastic_tendon.simulation.work import count

Array = NDArray[np.float64]

# the long steps of a static curve are solved for, with a Jacobian and its inverse each
STATIC = 4


@dataclass(frozen=True)
class InitialState:
    """State at the first sample: positions (rad) and velocities (rad/s).

    `position` and `velocity` of the joint, the others of the motor; what an interface does not
    compute stays 0. `own` : what else the recording has of its own, as the zero of an encoder, by
    dotted path; it takes the place of the model's.
    """

    position: float = 0.0
    velocity: float = 0.0
    motor_position: float = 0.0
    motor_velocity: float = 0.0
    own: Mapping[str, float] = field(default_factory=dict)

    @classmethod
    def of(cls, kind: InterfaceKind, numbers: Iterable[float]) -> "InitialState":
        """From the numbers in the order of `moved_states`."""
        names = (_FIELDS[name] for name in moved_states(kind))
        state: Any = {name: float(number) for name, number in zip(names, numbers, strict=True)}
        return cls(**state)

    def as_dict(self, kind: InterfaceKind = InterfaceKind.POSITION) -> dict[str, float]:
        """By the names of the states that an interface has."""
        return {name: getattr(self, _FIELDS[name]) for name in moved_states(kind)}

    def model(self, model: Model) -> Model:
        """The model as the recording has it."""
        if not self.own:
            return model
        present = model.values().keys() & self.own
        return model.with_values({path: self.own[path] for path in present})


_FIELDS = {  # of `InitialState`, by the state's name
    "joint_position": "position",
    "joint_velocity": "velocity",
    "motor_position": "motor_position",
    "motor_velocity": "motor_velocity",
}


@dataclass(frozen=True)
class Sensitivity:
    """Residuals of one measurement with their derivatives.

    `residuals` : signal -> (n,) array, simulated less measured, the signal's unit.
    `derivatives` : signal -> (n, m) array; columns are the parameters asked for, then the initial
    states as of `moved_states`.
    """

    residuals: dict[str, Array]
    derivatives: dict[str, Array]


def simulate_measurement(
    model: Model,
    measurement: Measurement,
    initial: InitialState,
    tolerance: float = DEFAULT_TOLERANCE,
    **instead: Array,
) -> Trajectory:
    """Simulate the recorded experiment at its own sample times.

    Parameters
    ----------
    model : Model
    measurement : Measurement at the model's interface; gives time (n,) s and inputs (n,)
    initial : InitialState, rad and rad/s
    tolerance : of the solver, see `simulate`
    instead : (n,) arrays, inputs by name in place of those that were recorded

    Returns
    -------
    Trajectory

    Raises
    ------
    SimulationError : the solver could not go on
    """
    arguments = _motion(measurement, initial, tolerance) | instead
    trajectory = simulate(initial.model(model), **arguments)
    count(_weight(measurement) * trajectory.statistics["rates"])
    return trajectory


def _motion(measurement: Measurement, initial: InitialState, tolerance: float) -> dict[str, Any]:
    """What is simulated of a recording, as arguments of `simulate`."""
    return {
        "time": measurement.time,
        **measurement.inputs,
        "initial_state": initial.as_dict(measurement.kind),
        "interpolation": measurement.input_interpolation,
        "tolerance": tolerance,
        "as_measured": True,
    }


def _weight(measurement: Measurement) -> int:
    """Times that an evaluation takes longer than usual."""
    return STATIC if measurement.static else 1


def deflection_of(trajectory: Trajectory) -> Array:
    """Simulated deflection (n,), rad; without springs as from a motor that stands at 0."""
    return trajectory["deflection" if "deflection" in trajectory.output_names else "joint_position"]


def residuals_of(trajectory: Trajectory, measurement: Measurement) -> dict[str, Array]:
    """Simulated less measured, by signal; (n,) arrays in the signals' units."""
    return {
        name: trajectory[trajectory.measured(name)] - values
        for name, values in measurement.signals.items()
    }


def beyond_rounding(errors: Mapping[str, Array], measurement: Measurement) -> dict[str, Array]:
    """Errors by signal, without what the steps of an encoder that rests hide: thousands of
    samples there say no more than one, that the joint is somewhere within the step."""
    found = dict(errors)
    for name, half in measurement.rounding.items():
        found[name] = np.sign(errors[name]) * np.maximum(np.abs(errors[name]) - half, 0.0)
    return found


def slopes_beyond_rounding(
    slopes: Mapping[str, Array], errors: Mapping[str, Array], measurement: Measurement
) -> dict[str, Array]:
    """Derivatives (n, k) by signal of `beyond_rounding`, from those of the errors as they are."""
    found = dict(slopes)
    for name, half in measurement.rounding.items():
        hidden = np.abs(errors[name]) < half
        found[name] = np.where(hidden[:, np.newaxis], 0.0, slopes[name])
    return found


def sensitivity(
    model: Model,
    measurement: Measurement,
    initial: InitialState,
    parameters: Sequence[str],
    tolerance: float = DEFAULT_TOLERANCE,
) -> Sensitivity:
    """Residuals and exact derivatives to parameters and initial state.

    Parameters
    ----------
    model : Model
    measurement : Measurement
    initial : InitialState, rad and rad/s
    parameters : dotted paths
    tolerance : of the solver, see `simulate`

    Returns
    -------
    Sensitivity

    Raises
    ------
    SimulationError : the solver could not go on
    """
    initial_states = moved_states(model.kind)
    result = sensitivities(
        initial.model(model),
        parameters=tuple(parameters),
        initial_states=initial_states,
        **_motion(measurement, initial, tolerance),
    )
    columns = (len(parameters) + len(initial_states)) * len(interface(*model.structure).states)
    count(_weight(measurement) * result.trajectory.statistics["rates"], columns)
    return Sensitivity(
        residuals=residuals_of(result.trajectory, measurement),
        derivatives={
            name: result.of(result.trajectory.measured(name)) for name in measurement.signals
        },
    )


def rms(values: Array) -> float:
    """Root mean square of an (n,) array, in its unit."""
    return float(np.sqrt(np.mean(values**2)))


def autocorrelation_time(residual: Array) -> float:
    """Number of samples that together say as much as one independent sample.

    The integrated autocorrelation 1 + 2 sum(rho_k), summed over neighbouring pairs while they are
    positive (Geyer, Practical Markov chain Monte Carlo, 1992). The mean is not removed: a constant
    error is one fact, however many samples show it.

    Parameters
    ----------
    residual : (n,) array, any unit

    Returns
    -------
    float, between 1 and n
    """
    n = len(residual)
    spectrum = np.abs(np.fft.rfft(residual, 2 * n)) ** 2
    covariance = np.fft.irfft(spectrum)[:n]
    if covariance[0] <= 0.0:
        return 1.0
    pairs = (covariance[0 : n - 1 : 2] + covariance[1:n:2]) / covariance[0]
    negative = np.flatnonzero(pairs <= 0.0)
    count = int(negative[0]) if len(negative) else len(pairs)
    return float(np.clip(2.0 * np.sum(pairs[:count]) - 1.0, 1.0, n))


def effective_sigma(residual: Array, floor: float) -> float:
    """Weight under which a sum of squares counts what the residual really tells.

    Where the model fails, the residual is larger than the noise and far from white. Weighted with
    the noise alone, thousands of samples of one and the same lack of fit would overrule the prior
    and give intervals that are far too narrow. So each sample counts with the residual's own RMS
    (never less than the noise floor), inflated by the root of its autocorrelation time. For a
    model that is right this is the noise floor.

    Parameters
    ----------
    residual : (n,) array
    floor : float, noise floor, the residual's unit

    Returns
    -------
    float, the residual's unit
    """
    return max(rms(residual), floor) * float(np.sqrt(autocorrelation_time(residual)))


def noise_floors(measurement: Measurement) -> dict[str, float]:
    """One-sigma noise of every signal, in its unit."""
    return {name: floor.sigma for name, floor in measurement.noise.items()}


def stack(parts: Sequence[Mapping[str, Array]], sigmas: Sequence[Mapping[str, float]]) -> Array:
    """Join the arrays of all measurements and signals, each divided by its sigma.

    Parameters
    ----------
    parts : for each measurement, signal -> (n,) or (n, m) array
    sigmas : for each measurement, signal -> float of the same unit

    Returns
    -------
    (N,) or (N, m) array
    """
    return np.concatenate(
        [
            values / sigma[name]
            for part, sigma in zip(parts, sigmas, strict=True)
            for name, values in part.items()
        ]
    )
