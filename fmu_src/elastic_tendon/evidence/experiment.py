"""An experiment for an FMU: inputs over time, the state it starts from, and results."""

import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastic_tendon.actuator.parameters import Model
from elastic_tendon.errors import EvidenceError
from elastic_tendon.simulation.simulate import simulate

Array = NDArray[np.float64]

SMOKE_TEST = "smoke_test"
# what any importer sees at a communication point, before it sets the next inputs
STATES = ("joint_position", "joint_velocity")
RESULTS = (*STATES, "joint_torque")
_SAMPLES, _STEP = 301, 0.01  # of the smoke test; the step, s, is a whole number of nanoseconds
_TURNS = (1.3, 3.7)  # Hz
_DIGITS = 9  # of inputs that are made up, and of results
_ROWS = 400  # results are thinned to about as many rows
# of the range of a result: above what other processors and libraries of mathematics differ by
_TOLERANCE = 1e-5


@dataclass(frozen=True)
class Experiment:
    """Inputs that are held from each of n times to the next, s from 0, and what a model does.

    `inputs` : name -> (n,) array, SI. `start` : name of a state -> its value at the first time.
    """

    name: str
    time: Array
    inputs: Mapping[str, Array]
    start: Mapping[str, float]

    def table(self) -> bytes:
        """Time and inputs as CSV; reading it gives the same numbers."""
        return to_csv({"time": self.time, **self.inputs}, "%r")


def smoke_test(motor_amplitude: float, load_amplitude: float) -> Experiment:
    """Three seconds that any importer can run: equal steps from where the FMU starts.

    Parameters
    ----------
    motor_amplitude : rad at the motor pulley
    load_amplitude : N·m on the joint
    """
    time = np.round(np.arange(_SAMPLES) * _STEP, _DIGITS)
    motor, load = (np.sin(2.0 * np.pi * rate * time) for rate in _TURNS)
    inputs = {"motor_position": motor_amplitude * motor, "load_torque": load_amplitude * load}
    rounded = {name: np.round(values, _DIGITS) for name, values in inputs.items()}
    return Experiment(SMOKE_TEST, time, rounded, {})


def results_of(model: Model, experiment: Experiment) -> dict[str, Array]:
    """Time and `RESULTS` of the model, thinned; SI.

    Raises
    ------
    SimulationError : the solver could not go on
    """
    run = simulate(
        model,
        experiment.time,
        experiment.inputs["motor_position"],
        experiment.inputs.get("load_torque"),
        initial_state=experiment.start,
        interpolation="hold",
    )
    kept = slice(None, None, -(-len(run.time) // _ROWS))
    columns = {"time": run.time, **{name: run[name] for name in RESULTS}}
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
