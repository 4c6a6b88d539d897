"""Tests of the residual in words: what they claim follows from the correlations, and only then."""

import numpy as np
import pytest

from elastic_tendon.comparison.correlations import Correlation
from elastic_tendon.reports.residual_tests import HEADS, residual_rows, residual_sentence

LAGS = 0.01 * np.arange(1.0, 101.0)


def correlation(signal: str, values, expected: float = 0.0) -> Correlation:
    """Of 100 lags of 10 ms, with bounds of 0.1."""
    nothing = np.zeros(100)
    return Correlation(signal, LAGS, values, nothing + expected, nothing + 0.1, 100.0)


def peak(height: float, at: int = 1, width: int = 1) -> np.ndarray:
    values = np.zeros(100)
    values[at : at + width] = height
    return values


def said(*every: Correlation) -> str:
    return residual_sentence("joint_position", every)


def test_a_white_residual_follows_nothing() -> None:
    assert said(correlation("", peak(0.11)), correlation("load_torque", peak(0.0))) == (
        "What is left of the joint position is white as far as can be told (1 of 100 lags lies "
        "beyond their 99 % bounds, by chance 1). It follows no input by more than chance."
    )


def test_the_memory_ends_at_the_last_lag_that_is_sure() -> None:
    own = correlation("", peak(0.5, width=11) + peak(0.12, at=60))
    assert "it hangs together over 120 ms (12 of 100 lags lie" in said(own)
    assert "over at least 1 s (" in said(correlation("", np.full(100, 0.9)))


def test_noise_with_memory_is_not_called_white() -> None:
    words = said(correlation("", np.full(100, 0.6), expected=0.6))
    assert "hangs together no more than the noise of its sensor (0 of 100 lags" in words
    assert words.endswith("No input changes that it could follow.")


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_the_input_that_is_followed_most_is_told_with_its_lag(sign: float) -> None:
    own = correlation("", peak(0.5))
    weaker = correlation("motor_velocity", peak(0.3, at=4))
    stronger = correlation("motor_position", peak(0.41 * sign, at=1))
    words = said(own, weaker, stronger, correlation("load_torque", peak(0.05)))
    assert words.endswith(
        f"It follows the motor position: correlation {0.41 * sign:.2f} at a lag of 20 ms, 99 % "
        "bound 0.1; it follows the motor velocity, too."
    )


def test_every_correlation_has_a_row_with_what_chance_would_give() -> None:
    rows = list(
        residual_rows([correlation("", peak(0.5, 4), 0.2), correlation("load_torque", peak(-0.11))])
    )
    assert all(len(row) == len(HEADS) for row in rows)
    assert rows == [
        ["itself", "0.500", "50 ms", "0.100 to 0.300", "100 of 100", "1", "yes"],
        ["the load torque", "-0.110", "20 ms", "-0.100 to 0.100", "1 of 100", "1", "no"],
    ]
