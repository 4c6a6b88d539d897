"""Many actuators that another simulator steps, in one call of the compiled libraries."""

import ctypes
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from elastic_tendon.actuator.interfaces import InterfaceKind
from elastic_tendon.actuator.parameters import Model
from elastic_tendon.actuator.variables import interface
from elastic_tendon.errors import SimulationError
from elastic_tendon.native.library import DEFAULT_TOLERANCE, EachStep, ListedActuator, load
from elastic_tendon.native.shared import TOLERANCES
from elastic_tendon.simulation.simulate import initial_state_of, library_parameters, reason

Array = NDArray[np.float64]

INPUTS = ("motor_position", "motor_velocity", "joint_position", "joint_velocity")


class _Call:
    """A call of the library for a share of the actuators, ready to be made again and again."""

    def __init__(
        self, each: Any, common: ctypes.Structure, share: tuple[int, NDArray[np.void]]
    ) -> None:
        self._each = each
        self._begin, self._listed = share
        self._outcome = ctypes.c_int()
        address = ctypes.c_void_p(self._listed.ctypes.data)
        length = ctypes.c_longlong(len(self._listed))
        self._arguments = (ctypes.byref(common), address, length, ctypes.byref(self._outcome))

    def __call__(self) -> tuple[int, int]:
        """Index of the first actuator that failed, else -1; and its outcome."""
        failed = self._each(*self._arguments)
        return (failed if failed < 0 else self._begin + failed), self._outcome.value


class Actuators:
    """Actuators at interface joint, stepped together by a simulator that has the links.

    Each call of `step` brings all to where motors and joints are now. In between, positions run
    as the cubics through the positions and velocities given, and what an actuator remembers
    (friction, hysteresis, relaxation) is integrated. They begin at time 0, all inputs zero.

    Parameters
    ----------
    models : at interface joint (``model.at("joint")``), with any effects
    threads : among which they are shared out; worth it from some hundred actuators on
    tolerance : relative, and absolute in units of the states' nominals; 1e-14 to 1e-2

    Attributes
    ----------
    output_names : what can be asked for, as in ``actuators["joint_torque"]``
    time : s since the start

    Raises
    ------
    ModelError
        for a model at another interface
    ValueError
        without models or threads, and for a tolerance outside its range
    """

    def __init__(
        self, models: Sequence[Model], *, threads: int = 1, tolerance: float = DEFAULT_TOLERANCE
    ) -> None:
        self.models = tuple(models)
        _check(self.models, threads, tolerance)
        outputs = [interface(*model.structure).output_names for model in self.models]
        self.output_names = min(outputs, key=len)  # others have readings of sensors behind these
        libraries = [load(*model.structure) for model in self.models]
        sizes = [_sizes(library) for library in libraries]
        memory_ends, constant_ends = np.cumsum([(0, 0), *sizes], axis=0).T
        n, width = len(self.models), len(self.output_names)
        self._constants = np.zeros(constant_ends[-1])
        # all that changes, beside the time: memories, outputs, inputs
        self._state = np.zeros(memory_ends[-1] + n * (width + len(INPUTS)))
        outputs_and_inputs = self._state[memory_ends[-1] :]
        self._outputs = outputs_and_inputs[: n * width].reshape(n, width)
        self._inputs = outputs_and_inputs[n * width :].reshape(n, len(INPUTS))
        self._columns = tuple(self._inputs.T)
        self._derivatives = np.zeros((n, width, len(INPUTS)))
        for model, library, (begin, end) in zip(
            self.models, libraries, pairwise(constant_ends), strict=True
        ):
            _prepare(model, library, self._constants[begin:end])
        listed = np.zeros(n, np.dtype(ListedActuator))
        listed["memory"] = self._state.ctypes.data + 8 * memory_ends[:-1]
        listed["constants"] = self._constants.ctypes.data + 8 * constant_ends[:-1]
        listed["input"] = _rows(self._inputs)
        each = libraries[0].elastic_tendon_each
        acts = {"start": self._outputs, "step": self._outputs, "derive": self._derivatives}
        self._common = EachStep(0.0, tolerance, width)
        self._calls = {
            act: [
                _Call(each, self._common, share)
                for share in _shares(_acting(listed, libraries, act, results), threads)
            ]
            for act, results in acts.items()
        }
        self._pool = ThreadPoolExecutor(min(n, threads)) if threads > 1 else None
        self.reset()

    def __len__(self) -> int:
        return len(self.models)

    def __getitem__(self, name: str) -> Array:
        """An output of all actuators now, (n,), SI."""
        if name not in self.output_names:
            raise KeyError(f"no output {name!r}; there are {', '.join(self.output_names)}")
        return self._outputs[:, self.output_names.index(name)].copy()

    def reset(
        self,
        motor_position: ArrayLike = 0.0,
        motor_velocity: ArrayLike = 0.0,
        joint_position: ArrayLike = 0.0,
        joint_velocity: ArrayLike = 0.0,
    ) -> None:
        """Start anew at time 0, with nothing remembered.

        Parameters
        ----------
        motor_position, motor_velocity, joint_position, joint_velocity : (n,) arrays or one number
            for all, rad and rad/s

        Raises
        ------
        SimulationError, ValueError
            as `step`
        """
        self._take(motor_position, motor_velocity, joint_position, joint_velocity)
        self._act("start")
        self.time = 0.0

    def step(
        self,
        duration: float,
        motor_position: ArrayLike,
        motor_velocity: ArrayLike,
        joint_position: ArrayLike,
        joint_velocity: ArrayLike,
    ) -> None:
        """Go on by `duration`, to where motors and joints are then.

        Parameters
        ----------
        duration : s, positive
        motor_position, motor_velocity, joint_position, joint_velocity : (n,) arrays or one number
            for all, rad and rad/s

        Raises
        ------
        SimulationError
            where an input is not finite or an actuator cannot go on; its name, the time and the
            reason are told. Then `restore` or `reset`, for others have gone on
        ValueError
            where an input has the wrong shape, or `duration` is not positive
        """
        if not duration > 0.0:
            raise ValueError(f"the step is {duration:g} s long; give a positive duration")
        self._take(motor_position, motor_velocity, joint_position, joint_velocity)
        self._act("step", duration)
        self.time += duration

    def derivatives(self) -> Array:
        """Derivatives of the outputs by the inputs now, what is remembered and slack as it is.

        Returns
        -------
        (n, n_outputs, 4) array, SI; outputs in the order of `output_names`, inputs in that of
        motor position, motor velocity, joint position, joint velocity
        """
        self._act("derive")
        return self._derivatives.copy()

    def stiffness_and_damping(self) -> tuple[Array, Array]:
        """By how much the joint torques fall with the joints' positions and velocities now.

        Returns
        -------
        (n,) array, N·m/rad, and (n,) array, N·m·s/rad
        """
        falling = -self.derivatives()[:, self.output_names.index("joint_torque"), :]
        by_position, by_velocity = (INPUTS.index(name) for name in INPUTS[2:])
        return falling[:, by_position], falling[:, by_velocity]

    def save(self) -> Array:
        """All that changes, in one array, for `restore` of actuators of the same models."""
        return np.append(self._state, self.time)

    def restore(self, saved: Array) -> None:
        """Go back to what `save` gave; raises ValueError for what other models have saved."""
        size = self._state.size
        if saved.shape != (size + 1,):
            raise ValueError(
                f"what was saved has shape {saved.shape}, but these {len(self)} actuators save "
                f"{size + 1} numbers; restore what actuators of the same models have saved"
            )
        self._state[:] = saved[:size]
        self.time = float(saved[size])

    def _take(self, *inputs: ArrayLike) -> None:
        for column, values in zip(self._columns, inputs, strict=True):
            # asked first, as numpy's own question takes longer than the step
            if type(values) is not np.ndarray or values.shape != column.shape:
                self._check_shapes(inputs)
            column[:] = values

    def _check_shapes(self, inputs: Sequence[ArrayLike]) -> None:
        for name, values in zip(INPUTS, inputs, strict=True):
            shape = np.shape(values)
            if shape not in ((), (len(self),)):
                raise ValueError(
                    f"{name} has shape {shape}, but there are {len(self)} actuators; give one "
                    "value for each"
                )

    def _act(self, act: str, duration: float = 0.0) -> None:
        self._common.duration = duration
        calls = self._calls[act]
        outcomes = self._pool.map(_Call.__call__, calls) if self._pool else [calls[0]()]
        for failed, outcome in outcomes:
            if failed >= 0:
                raise self._error(failed, outcome)

    def _error(self, index: int, outcome: int) -> SimulationError:
        which = f"actuator {index}, {self.models[index].name}"
        for name, value in zip(INPUTS, self._inputs[index], strict=True):
            if not np.isfinite(value):
                return SimulationError(
                    f"{which}: {name} is {value:g} after {self.time:.6g} s; the simulator that "
                    "moves it has perhaps become unstable: take shorter steps"
                )
        return SimulationError(f"{which}: {reason(outcome, self.time)}")


def _check(models: Sequence[Model], threads: int, tolerance: float) -> None:
    if not models:
        raise ValueError("there are no actuators; give one model at least")
    for model in models:
        model.check_interface("an actuator that another simulator steps", (InterfaceKind.JOINT,))
    if threads < 1:
        raise ValueError(f"{threads} threads cannot step; give 1 or more")
    if not TOLERANCES[0] <= tolerance <= TOLERANCES[1]:
        raise ValueError("tolerance {} is outside {:g} to {:g}".format(tolerance, *TOLERANCES))


def _sizes(library: ctypes.CDLL) -> tuple[int, int]:
    """Numbers that an actuator remembers, and that make it."""
    memory, constants = ctypes.c_longlong(), ctypes.c_longlong()
    library.elastic_tendon_actuator_sizes(ctypes.byref(memory), ctypes.byref(constants))
    return memory.value, constants.value


def _prepare(model: Model, library: ctypes.CDLL, constants: Array) -> None:
    """Write what makes an actuator: parameters, what follows from them, first states."""
    parameters, start = library_parameters(model), initial_state_of(model)
    constants[: len(parameters)] = parameters
    constants[len(constants) - len(start) :] = start
    library.elastic_tendon_actuator_prepare(ctypes.c_void_p(constants.ctypes.data))


def _rows(array: Array) -> NDArray[np.int64]:
    """Address of each row of an array."""
    rows: NDArray[np.int64] = array.ctypes.data + array.strides[0] * np.arange(len(array))
    return rows


def _acting(
    listed: NDArray[np.void], libraries: Sequence[ctypes.CDLL], act: str, results: Array
) -> NDArray[np.void]:
    """The actuators with what each does, and where its result goes."""
    acting = listed.copy()
    functions = [getattr(library, f"elastic_tendon_actuator_{act}") for library in libraries]
    acting["act"] = [ctypes.cast(function, ctypes.c_void_p).value for function in functions]
    acting["result"] = _rows(results)
    return acting


def _shares(listed: NDArray[np.void], threads: int) -> list[tuple[int, NDArray[np.void]]]:
    """Share of each thread, and the index at which it begins."""
    ends = np.linspace(0, len(listed), min(len(listed), threads) + 1).round().astype(int)
    return [(int(begin), listed[begin:end]) for begin, end in pairwise(ends)]
