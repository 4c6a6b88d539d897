"""Fresh machines: one to three effects at once, all base numbers wrong, three levels of noise.

    from hidden_effect.fresh import FreshOrder, build_fresh
    case = build_fresh(FreshOrder(seed=3, noise=2e-4))

Each hidden effect alone matters: without it the best noise-free refit of everything else leaves at
least `LEAST` times the noise. What else would explain the recording is found by such refits too,
by the truth's own simulator, never by the tool.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from elastic_tendon.actuator.parameters import Model, parse_model
from elastic_tendon.measurement import Measurement
from hidden_effect import cases, machines, motions, recordings
from hidden_effect.machines import EFFECTS, Hidden, Tree, get, sigma_of, with_effects, with_numbers
from hidden_effect.recordings import Noise
from hidden_effect.refit import (
    CLOSE,
    OFFSETS,
    Target,
    base_numbers,
    compatible,
    free_numbers,
    refit,
    rivals,
    started,
)
from truth.fast import Player, TruthError

Names = frozenset[str]

FIRST_REPORTED_SEED = cases.FIRST_REPORTED_SEED + 232  # those before were looked at by now
NOISES = (2e-5, 2e-4, 6e-4)  # rad
DURATION = 12.0  # s
WEAKEST, STRONGEST = 0.5, 2.5  # of the typical strength
STRONGER = 1.6  # times, for an effect that hardly matters
LEAST = 3.0  # R of dropping each hidden effect
MOST_SIGMAS = 2.0  # by which a given number is off
DAMPING_OFF = 0.6  # share by which a given damping is off at most
TRIES = 30
FARTHEST = 2.0  # times as far as the machine without effects
# nothing here tells it from other springs, so it can be no part of a right answer
DRAWN = tuple(name for name in EFFECTS if name not in cases.ALIASED)
ANGULAR = {"gravity_load", "joint_stop", "pulley_eccentricity"}  # depend on the angle itself
# laws that most recordings do not tell apart, for whoever cannot wait for refits
LIKE_ONE_ANOTHER: tuple[Names, ...] = (
    OFFSETS | {"constant_torque"},  # as long as both tendons are taut
    frozenset({"coulomb_friction", "stribeck_friction", "lugre_friction"}),
)


class NoMachineError(Exception):
    """No machine whose effects all matter was found for a seed."""


@dataclass(frozen=True)
class FreshOrder:
    """Which machine, by seed and noise (rad)."""

    seed: int
    noise: float

    @property
    def name(self) -> str:
        """For tables and files."""
        return f"fresh_{self.seed}_{1e6 * self.noise:g}urad"


@dataclass(frozen=True)
class FreshFacts:
    """What the tool never gets.

    `hidden` : the effects. `truth` : content of the true model.toml. `floor` : noise of the fitted
    recording, rad RMS. `ratios` : effect -> R of dropping it. `alternatives` : other sets whose
    best noise-free refit is within ΔBIC 10 of the truth; empty where the answer is decidable.
    """

    hidden: Names
    truth: Tree
    floor: float
    ratios: dict[str, float]
    alternatives: frozenset[Names]

    @property
    def decidable(self) -> bool:
        """Whether no other set explains the recording as well."""
        return not self.alternatives


@dataclass(frozen=True)
class FreshCase:
    """One question to the tool and its answer (`facts`)."""

    order: FreshOrder
    given: Model
    fit: tuple[Measurement, ...]
    validation: tuple[Measurement, ...]
    facts: FreshFacts = field(repr=False)


@dataclass(frozen=True)
class Drawn:
    """A machine in an experiment, its true numbers, and R of dropping each effect."""

    machine: cases.Machine
    truth: Tree
    ratios: dict[str, float]


def generator(seed: int, purpose: int) -> np.random.Generator:
    """Random numbers of a machine for one purpose."""
    return np.random.default_rng([20250, seed, purpose])


# ---- machines ------------------------------------------------------------------------------------


def believed(tree: Tree, rng: np.random.Generator) -> Tree:
    """Numbers off by draws of the whole prior."""
    numbers = {}
    for path in machines.UNCERTAINTY:
        value = get(tree, path)
        if path.endswith("damping"):
            numbers[path] = value * (1.0 + DAMPING_OFF * float(rng.uniform(-1.0, 1.0)))
        else:
            sigmas = float(np.clip(rng.standard_normal(), -MOST_SIGMAS, MOST_SIGMAS))
            numbers[path] = value + sigmas * sigma_of(tree, path)
    return with_numbers(tree, {path: value for path, value in numbers.items() if value > 0.0})


def machine_of(rng: np.random.Generator) -> cases.Machine:
    """A machine without effects in a rich experiment."""
    tree = machines.actuator(rng)
    given = believed(tree, rng)
    kind = motions.RICH[int(rng.integers(len(motions.RICH)))]
    order = cases.Order("effect", experiment=kind, duration=DURATION)
    return cases.machine_in(order, tree, given, int(rng.integers(1 << 30)))


def drawn_effects(rng: np.random.Generator) -> list[str]:
    """One to three effects that can stand beside one another."""
    wanted, found = int(rng.integers(1, 4)), list[str]()
    for name in rng.permutation(DRAWN).tolist():
        beside = dict.fromkeys(found, 0.0)
        if len(found) < wanted and compatible(name, beside) and len(OFFSETS & {*found, name}) < 2:
            found.append(name)
    return found


def target_of(machine: cases.Machine, truth: Tree, noise: float) -> Target:
    """The noise-free recording."""
    inputs = cases.recorded_inputs(machine, truth)
    player = Player(inputs)
    run = player.run(truth, machine.start)
    reached = max(-machine.reached.lowest, machine.reached.highest)
    if np.max(np.abs(run.joint_position)) > FARTHEST * reached:
        raise TruthError("the joint goes far beyond where it goes without effects")
    return Target(player, machine.start, run.joint_position, noise)


def ratio_without(effect: str, machine: cases.Machine, truth: Tree, target: Target) -> float:
    """R of dropping an effect: all that is left is refitted, from the true numbers."""
    others = {name: values for name, values in truth["effects"].items() if name != effect}
    given = machine.given | {"effects": others}
    known = [one for name, values in others.items() for one in free_numbers(name, {}, values)]
    best = refit(given, started([*base_numbers(given), *known], truth), [target])
    return math.sqrt(best.chi2 / target.count)


def drawn(order: FreshOrder) -> Drawn:
    """The machine of a seed; where an effect hardly matters in it, a stronger one or another.

    Raises
    ------
    NoMachineError : none was found
    """
    rng = generator(order.seed, 0)
    for _ in range(TRIES):
        machine = machine_of(rng)
        sizes = machines.sizes_of(machine.tree)
        hidden = [
            machines.hidden_numbers(name, sizes, machine.reached, rng)
            for name in drawn_effects(rng)
        ]
        strengths = np.exp(
            rng.uniform(math.log(WEAKEST), math.log(STRONGEST), len(hidden))
        ).tolist()
        try:
            found = strengthened(order.noise, machine, hidden, strengths)
        except TruthError:
            continue
        if found is not None:
            return found
    raise NoMachineError(order.name)


def strengthened(
    noise: float, machine: cases.Machine, hidden: list[Hidden], strengths: list[float]
) -> Drawn | None:
    """The machine with effects that all matter, each as strong as that needs; None: one cannot.

    Raises
    ------
    TruthError : the joint runs away
    """
    strengths = list(strengths)
    while True:
        effects = [
            (one.effect, one.at(strength)) for one, strength in zip(hidden, strengths, strict=True)
        ]
        truth = with_effects(machine.tree, effects)
        target = target_of(machine, truth, noise)
        weak = None
        ratios: dict[str, float] = {}
        for number, one in enumerate(hidden):
            ratios[one.effect] = ratio_without(one.effect, machine, truth, target)
            if ratios[one.effect] < LEAST:
                weak = number
                break
        if weak is None:
            return Drawn(machine, truth, ratios)
        strengths[weak] *= STRONGER
        if strengths[weak] > STRONGEST:
            return None


# ---- what else would do --------------------------------------------------------------------------


def alternatives_of(found: Drawn, noise: float) -> frozenset[Names]:
    """Other sets of effects that explain the recording as well: one effect swapped for another."""
    truth, machine = found.truth, found.machine
    target = target_of(machine, truth, noise)
    hidden = frozenset(truth["effects"])
    sets: set[Names] = set()
    for name in sorted(hidden):
        others = rivals(machine.given, truth, name, [target], machine.reached)
        near = {rival for rival, bic in others.items() if bic < CLOSE} - {name}
        sets |= {(hidden - {name}) | ({rival} if rival else set()) for rival in near}
    if len(hidden & OFFSETS) == 1 and not hidden & ANGULAR:
        sets.add(hidden ^ OFFSETS)  # the same motion exactly, however near the refit came to it
    return frozenset(sets)


def known_alternatives(hidden: Names) -> frozenset[Names]:
    """Other sets that often explain a recording as well; no refit is made."""
    return frozenset(
        (hidden - {name}) | {rival}
        for name in hidden
        for alike in LIKE_ONE_ANOTHER
        if name in alike
        for rival in alike - {name}
    )


# ---- cases ---------------------------------------------------------------------------------------


def recording_of(
    name: str, machine: cases.Machine, truth: Tree, noise: Noise, rng: np.random.Generator
) -> recordings.Shown:
    """What is recorded of a machine."""
    inputs = cases.recorded_inputs(machine, truth)
    run = Player(inputs).run(truth, machine.start)
    return recordings.shown(name, inputs, run, run, noise, 0.0, rng, "auto")


def build_fresh(order: FreshOrder, judge: bool = True) -> FreshCase:
    """The case of an order, always the same.

    Parameters
    ----------
    order : FreshOrder
    judge : whether alternatives are found by refits, which takes up to many minutes; else they are
        those that often are

    Raises
    ------
    NoMachineError : no machine whose effects all matter was found
    """
    found = drawn(order)
    machine, noise = found.machine, Noise("white", order.noise)
    fitted = recording_of(
        f"{order.name} fit", machine, found.truth, noise, generator(order.seed, 1)
    )
    validation: tuple[Measurement, ...] = ()
    # the halves of two seeds each, so that either half has all levels of noise
    if order.seed % 2 == 0:
        kind = cases.Order("effect", experiment="multisine", duration=DURATION)
        seed = int(generator(order.seed, 2).integers(1 << 30))
        again = cases.machine_in(kind, machine.tree, machine.given, seed)
        shown = recording_of(
            f"{order.name} validation", again, found.truth, noise, generator(order.seed, 3)
        )
        validation = (shown.measurement,)
    hidden = frozenset(found.truth["effects"])
    facts = FreshFacts(
        hidden=hidden,
        truth=found.truth,
        floor=fitted.floor["joint_position"],
        ratios=found.ratios,
        alternatives=alternatives_of(found, order.noise) if judge else known_alternatives(hidden),
    )
    return FreshCase(
        order, parse_model(machine.given, "given"), (fitted.measurement,), validation, facts
    )


def orders(reported: bool, count: int) -> Iterator[FreshOrder]:
    """So many fresh machines, the levels of noise in turn.

    Parameters
    ----------
    reported : seeds from which nothing was tuned, else those of development
    count : machines
    """
    first = FIRST_REPORTED_SEED if reported else 0
    for number in range(count):
        # two machines of a level, of which one has a validation recording
        yield FreshOrder(first + number, NOISES[number // 2 % len(NOISES)])
