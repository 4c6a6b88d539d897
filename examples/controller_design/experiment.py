"""A controller and the actuator's FMU in a loop, sample by sample, through fmpy."""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import control
import fmpy
import numpy as np
from design import ENCODER, JOINT, MOTOR, SAMPLE, Design, origin

from elastic_tendon import LinearModel, SlackState

Signals = dict[str, np.ndarray]


@dataclass(frozen=True)
class Scenario:
    """What the joint shall do, and what it bears.

    Attributes
    ----------
    reference : position (rad) and its first three derivatives at a time
    load : N·m at a time
    event : s, when something steps; None: nothing does
    step : whether it is the reference
    """

    name: str
    reference: Callable[[float], np.ndarray]
    load: Callable[[float], float]
    event: float | None = None
    step: bool = False
    duration: float = 2.0


class Actuator:
    """The FMU, from the motor's velocity and the load to where joint and motor are."""

    def __init__(self, unzipped: Path, motor_position: float, load: float) -> None:
        description = fmpy.read_model_description(unzipped)
        self.variable = {one.name: one.valueReference for one in description.modelVariables}
        self.fmu = fmpy.instantiate_fmu(unzipped, description, "CoSimulation")
        self.motor_position, self.time = motor_position, 0.0
        self.fmu.setupExperiment()
        self.fmu.enterInitializationMode()
        self._set(load)
        self.fmu.exitInitializationMode()

    def _set(self, load: float) -> None:
        names = [self.variable["motor_position"], self.variable["load_torque"]]
        self.fmu.setReal(names, [self.motor_position, load])

    def slack_state(self) -> SlackState:
        return SlackState(self.fmu.getInteger([self.variable["slack_state"]])[0])

    def positions(self) -> np.ndarray:
        return np.array(
            [self.fmu.getReal([self.variable["joint_position"]])[0], self.motor_position]
        )

    def step(self, motor_velocity: float, load: float) -> None:
        """One sample in which the motor runs with this velocity: its position is a ramp."""
        self._set(load)
        self.fmu.setRealInputDerivatives([self.variable["motor_position"]], [1], [motor_velocity])
        self.fmu.doStep(self.time, SAMPLE)
        self.time += SAMPLE
        self.motor_position += SAMPLE * motor_velocity

    def close(self) -> None:
        self.fmu.terminate()
        self.fmu.freeInstance()


class LinearActuator:
    """The same, by the linear model of one state."""

    def __init__(self, plant: LinearModel) -> None:
        self.state, self.origin = plant.validity.slack_state, origin(plant)
        self.plant = control.c2d(plant, SAMPLE)
        self.x = np.zeros(3)

    def slack_state(self) -> SlackState:
        return self.state

    def positions(self) -> np.ndarray:
        return self.plant.C @ self.x + self.origin[[JOINT, MOTOR]]

    def step(self, motor_velocity: float, load: float) -> None:
        u = np.array([motor_velocity, load - self.origin[3]])
        self.x = self.plant.A @ self.x + self.plant.B @ u


def run(
    actuator: Actuator | LinearActuator, design: Design, scenario: Scenario, delay: int = 0
) -> Signals:
    """Run a design in a scenario, from rest, with the joint at 0.

    The controller is that of the slack state at each sample; what it has observed is kept.
    `delay`: samples by which commands come late.
    """
    under_way = deque([0.0] * delay)
    x = design[actuator.slack_state()].at_rest(actuator.positions()[1])
    rows = []
    for time in SAMPLE * np.arange(round(scenario.duration / SAMPLE)):
        positions, state = actuator.positions(), actuator.slack_state()
        controller, reference = design[state], scenario.reference(time)
        u = controller.command(x, reference)
        x = controller.observe(x, u, ENCODER * np.round(positions / ENCODER))
        rows.append((time, reference[0], *positions, u, state.value))
        under_way.append(u)
        actuator.step(under_way.popleft(), scenario.load(time))
    names = ("time", "reference", "joint", "motor", "motor_velocity", "slack_state")
    return dict(zip(names, np.array(rows).T, strict=True))


@dataclass(frozen=True)
class Tracking:
    """How well the joint followed: errors in rad, the motor's largest velocity in rad/s.

    `peak` is the largest error, after a step of the reference the overshoot. `settled`: s from
    the event until the error stays small; None: not before the end.
    """

    rms: float
    peak: float
    settled: float | None
    fastest: float


def tracking(signals: Signals, scenario: Scenario, small: float = 2e-3) -> Tracking:
    """How well the joint followed in a scenario; an error below `small` (rad) is settled."""
    error = signals["joint"] - signals["reference"]
    large = np.flatnonzero(np.abs(error) > small)
    settled = None
    if scenario.event is not None and large.size and large[-1] + 1 < error.size:
        settled = float(signals["time"][large[-1] + 1] - scenario.event)
    return Tracking(
        rms=float(np.sqrt(np.mean(error**2))),
        peak=float(error.max() if scenario.step else np.abs(error).max()),
        settled=settled,
        fastest=float(np.abs(signals["motor_velocity"]).max()),
    )
