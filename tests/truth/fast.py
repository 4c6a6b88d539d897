"""The laws of the catalogue on a fixed step: a hundred times as fast as `solver`, for studies.

The equations stand in `fast.c`, which zig compiles once. A run errs by some 1e-6 rad against
`solver`, far below the smallest noise of the studies, whose recordings are made with it too.
"""

import ctypes
import hashlib
import math
import os
import subprocess
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from platformdirs import user_cache_path
from scipy.interpolate import CubicSpline

from truth.catalogue import signal_maps_of

Vector = NDArray[np.float64]
Numbers = Mapping[str, Any]

SOURCE = Path(__file__).with_name("fast.c")
STEP = 1e-3  # s, longest
CREEPLESS, NO_STRING = 1.0, 1e3  # s and m, numbers that only what is absent would use


class TruthError(Exception):
    """A run that no actuator makes: the joint ran away."""


@cache
def library() -> ctypes.CDLL:
    """`fast.c`, compiled into the user's cache."""
    digest = hashlib.sha256(SOURCE.read_bytes()).hexdigest()[:16]
    target = user_cache_path("elastic-tendon-truth") / f"fast_{digest}.so"
    if not target.exists():
        target.parent.mkdir(parents=True, exist_ok=True)
        made = target.with_suffix(f".{os.getpid()}")
        subprocess.run(
            [
                *(sys.executable, "-m", "ziglang", "cc", "-O2", "-fno-sanitize=undefined"),
                *("-shared", "-fPIC", "-o", str(made), str(SOURCE), "-lm"),
            ],
            check=True,
            capture_output=True,
        )
        made.replace(target)
    return ctypes.CDLL(str(target))


@dataclass(frozen=True)
class Inputs:
    """What is done to the actuator, as recorded: (n,) arrays at equidistant times from zero."""

    time: Vector  # s
    motor_position: Vector  # rad
    load_torque: Vector  # N·m


@dataclass(frozen=True)
class FastRun:
    """What the sensors show, (n,) each."""

    joint_position: Vector  # rad
    joint_torque: Vector  # N·m


def numbers_of(tree: Numbers, start: tuple[float, float]) -> Vector:
    """The parameters of a model.toml in the order of `fast.c`, from a start (rad, rad/s)."""
    transmission, link, effects = tree["transmission"], tree["link"], tree.get("effects", {})
    springs = [transmission["upper_spring"], transmission["lower_spring"]]
    counts = [spring.get("parallel", 1) for spring in springs]

    def effect(name: str, key: str, absent: float = 0.0) -> float:
        return float(effects[name][key]) if name in effects else absent

    def of_both(one: float) -> list[float]:
        return [count * one for count in counts]

    dry = next((name for name in DRY if name in effects), "")
    coulomb = effect("coulomb_friction", "torque", effect(dry, "coulomb_torque"))
    static = effect("coulomb_friction", "torque", effect(dry, "static_torque"))
    return np.array(
        [
            transmission["joint_pulley_radius"],
            transmission["motor_pulley_radius"],
            transmission["pretension_force"],
            link["inertia"],
            link.get("damping", 0.0),
            *[n * spring["stiffness"] for n, spring in zip(counts, springs, strict=True)],
            *[n * spring.get("damping", 0.0) for n, spring in zip(counts, springs, strict=True)],
            *[
                sign * count * effect("spring_asymmetry", "square_stiffness")
                for sign, count in zip((1.0, -1.0), counts, strict=True)
            ],
            *of_both(effect("spring_hardening", "cubic_stiffness")),
            *[
                effect("overstretch_protection", "engagement", NO_STRING) * one["max_deflection"]
                for one in springs
            ],
            *of_both(effect("overstretch_protection", "stiffness")),
            *of_both(effect("spring_hysteresis", "force")),
            effect("spring_hysteresis", "yield_length", 1.0),
            float(effects.get("spring_hysteresis", {}).get("exponent", 1.0)),
            *of_both(effect("spring_relaxation", "stiffness")),
            effect("spring_relaxation", "time_constant", CREEPLESS),
            *of_both(effect("spring_mass", "mass")),
            *of_both(effect("spring_mass", "damping")),
            effect("tendon_compliance", "compliance"),
            coulomb,
            static,
            effect(dry, "stribeck_velocity", 1.0),
            effect("lugre_friction", "bristle_stiffness"),
            effect("lugre_friction", "bristle_damping"),
            effect("quadratic_drag", "coefficient"),
            effect("cubic_damping", "coefficient"),
            effect("directional_damping", "difference"),
            effect("constant_torque", "torque"),
            effect("gravity_load", "torque"),
            effect("gravity_load", "angle"),
            effect("joint_stop", "lower", -math.inf),
            effect("joint_stop", "upper", math.inf),
            effect("joint_stop", "stiffness"),
            effect("joint_stop", "damping"),
            effect("tendon_guide_friction", "wrap_friction"),
            effect("gear_backlash", "gap"),
            effect("pulley_eccentricity", "amplitude"),
            effect("pulley_eccentricity", "phase"),
            effect("motor_encoder_offset", "offset"),
            effect("motor_encoder_gain", "error"),
            *start,
        ],
        dtype=np.float64,
    )


DRY = ("stribeck_friction", "lugre_friction")


@cache
def _grid(samples: int, interval: float, delay: float) -> tuple[int, float, Vector]:
    """Steps between samples, their size (s), and the times (s) of inputs at every half step."""
    steps = math.ceil(interval / STEP - 1e-9)
    size = interval / steps
    times = np.arange(2 * steps * (samples - 1) + 2) * 0.5 * size
    return steps, size, np.maximum(times - delay, 0.0)


class Player:
    """Runs of actuators under the same inputs."""

    def __init__(self, inputs: Inputs) -> None:
        self.inputs = inputs
        self._motor = CubicSpline(inputs.time, inputs.motor_position)
        self._load = CubicSpline(inputs.time, inputs.load_torque)
        self._tables: dict[float, tuple[Vector, ...]] = {}

    def _table(self, delay: float) -> tuple[int, float, tuple[Vector, ...]]:
        time = self.inputs.time
        steps, size, at = _grid(len(time), float(time[1] - time[0]), delay)
        if delay not in self._tables:
            if len(self._tables) > 4:  # those of one derivative by the delay
                self._tables.clear()
            rate, load_rate = self._motor(at, 1), self._load(at, 1)
            for one in (rate, load_rate):
                one[: np.searchsorted(at, 0.0, side="right") - 1] = 0.0
            self._tables[delay] = (self._motor(at), rate, self._load(at), load_rate)
        return steps, size, self._tables[delay]

    def run(self, tree: Numbers, start: tuple[float, float]) -> FastRun:
        """What the sensors of an actuator show.

        Parameters
        ----------
        tree : content of a model.toml
        start : position (rad) and velocity (rad/s) of the joint

        Raises
        ------
        TruthError : the joint ran away
        """
        effects = tree.get("effects", {})
        delay = effects.get("measurement_delay", {}).get("delay", 0.0)
        steps, size, table = self._table(delay)
        samples = len(self.inputs.time)
        position, torque = np.empty(samples), np.empty(samples)
        pointers = [
            array.ctypes.data_as(ctypes.POINTER(ctypes.c_double))
            for array in (numbers_of(tree, start), *table, position, torque)
        ]
        failed = library().fast_simulate(
            pointers[0], ctypes.c_long(samples), ctypes.c_long(steps), ctypes.c_double(size),
            *pointers[1:],
        )  # fmt: skip
        if failed:
            raise TruthError("the joint ran away")
        maps = signal_maps_of(tree)
        radii = tree["transmission"]
        ratio = radii["motor_pulley_radius"] / radii["joint_pulley_radius"]
        motor = (self.inputs.motor_position - maps.motor_offset) / (1.0 + maps.motor_share)
        deflection = position - ratio * motor
        return FastRun(
            (1.0 + maps.joint_share) * position
            + maps.joint_offset
            + maps.deflection_share * deflection,
            torque,
        )
