"""Shapes over the deflection that the missing torque may have: what the springs would have to be.

Everything here depends on the deflection alone, so that means over many small cells of it stand
for the samples.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from elastic_tendon.actuator.sections import Transmission
from elastic_tendon.actuator.transmission import characteristic_torque
from elastic_tendon.comparison.patterns import (
    SIMPLER,
    Evidence,
    Finding,
    Pattern,
    curve,
    proportional_to,
)
from elastic_tendon.comparison.residuals import Array

CELLS = 800  # of the range of the deflection
BOUNDS = np.linspace(0.2, 0.96, 77)  # of the largest deflection, where another stiffness may begin
# of the model's number: what another pretension or stiffness may be, first coarsely, then finely
RATIOS = np.geomspace(0.2, 3.0, 55)
FINE = 11


@dataclass(frozen=True)
class _Cells:
    """Samples by deflection: mean `deflection` (k,), sums of the target and counts (k,); `square`,
    the target's sum of squares.
    """

    deflection: Array
    total: Array
    count: Array
    square: float

    def explained(self, shape: Array) -> float:
        """Share of the target's mean square that a shape (k,) of its own size explains."""
        gain = 2.0 * float(self.total @ shape) - float(self.count @ shape**2)
        return gain / self.square

    def best_explained(self, shape: Array) -> float:
        """The same, with the size that suits best."""
        square = float(self.count @ shape**2)
        return float(self.total @ shape) ** 2 / (square * self.square) if square > 0.0 else 0.0


def _cells(target: Array, deflection: Array) -> _Cells:
    lowest, width = float(np.min(deflection)), float(np.ptp(deflection)) / CELLS
    member = np.minimum((deflection - lowest) / width, CELLS - 1).astype(np.intp)
    count = np.bincount(member, minlength=CELLS).astype(np.float64)
    kept = count > 0.0
    mean = np.bincount(member, deflection, CELLS)[kept] / count[kept]
    total = np.bincount(member, target, CELLS)[kept]
    return _Cells(mean, np.asarray(total), np.asarray(count[kept]), float(target @ target))


def stiffness(pattern: Pattern, target: Array, evidence: Evidence) -> Finding:
    """Another stiffness everywhere."""
    deflection = evidence.variables["deflection"]
    finding = proportional_to(pattern, target, deflection)
    return _of_springs(finding, finding.size * deflection, evidence)


def stiffness_curve(pattern: Pattern, target: Array, evidence: Evidence) -> Finding | None:
    """Another curve of the springs, which like any holds nothing where they are not deflected."""
    deflection = evidence.variables["deflection"]
    finding = curve(pattern, target, evidence, through_zero=True)
    if finding is None:
        return None
    return _of_springs(finding, finding.size * deflection, evidence)


def beyond(pattern: Pattern, target: Array, evidence: Evidence) -> Finding | None:
    """Another stiffness beyond a deflection of either sign, or of one."""
    deflection = evidence.variables["deflection"]
    cells = _cells(target, deflection)
    findings = []  # share explained, bound
    for side in (-1.0, 1.0):
        way = side * cells.deflection
        bounds = max(float(np.max(way)), 0.0) * BOUNDS
        gains = [cells.best_explained(np.maximum(way - bound, 0.0)) for bound in bounds]
        best = int(np.argmax(gains))
        findings.append((gains[best], side * float(bounds[best])))
    most = max(explained for explained, _ in findings)
    if most <= 0.0:
        return None
    chosen = tuple(bound for explained, bound in findings if explained > SIMPLER * most)
    shape = np.zeros(len(deflection))
    for bound in chosen:
        side = np.sign(bound)
        shape += side * np.maximum(side * deflection - abs(bound), 0.0)
    finding = proportional_to(pattern, target, shape)
    return replace(_of_springs(finding, finding.size * shape, evidence), bounds=chosen)


def pretension(pattern: Pattern, target: Array, evidence: Evidence) -> Finding:
    """Another pretension: the same torque beyond both slack boundaries, growing between them.

    The size is the share by which it is larger.
    """

    def changed(springs: Transmission, ratio: float) -> Transmission:
        return springs.model_copy(update={"pretension_force": ratio * springs.pretension_force})

    return _as_if(pattern, target, evidence, changed)


def spring_stiffness(*sides: str) -> Callable[[Pattern, Array, Evidence], Finding]:
    """Other springs on one side or both, at the same pretension; the size is the share by which
    they are stiffer.
    """

    def changed(springs: Transmission, ratio: float) -> Transmission:
        others = {}
        for side in sides:
            spring = getattr(springs, side)
            others[side] = spring.model_copy(update={"stiffness": ratio * spring.stiffness})
        return springs.model_copy(update=others)

    def fit(pattern: Pattern, target: Array, evidence: Evidence) -> Finding:
        return _as_if(pattern, target, evidence, changed)

    return fit


def _as_if(
    pattern: Pattern,
    target: Array,
    evidence: Evidence,
    changed: Callable[[Transmission, float], Transmission],
) -> Finding:
    """The torque that the springs would have more if one of their parameters were another."""
    springs = evidence.model.transmission
    deflection = evidence.variables["deflection"]
    cells = _cells(target, deflection)

    def shape(ratio: float, where: Array) -> Array:
        own = characteristic_torque(where, springs)
        return characteristic_torque(where, changed(springs, ratio)) - own

    def best(ratios: Array) -> float:
        gains = [cells.explained(shape(float(tried), cells.deflection)) for tried in ratios]
        return float(ratios[int(np.argmax(gains))])

    coarse = best(RATIOS)
    step = float(RATIOS[1] / RATIOS[0])
    ratio = best(coarse * np.geomspace(1.0 / step, step, FINE))
    more = shape(ratio, deflection)
    # the shape's own size is one; its standard error is relative to the change
    error = abs(ratio - 1.0) * proportional_to(pattern, target, more).error
    explained = cells.explained(shape(ratio, cells.deflection))
    return _of_springs(Finding(pattern, explained, ratio - 1.0, error), more, evidence)


def _of_springs(finding: Finding, torque: Array, evidence: Evidence) -> Finding:
    """What a change of stiffness explains of the deflections, where that is less than it seems.

    Whatever deflects the joint, where no known torque does, the model lacks just the torque that
    its springs have at that deflection, as if there were no springs. But the softer they are, the
    larger the deflections by the torque that the change leaves unexplained, and these are judged.
    `torque` (n,), N·m, is what the change adds; springs softer than none are no finding.
    """
    inside = torque != 0.0
    over = evidence.variables["deflection"][inside]
    over = over - np.mean(over) if len(over) else over
    square = max(float(over @ over), 1e-300)
    own = -float(over @ evidence.variables["joint_torque"][inside]) / square
    left = own - float(over @ torque[inside]) / square
    yielding = max(own / left, 1.0) if left > 0.0 else np.inf
    return replace(finding, explained=1.0 - (1.0 - finding.explained) * yielding**2)
