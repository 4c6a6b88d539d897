"""Simulated less measured signals, their derivatives, and how much information they hold."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastic_tendon.actuator.parameters import Model
from elastic_tendon.actuator.variables import interface
from elastic_tendon.measurement import Measurement
from elastic_tendon.native.library import DEFAULT_TOLERANCE
from elastic_tendon.simulation.simulate import Trajectory, sensitivities, simulate
from elastic_tendon.simulation.work import count

Array = NDArray[np.float64]

# the long steps of a static curve are solved for, with a Jacobian and its inverse each
STATIC = 4
INITIAL_STATES = ("joint_position", "joint_velocity")


@dataclass(frozen=True)
class InitialState:
    """State of the joint at the first sample: position (rad) and velocity (rad/s)."""

    position: float
    velocity: float

    def as_dict(self) -> dict[str, float]:
        """By the names of the states."""
        return dict(zip(INITIAL_STATES, (self.position, self.velocity), strict=True))


@dataclass(frozen=True)
class Sensitivity:
    """Residuals of one measurement with their derivatives.

    `residuals` : signal -> (n,) array, simulated less measured, the signal's unit.
    `derivatives` : signal -> (n, m) array; columns are the parameters asked for, then the initial
    position and velocity.
    """

    residuals: dict[str, Array]
    derivatives: dict[str, Array]


def simulate_measurement(
    model: Model,
    measurement: Measurement,
    initial: InitialState,
    tolerance: float = DEFAULT_TOLERANCE,
) -> Trajectory:
    """Simulate the recorded experiment at its own sample times.

    Parameters
    ----------
    model : Model
    measurement : Measurement; gives time (n,) s, motor position (n,) rad and load (n,) N·m
    initial : InitialState, rad and rad/s
    tolerance : of the solver, see `simulate`

    Returns
    -------
    Trajectory

    Raises
    ------
    SimulationError : the solver could not go on
    """
    trajectory = simulate(model, **_motion(measurement, initial, tolerance))
    count(_weight(measurement) * trajectory.statistics["rates"])
    return trajectory


def _motion(measurement: Measurement, initial: InitialState, tolerance: float) -> dict[str, Any]:
    """What is simulated of a recording, as arguments of `simulate`."""
    return {
        "time": measurement.time,
        "motor_position": measurement.motor_position,
        "load_torque": measurement.load_torque,
        "initial_state": initial.as_dict(),
        "interpolation": measurement.input_interpolation,
        "tolerance": tolerance,
        "as_measured": True,
    }


def _weight(measurement: Measurement) -> int:
    """Times that an evaluation takes longer than usual."""
    return STATIC if measurement.static else 1


def residuals_of(trajectory: Trajectory, measurement: Measurement) -> dict[str, Array]:
    """Simulated less measured, by signal; (n,) arrays in the signals' units."""
    return {
        name: trajectory[trajectory.measured(name)] - values
        for name, values in measurement.signals.items()
    }


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
    parameters : dotted paths, m - 2 of them
    tolerance : of the solver, see `simulate`

    Returns
    -------
    Sensitivity

    Raises
    ------
    SimulationError : the solver could not go on
    """
    result = sensitivities(
        model,
        parameters=tuple(parameters),
        initial_states=INITIAL_STATES,
        **_motion(measurement, initial, tolerance),
    )
    columns = (len(parameters) + len(INITIAL_STATES)) * len(interface(model.effect_ids).states)
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
