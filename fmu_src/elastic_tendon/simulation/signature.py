"""What an effect looks like: the same three experiments on a machine with it and without.

A slow load on the joint while the motor is held; a fast swing of the motor without load; a step of
the motor without load. Each effect of the catalogue shows in one of them at least, and where it
does not show says as much about it.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.distance import directed_hausdorff

from elastic_tendon.actuator.design import DesignTable, design
from elastic_tendon.actuator.interfaces import InterfaceKind
from elastic_tendon.actuator.parameters import Model, typical_value
from elastic_tendon.effects.base import Effect
from elastic_tendon.simulation.simulate import Trajectory, driving_torque, simulate

Array = NDArray[np.float64]

SAMPLES = 6000  # of an experiment
SLOW, FAST = 0.004, 0.35  # shares of the natural frequency with both tendons taut
LOAD = 0.95  # of the largest torque: far beyond the slack boundaries
SWING = 0.8  # rad at the joint
SETTLING, SHOWN = 12, 2  # swings of the motor before those that are shown, and these
STEP, RISE = 0.3, 0.02  # rad at the joint, s
REST, BEFORE, AFTER = 3.0, 0.1, 1.2  # s: rest before the step; what is shown before and after it

FACTORS = (1.0, 3.0, 10.0)  # times typical, of which the first that is visible is taken
VISIBLE = 0.075  # distance between two curves that anyone sees, as a share of the axes
HIDDEN = 0.01  # ... that hardly anyone sees


@dataclass(frozen=True)
class Curve:
    """Something over something else: arrays (n,), units as `Signature` says."""

    x: Array
    y: Array


@dataclass(frozen=True)
class Beside:
    """The same experiment on the machine `without` the effect and on that `with_it`."""

    without: Curve
    with_it: Curve

    @property
    def difference(self) -> float:
        """Largest distance from a point of one curve to the other, as a share of the axes."""
        bare, full = (np.column_stack((curve.x, curve.y)) for curve in (self.without, self.with_it))
        size = np.ptp(np.vstack((bare, full)), axis=0)
        bare, full = bare / size, full / size
        return float(max(directed_hausdorff(bare, full)[0], directed_hausdorff(full, bare)[0]))


@dataclass(frozen=True)
class Signature:
    """How an effect shows on the model named `example`, as the sensors read it.

    `slow_loop`: load torque (N·m) over deflection (rad), the motor held. `fast_loop`: torque of
    the tendons on the joint (N·m), see `_read_torque`, over deflection (rad), the motor swinging.
    `step`: joint position (rad) over time (s) beside `motor`, the motor position reflected to the
    joint (rad).
    `numbers` are the effect's by name, its strength `times_typical` the typical one.
    `slack_boundaries` (rad) are those without the effect.
    """

    effect: Effect
    example: str
    numbers: Mapping[str, float]
    times_typical: float
    slow_loop: Beside
    fast_loop: Beside
    step: Beside
    motor: Curve
    slack_boundaries: tuple[float, float]

    @property
    def experiments(self) -> tuple[str, str, str]:
        """What is done in each, in words."""
        if InterfaceKind.POSITION.has_slot(self.effect.slot):
            return "slow load, motor held", "fast motor swing, no load", "motor step, no load"
        return (
            "slow load, torque that would hold the motor",
            "fast swing of the motor torque, no load",
            "torque of a motor step, no load",
        )

    @property
    def difference(self) -> float:
        """Largest difference in any of the experiments, as a share of the axes."""
        return max(beside.difference for beside in (self.slow_loop, self.fast_loop, self.step))


def shown_on(effect: Effect, example: Model) -> Model:
    """The example at the interface at which an effect shows: a torque drives its rotor."""
    return example if example.kind.has_slot(effect.slot) else example.at(InterfaceKind.TORQUE)


def signature(effect: Effect, example: Model) -> Signature:
    """Run the experiments on a model without effects and on the same with one.

    Parameters
    ----------
    effect : Effect; at its typical values, or stronger where these would hardly be seen
    example : Model without effects at interface position; with [motor] for effects on the rotor,
        which is then driven by the torque under which it would move so without the effect

    Returns
    -------
    Signature

    Raises
    ------
    SimulationError, BuildError
        where an experiment cannot be simulated
    """
    signatures = (_signature(effect, example, factor) for factor in FACTORS)
    return next(
        response
        for response in signatures
        if response.difference >= VISIBLE or response.times_typical == FACTORS[-1]
    )


def _signature(effect: Effect, example: Model, times_typical: float) -> Signature:
    table = design(example)
    numbers = _numbers(effect, example, times_typical)
    bare = shown_on(effect, example)
    machines = (bare, bare.with_effect(effect.id, numbers))
    slow, fast, step = (
        [_record(machine, example, experiment) for machine in machines]
        for experiment in (_slow_load(table), _fast_swing(table), _step())
    )
    return Signature(
        effect=effect,
        example=example.name,
        numbers=numbers,
        times_typical=times_typical,
        slow_loop=Beside(*(Curve(run.deflection, run.load_torque) for run in slow)),
        fast_loop=Beside(*(Curve(run.deflection, run.joint_torque) for run in fast)),
        step=Beside(*(Curve(run.time, run.joint_position) for run in step)),
        motor=Curve(step[0].time, step[0].motor_position),
        slack_boundaries=(table.negative_slack_boundary, table.positive_slack_boundary),
    )


def _numbers(effect: Effect, example: Model, times_typical: float) -> dict[str, float]:
    """Typical numbers, those that say how strong the effect is multiplied, inside the bounds."""
    numbers = {}
    for parameter in effect.parameters:
        factor = 1.0 if parameter.shape else times_typical
        numbers[parameter.name] = min(
            max(factor * typical_value(example, parameter), parameter.lower), parameter.upper
        )
    return numbers


# ---- experiments ---------------------------------------------------------------------------


@dataclass(frozen=True)
class _Experiment:
    """What is done: arrays (n,), the motor position (rad) as it counts at the joint.

    It is shown from the time `start` (s) on.
    """

    time: Array
    motor_position: Array
    load_torque: Array
    start: float


@dataclass(frozen=True)
class _Record:
    """What is shown of an experiment and of what the sensors read, arrays (n,), SI units."""

    time: Array
    motor_position: Array
    load_torque: Array
    joint_position: Array
    joint_torque: Array

    @property
    def deflection(self) -> Array:
        """Measured joint position less reflected motor position, (n,) array, rad."""
        return self.joint_position - self.motor_position


def _slow_load(table: DesignTable) -> _Experiment:
    """A cycle of the load through both slack states, after half a one."""
    largest = min(abs(table.negative_max_torque), abs(table.positive_max_torque))
    frequency = SLOW * table.frequency_state_3
    time = _time(-np.pi / frequency, 2.0 * np.pi / frequency)
    load = LOAD * largest * np.sin(frequency * time)
    return _Experiment(time, np.zeros_like(time), load, start=0.0)


def _fast_swing(table: DesignTable) -> _Experiment:
    """Swings of the motor, when they have faded in and settled."""
    frequency = FAST * table.frequency_state_3
    period = 2.0 * np.pi / frequency
    time = _time(-SETTLING * period, SHOWN * period)
    fade = np.minimum(1.0, 2.0 + 2.0 * time / (SETTLING * period))
    swing = SWING * fade * np.sin(frequency * time)
    return _Experiment(time, swing, np.zeros_like(time), start=0.0)


def _step() -> _Experiment:
    """A step of the motor at 0, after a rest in which the joint settles."""
    time = _time(-REST, AFTER)
    step = STEP * np.clip(time / RISE, 0.0, 1.0)
    return _Experiment(time, step, np.zeros_like(time), start=-BEFORE)


def _time(start: float, end: float) -> Array:
    return np.linspace(start, end, SAMPLES)


def _record(machine: Model, example: Model, experiment: _Experiment) -> _Record:
    """The experiment on a machine; one that is driven by a torque gets what moves the `example`."""
    time, load = experiment.time, experiment.load_torque
    transmission = machine.transmission
    ratio = transmission.joint_pulley_radius / transmission.motor_pulley_radius  # n_t, (9)
    motor_position = ratio * experiment.motor_position
    if machine.kind.has_rotor:
        torque = driving_torque(
            machine, time, motor_position, simulate(example, time, motor_position, load)
        )
        trajectory = simulate(machine, time, load_torque=load, motor_torque=torque)
        motor_position = trajectory["motor_position"]
    else:
        trajectory = simulate(machine, time, motor_position, load, as_measured=True)
    shown = time >= experiment.start
    return _Record(
        time=time[shown],
        motor_position=motor_position[shown] / ratio,
        load_torque=load[shown],
        joint_position=trajectory[trajectory.measured("joint_position")][shown],
        joint_torque=_read_torque(example, trajectory)[shown],
    )


def _read_torque(example: Model, trajectory: Trajectory) -> Array:
    """Torque of the tendons on the joint, (n,) N·m, as the one sensor reads it that an effect
    changes, of the joint's torque, of the motor's, or of the force of a tendon."""
    transmission = example.transmission
    torque = trajectory["joint_torque"]
    for signal, arm in (
        ("joint_torque", 1.0),
        ("motor_torque", 1.0 / transmission.motor_share),
        ("upper_spring_force", transmission.joint_pulley_radius),
        ("lower_spring_force", -transmission.joint_pulley_radius),
    ):
        if (read := trajectory.measured(signal)) != signal:
            torque = torque + arm * (trajectory[read] - trajectory[signal])
    return np.asarray(torque)
