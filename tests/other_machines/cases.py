"""Cases of seven kinds of machine, three of each: what is given, recorded, and hidden.

The model as given has numbers that are wrong by up to its uncertainties. What is right is a list:
some kinds of recording cannot tell two answers apart.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np

import elastic_tendon as et
from truth.other_machines import (
    Array,
    Friction,
    Machine,
    Motion,
    driven_by_position,
    driven_by_torque,
    laminate,
    sines,
)

FIRST_REPORTED_SEED = 1000
RADIUS = 0.02  # m, of the pulleys by which a torsion spring is written
MOST_BENT = 0.6  # rad, of springs
Right = tuple[frozenset[str], ...]
# friction that moves a little before it slides, as all of these machines have
DRY = ("coulomb_friction", "lugre_friction")
GAINED = ("", " motor_torque_gain")  # where only a load that is known would tell


@dataclass(frozen=True)
class Case:
    """Recordings of a machine, the model as given, and the sets of effects that are right."""

    given: et.Model
    recordings: tuple[et.Measurement, ...]
    right: Right


@dataclass(frozen=True)
class Order:
    """A machine of a kind to be made."""

    kind: str
    hidden: str
    seed: int

    @property
    def name(self) -> str:
        """Of files and tables."""
        return f"{self.kind}_{self.hidden}_{self.seed}"


def right(*sets: str) -> Right:
    """Sets of effects, as "gravity_load coulomb_friction"."""
    return tuple(frozenset(names.split()) for names in sets)


def given(
    rng: np.random.Generator,
    machine: Machine,
    *,
    slack: int = 0,
    motor: bool = False,
) -> et.Model:
    """The model as given of a machine: springs 10 %, inertias 15 % off, dampings and all that is
    hidden unknown."""
    off = dict(
        zip(
            ("stiffness", "inertia", "motor", "pull"),
            1.0 + rng.uniform(-1.0, 1.0, 4) * np.array([0.1, 0.15, 0.1, 0.1]),
            strict=True,
        )
    )
    side = {
        "stiffness": 0.5 * off["stiffness"] * machine.stiffness / RADIUS**2,
        "damping": 0.0,
        "max_deflection": max(MOST_BENT, 6.0 * (machine.pull or 0.0) / machine.stiffness) * RADIUS,
    }
    content: dict[str, Any] = {
        "name": "given",
        "interface": {"kind": "torque" if motor else "position"},
        "transmission": {
            "joint_pulley_radius": RADIUS,
            "motor_pulley_radius": RADIUS,
            "pretension_force": off["pull"] * (machine.pull or 0.0) / RADIUS,
            "slack": slack,
            "upper_spring": side,
            "lower_spring": side,
        },
        "link": {"inertia": off["inertia"] * machine.inertia, "damping": machine.damping},
    }
    if motor:
        content["motor"] = {
            "inertia": off["motor"] * machine.motor_inertia,
            "damping": machine.motor_damping,
        }
    return et.load_model(content)


def noisy(rng: np.random.Generator, values: Array, size: float) -> Array:
    """Values of a sensor with white noise."""
    return values + size * rng.standard_normal(len(values))


def grid(seconds: float, rate: float) -> Array:
    """Times of samples, s."""
    return np.arange(round(seconds * rate)) / rate


def sampled(motion: Motion, time: Array) -> Array:
    """Values of a motion at times."""
    return np.array([motion(at)[0] for at in time])


# ---- kinds ---------------------------------------------------------------------------------


def series_elastic(rng: np.random.Generator, hidden: str) -> Case:
    """A joint behind a torsion spring, whose deflection is measured with a gain that is off."""
    machine = Machine(
        inertia=rng.uniform(0.05, 0.2),
        damping=rng.uniform(0.05, 0.2),
        stiffness=rng.uniform(80.0, 250.0),
        spring_damping=rng.uniform(0.1, 0.4),
    )
    torque = 0.04 * machine.stiffness
    changes: dict[str, dict[str, Any]] = {
        "friction": {"friction": Friction(rng.uniform(0.1, 0.3) * torque)},
        "hardening": {"cubic": 40.0 * machine.stiffness, "quintic": 200.0 * machine.stiffness},
        "gravity": {"gravity": rng.uniform(0.5, 1.5) * torque},
    }
    machine = replace(machine, **changes[hidden])
    time, motor = grid(10.0, 500.0), sines(rng, 0.3, 0.2, 2.5, 8)
    joint = driven_by_position(machine, time, motor)
    angle = sampled(motor, time)
    gain = rng.uniform(0.85, 1.15)
    recording = et.Measurement(
        time=time,
        motor_position=angle,
        signals={"joint_deflection": noisy(rng, gain * (joint - angle), 1e-4)},
    )
    named = {
        "friction": right(*DRY, *(f"{name} deflection_gain" for name in DRY)),
        "hardening": right("spring_hardening", "spring_hardening deflection_gain"),
        "gravity": right("gravity_load", "gravity_load deflection_gain"),
    }
    return Case(given(rng, machine), (recording,), named[hidden])


def cable_drive(rng: np.random.Generator, hidden: str) -> Case:
    """A tool at the end of two cables, moved slowly, at 100 Hz."""
    machine = Machine(
        inertia=rng.uniform(0.5e-3, 2e-3),
        damping=rng.uniform(1e-3, 4e-3),
        stiffness=rng.uniform(1.0, 3.0),
        spring_damping=5e-3,
        pull=rng.uniform(0.4, 0.8),
    )
    share, torque = rng.uniform(0.03, 0.08), rng.uniform(0.03, 0.08)
    frictions = {
        "guides": Friction(share=share),
        "constant": Friction(torque),
        "both": Friction(torque, share),
    }
    machine = replace(machine, friction=frictions[hidden])
    time, motor = grid(30.0, 100.0), sines(rng, 0.6, 0.1, 1.0, 5)
    joint = driven_by_position(machine, time, motor)
    recording = et.Measurement(
        time=time,
        motor_position=sampled(motor, time),
        signals={"joint_position": noisy(rng, joint, 5e-4)},
    )
    both = (*DRY, "tendon_guide_friction", *(f"{name} tendon_guide_friction" for name in DRY))
    return Case(given(rng, machine, slack=1), (recording,), right(*both))


def stick_slip(rng: np.random.Generator, hidden: str) -> Case:
    """A mass that is drawn slowly to and fro behind a soft spring and never rests."""
    sliding = rng.uniform(0.2, 0.4)
    frictions = {
        "weak": Friction(sliding, more=0.3 * sliding, slow=0.03),
        "strong": Friction(sliding, more=0.8 * sliding, slow=0.05),
        "quick": Friction(sliding, more=0.6 * sliding, slow=0.15),
    }
    machine = Machine(
        inertia=rng.uniform(0.05, 0.1),
        damping=rng.uniform(0.02, 0.06),
        stiffness=rng.uniform(8.0, 15.0),
        spring_damping=0.05,
        friction=frictions[hidden],
    )
    slope, turn = rng.uniform(0.08, 0.15), rng.uniform(4.0, 6.0)

    def motor(at: float) -> tuple[float, float]:
        phase = at % (2.0 * turn)
        there = phase < turn
        return (slope * phase, slope) if there else (slope * (2.0 * turn - phase), -slope)

    time = grid(20.0, 200.0)
    joint = driven_by_position(machine, time, motor)
    recording = et.Measurement(
        time=time,
        motor_position=sampled(motor, time),
        signals={"joint_position": noisy(rng, joint, 2e-4)},
    )
    return Case(given(rng, machine), (recording,), right("stribeck_friction", "lugre_friction"))


def laminate_spring(rng: np.random.Generator, hidden: str) -> Case:
    """A leaf spring that is loaded step by step, up, down and up again."""
    stiffness, most = rng.uniform(20.0, 60.0), 0.25
    slips = most * np.array([0.04, 0.08, 0.15, 0.3])
    shares = np.full(4, rng.uniform(0.06, 0.12)) if hidden != "hardening" else np.zeros(4)
    cubic = 0.0 if hidden == "leaves" else rng.uniform(0.4, 0.8) * stiffness / most**2
    turns = most * np.array([0.0, 1.0, -1.0, 1.0, -0.6, 0.6, 0.0])
    bent = np.concatenate([np.linspace(*pair, 25) for pair in pairwise(turns)])
    torque = laminate(bent, stiffness, cubic, slips, shares)
    recording = et.Measurement(
        time=10.0 * np.arange(len(bent), dtype=np.float64),
        motor_position=np.zeros(len(bent)),
        load_torque=noisy(rng, torque, 2e-3 * stiffness * most),
        signals={"joint_position": noisy(rng, bent, 2e-4)},
        static=True,
    )
    machine = Machine(inertia=0.05, damping=0.05, stiffness=stiffness)
    leaves = ("spring_hysteresis", "spring_hysteresis coulomb_friction")
    named = {
        "leaves": right(*leaves),
        "hardening": right("spring_hardening"),
        "both": right(*(f"{names} spring_hardening" for names in leaves)),
    }
    return Case(given(rng, machine), (recording,), named[hidden])


def flexible_shaft(rng: np.random.Generator, hidden: str) -> Case:
    """Two masses and a shaft, driven by a known motor torque."""
    inertia = rng.uniform(0.01, 0.04)
    machine = Machine(
        inertia=inertia,
        damping=rng.uniform(0.02, 0.06),
        stiffness=inertia * (2.0 * np.pi * rng.uniform(4.0, 8.0)) ** 2,
        spring_damping=rng.uniform(0.005, 0.02),
        motor_inertia=rng.uniform(0.5, 1.5) * inertia,
        motor_damping=rng.uniform(0.02, 0.06),
    )
    changes: dict[str, dict[str, Any]] = {
        "friction": {"motor_friction": Friction(rng.uniform(0.05, 0.15))},
        "play": {"gap": rng.uniform(0.01, 0.03)},
        "gravity": {"gravity": rng.uniform(0.1, 0.3)},
    }
    machine = replace(machine, **changes[hidden])
    time, push = grid(10.0, 500.0), sines(rng, 0.8, 0.3, 10.0, 11)
    turned, joint, torque = driven_by_torque(machine, time, lambda at, *_: push(at)[0])
    recording = et.Measurement(
        time=time,
        motor_position=noisy(rng, turned, 1e-4),
        signals={"joint_position": noisy(rng, joint, 1e-4), "motor_torque": torque},
    )
    named = {
        "friction": right("motor_friction", *DRY),
        "play": right("gear_backlash"),
        "gravity": right("gravity_load"),
    }
    return Case(given(rng, machine, motor=True), (recording,), named[hidden])


def pendulum_servo(rng: np.random.Generator, hidden: str) -> Case:
    """A geared servo with a pendulum; its torque is known by the current, up to a gain."""
    inertia, gain = rng.uniform(0.02, 0.05), rng.uniform(0.8, 1.2)
    weight = rng.uniform(0.8, 1.6)
    frictions = {
        "plain": Friction(),
        "friction": Friction(rng.uniform(0.1, 0.2)),
        "gear": Friction(rng.uniform(0.05, 0.1), share=rng.uniform(0.1, 0.2)),
    }
    machine = Machine(
        inertia=inertia,
        damping=rng.uniform(0.03, 0.1),
        stiffness=inertia * (2.0 * np.pi * 25.0) ** 2,
        spring_damping=0.5,
        gravity=weight,
        motor_inertia=rng.uniform(0.3, 0.6) * inertia,
        motor_damping=rng.uniform(0.02, 0.06),
        motor_friction=frictions[hidden],
    )
    time, wanted = grid(12.0, 500.0), sines(rng, 0.6, 0.3, 2.0, 5)

    def controlled(at: float, turned: float, speed: float) -> float:
        position, velocity = wanted(at)
        return 20.0 * (position - turned) + 1.0 * (velocity - speed)

    turned, joint, torque = driven_by_torque(machine, time, controlled)
    recording = et.Measurement(
        time=time,
        motor_position=noisy(rng, turned, 3e-4),
        signals={"joint_position": noisy(rng, joint, 3e-4), "motor_torque": gain * torque},
    )
    dry = [f"gravity_load {name}{gained}" for name in ("motor_friction", *DRY) for gained in GAINED]
    named = {
        "plain": right("gravity_load", "gravity_load motor_torque_gain"),
        "friction": right(*dry),
        # a gain is a loss while the motor drives its load
        "gear": right(*dry, *(f"{names} gear_loss" for names in ("gravity_load", *dry))),
    }
    return Case(given(rng, machine, motor=True), (recording,), named[hidden])


def many_logs(rng: np.random.Generator, hidden: str) -> Case:
    """Sixteen logs of 6 s of one antagonistic joint at 200 Hz, with loads."""
    machine = Machine(
        inertia=rng.uniform(0.02, 0.05),
        damping=rng.uniform(0.1, 0.2),
        stiffness=rng.uniform(25.0, 50.0),
        spring_damping=0.05,
        pull=rng.uniform(2.0, 4.0),
    )
    changes: dict[str, dict[str, Any]] = {
        "friction": {"friction": Friction(rng.uniform(0.1, 0.3))},
        "gravity": {"gravity": rng.uniform(0.3, 0.8)},
        "both": {
            "friction": Friction(rng.uniform(0.1, 0.3)),
            "gravity": rng.uniform(0.3, 0.8),
        },
    }
    machine = replace(machine, **changes[hidden])
    time, recordings = grid(6.0, 200.0), []
    for number in range(16):
        motor, load = sines(rng, 0.5, 0.3, 3.0, 5), sines(rng, 1.0, 0.4, 2.0, 3)
        joint = driven_by_position(machine, time, motor, load)
        recordings.append(
            et.Measurement(
                time=time,
                motor_position=sampled(motor, time),
                load_torque=sampled(load, time),
                signals={"joint_position": noisy(rng, joint, 3e-4)},
                name=f"log {number:02d}",
            )
        )
    named = {
        "friction": right(*DRY),
        "gravity": right("gravity_load"),
        "both": right(*(f"{name} gravity_load" for name in DRY)),
    }
    return Case(given(rng, machine, slack=1), tuple(recordings), named[hidden])


KINDS: dict[Callable[[np.random.Generator, str], Case], tuple[str, ...]] = {
    series_elastic: ("friction", "hardening", "gravity"),
    cable_drive: ("guides", "constant", "both"),
    stick_slip: ("weak", "strong", "quick"),
    laminate_spring: ("leaves", "hardening", "both"),
    flexible_shaft: ("friction", "play", "gravity"),
    pendulum_servo: ("plain", "friction", "gear"),
    many_logs: ("friction", "gravity", "both"),
}


def orders(*, reported: bool) -> Iterator[Order]:
    """Three machines of each kind; those reported have seeds from which nothing was tuned."""
    seed = FIRST_REPORTED_SEED if reported else 0
    for kind, variations in KINDS.items():
        for hidden in variations:
            yield Order(kind.__name__, hidden, seed)
            seed += 1


def made(order: Order) -> Case:
    """Make the recordings of an order."""
    kind = next(kind for kind in KINDS if kind.__name__ == order.kind)
    return kind(np.random.default_rng([7, order.seed]), order.hidden)
