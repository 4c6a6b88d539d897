"""Where modes switch next, as the joint is deflected with the motor held."""

from collections.abc import Iterable, Iterator
from itertools import pairwise

import numpy as np

from elastic_tendon.actuator.variables import JOINT_MOTION
from elastic_tendon.errors import LinearisationError
from elastic_tendon.linear.equilibrium import (
    LOAD_TORQUE,
    Point,
    deflection_of,
    deflection_range,
    deflection_span,
    held,
    torque_scale,
)
from elastic_tendon.linear.plant import Plant, Regime
from elastic_tendon.linear.result import Boundary

TOUCH = 1e-8  # share of the range of deflection within which a boundary counts as reached
_POINTS = 60  # looked at in each direction, before a switch is located between two of them
REACH = 1.0  # how far is looked beyond the range of deflection, in shares of that range
_MOST_BISECTIONS = 60
# loads tried in search of the one that sets a sticking joint in motion, in shares of the largest
# torque that the springs bear
_SMALLEST_BREAKAWAY, _LARGEST_BREAKAWAY = 1e-6, 100.0


def sides(plant: Plant, point: Point) -> tuple[Point, Point]:
    """The points just beside a point, towards negative and towards positive deflection."""
    at, touch = deflection_of(plant, point.x, point.u), TOUCH * deflection_span(plant)
    low, high = (_held(plant, (point,), at + step) or point for step in (-touch, touch))
    return low, high


def boundaries(plant: Plant, point: Point, beside: tuple[Point, Point]) -> tuple[Boundary, ...]:
    """The boundary on which a point lies, if any, and the next ones on both sides.

    Parameters
    ----------
    plant : Plant
    point : Point
    beside : tuple of two points, its `sides`

    Returns
    -------
    tuple of Boundary, by rising deflection
    """
    low, high = beside
    neighbours = [_next(plant, point, low, -1), _next(plant, point, high, 1)]
    if switches(low.regime, high.regime):
        neighbours.append(_boundary(plant, point, point, low.regime, high.regime))
    if point.regime.modes.get(JOINT_MOTION.name) == 0:
        neighbours += [_breakaway(plant, point, direction) for direction in (-1, 1)]
    every = [boundary for boundary in neighbours if boundary is not None]
    return tuple(sorted(every, key=lambda boundary: (boundary.deflection, boundary.load_torque)))


def switches(before: Regime, after: Regime) -> dict[str, int]:
    """Modes that differ, with their values after; whether the joint sticks is another matter."""
    return {
        name: value
        for name, value in after.modes.items()
        if value != before.modes[name] and name != JOINT_MOTION.name
    }


def _next(plant: Plant, point: Point, beside: Point, direction: int) -> Boundary | None:
    for near, far in pairwise(_path(plant, beside, direction)):
        if switches(near.regime, far.regime):
            located = _located(plant, near, far)
            if located is None:
                return None
            inner, outer = located
            return _boundary(plant, point, outer, inner.regime, outer.regime)
    return None


def _held(plant: Plant, near: Iterable[Point], deflection: float) -> Point | None:
    """The motor held, the joint at a deflection; sought from the first point that leads there."""
    for point in near:
        try:
            return held(plant, point, deflection)
        except LinearisationError:
            continue
    return None


def _path(plant: Plant, beside: Point, direction: int) -> Iterator[Point]:
    """Points from one outwards to beyond all of the range, as far as there are any."""
    yield beside
    start = deflection_of(plant, beside.x, beside.u)
    farthest = deflection_range(plant)[direction > 0]
    end = direction * max(direction * farthest, direction * start)
    end += direction * REACH * deflection_span(plant)
    point = beside
    for deflection in np.linspace(start, end, _POINTS)[1:]:
        following = _held(plant, (point,), float(deflection))
        if following is None:
            return
        point = following
        yield point


def _located(plant: Plant, near: Point, far: Point) -> tuple[Point, Point] | None:
    """The two points moved together until only rounding and the dead band lie between them.

    None where no equilibrium is found between them, so that the place would be a guess.
    """
    for _ in range(_MOST_BISECTIONS):
        ends = [deflection_of(plant, point.x, point.u) for point in (near, far)]
        between = float(np.mean(ends))
        if between in ends:
            break
        middle = _held(plant, (near, far), between)
        if middle is None:
            return None
        if switches(near.regime, middle.regime):
            far = middle
        else:
            near = middle
    return near, far


def _boundary(plant: Plant, point: Point, at: Point, before: Regime, after: Regime) -> Boundary:
    here = deflection_of(plant, point.x, point.u)
    deflection = deflection_of(plant, at.x, at.u)
    return Boundary(
        switches(before, after),
        after.slack_state,
        deflection,
        at.load_torque,
        deflection - here,
        at.load_torque - point.load_torque,
    )


def _breakaway(plant: Plant, point: Point, direction: int) -> Boundary | None:
    """Where more load, the joint held where it sticks, sets it in motion."""

    def slides(added: float) -> bool:
        u = point.u.copy()
        u[LOAD_TORQUE] += direction * added
        return plant.settle(point.x, u).modes[JOINT_MOTION.name] != 0

    holds, moves = 0.0, torque_scale(plant) * _SMALLEST_BREAKAWAY
    while not slides(moves):
        holds, moves = moves, 2.0 * moves
        if moves > torque_scale(plant) * _LARGEST_BREAKAWAY:
            return None
    for _ in range(_MOST_BISECTIONS):
        between = 0.5 * (holds + moves)
        holds, moves = (holds, between) if slides(between) else (between, moves)
    margin = direction * moves
    deflection = deflection_of(plant, point.x, point.u)
    return Boundary(
        {JOINT_MOTION.name: direction},
        point.regime.slack_state,
        *(deflection, point.load_torque + margin, 0.0, margin),
    )
