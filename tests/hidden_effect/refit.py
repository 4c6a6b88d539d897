"""Best refits without noise, by the truth's own fast simulator, and from these the classes.

A *class* is all answers whose best refit to the noise-free recordings lies within ΔBIC < 10 of
the truth. Noise enters only as the unit in which errors count.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from hidden_effect.forms import Form, forms
from hidden_effect.machines import (
    EFFECTS,
    UNCERTAINTY,
    Reached,
    Sizes,
    Tree,
    get,
    sigma_of,
    sizes_of,
    with_effects,
    with_numbers,
)
from truth.fast import Player, TruthError

Array = NDArray[np.float64]

DIFFERENCE = 1e-3  # of each number's scale, for derivatives
CLOSE = 10.0  # ΔBIC of a class
WORTH_REFITTING = 100.0  # ΔBIC after a linear refit, above which a rival is left at that
FAR = 0.2  # of the ΔBIC of no effect at all, likewise
PROBE = 0.05  # of an effect's typical strength, for its linear refit
POSITION_SIGMA, VELOCITY_SIGMA = 0.02, 0.5  # rad, rad/s: scale of an initial state


@dataclass(frozen=True)
class Target:
    """One noise-free recording to be met; standard deviations of its signals' noise."""

    player: Player
    start: tuple[float, float]
    position: Array  # (n,) rad
    position_sigma: float
    torque: Array | None = None  # (n,) N·m
    torque_sigma: float = 1.0
    correlation: float = 0.0  # of the noise from one sample to the next

    @property
    def count(self) -> int:
        """Number of values that are compared."""
        return len(self.position) * (1 if self.torque is None else 2)

    def errors(self, tree: Tree, start: tuple[float, float]) -> Array:
        """(count,) errors in units of the noise, whitened."""
        run = self.player.run(tree, start)
        parts = [(run.joint_position - self.position) / self.position_sigma]
        if self.torque is not None:
            parts.append((run.joint_torque - self.torque) / self.torque_sigma)
        return np.concatenate([whitened(part, self.correlation) for part in parts])


def whitened(error: Array, correlation: float) -> Array:
    """Errors in units of noise with first-order correlation, made independent."""
    if correlation == 0.0:
        return error
    following = (error[1:] - correlation * error[:-1]) / math.sqrt(1.0 - correlation**2)
    return np.concatenate([error[:1], following])


@dataclass(frozen=True)
class Free:
    """A number that a refit may move: where it starts, its scale, bounds, and what is believed."""

    path: str
    start: float
    scale: float
    lower: float = 0.0
    upper: float = math.inf
    belief: float = 0.0
    sigma: float = math.inf  # of the belief


@dataclass(frozen=True)
class Refit:
    """The best of a refit: `chi2` of the errors alone, `objective` with what is believed."""

    tree: Tree
    starts: tuple[tuple[float, float], ...]
    chi2: float
    objective: float
    jacobian: Array
    residual: Array


def base_numbers(tree: Tree) -> list[Free]:
    """Numbers of the base model with what is believed of each."""
    return [
        Free(path, get(tree, path), sigma, 1e-6 * sigma, belief=get(tree, path), sigma=sigma)
        for path in UNCERTAINTY
        if (sigma := sigma_of(tree, path)) > 0.0
    ]


def refit(
    tree: Tree, free: Sequence[Free], targets: Sequence[Target], evaluations: int = 15
) -> Refit:
    """Least squares over `free` and the initial states.

    Raises
    ------
    TruthError : the start itself cannot be simulated
    """
    believed = [one for one in free if math.isfinite(one.sigma)]
    scales = np.array([one.scale for one in free] + [POSITION_SIGMA, VELOCITY_SIGMA] * len(targets))
    start = np.array([one.start for one in free] + [v for t in targets for v in t.start]) / scales
    lower = np.array([one.lower for one in free] + [-math.inf] * 2 * len(targets)) / scales
    upper = np.array([one.upper for one in free] + [math.inf] * 2 * len(targets)) / scales

    def parts(x: Array) -> tuple[Tree, list[tuple[float, float]]]:
        values = x * scales
        numbers = {one.path: value for one, value in zip(free, values[: len(free)], strict=True)}
        at = values[len(free) :].reshape(-1, 2)
        return with_numbers(tree, numbers), [(float(a), float(b)) for a, b in at]

    def errors(x: Array) -> Array:
        numbers, starts = parts(x)
        try:
            found = [t.errors(numbers, s) for t, s in zip(targets, starts, strict=True)]
        except TruthError:
            found = [np.full(t.count, 1e6) for t in targets]
        moved = [(get(numbers, one.path) - one.belief) / one.sigma for one in believed]
        return np.concatenate([*found, moved])

    def jacobian(x: Array) -> Array:
        here, columns = errors(x), []
        for i in range(len(x)):
            step = DIFFERENCE if x[i] + DIFFERENCE <= upper[i] else -DIFFERENCE
            there = x.copy()
            there[i] += step
            columns.append((errors(there) - here) / step)
        return np.array(columns).T

    inside = np.clip(start, lower + 1e-9, np.maximum(upper - 1e-9, lower + 1e-9))
    best = least_squares(
        errors, inside, jacobian, bounds=(lower, upper), max_nfev=evaluations, ftol=1e-4, xtol=1e-7
    )
    numbers, starts = parts(best.x)
    count = sum(t.count for t in targets)
    chi2 = float(np.sum(best.fun[:count] ** 2))
    return Refit(
        numbers, tuple(starts), chi2, 2.0 * float(best.cost), np.asarray(best.jac), best.fun
    )


# ---- rivals --------------------------------------------------------------------------------------


UNBOUNDED = ("angle", "phase", "offset", "lower", "upper")
SMALLEST = {
    "stribeck_velocity": 2e-3, "yield_length": 2e-6, "time_constant": 1e-3, "exponent": 0.5
}  # fmt: skip
LARGEST = {"amplitude": 0.5, "exponent": 5.0}


def free_numbers(effect: str, shape: dict[str, float], strength: dict[str, float]) -> list[Free]:
    """The numbers of an effect, free, from a start."""
    found = []
    for name, value in (shape | strength).items():
        signed = name in UNBOUNDED or value < 0.0  # a constant torque may act either way
        lower = -math.inf if signed else SMALLEST.get(name, 1e-3 * value)
        upper = LARGEST.get(name, math.inf)
        scale = abs(value) if name not in ("angle", "phase", "lower", "upper") else 0.3
        found.append(Free(f"effects.{effect}.{name}", value, max(scale, 1e-9), lower, upper))
    return found


def with_form(tree: Tree, effect: str, shape: dict[str, float], strength: dict[str, float]) -> Tree:
    """The tree with an effect."""
    numbers = {f"effects.{effect}.{name}": value for name, value in (shape | strength).items()}
    return with_numbers(tree, numbers)


@dataclass(frozen=True)
class Start:
    """A form of a rival that a linear refit likes, at the strength that it likes."""

    shape: dict[str, float]
    strength: dict[str, float]
    objective: float


def linear_starts(
    base: Refit, effect: str, targets: Sequence[Target], reached: Reached
) -> list[Start]:
    """The forms of an effect, the best first, each refitted linearly from the refitted base."""
    residual, jacobian = base.residual, base.jacobian
    basis, _ = np.linalg.qr(jacobian)
    left = residual - basis @ (basis.T @ residual)
    found = []
    for shape, unit in forms(effect, base.tree, reached):
        probe = {name: PROBE * value for name, value in unit.items()}
        tree = with_form(base.tree, effect, shape, probe)
        try:
            errors = [t.errors(tree, s) for t, s in zip(targets, base.starts, strict=True)]
        except TruthError:
            continue
        change = np.zeros_like(residual)
        whole = np.concatenate(errors)
        change[: len(whole)] = (whole - residual[: len(whole)]) / PROBE
        own = change - basis @ (basis.T @ change)
        power = float(own @ own)
        times = max(-float(own @ left) / power, 0.0) if power > 0.0 else 0.0
        objective = float(np.sum((left + times * own) ** 2))
        times = min(max(times, 0.02), 30.0)
        found.append(Start(shape, {k: times * v for k, v in unit.items()}, objective))
    return sorted(found, key=lambda one: one.objective)


def bic(objective: float, parameters: int, targets: Sequence[Target]) -> float:
    """Schwarz's criterion; whoever compares takes the differences."""
    return objective + parameters * math.log(sum(t.count for t in targets))


PARAMETERS = {
    "stribeck_friction": 3, "lugre_friction": 5, "gravity_load": 2, "joint_stop": 4,
    "overstretch_protection": 2, "spring_hysteresis": 3, "spring_relaxation": 2,
    "spring_mass": 2, "pulley_eccentricity": 2,
} | dict.fromkeys(
    ("coulomb_friction", "quadratic_drag", "constant_torque", "spring_hardening",
     "tendon_guide_friction", "tendon_compliance", "gear_backlash", "joint_encoder_offset",
     "motor_encoder_offset", "measurement_delay"), 1,
)  # fmt: skip
OFFSETS = frozenset({"joint_encoder_offset", "motor_encoder_offset"})
LAWS_OF_FRICTION = {"coulomb_friction", "stribeck_friction", "lugre_friction"}


def compatible(effect: str, others: Mapping[str, object]) -> bool:
    """Whether an effect can stand beside others: a joint has one law of friction."""
    if effect in others:
        return False
    return effect not in LAWS_OF_FRICTION or not LAWS_OF_FRICTION & set(others)


def kin(rival: str, name: str, values: Mapping[str, float], sizes: Sizes) -> list[Form]:
    """Forms of an effect that are nearly another's: laws of friction, zeros of encoders."""
    if {rival, name} == OFFSETS:
        return [({}, {"offset": sign * values["offset"]}) for sign in (1.0, -1.0)]
    if not {rival, name} <= LAWS_OF_FRICTION or rival == name:
        return []
    dry = values.get("coulomb_torque", values.get("torque", 0.0))
    if rival == "coulomb_friction":
        return [({}, {"torque": dry})]
    shape = {"stribeck_velocity": values.get("stribeck_velocity", 0.1)}
    strength = {"coulomb_torque": dry, "static_torque": values.get("static_torque", 1.01 * dry)}
    if rival == "lugre_friction":
        shape |= {
            "bristle_stiffness": 40.0 * sizes.stiffness,
            "bristle_damping": sizes.stiffness / sizes.frequency,
        }
    return [(shape, strength)]


def rivals(
    given: Tree,
    true_tree: Tree,
    name: str,
    targets: Sequence[Target],
    reached: Reached,
) -> dict[str, float]:
    """ΔBIC of every rival's best noise-free refit over that of the true effect.

    Parameters
    ----------
    given : the model that the tool gets
    true_tree, name : the truth, and the effect whose rivals are asked for; others that it has
        stay in every answer, their numbers free

    Returns
    -------
    dict : effect -> ΔBIC; "" for the answer without it; 0 for the truth. Rivals whose numbers cost
        too much even if they explained everything have that cost, those far off that of their
        linear refit
    """
    values = true_tree["effects"][name]
    others = {one: two for one, two in true_tree["effects"].items() if one != name}
    given = with_effects(given, others.items())
    known = [free for one, two in others.items() for free in free_numbers(one, {}, dict(two))]
    numbers = [*base_numbers(given), *known]
    # from the true numbers, so that no basin is mistaken for the best
    base = refit(given, started(numbers, true_tree), targets)
    own = refit(
        true_tree, [*started(numbers, true_tree), *free_numbers(name, {}, dict(values))], targets
    )
    best = bic(own.objective, PARAMETERS[name], targets)
    found = {"": bic(base.objective, 0, targets) - best, name: 0.0}
    for rival in EFFECTS:
        if rival == name or not compatible(rival, others):
            continue
        found[rival] = bic(0.0, PARAMETERS[rival], targets) - best
        if found[rival] >= CLOSE:
            continue
        starts = linear_starts(base, rival, targets, reached)
        least = min((one.objective for one in starts), default=math.inf)
        found[rival] = bic(least, PARAMETERS[rival], targets) - best
        likely = kin(rival, name, values, sizes_of(given))
        if found[rival] < max(WORTH_REFITTING, FAR * found[""]) or likely:
            tried = [(base.tree, (one.shape, one.strength)) for one in starts[:2]]
            tried += [(own.tree, form) for form in likely]
            found[rival] = best_of(rival, tried, numbers, targets) - best
    return found


def started(numbers: Sequence[Free], tree: Tree) -> list[Free]:
    """The same numbers, starting from those of a tree."""
    return [replace(one, start=get(tree, one.path)) for one in numbers]


def best_of(
    rival: str,
    tried: Sequence[tuple[Tree, Form]],
    numbers: Sequence[Free],
    targets: Sequence[Target],
) -> float:
    """Schwarz's criterion of the best refit with a rival, from bases and forms to start with."""
    objectives = [math.inf]
    for base, (shape, strength) in tried:
        tree = with_form(without(base, rival), rival, shape, strength)
        free = [*started(numbers, tree), *free_numbers(rival, shape, strength)]
        objectives.append(refit(tree, free, targets).objective)
    return bic(min(objectives), PARAMETERS[rival], targets)


def without(tree: Tree, rival: str) -> Tree:
    """The tree without the laws that a rival would stand in for."""
    gone = LAWS_OF_FRICTION if rival in LAWS_OF_FRICTION else {rival}
    return {**tree, "effects": {k: v for k, v in tree.get("effects", {}).items() if k not in gone}}
