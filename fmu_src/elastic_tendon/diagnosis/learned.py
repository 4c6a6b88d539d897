"""What remains of the error as an effect of its own, learned from the measurements.

The term that predicts most of the error on stretches it was not fitted to becomes the text of an
effect file like any user's: friction opposes the motion, springs stay springs, and beyond what
was measured the curve fades away. It says what is missing, not why.
"""

from operator import itemgetter

import numpy as np

from elastic_tendon import effects
from elastic_tendon.comparison.residuals import Array
from elastic_tendon.diagnosis.block_test import RIDGES, weights_within
from elastic_tendon.diagnosis.columns import Term
from elastic_tendon.diagnosis.effect_text import effect_text
from elastic_tendon.diagnosis.forms import Curve
from elastic_tendon.diagnosis.lack_of_fit import Regression
from elastic_tendon.diagnosis.result import LearnedTerm
from elastic_tendon.effects.base import Effect

CANDIDATES = 4  # curves that are learned under the bounds of physics
# of what the best term explains: a curve that explains less follows from something else
WORTHWHILE = 0.8
# of what the best curve explains: an earlier form that explains as much is simpler
AS_GOOD = 0.95
DIGITS = 6  # of a coefficient; more say nothing


def learn(found: Regression) -> LearnedTerm | None:
    """Learn what remains of the error as a smooth function in a slot.

    Parameters
    ----------
    found : the residuals of a fit, held against the state

    Returns
    -------
    LearnedTerm; None where the error depends on nothing by more than chance, or on nothing that
    an effect can be made of, such as time
    """
    signals = [index for index, lack in enumerate(found.found.values()) if lack.significant]
    if not signals:
        return None
    gains = found.gains[:, signals].mean(axis=1)
    offered = [
        index
        for index in np.argsort(-gains)
        if found.terms[index].curve is not None and gains[index] > WORTHWHILE * gains.max()
    ][:CANDIDATES]
    learned = [_within_bounds(found, index) for index in sorted(offered)]
    best = max((explains for _, _, explains in learned), default=0.0)
    if best <= WORTHWHILE * gains.max():
        return None
    return next(
        _term(found, curve, coefficients, explains)
        for curve, coefficients, explains in learned
        if explains >= AS_GOOD * best
    )


def learned_effect(term: LearnedTerm) -> Effect:
    """Load a learned term as a user's own file is loaded; models can name its id then.

    Raises
    ------
    EffectError : its text cannot be used
    """
    return effects.load_text(term.source.encode(), f"{term.id}.py")


def _within_bounds(found: Regression, index: int) -> tuple[Curve, Array, float]:
    """A curve with coefficients that physics allows, and the share of error it explains."""
    term: Term = found.terms[index]
    assert term.curve is not None
    lower, upper = term.curve.bounds(found.motions[0].model)
    # the error is simulated less measured, so what it depends on is missing with the other sign
    tried = [weights_within(found.products[index], (-upper, -lower), ridge) for ridge in RIDGES]
    weights, explains = max(tried, key=itemgetter(1))
    # a solution on a bound may be off it by rounding
    return term.curve, np.clip(-weights, lower, upper), explains


def _term(found: Regression, curve: Curve, coefficients: Array, explains: float) -> LearnedTerm:
    values = {
        name: float(f"{value:.{DIGITS}g}")
        for name, value in zip(curve.names, coefficients.tolist(), strict=True)
    }
    typical = float(np.max(np.abs(coefficients)))
    bounds = curve.bounds(found.motions[0].model)
    data = ", ".join(motion.measurement.name for motion in found.motions)
    effect_id, source = effect_text(curve, bounds, typical, data, explains)
    return LearnedTerm(
        id=effect_id,
        slot=curve.form.slot.name,
        variables=curve.form.variables,
        source=source,
        values=values,
        explains=explains,
    )
