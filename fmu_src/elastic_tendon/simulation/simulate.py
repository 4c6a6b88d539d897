"""Simulate in one call of the compiled library: numpy arrays in, numpy arrays out."""

import ctypes
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from elastic_tendon.actuator.motion_kind import MotionKind
from elastic_tendon.actuator.parameters import Model
from elastic_tendon.actuator.quantity import unit_text
from elastic_tendon.actuator.variables import (
    LOAD_TORQUE,
    POSITION_OF,
    SIGNALS,
    interface,
    reading_of,
)
from elastic_tendon.errors import SimulationError
from elastic_tendon.native import interrupt
from elastic_tendon.native.interpolation import INTERPOLATIONS, Interpolation
from elastic_tendon.native.library import DEFAULT_TOLERANCE, Runs, Simulation, load
from elastic_tendon.native.shared import OUTCOMES, STATISTICS, TOLERANCES
from elastic_tendon.result import Result, plain

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

MAIN_OUTPUTS = ("joint_position", "joint_torque")  # of which sensitivities are tabled and drawn
_UNITS = {name: unit_text(signal.unit) for name, signal in SIGNALS.items()}
EVENT_CAPACITY = 4096
# after which the simulation of a recording is given up: what swings so fast is not in its samples
_FEWEST_STEPS, _STEPS_PER_SAMPLE = 200_000, 100
_KEPT_SAMPLES = 100_000  # of a recording whose spline is kept; a longer one is made in parts
_FORGOTTEN = 64  # samples after which a spline shows nothing of where it begins


@dataclass(frozen=True, repr=False)
class Trajectory(Result):
    """Simulated states and outputs at the sample times.

    `time` (n,), s; `states` (n, n_states) and `outputs` (n, n_outputs) in the order of
    `state_names` and `output_names`, units as in `variables`. `event_times` (k,), s: when a
    tendon went slack or taut, or another mode changed, between samples; the first 4096.
    `statistics` counts steps, right-hand sides (`rates`), events... `motion` : whether the machine
    turns or slides.
    """

    time: Array
    states: Array
    outputs: Array
    state_names: tuple[str, ...]
    output_names: tuple[str, ...]
    event_times: Array
    statistics: Mapping[str, int]
    motion: MotionKind = MotionKind.ROTARY

    def measured(self, signal: str) -> str:
        """Name of the output that shows what the sensor of a signal reads."""
        return reading_of(signal, self.output_names)

    def __getitem__(self, name: str) -> Array:
        """Column (n,) of an output or state by name."""
        if name in self.output_names:
            return self.outputs[:, self.output_names.index(name)]
        if name in self.state_names:
            return self.states[:, self.state_names.index(name)]
        raise KeyError(f"no output or state {name!r}; there are {', '.join(self.keys())}")

    def __len__(self) -> int:
        return len(self.time)

    def __iter__(self) -> Iterator[Any]:
        """Samples as named tuples, so that ``pandas.DataFrame(trajectory)`` is its table."""
        return iter(self.to_dataframe().reset_index().itertuples(index=False, name="Sample"))

    def keys(self) -> tuple[str, ...]:
        """Names of outputs and states, each once."""
        return tuple(dict.fromkeys(self.output_names + self.state_names))

    def summary(self) -> str:
        """Length, and the range of each output."""
        lines = [f"Trajectory of {self.time[-1] - self.time[0]:.4g} s, {len(self.time)} samples"]
        for name, column in zip(self.output_names, self.outputs.T, strict=True):
            lines.append(self.motion.words(_range(name, column)))
        return "\n".join(lines)

    def to_dataframe(self) -> "pd.DataFrame":
        """Outputs and states, a column each, SI; the index is the time, s."""
        import pandas as pd

        index = pd.Index(self.time, name="time")
        return pd.DataFrame({name: self[name] for name in self.keys()}, index=index)

    def to_dict(self) -> dict[str, Any]:
        """Time, outputs and states, a list each, SI."""
        return {"time": self.time.tolist()} | {name: self[name].tolist() for name in self.keys()}

    def plot(self) -> "Figure":
        """Draw joint position, joint torque and slack state over time."""
        from elastic_tendon.reports.trajectory_figure import trajectory_figure
        from elastic_tendon.reports.worded import worded_figure

        return worded_figure(trajectory_figure(self), self.motion)


@dataclass(frozen=True, repr=False)
class Sensitivities(Result):
    """A trajectory with the derivatives of its outputs.

    `output_derivatives` (n, n_outputs, m): by each of `names` (parameters, then initial states),
    in unit of the output per unit of the parameter or state, which `units` holds.
    """

    trajectory: Trajectory
    output_derivatives: Array
    names: tuple[str, ...]
    units: tuple[str, ...]

    @property
    def main_outputs(self) -> tuple[str, ...]:
        """Outputs that are tabled and drawn: joint position and joint torque, if there are any."""
        return tuple(name for name in MAIN_OUTPUTS if name in self.trajectory.output_names)

    def of(self, output: str) -> Array:
        """Derivatives (n, m) of one output."""
        return self.output_derivatives[:, self.trajectory.output_names.index(output), :]

    def summary(self) -> str:
        """Length, and the largest derivatives of joint position and joint torque."""
        time, motion = self.trajectory.time, self.trajectory.motion
        lines = [f"Sensitivities over {time[-1] - time[0]:.4g} s, {len(time)} samples; at most"]
        sizes = (np.abs(self.of(output)).max(axis=0) for output in self.main_outputs)
        of_outputs = [motion.words(_UNITS[output]) for output in self.main_outputs]
        for name, unit, *values in zip(self.names, self.units, *sizes, strict=True):
            pairs = zip(values, of_outputs, strict=True)
            most = " and ".join(f"{value:.4g} {own}" for value, own in pairs)
            lines.append(f"  by {name}: {most} per {motion.words(unit_text(unit))}")
        return "\n".join(lines)

    def to_dataframe(self) -> "pd.DataFrame":
        """Derivatives, SI, in columns (output, name); the index is the time, s."""
        import pandas as pd

        outputs = self.trajectory.output_names
        columns = pd.MultiIndex.from_product([outputs, self.names], names=["output", "by"])
        rows = self.output_derivatives.reshape(len(self.trajectory.time), -1)
        return pd.DataFrame(rows, pd.Index(self.trajectory.time, name="time"), columns)

    def to_dict(self) -> dict[str, Any]:
        """The trajectory, and the derivatives of each output by each name, a list each, SI."""
        derivatives = {
            output: dict(zip(self.names, self.of(output).T, strict=True))
            for output in self.trajectory.output_names
        }
        return {
            "trajectory": self.trajectory.to_dict(),
            "units": dict(zip(self.names, self.units, strict=True)),
            "derivatives": plain(derivatives),
        }

    def plot(self) -> "Figure":
        """Draw the derivatives of joint position and joint torque over time."""
        from elastic_tendon.reports.trajectory_figure import sensitivities_figure
        from elastic_tendon.reports.worded import worded_figure

        return worded_figure(sensitivities_figure(self), self.trajectory.motion)


@dataclass(frozen=True, repr=False)
class Many(Result):
    """Chosen outputs of k runs of one motion, each with its own parameters.

    `time` (n,), s; `outputs` (k, n_outputs, n) in the order of `output_names`, NaN of a run that
    failed; `failures` : k reasons, "" where the run went well. `motion` : whether the machine turns
    or slides.
    """

    time: Array
    outputs: Array
    output_names: tuple[str, ...]
    failures: tuple[str, ...]
    motion: MotionKind = MotionKind.ROTARY

    def summary(self) -> str:
        """How many runs, how many of them failed, and the range of each output over all."""
        failed = [reason for reason in self.failures if reason]
        lines = [f"{len(self.failures)} runs of {len(self.time)} samples, {len(failed)} failed"]
        lines += [f"  the first: {reason}" for reason in failed[:1]]
        if len(failed) < len(self.failures):
            for index, name in enumerate(self.output_names):
                lines.append(self.motion.words(_range(name, self.outputs[:, index])))
        return "\n".join(lines)

    def to_dataframe(self) -> "pd.DataFrame":
        """Outputs, a column each, SI; the index is the run, from 0, and the time, s."""
        import pandas as pd

        index = pd.MultiIndex.from_product(
            [range(len(self.failures)), self.time], names=["run", "time"]
        )
        columns = {name: self.outputs[:, i].ravel() for i, name in enumerate(self.output_names)}
        return pd.DataFrame(columns, index=index)

    def to_dict(self) -> dict[str, Any]:
        """Time, reasons of failures, and of each output a list for each run, SI."""
        outputs = {name: self.outputs[:, i] for i, name in enumerate(self.output_names)}
        content = {"time": self.time, "failures": self.failures, "outputs": outputs}
        data: dict[str, Any] = plain(content)
        return data

    def plot(self) -> "Figure":
        """Draw each output over time, a line for each run, at most 100."""
        from elastic_tendon.reports.trajectory_figure import runs_figure
        from elastic_tendon.reports.worded import worded_figure

        return worded_figure(runs_figure(self.to_dataframe()), self.motion)


def _range(name: str, values: Array) -> str:
    """A line of a summary: the smallest and the largest value of an output, NaN apart."""
    unit = f" {_UNITS[name]}" if _UNITS.get(name, "1") != "1" else ""
    return f"  {name:24} {np.nanmin(values):11.4g} to {np.nanmax(values):11.4g}{unit}"


def _samples(name: str, values: ArrayLike | None, n: int) -> Array:
    if values is None:
        return np.zeros(n)
    array = np.ascontiguousarray(values, dtype=np.float64)
    if array.shape != (n,):
        raise ValueError(f"{name} has shape {array.shape}, but time has {n} samples")
    if not np.isfinite(array).all():
        raise ValueError(f"{name} is not finite at sample {int(np.argmin(np.isfinite(array)))}")
    return array


def _time(values: ArrayLike) -> Array:
    time = np.ascontiguousarray(values, dtype=np.float64)
    if time.ndim != 1 or time.size < 2:
        raise ValueError(f"time needs at least two samples in one row, its shape is {time.shape}")
    steps = time[1:] - time[:-1]
    if not (steps > 0).all():
        raise ValueError(f"time does not increase after sample {int(np.argmin(steps > 0))}")
    return time


def spline_slopes(time: Array, samples: Array) -> Array:
    """Derivatives at the samples of the twice continuously differentiable cubic spline.

    Fits simulate one recording again and again, so those of a few are kept.
    """
    if not samples.any():
        return samples
    if len(time) <= _KEPT_SAMPLES:
        return _kept_slopes(time.tobytes(), samples.tobytes())
    slopes = np.empty_like(samples)
    for start in range(0, len(time), _KEPT_SAMPLES):  # so that all it takes stays in the cache
        end, before = start + _KEPT_SAMPLES, max(start - _FORGOTTEN, 0)
        around = slice(before, end + _FORGOTTEN)
        part = _spline_slopes(time[around], samples[around])
        slopes[start:end] = part[start - before : end - before]
    return slopes


@lru_cache(maxsize=256)  # windows of a recording are many
def _kept_slopes(time: bytes, samples: bytes) -> Array:
    return _spline_slopes(np.frombuffer(time), np.frombuffer(samples))


def _spline_slopes(at: Array, values: Array) -> Array:
    from scipy.interpolate import CubicSpline

    spline = CubicSpline(at, values)
    return np.append(spline.c[-2], spline(at[-1], 1))


def _address(array: Array | NDArray[np.int32] | None) -> int | None:
    return None if array is None else array.ctypes.data


def initial_state_of(model: Model, given: Mapping[str, float] | None = None) -> Array:
    """Initial states in the library's order, NaN where calculated; ValueError for a wrong name."""
    states = interface(*model.structure).states
    unknown = set(given or {}) - {state.name for state in states}
    if unknown:
        raise ValueError(
            f"no state {', '.join(sorted(unknown))}; there are "
            + ", ".join(state.name for state in states)
        )
    for name, value in (given or {}).items():
        if not np.isfinite(value):
            raise ValueError(f"the initial {name} is not finite")
    start = [(given or {}).get(state.name, state.start) for state in states]
    return np.array([np.nan if value is None else value for value in start])  # NaN: calculated


def given_names(model: Model) -> tuple[str, ...]:
    """Names of the inputs that `simulate` takes, in the library's order; it derives the rates."""
    names = interface(*model.structure).input_names
    return tuple(name for name in names if name not in POSITION_OF)


def driving_torque(model: Model, time: Array, motor_position: Array, moved: Trajectory) -> Array:
    """Torque under which the rotor moves as wanted, if it has no effects of its own.

    Parameters
    ----------
    model : Model with [motor]
    time, motor_position : (n,) arrays, s and rad
    moved : what the actuator does when the motor moves so

    Returns
    -------
    (n,) array, N·m; zero where there is no [motor]
    """
    if model.motor is None:
        return np.zeros(len(time))
    velocity = np.gradient(motor_position, time)
    accelerating = model.motor.inertia * np.gradient(velocity, time)
    return np.asarray(moved["motor_torque"] + accelerating + model.motor.damping * velocity)


def _by_name(
    motor_position: ArrayLike | None,
    load_torque: ArrayLike | None,
    motor_torque: ArrayLike | None,
    joint_position: ArrayLike | None,
) -> dict[str, ArrayLike | None]:
    return {
        "motor_position": motor_position,
        "load_torque": load_torque,
        "motor_torque": motor_torque,
        "joint_position": joint_position,
    }


def _given_inputs(model: Model, inputs: Mapping[str, ArrayLike | None], n: int) -> Array:
    """What drives the model, (k, n) in the library's order; raises ValueError."""
    names = given_names(model)
    for name, values in inputs.items():
        if values is not None and name not in names:
            raise ValueError(
                f"{name} is given, but {model.name} has interface {model.kind}, where it is "
                f"calculated or not used; its inputs are {', '.join(names)}"
            )
    for name in names:
        if inputs.get(name) is None and name != LOAD_TORQUE.name:
            raise ValueError(
                f"{model.name} has interface {model.kind}, so beside the time {name} is needed"
            )
    return np.array([_samples(name, inputs.get(name), n) for name in names])


@dataclass(frozen=True)
class _Motion:
    """What drives a simulation, as the library takes it; the arrays stay alive with it."""

    time: Array
    inputs: Array  # (k, n), those that are given, in the library's order
    slopes: Array | None
    interpolation: int
    start: Array
    tolerance: float

    @classmethod
    def of(
        cls,
        model: Model,
        time: ArrayLike,
        inputs: Mapping[str, ArrayLike | None],
        initial_state: Mapping[str, float] | None,
        interpolation: Interpolation,
        tolerance: float,
    ) -> "_Motion":
        """Checked arguments of `simulate`; raises ValueError."""
        time = _time(time)
        given = _given_inputs(model, inputs, time.size)
        if interpolation not in INTERPOLATIONS:
            raise ValueError(
                f"interpolation {interpolation!r} is none of {', '.join(INTERPOLATIONS)}"
            )
        if not TOLERANCES[0] <= tolerance <= TOLERANCES[1]:
            raise ValueError("tolerance {} is outside {:g} to {:g}".format(tolerance, *TOLERANCES))
        cubic = interpolation == "cubic"
        return cls(
            time=time,
            inputs=given,
            slopes=np.array([spline_slopes(time, samples) for samples in given]) if cubic else None,
            interpolation=INTERPOLATIONS.index(interpolation),
            start=initial_state_of(model, initial_state),
            tolerance=tolerance,
        )

    def call(self, states: Array, outputs: Array) -> ctypes.Structure:
        """A call of the library that fills `states` and `outputs`; its parameters are not set."""
        return Simulation(
            n_samples=self.time.size,
            time=_address(self.time),
            input=_address(self.inputs),
            input_slope=_address(self.slopes),
            interpolation=self.interpolation,
            initial_state=_address(self.start),
            tolerance=self.tolerance,
            states=_address(states),
            outputs=_address(outputs),
        )


def library_parameters(model: Model, as_measured: bool = False) -> Array:
    """Parameters of the library: the model's parameters, and the settings of a call."""
    settings = [float(as_measured)] if interface(*model.structure).reads_signals else []
    return np.array([*model.values().values(), *settings])


def reason(outcome: int, time: float) -> str:
    """Why a simulation stopped, as its `Outcome` says."""
    return f"stopped at {time:.6g} s: {tuple(OUTCOMES.values())[outcome]}"


def _run(
    model: Model, motion: _Motion, directions: Sequence[int], as_measured: bool
) -> tuple[Trajectory, Array]:
    variables = interface(*model.structure)
    n, m = motion.time.size, len(directions)
    parameters = library_parameters(model, as_measured)
    direction = np.array(directions, dtype=np.int32)
    states = np.empty((n, len(variables.states)))
    outputs = np.empty((n, len(variables.outputs)))
    derivatives = np.empty((n, len(variables.outputs), m))
    event_time = np.empty(EVENT_CAPACITY)
    call = motion.call(states, outputs)
    call.parameters = _address(parameters)
    call.most_steps = _FEWEST_STEPS + _STEPS_PER_SAMPLE * n if as_measured else 0
    call.n_directions = m
    call.direction = _address(direction)
    call.output_derivatives = _address(derivatives)
    call.event_time = _address(event_time)
    call.event_capacity = EVENT_CAPACITY
    library = load(*model.structure)
    outcome = interrupt.call(library.elastic_tendon_simulate, call)
    if outcome != 0:
        raise SimulationError(f"{model.name}: {reason(outcome, call.failure_time)}")
    statistics = {name: int(getattr(call.statistics, name)) for name in STATISTICS}
    names = (variables.state_names, variables.output_names)
    event_times = event_time[: statistics["events"]].copy()
    trajectory = Trajectory(
        motion.time, states, outputs, *names, event_times, statistics, model.motion
    )
    return trajectory, derivatives


def simulate(
    model: Model,
    time: ArrayLike,
    motor_position: ArrayLike | None = None,
    load_torque: ArrayLike | None = None,
    *,
    motor_torque: ArrayLike | None = None,
    joint_position: ArrayLike | None = None,
    initial_state: Mapping[str, float] | None = None,
    interpolation: Interpolation = "linear",
    tolerance: float = DEFAULT_TOLERANCE,
    as_measured: bool = False,
) -> Trajectory:
    """Simulate a motion that is given; `elastic_tendon.simulate` tells the arguments and errors."""
    inputs = _by_name(motor_position, load_torque, motor_torque, joint_position)
    motion = _Motion.of(model, time, inputs, initial_state, interpolation, tolerance)
    trajectory, _ = _run(model, motion, (), as_measured)
    return trajectory


def sensitivities(
    model: Model,
    time: ArrayLike,
    motor_position: ArrayLike | None = None,
    load_torque: ArrayLike | None = None,
    *,
    motor_torque: ArrayLike | None = None,
    joint_position: ArrayLike | None = None,
    parameters: Sequence[str],
    initial_states: Sequence[str] = (),
    initial_state: Mapping[str, float] | None = None,
    interpolation: Interpolation = "linear",
    tolerance: float = DEFAULT_TOLERANCE,
    as_measured: bool = False,
) -> Sensitivities:
    """Simulate, with exact derivatives of the outputs, correct across events.

    Parameters
    ----------
    parameters : dotted paths of the parameters to derive by
    initial_states : names of the states by whose initial values to derive
    model, time, motor_position, load_torque, motor_torque, joint_position, initial_state,
    interpolation, tolerance, as_measured : as in `simulate`

    Returns
    -------
    Sensitivities

    Raises
    ------
    SimulationError, ValueError
        as `simulate`; ValueError also for a name that the model does not have or that stands twice
    """
    variables = interface(*model.structure)
    offset = len(variables.states) + len(variables.inputs)
    index = {path: offset + i for i, path in enumerate(variables.parameter_names)}
    states = {name: i for i, name in enumerate(variables.state_names)}
    unknown = [p for p in parameters if p not in index] + [
        s for s in initial_states if s not in states
    ]
    if unknown:
        raise ValueError(f"the model has no {', '.join(unknown)}")
    names = (*parameters, *initial_states)
    if len(set(names)) < len(names):
        raise ValueError(f"a name stands twice among {', '.join(names)}")
    directions = [index[p] for p in parameters] + [states[s] for s in initial_states]
    inputs = _by_name(motor_position, load_torque, motor_torque, joint_position)
    motion = _Motion.of(model, time, inputs, initial_state, interpolation, tolerance)
    trajectory, derivatives = _run(model, motion, directions, as_measured)
    known = (*variables.parameters, *variables.states)
    units = {variable.name: variable.unit for variable in known}
    return Sensitivities(trajectory, derivatives, names, tuple(units[name] for name in names))


def simulate_many(
    model: Model,
    parameters: Mapping[str, ArrayLike],
    time: ArrayLike,
    motor_position: ArrayLike | None = None,
    load_torque: ArrayLike | None = None,
    *,
    motor_torque: ArrayLike | None = None,
    joint_position: ArrayLike | None = None,
    outputs: Sequence[str],
    initial_state: Mapping[str, float] | None = None,
    interpolation: Interpolation = "linear",
    tolerance: float = DEFAULT_TOLERANCE,
    as_measured: bool = False,
) -> Many:
    """Simulate one motion with many sets of parameters, in one call of the library.

    Other threads of Python go on meanwhile. Values are not checked against the bounds of
    model.toml: what the solver cannot integrate fails, alone.

    Parameters
    ----------
    parameters : dotted path -> (k,) values of each that varies, SI; the others are the model's
    outputs : names of the outputs to keep; 8 n k bytes each
    model, time, motor_position, load_torque, motor_torque, joint_position, initial_state,
    interpolation, tolerance, as_measured : as in `simulate`

    Returns
    -------
    Many

    Raises
    ------
    ValueError
        as `simulate`; also for a path or output that the model does not have, and for arrays of
        different lengths
    """
    variables = interface(*model.structure)
    inputs = _by_name(motor_position, load_torque, motor_torque, joint_position)
    motion = _Motion.of(model, time, inputs, initial_state, interpolation, tolerance)
    sets = _parameter_sets(model, parameters, as_measured)
    unknown = [name for name in outputs if name not in variables.output_names]
    if unknown:
        raise ValueError(f"the model has no output {', '.join(unknown)}")
    k, n = len(sets), motion.time.size
    kept = np.array([variables.output_names.index(name) for name in outputs], dtype=np.int32)
    values = np.empty((k, len(kept), n))
    outcome = np.empty(k, dtype=np.int32)
    stopped = np.empty(k)
    states = np.empty((n, len(variables.states)))
    every = np.empty((n, len(variables.outputs)))
    runs = Runs(
        n_runs=k,
        parameters=_address(sets),
        n_kept=len(kept),
        kept=_address(kept),
        outputs=_address(values),
        outcome=_address(outcome),
        failure_time=_address(stopped),
    )
    library = load(*model.structure)
    call = motion.call(states, every)
    if interrupt.call(library.elastic_tendon_simulate_many, call, runs) != 0:
        raise SimulationError(f"{model.name}: memory is short")
    failures = [""] * k
    for i in np.flatnonzero(outcome):
        failures[i] = reason(outcome[i], stopped[i])
    return Many(motion.time, values, tuple(outputs), tuple(failures), model.motion)


def _parameter_sets(model: Model, varied: Mapping[str, ArrayLike], as_measured: bool) -> Array:
    """All parameters of each run, (k, n_parameters)."""
    paths = interface(*model.structure).parameter_names
    columns = {path: np.asarray(values, dtype=np.float64) for path, values in varied.items()}
    unknown = [path for path in columns if path not in paths]
    if unknown:
        raise ValueError(f"the model has no {', '.join(unknown)}")
    shapes = {column.shape for column in columns.values()}
    if len(shapes) != 1 or len(next(iter(shapes))) != 1:
        raise ValueError(
            "one row of values of each parameter is needed, all of one length, not of shapes "
            + ", ".join(map(str, sorted(shapes)))
        )
    sets = np.tile(library_parameters(model, as_measured), (next(iter(shapes))[0], 1))
    for path, column in columns.items():
        sets[:, paths.index(path)] = column
    return sets
