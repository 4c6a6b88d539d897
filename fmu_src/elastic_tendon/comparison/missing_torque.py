"""The torque on the joint that is missing in a model, reconstructed from a recording.

Sought is the additional load u(t) under which the model moves as the joint was measured to move.
Where the model's joint errs by e = simulated - measured, the springs, the link's inertia and the
damping say which torque would have prevented it: u = -(J e'' + d e' + K e), where K e stands for
the difference between the springs' torques, (17) to (25), at both deflections. Simulated again
under this load the whole model, with all that it holds, shows what is still missing, and so on
until what is left is noise. The error is smoothed first (Whittaker 1923; Eilers, Anal. Chem. 75,
2003), up to the frequency at which it drowns in the noise.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from elastic_tendon.actuator.parameters import Model
from elastic_tendon.actuator.transmission import (
    characteristic_damping,
    characteristic_stiffness,
    characteristic_torque,
)
from elastic_tendon.comparison.averaging import (
    averaged_file,
    averaged_noise,
    block_sizes,
    stride_of,
)
from elastic_tendon.comparison.bins import noise_density
from elastic_tendon.comparison.comparison import FileComparison, slack_states_measured
from elastic_tendon.comparison.initial_state import estimate_initial_state
from elastic_tendon.comparison.partition import (
    Integers,
    Partition,
    blocks_of,
    memory_of,
    partitions,
)
from elastic_tendon.comparison.residuals import (
    Array,
    InitialState,
    deflection_of,
    residuals_of,
    rms,
    simulate_measurement,
)
from elastic_tendon.errors import SimulationError
from elastic_tendon.measurement import Measurement, NoiseFloor
from elastic_tendon.progress import Progress, silent
from elastic_tendon.simulation.simulate import Trajectory

ROUNDS = 5
# a longer recording is simulated once more, and once only
LONG_NOTE = (
    "as the recording is long, the missing torque was found in one round instead of up to "
    f"{ROUNDS}, and each {{stride}} neighbouring samples count as one where the error is located"
)
# of the error, and times the noise: where more is left, the model does not move as measured
LEFT, LEFT_NOISE = 0.5, 3.0
NOT_FOUND = (
    "no missing torque was found under which the model moves as measured: places and figures are "
    "those of a motion that is off by {left:.3g} mrad RMS"
)
# what a round must remove of the smoothed error to be worth another
WORTHWHILE = 0.05
# times the noise's spectrum: surely more than noise, and down to where that goes on
CLEAR, AUDIBLE = 4.0, 2.0
# of Welch's spectrum; the shorter the segment, the more of them are averaged
LONGEST_SEGMENT = 4096
SEGMENTS, MOST_SEGMENTS = 4, 64
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
    `found`: the model moves nearly as measured under it. Both are NaN where a position was not
    measured.
    """

    torque: Array
    sigma: Array
    curves: tuple[TorqueCurve, ...]
    notes: tuple[str, ...]
    found: bool

    @property
    def known(self) -> bool:
        """Whether the positions from which it is told were measured."""
        return not bool(np.isnan(self.torque).any())


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

        bands = np.empty((ORDER + 1, len(values)))
        edge = min(ORDER, (len(values) - 1) // 2)
        few = _penalty(min(len(values), 2 * ORDER + 1))
        bands[:] = few[:, edge : edge + 1]
        bands[:, :edge], bands[:, -edge:] = few[:, :edge], few[:, -edge:]
        bands *= self.weight
        bands[0] += 1.0
        return np.asarray(solveh_banded(bands, values, lower=True, check_finite=False))


def _penalty(n: int) -> Array:
    """Lower bands (4, n) of the matrix whose form is the sum of squared third differences."""
    bands = np.zeros((ORDER + 1, n))
    coefficients = (-1.0, 3.0, -3.0, 1.0)
    for first, left in enumerate(coefficients):
        for offset, right in enumerate(coefficients[first:]):
            bands[offset, first : first + n - ORDER] += left * right
    return bands


@dataclass(frozen=True)
class _Track:
    """The model under the load found so far, with its error (n,)."""

    torque: Array
    initial: InitialState
    trajectory: Trajectory
    error: Array


def missing_torque(
    model: Model, file: FileComparison, progress: Progress = silent
) -> tuple[MissingTorque, Mapping[str, Array], Mapping[str, Partition]]:
    """Reconstruct the missing torque of one recording; of a long one, that of `averaging` blocks.

    Parameters
    ----------
    model : Model
    file : FileComparison; its measurement holds ``joint_position``
    progress : told what is being done, and the share of it that is done

    Returns
    -------
    MissingTorque; what the joint did under it, variables by name, (n,) arrays as in
    `locate.FileLocation`; and the samples sorted by these. All hold one value for each block of
    `averaging.stride_of` samples, which is one sample unless the recording is long
    """
    whole, stride = file.measurement, stride_of(len(file.measurement.time))
    file = averaged_file(file, stride)
    measurement = file.measurement
    error = _error(file.trajectory, measurement)
    floor = whole.noise["joint_position"]
    noise = averaged_noise(floor, stride)
    grid = _even(measurement.time)
    smoother = smoother_for(_onto(grid, measurement.time, error), noise, grid[1] - grid[0])
    rounds = ROUNDS if stride == 1 else 1
    track, done, notes = _track(model, file, noise, smoother, grid, rounds, progress)
    left = rms(track.error)
    follows = left <= max(LEFT * rms(error), LEFT_NOISE * noise.sigma)
    if not follows:
        notes.append(NOT_FOUND.format(left=1e3 * left))
    if stride > 1:
        notes.append(LONG_NOTE.format(stride=stride))
    variables = _variables(model, measurement, track.trajectory)
    sigma = _torque_sigma(model, measurement, track.trajectory, smoother, noise, max(done, 1))
    # what a measured load's own noise adds to the position, and so to the torque that undoes it
    added = max(file.signals["joint_position"].noise.sigma ** 2 - floor.sigma**2, 0.0)
    sigma = np.hypot(sigma, _stiffness(model, track.trajectory) * np.sqrt(added))
    shaking = noise.sigma * _noise_gain(smoother, noise, lambda w: w, max(done, 1))
    sizes = None if stride == 1 else block_sizes(len(whole.time), stride)
    parts = partitions(variables, model, shaking, static=measurement.static, sizes=sizes)
    curves = _curves(track.torque, sigma, variables, parts)
    return MissingTorque(track.torque, sigma, curves, tuple(notes), follows), variables, parts


def without_torque(
    model: Model, file: FileComparison, reason: str
) -> tuple[MissingTorque, Mapping[str, Array], Mapping[str, Partition]]:
    """What `missing_torque` returns where the torque cannot be known, for a reason that is told;
    the motion is as simulated."""
    whole, stride = file.measurement, stride_of(len(file.measurement.time))
    file = averaged_file(file, stride)
    variables = _variables(model, file.measurement, file.trajectory)
    sizes = None if stride == 1 else block_sizes(len(whole.time), stride)
    parts = partitions(variables, model, 0.0, static=False, sizes=sizes)
    unknown = np.full(len(file.measurement.time), np.nan)
    note = f"{reason}, so the missing torque is not known"
    return MissingTorque(unknown, unknown, (), (note,), found=False), variables, parts


def _track(
    model: Model,
    file: FileComparison,
    noise: NoiseFloor,
    smoother: Smoother,
    grid: Array,
    rounds: int,
    progress: Progress,
) -> tuple[_Track, int, list[str]]:
    """Move the model by its smoothed error until noise is left; with the number of rounds."""
    measurement = file.measurement
    error = _error(file.trajectory, measurement)
    track = _Track(np.zeros(len(error)), file.initial_state, file.trajectory, error)
    floor = noise.sigma * _noise_gain(smoother, noise, np.ones_like)
    notes: list[str] = []
    before = np.inf
    for done in range(rounds):
        progress("missing torque", done / rounds)
        even = smoother.smooth(_onto(grid, measurement.time, track.error))
        left = _onto(measurement.time, grid, even)
        if done and (rms(left) < floor or rms(left) > (1.0 - WORTHWHILE) * before):
            return track, done, notes
        try:
            following = _next_track(model, measurement, track, left)
        except SimulationError as failure:
            outcome = f"the missing torque was found in {done} of up to {rounds} rounds"
            sentence = f"{outcome}, as the next failed: {failure}"
            return track, done, [*notes, sentence]
        if rms(following.error) >= rms(track.error):
            return track, done, notes
        track, before = following, rms(left)
    return track, rounds, notes


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
    power = _spectrum(error)
    angle = np.linspace(0.0, np.pi, len(power))
    frequency = angle / (2.0 * np.pi * step)
    floor = noise.sigma**2 * noise_density(angle, noise)
    edges = frequency[1] * BAND ** np.arange(
        1 + np.log(frequency[-1] / frequency[1]) / np.log(BAND)
    )
    band = np.digitize(frequency, edges)
    size = np.bincount(band)
    filled = np.flatnonzero(size)
    loud = (np.bincount(band, power) / np.maximum(np.bincount(band, floor), 1e-300))[filled]
    clear = np.flatnonzero(loud >= CLEAR)
    last = int(clear[-1]) if len(clear) else 0
    while last + 1 < len(loud) and loud[last + 1] >= AUDIBLE:
        last += 1
    last = int(filled[last])
    cutoff = float(edges[min(last, len(edges) - 1)])
    weight = (2.0 * np.sin(np.pi * min(cutoff * step, 0.5))) ** (-2 * ORDER)
    return Smoother(min(weight, HEAVIEST), step)


def _spectrum(values: Array) -> Array:
    """Power from frequency 0 to half the rate, of mean 1 for white noise of variance 1 (Welch)."""
    length = min(max(8, min(len(values) // SEGMENTS, LONGEST_SEGMENT)), len(values)) // 2 * 2
    count = min(2 * (len(values) // length), MOST_SEGMENTS)
    starts = np.linspace(0, len(values) - length, max(count, 1)).astype(int)
    window = np.hanning(length)
    segments = values[starts[:, None] + np.arange(length)] * window
    power = np.abs(np.fft.rfft(segments, axis=1)) ** 2
    return np.asarray(np.mean(power, axis=0) / np.sum(window**2))


def joint_velocity_measured(file: FileComparison) -> Array:
    """Velocity with which the joint was measured to move, (n,) rad/s.

    That of the simulation less the rate of the smoothed error: nothing is smoothed that the model
    explains.

    Parameters
    ----------
    file : FileComparison of a time series; its measurement holds ``joint_position``
    """
    time = file.measurement.time
    error = _error(file.trajectory, file.measurement)
    grid = _even(time)
    even = _onto(grid, time, error)
    noise = file.measurement.noise["joint_position"]
    smooth = smoother_for(even, noise, grid[1] - grid[0]).smooth(even)
    return file.trajectory["joint_velocity"] - np.gradient(_onto(time, grid, smooth), time)


def _even(time: Array) -> Array:
    """A grid of even steps with as many samples over the same time; the samples' own if even."""
    grid = np.linspace(time[0], time[-1], len(time))
    return time if np.max(np.abs(np.diff(time) / np.diff(grid) - 1.0)) < JITTER else grid


def _onto(to: Array, of: Array, values: Array) -> Array:
    return values if to is of else np.interp(to, of, values)


def _next_track(model: Model, measurement: Measurement, track: _Track, left: Array) -> _Track:
    """Move the model by its smoothed error (n,): change load and initial state, and simulate."""
    time, transmission = measurement.time, model.transmission
    deflection = deflection_of(track.trajectory)
    if measurement.static:
        elastic = characteristic_torque(deflection, transmission)
        change = characteristic_torque(deflection - left, transmission) - elastic
    else:
        rate = np.gradient(left, time, edge_order=2)
        speed = np.gradient(deflection, time)
        elastic = characteristic_torque(deflection, transmission, speed)
        change = characteristic_torque(deflection - left, transmission, speed - rate) - elastic
        change = change + model.link.damping * rate
        change = change + model.link.inertia * np.gradient(rate, time, edge_order=2)
    torque = track.torque - change
    load = torque if measurement.load_torque is None else measurement.load_torque + torque
    loaded = replace(measurement, load_torque=load)
    if measurement.static:
        initial = estimate_initial_state(model, loaded)
    else:
        initial = InitialState(
            track.initial.position - float(left[0]), track.initial.velocity - float(rate[0])
        )
    trajectory = simulate_measurement(model, loaded, initial)
    return _Track(torque, initial, trajectory, _error(trajectory, measurement))


def _error(trajectory: Trajectory, measurement: Measurement) -> Array:
    return residuals_of(trajectory, measurement)["joint_position"]


def _stiffness(model: Model, trajectory: Trajectory) -> Array:
    return characteristic_stiffness(deflection_of(trajectory), model.transmission)


def _damping(model: Model, trajectory: Trajectory) -> Array:
    springs = characteristic_damping(deflection_of(trajectory), model.transmission)
    return np.asarray(model.link.damping + springs)


def _variables(model: Model, measurement: Measurement, trajectory: Trajectory) -> dict[str, Array]:
    known = measurement.inputs | {name: trajectory[name] for name in trajectory.output_names}
    joint = known["joint_position"]
    velocity = known.get("joint_velocity", np.gradient(joint, measurement.time))
    load = measurement.load_torque
    nothing = np.zeros(len(velocity))
    return {
        "time": measurement.time,
        "slack_state": slack_states_measured(model, trajectory, measurement),
        "deflection": deflection_of(trajectory),
        "joint_velocity": velocity,
        "joint_acceleration": np.gradient(velocity, measurement.time),
        "joint_position": joint,
        "joint_torque": trajectory["joint_torque"] if model.kind.has_springs else nothing,
        "motor_position": known.get("motor_position", nothing),
        "load_torque": nothing if load is None else load,
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
    for k in set(stiffness.tolist()):
        where = stiffness == k
        d = 0.0 if measurement.static else float(damping[where][0])
        gain = _noise_gain(smoother, noise, lambda w: k - inertia * w**2 + 1j * d * w, rounds)  # noqa: B023
        sigma[where] = noise.sigma * gain
    return sigma


def _curves(
    torque: Array, sigma: Array, variables: Mapping[str, Array], parts: Mapping[str, Partition]
) -> tuple[TorqueCurve, ...]:
    from scipy.special import stdtrit

    blocks = blocks_of(memory_of(torque - np.mean(torque)), len(torque))
    curves = []
    for by, part in parts.items():
        if part.unit is None:
            continue
        centre = part.means(variables[by])
        sums = part.by_block(torque, blocks)
        mean, error, freedom = sums.mean_with_error()
        half = stdtrit(np.maximum(freedom, 1.0), 0.5 + 0.5 * CONFIDENCE) * error
        # few blocks tell little of their scatter, one nothing: then the samples of the bin are
        # taken as if they were one, which is not known better than they lie apart
        own = np.sqrt(part.means((torque - mean[part.member]) ** 2 + sigma**2))
        half = np.where(freedom < 1.0, 2.0 * own, np.minimum(half, 2.0 * own))
        low, high = mean - half, mean + half
        # no mean lies beyond its samples, up to what noise does to each
        least, most = low + np.inf, high - np.inf
        np.minimum.at(least, part.member, torque - 2.0 * sigma)
        np.maximum.at(most, part.member, torque + 2.0 * sigma)
        low, high = np.maximum(low, least), np.minimum(high, most)
        curves.append(TorqueCurve(by, part.unit, centre, mean, low, high, part.counts))
    return tuple(curves)
