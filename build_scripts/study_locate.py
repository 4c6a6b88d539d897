"""How honest the bins of `locate` are: alarms where nothing is missing, and where something is.

    python build_scripts/study_locate.py [SEEDS]

Recordings are made by the independent simulator in tests/truth. The model held against them has
the true numbers, so that every bin that stands out of noise alone is a false alarm. For the power
one effect is hidden from the model, and the noise is as large as the error it causes. Numbers in
the code were chosen with seeds below 1000; those reported here are above.
"""

import sys
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarking import Row, at_least, at_most, print_table
from elastic_tendon.actuator.parameters import Model, load_model
from elastic_tendon.comparison.bins import Bin
from elastic_tendon.comparison.compare import compare
from elastic_tendon.comparison.locate import locate
from elastic_tendon.measurement import Measurement

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from truth.catalogue import actuator_of, signal_maps_of
from truth.experiments import Limits, free_decay, multisine, steps_with_load_pulses
from truth.noise import Sensor, counts, measured
from truth.recording import record
from truth.signals import Experiment, Signal, total

Array = NDArray[np.float64]

FIRST_REPORTED_SEED = 1000
LIMITS = Limits(0.2, 4.0, 3.0)
NOISE = 2e-4  # rad
# kind of noise -> what the encoder of the joint does
SENSORS = {
    "white": Sensor(white=NOISE),
    "coloured, AR(0.9)": Sensor(coloured=NOISE),
    "quantised, 12 bits": Sensor(step=counts(12)),
    "quantised, 14 bits": Sensor(step=counts(14)),
    "white and 14 bits": Sensor(white=0.5 * NOISE, step=counts(14)),
}
# effect -> numbers; the noise is made as large as the error
HIDDEN: dict[str, dict[str, float]] = {
    "coulomb_friction": {"torque": 0.05},
    "spring_hardening": {"cubic_stiffness": 1e7},
    "gravity_load": {"torque": 0.1, "angle": 0.3},
    "joint_encoder_offset": {"offset": 0.002},
    "quadratic_drag": {"coefficient": 0.01},
}


@dataclass(frozen=True)
class Motion:
    """A recording without noise: (n,) arrays in SI units."""

    time: Array
    motor_position: Array
    load_torque: Array
    joint_position: Array


def numbers_of(model: Model) -> dict[str, Any]:
    """The content of the model.toml, as the truth takes it."""
    tree: dict[str, Any] = {}
    for path, value in model.values().items():
        *parents, leaf = path.split(".")
        node = tree
        for parent in parents:
            node = node.setdefault(parent, {})
        node[leaf] = value
    return tree


def _experiment(kind: str, seed: int, duration: float) -> Experiment:
    makers = {"multisine": multisine, "steps": steps_with_load_pulses, "decay": free_decay}
    return makers[kind](seed, LIMITS, duration)


def moved(
    numbers: Mapping[str, Any],
    experiment: Experiment,
    rate: float,
    unknown: Signal | None = None,
) -> Motion:
    """What an actuator does in an experiment; the load `unknown` acts as well and is not told."""
    time = np.arange(round(experiment.duration * rate)) / rate
    load = np.array([experiment.load_torque.value(float(moment)) for moment in time])
    if unknown is not None:
        experiment = replace(experiment, load_torque=total(experiment.load_torque, unknown))
    run = record(actuator_of(numbers), experiment, time, signal_maps_of(numbers))
    return Motion(time, run["motor_position"], load, run["joint_position"])


@cache
def motion(kind: str, seed: int, duration: float, rate: float, effect: str = "") -> Motion:
    """One experiment of the true actuator, with an effect of `HIDDEN` where one is named."""
    effects = {effect: HIDDEN[effect]} if effect else {}
    numbers = {**numbers_of(load_model("biorob_x4_joint_3")), "effects": effects}
    return moved(numbers, _experiment(kind, seed, duration), rate)


def recording(made: Motion, sensor: Sensor, seed: int) -> Measurement:
    """A motion as an encoder shows it.

    Inputs are splines between the samples: straight lines would be an error of their own, up to
    half the noise where the motor starts sharply, and it would stand out rightly.
    """
    position = measured(made.joint_position, sensor, np.random.default_rng(seed))
    return Measurement(
        name=f"seed {seed}",
        time=made.time,
        motor_position=made.motor_position,
        signals={"joint_position": position},
        load_torque=made.load_torque,
        interpolation="cubic",
    )


def located(measurement: Measurement) -> tuple[Bin, ...]:
    """Bins of the joint position beside the model that has the true numbers and no effect."""
    comparison = compare(load_model("biorob_x4_joint_3"), [measurement])
    return locate(comparison).files[0].bins["joint_position"]


def false_alarms(sensor: Sensor, made: list[Motion], seeds: range) -> list[list[str]]:
    """For each motion and seed, the variables by which a bin stands out of noise alone."""
    return [
        [
            error_bin.by
            for error_bin in located(recording(one_motion, sensor, seed))
            if error_bin.stands_out
        ]
        for one_motion in made
        for seed in seeds
    ]


def found(effect: str, kind: str, seed: int) -> list[Bin]:
    """Bins that stand out where the error of a hidden effect is as large as the white noise."""
    made = motion(kind, seed, 10.0, 500.0, effect)
    clean = recording(made, Sensor(), seed)
    error = compare(load_model("biorob_x4_joint_3"), [clean]).files[0].signals["joint_position"]
    return [
        error_bin
        for error_bin in located(recording(made, Sensor(white=error.rmse), seed))
        if error_bin.stands_out
    ]


def motions(duration: float, first_seed: int) -> list[Motion]:
    """Experiments of all kinds at two rates."""
    return [
        motion(kind, first_seed + index, duration, rate)
        for index, (kind, rate) in enumerate(
            [("multisine", 500.0), ("multisine", 1000.0), ("steps", 500.0), ("decay", 500.0)]
        )
    ]


def rows(seeds: int) -> list[Row]:
    """The figures of the study."""
    result = []
    first = FIRST_REPORTED_SEED
    for duration in (2.0, 10.0, 40.0):
        made = motions(duration, first)
        for kind, sensor in SENSORS.items():
            alarms = false_alarms(sensor, made, range(first, first + seeds))
            share = 100.0 * sum(map(bool, alarms)) / len(alarms)
            what = f"{kind}, {duration:g} s: recordings in which any bin stands out"
            result.append(at_most(what, share, 5.0, "%"))
    for effect in HIDDEN:
        hits = [
            bool(found(effect, kind, seed))
            for seed in range(first, first + 5)
            for kind in ("multisine", "steps")
        ]
        what = f"{effect}, error as large as the noise: recordings in which a bin stands out"
        result.append(at_least(what, 100.0 * float(np.mean(hits)), 90.0, "%"))
    return result


def main() -> int:
    """Print the table; exit status 1 where a target is missed."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 25
    return print_table("Bins that stand out", rows(count))


if __name__ == "__main__":
    sys.exit(main())
