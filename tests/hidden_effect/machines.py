"""Actuators at random, and what effects on them are like: numbers off any grid.

A `Tree` is the content of a model.toml, as `truth.catalogue` takes it.
"""

import copy
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

Tree = dict[str, Any]
SIDES = ("upper_spring", "lower_spring")

# what the truth's actuators are uncertain by, one sigma relative to the value: as the product says
# of a model whose [uncertainty] is empty; dampings of 0 by what makes a damping ratio of 0.3
UNCERTAINTY = {
    "transmission.upper_spring.stiffness": 0.1,
    "transmission.lower_spring.stiffness": 0.1,
    "transmission.pretension_force": 0.3,
    "link.inertia": 0.3,
    "link.damping": 1.0,
    "transmission.upper_spring.damping": 1.0,
    "transmission.lower_spring.damping": 1.0,
}
WIDE_DAMPING_RATIO = 0.3
SHAKEN = math.log(2.0)  # shapes lie within so much of the typical one
RINGING_RATIO = 0.005  # damping ratio of a spring that swings in itself; of steel 0.001 to 0.02


def get(tree: Mapping[str, Any], path: str) -> float:
    """Number at a dotted path; 0 where it is not given."""
    *tables, key = path.split(".")
    node: Any = tree
    for table in tables:
        node = node.get(table, {})
    return float(node.get(key, 0.0))


def with_numbers(tree: Mapping[str, Any], numbers: Mapping[str, float]) -> Tree:
    """A copy with other numbers by dotted path."""
    changed = copy.deepcopy(dict(tree))
    for path, value in numbers.items():
        *tables, key = path.split(".")
        node = changed
        for table in tables:
            node = node.setdefault(table, {})
        node[key] = float(value)
    return changed


@dataclass(frozen=True)
class Sizes:
    """Characteristic sizes of an actuator, SI."""

    torque: float  # that the weaker spring bears at the joint
    stiffness: float  # of the joint with both tendons taut
    frequency: float  # rad/s, of the joint then
    spring: float  # stiffness of one of the softer springs
    side: float  # stiffness of the softer side
    deflection: float  # largest of a spring, m
    link_mass: float  # J / R², kg


def sizes_of(tree: Mapping[str, Any]) -> Sizes:
    """Characteristic sizes."""
    transmission = tree["transmission"]
    springs = [transmission[side] for side in SIDES]
    sides = [spring["stiffness"] * spring.get("parallel", 1) for spring in springs]
    radius, inertia = transmission["joint_pulley_radius"], tree["link"]["inertia"]
    stiffness = radius**2 * sum(sides)
    deflection = min(spring["max_deflection"] for spring in springs)
    return Sizes(
        torque=radius
        * min(k * spring["max_deflection"] for k, spring in zip(sides, springs, strict=True)),
        stiffness=stiffness,
        frequency=math.sqrt(stiffness / inertia),
        spring=min(spring["stiffness"] for spring in springs),
        side=min(sides),
        deflection=deflection,
        link_mass=inertia / radius**2,
    )


def sigma_of(tree: Mapping[str, Any], path: str) -> float:
    """One sigma of what is believed of a number of the base model, in its unit."""
    value = get(tree, path)
    share = tree.get("uncertainty", {}).get(path, UNCERTAINTY[path])
    if value != 0.0:
        return float(share * abs(value))
    sizes = sizes_of(tree)
    damping = 2.0 * WIDE_DAMPING_RATIO * math.sqrt(sizes.stiffness * tree["link"]["inertia"])
    if path == "link.damping":
        return damping
    transmission = tree["transmission"]
    count = sum(transmission[side].get("parallel", 1) for side in SIDES)
    return float(damping / (transmission["joint_pulley_radius"] ** 2 * count))


def actuator(rng: np.random.Generator) -> Tree:
    """An actuator: springs of two kinds, damped in half of all; tendons that can go slack."""
    deflections = rng.uniform(0.011, 0.018, 2)
    stiffness = float(np.exp(rng.uniform(np.log(5e3), np.log(1.5e4))))
    parallel = [int(rng.integers(1, 4))] * 2
    damped = bool(rng.random() < 0.5)
    radius = float(rng.uniform(0.025, 0.045))
    springs = [
        {
            "stiffness": stiffness * float(rng.uniform(0.85, 1.18)),
            "parallel": parallel[i],
            "damping": float(rng.uniform(1.0, 6.0)) if damped else 0.0,
            "max_deflection": float(deflections[i]),
        }
        for i in range(2)
    ]
    combined = [spring["parallel"] * spring["stiffness"] for spring in springs]
    # (30): the pretension with the widest range in which both tendons are taut
    recommended = float(min(deflections)) / sum(1.0 / k for k in combined)
    inertia = float(radius**2 * sum(combined) / (2.0 * np.pi * rng.uniform(4.0, 8.0)) ** 2)
    ratio = float(rng.uniform(0.03, 0.12))
    return {
        "name": "actuator",
        "transmission": {
            "joint_pulley_radius": radius,
            "motor_pulley_radius": radius * float(rng.uniform(0.6, 1.2)),
            "pretension_force": recommended * float(rng.uniform(0.35, 0.75)),
            "upper_spring": springs[0],
            "lower_spring": springs[1],
        },
        "link": {
            "inertia": inertia,
            "damping": 2.0 * ratio * math.sqrt(radius**2 * sum(combined) * inertia),
        },
    }


@dataclass(frozen=True)
class Reached:
    """How far a motion of the actuator without effects goes."""

    lowest: float  # rad
    highest: float  # rad
    elongation: float  # m, largest of a spring


def stop(sizes: Sizes, reached: Reached, depth: float, share: float, upper: bool) -> Tree:
    """End stops, of which one lies `depth` of the joint's range inside the motion."""
    span = reached.highest - reached.lowest
    inside = depth * span
    return {
        "lower": reached.lowest + (-0.4 * span if upper else inside),
        "upper": reached.highest - (inside if upper else -0.4 * span),
        "stiffness": 12.0 * share * sizes.stiffness,
        "damping": 0.4 * share * sizes.stiffness / sizes.frequency,
    }


def hidden_numbers(
    effect: str, sizes: Sizes, reached: Reached, rng: np.random.Generator
) -> "Hidden":
    """An effect with shapes at random, to be given a strength."""

    def shake() -> float:
        return float(np.exp(rng.uniform(-SHAKEN, SHAKEN)))

    dry = 0.03 * sizes.torque
    stribeck = {
        "coulomb_torque": dry,
        "static_torque": dry * float(rng.uniform(1.4, 2.0)),
        "stribeck_velocity": 0.1 * shake(),
    }
    damping = 0.5 * sizes.stiffness / sizes.frequency
    heavy = 0.01 * sizes.link_mass
    ringing = 2.0 * RINGING_RATIO * math.sqrt(4.0 * sizes.spring * heavy)
    turn = float(rng.uniform(-1.2, 1.2))
    force = 0.05 * sizes.spring * sizes.deflection
    sign = float(rng.choice([-1.0, 1.0]))
    engage = min(0.9 * reached.elongation / sizes.deflection, 0.95) * float(rng.uniform(0.7, 0.9))
    numbers: dict[str, tuple[Tree, tuple[str, ...]]] = {
        "coulomb_friction": ({"torque": dry}, ("torque",)),
        "stribeck_friction": (stribeck, ("coulomb_torque", "static_torque")),
        "lugre_friction": (
            stribeck
            | {
                "bristle_stiffness": 10.0 * sizes.stiffness * shake(),
                "bristle_damping": damping * shake(),
            },
            ("coulomb_torque", "static_torque"),
        ),
        "quadratic_drag": ({"coefficient": 0.003 * shake()}, ("coefficient",)),
        "gravity_load": ({"torque": 0.1 * sizes.torque, "angle": turn}, ("torque",)),
        "constant_torque": ({"torque": sign * dry}, ("torque",)),
        "joint_stop": (
            stop(sizes, reached, 0.05, shake(), bool(rng.random() < 0.5)),
            ("depth",),
        ),
        "overstretch_protection": (
            {"engagement": engage, "stiffness": 3.0 * sizes.spring * shake()},
            ("stiffness",),
        ),
        "spring_hardening": (
            {"cubic_stiffness": 0.3 * sizes.spring / sizes.deflection**2},
            ("cubic_stiffness",),
        ),
        "spring_hysteresis": (
            {"force": force, "yield_length": 0.05 * sizes.deflection * shake(), "exponent": 1.0},
            ("force",),
        ),
        "spring_relaxation": (
            {"stiffness": 0.2 * sizes.spring, "time_constant": 3.0 / sizes.frequency * shake()},
            ("stiffness",),
        ),
        "spring_mass": (
            {
                "mass": heavy,
                "damping": ringing * shake(),
            },
            ("mass", "damping"),
        ),
        "tendon_guide_friction": ({"wrap_friction": 0.05}, ("wrap_friction",)),
        "tendon_compliance": ({"compliance": 0.1 / sizes.side}, ("compliance",)),
        "gear_backlash": ({"gap": 0.01}, ("gap",)),
        "pulley_eccentricity": ({"amplitude": 0.02, "phase": turn}, ("amplitude",)),
        "joint_encoder_offset": ({"offset": sign * 0.01}, ("offset",)),
        "motor_encoder_offset": ({"offset": sign * 0.01}, ("offset",)),
        "measurement_delay": ({"delay": 0.005}, ("delay",)),
    }
    values, strengths = numbers[effect]
    return Hidden(effect, values, strengths, reached.highest - reached.lowest)


@dataclass(frozen=True)
class Hidden:
    """An effect at typical strength 1; `strengths` are what grows with it."""

    effect: str
    numbers: Tree
    strengths: tuple[str, ...]
    span: float  # rad, of the joint's motion

    def at(self, strength: float) -> Tree:
        """Its numbers at a strength; a stop's is how far it stands inside the motion."""
        if self.strengths == ("depth",):
            deeper = 0.05 * self.span * (strength - 1.0)
            return self.numbers | {
                "lower": self.numbers["lower"] + deeper,
                "upper": self.numbers["upper"] - deeper,
            }
        return {
            name: value * strength if name in self.strengths else value
            for name, value in self.numbers.items()
        }


EFFECTS = (
    *("coulomb_friction", "stribeck_friction", "lugre_friction", "quadratic_drag"),
    "constant_torque",
    *("gravity_load", "joint_stop", "overstretch_protection", "spring_hardening"),
    *("spring_hysteresis", "spring_relaxation", "spring_mass", "tendon_guide_friction"),
    *("tendon_compliance", "gear_backlash", "pulley_eccentricity", "joint_encoder_offset"),
    *("motor_encoder_offset", "measurement_delay"),
)


def with_effects(
    tree: Mapping[str, Any], effects: Iterable[tuple[str, Mapping[str, float]]]
) -> Tree:
    """A copy with effects of these numbers."""
    changed = copy.deepcopy(dict(tree))
    changed["effects"] = changed.get("effects", {}) | {name: dict(one) for name, one in effects}
    return changed
