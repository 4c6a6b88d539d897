"""The plant of an FMU, through its directional derivatives, and its linear models."""

import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastic_tendon.actuator.motion_kind import MotionKind
from elastic_tendon.actuator.sections import Motor
from elastic_tendon.actuator.system import HYSTERESIS
from elastic_tendon.actuator.transmission import SlackState
from elastic_tendon.actuator.variables import JOINT_MOTION
from elastic_tendon.errors import LinearisationError
from elastic_tendon.linear.boundaries import sides
from elastic_tendon.linear.equilibrium import JOINT_POSITION, JOINT_VELOCITY, Point
from elastic_tendon.linear.fmu_variables import (
    INPUT_NAMES,
    STARTING,
    VELOCITY_USED,
    check_names,
    check_start_values,
    mode_places,
    transmission_of,
)
from elastic_tendon.linear.linearise import (
    linear_model,
    moving,
    operating_point_of,
)
from elastic_tendon.linear.model_exchange import Instance, opened
from elastic_tendon.linear.names import slack_state, state_name
from elastic_tendon.linear.plant import Jacobians, Regime
from elastic_tendon.linear.result import Array, Drive, LinearModel, OperatingPoint
from elastic_tendon.linear.selection import selected

_REAL = {2: "Real", 3: "Float64"}
# a velocity against the motion that is not yet one, but beyond the dead band that keeps it sliding
_RELEASING = 0.75 * HYSTERESIS


def linearise_fmu(
    path: str | os.PathLike[str],
    state: SlackState | str,
    operating_point: OperatingPoint | None = None,
    *,
    drive: Drive = Drive.SOURCE,
    inputs: Sequence[str] | None = None,
    outputs: Sequence[str] | None = None,
    start_values: Mapping[str, float] | None = None,
    motor: Motor | None = None,
) -> LinearModel:
    """Linear model of an FMU of this software in a slack state, as `linearise` has it of a model.

    The FMU is linearised where it is, so the state has to be active at the operating point, or on
    one side of it. `motor_velocity_connected` is set. Modes of FMI 3.0 have the names of their
    event indicators; those of FMI 2.0 too, where all effects of the FMU are known, else
    ``indicator_1``, ``indicator_2``...

    Parameters
    ----------
    path : of an FMU of FMI 2.0 or 3.0 with model exchange, by `export_fmu`
    state : "I", "II", "III", "both" or a SlackState
    operating_point : where to linearise; None: as of `linearise`
    drive : what moves the motor; `Drive.TORQUE` needs `motor`, which no FMU has
    inputs, outputs : names in the order wanted; None: all that the drive has
    start_values : of parameters, by dotted path, SI units; None: those of the FMU
    motor : rotor, at the motor pulley

    Returns
    -------
    LinearModel

    Raises
    ------
    LinearisationError
        for a file that is no such FMU, where there is no such equilibrium, name or motor, and where
        the state is not active at the operating point
    """
    wanted = slack_state(state)
    if drive is Drive.TORQUE and motor is None:
        raise LinearisationError(
            f"{Path(path).name}: an FMU has no rotor; give the motor in Python, or linearise the "
            "model.toml it was made from, with [motor]"
        )
    with fmu_plant(path, start_values or {}) as plant:
        point = operating_point_of(
            plant, operating_point, lambda regime: regime.slack_state is wanted
        )
        regime = moving(plant, point, _regime_in(plant, point, wanted))
        whole = linear_model(plant, point, regime, True, drive, motor)
    return selected(whole, inputs, outputs)


@contextmanager
def fmu_plant(
    path: str | os.PathLike[str], start_values: Mapping[str, float]
) -> Iterator["FmuPlant"]:
    """The plant of an FMU, which is freed at the end.

    Raises
    ------
    LinearisationError
        for a file that is no FMU of this software
    """
    with opened(path) as instance:
        check_names(instance)
        check_start_values(instance, start_values)
        yield FmuPlant(instance, start_values)


class FmuPlant:
    """`Plant` of an FMU for model exchange.

    Modes are what the signs of the event indicators say. An FMU holds them between events, so it
    is brought into a regime by an event at `Regime.reached_at`, and moved from there.
    """

    def __init__(self, instance: Instance, start_values: Mapping[str, float]) -> None:
        """Initialise the FMU with its own or other start values of parameters.

        Raises
        ------
        LinearisationError
            for a start value that the FMU refuses
        """
        self.name = instance.name
        self.states = instance.states
        slides = instance.variables[self.states[JOINT_POSITION]].unit == "m"
        self.motion = MotionKind.LINEAR if slides else MotionKind.ROTARY
        self.outputs = tuple(
            output.variable.name
            for output in instance.description.outputs
            if output.variable.type == _REAL[instance.version]
        )
        self._instance = instance
        self._start = {**start_values, VELOCITY_USED: 1.0}
        self._held: Regime | None = None
        # whether the joint slides is kept from event to event, so there is a start of each motion
        self._started = {direction: self._starting(direction) for direction in (-1, 1)}
        self._places = mode_places(instance)  # at the start upwards
        self.transmission = transmission_of(instance)
        self.nominal = np.array(
            [float(instance.variables[state].nominal or 1.0) for state in self.states]
        )

    def start(self, u: Array, joint_position: float) -> Array:
        """States at rest, as the FMU starts them."""
        at = {**dict(zip(INPUT_NAMES, u, strict=True)), self.states[JOINT_POSITION]: joint_position}
        self._held = None
        self._instance.initialise(self._start | at)
        return self._instance.position()

    def settle(self, x: Array, u: Array) -> Regime:
        """The regime that is active at a point."""
        return self._reached(x, u, int(np.sign(x[JOINT_VELOCITY])))

    def sliding(self, regime: Regime, direction: int) -> Regime:
        """The regime with dry friction of the joint sliding: 1 up, -1 down; 0: sticking."""
        if JOINT_MOTION.name not in regime.modes:
            return regime
        return self._reached(*regime.reached_at, direction)

    def rates(self, x: Array, u: Array, regime: Regime) -> Array:
        """Time derivatives (n,) of the states, the regime held."""
        self._hold(x, u, regime)
        return self._instance.rates()

    def output(self, x: Array, u: Array, regime: Regime) -> Array:
        """Outputs (m,), the regime held."""
        self._hold(x, u, regime)
        return self._instance.get_reals(self.outputs)

    def jacobians(self, x: Array, u: Array, regime: Regime) -> Jacobians:
        """Derivatives, the regime held."""
        self._hold(x, u, regime)
        n = len(self.states)
        unknowns = [*self._instance.derivatives, *self.outputs]
        columns = [
            self._instance.derivative(unknowns, variable)
            for variable in (*self.states, *INPUT_NAMES)
        ]
        by = np.column_stack(columns)
        return Jacobians(by[:n, :n], by[:n, n:], by[n:, :n], by[n:, n:])

    def _starting(self, direction: int) -> Any:
        """State of the FMU with its joint in motion."""
        velocity = {self.states[JOINT_VELOCITY]: direction * STARTING}
        self._instance.initialise(self._start | velocity)
        self._instance.settle()
        return self._instance.state()

    def _reached(self, x: Array, u: Array, direction: int) -> Regime:
        """The regime that an event at a point leads to, the joint moving in a direction."""
        self._enter(x, u, direction)
        self._move(x, u)
        positive = self._instance.indicators() > 0.0
        modes = {name: _mode(positive[list(at)]) for name, at in self._places.items()}
        slack = SlackState(int(self._instance.get("slack_state")))
        self._held = Regime(slack, modes, (x.copy(), u.copy()))
        return self._held

    def _hold(self, x: Array, u: Array, regime: Regime) -> None:
        """Bring the FMU into a regime, and move it to a point."""
        if regime is not self._held:
            self._enter(*regime.reached_at, regime.modes.get(JOINT_MOTION.name, 0))
            self._held = regime
        self._move(x, u)

    def _enter(self, x: Array, u: Array, direction: int) -> None:
        """Handle an event with the joint moving up (1), down (-1), or as it must (0).

        At rest sliding is kept up, so a joint that may stick is released in a second event, when
        the other modes are right already.
        """
        self._held = None
        self._instance.restore(self._started[direction or 1])
        reached = x.copy()
        velocities = [x[JOINT_VELOCITY]]
        if direction:
            velocities = [direction * max(direction * x[JOINT_VELOCITY], 0.0)]
        elif velocities == [0.0]:
            velocities = [0.0, -_RELEASING]
        for velocity in velocities:
            reached[JOINT_VELOCITY] = velocity
            self._move(reached, u)
            self._instance.handle_event()

    def _move(self, x: Array, u: Array) -> None:
        self._instance.move(x)
        self._instance.set_reals(INPUT_NAMES, u)


def _regime_in(plant: FmuPlant, point: Point, wanted: SlackState) -> Regime:
    """The regime at a point, or on one side of it, that has a slack state."""
    if point.regime.slack_state is wanted:
        return point.regime
    for side in sides(plant, point):
        if side.regime.slack_state is wanted:
            return side.regime
    active = state_name(point.regime.slack_state)
    raise LinearisationError(
        f"{plant.name}: the FMU is in state {active} there, and an FMU is linearised where it is; "
        f"give an operating point in state {state_name(wanted)}"
    )


def _mode(positive: NDArray[np.bool_]) -> int:
    """Value of a mode by the signs of its indicators; with two it is the sign of a motion."""
    return int(positive[0]) - int(positive[1]) if len(positive) > 1 else int(positive[0])
