"""The descent ends where scipy's does, keeps within bounds, and asks no more than it may."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest
from scipy.linalg import block_diag
from scipy.optimize import least_squares, lsq_linear

from elastic_tendon.estimation import descent
from elastic_tendon.estimation.descent import ROWS, descend

FREE = (-np.inf, np.inf)
MANY, EXACT = 200, 1e-12  # evaluations; relative fall of the cost


def derivatives(residuals: Callable) -> Callable:
    """Exact, by a step into the complex plane."""

    def jacobian(x: np.ndarray) -> np.ndarray:
        steps = 1e-30j * np.eye(len(x))
        return np.column_stack([residuals(x + step).imag / 1e-30 for step in steps])

    return jacobian


def limits(*pairs: tuple[float, float]) -> tuple[np.ndarray, np.ndarray]:
    low, high = np.array(pairs, dtype=float).T
    return low, high


def descended(residuals: Callable, start, bounds, evaluations: int = MANY, tolerance=EXACT):
    found, cost = descend(
        residuals,
        derivatives(residuals),
        np.array(start, dtype=float),
        bounds,
        evaluations,
        tolerance,
    )
    assert np.all((bounds[0] <= found) & (found <= bounds[1]))
    assert cost == pytest.approx(0.5 * np.sum(residuals(found) ** 2), rel=1e-12)
    return found, cost


# ---- as scipy has it -----------------------------------------------------------------------------


@dataclass(frozen=True)
class Curve:
    law: Callable
    truth: tuple[float, ...]
    start: tuple[float, ...]
    cut: tuple[tuple[float, float], ...]  # bounds that leave the truth out

    def residuals(self, count: int) -> Callable:
        time = np.linspace(0.0, 4.0, count)
        noise = 0.02 * np.random.default_rng(1).standard_normal(count)
        shown = self.law(np.array(self.truth), time) + noise
        return lambda x: self.law(x, time) - shown


CURVES = {
    "decay": Curve(
        lambda x, t: x[0] * np.exp(-x[1] * t) + x[2],
        (2.0, 1.3, 0.4),
        (1.0, 0.5, 0.1),
        (FREE, (0.1, 0.9), (0.0, 0.3)),
    ),
    "swing": Curve(
        lambda x, t: x[0] * np.exp(-x[1] * t) * np.cos(x[2] * t + x[3]),
        (1.5, 0.4, 3.0, 0.5),
        (1.0, 0.1, 2.8, 0.1),
        ((0.0, 1.2), FREE, (2.5, 3.5), (0.0, 0.45)),
    ),
    "step": Curve(
        lambda x, t: x[0] / (1.0 + np.exp(-x[1] * (t - x[2]))),
        (3.0, 2.0, 1.7),
        (2.0, 1.0, 1.2),
        ((0.0, 2.7), (0.5, 1.5), FREE),
    ),
}


@pytest.mark.parametrize("count", [12, 5 * ROWS + 7], ids=["few samples", "many samples"])
@pytest.mark.parametrize("bound", [False, True], ids=["free", "bounded"])
@pytest.mark.parametrize("curve", CURVES.values(), ids=CURVES)
def test_a_curve_fit_ends_where_that_of_scipy_does(curve, bound, count) -> None:
    residuals = curve.residuals(count)
    bounds = limits(*(curve.cut if bound else [FREE] * len(curve.start)))
    known = least_squares(
        residuals, curve.start, derivatives(residuals), bounds, xtol=1e-14, ftol=1e-14, gtol=1e-14
    )
    found, cost = descended(residuals, curve.start, bounds)
    assert cost == pytest.approx(known.cost, rel=1e-6)
    assert found == pytest.approx(known.x, rel=1e-3)
    reached = np.isclose(found, bounds[0], rtol=1e-9) | np.isclose(found, bounds[1], rtol=1e-9)
    assert reached.any() == bound


def rosenbrock(x: np.ndarray) -> np.ndarray:
    return np.array([10.0 * (x[1] - x[0] ** 2), 1.0 - x[0]])


@pytest.mark.parametrize(
    ("bounds", "end"),
    [
        (limits(FREE, FREE), (1.0, 1.0)),
        (limits((-2.0, 0.5), FREE), (0.5, 0.25)),
        (limits(FREE, (-1.0, 0.0)), None),
        (limits((-2.0, 2.0), (1.5, 3.0)), None),
    ],
    ids=["free", "x at its bound", "y below", "y above"],
)
def test_the_valley_of_rosenbrock_is_followed_to_its_end(bounds, end) -> None:
    start = np.clip([-1.2, 1.0], *bounds)
    found, cost = descended(rosenbrock, start, bounds)
    inside = np.clip(start, bounds[0] + 1e-3, bounds[1] - 1e-3)
    tight = {"xtol": 1e-15, "ftol": 1e-15, "gtol": 1e-15, "max_nfev": 1000}
    known = least_squares(rosenbrock, inside, derivatives(rosenbrock), bounds, **tight)
    assert cost == pytest.approx(known.cost, rel=1e-6, abs=1e-12)
    assert found == pytest.approx(known.x if end is None else np.array(end), rel=1e-4, abs=1e-6)


@pytest.mark.parametrize("count", [6, ROWS - 1, ROWS, ROWS + 1, 3 * ROWS])
def test_a_linear_problem_takes_few_steps_whatever_its_size(count) -> None:
    rng = np.random.default_rng(count)
    matrix, target = rng.standard_normal((count, 4)), rng.standard_normal(count)
    known = lsq_linear(matrix, target)
    found, cost = descended(lambda x: matrix @ x - target, np.ones(4), limits(*[FREE] * 4), 6)
    assert found == pytest.approx(known.x, abs=1e-7)
    assert cost == pytest.approx(known.cost, rel=1e-10)


@pytest.mark.parametrize("seed", range(10))
def test_a_linear_problem_with_many_active_bounds_is_solved(seed) -> None:
    rng = np.random.default_rng(seed)
    matrix, target = rng.standard_normal((150, 10)), 10.0 * rng.standard_normal(150)
    low = -0.3 * rng.random(10)
    bounds = (low, low + 0.5 * rng.random(10))
    start = np.where(rng.random(10) < 0.5, low, rng.uniform(*bounds))
    known = lsq_linear(matrix, target, bounds, tol=1e-14)
    _, cost = descended(lambda x: matrix @ x - target, start, bounds, tolerance=1e-8)
    assert cost == pytest.approx(known.cost, rel=1e-6)


# ---- what is out of the way ----------------------------------------------------------------------


def plain(x: np.ndarray) -> np.ndarray:
    """Least at (1, 2), whatever a third variable is."""
    return np.array([x[0] - 1.0, 2.0 * (x[1] - 2.0), 0.1 * (x[0] - 1.0) * (x[1] - 2.0), 0.5])


def test_a_variable_that_does_nothing_stays() -> None:
    for bounds in (limits(FREE, FREE, FREE), limits((0.0, 5.0), (0.0, 1.5), (-1.0, 1.0))):
        found, _ = descended(plain, [0.0, 0.0, 0.7], bounds)
        assert found == pytest.approx([1.0, min(2.0, bounds[1][1]), 0.7], abs=1e-6)


def test_a_start_on_a_bound_leaves_it_or_stays_as_the_cost_has_it() -> None:
    inward, _ = descended(plain, [0.0, 5.0], limits((0.0, 3.0), (0.0, 5.0)))
    assert inward == pytest.approx([1.0, 2.0], abs=1e-6)
    outward, _ = descended(plain, [3.0, 0.0], limits((3.0, 6.0), (0.0, 5.0)))
    assert outward[0] == 3.0
    assert outward[1] == pytest.approx(2.0, abs=1e-6)
    corner, cost = descended(plain, [3.0, 0.0], limits((3.0, 6.0), (-5.0, 0.0)))
    assert corner.tolist() == [3.0, 0.0]
    assert cost == 0.5 * np.sum(plain(corner) ** 2)


def test_a_variable_whose_bounds_coincide_stays() -> None:
    found, _ = descended(plain, [0.0, 3.0], limits(FREE, (3.0, 3.0)))
    assert found[1] == 3.0
    assert found[0] == pytest.approx(1.0, abs=1e-6)
    fixed, _ = descended(plain, [0.2, 3.0], limits((0.2, 0.2), (3.0, 3.0)))
    assert fixed.tolist() == [0.2, 3.0]


def test_what_has_no_residuals_is_stepped_back_from() -> None:
    beyond = []

    def residuals(x: np.ndarray) -> np.ndarray:
        if x[0].real < -1.0:
            beyond.append(x)
            return np.full(3, np.inf)
        return np.array([np.arctan(x[0] - 1.0), 0.1 * (x[1] - 2.0), 0.3])

    # there the slope is so small that a whole step leads to about -11
    found, _ = descended(residuals, [4.0, 0.0], limits(FREE, FREE))
    assert beyond
    assert found == pytest.approx([1.0, 2.0], abs=1e-5)


def test_residuals_nowhere_else_leave_the_start() -> None:
    start = np.array([0.5, 0.5])

    def residuals(x: np.ndarray) -> np.ndarray:
        return plain(x) if np.array_equal(x.real, start) else np.full(4, np.inf)

    found, cost = descended(residuals, start, limits(FREE, FREE))
    assert found.tolist() == start.tolist()
    assert cost == 0.5 * np.sum(plain(start) ** 2)


@pytest.mark.parametrize("allowed", [1, 2, 3, 5, 8, 13, 21])
def test_residuals_are_evaluated_no_more_often_than_allowed(allowed) -> None:
    asked: list[float] = []

    def residuals(x: np.ndarray) -> np.ndarray:
        values = rosenbrock(x) if x[0] < 0.9 else np.full(2, np.inf)
        asked.append(0.5 * float(values @ values))
        return values

    start = np.array([-1.2, 1.0])
    bounds = limits(FREE, FREE)
    found, cost = descend(residuals, derivatives(rosenbrock), start, bounds, allowed, EXACT)
    assert len(asked) == allowed  # the valley is longer
    assert cost == min(asked)  # the best that was met
    assert cost == 0.5 * float(rosenbrock(found) @ rosenbrock(found))


def test_a_loose_tolerance_ends_sooner() -> None:
    counts = []
    for tolerance in (0.5, EXACT):
        asked: list[np.ndarray] = []

        def residuals(x: np.ndarray, asked=asked) -> np.ndarray:
            asked.append(x)
            return CURVES["decay"].residuals(50)(x)

        jacobian = derivatives(CURVES["decay"].residuals(50))
        start = np.array(CURVES["decay"].start)
        descend(residuals, jacobian, start, limits(*[FREE] * 3), MANY, tolerance)
        counts.append(len(asked))
    assert 2 < counts[0] < counts[1] < MANY


def test_a_start_at_a_minimum_on_a_bound_is_taken_for_one() -> None:
    """What is left to gain there is less than rounding takes from the cost."""
    rng = np.random.default_rng(0)
    for _ in range(200):
        matrix, target = 0.05 * rng.standard_normal((300, 6)), rng.standard_normal(300)
        low = np.full(6, -np.inf)
        low[:2] = np.linalg.lstsq(matrix, target)[0][:2] + 1.0
        start = low.copy()
        start[2:] = np.linalg.lstsq(matrix[:, 2:], target - matrix[:, :2] @ low[:2])[0]
        start[2:] += 1e-8 * rng.standard_normal(4)
        found, _ = descend(
            lambda x, matrix=matrix, target=target: matrix @ x - target,
            lambda _x, matrix=matrix: matrix,
            start,
            (low, np.full(6, np.inf)),
            40,
            1e-5,
        )
        assert found == pytest.approx(start, abs=1e-6)


def test_variables_of_pieces_alone_cost_no_accuracy() -> None:
    """As of the initial states of many windows of a recording."""
    pieces, own, shared = 12, 3, 2
    rng = np.random.default_rng(8)
    rows = [
        (rng.standard_normal((ROWS + 7, shared)), rng.standard_normal((ROWS + 7, own)))
    ] * pieces
    matrix = np.hstack(
        [np.vstack([common for common, _ in rows]), block_diag(*(alone for _, alone in rows))]
    )
    values = rng.standard_normal(len(matrix))
    triangle, rotated = descent._triangle(matrix, values)
    assert np.allclose(triangle.T @ triangle, matrix.T @ matrix, atol=1e-9)
    assert np.allclose(triangle.T @ rotated, matrix.T @ values, atol=1e-9)
