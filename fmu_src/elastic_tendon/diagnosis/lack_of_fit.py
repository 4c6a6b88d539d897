"""What remains of the error: does it depend on the state of the machine?"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from elastic_tendon.comparison.residuals import Array, rms
from elastic_tendon.diagnosis.block_test import (
    Products,
    chance_of,
    error_as_is,
    gains_of,
    outburst,
    sudden,
    unseen_weights,
)
from elastic_tendon.diagnosis.columns import Term, moments, terms_for
from elastic_tendon.diagnosis.motion import Motion
from elastic_tendon.diagnosis.rows import Rows, rows_of
from elastic_tendon.estimation.fit import FitResult
from elastic_tendon.progress import Progress, silent

SIGNIFICANT = 0.02  # probability by chance, of all signals together
# of the noise floor: what explains less than this RMS is no effect, but what solving leaves, or
# noise of the motor's encoder, which shows where the motor turns
AUDIBLE = 0.7
# ... and less sure may be what is larger than nobody wants to hear of
LOUD, LIKELY = 1.5, 0.1
RARELY = 10.0  # times less often than anything else a load comes once, of which nobody knows
# times the noise floor: much of what remains, unless nothing tells it from a disturbance, ...
TOO_LARGE = 5.0
# ... and nobody would call a model adequate, whatever disturbs the machine
OVERWHELMING = 10.0
# a disturbance: more probable by chance, and less of it predicted on unseen stretches
CHANCY, EXPLAINED = 0.2, 0.25
# correlations above those of chance by so many standard deviations are memory
REMEMBERED = 4.0
TRIED = (10, 20)  # blocks, in search of what is memory and what is a missing effect


@dataclass(frozen=True)
class LackOfFit:
    """Of one signal: does its error depend on the state of the machine by more than chance?

    `p_value` pays for the number of terms and signals; `variables` are those of the best term,
    `explains` the share of the squared error that it predicts on stretches it has not seen.
    """

    p_value: float
    significant: bool
    variables: tuple[str, ...]
    explains: float

    @property
    def shapeless(self) -> bool:
        """Whether nothing tells it from a disturbance that nobody recorded."""
        return self.p_value > CHANCY and self.explains < EXPLAINED

    def or_surely(self, again: "LackOfFit") -> "LackOfFit":
        """This, or what a second look at more recordings finds, if it leaves no doubt."""
        return again if again.significant and again.p_value <= SIGNIFICANT else self


@dataclass(frozen=True)
class Regression:
    """The residuals of a fit, regressed on terms of the state of the machine.

    `products` of each of the `terms`, over blocks that are longer than the error remembers;
    `gains` (terms, signals): share of squared error that each predicts on unseen blocks;
    `found` for each signal.
    """

    motions: tuple[Motion, ...]
    terms: tuple[Term, ...]
    products: tuple[Products, ...]
    gains: Array
    found: Mapping[str, LackOfFit]


def regress(result: FitResult, progress: Progress = silent) -> Regression:
    """Regress the residuals of a fit on every term of the state of the machine.

    Parameters
    ----------
    result : of a fit
    progress : told what is being done, and the share of it that is done

    Returns
    -------
    Regression; its `found` judges for each signal whether its error depends on the state
    """
    pairs = zip(result.problem.measurements, result.initial_states, strict=True)
    motions = tuple(Motion(result.model, recording, initial) for recording, initial in pairs)
    terms = terms_for(motions)
    rows = rows_of(result, motions)
    products = []
    for index, term in enumerate(terms):
        progress("what remains of the error", index / (len(terms) + 1))
        products.append(rows.products(term))
    progress("what remains of the error", len(terms) / (len(terms) + 1))
    gains = gains_of(products, error_as_is(products[0]))[..., 0]
    best = int(np.argmax(gains.max(axis=1)))
    firsts = rows.longer_blocks(_memory(rows, terms[best], products[best]))
    products = [product.merged(firsts) for product in products]
    gains = gains_of(products, error_as_is(products[0]))[..., 0]
    chances = chance_of(products, gains) * len(rows.names)
    for motion, blocks in zip(motions, rows.counts, strict=True):
        if blocks > 1 and not motion.measurement.static:  # of one block see `outburst`
            terms.append(moments(motion))
            products.append(rows.products(terms[-1]))
            chance, shares = sudden(products[-1])
            chance *= RARELY * len(motions)
            once = (chance < chances) & (shares > gains.max(axis=0))
            chances = np.where(once, chance, chances)
            gains = np.vstack([gains, np.where(once, shares, 0.0)])
    found = {}
    for signal, (name, lack) in enumerate(
        zip(rows.names, _outbursts(motions, products), strict=True)
    ):
        explains = max(0.0, float(gains[:, signal].max()))
        if chances[signal] <= lack.p_value or explains >= lack.explains:
            variables = terms[int(np.argmax(gains[:, signal]))].variables
            lack = LackOfFit(min(1.0, float(chances[signal])), False, variables, explains)
        judged = _is_significant(lack, *_loudness(motions, name))
        found[name] = replace(lack, significant=judged)
    return Regression(motions, tuple(terms), tuple(products), gains, found)


def _outbursts(motions: Sequence[Motion], products: Sequence[Products]) -> Iterator[LackOfFit]:
    """For each signal whether it errs far more in one block than in all others."""
    static = any(motion.measurement.static for motion in motions)
    for chance, share in zip(*outburst(products[0]), strict=True):
        p_value = 1.0 if static else min(1.0, RARELY * float(chance))
        yield LackOfFit(p_value, False, ("time",), float(share))


def _is_significant(found: LackOfFit, error: float, noise: float) -> bool:
    """By more than chance and large enough to be an effect; or too large to be a disturbance."""
    explained, ratio = found.explains * error / noise, np.sqrt(error / noise)
    surely = found.p_value <= SIGNIFICANT and explained > AUDIBLE**2
    loudly = found.p_value <= LIKELY and explained > LOUD**2
    large = ratio > TOO_LARGE and not found.shapeless
    return bool(surely or loudly or large or ratio > OVERWHELMING)


def _loudness(motions: Sequence[Motion], name: str) -> tuple[float, float]:
    """Mean squares of the error and of its noise."""
    with_it = [motion for motion in motions if name in motion.errors]
    error = np.mean([rms(part.errors[name]) ** 2 for part in with_it])
    noise = np.mean([part.measurement.noise[name].sigma ** 2 for part in with_it])
    return float(error), float(noise)


def _memory(rows: Rows, term: Term, products: Products) -> float:
    """How long the error remembers, in samples, less what the best term predicts of it.

    What a missing effect adds would look like a long memory. It is predicted for each block from
    the others, because fitted to all of them, a term would eat a disturbance and hide its memory.
    Long blocks may be unlike all others, short ones remember; the better prediction counts.
    """
    found = []
    for number in TRIED:
        firsts = rows.merged_to(number)
        weights = unseen_weights(products.merged(firsts))
        sizes = np.diff(firsts, append=len(products.square))
        left = rows.left_by(term, np.repeat(weights, sizes, axis=0))
        found.append(max(memory_of(error) for errors in left for error in errors.values()))
    return min(found)


def memory_of(error: Array) -> float:
    """Number of samples over which an error remembers itself, (n,) array; 1 where it does not.

    By the sum of squared correlations, which an oscillation that dies away does not cancel, and
    by the longest lags at which they are still above those of chance (M. S. Bartlett, 1946).
    """
    n = len(error)
    spectrum = np.abs(np.fft.rfft(error - np.mean(error), 2 * n)) ** 2
    covariance = np.fft.irfft(spectrum)[: max(n // 4, 2)]
    if covariance[0] <= 0.0:
        return 1.0
    squares = (covariance[1:] / covariance[0]) ** 2
    memory = 1.0 + 2.0 * float(np.sum(np.maximum(squares - 1.0 / n, 0.0)[: max(n // 10, 1)]))
    longest, low = memory, 1
    while low < len(squares):
        band = squares[low - 1 : 2 * low - 1]
        above = REMEMBERED * np.sqrt(2.0 * max(memory, 1.0) / len(band))
        if n / memory * float(np.mean(band)) - 1.0 > above:
            longest = max(longest, 0.2 * low)
        low *= 2
    return longest
