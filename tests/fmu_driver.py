"""Drives an exported FMU through fmpy, the way an importer would, with inputs from samples."""

from collections.abc import Mapping, Sequence
from ctypes import c_double, c_uint, c_void_p
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Model, FMU2Slave, fmi2CallbackFunctions, fmi2CallbackLoggerTYPE
from fmpy.model_description import ModelDescription
from fmpy.sundials import CVodeSolver

from elastic_tendon.compiled import Array
from elastic_tendon.interpolation import Interpolation

DISCARD, ERROR = 2, 3  # fmi2Status


@dataclass
class Message:
    """One call of the logger."""

    instance: str
    status: int
    category: str
    text: str


@dataclass
class Instance:
    """An instance of the FMU with names instead of value references.

    `fmu` is fmpy's object; `log` collects the messages.
    """

    fmu: FMU2Model | FMU2Slave
    description: ModelDescription
    log: list[Message]
    callbacks: fmi2CallbackFunctions = field(repr=False)

    def __post_init__(self) -> None:
        self.variables = {one.name: one for one in self.description.modelVariables}

    def reference(self, name: str) -> int:
        """Value reference of a variable."""
        reference: int = self.variables[name].valueReference
        return reference

    def get(self, name: str) -> Any:
        """Value of a variable of any type."""
        variable = self.variables[name]
        getter = {"Real": self.fmu.getReal, "Boolean": self.fmu.getBoolean}.get(
            variable.type, self.fmu.getInteger
        )
        return getter([variable.valueReference])[0]

    def set(self, name: str, value: float) -> None:
        """Set a variable of any type."""
        variable = self.variables[name]
        setter = {"Real": self.fmu.setReal, "Boolean": self.fmu.setBoolean}.get(
            variable.type, self.fmu.setInteger
        )
        setter([variable.valueReference], [value])

    def everything(self) -> dict[str, Any]:
        """All values that can be read."""
        return {name: self.get(name) for name in self.variables}

    def set_rate(self, name: str, value: float) -> None:
        """Time derivative of an input."""
        self.fmu.setRealInputDerivatives([self.reference(name)], [1], [value])

    def derivative(
        self, unknowns: Sequence[str], knowns: Sequence[str], seed: Sequence[float]
    ) -> Array:
        """Directional derivative."""
        references = [[self.reference(name) for name in names] for names in (unknowns, knowns)]
        return np.array(self.fmu.getDirectionalDerivative(*references, list(seed)))

    def set_up(
        self,
        start: Mapping[str, float] | None = None,
        tolerance: float | None = None,
        start_time: float | None = 0.0,
        stop_time: float | None = None,
    ) -> None:
        """From instantiated to initialisation mode."""
        self.fmu.setupExperiment(tolerance=tolerance, startTime=start_time, stopTime=stop_time)
        for name, value in (start or {}).items():
            self.set(name, value)
        self.fmu.enterInitializationMode()

    def begin(self, start: Mapping[str, float] | None = None, **experiment: float | None) -> None:
        """From instantiated to between steps or, after event iteration, continuous time."""
        self.set_up(start, **experiment)
        self.fmu.exitInitializationMode()
        if isinstance(self.fmu, FMU2Model):
            self.iterate_events()

    def iterate_events(self) -> bool:
        """From event mode to continuous time; returns whether states jumped."""
        again = True
        while again:
            again, _, _, jumped, *_ = self.fmu.newDiscreteStates()
        self.fmu.enterContinuousTimeMode()
        return bool(jumped)

    def status(self, function: str, *arguments: Any) -> int:
        """Status of a call that may be illegal."""
        raw = self.fmu.dll[function]  # fmpy's own wrapper knows the functions of one interface only
        numbers = [c_double(one) if isinstance(one, float) else one for one in arguments]
        status: int = raw(c_void_p(self.fmu.component), *numbers)
        return status

    def snapshot(self) -> bytes:
        """Serialised state."""
        state = self.fmu.getFMUstate()
        data: bytes = self.fmu.serializeFMUstate(state)
        self.fmu.freeFMUstate(state)
        return data

    def restore(self, data: bytes) -> None:
        """Go back to a serialised state."""
        state = self.fmu.deSerializeFMUstate(data)
        self.fmu.setFMUstate(state)
        self.fmu.freeFMUstate(state)

    def free(self) -> None:
        """End the instance's life."""
        self.fmu.fmi2FreeInstance(self.fmu.component)


class Fmu:
    """An FMU file, unpacked."""

    def __init__(self, path: Path, folder: Path) -> None:
        self.path = path
        self.description = read_model_description(str(path))
        self.folder = extract(str(path), str(folder))

    def instantiate(
        self, kind: Any, name: str = "actuator", guid: str | None = None, logging: bool = False
    ) -> Instance:
        """A new instance: kind is FMU2Slave (co-simulation) or FMU2Model (model exchange)."""
        interface = (
            self.description.coSimulation if kind is FMU2Slave else self.description.modelExchange
        )
        fmu = kind(
            guid=guid or self.description.guid,
            unzipDirectory=self.folder,
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
        return Instance(fmu, self.description, log, callbacks)

    def slave(self, **options: Any) -> Instance:
        """A new instance for co-simulation; options of `instantiate`."""
        return self.instantiate(FMU2Slave, **options)

    def model(self, **options: Any) -> Instance:
        """A new instance for model exchange."""
        return self.instantiate(FMU2Model, **options)


@dataclass
class Segments:
    """Motor position piecewise constant or linear between samples, as polynomials in time."""

    time: Array
    position: Array
    linear: bool

    def __post_init__(self) -> None:
        rise = np.diff(self.position) / np.diff(self.time)
        # after the last sample the inputs stay
        self.slope = np.append(rise if self.linear else 0 * rise, 0.0)

    @property
    def interpolation(self) -> Interpolation:
        """Name of the same in `simulate`."""
        return "linear" if self.linear else "hold"


def run_co_simulation(
    instance: Instance, segments: Segments, name: str = "joint_position", *, tolerance: float
) -> Array:
    """Steps from sample to sample; the output at each sample, with the inputs that begin there."""
    result = []
    time, position, slope = segments.time, segments.position, segments.slope
    instance.begin({"motor_position": position[0]}, tolerance=tolerance)
    now = time[0]
    for i in range(len(time)):
        instance.set("motor_position", position[i])
        instance.set_rate("motor_position", slope[i])
        result.append(instance.get(name))
        if i + 1 < len(time):
            instance.fmu.doStep(now, time[i + 1] - now)
            now = time[i + 1]
    return np.array(result)


class _Input:
    """What CVodeSolver asks to apply inputs; the velocity goes along, for models that need it."""

    def __init__(self, instance: Instance, segments: Segments) -> None:
        names = ("motor_position", "motor_velocity")
        self._set = instance.fmu.fmi2SetReal
        self._component = instance.fmu.component
        self._references = (c_uint * 2)(*map(instance.reference, names))
        self._values = (c_double * 2)()
        self._segments = segments
        self.segment = 0

    def apply(self, time: float) -> None:
        """Set position and velocity at a time in the present segment, s."""
        s, i = self._segments, self.segment
        self._values[0] = s.position[i] + s.slope[i] * (time - s.time[i])
        self._values[1] = s.slope[i]
        self._set(self._component, self._references, 2, self._values)


class _Solver(CVodeSolver):  # type: ignore[misc]
    """CVode as in fmpy, which applies the inputs for event indicators only, not for rates."""

    def f(self, t: float, y: Any, ydot: Any, user_data: Any) -> Any:
        """Rates at a time, with the inputs of that time."""
        self.input.apply(t)
        return super().f(t, y, ydot, user_data)


def run_model_exchange(
    instance: Instance, segments: Segments, name: str = "joint_position", *, tolerance: float
) -> tuple[Array, int]:
    """Integrates with CVode; every sample is an input event. Output at the samples, event count."""
    fmu = instance.fmu
    inputs = _Input(instance, segments)
    time = segments.time
    start = {"motor_position": segments.position[0], "motor_velocity": segments.slope[0]}
    instance.begin({"motor_velocity_connected": True} | start)
    solver = _Solver(
        nx=instance.description.numberOfContinuousStates,
        nz=instance.description.numberOfEventIndicators,
        get_x=fmu.getContinuousStates,
        set_x=fmu.setContinuousStates,
        get_dx=fmu.getDerivatives,
        get_z=fmu.getEventIndicators,
        get_nominals=fmu.getNominalsOfContinuousStates,
        set_time=fmu.setTime,
        input=inputs,
        startTime=time[0],
        relativeTolerance=tolerance,
        maxNumSteps=100000,
    )
    events = 0
    result = [instance.get(name)]
    for i in range(len(time) - 1):
        now = time[i]
        while now < time[i + 1]:
            event, _, now = solver.step(now, time[i + 1])
            fmu.setTime(now)
            inputs.apply(now)
            if event and now < time[i + 1]:
                events += 1
                fmu.enterEventMode()
                instance.iterate_events()
                solver.reset(now)
        inputs.segment = i + 1
        fmu.enterEventMode()
        inputs.apply(now)
        instance.iterate_events()
        solver.reset(now)
        result.append(instance.get(name))
    return np.array(result), events
