"""What no catalogue holds, and what it holds by another law.

A law is made of random numbers for an actuator without effects; `Law.applied` gives the actuator
and experiment that a `solver` run takes at some strength, 1 being typical. Torques that depend on
the springs are exact for springs without damper and memory, and good enough for damped ones.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from truth.actuator import Actuator
from truth.fast import FastRun, Inputs
from truth.friction import Coulomb, Dahl, HessSoom
from truth.hysteresis import exponential_slip
from truth.link import no_torque
from truth.signals import Experiment, Signal, rectangular_pulse, total
from truth.solver import simulate
from truth.spring import Spring

Vector = NDArray[np.float64]
Torque = Callable[[float, float, float], float]
Applied = Callable[[float, Actuator, Experiment], tuple[Actuator, Experiment]]

TOLERANCE = 1e-8  # far below the noise of any sensor


def unchanged(_strength: float, position: Vector) -> Vector:
    """What a true encoder shows, rad."""
    return position


@dataclass(frozen=True)
class Law:
    """How an effect changes actuator and experiment, and what the joint's encoder makes of it."""

    applied: Applied
    encoder: Callable[[float, Vector], Vector] = unchanged


Make = Callable[[np.random.Generator, Actuator, float], Law]


def torque_law(torque: Callable[[Actuator, Experiment], Torque]) -> Law:
    """A law that adds `strength` times a torque to the joint."""

    def applied(
        strength: float, actuator: Actuator, experiment: Experiment
    ) -> tuple[Actuator, Experiment]:
        own = torque(actuator, experiment)
        link = replace(
            actuator.link,
            extra_torque=no_torque if strength == 0.0 else lambda t, q, v: strength * own(t, q, v),
        )
        return replace(actuator, link=link), experiment

    return Law(applied)


def largest_torque(actuator: Actuator) -> float:
    """What the weaker spring bears, at the joint, N·m."""
    return actuator.joint_pulley_radius * min(
        spring.stiffness * spring.max_deflection for spring in actuator.springs
    )


def joint_stiffness(actuator: Actuator) -> float:
    """With both tendons taut, N·m/rad."""
    radius = actuator.joint_pulley_radius
    return radius**2 * sum(spring.stiffness for spring in actuator.springs)


def tautness(actuator: Actuator, experiment: Experiment) -> Callable[[float, float], list[float]]:
    """Elongations (m) of the linear springs at a time and joint position."""

    def lengths(time: float, position: float) -> list[float]:
        return list(actuator.elongations(experiment.motor_position.value(time), position))

    return lengths


# ---- outside the catalogue -----------------------------------------------------------------------


def friction_at_a_place(rng: np.random.Generator, actuator: Actuator, _elongation: float) -> Law:
    """A rough spot: dry friction near one angle of the joint and nowhere else."""
    size = 0.1 * largest_torque(actuator)
    place, width = float(rng.uniform(-0.25, 0.25)), float(rng.uniform(0.04, 0.1))

    def torque(_time: float, position: float, velocity: float) -> float:
        near = math.exp(-(((position - place) / width) ** 2))
        return -size * near * math.tanh(velocity / 0.03)

    return torque_law(lambda *_: torque)


def transmission_ripple(rng: np.random.Generator, _actuator: Actuator, _elongation: float) -> Law:
    """The pulley runs ahead and behind several times a turn, as a toothed belt or a gear does."""
    multiple, phase = int(rng.integers(9, 17)), float(rng.uniform(-math.pi, math.pi))

    def applied(
        strength: float, actuator: Actuator, experiment: Experiment
    ) -> tuple[Actuator, Experiment]:
        motor, size = experiment.motor_position, 0.008 * strength

        def value(time: float) -> float:
            angle = motor.value(time)
            return angle + size * (math.sin(multiple * angle + phase) - math.sin(phase))

        def rate(time: float) -> float:
            turned = multiple * size * math.cos(multiple * motor.value(time) + phase)
            return motor.rate(time) * (1.0 + turned)

        rippled = Signal(value, rate, motor.breakpoints)
        return actuator, replace(experiment, motor_position=rippled)

    return Law(applied)


def cogging(rng: np.random.Generator, actuator: Actuator, _elongation: float) -> Law:
    """Torque ripple of what turns with the joint."""
    size, multiple = 0.03 * largest_torque(actuator), int(rng.integers(12, 24))
    phase = float(rng.uniform(-math.pi, math.pi))
    return torque_law(lambda *_: lambda _t, q, _v: size * math.sin(multiple * q + phase))


def slackening_path(rng: np.random.Generator, actuator: Actuator, _elongation: float) -> Law:
    """Tendons whose path shortens as the joint turns away from its middle, so both lose tension."""
    loss = 0.3 * actuator.pretension_force / max(one.stiffness for one in actuator.springs)
    middle, width = float(rng.uniform(-0.1, 0.1)), float(rng.uniform(0.2, 0.35))

    def torque(actuator: Actuator, experiment: Experiment) -> Torque:
        lengths = tautness(actuator, experiment)

        def lost(time: float, position: float, _velocity: float) -> float:
            less = loss * (1.0 - math.exp(-(((position - middle) / width) ** 2)))
            changes = [
                spring.stiffness * (max(length - less, 0.0) - max(length, 0.0))
                for spring, length in zip(actuator.springs, lengths(time, position), strict=True)
            ]
            return actuator.joint_pulley_radius * (changes[0] - changes[1])

        return lost

    return torque_law(torque)


def softening_spring(_rng: np.random.Generator, _actuator: Actuator, elongation: float) -> Law:
    """Springs that turn softer the longer they are."""

    def softer(spring: Spring, strength: float) -> Spring:
        share = min(0.08 * strength, 0.3)  # of its force, lost at the largest elongation
        return replace(spring, cubic_stiffness=-share * spring.stiffness / elongation**2)

    def applied(
        strength: float, actuator: Actuator, experiment: Experiment
    ) -> tuple[Actuator, Experiment]:
        upper, lower = (softer(spring, strength) for spring in actuator.springs)
        return replace(actuator, upper=upper, lower=lower), experiment

    return Law(applied)


def saturating_loss(rng: np.random.Generator, actuator: Actuator, _elongation: float) -> Law:
    """Damping between the pulleys that grows with their relative speed, and then no more."""
    size, speed = 0.03 * largest_torque(actuator), float(rng.uniform(0.3, 1.0))

    def torque(actuator: Actuator, experiment: Experiment) -> Torque:
        ratio = actuator.motor_pulley_radius / actuator.joint_pulley_radius
        motor = experiment.motor_position
        return lambda t, _q, v: size * math.tanh((ratio * motor.rate(t) - v) / speed)

    return torque_law(torque)


def stiffness_drift(rng: np.random.Generator, _actuator: Actuator, _elongation: float) -> Law:
    """Springs that warm up: stiffness and pretension fall or grow in the course of the run."""
    sign, time_constant = float(rng.choice([-1.0, 1.0])), float(rng.uniform(3.0, 8.0))

    def torque(actuator: Actuator, experiment: Experiment) -> Torque:
        lengths = tautness(actuator, experiment)

        def drift(time: float, position: float, _velocity: float) -> float:
            share = 0.1 * sign * (1.0 - math.exp(-time / time_constant))
            forces = [
                spring.stiffness * max(length, 0.0)
                for spring, length in zip(actuator.springs, lengths(time, position), strict=True)
            ]
            return share * actuator.joint_pulley_radius * (forces[0] - forces[1])

        return drift

    return torque_law(torque)


def unseen_load(rng: np.random.Generator, actuator: Actuator, _elongation: float) -> Law:
    """Something pulls at the link for a second, beside the load cell."""
    size = float(rng.choice([-1.0, 1.0])) * 0.15 * largest_torque(actuator)
    share, duration = float(rng.uniform(0.2, 0.7)), float(rng.uniform(0.4, 1.2))

    def applied(
        strength: float, actuator: Actuator, experiment: Experiment
    ) -> tuple[Actuator, Experiment]:
        pulse = rectangular_pulse(share * experiment.duration, duration, strength * size)
        return actuator, replace(experiment, load_torque=total(experiment.load_torque, pulse))

    return Law(applied)


def encoder_distortion(rng: np.random.Generator, _actuator: Actuator, _elongation: float) -> Law:
    """A joint encoder that is not straight: a cubic error of its angle."""
    sign = float(rng.choice([-1.0, 1.0]))
    return Law(
        lambda _strength, actuator, experiment: (actuator, experiment),
        lambda strength, position: position + 0.2 * sign * strength * position**3,
    )


OUTSIDE: dict[str, Make] = {
    "friction at a place": friction_at_a_place,
    "transmission ripple": transmission_ripple,
    "cogging": cogging,
    "slackening path": slackening_path,
    "softening spring": softening_spring,
    "saturating loss": saturating_loss,
    "stiffness drift": stiffness_drift,
    "unseen load": unseen_load,
    "encoder distortion": encoder_distortion,
}

# ---- of the catalogue, by another law ------------------------------------------------------------


def smooth_friction(_rng: np.random.Generator, actuator: Actuator, _elongation: float) -> Law:
    """Dry friction as a steep smooth curve of velocity."""
    size = 0.03 * largest_torque(actuator)
    return torque_law(lambda *_: lambda _t, _q, v: -size * math.tanh(v / 0.01))


def friction_law(make: Callable[[float], Coulomb | Dahl | HessSoom]) -> Law:
    """A law of friction, of which `make` makes one of a strength."""

    def applied(
        strength: float, actuator: Actuator, experiment: Experiment
    ) -> tuple[Actuator, Experiment]:
        link = replace(actuator.link, friction=make(strength))
        return replace(actuator, link=link), experiment

    return Law(applied)


def dahl(rng: np.random.Generator, actuator: Actuator, _elongation: float) -> Law:
    """Friction of a bristle that yields before it slips."""
    size, yielding = 0.03 * largest_torque(actuator), 0.004 * float(rng.uniform(0.6, 1.6))  # rad
    return friction_law(lambda strength: Dahl(strength * size, strength * size / yielding))


def hess_soom(rng: np.random.Generator, actuator: Actuator, _elongation: float) -> Law:
    """Stribeck's curve by another formula."""
    size, velocity = 0.03 * largest_torque(actuator), 0.1 * float(rng.uniform(0.6, 1.6))
    return friction_law(lambda strength: HessSoom(strength * size, 1.7 * strength * size, velocity))


def maxwell_slip(rng: np.random.Generator, _actuator: Actuator, _elongation: float) -> Law:
    """Hysteresis of springs as parallel elements that slip one after the other."""
    share, count = 0.05 * float(rng.uniform(0.6, 1.6)), 6

    def applied(
        strength: float, actuator: Actuator, experiment: Experiment
    ) -> tuple[Actuator, Experiment]:
        upper, lower = (
            replace(
                spring,
                hysteresis=exponential_slip(
                    0.05 * strength * spring.stiffness * spring.max_deflection,
                    share * spring.max_deflection,
                    count,
                ),
            )
            for spring in actuator.springs
        )
        return replace(actuator, upper=upper, lower=lower), experiment

    return Law(applied)


def one_way_damping(rng: np.random.Generator, actuator: Actuator, _elongation: float) -> Law:
    """Viscous friction in one direction of motion only."""
    sign = float(rng.choice([-1.0, 1.0]))
    stiffness, inertia = joint_stiffness(actuator), actuator.link.inertia
    damping = 0.2 * math.sqrt(stiffness * inertia)
    return torque_law(lambda *_: lambda _t, _q, v: -damping * v if sign * v > 0.0 else 0.0)


OTHER_LAWS: dict[str, Make] = {
    "smooth friction": smooth_friction,
    "Dahl friction": dahl,
    "Hess-Soom friction": hess_soom,
    "Maxwell-slip hysteresis": maxwell_slip,
    "one-way damping": one_way_damping,
}
# which effects of the catalogue a law is one of
MEANT_BY = {
    "smooth friction": ("coulomb_friction", "lugre_friction", "stribeck_friction"),
    "Dahl friction": ("lugre_friction", "coulomb_friction", "stribeck_friction"),
    "Hess-Soom friction": ("stribeck_friction", "lugre_friction"),
    "Maxwell-slip hysteresis": ("spring_hysteresis",),
    "one-way damping": ("directional_damping",),
}


def foreign_run(
    law: Law, strength: float, actuator: Actuator, experiment: Experiment, inputs: Inputs
) -> FastRun:
    """What the sensors show of an actuator with such an effect, at the times of `inputs`."""
    changed, done = law.applied(strength, actuator, experiment)
    run = simulate(changed, done, inputs.time, tolerance=TOLERANCE)
    return FastRun(law.encoder(strength, run["joint_position"]), run["joint_torque"])
