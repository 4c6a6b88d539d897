"""An instance of an FMU with names instead of value references, of whatever version of FMI."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from ctypes import POINTER, c_double, c_size_t, c_uint, c_void_p
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from fmpy.model_description import ModelDescription

from elastic_tendon.simulation.simulate import Array

OK, WARNING, DISCARD, ERROR = range(4)  # fmi2Status, fmi3Status
Call = tuple[str, *tuple[Any, ...]]  # a function of the header and its arguments but the instance


@dataclass(frozen=True)
class Message:
    """One call of the logger; FMI 3 does not pass the instance's name."""

    instance: str
    status: int
    category: str
    text: str


@dataclass(frozen=True)
class EventInfo:
    """What event iteration came to."""

    calls: int
    jumped: bool
    nominals_changed: bool
    terminate: bool
    next_time: float | None


class Instance(ABC):
    """An instance as its importer has it.

    `fmu` is fmpy's object, `log` collects the messages, `kept` are callbacks that must live on.
    """

    version: ClassVar[int]
    number: ClassVar[str]  # name of the type of real numbers
    # how functions that get and set a type of variables end, and what they take
    access: ClassVar[Mapping[str, tuple[str, Any]]]

    def __init__(
        self,
        fmu: Any,
        description: ModelDescription,
        log: list[Message],
        kept: Any = None,
    ) -> None:
        self.fmu = fmu
        self.description = description
        self.log = log
        self.kept = kept
        self.variables = {one.name: one for one in description.modelVariables}

    # ---- variables ----

    def reference(self, name: str) -> int:
        """Value reference of a variable."""
        reference: int = self.variables[name].valueReference
        return reference

    def references(self, names: Sequence[str]) -> list[int]:
        """Value references of variables."""
        return [self.reference(name) for name in names]

    def named(self, **wanted: str) -> list[str]:
        """Names of the variables whose attributes are as wanted."""
        return [
            name
            for name, one in self.variables.items()
            if all(getattr(one, key) == value for key, value in wanted.items())
        ]

    def get(self, name: str) -> Any:
        """Value of a variable of any type."""
        variable = self.variables[name]
        getter = getattr(self.fmu, f"get{self.access[variable.type][0]}")
        return getter([variable.valueReference])[0]

    def values(self, names: Sequence[str]) -> Array:
        """Values of several real variables."""
        return np.array(getattr(self.fmu, f"get{self.number}")(self.references(names)))

    def set(self, name: str, value: float) -> None:
        """Set a variable of any type."""
        variable = self.variables[name]
        setter = getattr(self.fmu, f"set{self.access[variable.type][0]}")
        setter([variable.valueReference], [value])

    def everything(self) -> dict[str, Any]:
        """All values that can be read."""
        return {name: self.get(name) for name in self.variables}

    def derivative(
        self, unknowns: Sequence[str], knowns: Sequence[str], seed: Sequence[float]
    ) -> Array:
        """Directional derivative."""
        references = (self.references(unknowns), self.references(knowns))
        return np.array(self.fmu.getDirectionalDerivative(*references, list(seed)))

    @abstractmethod
    def output_derivatives(self, names: Sequence[str]) -> Array:
        """First derivatives of outputs by time."""

    # ---- life ----

    @abstractmethod
    def set_up(
        self,
        start: Mapping[str, float] | None = None,
        tolerance: float | None = None,
        start_time: float = 0.0,
        stop_time: float | None = None,
    ) -> None:
        """From instantiated to initialisation mode."""

    def begin(self, start: Mapping[str, float] | None = None, **experiment: Any) -> None:
        """From instantiated to between steps or, after event iteration, continuous time."""
        self.set_up(start, **experiment)
        self.fmu.exitInitializationMode()
        if self.has_event_mode:
            self.iterate_events()

    @property
    @abstractmethod
    def is_slave(self) -> bool:
        """Whether it is for co-simulation."""

    @property
    def has_event_mode(self) -> bool:
        """Whether the importer handles events."""
        return not self.is_slave

    @abstractmethod
    def iterate_events(self) -> EventInfo:
        """From event mode to continuous time, or to between steps."""

    @abstractmethod
    def rates_of_states(self) -> Callable[..., Any]:
        """The function that gets the derivatives of the states."""

    @abstractmethod
    def advance(self, time: float, h: float) -> Any:
        """A step that is taken."""

    @abstractmethod
    def free(self) -> None:
        """End the instance's life."""

    # ---- model exchange ----

    def indicators(self) -> Array:
        """Event indicators."""
        values = np.zeros(self.description.numberOfEventIndicators)
        self.fmu.getEventIndicators(values.ctypes.data_as(POINTER(c_double)), len(values))
        return values

    def move(self, *x: float) -> None:
        """Set the continuous states."""
        self.fmu.setContinuousStates((c_double * len(x))(*x), len(x))

    # ---- state ----

    @abstractmethod
    def get_state(self) -> Any:
        """The state, kept in the FMU's memory."""

    @abstractmethod
    def set_state(self, state: Any) -> None:
        """Go back to a state."""

    @abstractmethod
    def free_state(self, state: Any) -> None:
        """Forget a state."""

    @abstractmethod
    def serialise(self, state: Any) -> bytes:
        """Bytes of a state."""

    @abstractmethod
    def deserialise(self, data: bytes) -> Any:
        """State of bytes."""

    def snapshot(self) -> bytes:
        """Serialised state."""
        state = self.get_state()
        data = self.serialise(state)
        self.free_state(state)
        return data

    def restore(self, data: bytes) -> None:
        """Go back to a serialised state."""
        state = self.deserialise(data)
        self.set_state(state)
        self.free_state(state)

    # ---- calls that may be illegal ----

    def call(self, function: str, *arguments: Any) -> Call:
        """A function by its name without the version."""
        return (f"fmi{self.version}{function}", *arguments)

    @abstractmethod
    def getting(self, reference: int, suffix: str | None = None) -> Call:
        """Call that gets a value; suffix is the name of the type in the function's name."""

    @abstractmethod
    def setting(self, names: Sequence[str], values: Sequence[Any], suffix: str = "") -> Call:
        """Call that sets values of variables; real numbers where no suffix is given."""

    @abstractmethod
    def stepping(self, time: float, h: float) -> Call:
        """Call that takes a step."""

    @abstractmethod
    def differentiating(self, unknowns: Sequence[str], knowns: Sequence[str]) -> Call:
        """Call that gets a directional derivative along ones."""

    def status(self, function: str, *arguments: Any) -> int:
        """Status of a call that may be illegal."""
        raw = self.fmu.dll[function]  # fmpy's own wrapper knows the functions of one interface only
        status: int = raw(c_void_p(self.fmu.component), *map(_argument, arguments))
        return status

    def _arrays(self, names: Sequence[str], values: Sequence[Any], suffix: str) -> tuple[Any, Any]:
        c_type = dict(self.access.values())[suffix or self.number]
        references = (c_uint * len(names))(*self.references(names))
        return references, (c_type * len(values))(*values)


def _argument(one: Any) -> Any:
    if isinstance(one, float):
        return c_double(one)
    return c_size_t(one) if isinstance(one, int) else one  # in a register an int is its lower part
