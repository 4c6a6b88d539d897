"""By how much a signal is late, estimated from the simulation."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from elastic_tendon.errors import MeasurementError, SimulationError
from elastic_tendon.identify.excerpt import liveliest
from elastic_tendon.identify.initial_state import estimate_initial_state
from elastic_tendon.identify.residuals import Array, autocorrelation_time, simulate_measurement
from elastic_tendon.measurement import Measurement
from elastic_tendon.parameters import Model

LONGEST = 0.2  # s, to either side
LONGEST_SHARE = 0.1  # of the recording, to either side
SAMPLES = 10_000  # of the excerpt
GRID = 41  # shifts at which the error is first looked at
SHARPEST = 1e-6  # s, to which the best shift is found
# standard error above which the recording does not tell, s
WORST_ERROR = 0.005


@dataclass(frozen=True)
class TimeShift:
    """A delay (s; positive: the sensor is late) with its standard error (s)."""

    shift: float
    standard_error: float


def estimate_time_shift(model: Model, measurement: Measurement, signal: str) -> TimeShift | None:
    """By how much a signal is late against the others, within ±0.2 s.

    The shift is the one with which the model errs least: of a measured signal against its own
    simulation, of motor position or load in what they make the joint do. A constant offset does
    not count. The simulation is moved, not the noisy recording, whose interpolation would be
    smoother between samples than at them.

    A shift is not all that makes a signal late. A larger inertia, more damping or friction than
    the model has delay the joint as well, and the estimate takes as much of that as looks like a
    delay: 3 times the inertia of a joint with a natural frequency of 6 Hz and motion up to
    5 Hz costs some ms. So fit first what is uncertain, or measure the delay at the bench.

    Parameters
    ----------
    model : Model
    measurement : Measurement; not shifted, with ``joint_position``
    signal : ``motor_position``, ``load_torque`` or a name in ``measurement.signals``

    Returns
    -------
    TimeShift, s; None where the recording cannot tell: it does not move enough, the error is
    least at the end of the range, or its standard error exceeds 5 ms. The standard error counts
    how the error is correlated in time, but no wrong parameter
    """
    from scipy.optimize import minimize_scalar

    excerpt = liveliest(measurement, SAMPLES)
    if not _moves(excerpt, signal):
        return None
    longest = min(LONGEST, LONGEST_SHARE * float(excerpt.time[-1] - excerpt.time[0]))
    error = _error_of(model, excerpt, signal, longest)

    def cost(shift: float) -> float:
        return float(np.var(error(shift)))

    grid = np.linspace(-longest, longest, GRID)
    costs = [cost(float(shift)) for shift in grid]
    best = int(np.argmin(costs))
    if best in (0, GRID - 1) or not np.isfinite(costs[best]):
        return None
    found = minimize_scalar(
        cost,
        bounds=(float(grid[best - 1]), float(grid[best + 1])),
        method="bounded",
        options={"xatol": SHARPEST},
    )
    shift = float(found.x)
    deviation = _standard_error(error, shift, 0.1 * float(grid[1] - grid[0]))
    return TimeShift(shift, deviation) if deviation <= WORST_ERROR else None


def _moves(measurement: Measurement, signal: str) -> bool:
    if signal == "load_torque":
        load = measurement.load_torque
        return load is not None and bool(np.ptp(load) > 0.0)
    if signal == "motor_position":
        return bool(np.ptp(measurement.motor_position) > 0.0)
    return bool(np.ptp(measurement.signals[signal]) > 0.0)


def _error_of(
    model: Model, measurement: Measurement, signal: str, longest: float
) -> Callable[[float], Array]:
    """Function from a shift (s) to the error at the samples that lie `longest` (s) inside."""
    time = measurement.time
    inside = (time >= time[0] + longest) & (time <= time[-1] - longest)
    inner = measurement.samples(inside)
    load = measurement.load_torque

    def later(values: Array, by: float) -> Array:
        return np.interp(inner.time - by, time, values)

    def joint_error(shift: float) -> Array:
        # a late joint sensor sees what inputs did that much earlier
        motor_by, load_by = {
            "joint_position": (shift, shift),
            "motor_position": (-shift, 0.0),
            "load_torque": (0.0, -shift),
        }[signal]
        moved = replace(
            inner,
            motor_position=later(measurement.motor_position, motor_by),
            load_torque=None if load is None else later(load, load_by),
            signals={"joint_position": inner.signals["joint_position"]},
        )
        try:
            trajectory = simulate_measurement(model, moved, estimate_initial_state(model, moved))
        except SimulationError:
            return np.full(len(inner.time), np.inf)
        return trajectory[trajectory.measured("joint_position")] - moved.signals["joint_position"]

    if signal in ("joint_position", "motor_position", "load_torque"):
        return joint_error
    trajectory = simulate_measurement(
        model, measurement, estimate_initial_state(model, measurement)
    )
    simulated = trajectory[trajectory.measured(signal)]
    return lambda shift: later(simulated, shift) - inner.signals[signal]


def _standard_error(error: Callable[[float], Array], shift: float, step: float) -> float:
    """Standard error of a shift by least squares with errors that are correlated in time, s."""
    slope = (error(shift + step) - error(shift - step)) / (2.0 * step)
    slope -= np.mean(slope)
    left = error(shift)
    left = left - np.mean(left)
    information = float(np.sum(slope**2))
    if information == 0.0:
        return np.inf
    return float(np.sqrt(np.mean(left**2) * autocorrelation_time(left) / information))


def with_time_shifts_resolved(
    model: Model, measurements: Sequence[Measurement]
) -> list[Measurement]:
    """Put estimates in the place of every shift that is left to be estimated (``"auto"``).

    Parameters
    ----------
    model : Model
    measurements : sequence of Measurement

    Returns
    -------
    list of Measurement; shifted, with the number in its preparation and a note

    Raises
    ------
    MeasurementError : the recording cannot tell by how much a signal is late
    SimulationError : the model cannot be simulated with a recording
    """
    return [_resolved(model, measurement) for measurement in measurements]


def _resolved(model: Model, measurement: Measurement) -> Measurement:
    for signal, shift in measurement.preparation.time_shift.items():
        if shift == "auto":
            measurement = _shifted(measurement, signal, _told(model, measurement, signal))
    return measurement


def _told(model: Model, measurement: Measurement, signal: str) -> TimeShift:
    found = estimate_time_shift(model, measurement, signal)
    if found is None:
        raise MeasurementError(
            f"{measurement.name}: the recording does not tell with this model by how "
            f"much {signal} is late; give "
            f"the shift as a number, such as --shift {signal}=0.004, or leave it out"
        )
    return found


def _shifted(measurement: Measurement, signal: str, found: TimeShift) -> Measurement:
    """The signal brought forward by its delay, over the time that all signals have in common."""
    shift, time = found.shift, measurement.time
    common = (time + shift >= time[0]) & (time + shift <= time[-1])
    kept = measurement.samples(common)

    def forward(values: Array) -> Array:
        return np.interp(kept.time + shift, time, values)

    load = measurement.load_torque
    signals = {
        name: forward(measurement.signals[name]) if name == signal else values
        for name, values in kept.signals.items()
    }
    preparation = measurement.preparation
    shifts = preparation.time_shift | {signal: shift}
    note = (
        f"{signal} is taken as {1e3 * shift:.2f} ms late (standard error "
        f"{1e3 * found.standard_error:.2f} ms), which was estimated with this model"
    )
    return replace(
        kept,
        motor_position=forward(measurement.motor_position)
        if signal == "motor_position"
        else kept.motor_position,
        load_torque=forward(load)
        if signal == "load_torque" and load is not None
        else kept.load_torque,
        signals=signals,
        preparation=preparation.model_copy(update={"time_shift": shifts}),
        notes=(*measurement.notes, note),
    )
