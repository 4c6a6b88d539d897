"""Simulations of one motion with many sets of numbers: statistics or trajectories of outputs."""

import hashlib
import math
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal, get_args

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from elastic_tendon.actuator import problems
from elastic_tendon.actuator.parameters import Model
from elastic_tendon.actuator.transmission import SlackState
from elastic_tendon.actuator.variables import LOAD_TORQUE, Kind, Variable, interface
from elastic_tendon.comparison.simulated import SUFFIXES, default_inputs, starting_state
from elastic_tendon.errors import SweepError
from elastic_tendon.measurement import Measurement
from elastic_tendon.native.interpolation import Interpolation
from elastic_tendon.native.library import DEFAULT_TOLERANCE
from elastic_tendon.native.shared import TOLERANCES
from elastic_tendon.simulation.simulate import given_names, simulate_many
from elastic_tendon.sweeps.factors import Array
from elastic_tendon.sweeps.points import Points
from elastic_tendon.sweeps.shipped import ShippedModel, ship
from elastic_tendon.sweeps.task import FAILURE, RUN

Kept = Literal["statistics", "trajectories"]

OUTPUTS = ("joint_position", "joint_torque", "slack_state")  # where none are chosen
TIME = "time_s"
MEMORY = 32_000_000  # bytes of outputs of one call; between calls threads wait for Python's lock
PART = 5_000_000  # bytes of one batch of trajectories as text; some tens of them may wait
CELL = 20  # bytes of a number as text
WORK = 0.5  # s of one batch
TRIAL = 0.05  # s that are long enough to tell how fast runs are
MOST_RUNS = 10_000  # in a batch


@dataclass(frozen=True, eq=False, repr=False)
class Motion:
    """What moves every machine of a sweep.

    `time` (n,) s, and of what drives the model at its interface (n,) each: `motor_position` (rad at
    the motor pulley) or `motor_torque` (N·m), `load_torque` (N·m on the joint, None: none acts) or
    `joint_position` (rad). `initial_state` : of all runs, by the states' names, start values where
    missing; `signals` : what was measured, output -> (n,) array in its SI unit.
    """

    time: Array
    motor_position: Array | None = None
    load_torque: Array | None = None
    interpolation: Interpolation = "linear"
    initial_state: Mapping[str, float] = field(default_factory=dict)
    signals: Mapping[str, Array] = field(default_factory=dict)
    motor_torque: Array | None = None
    joint_position: Array | None = None

    def __repr__(self) -> str:
        load = "no load" if self.load_torque is None else "a load"
        return f"Motion of {np.ptp(self.time):.4g} s, {len(self.time)} samples, with {load}"

    @property
    def inputs(self) -> dict[str, Array]:
        """What drives the model, by name."""
        names = ("motor_position", "load_torque", "motor_torque", "joint_position")
        given = {name: getattr(self, name) for name in names}
        return {name: values for name, values in given.items() if values is not None}

    @property
    def fingerprint(self) -> str:
        """Hash of all of it."""
        digest = hashlib.sha256(f"{self.interpolation} {dict(self.initial_state)!r}".encode())
        measured = {f"measured {name}": values for name, values in self.signals.items()}
        for name, values in ({"time": self.time} | self.inputs | measured).items():
            digest.update(name.encode() + np.ascontiguousarray(values, dtype="<f8").tobytes())
        return digest.hexdigest()


def default_motion(model: Model) -> Motion:
    """Ten seconds of motion and load that suit the model, from rest; see `default_inputs`."""
    time, inputs = default_inputs(model)
    return Motion(time, **inputs)


def measured_motion(model: Model, measurement: Measurement) -> Motion:
    """What drives the model in a recording, from the state where it begins.

    That state is estimated once, with the numbers of `model`, and is that of all runs.

    Raises
    ------
    MeasurementError : what drives the model was not measured
    SimulationError : the solver could not go on
    """
    measurement = measurement.for_model(model)
    return Motion(
        measurement.time,
        interpolation=measurement.input_interpolation,
        initial_state=starting_state(model, measurement).as_dict(model.kind),
        signals=measurement.signals,
        **measurement.inputs,
    )


@dataclass(frozen=True, eq=False, repr=False)
class Simulations:
    """Simulations as a task, see `elastic_tendon.sweeps.task`.

    A row of statistics holds the run, what varied (by dotted path, unit as in model.toml), and of
    each output: minimum, maximum, mean, rms and final value (SI, as the suffix says), with
    ``rms_error`` where it was measured; of the slack state the share of samples in each; of
    `overstretched` the share of samples. Trajectories have a row for each sample, and one row for
    a run that failed.
    """

    shipped: ShippedModel
    points: Points
    motion: Motion
    outputs: tuple[str, ...]
    keep: Kept
    tolerance: float

    def __repr__(self) -> str:
        return f"Simulations of {self.shipped.model.name}: {self.points!r}; {self.motion!r}"

    @property
    def runs(self) -> int:
        """How many there are."""
        return self.points.count

    @property
    def threads(self) -> bool:
        """True: the library does a batch in one call, while other threads go on."""
        return True

    @property
    def identity(self) -> dict[str, str]:
        """All that the results depend on."""
        own = (
            f"{name} {hashlib.sha256(content).hexdigest()}"
            for name, content in self.shipped.own_effects
        )
        return self.points.identity | {
            "kind": "simulations",
            "model": self.shipped.text,
            "own effects": "; ".join(own),
            "motion": self.motion.fingerprint,
            "outputs": ", ".join(self.outputs),
            "kept": self.keep,
            "tolerance": repr(self.tolerance),
        }

    def batch(self) -> int:
        """Number of runs that take about half a second here; few where trajectories are kept."""
        most = min(MOST_RUNS, self.runs)
        if self.keep == "trajectories":
            columns = 3 + len(self.points.factors) + len(self.outputs)
            most = min(most, max(1, PART // (CELL * columns * len(self.motion.time))))
        self.rows(0, 1)  # compiles and loads the library, where that was not done
        count = 1
        while (taken := self._seconds(count)) < TRIAL and count < most:
            count = min(4 * count, most)
        return max(1, min(most, math.floor(WORK / taken * count)))

    def _seconds(self, count: int) -> float:
        begin = time.perf_counter()
        self.rows(0, count)
        return time.perf_counter() - begin

    def rows(self, start: int, stop: int) -> pd.DataFrame:
        """Results of the runs `start` to `stop` - 1, in order."""
        each = 8 * len(self._simulated) * len(self.motion.time)
        step = max(1, MEMORY // each)
        parts = [self._rows(first, min(first + step, stop)) for first in range(start, stop, step)]
        return parts[0] if len(parts) == 1 else pd.concat(parts, ignore_index=True)

    def failed(self, run: int, reason: str) -> pd.DataFrame:
        """What `rows` gives for one run that failed."""
        none = np.full((1, len(self._simulated), len(self.motion.time)), np.nan)
        return self._table(run, self.points.rows(run, run + 1), none, [reason])

    def _rows(self, start: int, stop: int) -> pd.DataFrame:
        motion, points = self.motion, self.points.rows(start, stop)
        varied = dict(zip(self._paths, points.T, strict=True))
        many = simulate_many(
            self.shipped.model,
            varied,
            motion.time,
            **motion.inputs,
            outputs=self._simulated,
            initial_state=motion.initial_state,
            interpolation=motion.interpolation,
            tolerance=self.tolerance,
            as_measured=True,
        )
        failures = list(many.failures)
        for run, reason in _impossible(self.shipped.model, varied):
            failures[run] = reason
            many.outputs[run] = np.nan
        return self._table(start, points, many.outputs, failures)

    # ---- tables ------------------------------------------------------------------------------

    @property
    def _paths(self) -> list[str]:
        return [factor.path for factor in self.points.factors]

    @property
    def _simulated(self) -> tuple[str, ...]:
        """The outputs chosen, and those that show what sensors of measured signals read."""
        readings = [self._reading(name) for name in self.outputs if name in self.motion.signals]
        return tuple(dict.fromkeys((*self.outputs, *readings)))

    def _reading(self, output: str) -> str:
        reading = f"measured_{output}"
        known = interface(*self.shipped.model.structure).output_names
        return reading if reading in known else output

    def _table(
        self, first: int, points: Array, outputs: Array, failures: Sequence[str]
    ) -> pd.DataFrame:
        """Table of the runs from `first` on: points (k, m), outputs (k, n_outputs, n)."""
        went_well = np.array([not reason for reason in failures])
        runs = np.arange(first, first + len(points))
        index = np.arange(len(points))
        if self.keep == "trajectories":
            kept = np.repeat(went_well[:, None], outputs.shape[2], axis=1)
            kept[:, 0] = True  # the one row of a run that failed
            index = np.nonzero(kept)[0]
            results = self._trajectories(outputs, went_well, kept)
        else:
            results = self._statistics(outputs, went_well)
        columns: dict[str, NDArray[np.int64] | Array | list[str]] = {RUN: runs[index]}
        columns |= {path: points[index, i] for i, path in enumerate(self._paths)}
        columns |= results
        return pd.DataFrame(columns | {FAILURE: [failures[i] for i in index.tolist()]})

    def _trajectories(
        self, outputs: Array, went_well: NDArray[np.bool_], kept: NDArray[np.bool_]
    ) -> dict[str, Array]:
        moments = np.where(went_well[:, None], self.motion.time, np.nan)
        columns = {TIME: moments[kept]}
        for i, variable in enumerate(self.variables):
            columns[variable.name + SUFFIXES[variable.unit]] = outputs[:, i][kept]
        return columns

    def _statistics(self, outputs: Array, went_well: NDArray[np.bool_]) -> dict[str, Array]:
        by_name = {name: outputs[:, i] for i, name in enumerate(self._simulated)}
        columns: dict[str, Array] = {}
        for variable in self.variables:
            name, values = variable.name, by_name[variable.name]
            for statistic, numbers in _statistics(variable, values):
                columns[f"{name}.{statistic}"] = np.where(went_well, numbers, np.nan)
            if name in self.motion.signals:
                error = by_name[self._reading(name)] - self.motion.signals[name]
                columns[f"{name}.rms_error{SUFFIXES[variable.unit]}"] = _rms(error)
        return columns

    @property
    def variables(self) -> list[Variable]:
        """The outputs that are kept, in the units of the model's motion."""
        model = self.shipped.model
        known = {output.name: output for output in interface(*model.structure).outputs}
        chosen = [known[name] for name in self.outputs]
        return [replace(output, unit=model.motion.unit(output.unit)) for output in chosen]


def simulations(
    model: Model,
    points: Points,
    *,
    motion: Motion | None = None,
    outputs: Sequence[str] | None = None,
    keep: Kept = "statistics",
    tolerance: float = DEFAULT_TOLERANCE,
) -> Simulations:
    """Simulations of a model at many points, as a task for `sweep`.

    Parameters
    ----------
    model : Model
    points : what varies, and how
    motion : of all runs; None: the default motion of the model
    outputs : names of outputs of the model; None: those of `OUTPUTS` that it has
    keep : "statistics" for one row a run, "trajectories" for a row each sample
    tolerance : as in `simulate`

    Returns
    -------
    Simulations

    Raises
    ------
    SweepError
        for an output that the model does not have, no output, another word for `keep`, or a motion
        that does not drive the model at its interface
    """
    known = interface(*model.structure).output_names
    if outputs is None:
        outputs = [name for name in OUTPUTS if name in known]
    unknown = [name for name in outputs if name not in known]
    if unknown:
        raise SweepError(problems.unknown_key(unknown[0], unknown[0], known, "the outputs"))
    if not outputs:
        raise SweepError(f"no output is chosen; choose some of {', '.join(known)}")
    if keep not in get_args(Kept):
        raise SweepError(f"{keep!r} cannot be kept; choose one of {', '.join(get_args(Kept))}")
    if not TOLERANCES[0] <= tolerance <= TOLERANCES[1]:
        raise SweepError("tolerance {:g} is outside {:g} to {:g}".format(tolerance, *TOLERANCES))
    chosen = tuple(dict.fromkeys(outputs))
    motion = motion or default_motion(model)
    _check_motion(model, motion)
    return Simulations(ship(model), points, motion, chosen, keep, tolerance)


def _check_motion(model: Model, motion: Motion) -> None:
    """Refuse a motion without what drives a model, or with what that calculates."""
    names, given = given_names(model), motion.inputs
    if set(given) | {LOAD_TORQUE.name} != set(names) | {LOAD_TORQUE.name}:
        raise SweepError(
            f"{model.name} has interface {model.kind}, which {' and '.join(names)} drive; the "
            f"motion has {', '.join(given) or 'neither'}"
        )


# ---- statistics over the last axis of (k, n) samples -------------------------------------------


def _statistics(variable: Variable, values: Array) -> Iterator[tuple[str, Array]]:
    if variable.kind is Kind.SLACK_STATE:
        for state in SlackState:
            yield share_of(state), np.mean(values == state, axis=-1)
    elif variable.discrete:
        yield "share", np.mean(values, axis=-1)
    else:
        suffix = SUFFIXES[variable.unit]
        yield f"minimum{suffix}", np.min(values, axis=-1)
        yield f"maximum{suffix}", np.max(values, axis=-1)
        yield f"mean{suffix}", np.mean(values, axis=-1)
        yield f"rms{suffix}", _rms(values)
        yield f"final{suffix}", values[..., -1]


def share_of(state: SlackState) -> str:
    """Name of the statistic that is the share of samples in a slack state."""
    return f"share_{state.name.lower() if state is SlackState.BOTH else state.name}"


def _rms(values: Array) -> Array:
    return np.asarray(np.sqrt(np.mean(np.square(values), axis=-1)))


def _impossible(model: Model, varied: Mapping[str, Array]) -> Iterator[tuple[int, str]]:
    """Runs that no model.toml may have although each number is within its bounds, and why."""
    if not model.kind.has_springs:
        return
    count = len(next(iter(varied.values())))
    numbers = {
        path: np.broadcast_to(varied.get(path, value), (count,))
        for path, value in model.values().items()
    }
    upper, lower = (
        numbers[f"transmission.{side}.max_deflection"]
        * numbers[f"transmission.{side}.parallel"]
        * numbers[f"transmission.{side}.stiffness"]
        for side in ("upper_spring", "lower_spring")
    )
    pretension, limit = numbers["transmission.pretension_force"], np.minimum(upper, lower)
    for run in np.flatnonzero(pretension > limit):
        yield (
            int(run),
            f"transmission.pretension_force: {pretension[run]:g} N is above the {limit[run]:g} N "
            "that the springs bear, paper (27)",
        )
