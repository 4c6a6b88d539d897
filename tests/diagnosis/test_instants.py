"""Functions of CasADi at many instants at once give what its own machine gives one by one."""

import casadi as ca
import numpy as np
import pytest

from elastic_tendon.diagnosis.instants import AtInstants

N = 50
X, P = ca.SX.sym("x", 2), ca.SX.sym("p")
UNARY = (
    *("sqrt", "exp", "expm1", "log", "log1p", "erf"),
    *("sin", "cos", "tan", "asin", "acos", "atan"),
    *("sinh", "cosh", "tanh", "asinh", "acosh", "atanh"),
    *("floor", "ceil", "fabs", "sign", "logic_not"),
)
BINARY = (
    *("fmod", "remainder", "fmin", "fmax", "copysign", "atan2", "hypot", "power"),
    *("lt", "le", "eq", "ne", "logic_and", "logic_or"),
)


def one_by_one(function: ca.Function, x: np.ndarray, p: np.ndarray) -> np.ndarray:
    return np.array([function(place, p).full().ravel() for place in x])


def assert_same(column: ca.SX, x: np.ndarray, p: np.ndarray, accuracy: float = 1e-14) -> None:
    function = ca.Function("f", [X, P], [ca.densify(column)])
    found = AtInstants(function)(N, x, p)
    assert found.shape == (N, column.numel())
    np.testing.assert_allclose(found, one_by_one(function, x, p), rtol=accuracy, equal_nan=True)


@pytest.fixture(scope="module")
def places() -> np.ndarray:
    """Some of them zero, equal, or where functions have no value."""
    found = np.random.default_rng(1).uniform(-2.0, 2.0, (N, 2))
    found[0], found[1] = 0.0, 1.0
    return found


@pytest.mark.parametrize("name", UNARY)
def test_functions_of_one(name: str, places: np.ndarray) -> None:
    function = getattr(ca, name)
    assert_same(ca.vertcat(function(X[0]), function(P)), places, np.array([0.3]))


@pytest.mark.parametrize("name", BINARY)
def test_functions_of_two(name: str, places: np.ndarray) -> None:
    function = getattr(ca, name)
    assert_same(ca.vertcat(function(X[0], X[1]), function(P, X[0])), places, np.array([0.3]))


def test_where_casadi_is_approximate() -> None:
    shares = np.linspace(-0.9, 0.9, N)[:, np.newaxis] * np.ones(2)
    assert_same(ca.erfinv(X), shares, np.zeros(1), accuracy=1e-5)


def test_arithmetic_conditions_and_constants(places: np.ndarray) -> None:
    column = ca.vertcat(
        X[0] + X[1] - 2 * X[0] / X[1],
        ca.if_else(X[0] > P, X[1] ** 3, -1 / X[0]),
        X[0] ** 2,
        X[0] ** 2.5,
        7.0,
        P,
        0.0,
    )
    assert_same(column, places, np.array([0.3]))
