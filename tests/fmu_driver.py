"""Drives an exported FMU through fmpy, the way an importer would, with inputs from samples."""

from collections.abc import Sequence
from ctypes import c_double, c_uint
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from fmpy import extract, read_model_description
from fmpy.sundials import CVodeSolver

from elastic_tendon.native.interpolation import Interpolation
from elastic_tendon.simulation.simulate import Array
from fmu2_instance import instantiate2
from fmu3_instance import instantiate3
from fmu_instance import DISCARD, ERROR, OK, WARNING, Instance, Message

__all__ = [
    "DISCARD",
    "ERROR",
    "OK",
    "WARNING",
    "Fmu",
    "Instance",
    "Message",
    "Segments",
    "run_co_simulation",
    "run_model_exchange",
]


class Fmu:
    """An FMU file, unpacked."""

    def __init__(self, path: Path, folder: Path) -> None:
        self.path = path
        self.description = read_model_description(str(path))
        self.folder = extract(str(path), str(folder))
        self.version = int(self.description.fmiVersion[0])

    def _instantiate(
        self,
        *,
        slave: bool,
        name: str = "actuator",
        token: str | None = None,
        logging: bool = True,
        **options: Any,
    ) -> Any:  # Instance2 or Instance3: tests use what one of them alone has
        instantiate: Any = instantiate2 if self.version == 2 else instantiate3
        token = self.description.guid if token is None else token
        options |= {"slave": slave, "name": name, "token": token, "logging": logging}
        return instantiate(self.description, self.folder, **options)

    def slave(self, **options: Any) -> Any:
        """A new instance for co-simulation, with options of its version's `instantiate`."""
        return self._instantiate(slave=True, **options)

    def model(self, **options: Any) -> Any:
        """A new instance for model exchange."""
        return self._instantiate(slave=False, **options)


@dataclass
class Segments:
    """Motor position, or what else drives, piecewise constant or linear between samples."""

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
    instance: Any,
    segments: Segments,
    name: str = "joint_position",
    *,
    tolerance: float | None,
    connected: bool = True,
    driven: str = "motor_position",
) -> Array:
    """Steps from sample to sample; the output at each sample, with the inputs that begin there.

    A velocity that is `connected` is that of a held position, 0. `driven` : input that is moved.
    """
    result = []
    time, position, slope = segments.time, segments.position, segments.slope
    start = {driven: position[0]}
    if connected and not segments.linear:
        start["motor_velocity_connected"] = True
    instance.begin(start, tolerance=tolerance)
    now = time[0]
    for i in range(len(time)):
        instance.set(driven, position[i])
        if segments.linear:
            instance.set_rate(driven, slope[i])
        result.append(instance.get(name))
        if i + 1 < len(time):
            instance.advance(now, time[i + 1] - now)
            now = time[i + 1]
    return np.array(result)


class _Input:
    """What CVodeSolver asks to apply inputs; the velocity goes along, for models that need it."""

    def __init__(self, instance: Instance, segments: Segments, names: Sequence[str]) -> None:
        n = len(names)
        self._values = (c_double * n)()
        arguments = ((c_uint * n)(*instance.references(names)), n, self._values, n)
        self._arguments = arguments[: 3 if instance.version == 2 else 4]
        self._set = getattr(instance.fmu, f"fmi{instance.version}Set{instance.number}")
        self._component = instance.fmu.component
        self._segments = segments
        self.segment = 0

    def apply(self, time: float) -> None:
        """Set position and velocity at a time in the present segment, s."""
        s, i = self._segments, self.segment
        along = [s.position[i] + s.slope[i] * (time - s.time[i]), s.slope[i]]
        self._values[:] = along[: len(self._values)]
        self._set(self._component, *self._arguments)


class _Solver(CVodeSolver):  # type: ignore[misc]
    """CVode as in fmpy, which applies the inputs for event indicators only, not for rates."""

    def f(self, t: float, y: Any, ydot: Any, user_data: Any) -> Any:
        """Rates at a time, with the inputs of that time."""
        self.input.apply(t)
        return super().f(t, y, ydot, user_data)


def run_model_exchange(
    instance: Instance,
    segments: Segments,
    name: str = "joint_position",
    *,
    tolerance: float,
    connected: bool = True,
    driven: str = "motor_position",
) -> tuple[Array, list[float]]:
    """Integrates with CVode; every sample is an input event. Output at the samples, event times."""
    fmu = instance.fmu
    time = segments.time
    start: dict[str, float] = {driven: segments.position[0]}
    if driven == "motor_position":
        start["motor_velocity"] = segments.slope[0]
    inputs = _Input(instance, segments, list(start))
    instance.begin(start | ({"motor_velocity_connected": True} if connected else {}))
    solver = _Solver(
        nx=instance.description.numberOfContinuousStates,
        nz=instance.description.numberOfEventIndicators,
        get_x=fmu.getContinuousStates,
        set_x=fmu.setContinuousStates,
        get_dx=instance.rates_of_states(),
        get_z=fmu.getEventIndicators,
        get_nominals=fmu.getNominalsOfContinuousStates,
        set_time=fmu.setTime,
        input=inputs,
        startTime=time[0],
        relativeTolerance=tolerance,
        maxNumSteps=100000,
    )
    events = []
    result = [instance.get(name)]
    now = time[0]
    for i in range(len(time) - 1):
        while now < time[i + 1]:
            event, _, now = solver.step(now, time[i + 1])
            fmu.setTime(now)
            inputs.apply(now)
            if event and now < time[i + 1]:
                events.append(now)
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
