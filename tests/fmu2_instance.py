"""Instances of FMI 2.0."""

from collections.abc import Callable, Mapping, Sequence
from ctypes import c_double, c_int, c_uint
from typing import Any, ClassVar

import numpy as np
from fmpy.fmi2 import FMU2Model, FMU2Slave, fmi2CallbackFunctions, fmi2CallbackLoggerTYPE
from fmpy.model_description import ModelDescription

from elastic_tendon.simulation.simulate import Array
from fmu_instance import Call, EventInfo, Instance, Message


class Instance2(Instance):
    """An instance of FMI 2.0."""

    version: ClassVar[int] = 2
    number: ClassVar[str] = "Real"
    access: ClassVar[Mapping[str, tuple[str, Any]]] = {
        "Real": ("Real", c_double),
        "Integer": ("Integer", c_int),
        "Enumeration": ("Integer", c_int),
        "Boolean": ("Boolean", c_int),
    }

    @property
    def is_slave(self) -> bool:
        """Whether it is for co-simulation."""
        return isinstance(self.fmu, FMU2Slave)

    def set_rate(self, name: str, value: float) -> None:
        """Time derivative of an input."""
        self.fmu.setRealInputDerivatives([self.reference(name)], [1], [value])

    def output_derivatives(self, names: Sequence[str]) -> Array:
        """First derivatives of outputs by time."""
        references = self.references(names)
        return np.array(self.fmu.getRealOutputDerivatives(references, [1] * len(names)))

    def set_up(
        self,
        start: Mapping[str, float] | None = None,
        tolerance: float | None = None,
        start_time: float = 0.0,
        stop_time: float | None = None,
    ) -> None:
        """From instantiated to initialisation mode."""
        self.fmu.setupExperiment(tolerance=tolerance, startTime=start_time, stopTime=stop_time)
        for name, value in (start or {}).items():
            self.set(name, value)
        self.fmu.enterInitializationMode()

    def iterate_events(self) -> EventInfo:
        """From event mode to continuous time."""
        again, calls = True, 0
        while again:
            again, terminate, nominals, jumped, defined, time = self.fmu.newDiscreteStates()
            calls += 1
        self.fmu.enterContinuousTimeMode()
        next_time = time if defined else None
        return EventInfo(calls, bool(jumped), bool(nominals), bool(terminate), next_time)

    def rates_of_states(self) -> Callable[..., Any]:
        """The function that gets the derivatives of the states."""
        function: Callable[..., Any] = self.fmu.getDerivatives
        return function

    def advance(self, time: float, h: float) -> None:
        """A step that is taken."""
        self.fmu.doStep(time, h)

    def free(self) -> None:
        """End the instance's life."""
        self.fmu.fmi2FreeInstance(self.fmu.component)

    def get_state(self) -> Any:
        """The state, kept in the FMU's memory."""
        return self.fmu.getFMUstate()

    def set_state(self, state: Any) -> None:
        """Go back to a state."""
        self.fmu.setFMUstate(state)

    def free_state(self, state: Any) -> None:
        """Forget a state."""
        self.fmu.freeFMUstate(state)

    def serialise(self, state: Any) -> bytes:
        """Bytes of a state."""
        data: bytes = self.fmu.serializeFMUstate(state)
        return data

    def deserialise(self, data: bytes) -> Any:
        """State of bytes."""
        return self.fmu.deSerializeFMUstate(data)

    def getting(self, reference: int, suffix: str | None = None) -> Call:
        """Call that gets a value."""
        return self.call(
            f"Get{suffix or self.number}", (c_uint * 1)(reference), 1, (c_double * 1)()
        )

    def setting(self, names: Sequence[str], values: Sequence[Any], suffix: str = "") -> Call:
        """Call that sets values of variables."""
        references, given = self._arrays(names, values, suffix)
        return self.call(f"Set{suffix or self.number}", references, len(names), given)

    def stepping(self, time: float, h: float) -> Call:
        """Call that takes a step."""
        return self.call("DoStep", time, h, 1)

    def differentiating(self, unknowns: Sequence[str], knowns: Sequence[str]) -> Call:
        """Call that gets a directional derivative along ones."""
        vectors = self._arrays(unknowns, [0.0] * len(unknowns), "")
        others = self._arrays(knowns, [1.0] * len(knowns), "")
        return self.call(
            "GetDirectionalDerivative",
            *(vectors[0], len(unknowns), others[0], len(knowns), others[1], vectors[1]),
        )


def instantiate2(
    description: ModelDescription,
    folder: str,
    *,
    slave: bool,
    name: str,
    token: str,
    logging: bool,
) -> Instance2:
    """A new instance for co-simulation or model exchange."""
    interface = description.coSimulation if slave else description.modelExchange
    fmu = (FMU2Slave if slave else FMU2Model)(
        guid=token,
        unzipDirectory=folder,
        modelIdentifier=interface.modelIdentifier,
        instanceName=name,
    )
    log: list[Message] = []

    def logger(
        _environment: Any, instance: bytes, status: int, category: bytes, message: bytes
    ) -> None:
        texts = [(one or b"").decode() for one in (instance, category, message)]
        log.append(Message(texts[0], status, *texts[1:]))

    callbacks = fmi2CallbackFunctions()
    callbacks.logger = fmi2CallbackLoggerTYPE(logger)
    fmu.instantiate(callbacks=callbacks, loggingOn=logging)
    return Instance2(fmu, description, log, callbacks)
