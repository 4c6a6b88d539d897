"""Compare a model with measurements: how large is the error, over all and in each slack state."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from elastic_tendon.actuator.parameters import Model
from elastic_tendon.comparison.comparison import (
    Comparison,
    FileComparison,
    signal_error,
    slack_states_measured,
)
from elastic_tendon.comparison.initial_state import estimate_initial_state, residuals_from_beginning
from elastic_tendon.comparison.residuals import (
    Array,
    InitialState,
    residuals_of,
    rms,
    simulate_measurement,
)
from elastic_tendon.comparison.selection import only_where
from elastic_tendon.measurement import (
    CLEARLY_LESS,
    Measurement,
    NoiseFloor,
    Recordings,
    listed,
)
from elastic_tendon.simulation.simulate import Trajectory

NORMAL_MEDIAN = 0.6745  # of the magnitude of normal values, in standard deviations
THIRD_DIFFERENCES = 20.0  # their variance over that of white noise, binomial(6, 3)
LOOKED_AT = 20_000  # samples from the start, to see how the inputs ran between them


def compare(
    model: Model,
    measurements: Recordings,
    initial_states: Sequence[InitialState] | None = None,
    where: Sequence[str] = (),
) -> Comparison:
    """Simulate every recording with its own inputs and compare.

    Parameters
    ----------
    model : Model
    measurements : one or several
    initial_states : at the first sample of each, as a fit to it found them; None: estimated on the
        first 0.1 s of each, all else of it unseen
    where : conditions that all hold for the samples whose errors are told, as ``"slack_state=I"``,
        ``"joint_velocity>0"``, ``"deflection<5deg"`` or ``"time=3..5"``

    Returns
    -------
    Comparison; recordings without a sample for which the conditions hold are left out

    Raises
    ------
    SimulationError : the solver could not go on
    MeasurementError : a condition cannot be read, or holds for no sample
    """
    measurements = [part.to_compare(model) for part in listed(measurements)]
    if initial_states is None:
        measurements = [_as_inputs_ran(model, part) for part in measurements]
        initial_states = [estimate_initial_state(model, part) for part in measurements]
    pairs = zip(measurements, initial_states, strict=True)
    whole = Comparison(model, tuple(_compare_one(model, *pair) for pair in pairs))
    return only_where(whole, where)


def _as_inputs_ran(model: Model, measurement: Measurement) -> Measurement:
    """The recording with straight lines between its samples, if they explain it clearly better."""
    if not measurement.has_assumed_curves:
        return measurement
    straight = measurement.with_straight_inputs()
    signal = next(iter(measurement.signals))
    curved_error, straight_error = (
        rms(residuals_from_beginning(model, part.samples(slice(LOOKED_AT)))[signal])
        for part in (measurement, straight)
    )
    return straight if straight_error**2 < CLEARLY_LESS * curved_error**2 else measurement


def _compare_one(model: Model, measurement: Measurement, initial: InitialState) -> FileComparison:
    trajectory = simulate_measurement(model, measurement, initial)
    errors = residuals_of(trajectory, measurement)
    states = slack_states_measured(model, trajectory, measurement)
    noise = _noise(model, measurement, trajectory)
    return FileComparison(
        measurement=measurement,
        initial_state=initial,
        trajectory=trajectory,
        signals={
            name: signal_error(error, measurement.signals[name], states, noise[name])
            for name, error in errors.items()
        },
    )


def _noise(
    model: Model, measurement: Measurement, trajectory: Trajectory
) -> Mapping[str, NoiseFloor]:
    """Noise of each signal; a static curve's torque has noise too, which moves the simulation.

    The measured torque is the load of a static curve. How its noise shows in the joint position,
    the model itself says: simulated once more, under a load larger by one standard deviation.
    """
    load = measurement.load_torque
    given = "joint_position" in measurement.given_noise  # then it is all that shows there
    if not measurement.static or load is None or given:
        return measurement.noise
    larger = replace(measurement, load_torque=load + _torque_noise(load))
    moved = simulate_measurement(model, larger, estimate_initial_state(model, larger))
    floor = measurement.noise["joint_position"]
    through = rms(moved["joint_position"] - trajectory["joint_position"])
    total = replace(floor, sigma=float(np.hypot(floor.sigma, through)))
    return {**measurement.noise, "joint_position": total}


def _torque_noise(torque: Array) -> float:
    """Standard deviation of white noise on a sweep (n,), N·m; n > 3.

    The median of the third differences, which wipe out a sweep; where it turns and where the
    stiffness changes they are large, but these are few.
    """
    differences = np.abs(np.diff(torque, 3))
    return float(np.median(differences)) / (NORMAL_MEDIAN * math.sqrt(THIRD_DIFFERENCES))
