"""Simple shapes that the missing torque or an error may have, and how well each explains it.

A shape is a constant, proportional to one variable, with the direction of motion, a curve over one
variable, a stiffness that begins somewhere, or a stretch of time. A shape is fitted by least
squares, and what it explains is the share of the mean square; where that would say little of the
joint's motion, as with springs, the motion is judged.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from elastic_tendon.identify.bins import Bin
from elastic_tendon.identify.compare import SignalError
from elastic_tendon.identify.missing_torque import MissingTorque
from elastic_tendon.identify.partition import Partition, blocks_of, last_way, memory_of
from elastic_tendon.identify.residuals import Array, rms

# by which a pattern must explain more than a simpler one
SIMPLER = 0.04
# standard errors that a direction needs
SURE = 3.0
# longest stretch that counts as a passing event, share of the recording
EVENT = 0.2
STRETCHES = 50
CURVE_PARTS = 24  # of the range of a variable
BOUNDS = np.linspace(0.2, 0.96, 77)  # of the largest deflection, where another stiffness may begin
STILL = 0.2  # of the motor's motion at the joint: a joint that moves less is held
EVENT_SHARE = 0.8  # of the square over the recording that a passing event must hold
EVENT_ENERGY = 0.9  # of what the longest stretch holds lies between the times that are told


@dataclass(frozen=True)
class Evidence:
    """What is known of the error of one signal in one recording.

    `signal` and its `residual` (n,), simulated less measured, with its figures `error` and its
    `bins`; the rest as in `locate.FileLocation`; `static`: the recording is a slow sweep.
    """

    signal: str
    residual: Array
    error: SignalError
    bins: tuple[Bin, ...]
    missing: MissingTorque
    variables: Mapping[str, Array]
    parts: Mapping[str, Partition]
    static: bool


@dataclass(frozen=True)
class Finding:
    """How well one pattern fits.

    `explained` share of the mean square; `size` and `error`, the pattern's number and its standard
    error; `bounds`: start and end (s) of a passing event, or the deflections (rad) beyond which
    another stiffness begins.
    """

    pattern: "Pattern"
    explained: float
    size: float
    error: float
    bounds: tuple[float, ...] = ()

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
    return _proportional_to(pattern, evidence.residual, np.ones(len(evidence.residual)))


def late(pattern: Pattern, _target: Array, evidence: Evidence) -> Finding:
    """The error is the way that the joint goes in a constant time."""
    return proportional(pattern, evidence.residual, evidence)


def constant(pattern: Pattern, target: Array, _evidence: Evidence) -> Finding:
    """The same throughout."""
    return _proportional_to(pattern, target, np.ones(len(target)))


def proportional(pattern: Pattern, target: Array, evidence: Evidence) -> Finding:
    """In proportion to the pattern's variable."""
    return _proportional_to(pattern, target, evidence.variables[pattern.by])


def direction(pattern: Pattern, target: Array, evidence: Evidence) -> Finding:
    """The sign of the velocity."""
    return _along(pattern, target, evidence, np.ones(len(target)))


def direction_and_load(pattern: Pattern, target: Array, evidence: Evidence) -> Finding:
    """The sign of the velocity, and the larger the more the known torques load the springs.

    What the springs carry beyond them is the missing torque itself, of which it cannot be a cause.
    """
    return _along(pattern, target, evidence, np.abs(evidence.variables["joint_torque"] + target))


def _along(pattern: Pattern, target: Array, evidence: Evidence, size: Array) -> Finding:
    """`size` (n,) along the motion; at rest it may stay as the last motion left it, or not."""
    part = evidence.parts[pattern.by]
    signs = [{"negative": -1.0, "positive": 1.0}.get(word, 0.0) for word in part.words]
    ways = np.array(signs)[part.member], last_way(evidence.variables["joint_position"])
    fits = [_proportional_to(pattern, target, size * way) for way in ways]
    return max(fits, key=lambda one: one.explained)


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


def stiffness(pattern: Pattern, target: Array, evidence: Evidence) -> Finding:
    """Another stiffness everywhere."""
    deflection = evidence.variables["deflection"]
    return _of_springs(_proportional_to(pattern, target, deflection), deflection, evidence)


def beyond(pattern: Pattern, target: Array, evidence: Evidence) -> Finding | None:
    """Another stiffness beyond a deflection of either sign, or of one."""
    deflection = evidence.variables["deflection"]
    found = []  # share explained, bound, shape
    for side in (-1.0, 1.0):
        way = side * deflection
        bounds = max(float(np.max(way)), 0.0) * BOUNDS
        shapes = [side * np.maximum(way - bound, 0.0) for bound in bounds]
        gains = [_proportional_to(pattern, target, shape).explained for shape in shapes]
        best = int(np.argmax(gains))
        found.append((gains[best], side * float(bounds[best]), shapes[best]))
    most = max(explained for explained, _, _ in found)
    chosen = [one for one in found if one[0] > SIMPLER * most]
    if most <= 0.0:
        return None
    shape = np.sum([shape for _, _, shape in chosen], axis=0)
    finding = _of_springs(_proportional_to(pattern, target, shape), shape, evidence)
    return replace(finding, bounds=tuple(bound for _, bound, _ in chosen))


def _of_springs(finding: Finding, shape: Array, evidence: Evidence) -> Finding:
    """What a change of stiffness explains of the deflections, where that is less than it seems.

    Whatever deflects the joint, where no known torque does, the model lacks just the torque that
    its springs have at that deflection, as if there were no springs. But the softer they are, the
    larger the deflections by the torque that the change leaves unexplained, and these are judged.
    `shape` (n,), rad, is the deflection over which the stiffness changes.
    """
    inside = shape != 0.0
    over = evidence.variables["deflection"][inside]
    over = over - np.mean(over)
    springs = -evidence.variables["joint_torque"][inside]
    stiffness = float(over @ springs) / max(float(over @ over), 1e-300)
    left = stiffness - finding.size
    yielding = max(stiffness / left, 1.0) if left > 0.0 else np.inf
    return replace(finding, explained=1.0 - (1.0 - finding.explained) * yielding**2)


def _proportional_to(pattern: Pattern, target: Array, shape: Array) -> Finding:
    """Least squares of target on one shape; the standard error counts blocks, not samples."""
    square = float(shape @ shape)
    if square == 0.0:
        return Finding(pattern, 0.0, 0.0, 0.0)
    size = float(shape @ target) / square
    rest = target - size * shape
    score = shape * rest
    blocks = blocks_of(memory_of(score), len(score))
    error = float(np.linalg.norm(np.bincount(blocks, score))) / square
    return Finding(pattern, 1.0 - float(rest @ rest) / float(target @ target), size, error)


def curve(pattern: Pattern, target: Array, evidence: Evidence) -> Finding:
    """A mean for each of many small parts of the range; the slope tells the direction."""
    values = evidence.variables[pattern.by]
    lowest, width = float(np.min(values)), float(np.ptp(values)) / CURVE_PARTS
    member = np.minimum((values - lowest) / width, CURVE_PARTS - 1).astype(int)
    counts = np.bincount(member, minlength=CURVE_PARTS)
    means = np.bincount(member, target, CURVE_PARTS) / np.maximum(counts, 1)
    rest = target - means[member]
    # as many independent facts as the target has memories, less one for each part
    facts = len(target) / memory_of(target)
    penalty = facts / max(facts - float(np.count_nonzero(counts)), 1.0)
    slope = _proportional_to(pattern, target - np.mean(target), values - np.mean(values))
    explained = 1.0 - penalty * float(rest @ rest) / float(target @ target)
    return Finding(pattern, explained, slope.size, slope.error)


def stiffness_curve(pattern: Pattern, target: Array, evidence: Evidence) -> Finding:
    """Another curve of the springs."""
    deflection = evidence.variables["deflection"]
    return _of_springs(curve(pattern, target, evidence), deflection, evidence)


def event(pattern: Pattern, target: Array, evidence: Evidence) -> Finding | None:
    """A stretch of time, shorter than `EVENT`, that holds nearly all of the target's square."""
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
