"""What is done to an actuator: experiments that stay within what its springs bear."""

from dataclasses import replace

import numpy as np

from hidden_effect.machines import Reached, Tree
from truth.actuator import Actuator
from truth.catalogue import actuator_of
from truth.experiments import (
    Limits,
    free_decay,
    limits_of,
    multisine,
    slow_sweep,
    steps_with_load_pulses,
)
from truth.fast import FastRun, Inputs, Player, Vector
from truth.signals import Experiment, constant, scaled, smooth_step, total

RICH = ("multisine", "steps")
KINDS = (*RICH, "static sweep", "free decay", "only slack", "only taut")
RATE = 500  # Hz
DURATION = 10.0  # s
SPEED = 4.0  # rad/s, of the motor pulley
REACH = 0.92  # of the largest deflection that is used
TAUT = 0.75  # of the slack boundary
LOAD = 0.75  # of the load that the springs bear
SLACK = 1.15  # times the slack boundary, which a rich experiment passes on both sides
TRIES = 8
HALVINGS = 7


def shrunk(experiment: Experiment, share: float) -> Experiment:
    """The experiment, smaller."""
    return replace(
        experiment,
        motor_position=scaled(experiment.motor_position, share),
        load_torque=scaled(experiment.load_torque, share),
        initial_position=share * experiment.initial_position,
        initial_velocity=share * experiment.initial_velocity,
    )


def inputs_of(experiment: Experiment) -> Inputs:
    """Motor position and load at the samples."""
    time = np.arange(round(experiment.duration * RATE)) / RATE
    return Inputs(
        time,
        np.array([experiment.motor_position.value(one) for one in time.tolist()]),
        np.array([experiment.load_torque.value(one) for one in time.tolist()]),
    )


def start_of(experiment: Experiment) -> tuple[float, float]:
    """Position (rad) and velocity (rad/s) at which it starts."""
    return experiment.initial_position, experiment.initial_velocity


def run_of(tree: Tree, inputs: Inputs, start: tuple[float, float]) -> FastRun:
    """What the sensors of an actuator show."""
    return Player(inputs).run(tree, start)


def _deflection(tree: Tree, inputs: Inputs, start: tuple[float, float]) -> Vector:
    transmission = tree["transmission"]
    ratio = transmission["motor_pulley_radius"] / transmission["joint_pulley_radius"]
    motor_side: Vector = ratio * inputs.motor_position
    return run_of(tree, inputs, start).joint_position - motor_side


def within(tree: Tree, experiment: Experiment, largest: float) -> Experiment:
    """The experiment, as large as `largest` deflection (rad) allows but not larger than it is."""
    inputs, start = inputs_of(experiment), start_of(experiment)

    def fits(share: float) -> bool:
        smaller = Inputs(inputs.time, share * inputs.motor_position, share * inputs.load_torque)
        deflection = _deflection(tree, smaller, (share * start[0], share * start[1]))
        return float(np.max(np.abs(deflection))) <= largest

    if fits(1.0):
        return experiment
    small, large = 0.0, 1.0
    for _ in range(HALVINGS):
        middle = 0.5 * (small + large)
        small, large = (middle, large) if fits(middle) else (small, middle)
    return shrunk(experiment, small)


def only_slack(truth: Actuator, seed: int, limits: Limits, duration: float) -> Experiment:
    """A load holds the joint where one tendon is slack, and the motor moves it a little there."""
    rng = np.random.default_rng(seed)
    lower, upper = truth.slack_boundaries()
    sign = float(rng.choice([-1.0, 1.0]))
    boundary = upper if sign > 0 else -lower
    target = sign * (0.45 * boundary + 0.55 * REACH * limits.deflection)
    forces = truth.spring_forces((0.0, 0.0), (target, 0.0), (False, False))
    hold = -truth.joint_pulley_radius * (max(forces[0], 0.0) - max(forces[1], 0.0))
    small = multisine(seed, Limits(limits.deflection, 0.4, 0.0), duration)
    push = multisine(seed + 1, Limits(1.0, 1.0, 0.0), duration).motor_position
    room = 0.15 * abs(hold)
    return replace(
        small,
        load_torque=total(constant(hold), scaled(push, room / 2.0)),
        initial_position=target,
    )


def experiment_of(kind: str, tree: Tree, seed: int, duration: float = DURATION) -> Experiment:
    """An experiment of a kind in `KINDS` for an actuator without effects.

    A free decay and a static sweep take as long as they do; the others last `duration` (s).
    """
    truth = actuator_of(tree)
    limits = limits_of(truth, SPEED)
    if kind == "only slack":
        return only_slack(truth, seed, limits, duration)
    if kind == "only taut":
        bound = TAUT * min(abs(one) for one in truth.slack_boundaries())
        return within(tree, multisine(seed, limits, duration), bound)
    if kind in RICH:
        return rich(kind, tree, seed, replace(limits, torque=LOAD * limits.torque), duration)
    make = {"free decay": free_decay, "static sweep": swept}[kind]
    return within(tree, make(seed, limits), REACH * limits.deflection)


def rich(kind: str, tree: Tree, seed: int, limits: Limits, duration: float) -> Experiment:
    """Multisine or steps, of several the first in which either tendon goes slack."""
    make = {"multisine": multisine, "steps": steps_with_load_pulses}[kind]
    lower, upper = actuator_of(tree).slack_boundaries()
    tried: list[tuple[float, Experiment]] = []
    for again in range(TRIES):
        unbound = make(seed + again, limits, duration)
        found = within(tree, unbound, REACH * limits.deflection)
        deflection = _deflection(tree, inputs_of(found), start_of(found))
        beyond = min(float(np.min(deflection)) / lower, float(np.max(deflection)) / upper)
        if beyond > SLACK:
            return found
        tried.append((beyond, found))
    return max(tried, key=lambda one: one[0])[1]


def swept(seed: int, limits: Limits) -> Experiment:
    """Two slow sines of the load, up to near its limit or less, after a slow move of the motor."""
    share = np.random.default_rng(seed).uniform(0.75, 0.95)
    sweep = slow_sweep(seed, replace(limits, torque=share * limits.torque), 20.0)
    return replace(sweep, motor_position=smooth_step(0.0, 19.0, 0.3))


def reached_by(tree: Tree, experiment: Experiment) -> Reached:
    """How far the actuator without effects goes."""
    inputs, start = inputs_of(experiment), start_of(experiment)
    run = run_of(tree, inputs, start)
    deflection = _deflection(tree, inputs, start)
    truth = actuator_of(tree)
    travel = truth.joint_pulley_radius * deflection
    elongation = max(
        truth.rest_length(truth.upper) - float(np.min(travel)),
        truth.rest_length(truth.lower) + float(np.max(travel)),
    )
    return Reached(float(np.min(run.joint_position)), float(np.max(run.joint_position)), elongation)
