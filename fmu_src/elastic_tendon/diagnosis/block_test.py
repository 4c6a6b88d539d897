"""Whether columns explain an error on stretches that they were not fitted to, by more than chance.

The error is cut into blocks longer than its autocorrelation time. Each is predicted from the
others by that part of a term's columns which the fitted parameters cannot make. What chance would
give is found by turning the sign of the error in whole blocks at random and fitting the parameters
again: that keeps size, colour and memory, and destroys what is owed to the state of the machine
(the wild cluster bootstrap with jackknifed errors of J. G. MacKinnon, M. Ø. Nielsen and M. D. Webb,
Fast and reliable jackknife and bootstrap methods for cluster-robust inference, 2023). The best of
all terms is held against the best of all terms under chance, so their number is paid for.

What happens once cannot be predicted from other blocks; `sudden` asks for it.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.stats import f as f_distribution
from scipy.stats import t as t_distribution

from elastic_tendon.comparison.partition import Integers
from elastic_tendon.comparison.residuals import Array

TURNS = 255  # of signs at random; all that there are with up to ten blocks
MOST_EXACT = 10
SEED = 20240607
# how far a term's coefficients are held back, as shares of what its columns tell on average
RIDGES = (1e-3, 1e-2, 1e-1)
# largest share of what parameters tell that one block may be said to hold: the start is told by one
LEVERAGE = 0.9
LEAST_BLOCKS = 6  # of which one may stand out
APART = 3  # coefficients, of which neighbours are correlated


@dataclass(frozen=True)
class Products:
    """Sums of products over the rows of b blocks and s signals, whitened.

    Of p columns of fitted parameters, then k of a term: `gram` (b, s, p + k, p + k), `score`
    (b, s, p + k) with the error; `square` (b, s) of the error; `prior` (p, p) precision of the
    fitted parameters.
    """

    gram: Array
    score: Array
    square: Array
    prior: Array

    def merged(self, firsts: Integers) -> "Products":
        """Sums over neighbouring blocks; `firsts` are the first of each."""
        gram, score, square = (
            np.add.reduceat(sums, firsts) for sums in (self.gram, self.score, self.square)
        )
        return Products(gram, score, square, self.prior)

    @property
    def fitted(self) -> int:
        """Number p of columns of fitted parameters."""
        return len(self.prior)

    @cached_property
    def inverse(self) -> Array:
        """Covariance (p, p) of the fitted parameters."""
        p = self.fitted
        return _inverse(self.gram[..., :p, :p].sum(axis=(0, 1)) + self.prior)

    @cached_property
    def own(self) -> Array:
        """Way (p + k, k) to the part of a term's columns that fitted parameters cannot make."""
        p, k = self.fitted, self.gram.shape[-1] - self.fitted
        return np.vstack([-self.inverse @ self.gram.sum(axis=(0, 1))[:p, p:], np.eye(k)])


def signs_for(blocks: int) -> Array:
    """Signs of the blocks, (b, t), other than all alike; seed fixed.

    Parameters
    ----------
    blocks : int b
    """
    if blocks <= MOST_EXACT:
        # turning all signs changes nothing, so the last block keeps its own
        number = np.arange(1, 2 ** (blocks - 1))
        turned = (number >> np.arange(blocks)[:, np.newaxis]) & 1
    else:
        turned = np.random.default_rng(SEED).integers(0, 2, (blocks, TURNS))
    return np.asarray(1.0 - 2.0 * turned)


@dataclass(frozen=True)
class Turned:
    """The error with its signs turned and the parameters fitted again, for t turns.

    `signs` (b, t); `raised` (p, b): parameters whose columns are added to a block's error before
    it is turned; `shift` (p, t) by which they moved then; `square` (s, t) of what is left.
    """

    signs: Array
    raised: Array
    shift: Array
    square: Array


def error_as_is(products: Products) -> Turned:
    """The error itself, as the one turn."""
    blocks, p = len(products.square), products.fitted
    square = products.square.sum(axis=0)[:, np.newaxis]
    return Turned(np.ones((blocks, 1)), np.zeros((p, blocks)), np.zeros((p, 1)), square)


def turned_error(products: Products, signs: Array) -> Turned:
    """Fit the parameters to the error with other signs, (b, t).

    The fit has taken from each block what its parameters could make of it. That is given back
    before signs are turned, as by leaving the block out, or chance would look smaller than it is.
    """
    p = products.fitted
    gram, score = products.gram[..., :p, :p], products.score[..., :p]
    raised = _left_out(products, gram.sum(axis=1), score.sum(axis=1))
    shown = score + np.einsum("bsij,jb->bsi", gram, raised)
    square = products.square + np.einsum("ib,bsi->bs", raised, score + shown)
    shift = products.inverse @ (shown.sum(axis=1).T @ signs)
    cross = np.einsum("bsi,bt,it->st", shown, signs, shift, optimize=True)
    again = np.einsum("it,sij,jt->st", shift, gram.sum(axis=0), shift, optimize=True)
    return Turned(signs, raised, shift, square.sum(axis=0)[:, np.newaxis] - 2.0 * cross + again)


def _left_out(products: Products, gram: Array, score: Array) -> Array:
    """Parameters (p, b) by which the fit would differ without each block, times -1."""
    values, vectors = np.linalg.eigh(products.inverse)
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    found = []
    for own, error in zip(gram, score, strict=True):
        share, way = np.linalg.eigh(root.T @ own @ root)
        back = 1.0 / (1.0 - np.clip(share, 0.0, LEVERAGE))
        found.append(root @ (way * back) @ (way.T @ (root.T @ error)))
    return np.column_stack(found)


def gained(products: Products, turned: Turned) -> Array:
    """Squared error by which a term predicts each block from those that are not its neighbours.

    Parameters
    ----------
    products : Products of b blocks and s signals
    turned : the error of t turns

    Returns
    -------
    (s, t) array, under the best of the ridges
    """
    p, own = products.fitted, products.own
    half = own.T @ products.gram
    gram, base = half @ own, half[..., :p]
    raised = turned.raised.T[:, np.newaxis, :, np.newaxis]
    shown = (products.score @ own)[..., np.newaxis] + base @ raised
    score = shown * turned.signs[:, np.newaxis, np.newaxis] - base @ turned.shift
    return np.asarray(
        np.max([_predicted(gram, score, held) for held in held_back(products)], axis=0)
    )


def weights_within(
    products: Products, bounds: tuple[float, float], ridge: float
) -> tuple[Array, float]:
    """A term's coefficients (k,) within bounds, and the share of squared error they explain.

    The coefficients are those of all blocks; the share is of blocks that, with their neighbours,
    were left out.
    """
    way = products.own
    gram, score = way.T @ products.gram.sum(axis=1) @ way, products.score.sum(axis=1) @ way
    held = held_back(products)[RIDGES.index(ridge)] * np.eye(way.shape[1])
    whole, total = gram.sum(axis=0) + held, score.sum(axis=0)
    gain = 0.0
    unseen = zip(whole - _near(gram), total - _near(score), gram, score, strict=True)
    for others, told, own, error in unseen:
        found = _bounded(others, told, bounds)
        gain += float(found @ (2.0 * error - own @ found))
    return _bounded(whole, total, bounds), gain / float(products.square.sum())


def _bounded(gram: Array, score: Array, bounds: tuple[float, float]) -> Array:
    """Minimum of x·gram·x - 2 x·score within bounds, (k,)."""
    from scipy.optimize import lsq_linear

    root = np.linalg.cholesky(gram)
    scale = np.sqrt(np.diag(gram))
    solution = lsq_linear(
        root.T / scale,
        np.linalg.solve(root, score),
        (bounds[0] * scale, bounds[1] * scale),
        method="bvls",
    )
    return np.asarray(solution.x / scale)


def held_back(products: Products) -> list[float]:
    """What is added to the diagonal of a term's own products, for each ridge."""
    own = products.own
    gram = products.gram.sum(axis=(0, 1))
    told = np.trace(gram[products.fitted :, products.fitted :])
    # a term that says nothing of its own is held back altogether
    least = 1e-9 * told + np.finfo(float).tiny
    mean = np.trace(own.T @ gram @ own) / own.shape[1]
    return [float(max(ridge * mean, least)) for ridge in RIDGES]


def _predicted(gram: Array, score: Array, held: float) -> Array:
    """Squared error (s, t) less, of products (b, s, k, k) and scores (b, s, k, t)."""
    weights = _without_block(gram.sum(axis=1), score.sum(axis=1), held)[:, np.newaxis]
    return np.asarray(np.sum(weights * (2.0 * score - gram @ weights), axis=(0, 2)))


def _without_block(gram: Array, score: Array, held: float) -> Array:
    """Coefficients (b, k, t) for each block, from those that are not its neighbours.

    Neighbours are left out because their ends may be correlated with the block.
    """
    whole = gram.sum(axis=0) + held * np.eye(gram.shape[-1])
    return np.linalg.solve(whole - _near(gram), score.sum(axis=0) - _near(score))


def _near(blocks: Array) -> Array:
    """Sums over each block and its neighbours."""
    ends = np.zeros((1, *blocks.shape[1:]))
    padded: Array = np.concatenate([ends, blocks, ends])
    return padded[:-2] + blocks + padded[2:]


def sudden(products: Products) -> tuple[float, Array]:
    """Does one of a term's coefficients, with its neighbours, stand out from all the others?

    Both coefficients and coefficients over their uncertainty are tried, the less surprising counts:
    of a disturbance the ones are alike, of the noise the others.

    Returns
    -------
    probability by chance, their number paid for; and the share (s,) of squared error that the
    outlying ones explain
    """
    own = products.own
    gram, score = own.T @ products.gram.sum(axis=0) @ own, products.score.sum(axis=0) @ own
    covariance = _inverse(gram.sum(axis=0))
    found = covariance @ score.sum(axis=0)
    sigma = np.sqrt(np.maximum(np.diag(covariance), np.finfo(float).tiny))
    chances = np.maximum(_outlying(found), _outlying(found / sigma))
    first = int(np.argmin(chances))
    near = np.where(np.abs(np.arange(len(found)) - first) < APART, found, 0.0)
    square = np.maximum(products.square.sum(axis=0), np.finfo(float).tiny)
    explained = 2.0 * score @ near - np.einsum("i,sij,j->s", near, gram, near)
    return min(1.0, float(chances[first]) * len(found)), explained / square


def outburst(products: Products) -> tuple[Array, Array]:
    """Does one block err far more than all but its neighbours, as where something happened once?

    Each block counts as one fact, for the error may remember itself as long. The error of a
    disturbance that lasts is about as large everywhere.

    Returns
    -------
    (s,) probability by chance, the number of blocks paid for; and (s,) share of squared error by
    which the block and its neighbours err more than the others
    """
    square, blocks = products.square, len(products.square)
    if blocks < LEAST_BLOCKS:
        return np.ones(square.shape[1]), np.zeros(square.shape[1])
    chances, shares = [], []
    for own in square.T:
        near = np.abs(np.arange(blocks) - np.argmax(own)) <= 1
        usual = max(float(np.mean(own[~near])), np.finfo(float).tiny)
        chances.append(blocks * f_distribution.sf(np.max(own) / usual, 1, np.sum(~near)))
        shares.append(np.sum(own[near] - usual) / np.sum(own))
    return np.minimum(chances, 1.0), np.array(shares)


def _outlying(values: Array) -> Array:
    """Probability that each value (k,) is so large if it is of the kind of those apart from it."""
    index = np.arange(len(values))
    # what has run away could not be squared
    values = values / max(float(np.max(np.abs(values))), np.finfo(float).tiny)
    apart = np.abs(index[:, np.newaxis] - index) >= APART
    count = apart.sum(axis=1)
    spread = np.sqrt(apart @ values**2 / count)
    return np.asarray(
        2.0 * t_distribution.sf(np.abs(values) / np.maximum(spread, np.finfo(float).tiny), count)
    )


def unseen_weights(products: Products) -> Array:
    """Weights of all columns, (b, p + k), for each block found without it and its neighbours."""
    own = products.own
    gram, score = products.gram.sum(axis=1), products.score.sum(axis=1)[..., np.newaxis]
    found = _without_block(own.T @ gram @ own, own.T @ score, held_back(products)[1])
    return np.stack([own @ weights[:, 0] for weights in found])


def _inverse(matrix: Array) -> Array:
    """Inverse of a symmetric matrix, its columns scaled alike; what is singular stays 0."""
    scale = 1.0 / np.sqrt(np.maximum(np.diag(matrix), np.finfo(float).tiny))
    inverse = np.linalg.pinv(matrix * np.outer(scale, scale), rcond=1e-12, hermitian=True)
    return np.asarray(inverse * np.outer(scale, scale))


def gains_of(terms: Sequence[Products], turned: Turned) -> Array:
    """Share of the squared error that each term predicts, (terms, s, t)."""
    before = np.maximum(turned.square, np.finfo(float).tiny)
    return np.stack([gained(products, turned) for products in terms]) / before


def chance_of(terms: Sequence[Products], gains: Array) -> Array:
    """Probability, for each signal, that chance gives the best term so large a gain, (s,).

    Parameters
    ----------
    terms : of all, over the same blocks
    gains : (terms, s) array, of the error as it is
    """
    turned = turned_error(terms[0], signs_for(len(terms[0].square)))
    by_chance = gains_of(terms, turned).max(axis=0)
    better = np.sum(by_chance >= gains.max(axis=0)[:, np.newaxis], axis=1)
    return np.asarray((1.0 + better) / (1.0 + by_chance.shape[1]))
