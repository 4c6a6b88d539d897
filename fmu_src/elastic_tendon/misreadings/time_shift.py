"""By how much a signal is late, estimated from the simulation."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from elastic_tendon.actuator.parameters import Model
from elastic_tendon.comparison.initial_state import estimate_initial_state
from elastic_tendon.comparison.residuals import Array, autocorrelation_time, simulate_measurement
from elastic_tendon.errors import MeasurementError, SimulationError
from elastic_tendon.measurement import Measurement
from elastic_tendon.measurement.excerpt import liveliest

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

    A late sensor is not all that makes a signal late. An inertia that the model has 20 % too large
    passes for a joint sensor that is 0.2 to 27 ms early (actuators of 4 to 10 Hz, motion up to
    5 Hz), far more than the standard error, and friction that the model lacks for some ms of
    delay; with grossly wrong numbers there is no answer. So fit first what is uncertain, or
    measure the delay at the bench.

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
    minimum = minimize_scalar(
        cost,
        bounds=(float(grid[best - 1]), float(grid[best + 1])),
        method="bounded",
        options={"xatol": SHARPEST},
    )
    shift = float(minimum.x)
    deviation = _standard_error(error, shift, 0.1 * float(grid[1] - grid[0]))
    return TimeShift(shift, deviation) if deviation <= WORST_ERROR else None


def _moves(measurement: Measurement, signal: str) -> bool:
    values = (measurement.inputs | dict(measurement.signals)).get(signal)
    return values is not None and bool(np.ptp(values) > 0.0)


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
    shifts_resolved: dict[str, TimeShift] = {}
    shifts: dict[str, float] = {}
    for signal, shift in measurement.preparation.time_shift.items():
        if shift == "auto":
            shifts_resolved[signal] = _estimated_shift(model, measurement.shifted(shifts), signal)
            shifts[signal] = shifts_resolved[signal].shift
    notes = [
        f"{signal} is taken as {1e3 * late.shift:.2f} ms late, which was estimated with this model "
        f"(standard error {1e3 * late.standard_error:.2f} ms if the model is right; friction that "
        "it lacks or a wrong inertia passes for a delay)"
        for signal, late in shifts_resolved.items()
    ]
    # all at once, as when the file is read again with these numbers
    return measurement.shifted(shifts).noted(notes)


def _estimated_shift(model: Model, measurement: Measurement, signal: str) -> TimeShift:
    shift = estimate_time_shift(model, measurement, signal)
    if shift is None:
        raise MeasurementError(
            f"{measurement.name}: the recording does not tell with this model by how "
            f"much {signal} is late; give "
            f"the shift as a number, such as --shift {signal}=0.004, or leave it out"
        )
    return shift
