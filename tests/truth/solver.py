"""Integrates actuator and link piece by piece: smooth inside a mode, restarted at each event."""

import math
from bisect import bisect_right
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.integrate import DOP853, Radau
from scipy.optimize import brentq, minimize_scalar

from truth.actuator import Actuator
from truth.signals import Experiment
from truth.system import Mode, System, Vector

ROOT_ERROR = 1e-15  # s
GRID_POINTS = 6  # in a step, where thresholds are looked at
STUCK_STEP = 2e-3  # s; a joint at rest gives the step control nothing to go by
METHODS = {"DOP853": DOP853, "Radau": Radau}
MOST_EVENTS = 20_000  # a run with more than this is no run but a fault


@dataclass(frozen=True)
class Event:
    """A change of mode at `time` (s)."""

    time: float
    before: Mode
    after: Mode


@dataclass(frozen=True)
class Trajectory:
    """The run at its sample times (s); every array is (n,), names and units as in `outputs`."""

    time: Vector
    columns: dict[str, Vector]
    events: tuple[Event, ...]

    def __getitem__(self, name: str) -> Vector:
        return self.columns[name]


def first_crossing(
    function: Callable[[float], float], grid: Vector, values: Vector
) -> float | None:
    """First time (s) at which a threshold rises through zero, peaks between included.

    Parameters
    ----------
    function : threshold of time (s)
    grid, values : (n,) array, s, and the threshold there
    """
    above = next((i for i, value in enumerate(values) if value >= 0.0), None)
    if above == 0:  # the end of the step before, rounded the other way
        return float(grid[0])
    if above is not None:
        return float(brentq(function, grid[above - 1], grid[above], xtol=ROOT_ERROR))
    # a mode left and entered again between two grid points shows as a peak just below zero
    top = min(max(int(np.argmax(values)), 1), len(values) - 2)
    if values[top] + abs(values[top - 1] - 2.0 * values[top] + values[top + 1]) < 0.0:
        return None
    around = (grid[top - 1], grid[top + 1])
    peak = minimize_scalar(
        lambda time: -function(time), bounds=around, method="bounded", options={"xatol": 1e-9}
    )
    if function(peak.x) < 0.0:
        return None
    return float(brentq(function, around[0], peak.x, xtol=ROOT_ERROR))


def crossings(
    thresholds: Callable[[float, Vector], list[float]], dense: Callable[[Any], Vector], grid: Vector
) -> list[float]:
    """Times (s) at which thresholds first rise through zero on `grid`, of those that do."""
    states = dense(grid).T
    values = np.array(
        [thresholds(float(time), state) for time, state in zip(grid, states, strict=True)]
    )

    def along(number: int) -> Callable[[float], float]:
        return lambda time: thresholds(time, dense(time))[number]

    found = [first_crossing(along(i), grid, column) for i, column in enumerate(values.T)]
    return [time for time in found if time is not None]


def integrate_piece(
    system: System,
    mode: Mode,
    state: Vector,
    times: Vector,
    span: tuple[float, float],
    **options: Any,
) -> tuple[Vector, float, Vector]:
    """Integrate one mode until `span` ends or the mode is left.

    Returns
    -------
    samples : (m, k) array, states at the first m of `times`
    end : float, s
    state : (k,) array, at `end`
    """
    # inputs are right-continuous: the piece must not see the jump at its own end
    last = math.nextafter(span[1], span[0])

    def inside(function: Callable[[float, Vector], Any]) -> Callable[[float, Vector], Any]:
        return lambda time, state: function(min(time, last), state)

    thresholds = inside(lambda time, state: system.thresholds(time, state, mode))
    rates = inside(lambda time, state: system.rates(time, state, mode))
    stuck = system.has_direction and mode.direction == 0
    solver = options["method"](
        rates, span[0], state, span[1], rtol=options["rtol"],
        atol=options["atol"] * np.array(system.layout.scales),
        max_step=STUCK_STEP if stuck else options["longest_step"],
    )  # fmt: skip
    samples = np.empty((0, len(state)))
    while solver.status == "running":
        message = solver.step()
        if solver.status == "failed":
            raise RuntimeError(f"truth stopped at {solver.t} s: {message}")
        dense, grid = solver.dense_output(), np.linspace(solver.t_old, solver.t, GRID_POINTS)
        met = crossings(thresholds, dense, grid)
        stop = min(met, default=solver.t)
        reached = times[len(samples) : np.searchsorted(times, stop, side="right")]
        samples = np.vstack([samples, dense(reached).T])
        if met:
            return samples, stop, dense(stop)
    return samples, span[1], solver.y


@dataclass(frozen=True)
class Piece:
    """States at the sample times inside one mode."""

    mode: Mode
    start: float
    samples: Vector


def pieces(system: System, time: Vector, **options: Any) -> Iterator[Piece]:
    """Integrate from zero to the last sample, one mode after the other."""
    breakpoints = {
        *system.experiment.motor_position.breakpoints,
        *system.experiment.load_torque.breakpoints,
    }
    end = float(time[-1])
    stops = [*sorted(point for point in breakpoints if 0.0 < point < end), end]
    mode, state = system.initial()
    now, done = 0.0, 0
    for _ in range(len(stops) + MOST_EVENTS):
        stop = stops[bisect_right(stops, now)]
        # a sample at a breakpoint belongs to what follows, as the inputs do
        first_after = int(np.searchsorted(time, stop, side="left"))
        samples, reached, state = integrate_piece(
            system, mode, state, time[done:first_after], (now, stop), **options
        )
        yield Piece(mode, now, samples)
        now, done = reached, done + len(samples)
        if now >= end:
            yield Piece(mode, now, np.tile(state, (len(time) - done, 1)))
            return
        mode, state = system.updated(now, state, mode)
    raise RuntimeError(f"truth met more than {MOST_EVENTS} events by {now} s")


def outputs(system: System, time: float, state: Vector, mode: Mode) -> dict[str, float]:
    """All signals of one sample in rad, rad/s, N·m and N.

    `friction_torque` is against positive motion. `slack_state` 1 is I (lower slack), 2 is II
    (upper slack), 3 is III (none), 4 both.
    """
    motor_position, motor_velocity = system.motor(time)
    tensions = system.tensions(time, state, mode)
    forces = system.at_joint(tensions)
    ratio = system.actuator.joint_pulley_radius / system.actuator.motor_pulley_radius
    return {
        "motor_position": motor_position,
        "motor_velocity": motor_velocity,
        "load_torque": system.experiment.load_torque.value(time),
        "joint_position": float(state[0]),
        "joint_velocity": float(state[1]),
        "deflection": float(state[0]) - motor_position / ratio,
        "joint_torque": system.joint_torque(time, state, mode, tensions),
        "motor_torque": system.motor_torque(time, mode, tensions),
        "upper_spring_force": forces[0],
        "lower_spring_force": forces[1],
        "friction_torque": system.friction_torque(time, state, mode, tensions),
        "slack_state": {(1, 0): 1, (0, 1): 2, (1, 1): 3, (0, 0): 4}[mode.taut],
    }


def simulate(
    actuator: Actuator,
    experiment: Experiment,
    time: Vector,
    *,
    tolerance: float = 1e-11,
    longest_step: float = 0.02,
    method: str = "DOP853",
) -> Trajectory:
    """Simulate an experiment from time zero.

    Parameters
    ----------
    time : (n,) array, s; increasing sample times, the first not negative
    tolerance : relative; absolute a tenth of it in the states' ordinary sizes
    longest_step : s, while the joint moves; shorter than what the inputs do
    method : a name in `METHODS`: DOP853, or Radau where the actuator is stiff
    """
    system = System(actuator, experiment)
    options = {
        "method": METHODS[method], "rtol": tolerance, "atol": 0.1 * tolerance,
        "longest_step": longest_step,
    }  # fmt: skip
    rows: list[dict[str, float]] = []
    events: list[Event] = []
    previous: Mode | None = None
    for piece in pieces(system, time, **options):
        if previous is not None and piece.mode != previous:
            events.append(Event(piece.start, previous, piece.mode))
        previous = piece.mode
        rows += [
            outputs(system, float(time[len(rows) + i]), state, piece.mode)
            for i, state in enumerate(piece.samples)
        ]
    columns = {name: np.array([row[name] for row in rows]) for name in rows[0]}
    return Trajectory(time, columns, tuple(events))
