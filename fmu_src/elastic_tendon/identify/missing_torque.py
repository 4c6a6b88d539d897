"""The torque on the joint that is missing in a model, reconstructed from a recording.

Sought is the additional load u(t) under which the model moves as the joint was measured to move.
Where the model's joint errs by e = simulated - measured, the springs, the link's inertia and the
damping say which torque would have prevented it: u = -(J e'' + d e' + K e), with K and d of the
slack state. Simulated again under this load the whole model, with all that it holds, shows what
is still missing, and so on until what is left is noise. The error is smoothed first (Whittaker
1923; Eilers, Anal. Chem. 75, 2003), up to the frequency at which it drowns in the noise.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from elastic_tendon.compiled import Trajectory
from elastic_tendon.errors import SimulationError
from elastic_tendon.identify.bins import noise_density
from elastic_tendon.identify.compare import FileComparison
from elastic_tendon.identify.partition import Integers, Partition, blocks_of, partitions
from elastic_tendon.identify.residuals import (
    Array,
    InitialState,
    autocorrelation_time,
    residuals_of,
    rms,
    simulate_measurement,
)
from elastic_tendon.measurement import Measurement, NoiseFloor
from elastic_tendon.parameters import Model
from elastic_tendon.transmission import characteristic_damping, characteristic_stiffness

Report = Callable[[str, float], object]

ITERATIONS = 5
# a longer recording is simulated once more, and once only
LONG = 200_000  # samples
# what an iteration must remove of the smoothed error to be worth another
WORTHWHILE = 0.05
# times the noise's spectrum; the error's spectrum drowns where it falls below
AUDIBLE = 2.0
# of Welch's spectrum; the shorter the segment, the more of them are averaged
LONGEST_SEGMENT = 4096
SEGMENTS = 4
BAND = 2.0 ** (1 / 3)  # ratio of the edges of the bands over which a spectrum is averaged
ORDER = 3  # of the differences that smoothing keeps small
HEAVIEST = 1e11  # weight of the penalty; heavier ones are lost in rounding
# share of the mean step by which an even sampling may be uneven
JITTER = 1e-3
CONFIDENCE = 0.95


@dataclass(frozen=True)
class TorqueCurve:
    """Mean of the missing torque over one variable, with the ends of its 95 % interval.

    `by` names the variable and `unit` is its unit; `centre` (k,), in it; `mean`, `low`, `high`
    (k,), N·m; `count` (k,) samples.
    """

    by: str
    unit: str
    centre: Array
    mean: Array
    low: Array
    high: Array
    count: Integers


@dataclass(frozen=True)
class MissingTorque:
    """Load under which the model moves as the joint was measured to move.

    `torque` (n,), N·m on the joint, positive with its position; `sigma` (n,), what the noise of
    the joint position does to it; `notes` say where it could not be found as well as usual.
    """

    torque: Array
    sigma: Array
    curves: tuple[TorqueCurve, ...]
    notes: tuple[str, ...]


@dataclass(frozen=True)
class Smoother:
    """Whittaker's smoother on an even grid: `weight` of the penalty, `step` of the grid in s."""

    weight: float
    step: float

    def gain(self, angular_frequency: Array) -> Array:
        """What is left of a sine, 0 to 1; (k,) from (k,) in rad/s."""
        difference = 2.0 * np.sin(0.5 * angular_frequency * self.step)
        return np.asarray(1.0 / (1.0 + self.weight * difference ** (2 * ORDER)))

    def smooth(self, values: Array) -> Array:
        """Smooth (n,) samples, n > 3, any unit."""
        from scipy.linalg import solveh_banded

        n = len(values)
        bands = np.zeros((ORDER + 1, n))
        coefficients = np.array([-1.0, 3.0, -3.0, 1.0])
        for first, one in enumerate(coefficients):
            for offset, other in enumerate(coefficients[first:]):
                bands[offset, first : first + n - ORDER] += self.weight * one * other
        bands[0] += 1.0
        return np.asarray(solveh_banded(bands, values, lower=True, check_finite=False))


@dataclass(frozen=True)
class _Track:
    """The model under the load found so far; `left` (n,) is its error smoothed."""

    torque: Array
    initial: InitialState
    trajectory: Trajectory
    left: Array


def missing_torque(
    model: Model, file: FileComparison, report: Report = lambda _text, _share: None
) -> tuple[MissingTorque, Mapping[str, Array]]:
    """Reconstruct the missing torque of one recording.

    Parameters
    ----------
    model : Model
    file : FileComparison; its measurement holds ``joint_position``
    report : told what is being done, and the share of it that is done

    Returns
    -------
    MissingTorque, and what the joint did under it: variables by name, (n,) arrays as in
    `locate.FileLocation`
    """
    measurement = file.measurement
    error = residuals_of(file.trajectory, measurement)["joint_position"]
    noise = file.signals["joint_position"].noise
    grid = _even(measurement.time)
    smoother = smoother_for(_onto(grid, measurement.time, error), noise, grid[1] - grid[0])
    left = _smoothed(smoother, grid, measurement.time, error)
    track = _Track(np.zeros(len(error)), file.initial_state, file.trajectory, left)
    floor = noise.sigma * _noise_gain(smoother, noise, lambda w: np.ones_like(w))
    limit = 1 if len(error) > LONG else ITERATIONS
    notes: list[str] = []
    done = 0
    while done < limit and rms(track.left) > (floor if done else 0.0):
        report("missing torque", done / limit)
        try:
            following = _next_track(model, measurement, track, smoother, grid)
        except SimulationError as failure:
            notes.append(f"the missing torque is that of {done} of {limit} rounds: {failure}")
            break
        gain = 1.0 - rms(following.left) / rms(track.left)
        if gain <= 0.0:
            break
        track, done = following, done + 1
        if gain < WORTHWHILE:
            break
    if len(error) > LONG:
        notes.append(
            f"the missing torque was found in one round instead of up to {ITERATIONS}, as the "
            f"recording has more than {LONG} samples"
        )
    variables = _variables(measurement, track.trajectory)
    sigma = _torque_sigma(model, measurement, track.trajectory, smoother, noise, max(done, 1))
    parts = partitions(variables, model, static=measurement.static)
    curves = _curves(track.torque, sigma, variables, parts)
    return MissingTorque(track.torque, sigma, curves, tuple(notes)), variables


def smoother_for(error: Array, noise: NoiseFloor, step: float) -> Smoother:
    """The smoother that lets pass what of an error is louder than the noise.

    Parameters
    ----------
    error : (n,) array on an even grid, unit of the noise
    noise : NoiseFloor
    step : float, s, of the grid

    Returns
    -------
    Smoother; it halves what has the frequency up to which the error is louder
    """
    from scipy.signal import welch

    length = max(8, min(len(error) // SEGMENTS, LONGEST_SEGMENT))
    frequency, density = welch(error, 1.0 / step, nperseg=min(length, len(error)), detrend=False)
    floor = 2.0 * step * noise.sigma**2 * noise_density(2.0 * np.pi * frequency * step, noise)
    edges = frequency[1] * BAND ** np.arange(
        1 + np.log(frequency[-1] / frequency[1]) / np.log(BAND)
    )
    band = np.digitize(frequency, edges)
    size = np.bincount(band)
    filled = np.flatnonzero(size)
    loud = (np.bincount(band, density) / np.maximum(np.bincount(band, floor), 1e-300))[filled]
    loudest = int(np.argmax(loud))
    quiet = np.flatnonzero(loud[loudest:] < AUDIBLE)
    last = filled[loudest + int(quiet[0]) - 1] if len(quiet) > 1 and quiet[0] > 0 else filled[-1]
    if len(quiet) and quiet[0] == 0:
        last = filled[min(loudest, 1)]
    cutoff = float(edges[min(last, len(edges) - 1)])
    weight = (2.0 * np.sin(np.pi * min(cutoff * step, 0.5))) ** (-2 * ORDER)
    return Smoother(min(weight, HEAVIEST), step)


def _even(time: Array) -> Array:
    """A grid of even steps with as many samples over the same time; the samples' own if even."""
    grid = np.linspace(time[0], time[-1], len(time))
    return time if np.max(np.abs(np.diff(time) / np.diff(grid) - 1.0)) < JITTER else grid


def _onto(to: Array, of: Array, values: Array) -> Array:
    return values if to is of else np.interp(to, of, values)


def _smoothed(smoother: Smoother, grid: Array, time: Array, error: Array) -> Array:
    return _onto(time, grid, smoother.smooth(_onto(grid, time, error)))


def _next_track(
    model: Model, measurement: Measurement, track: _Track, smoother: Smoother, grid: Array
) -> _Track:
    """Move the model by its smoothed error: change load and initial state, and simulate."""
    time = measurement.time
    rate = np.gradient(track.left, time, edge_order=2)
    change = _stiffness(model, track.trajectory) * track.left
    initial = track.initial
    if not measurement.static:
        change = change + _damping(model, track.trajectory) * rate
        change = change + model.link.inertia * np.gradient(rate, time, edge_order=2)
        initial = InitialState(
            initial.position - float(track.left[0]), initial.velocity - float(rate[0])
        )
    torque = track.torque - change
    load = torque if measurement.load_torque is None else measurement.load_torque + torque
    trajectory = simulate_measurement(model, replace(measurement, load_torque=load), initial)
    error = residuals_of(trajectory, measurement)["joint_position"]
    return _Track(torque, initial, trajectory, _smoothed(smoother, grid, time, error))


def _stiffness(model: Model, trajectory: Trajectory) -> Array:
    return characteristic_stiffness(trajectory["deflection"], model.transmission)


def _damping(model: Model, trajectory: Trajectory) -> Array:
    springs = characteristic_damping(trajectory["deflection"], model.transmission)
    return np.asarray(model.link.damping + springs)


def _variables(measurement: Measurement, trajectory: Trajectory) -> dict[str, Array]:
    velocity = trajectory["joint_velocity"]
    load = measurement.load_torque
    return {
        "time": measurement.time,
        "slack_state": np.rint(trajectory["slack_state"]),
        "deflection": trajectory["deflection"],
        "joint_velocity": velocity,
        "joint_acceleration": np.gradient(velocity, measurement.time),
        "motor_position": measurement.motor_position,
        "load_torque": np.zeros(len(velocity)) if load is None else load,
    }


def _noise_gain(
    smoother: Smoother, noise: NoiseFloor, response: Callable[[Array], Array], rounds: int = 1
) -> float:
    """Standard deviation of smoothed and filtered noise over that of the noise."""
    angle = np.linspace(0.0, np.pi, LONGEST_SEGMENT)
    frequency = angle / smoother.step
    gain = (1.0 - (1.0 - smoother.gain(frequency)) ** rounds) * np.abs(response(frequency))
    return float(np.sqrt(np.mean(noise_density(angle, noise) * gain**2)))


def _torque_sigma(
    model: Model,
    measurement: Measurement,
    trajectory: Trajectory,
    smoother: Smoother,
    noise: NoiseFloor,
    rounds: int,
) -> Array:
    stiffness, damping = _stiffness(model, trajectory), _damping(model, trajectory)
    sigma = np.empty(len(stiffness))
    inertia = 0.0 if measurement.static else model.link.inertia
    for k in np.unique(stiffness):
        where = stiffness == k
        d = 0.0 if measurement.static else float(damping[where][0])
        gain = _noise_gain(smoother, noise, lambda w: k - inertia * w**2 + 1j * d * w, rounds)  # noqa: B023
        sigma[where] = noise.sigma * gain
    return sigma


def _curves(
    torque: Array, sigma: Array, variables: Mapping[str, Array], parts: Mapping[str, Partition]
) -> tuple[TorqueCurve, ...]:
    from scipy.stats import t

    blocks = blocks_of(autocorrelation_time(torque - np.mean(torque)), len(torque))
    curves = []
    for by, part in parts.items():
        if part.unit is None:
            continue
        centre = part.means(variables[by])
        sums = part.by_block(torque, blocks)
        mean, error, freedom = sums.mean_with_error()
        half = t.ppf(0.5 + 0.5 * CONFIDENCE, np.maximum(freedom, 1.0)) * error
        # a bin that lies within one block has no scatter to judge by: the whole torque's counts
        half = np.where(freedom < 1.0, 2.0 * max(rms(torque), float(np.max(sigma))), half)
        low, high = mean - half, mean + half
        curves.append(TorqueCurve(by, part.unit, centre, mean, low, high, part.counts))
    return tuple(curves)
