"""Truth recordings of many actuators, and the ways in which they could be misread."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from effects_at import IDS_AT_POSITION, searched_in_positions
from elastic_tendon.actuator.parameters import Model, parse_model, typical_value
from elastic_tendon.effects import BY_ID
from elastic_tendon.measurement import Measurement
from truth.catalogue import actuator_of, signal_maps_of
from truth.experiments import (
    Limits,
    free_decay,
    limits_of,
    multisine,
    slow_sweep,
    steps_with_load_pulses,
    within_deflection,
)
from truth.noise import Sensor, counts
from truth.recording import record
from truth.sampling import sample

# seeds below are for development, reported figures come from those above
REPORTED_SEEDS = 1000
RATE = 500  # Hz
SPEED = 4.0  # rad/s, of the motor
ROUGH_BUT_ENOUGH = 1.2  # share of the deflection limit that experiments keep to

SENSORS = (
    Sensor(white=2e-4),
    Sensor(coloured=5e-4),
    Sensor(step=counts(14)),
)
EXPERIMENTS = (multisine, steps_with_load_pulses, multisine, free_decay, slow_sweep)
# what the user believes wrongly
BELIEFS: tuple[dict[str, float], ...] = (
    {},
    {"transmission.upper_spring.stiffness": 2.0, "transmission.lower_spring.stiffness": 2.0},
    {"link.inertia": 3.0},
)


@dataclass(frozen=True)
class Case:
    """A recording, the model it is held against, and what was done."""

    model: Model
    measurement: Measurement
    effect: str


def random_model(rng: np.random.Generator) -> Model:
    """An actuator of robot joints' size, with unlike pulleys in half of the cases."""
    radius = float(rng.uniform(0.02, 0.05))
    ratio = float(rng.choice([1.0, rng.uniform(0.5, 1.3)]))
    sides = {}
    for side in ("upper_spring", "lower_spring"):
        sides[side] = {
            "stiffness": float(rng.uniform(6e3, 2.4e4)),
            "damping": float(rng.choice([0.0, 10.0])),
            "max_deflection": float(rng.uniform(0.01, 0.02)),
        }
    return parse_model(
        {
            "name": "random",
            "transmission": {
                "joint_pulley_radius": radius,
                "motor_pulley_radius": ratio * radius,
                "pretension_force": float(rng.uniform(20.0, 60.0)),
                **sides,
            },
            "link": {
                "inertia": float(rng.uniform(0.02, 0.06)),
                "damping": float(rng.uniform(0.05, 0.3)),
            },
        },
        "random",
    )


@lru_cache(maxsize=16)  # the truth takes seconds to simulate
def truth_case(seed: int, *, hidden: bool = True, duration: float = 4.0) -> Case:
    """The recording of a seed: every effect, experiment, noise and wrong belief in turn.

    Parameters
    ----------
    seed : also says which effect is hidden
    hidden : whether an effect is hidden, at its typical strength, and the beliefs are wrong
    duration : s
    """
    rng = np.random.default_rng(seed)
    base = random_model(rng)
    ids = ("", *(name for name in IDS_AT_POSITION if name in searched_in_positions()))
    effect = ids[seed % len(ids)] if hidden else ""
    true = base
    if effect:
        parameters = BY_ID[effect].parameters
        typical = {
            one.name: float(np.clip(typical_value(base, one), one.lower, one.upper))
            for one in parameters
        }
        true = base.with_effect(effect, typical)
    tree = true.model_dump()
    actuator = actuator_of(tree)
    limits = limits_of(actuator, SPEED)
    experiment = EXPERIMENTS[int(rng.integers(len(EXPERIMENTS)))]
    loaded = bool(rng.integers(2)) or experiment is slow_sweep
    limits = limits if loaded else Limits(limits.deflection, limits.speed, 0.0)
    run = experiment(seed, limits, duration)
    run = within_deflection(actuator, run, ROUGH_BUT_ENOUGH * limits.deflection)
    time = np.arange(round(duration * RATE)) / RATE
    sensors = {"joint_position": SENSORS[int(rng.integers(len(SENSORS)))]}
    table = sample(record(actuator, run, time, signal_maps_of(tree)), sensors, seed)
    belief = BELIEFS[int(rng.integers(len(BELIEFS)))] if hidden else {}
    values = base.values()
    return Case(
        model=base.with_values({path: by * values[path] for path, by in belief.items()}),
        measurement=Measurement(
            name=f"seed_{seed}.csv",
            time=table["time_s"],
            motor_position=table["motor_position_rad"],
            signals={"joint_position": table["joint_position_rad"]},
            load_torque=table["load_torque_Nm"] if loaded else None,
        ),
        effect=effect,
    )


@dataclass(frozen=True)
class Misreading:
    """What goes wrong, which words must say so, and what must move for it to show."""

    misread: Callable[[Measurement], Measurement]
    says: str
    needs_load: bool = False
    needs_motor: bool = False


def can_show(misreading: Misreading, case: Case) -> bool:
    """Whether what must move does."""
    load = case.measurement.load_torque
    loaded = load is not None and bool(np.ptp(load) > 0.0)
    moves = bool(np.ptp(case.measurement.motor_position) > 0.0)
    return (loaded or not misreading.needs_load) and (moves or not misreading.needs_motor)


def scaled(**factors: float) -> Callable[[Measurement], Measurement]:
    """Signals times factors."""

    def misread(one: Measurement) -> Measurement:
        load = one.load_torque
        joint = factors.get("joint_position", 1.0) * one.signals["joint_position"]
        return replace(
            one,
            time=factors.get("time", 1.0) * one.time,
            motor_position=factors.get("motor_position", 1.0) * one.motor_position,
            load_torque=None if load is None else factors.get("load_torque", 1.0) * load,
            signals=dict(one.signals) | {"joint_position": joint},
        )

    return misread


def swapped(one: Measurement) -> Measurement:
    """Motor and joint position in each other's place."""
    joint = dict(one.signals) | {"joint_position": one.motor_position}
    return replace(one, motor_position=one.signals["joint_position"], signals=joint)


DEGREES = 180.0 / np.pi
MISREADINGS = {
    "swapped": Misreading(swapped, "swapped", needs_motor=True),
    "joint's sign": Misreading(scaled(joint_position=-1.0), "opposite sign"),
    "motor's sign": Misreading(scaled(motor_position=-1.0), "opposite sign", needs_motor=True),
    "load's sign": Misreading(scaled(load_torque=-1.0), "opposite sign", needs_load=True),
    "joint in degrees": Misreading(scaled(joint_position=DEGREES), "degrees"),
    "motor in degrees": Misreading(scaled(motor_position=DEGREES), "degrees", needs_motor=True),
    "both in degrees": Misreading(
        scaled(joint_position=DEGREES, motor_position=DEGREES), "degrees"
    ),
    "joint in mrad": Misreading(scaled(joint_position=1e3), "mrad"),
    "motor in mrad": Misreading(scaled(motor_position=1e3), "mrad", needs_motor=True),
    "joint before a gear of 16": Misreading(scaled(joint_position=16.0), "ratio", needs_motor=True),
    "motor before a gear of 16": Misreading(scaled(motor_position=16.0), "ratio", needs_motor=True),
    "motor before a gear of 50": Misreading(scaled(motor_position=50.0), "ratio", needs_motor=True),
    "load in N·cm": Misreading(scaled(load_torque=1e2), "N·cm", needs_load=True),
    "load in mN·m": Misreading(scaled(load_torque=1e3), "mN·m", needs_load=True),
    "time in ms": Misreading(scaled(time=1e3), "milliseconds"),
    "time in µs": Misreading(scaled(time=1e6), "microseconds"),
}
