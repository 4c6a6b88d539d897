"""Cases of the study: what the tool gets, and the facts it never gets.

    from hidden_effect.cases import build, Order
    case = build(Order("effect", ("coulomb_friction",), ratio=1.0, seed=7))

`Order` says what is wanted, `build` makes the same case of it every time.
"""

import math
from dataclasses import dataclass, field, replace
from zlib import crc32

import numpy as np

from elastic_tendon.actuator.parameters import Model, parse_model
from elastic_tendon.measurement import Measurement
from elastic_tendon.native.interpolation import Interpolation
from hidden_effect import machines, motions, recordings
from hidden_effect.machines import Hidden, Reached, Tree, get, sigma_of, with_effects, with_numbers
from hidden_effect.recordings import QUANTISED, Noise
from hidden_effect.refit import Target, base_numbers, refit, rivals, started
from truth.catalogue import actuator_of
from truth.fast import FastRun, Inputs, Player, TruthError
from truth.outside import OTHER_LAWS, OUTSIDE, Law, foreign_run
from truth.signals import Experiment

FAMILIES = ("effect", "nothing", "wrong parameter", "two effects", "outside", "other law")
FIRST_REPORTED_SEED = 1000

SMALLEST_NOISE, LARGEST_NOISE = 2e-5, 6e-4  # rad
ORDINARY_NOISE = (5e-5, 3e-4)  # rad
TYPICAL = (0.4, 2.5)  # strengths, of the typical one
BELIEVED = 0.3  # how far off the given numbers are, in their standard deviations
RATIO_ERROR = 0.05
STRONGEST = 30.0  # of the typical strength
# no strength of these shows beside refitted springs, so R cannot be ordered
ALIASED = ("tendon_compliance",)
SEARCHES, FOREIGN_SEARCHES = 12, 5
WRONG = 0.3  # share by which wrong parameters are wrong
WRONG_PATHS = (
    *("transmission.upper_spring.stiffness", "transmission.lower_spring.stiffness"),
    *("transmission.pretension_force", "link.inertia", "link.damping"),
)


class UnreachableError(Exception):
    """A case that cannot be: the effect does not show in this experiment."""


@dataclass(frozen=True)
class Order:
    """What a case shall be; see `FAMILIES`, `motions.KINDS`, `recordings.NOISES`."""

    family: str
    effects: tuple[str, ...] = ()
    ratio: float = 0.0  # R
    experiment: str = "multisine"
    noise: str = "white"
    seed: int = 0
    torque: bool = False  # whether the joint's torque is recorded too
    interpolation: Interpolation = "cubic"
    duration: float = motions.DURATION  # s

    @property
    def name(self) -> str:
        """For tables and files."""
        parts = [self.family, "+".join(self.effects) or "none", f"R{self.ratio:g}"]
        parts += [self.experiment, self.noise, str(self.seed)]
        parts += ["torque"] * self.torque + [self.interpolation] * (self.interpolation != "cubic")
        parts += [f"{self.duration:g}s"] * (self.duration != motions.DURATION)
        return "_".join(parts).replace(" ", "-")


@dataclass(frozen=True)
class Facts:
    """What the tool never gets.

    `truth` : content of the true model.toml, without effects of another kind. `numbers` : true
    values by dotted path, of the catalogue's effects and of the base. `floor` and `heldout_floor` :
    RMSE of the true system by signal. `sigma` : noise of the joint's encoder, rad. `ratio` : R as
    reached. `inputs`, `start` : the fitted experiment without noise.
    """

    truth: Tree
    numbers: dict[str, float]
    floor: dict[str, float]
    heldout_floor: dict[str, float]
    noise: Noise
    torque_sigma: float
    ratio: float
    reached: Reached
    inputs: Inputs
    start: tuple[float, float]


@dataclass(frozen=True)
class Case:
    """One question to the tool (`given`, `fit`, `validation`) and its answer (`facts`)."""

    order: Order
    given: Model
    fit: tuple[Measurement, ...]
    validation: tuple[Measurement, ...]
    facts: Facts = field(repr=False)

    @property
    def name(self) -> str:
        """For tables and files."""
        return self.order.name


def generator(order: Order, purpose: str) -> np.random.Generator:
    """Random numbers of a case for one purpose; R and noise do not change the machine."""
    key = f"{order.family} {order.effects} {order.experiment} {purpose}"
    return np.random.default_rng([crc32(key.encode()), order.seed])


def believed(tree: Tree, rng: np.random.Generator) -> Tree:
    """The numbers that somebody believes in, a little off."""
    numbers = {}
    for path in machines.UNCERTAINTY:
        value, sigma = get(tree, path), sigma_of(tree, path)
        if value:
            numbers[path] = value + BELIEVED * float(np.clip(rng.standard_normal(), -2, 2)) * sigma
    return with_numbers(tree, numbers)


@dataclass(frozen=True)
class Machine:
    """A machine in an experiment: the truth without effects, and what is believed of it."""

    tree: Tree
    given: Tree
    experiment: Experiment
    inputs: Inputs
    start: tuple[float, float]
    reached: Reached


def machine_of(order: Order) -> Machine:
    """The machine and the experiment of a case."""
    rng = generator(order, "machine")
    tree = machines.actuator(rng)
    given = tree if order.family == "nothing" else believed(tree, rng)
    return machine_in(order, tree, given, int(rng.integers(1 << 30)))


def machine_in(order: Order, tree: Tree, given: Tree, seed: int) -> Machine:
    """The machine in an experiment of the ordered kind."""
    experiment = motions.experiment_of(order.experiment, tree, seed, order.duration)
    return Machine(
        tree,
        given,
        experiment,
        motions.inputs_of(experiment),
        motions.start_of(experiment),
        motions.reached_by(tree, experiment),
    )


def recorded_inputs(machine: Machine, truth: Tree) -> Inputs:
    """Inputs as the motor's encoder shows them."""
    offset = get(truth, "effects.motor_encoder_offset.offset")
    return replace(machine.inputs, motor_position=machine.inputs.motor_position + offset)


def target_of(inputs: Inputs, machine: Machine, run: FastRun, noise: Noise) -> Target:
    """A run as what a refit has to meet."""
    return Target(
        Player(inputs), machine.start, run.joint_position, noise.sigma,
        correlation=noise.correlation,
    )  # fmt: skip


def left_of(machine: Machine, inputs: Inputs, run: FastRun, noise: Noise) -> float:
    """RMS (rad) that the base model, refitted within its uncertainty, leaves of a run."""
    # not whitened: R is a ratio of standard deviations
    target = target_of(inputs, machine, run, replace(noise, kind="white"))
    # from the true numbers, so that no basin is mistaken for the best
    numbers = started(base_numbers(machine.given), machine.tree)
    best = refit(machine.given, numbers, [target])
    return math.sqrt(best.chi2 / target.count) * noise.sigma


def first_noise(order: Order, rng: np.random.Generator) -> Noise:
    """The noise to begin with."""
    low, high = (math.log(one) for one in ORDINARY_NOISE)
    sigma = float(np.exp(rng.uniform(low, high)))
    return Noise(order.noise, QUANTISED if order.noise == "quantised" else sigma)


@dataclass(frozen=True)
class Tuned:
    """A truth whose hidden effect is `ratio` as strong as the noise."""

    truth: Tree
    strength: float
    noise: Noise
    ratio: float


def tuned(
    order: Order,
    machine: Machine,
    hidden: Hidden,
    rng: np.random.Generator,
    fixed: Noise | None = None,
) -> Tuned:
    """The strength of an effect and the noise at which the ordered R is reached.

    A typical strength is kept where noise between SMALLEST and LARGEST gives R; where it does not,
    or where the noise is `fixed` or that of counts, the strength is found by a search.

    Raises
    ------
    UnreachableError : no strength does it
    """
    strength = float(np.exp(rng.uniform(*np.log(TYPICAL))))
    noise = fixed or first_noise(order, rng)
    tuning = Tuning(machine, hidden)
    left = tuning.left(strength, noise)
    if fixed is None and order.noise != "quantised" and 0.0 < left < math.inf:
        wanted = left / order.ratio
        if SMALLEST_NOISE < wanted < LARGEST_NOISE:
            noise = replace(noise, sigma=wanted)
            left = tuning.left(strength, noise)
    low, high = 0.0, math.inf
    for _ in range(SEARCHES):
        ratio = left / noise.sigma
        if abs(ratio / order.ratio - 1.0) < RATIO_ERROR:
            return Tuned(tuning.truth(strength), strength, noise, ratio)
        low, high = (strength, high) if ratio < order.ratio else (low, strength)
        factor = float(np.clip(order.ratio / max(ratio, 1e-3 * order.ratio), 0.1, 6.0))
        if not low < factor * strength < high:
            between = math.sqrt(low * high) if 0.0 < low < high < math.inf else 0.5 * (low + high)
            factor = between / strength
        strength *= factor
        if strength > STRONGEST:
            break
        left = tuning.left(strength, noise)
    ratio = left / noise.sigma
    raise UnreachableError(f"{order.name}: R is {ratio:.3g} at strength {strength:.3g}")


@dataclass(frozen=True)
class Tuning:
    """An effect on a machine, to be tried at several strengths."""

    machine: Machine
    hidden: Hidden

    def truth(self, strength: float) -> Tree:
        """The machine with the effect."""
        effect = (self.hidden.effect, self.hidden.at(strength))
        return with_effects(self.machine.tree, [effect])

    def left(self, strength: float, noise: Noise) -> float:
        """What the refitted base model leaves, rad; infinite where the joint runs away."""
        truth = self.truth(strength)
        inputs = recorded_inputs(self.machine, truth)
        try:
            # the encoder's offset is taken off again inside
            run = Player(inputs).run(truth, self.machine.start)
            return left_of(self.machine, inputs, run, noise)
        except TruthError:
            return math.inf


def typical(order: Order, machine: Machine, hidden: Hidden, rng: np.random.Generator) -> Tuned:
    """An effect that other numbers of the base model make up for, as strong as it usually is."""
    strength, noise = float(np.exp(rng.uniform(*np.log(TYPICAL)))), first_noise(order, rng)
    tuning = Tuning(machine, hidden)
    ratio = tuning.left(strength, noise) / noise.sigma
    return Tuned(tuning.truth(strength), strength, noise, ratio)


def torque_noise(order: Order, tree: Tree, noise: Noise) -> float:
    """Noise of the joint's torque, N·m: as loud as that of the encoder times the stiffness."""
    return noise.sigma * machines.sizes_of(tree).stiffness if order.torque else 0.0


def recording_of(
    order: Order, machine: Machine, truth: Tree, noise: Noise, purpose: str
) -> recordings.Shown:
    """What is recorded of a machine of the catalogue's laws."""
    rng = generator(order, f"noise {purpose} {order.ratio} {order.noise}")
    inputs = recorded_inputs(machine, truth)
    player = Player(inputs)
    undisturbed = disturbed = player.run(truth, machine.start)
    if order.noise == "disturbance":
        rms = recordings.DISTURBANCE * noise.sigma * machines.sizes_of(truth).stiffness
        load = inputs.load_torque + recordings.disturbance(rng, inputs.time, rms)
        disturbed = Player(replace(inputs, load_torque=load)).run(truth, machine.start)
    return recordings.shown(
        f"{order.name} {purpose}", inputs, disturbed, undisturbed, noise,
        torque_noise(order, truth, noise), rng, order.interpolation,
    )  # fmt: skip


def heldout_machine(order: Order, machine: Machine) -> Machine:
    """The same machine in another experiment of the kind."""
    seed = int(generator(order, "validation").integers(1 << 30))
    return machine_in(order, machine.tree, machine.given, seed)


def numbers_by_path(truth: Tree) -> dict[str, float]:
    """True numbers of base and effects by dotted path."""
    numbers = {path: get(truth, path) for path in machines.UNCERTAINTY}
    for effect, values in truth.get("effects", {}).items():
        numbers |= {f"effects.{effect}.{name}": value for name, value in values.items()}
    return numbers


def assembled(order: Order, machine: Machine, truth: Tree, noise: Noise, ratio: float) -> Case:
    """A case of a truth with laws of the catalogue."""
    other = heldout_machine(order, machine)
    fitted = recording_of(order, machine, truth, noise, "fit")
    heldout = recording_of(order, other, truth, noise, "validation")
    return finished(order, machine, truth, noise, ratio, fitted, heldout)


def finished(
    order: Order, machine: Machine, truth: Tree, noise: Noise, ratio: float,
    fitted: recordings.Shown, heldout: recordings.Shown,
) -> Case:  # fmt: skip
    """A case of its recordings."""
    facts = Facts(
        truth, numbers_by_path(truth), fitted.floor, heldout.floor, noise,
        torque_noise(order, truth, noise), ratio, machine.reached,
        recorded_inputs(machine, truth), machine.start,
    )  # fmt: skip
    return Case(
        order, parse_model(machine.given, "given"), (fitted.measurement,), (heldout.measurement,),
        facts,
    )  # fmt: skip


# ---- families ------------------------------------------------------------------------------------


def effect_case(order: Order) -> Case:
    """One effect of the catalogue."""
    machine, rng = machine_of(order), generator(order, "effect")
    sizes = machines.sizes_of(machine.tree)
    hidden = machines.hidden_numbers(order.effects[0], sizes, machine.reached, rng)
    found = (typical if order.effects[0] in ALIASED else tuned)(order, machine, hidden, rng)
    return assembled(order, machine, found.truth, found.noise, found.ratio)


def nothing_case(order: Order) -> Case:
    """Nothing is missing, and the given numbers are the true ones."""
    machine = machine_of(order)
    noise = first_noise(order, generator(order, "effect"))
    return assembled(order, machine, machine.tree, noise, 0.0)


def wrong_case(order: Order) -> Case:
    """One to three numbers are 30 % off, within what the model says of them."""
    machine, rng = machine_of(order), generator(order, "effect")
    wrong = rng.choice(len(WRONG_PATHS), int(rng.integers(1, 4)), replace=False)
    paths = [WRONG_PATHS[i] for i in sorted(wrong)]
    numbers = {
        path: get(machine.tree, path) * (1.0 + WRONG * float(rng.choice([-1.0, 1.0])))
        for path in paths
    }
    given = with_numbers(machine.tree, numbers)
    given["uncertainty"] = {path: max(WRONG, machines.UNCERTAINTY[path]) for path in paths}
    noise = first_noise(order, rng)
    return assembled(order, replace(machine, given=given), machine.tree, noise, 0.0)


def two_case(order: Order) -> Case:
    """Two effects, each as strong alone as ordered, beside the noise of the first.

    Raises
    ------
    UnreachableError : one of them does not show beside the other, as a stop that is never reached
    """
    machine, rng = machine_of(order), generator(order, "effect")
    sizes = machines.sizes_of(machine.tree)
    found: list[Tuned] = []
    for effect in order.effects:
        hidden = machines.hidden_numbers(effect, sizes, machine.reached, rng)
        fixed = found[0].noise if found else None
        found.append(tuned(order, machine, hidden, rng, fixed))
    together = [pair for one in found for pair in one.truth["effects"].items()]
    truth, noise = with_effects(machine.tree, together), found[0].noise
    player = Player(recorded_inputs(machine, truth))
    whole = player.run(truth, machine.start).joint_position
    for effect, rest in zip(order.effects, reversed(found), strict=True):
        shown = whole - player.run(rest.truth, machine.start).joint_position
        if np.sqrt(np.mean(shown**2)) < noise.sigma:
            raise UnreachableError(f"{order.name}: beside the other, {effect} does not show")
    return assembled(order, machine, truth, noise, min(one.ratio for one in found))


@dataclass(frozen=True)
class Foreign:
    """A law of another kind on one machine, at a strength, and the noise to go with it."""

    law: Law
    strength: float
    noise: Noise
    ratio: float

    def run_on(self, machine: Machine) -> FastRun:
        """What the sensors show."""
        return foreign_run(
            self.law, self.strength, actuator_of(machine.tree), machine.experiment, machine.inputs
        )


def tuned_foreign(order: Order, machine: Machine, rng: np.random.Generator) -> Foreign:
    """A law at random, whose strength and noise give the ordered R."""
    law = (OUTSIDE | OTHER_LAWS)[order.effects[0]](
        rng, actuator_of(machine.tree), machine.reached.elongation
    )
    noise = first_noise(order, rng)
    found = Foreign(law, float(np.exp(rng.uniform(*np.log(TYPICAL)))), noise, 0.0)
    for _ in range(FOREIGN_SEARCHES):
        left = left_of(machine, machine.inputs, found.run_on(machine), noise)
        if order.noise != "quantised":
            sigma = float(np.clip(left / order.ratio, SMALLEST_NOISE, LARGEST_NOISE))
            noise = replace(noise, sigma=sigma)
        found = replace(found, noise=noise, ratio=left / noise.sigma)
        if abs(found.ratio / order.ratio - 1.0) < 3.0 * RATIO_ERROR:
            return found
        factor = float(np.clip(order.ratio / found.ratio, 0.1, 10.0))
        found = replace(found, strength=found.strength * factor)
    raise UnreachableError(f"{order.name}: R is {found.ratio:.3g}")


def foreign_case(order: Order) -> Case:
    """An effect that is not in the catalogue, or one of it by another law."""
    machine = machine_of(order)
    found = tuned_foreign(order, machine, generator(order, "effect"))

    def recorded(on: Machine, purpose: str) -> recordings.Shown:
        rng, run = (
            generator(order, f"noise {purpose} {order.ratio} {order.noise}"),
            found.run_on(on),
        )
        return recordings.shown(
            f"{order.name} {purpose}", on.inputs, run, run, found.noise,
            torque_noise(order, on.tree, found.noise), rng, order.interpolation,
        )  # fmt: skip

    fitted = recorded(machine, "fit")
    heldout = recorded(heldout_machine(order, machine), "validation")
    return finished(order, machine, machine.tree, found.noise, found.ratio, fitted, heldout)


BUILDERS = {
    "effect": effect_case,
    "nothing": nothing_case,
    "wrong parameter": wrong_case,
    "two effects": two_case,
    "outside": foreign_case,
    "other law": foreign_case,
}


def build(order: Order) -> Case:
    """The case that is ordered, always the same.

    Raises
    ------
    UnreachableError : the effect does not show in the experiment
    """
    return BUILDERS[order.family](order)


def rivals_of(case: Case, effect: str) -> dict[str, float]:
    """ΔBIC over the true `effect` of every rival's best noise-free refit, see `refit.rivals`."""
    facts = case.facts
    run = Player(facts.inputs).run(facts.truth, facts.start)
    target = Target(
        Player(facts.inputs), facts.start, run.joint_position, facts.noise.sigma,
        run.joint_torque if facts.torque_sigma > 0.0 else None, facts.torque_sigma or 1.0,
        facts.noise.correlation,
    )  # fmt: skip
    given = case.given.model_dump(exclude_none=True)
    return rivals(given, facts.truth, effect, [target], facts.reached)
