"""An experiment for an FMU: inputs over time, the state it starts from, and results."""

import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastic_tendon.actuator.interfaces import InterfaceKind
from elastic_tendon.actuator.parameters import Model
from elastic_tendon.actuator.transmission import characteristic_stiffness, slack_boundaries
from elastic_tendon.actuator.variables import moved_states
from elastic_tendon.errors import EvidenceError
from elastic_tendon.simulation.simulate import given_names, simulate

Array = NDArray[np.float64]

SMOKE_TEST = "smoke_test"
_SAMPLES, _STEP = 301, 0.01  # of the smoke test; the step, s, is a whole number of nanoseconds
_TURNS = 2.0 * np.pi * np.array([1.3, 3.7])  # rad/s, of motor and load
_AMPLITUDE = 0.1  # rad at the joint
_DIGITS = 9  # of inputs that are made up, and of results
_ROWS = 400  # results are thinned to about as many rows
# of the range of a result: above what other processors and libraries of mathematics differ by
_TOLERANCE = 1e-5


@dataclass(frozen=True)
class Experiment:
    """Inputs that are held from each of n times to the next, s from 0, and what a model does.

    `inputs` : name -> (n,) array, SI. `start` : name of a state, or dotted path of what the
    recording has of its own -> its value.
    """

    name: str
    time: Array
    inputs: Mapping[str, Array]
    start: Mapping[str, float]

    def table(self) -> bytes:
        """Time and inputs as CSV; reading it gives the same numbers."""
        return to_csv({"time": self.time, **self.inputs}, "%r")


def result_names(kind: InterfaceKind) -> tuple[str, ...]:
    """Outputs that reference results hold: of what is moved, and the torque of the tendons."""
    return (*moved_states(kind), *(("joint_torque",) if kind.has_springs else ()))


def smoke_test(model: Model) -> Experiment:
    """Three seconds that any importer can run: equal steps from where the FMU starts.

    A motor turns the joint by 0.1 rad, torques deflect the springs by half of what slackens a
    tendon, and so does a joint that is given; without springs the load moves the link by 0.1 rad.
    Torques are cosines, under which what is free to move does not drift away.
    """
    time = np.round(np.arange(_SAMPLES) * _STEP, _DIGITS)
    motor, load = _TURNS[:, np.newaxis] * time
    ratio = 1.0 / model.transmission.motor_share  # n_t, (9)
    deflection, torque = _deflecting(model)
    inputs = {
        "motor_position": ratio * _AMPLITUDE * np.sin(motor),
        "motor_torque": torque / ratio * np.cos(motor),
        "load_torque": torque * np.cos(load),
        "joint_position": _AMPLITUDE * np.sin(motor) + deflection * np.sin(load),
    }
    given = {name: np.round(inputs[name], _DIGITS) for name in given_names(model)}
    return Experiment(SMOKE_TEST, time, given, {})


def _deflecting(model: Model) -> tuple[float, float]:
    """Amplitudes of a deflection, rad, and of a torque on the joint, N·m."""
    if not model.kind.has_springs:
        return 0.0, model.link.inertia * float(_TURNS[1]) ** 2 * _AMPLITUDE
    low, high = slack_boundaries(model.transmission)
    deflection = min(-low, high) / 2.0
    return deflection, deflection * float(characteristic_stiffness(0.0, model.transmission))


def results_of(model: Model, experiment: Experiment) -> dict[str, Array]:
    """Time and what `result_names` lists, thinned; SI.

    Raises
    ------
    SimulationError : the solver could not go on
    """
    motion: dict[str, Any] = {"time": experiment.time, **experiment.inputs}
    run = simulate(model, **motion, initial_state=experiment.start, interpolation="hold")
    kept = slice(None, None, -(-len(run.time) // _ROWS))
    columns = {"time": run.time, **{name: run[name] for name in result_names(model.kind)}}
    return {name: values[kept] for name, values in columns.items()}


def tolerances(results: Mapping[str, Array]) -> dict[str, float]:
    """How far an importer may be from the results, by name, SI."""
    ranges = {name: float(np.ptp(results[name])) for name in results if name != "time"}
    return {name: float(f"{_TOLERANCE * (size or 1.0):.2g}") for name, size in ranges.items()}


def results_table(results: Mapping[str, Array]) -> bytes:
    """Results as CSV, times in full."""
    return to_csv(results, f"%.{_DIGITS}g")


def to_csv(columns: Mapping[str, Array], form: str) -> bytes:
    """Columns (n,) by name as CSV; `form` of the numbers but the times, as "%r"."""
    forms = ["%r" if name == "time" else form for name in columns]
    row = ",".join(forms)
    lists = (values.tolist() for values in columns.values())
    rows = (row % values for values in zip(*lists, strict=True))
    return ("\n".join([",".join(columns), *rows]) + "\n").encode()


def from_csv(content: bytes, source: str, wanted: Sequence[str] = ("time",)) -> dict[str, Array]:
    """Columns (n,) of a CSV by name.

    Raises
    ------
    EvidenceError : it is no table of finite numbers with increasing times and the `wanted` columns
    """
    try:
        head, _, rows = content.decode().partition("\n")
        names = head.strip().split(",")
        lines = io.StringIO(rows if rows.strip() else "nan")  # for no line at all it would warn
        table = np.loadtxt(lines, delimiter=",", comments=None, ndmin=2)
    except (ValueError, UnicodeDecodeError):
        raise EvidenceError(f"{source}: it is no table of numbers with one header line") from None
    if not {*wanted} <= {*names} or table.shape[1:] != (len(names),) or len(table) < 2:
        listed = ", ".join(wanted)
        raise EvidenceError(f"{source}: a table with the columns {listed} is expected") from None
    columns = dict(zip(names, table.T, strict=True))
    if not np.isfinite(table).all() or not (np.diff(columns["time"]) > 0.0).all():
        raise EvidenceError(f"{source}: its numbers are not finite, or its times do not increase")
    return columns
