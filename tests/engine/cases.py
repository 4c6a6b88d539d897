"""Questions for the diagnosis: machines of MuJoCo, and a model that lacks what hides in them.

from engine.cases import build, orders
case = build(Order("dry_joint", "waves", seed=0))
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from zlib import crc32

import numpy as np

from elastic_tendon.actuator.parameters import Model, parse_model
from elastic_tendon.measurement import Measurement
from engine.machines import MACHINES, Answer, Base, Hidden, Machine, Tree, machine_of
from engine.motions import KINDS
from engine.play import DURATION, Played, motion_for, play, recorded

FIRST_REPORTED_SEED = 1000
QUIETEST, LOUDEST = 1.5e-4, 3e-4  # rad, noise of the joint's encoder
STIFFNESS, PRETENSION, INERTIA = 0.1, 0.3, 0.3  # one sigma of the default prior, relative
DAMPING = 0.5  # share by which a damping is off at most
HELD_OUT = 500  # added to the seed of the motion that is not fitted


@dataclass(frozen=True)
class Order:
    """Which machine in which motion; `bare`: without what hides in it. `duration` in s."""

    machine: str
    motion: str
    seed: int
    bare: bool = False
    duration: float = DURATION

    @property
    def name(self) -> str:
        """For tables and files."""
        name = f"{self.machine}{'-bare' if self.bare else ''}_{self.motion}_{self.seed}"
        return name if self.duration == DURATION else f"{name}_{self.duration:g}s"


@dataclass(frozen=True)
class Case:
    """A question (`given`, `fit`, `validation`) and what is a right answer.

    `hidden` : what the machine has, in words of `machines.MACHINES`; `accepted` : sets of effects
    that are right, the empty one where nothing is missing; `unknown` : "unexplained" is right;
    `floor_rmse` : noise of the fitted recordings, rad RMS; `true` : the right model, None where no
    law of the catalogue is what hides; `most_error` : of a right answer, in units of the noise.
    """

    name: str
    hidden: str
    given: Model
    fit: tuple[Measurement, ...]
    validation: tuple[Measurement, ...]
    accepted: frozenset[Answer]
    unknown: bool
    floor_rmse: float
    most_error: float
    true: Model | None = field(repr=False)

    def names_right(self, verdict: str, named: Answer) -> bool:
        """Whether the answer says what hides, its error aside."""
        if verdict in ("unexplained", "unknown_effect"):
            return self.unknown
        return named in self.accepted

    def right(self, verdict: str, named: Answer, error: float) -> bool:
        """Whether the answer is right, with its error (rad RMS)."""
        explained = verdict not in ("unexplained", "unknown_effect")
        near = not explained or error <= self.most_error * self.floor_rmse
        return near and self.names_right(verdict, named)


def believed(base: Base, rng: np.random.Generator) -> Tree:
    """The numbers that somebody believes in: each off by up to one sigma."""

    def off(share: float) -> float:
        return 1.0 + share * float(rng.uniform(-1.0, 1.0))

    tree = base.tree()
    transmission, link = tree["transmission"], tree["link"]
    transmission["upper_spring"]["stiffness"] *= off(STIFFNESS)
    transmission["lower_spring"]["stiffness"] *= off(STIFFNESS)
    transmission["pretension_force"] *= off(PRETENSION)
    link["inertia"] *= off(INERTIA)
    link["damping"] *= off(DAMPING)
    return tree


def generator(order: Order, purpose: str) -> np.random.Generator:
    """Random numbers of a case for one purpose."""
    return np.random.default_rng([crc32(f"{order.name} {purpose}".encode()), order.seed])


def true_model(machine: Machine) -> Model | None:
    """The model that says all of a machine, None where the catalogue lacks its law."""
    if machine.hidden.effects is None:
        return None
    return parse_model(machine.true.tree() | {"effects": machine.hidden.effects}, "true")


def played(order: Order, held_out: bool) -> Played:
    """What the machine does, without noise."""
    machine = machine_of(order.machine, order.seed)
    seed = order.seed + (HELD_OUT if held_out else 0)
    motion = motion_for(machine, order.motion, seed, order.duration)
    return play(machine.bare if order.bare else machine, motion)


def build(order: Order) -> Case:
    """The case, always the same."""
    machine = machine_of(order.machine, order.seed)
    machine = machine.bare if order.bare else machine
    sigma = float(generator(order, "noise level").uniform(QUIETEST, LOUDEST))
    runs = {purpose: played(order, purpose == "validation") for purpose in ("fit", "validation")}
    recordings = {
        purpose: recorded(f"{order.name} {purpose}", run, sigma, generator(order, purpose))
        for purpose, run in runs.items()
    }
    noise = recordings["fit"].signals["joint_position"] - runs["fit"].joint_position
    return Case(
        name=order.name,
        hidden="nothing" if order.bare else MACHINES[order.machine].__name__,
        given=parse_model(believed(machine.base, generator(order, "given")), "given"),
        fit=(recordings["fit"],),
        validation=(recordings["validation"],),
        accepted=accepted_of(machine.hidden, runs["fit"]),
        unknown=machine.hidden.unknown,
        floor_rmse=float(np.sqrt(np.mean(noise**2))),
        most_error=machine.hidden.most_error,
        true=true_model(machine),
    )


def accepted_of(hidden: Hidden, fitted: Played) -> frozenset[Answer]:
    """Right answers; without the stop too, where the fitted run does not come to it."""
    if float(np.max(fitted.joint_position)) > hidden.stop:
        return hidden.accepted
    return hidden.accepted | {answer - {"joint_stop"} for answer in hidden.accepted}


def orders(reported: bool, rounds: int = 1, bare: bool = True) -> Iterator[Order]:
    """All cases, those with something hidden first.

    Parameters
    ----------
    reported : seeds from which nothing was tuned, else those of development
    rounds : seeds of each
    bare : whether machines without their hidden part are asked about too
    """
    first = FIRST_REPORTED_SEED if reported else 0
    for without in (False, True) if bare else (False,):
        for seed in range(first, first + rounds):
            for machine, make in MACHINES.items():
                # what hides nothing is bare already
                if without and make.__name__ == "nothing":
                    continue
                for motion in KINDS:
                    yield Order(machine, motion, seed, without)
