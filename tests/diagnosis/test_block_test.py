"""The block test on rows made of known columns and noise."""

import numpy as np
import pytest

from elastic_tendon.diagnosis import block_test
from elastic_tendon.diagnosis.block_test import (
    RIDGES,
    Products,
    chance_of,
    error_as_is,
    gains_of,
    outburst,
    signs_for,
    sudden,
    turned_error,
    weights_within,
)
from elastic_tendon.diagnosis.lack_of_fit import memory_of
from truth.noise import coloured_noise

BLOCKS, ROWS = 20, 50


def products_of(
    fitted: np.ndarray, columns: np.ndarray, error: np.ndarray, blocks: int = BLOCKS
) -> Products:
    """Products of rows of one signal, in blocks of one length."""
    rows = np.hstack([fitted, columns]).reshape(blocks, -1, fitted.shape[1] + columns.shape[1])
    left = error.reshape(blocks, -1)
    return Products(
        gram=np.einsum("bni,bnj->bij", rows, rows)[:, np.newaxis],
        score=np.einsum("bni,bn->bi", rows, left)[:, np.newaxis],
        square=np.einsum("bn,bn->b", left, left)[:, np.newaxis],
        prior=np.zeros((fitted.shape[1], fitted.shape[1])),
    )


def case(strength: float, seed: int = 1) -> Products:
    """Two fitted columns and three of a term, of which one acts with this strength."""
    rng = np.random.default_rng(seed)
    n = BLOCKS * ROWS
    fitted, columns = rng.standard_normal((n, 2)), rng.standard_normal((n, 3))
    error = rng.standard_normal(n) + strength * columns[:, 1]
    error -= fitted @ np.linalg.lstsq(fitted, error, rcond=None)[0]
    return products_of(fitted, columns, error)


def gain(products: Products) -> float:
    return float(gains_of([products], error_as_is(products))[0, 0, 0])


def test_the_gain_is_the_share_of_the_error_that_is_explained() -> None:
    # of variance 1 + 0.25 a fifth; 1000 rows leave it uncertain by 0.02
    assert gain(case(0.5)) == pytest.approx(0.2, abs=0.05)
    assert gain(case(0.0)) < 0.01


def test_what_is_there_is_found_and_what_is_not_is_not() -> None:
    found = case(0.5)
    gains = gains_of([found], error_as_is(found))[..., 0]
    assert chance_of([found], gains)[0] < 0.01
    chances = []
    for seed in range(30):
        none = case(0.0, seed)
        chances.append(chance_of([none], gains_of([none], error_as_is(none))[..., 0])[0])
    # uniform between 0 and 1
    assert 0.3 < np.mean(chances) < 0.7
    assert np.sum(np.array(chances) <= 0.05) <= 4


def test_what_happens_once_stands_out_and_what_happens_all_the_time_does_not() -> None:
    rng = np.random.default_rng(4)
    n, moments = BLOCKS * ROWS, 20
    fitted = rng.standard_normal((n, 2))
    columns = np.repeat(np.eye(moments), n // moments, axis=0)
    once = rng.standard_normal(n) + 3.0 * columns[:, 7]
    chance, share = sudden(products_of(fitted, columns, once))
    assert chance < 1e-6
    # nine of variance one beside it, in one of twenty moments
    assert share[0] == pytest.approx(0.45 / 1.45, abs=0.05)
    always = [
        sudden(products_of(fitted, columns, columns @ rng.standard_normal(moments)))[0]
        for _ in range(30)
    ]
    assert np.sum(np.array(always) <= 0.05) <= 4


def test_an_error_that_is_large_once_is_an_outburst_and_one_that_lasts_is_none() -> None:
    rng = np.random.default_rng(6)
    n = BLOCKS * ROWS
    columns = rng.standard_normal((n, 2))
    once = rng.standard_normal(n)
    once[7 * ROWS : 8 * ROWS] *= 12.0
    chance, share = outburst(products_of(columns, columns, once))
    assert chance[0] < 1e-4
    assert share[0] == pytest.approx(143.0 / (143.0 + BLOCKS), abs=0.05)  # of the variance
    always = [
        outburst(products_of(columns, columns, np.repeat(rng.standard_normal(BLOCKS), ROWS)))[0][0]
        for _ in range(30)
    ]
    assert np.sum(np.array(always) <= 0.05) <= 2
    few = products_of(columns, columns, once, blocks=5)
    assert outburst(few)[0][0] == 1.0


def test_columns_that_the_fitted_numbers_can_make_explain_nothing() -> None:
    rng = np.random.default_rng(2)
    fitted = rng.standard_normal((BLOCKS * ROWS, 2))
    same = products_of(fitted, fitted @ rng.standard_normal((2, 2)), rng.standard_normal(1000))
    assert abs(gain(same)) < 1e-3


def test_signs_are_all_that_there_are_or_always_the_same() -> None:
    few = signs_for(5)
    assert few.shape == (5, 15)
    assert len({tuple(one) for one in few.T}) == 15
    assert np.all(few[-1] == 1.0)
    np.testing.assert_array_equal(signs_for(30), signs_for(30))


def test_an_error_fitted_again_is_smaller_and_without_turn_the_same() -> None:
    products = case(0.3)
    kept = turned_error(products, np.ones((BLOCKS, 1)))
    assert kept.square[0, 0] >= 0.999 * products.square.sum()
    given_back = kept.square[0, 0] / products.square.sum()
    assert given_back < 1.1


def test_blocks_merge_to_the_same_sums() -> None:
    products = case(0.3)
    merged = products.merged(np.arange(0, BLOCKS, 4))
    assert len(merged.square) == BLOCKS // 4
    np.testing.assert_allclose(merged.gram.sum(axis=0), products.gram.sum(axis=0), rtol=1e-12)
    np.testing.assert_allclose(merged.inverse, products.inverse, rtol=1e-9)


def test_coefficients_keep_their_bounds() -> None:
    products = case(0.5)
    free, explains = weights_within(products, (-10.0, 10.0), RIDGES[0])
    assert free[1] == pytest.approx(0.5, abs=0.1)
    assert explains == pytest.approx(0.2, abs=0.05)
    bounded, less = weights_within(products, (-10.0, 0.0), RIDGES[0])
    assert np.all(bounded <= 0.0)
    assert less < 0.02


def test_memory_is_that_of_the_noise() -> None:
    rng = np.random.default_rng(3)
    assert memory_of(rng.standard_normal(5000)) < 2.0
    # of first-order noise 1 + 2 sum(rho^2): 9.5 samples
    assert memory_of(coloured_noise(rng, 20_000, 1.0, 0.9)) == pytest.approx(9.5, rel=0.4)
    decay, time = 0.99, np.arange(400)
    ringing = np.convolve(rng.standard_normal(8000), decay**time * np.cos(0.1 * time))
    # an oscillation that dies away within 100 samples is not told by its first half period
    assert 30.0 < memory_of(ringing) < 200.0
    assert memory_of(np.zeros(100)) == 1.0


def test_what_is_out_of_all_scale_is_judged_by_its_shape() -> None:
    """An error that has run away is squared like any other."""
    values = np.random.default_rng(3).standard_normal(40)
    values[20] = 9.0
    chances = block_test._outlying(values)
    assert np.allclose(block_test._outlying(1e200 * values), chances)
    assert np.argmin(chances) == 20
