"""Instances of FMI 3.0."""

from collections.abc import Callable, Mapping, Sequence
from ctypes import byref, c_bool, c_double, c_int32, c_int64, c_uint
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from fmpy.fmi3 import FMU3Model, FMU3Slave
from fmpy.model_description import ModelDescription

from elastic_tendon.simulation.simulate import Array
from fmu_instance import Call, EventInfo, Instance, Message


@dataclass(frozen=True)
class StepEnd:
    """What fmi3DoStep tells."""

    event: bool
    terminate: bool
    early: bool
    time: float


@dataclass(frozen=True)
class Look:
    """What an intermediate update tells."""

    time: float
    may_set: bool
    may_get: bool
    step_finished: bool
    may_stop: bool


# looks at an instance inside a step; answers a time to stop at, or None
Update = Callable[["Instance3", Look], float | None]


class Instance3(Instance):
    """An instance of FMI 3.0."""

    version: ClassVar[int] = 3
    number: ClassVar[str] = "Float64"
    access: ClassVar[Mapping[str, tuple[str, Any]]] = {
        "Float64": ("Float64", c_double),
        "Int32": ("Int32", c_int32),
        "Enumeration": ("Int64", c_int64),
        "Boolean": ("Boolean", c_bool),
    }
    event_mode_used = False

    @property
    def is_slave(self) -> bool:
        """Whether it is for co-simulation."""
        return isinstance(self.fmu, FMU3Slave)

    @property
    def has_event_mode(self) -> bool:
        """Whether the importer handles events."""
        return self.event_mode_used or not self.is_slave

    def adjoint(
        self, unknowns: Sequence[str], knowns: Sequence[str], seed: Sequence[float]
    ) -> Array:
        """Adjoint derivative."""
        references = (self.references(unknowns), self.references(knowns))
        # fmpy takes the number of unknowns for that of the results
        found = self.fmu.getAdjointDerivative(*references, list(seed), len(knowns))
        return np.array(found)

    def output_derivatives(self, names: Sequence[str]) -> Array:
        """First derivatives of outputs by time."""
        return np.array(self.fmu.getOutputDerivatives(self.references(names), [1] * len(names)))

    def set_up(
        self,
        start: Mapping[str, float] | None = None,
        tolerance: float | None = None,
        start_time: float = 0.0,
        stop_time: float | None = None,
    ) -> None:
        """From instantiated to initialisation mode."""
        for name, value in (start or {}).items():
            self.set(name, value)
        self.fmu.enterInitializationMode(tolerance, start_time, stop_time)

    def iterate_events(self) -> EventInfo:
        """From event mode to continuous time, or to between steps."""
        again, calls = True, 0
        while again:
            again, terminate, nominals, jumped, defined, time = self.fmu.updateDiscreteStates()
            calls += 1
        (self.fmu.enterStepMode if self.is_slave else self.fmu.enterContinuousTimeMode)()
        return EventInfo(calls, jumped, nominals, terminate, time if defined else None)

    def rates_of_states(self) -> Callable[..., Any]:
        """The function that gets the derivatives of the states."""
        function: Callable[..., Any] = self.fmu.getContinuousStateDerivatives
        return function

    def advance(self, time: float, h: float) -> StepEnd:
        """A step that is taken."""
        return StepEnd(*self.fmu.doStep(time, h))

    def free(self) -> None:
        """End the instance's life."""
        self.fmu.fmi3FreeInstance(self.fmu.component)

    def get_state(self) -> Any:
        """The state, kept in the FMU's memory."""
        return self.fmu.getFMUState()

    def set_state(self, state: Any) -> None:
        """Go back to a state."""
        self.fmu.setFMUState(state)

    def free_state(self, state: Any) -> None:
        """Forget a state."""
        self.fmu.freeFMUState(state)

    def serialise(self, state: Any) -> bytes:
        """Bytes of a state."""
        data: bytes = self.fmu.serializeFMUState(state)
        return data

    def deserialise(self, data: bytes) -> Any:
        """State of bytes."""
        return self.fmu.deserializeFMUState(data)

    def getting(self, reference: int, suffix: str | None = None) -> Call:
        """Call that gets a value."""
        arguments = ((c_uint * 1)(reference), 1, (c_double * 1)(), 1)
        return self.call(f"Get{suffix or self.number}", *arguments)

    def setting(self, names: Sequence[str], values: Sequence[Any], suffix: str = "") -> Call:
        """Call that sets values of variables."""
        references, given = self._arrays(names, values, suffix)
        arguments = (references, len(names), given, len(values))
        return self.call(f"Set{suffix or self.number}", *arguments)

    def stepping(self, time: float, h: float) -> Call:
        """Call that takes a step."""
        results = (byref(c_bool()), byref(c_bool()), byref(c_bool()), byref(c_double()))
        return self.call("DoStep", time, h, 1, *results)

    def differentiating(self, unknowns: Sequence[str], knowns: Sequence[str]) -> Call:
        """Call that gets a directional derivative along ones."""
        n, m = len(unknowns), len(knowns)
        vectors = self._arrays(unknowns, [0.0] * n, "")
        others = self._arrays(knowns, [1.0] * m, "")
        return self.call(
            "GetDirectionalDerivative",
            *(vectors[0], n, others[0], m, others[1], m, vectors[1], n),
        )


def instantiate3(
    description: ModelDescription,
    folder: str,
    *,
    slave: bool,
    name: str,
    token: str,
    logging: bool,
    event_mode: bool = False,
    early_return: bool = False,
    update: Update | None = None,
    required: Sequence[str] = (),
) -> Instance3:
    """A new instance for co-simulation or model exchange.

    `required` are variables that `update` may get and set inside a step.
    """
    interface = description.coSimulation if slave else description.modelExchange
    fmu = (FMU3Slave if slave else FMU3Model)(
        guid=token,
        unzipDirectory=folder,
        modelIdentifier=interface.modelIdentifier,
        instanceName=name,
    )
    log: list[Message] = []
    instance = Instance3(fmu, description, log)
    instance.event_mode_used = event_mode

    def logger(_environment: Any, status: int, category: bytes, message: bytes) -> None:
        log.append(Message(name, status, category.decode(), message.decode()))

    def look(_environment: Any, *told: Any) -> None:
        *facts, wish, stop = told
        answer = update(instance, Look(*facts)) if update else None
        if answer is not None:
            wish[0], stop[0] = True, answer

    options = {"loggingOn": logging, "logMessage": logger}
    if slave:
        options |= {
            "eventModeUsed": event_mode,
            "earlyReturnAllowed": early_return,
            "intermediateUpdate": look if update else None,
            "requiredIntermediateVariables": instance.references(required),
        }
    fmu.instantiate(**options)
    return instance
