"""Run an FMU's own binary through an experiment, in importers that are not ours."""

import ctypes
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from importlib.metadata import files
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from fmpy import read_model_description
from fmpy.fmi1 import FMICallException, printLogMessage
from fmpy.fmi2 import fmi2CallbackFunctions, fmi2CallbackLoggerTYPE
from fmpy.logging import addLoggerProxy
from fmpy.simulation import instantiate_fmu

from elastic_tendon.actuator.variables import POSITION_OF
from elastic_tendon.comparison.residuals import rms
from elastic_tendon.errors import EvidenceError
from elastic_tendon.evidence.experiment import Array, Experiment
from elastic_tendon.native.layout import MOTOR_VELOCITY_CONNECTED

_FINEST = 1e-3  # s; of a replay whose inputs move, where the importer gives no derivatives
_MOST_PARTS = 20  # of a step of such a replay
_REAL = {2: "Real", 3: "Float64"}
_PRINTED = fmi2CallbackLoggerTYPE(printLogMessage)
_ENDINGS = {"Boolean": "Boolean", "Real": "Real", "Float64": "Float64"}


class Slave:
    """An FMU of FMI 2.0 or 3.0 in co-simulation by fmpy, variables by name."""

    def __init__(self, folder: str, name: str) -> None:
        self._description = read_model_description(folder)
        self.version = 2 if self._description.fmiVersion.startswith("2") else 3
        self.variables = {variable.name: variable for variable in self._description.modelVariables}
        self.outputs = tuple(
            name
            for name, variable in self.variables.items()
            if variable.causality == "output" and variable.type == _REAL[self.version]
        )
        self._last_words = ""
        self._name = name
        self._fmu = instantiate_fmu(
            folder, self._description, "CoSimulation", logger=self._listen, debug_logging=True
        )

    def is_input(self, name: str) -> bool:
        """Whether a variable of this name is an input."""
        return name in self.variables and self.variables[name].causality == "input"

    def _listen(self, *arguments: Any) -> None:
        """A call of the FMU's logger, whose last three arguments are status, category and text."""
        status, _, text = arguments[-3:]
        if status > 1:  # more than a warning
            self._last_words = text.decode(errors="replace")

    def begin(self, start: Mapping[str, float]) -> None:
        """From instantiated to the first communication point, at 0 s."""
        if self.version == 2:
            self._call("setupExperiment")
        for name, value in start.items():
            ending = _ENDINGS[self.variables[name].type]
            typed = bool(value) if ending == "Boolean" else float(value)
            self._call(f"set{ending}", self._references([name]), [typed])
        self._call("enterInitializationMode")
        self._call("exitInitializationMode")

    def set(self, names: Sequence[str], values: Sequence[float]) -> None:
        """Set inputs."""
        self._call(f"set{_REAL[self.version]}", self._references(names), [*map(float, values)])

    def set_rates(self, names: Sequence[str], values: Sequence[float]) -> None:
        """Set first derivatives of inputs, which FMI 2.0 alone knows."""
        orders = [1] * len(names)
        numbers = [*map(float, values)]
        self._call("setRealInputDerivatives", self._references(names), orders, numbers)

    def get(self, names: Sequence[str]) -> list[float]:
        """Values of real variables."""
        values = self._call(f"get{_REAL[self.version]}", self._references(names))
        return [float(value) for value in values]

    def step(self, time: float, h: float) -> None:
        """One communication step, s."""
        self._call("doStep", time, h)

    def close(self) -> None:
        """End the instance and unload its library."""
        self._fmu.freeInstance()

    def _references(self, names: Sequence[str]) -> list[int]:
        return [self.variables[name].valueReference for name in names]

    def _call(self, function: str, *arguments: Any) -> Any:
        try:
            return getattr(self._fmu, function)(*arguments)
        except FMICallException as error:
            reason = self._last_words or str(error)
            raise EvidenceError(f"{self._name}: the FMU stopped in {function}: {reason}") from None


@contextmanager
def _opened(folder: str, name: str) -> Iterator[Slave]:
    """The FMU unpacked in a folder, which is unloaded at the end.

    For all FMUs of FMI 2.0 fmpy has one logger, the last that was set, and calls it also when it is
    gone: at the end its own is put back.

    Raises
    ------
    EvidenceError : it has no binary for this machine, or that cannot be loaded
    """
    with ExitStack() as ends:
        ends.callback(_print_again)
        try:
            slave = Slave(folder, name)
        except Exception as error:
            reason = str(error).splitlines()[0].replace(folder, name)
            raise EvidenceError(
                f"{name}: its binary does not run on this machine ({reason})"
            ) from None
        ends.callback(slave.close)
        yield slave


def _print_again() -> None:
    addLoggerProxy(ctypes.byref(fmi2CallbackFunctions(logger=_PRINTED)))


@dataclass(frozen=True)
class Run:
    """Outputs (n,) at the times of an experiment, by name, and what they may be off by (RMS)."""

    outputs: Mapping[str, Array]
    off: Mapping[str, float]


def run_held(folder: str, name: str, experiment: Experiment) -> Run:
    """Run an experiment with inputs that are held from time to time, by fmpy.

    Parameters
    ----------
    folder, name : where the FMU is unpacked, and what messages call it
    experiment : Experiment

    Raises
    ------
    EvidenceError : the FMU cannot be loaded, or stops
    """
    still = {input_name: np.zeros(len(experiment.time)) for input_name in experiment.inputs}
    with _opened(folder, name) as slave:
        outputs = _outputs(slave, experiment, still)
        return Run(outputs, dict.fromkeys(outputs, 0.0))


def run_straight(folder: str, name: str, experiment: Experiment) -> Run:
    """Run an experiment with inputs that are straight from time to time, by fmpy.

    FMI 2.0 takes the inputs' derivatives. Else steps are parted, each with the inputs of its
    middle, and parted once more; by how much the outputs then differ, they may be off.

    Parameters, errors: as of `run_held`
    """
    slopes = {
        input_name: _slopes(experiment.time, values)
        for input_name, values in experiment.inputs.items()
    }
    runs = []
    for finest in (_FINEST, _FINEST / 2.0):
        with _opened(folder, name) as slave:
            if slave.version == 2:
                outputs = _outputs(slave, experiment, slopes)
                return Run(outputs, dict.fromkeys(outputs, 0.0))
            runs.append(_outputs(slave, experiment, slopes, finest))
    coarse, fine = runs
    return Run(fine, {output: rms(fine[output] - coarse[output]) for output in fine})


def _slopes(time: Array, values: Array) -> Array:
    """Slopes (n,) of straight lines from each sample to the next; at the last, that to it."""
    slopes = np.diff(values) / np.diff(time)
    return np.append(slopes, slopes[-1])


def _outputs(
    slave: Slave,
    experiment: Experiment,
    slopes: Mapping[str, Array],
    finest: float | None = None,
) -> dict[str, Array]:
    """Outputs at each time, with the inputs that begin there; `finest` step, s, where parted."""
    inputs = [*experiment.inputs]
    values = np.column_stack([*experiment.inputs.values()])
    rates = np.column_stack([slopes[name] for name in inputs])
    velocities = {
        velocity: slopes[position]
        for velocity, position in POSITION_OF.items()
        if slave.is_input(velocity)
    }
    every = (*inputs, *velocities)
    given = np.column_stack([values, *velocities.values()])
    option = MOTOR_VELOCITY_CONNECTED.name
    settings = {option: 1.0} if option in slave.variables else {}
    slave.begin({**experiment.start, **dict(zip(every, given[0], strict=True)), **settings})
    rows = []
    for i, time in enumerate(experiment.time):
        slave.set(every, given[i])
        if finest is None and rates.any():
            slave.set_rates(inputs, rates[i])
        rows.append(slave.get(slave.outputs))
        if i + 1 == len(values):
            break
        h = float(experiment.time[i + 1] - time)
        parts = 1 if finest is None else min(math.ceil(h / finest), _MOST_PARTS)
        for part in range(parts):
            if parts > 1:
                slave.set(inputs, values[i] + rates[i] * (part + 0.5) * h / parts)
            slave.step(float(time) + part * h / parts, h / parts)
    return dict(zip(slave.outputs, np.array(rows).T, strict=True))


# ---- other importers -----------------------------------------------------------------------


def _ecos(path: str, experiment: Experiment, states: Sequence[str]) -> Array:
    for file in files("tbb") or ():
        if file.name == "libtbb.so.12":  # Ecos is linked with it and does not find it by itself
            ctypes.CDLL(str(file.locate()), mode=ctypes.RTLD_GLOBAL)
    from ecospy import EcosSimulation, EcosSimulationStructure

    rows = []
    with EcosSimulationStructure() as structure:
        structure.add_model("fmu", path)
        with EcosSimulation(_step(experiment), structure=structure) as simulation:
            simulation.init()
            rows.append([simulation.get_real(f"fmu::{name}") for name in states])
            for i in range(len(experiment.time) - 1):
                for name, values in experiment.inputs.items():
                    simulation.set_real(f"fmu::{name}", float(values[i]))
                simulation.step()
                rows.append([simulation.get_real(f"fmu::{name}") for name in states])
            simulation.terminate()
    return np.array(rows)


def _libcosim(path: str, experiment: Experiment, states: Sequence[str]) -> Array:
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
    from libcosimpy.CosimManipulator import CosimManipulator
    from libcosimpy.CosimObserver import CosimObserver
    from libcosimpy.CosimSlave import CosimLocalSlave

    log_output_level(CosimLogLevel.FATAL)
    description = read_model_description(path)
    if not description.fmiVersion.startswith("2"):  # it would bring the process down
        raise EvidenceError(f"{Path(path).name}: libcosim runs FMI 2.0 alone")
    references = {variable.name: variable.valueReference for variable in description.modelVariables}
    execution = CosimExecution.from_step_size(round(1e9 * _step(experiment)))
    index = execution.add_local_slave(CosimLocalSlave(fmu_path=path, instance_name="fmu"))
    observer, manipulator = CosimObserver.create_last_value(), CosimManipulator.create_override()
    execution.add_observer(observer)
    execution.add_manipulator(manipulator)
    set_at = [references[name] for name in experiment.inputs]
    read_at = [references[name] for name in states]
    rows = [[0.0] * len(states)]
    for values in np.column_stack([*experiment.inputs.values()])[:-1].tolist():
        manipulator.slave_real_values(index, set_at, values)
        if not execution.step():
            raise EvidenceError(f"{Path(path).name}: libcosim stopped before the experiment's end")
        rows.append(observer.last_real_values(index, read_at))
    return np.array(rows)


def _step(experiment: Experiment) -> float:
    return float(experiment.time[1] - experiment.time[0])


_OTHERS: Mapping[str, tuple[str, Callable[[str, Experiment, Sequence[str]], Array]]] = {
    "ecos": ("ecospy", _ecos),
    "libcosim": ("libcosimpy", _libcosim),
}
IMPORTERS = ("fmpy", *_OTHERS)


def by_another(
    importer: str, path: str, experiment: Experiment, states: Sequence[str]
) -> dict[str, Array]:
    """States (n,) in the smoke test, by an importer that is none of Python's.

    Such importers set inputs only after they have looked, so what follows inputs at once is that
    of the inputs before.

    Parameters
    ----------
    importer : one of `IMPORTERS` but "fmpy"
    path : of the FMU
    experiment : of equal steps, from where the FMU starts
    states : names of those that are looked at

    Raises
    ------
    EvidenceError : the importer is not installed, refuses the FMU, or stops; nothing is looked at
    """
    if not states:
        raise EvidenceError(
            f"{Path(path).name}: at its interface nothing is moved, and {importer} looks at what "
            "is moved; verify it with fmpy"
        )
    package, run = _OTHERS[importer]
    if find_spec(package) is None:
        raise EvidenceError(f"{importer} is not installed; pip install {package}")
    try:
        return dict(zip(states, run(path, experiment, states).T, strict=True))
    except EvidenceError:
        raise
    except Exception as error:
        reason = str(error).splitlines()[:1] or [type(error).__name__]
        raise EvidenceError(f"{Path(path).name}: {importer} refuses it ({reason[0]})") from None
