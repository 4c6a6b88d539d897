"""Simple shapes that the missing torque or an error may have, and how well each explains it.

A shape is a constant, proportional to one variable, with the direction of motion, a curve over one
variable, or a stretch of time; those over the deflection are in `springs`. A shape is fitted by
least squares, and what it explains is the share of the mean square; where that would say little of
the joint's motion, as with springs, the motion is judged. A number that no machine can have is no
finding.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from elastic_tendon.actuator.parameters import Model
from elastic_tendon.actuator.transmission import characteristic_damping
from elastic_tendon.comparison.bins import Bin
from elastic_tendon.comparison.comparison import SignalError
from elastic_tendon.comparison.missing_torque import MissingTorque
from elastic_tendon.comparison.partition import Partition, blocks_of, last_way, memory_of
from elastic_tendon.comparison.residuals import Array, rms

# by which a pattern must explain more than a simpler one
SIMPLER = 0.04
# standard errors that a direction needs
SURE = 3.0
# longest stretch that counts as a passing event, share of the recording
EVENT = 0.2
STRETCHES = 50
CURVE_PARTS = 24  # of the range of a variable
# of the largest speed: what is slow; slower still, smoothing turns the missing torque too early
SLOWEST, SLOW = 0.02, 0.1
# of the torque along the motion: by which it falls or grows with the speed before that is reported
TREND = 0.15
# of the motor's motion at the joint: a joint that moves less is held; of the deflection: a motor
# that moves less is
STILL = 0.2
EVENT_SHARE = 0.8  # of the square over the recording that a passing event must hold
EVENT_ENERGY = 0.9  # of what the longest stretch holds lies between the times that are reported


@dataclass(frozen=True)
class Evidence:
    """What is known of the error of one signal in one recording.

    `signal` and its `residual` (n,), simulated less measured, with its figures `error` and its
    `bins`; the rest as in `locate.FileLocation`, where a long recording is taken in blocks, see
    `averaging`. `static`: the recording is a slow sweep; `load_recorded`: it has a load.
    """

    signal: str
    residual: Array
    error: SignalError
    bins: tuple[Bin, ...]
    missing: MissingTorque
    variables: Mapping[str, Array]
    parts: Mapping[str, Partition]
    static: bool
    model: Model
    load_recorded: bool

    @cached_property
    def last_way(self) -> Array:
        """Direction of motion (n,), kept at rest, see `partition.last_way`."""
        return last_way(self.variables["joint_position"])


@dataclass(frozen=True)
class Finding:
    """How well one pattern fits.

    `explained` share of the mean square; `size` and `error`, the pattern's number and its standard
    error; `bounds`: start and end (s) of a passing event, or the deflections (rad) beyond which
    another stiffness begins; `trend`: whether the magnitude falls with the speed (-1), grows (1).
    """

    pattern: "Pattern"
    explained: float
    size: float
    error: float
    bounds: tuple[float, ...] = ()
    trend: int = 0

    @property
    def sign(self) -> int:
        """Direction that the data show: -1, 1, or 0 where they do not."""
        return int(np.sign(self.size)) if abs(self.size) > SURE * self.error else 0


@dataclass(frozen=True)
class Pattern:
    """One shape: `by` its variable, `fit` from (target, evidence), and what it means.

    `meaning` by the sign of the finding, with ``{size}`` for its magnitude; 0 where the
    direction is not sure.
    """

    name: str
    by: str
    fit: Callable[["Pattern", Array, Evidence], Finding | None]
    meaning: Mapping[int, str]


def constant_error(pattern: Pattern, _target: Array, evidence: Evidence) -> Finding:
    """The error of the signal is the same throughout."""
    return proportional_to(pattern, evidence.residual, np.ones(len(evidence.residual)))


def late(pattern: Pattern, _target: Array, evidence: Evidence) -> Finding:
    """The error is the way that the joint goes in a constant time."""
    return proportional(pattern, evidence.residual, evidence)


def constant(pattern: Pattern, target: Array, _evidence: Evidence) -> Finding:
    """The same throughout."""
    return proportional_to(pattern, target, np.ones(len(target)))


def proportional(pattern: Pattern, target: Array, evidence: Evidence) -> Finding:
    """In proportion to the pattern's variable."""
    return proportional_to(pattern, target, evidence.variables[pattern.by])


def acceleration(pattern: Pattern, target: Array, evidence: Evidence) -> Finding | None:
    """In proportion to the acceleration; a link cannot be less inert than not at all."""
    finding = proportional(pattern, target, evidence)
    return finding if finding.size < evidence.model.link.inertia else None


def velocity(pattern: Pattern, target: Array, evidence: Evidence) -> Finding | None:
    """In proportion to the velocity; nothing is damped less than not at all."""
    finding = proportional(pattern, target, evidence)
    springs = characteristic_damping(0.0, evidence.model.transmission)
    return finding if finding.size < evidence.model.link.damping + float(springs) else None


def load(pattern: Pattern, target: Array, evidence: Evidence) -> Finding | None:
    """In proportion to the load, which does not act backwards."""
    finding = proportional(pattern, target, evidence)
    return finding if finding.size > -1.0 else None


def direction(pattern: Pattern, target: Array, evidence: Evidence) -> Finding:
    """The sign of the velocity; friction holds what rests with any smaller torque."""
    best = _along(pattern, target, evidence, np.ones(len(target)))
    sticking = _sticking(pattern, target, _ways(pattern, evidence))
    best = max(best, sticking, key=lambda finding: finding.explained)
    return replace(best, trend=_trend(pattern, target, best, evidence))


def direction_and_load(pattern: Pattern, target: Array, evidence: Evidence) -> Finding:
    """The sign of the velocity, and the larger the more the known torques load the springs.

    What the springs carry beyond them is the missing torque itself, of which it cannot be a cause.
    """
    return _along(pattern, target, evidence, np.abs(evidence.variables["joint_torque"] + target))


def _along(pattern: Pattern, target: Array, evidence: Evidence, size: Array) -> Finding:
    """`size` (n,) along the motion; at rest it may stay as the last motion left it, or not."""
    ways = _ways(pattern, evidence), evidence.last_way
    fits = [proportional_to(pattern, target, size * way) for way in ways]
    return max(fits, key=lambda finding: finding.explained)


def _ways(pattern: Pattern, evidence: Evidence) -> Array:
    """Direction of motion of each sample: -1, 1, and 0 at rest."""
    part = evidence.parts[pattern.by]
    signs = [{"negative": -1.0, "positive": 1.0}.get(word, 0.0) for word in part.words]
    return np.asarray(np.array(signs)[part.member])


def _sticking(pattern: Pattern, target: Array, way: Array) -> Finding:
    """Against the motion, and at rest whatever is no larger; the motion alone must show it too."""
    moving = way != 0.0
    if not moving.any():
        return Finding(pattern, 0.0, 0.0, 0.0)
    fit = proportional_to(pattern, target[moving], way[moving])
    if fit.size >= 0.0:
        return replace(fit, explained=0.0)
    held = np.clip(target, fit.size, -fit.size)
    rest = target - np.where(moving, fit.size * way, held)
    overall = 1.0 - float(rest @ rest) / float(target @ target)
    return replace(fit, explained=min(fit.explained, overall))


def _trend(pattern: Pattern, target: Array, finding: Finding, evidence: Evidence) -> int:
    """Whether the torque along the motion surely falls (-1) or grows (1) with the speed.

    What smoothing does to slow motion only makes it seem smaller there, never larger.
    """
    velocity = evidence.variables["joint_velocity"]
    speed = np.abs(velocity)
    along = np.sign(finding.size) * target * np.sign(velocity)
    share = speed / max(float(np.max(speed)), 1e-300)
    fast, slow = share > SLOW, (share > SLOWEST) & (share <= SLOW)
    if slow.any() and fast.any():
        more = along[slow] - np.mean(along[fast])
        excess = proportional_to(pattern, more, np.ones(len(more)))
        if excess.sign > 0 and excess.size > TREND * abs(finding.size):
            return -1
    along, speed = along[fast], speed[fast]
    slope = proportional_to(pattern, along - np.mean(along), speed - np.mean(speed))
    change = slope.size * float(np.subtract(*np.quantile(speed, (0.9, 0.1))))
    return slope.sign if abs(change) > TREND * abs(finding.size) else 0


def unknown_torque(pattern: Pattern, target: Array, evidence: Evidence) -> Finding:
    """What the springs carry, as if no known torque had any part in it."""
    carried = -evidence.variables["joint_torque"]
    rest = target - carried
    explained = 1.0 - float(rest @ rest) / float(target @ target)
    return Finding(pattern, explained, rms(target), 0.0)


def held(pattern: Pattern, target: Array, evidence: Evidence) -> Finding | None:
    """The springs yield to a motor that moves while the joint stays."""
    joint, deflection = evidence.variables["joint_position"], evidence.variables["deflection"]
    if np.std(joint) > STILL * np.std(joint - deflection):
        return None
    return unknown_torque(pattern, target, evidence)


def proportional_to(pattern: Pattern, target: Array, shape: Array) -> Finding:
    """Least squares of target (n,) on one shape (n,); the standard error counts blocks."""
    square = float(shape @ shape)
    if square == 0.0:
        return Finding(pattern, 0.0, 0.0, 0.0)
    size = float(shape @ target) / square
    rest = target - size * shape
    score = shape * rest
    blocks = blocks_of(memory_of(score), len(score))
    error = float(np.linalg.norm(np.bincount(blocks, score))) / square
    explained = 1.0 - float(rest @ rest) / max(float(target @ target), 1e-300)
    return Finding(pattern, explained, size, error)


def curve(
    pattern: Pattern, target: Array, evidence: Evidence, *, through_zero: bool = False
) -> Finding | None:
    """A mean for each of many small parts of the range; the slope tells the direction."""
    if len(target) < 2 * CURVE_PARTS:
        return None  # it would go through any samples
    values = evidence.variables[pattern.by]
    lowest, width = float(np.min(values)), float(np.ptp(values)) / CURVE_PARTS
    member = np.minimum((values - lowest) / width, CURVE_PARTS - 1).astype(int)
    counts = np.bincount(member, minlength=CURVE_PARTS)
    means = np.bincount(member, target, CURVE_PARTS) / np.maximum(counts, 1)
    near = np.abs(values) < width
    if through_zero and near.any():
        means -= np.mean(target[near])
    rest = target - means[member]
    # as many independent facts as the target has memories, less one for each part
    facts = len(target) / memory_of(target)
    penalty = facts / max(facts - float(np.count_nonzero(counts)), 1.0)
    slope = proportional_to(pattern, target - np.mean(target), values - np.mean(values))
    explained = 1.0 - penalty * float(rest @ rest) / float(target @ target)
    return Finding(pattern, explained, slope.size, slope.error)


def position_curve(pattern: Pattern, target: Array, evidence: Evidence) -> Finding | None:
    """A curve over the joint's position, where the motor moves: else that is the deflection."""
    joint, deflection = evidence.variables["joint_position"], evidence.variables["deflection"]
    if np.std(joint - deflection) < STILL * np.std(deflection):
        return None
    return curve(pattern, target, evidence)


def event(pattern: Pattern, target: Array, evidence: Evidence) -> Finding | None:
    """A stretch of time, shorter than `EVENT`, that holds nearly all of the target's square."""
    if len(target) < STRETCHES:
        return None  # a stretch would be less than a sample
    time = evidence.variables["time"]
    edges = np.linspace(time[0], time[-1], STRETCHES + 1)
    part = np.clip(np.searchsorted(edges, time, side="right") - 1, 0, STRETCHES - 1)
    energy = np.bincount(part, target**2, STRETCHES)
    energy = np.maximum(energy - np.median(energy), 0.0)
    width = round(EVENT * STRETCHES)
    windows = np.convolve(energy, np.ones(width), "valid")
    first = int(np.argmax(windows))
    inside = np.cumsum(energy[first : first + width]) / max(float(windows[first]), 1e-300)
    start = first + int(np.searchsorted(inside, 0.5 * (1.0 - EVENT_ENERGY)))
    end = first + int(np.searchsorted(inside, 0.5 * (1.0 + EVENT_ENERGY)))
    span = (float(edges[start]), float(edges[end + 1]))
    within = (time >= span[0]) & (time <= span[1])
    explained = float(np.sum(target[within] ** 2) / np.sum(target**2))
    if explained < EVENT_SHARE:
        return None
    size = float(np.sign(np.mean(target[within])) * rms(target[within]))
    return Finding(pattern, explained, size, 0.0, span)
