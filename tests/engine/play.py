"""Runs the engine, and records what a machine's sensors show."""

from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from elastic_tendon.measurement import Measurement
from engine.machines import STEP, Machine
from engine.motions import Motion, motion_of

Array = NDArray[np.float64]

RATE = 500  # Hz
DURATION = 12.0  # s
SETTLING = 1.0  # s, before the recording begins, all inputs as at its start
REACH = 0.85  # of the deflection that the springs bear
SLACK = 1.2  # times the deflection at which a tendon is slack, passed to both sides
TRIES = 12
PUSH = 0.8  # s, of a load that nobody records
COARSE = 5e-4  # s, step that is good enough to see how far a bare machine goes


@dataclass(frozen=True)
class Played:
    """What the sensors of a machine would show without noise, (n,) each."""

    time: Array  # s
    motor_position: Array  # rad
    load_torque: Array  # N·m
    joint_position: Array  # rad


def unrecorded(machine: Machine, motion: Motion, time: Array) -> Array:
    """The load that the load cell misses, N·m: two pushes, as a cosine comes and goes."""
    found = np.zeros_like(time)
    for share, sign in ((0.3, 1.0), (0.7, -1.0)):
        within = np.clip((time - share * motion.duration) / PUSH, 0.0, 1.0)
        found += 0.5 * sign * (1.0 - np.cos(2.0 * np.pi * within))
    return machine.hidden.push * found


def run(machine: Machine, motor: Array, load: Array, step: float = STEP) -> Array:
    """Joint position (n,), rad, at every step of the engine.

    The motor's place and rate are written before each step, so it is where it shall be whatever
    pulls at it. Then a step advances the joint as the leapfrog does, exact to second order.
    """
    model = mujoco.MjModel.from_xml_string(machine.mjcf)
    model.opt.timestep = step
    data = mujoco.MjData(model)
    kind = mujoco.mjtObj.mjOBJ_JOINT
    first, joint = (mujoco.mj_name2id(model, kind, name) for name in ("motor", "joint"))
    place, rate, torque, advance = data.qpos, data.qvel, data.qfrc_applied, mujoco.mj_step
    for name in ("joint", "pulley", "upper_middle", "lower_middle"):
        number = mujoco.mj_name2id(model, kind, name)
        if number >= 0:
            place[number] = start_of(machine, name, float(motor[0]))
    found = np.empty(len(motor))
    inputs = zip(motor.tolist(), np.gradient(motor, step).tolist(), load.tolist(), strict=True)
    for i, (position, velocity, push) in enumerate(inputs):
        found[i] = place[joint]
        place[first] = position
        rate[first] = velocity
        torque[joint] = push
        advance(model, data)
    return found


def start_of(machine: Machine, name: str, motor: float) -> float:
    """Where a hinge (rad) or slide (m) is while nothing pulls."""
    travel = machine.base.motor_radius * motor
    return {
        "joint": machine.base.ratio * motor,
        "pulley": motor,
        "upper_middle": travel,
        "lower_middle": -travel,
    }[name]


def play(machine: Machine, motion: Motion, step: float = STEP) -> Played:
    """What the sensors show of a motion."""
    settling, every = round(SETTLING / step), round(1.0 / (RATE * step))
    # whole numbers of steps, so that samples are at steps exactly
    time = np.maximum(np.arange(-settling, round(motion.duration / step)) * step, 0.0)
    motor, load = motion.motor(time), motion.load(time)
    joint = run(machine, motor, load + unrecorded(machine, motion, time), step)
    samples = np.arange(settling, len(time), every)
    late = round(machine.hidden.delay / step)
    return Played(
        time[samples],
        motor[samples],
        load[samples],
        joint[samples - late] + machine.hidden.offset,
    )


def recorded(name: str, played: Played, sigma: float, rng: np.random.Generator) -> Measurement:
    """A recording with white noise of the joint's encoder, rad."""
    noise = sigma * rng.standard_normal(len(played.time))
    return Measurement(
        name=name,
        time=played.time,
        motor_position=played.motor_position,
        signals={"joint_position": played.joint_position + noise},
        load_torque=played.load_torque if np.any(played.load_torque) else None,
    )


def motion_for(machine: Machine, kind: str, seed: int, duration: float = DURATION) -> Motion:
    """A motion that makes either tendon slack and breaks no spring of the bare machine."""
    base = machine.base
    largest = REACH * base.largest_deflection
    # what holds a spring at that deflection, the other slack
    torque = base.joint_radius * min(base.sides) * (
        base.pretension / min(base.sides) + base.joint_radius * largest
    )  # fmt: skip
    found: list[tuple[float, Motion]] = []
    for number in range(TRIES):
        motion = motion_of(kind, TRIES * seed + number, duration, 0.7 * torque)
        motion, deflection = fitted(machine, motion, largest)
        beyond = min(-float(np.min(deflection)), float(np.max(deflection)))
        beyond /= base.slack_deflection
        if beyond > SLACK:
            return motion
        found.append((beyond, motion))
    return max(found, key=lambda pair: pair[0])[1]


def fitted(machine: Machine, motion: Motion, largest: float) -> tuple[Motion, Array]:
    """A motion as large as `largest` deflection (rad) allows, and the bare machine's in it."""
    for _ in range(TRIES):
        played = play(machine.bare, motion, COARSE)
        deflection = played.joint_position - machine.base.ratio * played.motor_position
        excess = float(np.max(np.abs(deflection))) / largest
        if excess <= 1.0:
            break
        motion = motion.scaled(max(0.98 / excess, 0.7))
    return motion, deflection
