"""An FMU for model exchange, of FMI 2.0 or 3.0, with names instead of value references."""

import os
import tempfile
import zipfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import chdir, contextmanager
from ctypes import POINTER, c_double
from pathlib import Path
from typing import Any, NamedTuple
from xml.etree import ElementTree

import fmpy
import numpy as np
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import FMU2Model, fmi2CallbackFunctions, fmi2CallbackLoggerTYPE
from fmpy.fmi3 import FMU3Model
from fmpy.model_description import ModelDescription, ModelVariable, read_model_description

from elastic_tendon.errors import LinearisationError
from elastic_tendon.linear.result import Array

_DESCRIPTION = "modelDescription.xml"
_ADVICE = "give one that elastic-tendon export wrote"
_MOST_EVENT_ITERATIONS = 100


class _Calls(NamedTuple):
    """What the versions of FMI name differently: functions, and how those of a type end."""

    update: str
    rates: str
    reals: str
    ending: Mapping[str, str]
    derivatives: str  # the attribute that says whether there are directional derivatives


_CALLS = {
    2: _Calls(
        *("newDiscreteStates", "getDerivatives", "Real"),
        {"Real": "Real", "Integer": "Integer", "Enumeration": "Integer", "Boolean": "Boolean"},
        "providesDirectionalDerivative",
    ),
    3: _Calls(
        *("updateDiscreteStates", "getContinuousStateDerivatives", "Float64"),
        {"Float64": "Float64", "Int32": "Int32", "Enumeration": "Int64", "Boolean": "Boolean"},
        "providesDirectionalDerivatives",
    ),
}


class Instance:
    """An instance as `opened` gives it; variables by name, in SI units.

    Every method raises LinearisationError with the FMU's own words where the FMU refuses.
    """

    def __init__(self, name: str, description: ModelDescription, folder: str) -> None:
        self.name = name
        self.description = description
        self.version: int = description.fmiMajorVersion
        self.variables: dict[str, ModelVariable] = {
            variable.name: variable for variable in description.modelVariables
        }
        self.derivatives = tuple(derivative.variable.name for derivative in description.derivatives)
        self.states = tuple(
            derivative.variable.derivative.name for derivative in description.derivatives
        )
        self._calls = _CALLS[self.version]
        self._last_words = ""
        self._kept: list[Any] = []
        self._fmu = (FMU2Model if self.version == 2 else FMU3Model)(
            guid=description.guid,
            unzipDirectory=folder,
            modelIdentifier=description.modelExchange.modelIdentifier,
            instanceName=description.modelExchange.modelIdentifier,
        )
        self._instantiate()

    def _instantiate(self) -> None:
        """Bring the FMU to life; what it says is kept, not printed."""
        try:
            if self.version == 2:
                callbacks = fmi2CallbackFunctions()
                callbacks.logger = fmi2CallbackLoggerTYPE(self._listen)
                self._fmu.instantiate(callbacks=callbacks, loggingOn=True)
            else:
                self._fmu.instantiate(loggingOn=True, logMessage=self._listen)
        except Exception:
            self._fmu.freeLibrary()
            raise

    def _listen(self, *told: Any) -> None:
        """A call of the FMU's logger, whose last two arguments are status, category and text."""
        status, _, text = told[-3:]
        if status > 1:  # more than a warning
            self._last_words = text.decode(errors="replace")

    def close(self) -> None:
        """End the instance and unload its library."""
        for state in self._kept:
            self._fmu.freeFMUState(state)
        self._fmu.freeInstance()

    # ---- variables ----

    def set(self, name: str, value: float) -> None:
        """Set a variable of any type."""
        variable = self.variables[name]
        ending = self._calls.ending[variable.type]
        whole = ending not in ("Real", "Float64")
        self._call(f"set{ending}", [variable.valueReference], [int(value) if whole else value])

    def get(self, name: str) -> float:
        """Value of a variable of any type."""
        variable = self.variables[name]
        values = self._call(f"get{self._calls.ending[variable.type]}", [variable.valueReference])
        return float(values[0])

    def get_reals(self, names: Sequence[str]) -> Array:
        """Values of continuous variables, (n,)."""
        return np.array(self._call(f"get{self._calls.reals}", self._references(names)))

    def set_reals(self, names: Sequence[str], values: Array) -> None:
        """Set continuous variables, (n,)."""
        self._call(f"set{self._calls.reals}", self._references(names), values.tolist())

    def derivative(self, unknowns: Sequence[str], known: str) -> Array:
        """Derivatives of unknowns by a known, (n,)."""
        references = self._references(unknowns), self._references([known])
        return np.array(self._call("getDirectionalDerivative", *references, [1.0]))

    # ---- life ----

    def initialise(self, values: Mapping[str, float]) -> None:
        """From anew to event mode, with values that differ from the FMU's own."""
        self._call("reset")
        for name, value in values.items():
            self.set(name, value)
        if self.version == 2:
            self._call("setupExperiment")
        self._call("enterInitializationMode")
        self._call("exitInitializationMode")

    def handle_event(self) -> None:
        """From continuous-time mode through event mode and back."""
        self._call("enterEventMode")
        self.settle()

    def settle(self) -> None:
        """From event mode to continuous-time mode."""
        for _ in range(_MOST_EVENT_ITERATIONS):
            if not self._call(self._calls.update)[0]:
                break
        self._call("enterContinuousTimeMode")

    def state(self) -> Any:
        """All of the instance's state, kept in its memory until it is closed."""
        self._kept.append(self._call("getFMUState"))
        return self._kept[-1]

    def restore(self, state: Any) -> None:
        """Go back to a state."""
        self._call("setFMUState", state)

    # ---- continuous time ----

    def move(self, x: Array) -> None:
        """Set the continuous states, (n,)."""
        n = len(self.states)
        self._call("setContinuousStates", (c_double * n)(*x), n)

    def position(self) -> Array:
        """The continuous states, (n,)."""
        return self._filled("getContinuousStates", len(self.states))

    def rates(self) -> Array:
        """Time derivatives of the continuous states, (n,)."""
        return self._filled(self._calls.rates, len(self.states))

    def indicators(self) -> Array:
        """Event indicators."""
        return self._filled("getEventIndicators", self.description.numberOfEventIndicators)

    def _filled(self, function: str, n: int) -> Array:
        values = np.zeros(n)
        self._call(function, values.ctypes.data_as(POINTER(c_double)), n)
        return values

    def _references(self, names: Sequence[str]) -> list[int]:
        return [self.variables[name].valueReference for name in names]

    def _call(self, function: str, *arguments: Any) -> Any:
        try:
            return getattr(self._fmu, function)(*arguments)
        except FMICallException:
            words = self._last_words.split(": ", 2)[-1]  # before them: who, when
            raise LinearisationError(f"{self.name}: the FMU refuses {function}: {words}") from None


@contextmanager
def opened(path: str | os.PathLike[str]) -> Iterator[Instance]:
    """An instance of an FMU that is freed at the end, with the folder that it was unpacked to.

    Raises
    ------
    LinearisationError
        for what is no FMU for model exchange of FMI 2.0 or 3.0 with directional derivatives, and
        where its binary is not for this machine
    """
    file = Path(path)
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        _unpack(file, folder)
        description = _description(file.name, Path(folder))
        if not description.derivatives or not all(
            derivative.variable.derivative for derivative in description.derivatives
        ):
            raise LinearisationError(
                f"{file.name}: its {_DESCRIPTION} does not say which derivative belongs to which "
                f"state; {_ADVICE}"
            )
        try:
            with chdir(Path.cwd()):  # fmpy does not come back where a library cannot be loaded
                instance = Instance(file.name, description, folder)
        except FMICallException:
            raise LinearisationError(
                f"{file.name}: its binary does not take its {_DESCRIPTION} for its own; export the "
                "FMU anew"
            ) from None
        except Exception as error:  # fmpy's own are of no other class
            raise LinearisationError(
                f"{file.name}: its binary for {fmpy.platform} cannot be loaded "
                f"({_first_line(error)}); export the FMU for this platform"
            ) from None
        try:
            yield instance
        finally:
            instance.close()


def _unpack(file: Path, folder: str) -> None:
    if not file.is_file():
        raise LinearisationError(f"{file.name}: there is no such file; give the path of an FMU")
    if not zipfile.is_zipfile(file):
        raise LinearisationError(f"{file.name}: this is no FMU (no ZIP archive); {_ADVICE}")
    try:
        fmpy.extract(file, folder)
    except Exception as error:  # of zipfile, zlib, the disk, and fmpy's for paths that lead out
        raise LinearisationError(
            f"{file.name}: the FMU cannot be unpacked ({_first_line(error)}); export it anew"
        ) from None


def _description(name: str, folder: Path) -> ModelDescription:
    file = folder / _DESCRIPTION
    if not file.is_file():
        raise LinearisationError(f"{name}: this is no FMU (no {_DESCRIPTION}); {_ADVICE}")
    try:
        interface = ElementTree.parse(file).getroot().find("ModelExchange")
        description = read_model_description(str(folder), validate=False)
    except Exception as error:  # a parser has many of them
        raise LinearisationError(
            f"{name}: its {_DESCRIPTION} cannot be read ({_first_line(error)}); {_ADVICE}"
        ) from None
    if description.fmiMajorVersion not in _CALLS:
        raise LinearisationError(
            f"{name}: FMI {description.fmiVersion} has no directional derivatives; give an FMU of "
            "FMI 2.0 or 3.0"
        )
    if interface is None:
        raise LinearisationError(
            f"{name}: the FMU has no model exchange, by which it is linearised; {_ADVICE}"
        )
    attribute = _CALLS[description.fmiMajorVersion].derivatives
    if interface.get(attribute) not in ("true", "1"):
        raise LinearisationError(
            f"{name}: the FMU has no directional derivatives ({attribute}); {_ADVICE}"
        )
    return description


def _first_line(error: Exception) -> str:
    lines = str(error).splitlines() or [type(error).__name__]
    return lines[0].rstrip(".")
