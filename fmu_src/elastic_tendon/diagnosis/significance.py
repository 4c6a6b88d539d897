"""Is a gain more than chance, whatever the noise; and does it last on data that was not fitted?

Correlated errors (coloured noise, disturbances that nobody recorded) make everything look
significant that is judged sample by sample. So errors are taken by stretches of time longer than
their autocorrelation time, and each stretch is left out once (jackknife): how the answer scatters
then is its uncertainty.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.stats import f as f_distribution
from scipy.stats import t as t_distribution

from elastic_tendon import effects
from elastic_tendon.comparison.residuals import (
    Array,
    autocorrelation_time,
    stack,
)
from elastic_tendon.diagnosis.answer import Answer, facts_between
from elastic_tendon.estimation.stretches import left_out, stretch_numbers
from elastic_tendon.measurement import Measurement

CHANCE = 0.01  # probability up to which a gain is no chance ...
REFUTED = 0.05  # ... and a loss on held-out data is none
# of a zero or a load that was not told, which hardly any recording is without
COMMON = 0.05


def significance(before: Answer, after: Answer, effect_id: str) -> float:
    """Probability that adding an effect gains so much where it is not there.

    What the effect brought, the change of the errors from one fit to the other, is taken as one
    column beside the free parameters; its coefficient is one, and the jackknife says how surely it
    is not zero. That the column was itself fitted is paid for by as many degrees of freedom as
    the effect has parameters; a single one that cannot be negative counts half (Self & Liang 1987).

    Parameters
    ----------
    before, after : Answer without and with the effect
    effect_id : what came in

    Returns
    -------
    float, 0 to 1
    """
    result = after.result
    sigmas = result.sigmas
    change = stack(before.errors, sigmas) - stack(after.errors, sigmas)
    if not change.any():
        return 1.0
    own = [
        index
        for index, path in enumerate(result.problem.coordinates.paths)
        if path.startswith(f"effects.{effect_id}.")
    ]
    jacobian, errors = _linear(after, without=own)
    padded = np.zeros((len(errors), 1))
    padded[: len(change), 0] = -change
    columns = np.hstack([jacobian, padded])
    moves = left_out(columns, errors, _stretches(before, after))
    count = len(moves)
    if count < 3:
        return 1.0
    scatter = float(np.sum(moves[:, -1] ** 2)) * (count - 1) / count
    parameters, freedom = effects.BY_ID[effect_id].parameters, len(own)
    tail = float(f_distribution.sf(1.0 / max(scatter * freedom, 1e-300), freedom, count - 1))
    one_sided = freedom == 1 and parameters[0].lower >= parameters[0].null
    return 0.5 * tail if one_sided else tail


def heldout_significance(before: Array, after: Array, heldout: Sequence[Measurement]) -> float:
    """Probability that squared errors on held-out recordings fall so much by chance.

    By stretches of time: Student's test of whether they fall on average (Diebold & Mariano 1995).

    Parameters
    ----------
    before, after : (N,) arrays, see `heldout_errors`
    heldout : the recordings
    """
    fall = before**2 - after**2
    memory = autocorrelation_time(fall - float(np.mean(fall)))
    numbers = stretch_numbers(heldout, memory)
    means = np.bincount(numbers, fall) / np.bincount(numbers)
    scatter = float(np.std(means, ddof=1)) / np.sqrt(len(means)) if len(means) > 2 else 0.0
    if scatter == 0.0:
        return 1.0
    return float(t_distribution.sf(float(np.mean(means)) / scatter, len(means) - 1))


def heldout_worse(after: Array, before: Array, heldout: Sequence[Measurement]) -> bool:
    """Whether errors on held-out recordings have surely grown from one answer to the next.

    A single bad moment does not say so: parameters that the fitted data leave open may show there
    first.
    """
    return heldout_significance(after, before, heldout) < REFUTED


def _stretches(before: Answer, after: Answer) -> NDArray[np.int_]:
    memory = len(after.floored) / facts_between(before, after)
    return stretch_numbers(after.result.problem.measurements, memory)


def _linear(answer: Answer, without: Sequence[int]) -> tuple[Array, Array]:
    """Jacobian (N + m, k) and residuals (N + m,) of a fit, parameters on their bounds held."""
    result = answer.result
    problem = result.problem
    jacobian = result.derivatives
    free = problem.off_bounds(result.vector)
    free[list(without)] = False
    kept = jacobian[:, free]
    kept = kept[:, np.linalg.norm(kept, axis=0) > 0.0]
    return kept, problem.residuals(result.vector, result.sigmas)
