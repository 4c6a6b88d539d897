"""What an answer errs on stretches of time that it was not fitted to.

Where more than noise is left, an effect that does not exist may still fit what is left, by chance;
it then errs more where it was not fitted. Stretches of the same recordings show that without any
other.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from elastic_tendon.actuator.parameters import Model
from elastic_tendon.comparison.residuals import (
    Array,
    beyond_rounding,
    noise_floors,
    residuals_of,
    simulate_measurement,
    stack,
)
from elastic_tendon.diagnosis.answer import Answer, refit
from elastic_tendon.diagnosis.refits import Check
from elastic_tendon.estimation.fit import QUICK
from elastic_tendon.estimation.stretches import settling_samples
from elastic_tendon.measurement import Measurement

STRETCHES = 4  # of all recordings together
SETTLINGS = 2.0  # times in which the joint settles, in the shortest stretch that tells anything
FEWEST = 100  # samples in it
# of fits to the other stretches, which begin at the answer
ENOUGH = replace(QUICK, scouted=2, rounds=1, tolerance=1e-3)

Tasks = Sequence[tuple[str, Callable[[Check], float]]]
AtOnce = Callable[[Tasks], Iterable[float | Exception]]


def crossed_squares(given: Model, answer: Answer, at_once: AtOnce) -> Array:
    """Mean square errors on each stretch of time, predicted from the others; in the noise's.

    Parameters
    ----------
    given : Model; centre of the prior
    answer : Answer, from which the fits to the others begin
    at_once : gives results of tasks, each with what is told of it, or why there are none

    Returns
    -------
    (k,) array for k stretches; NaN where recordings are too short, and infinite where a fit fails
    """
    measurements = answer.result.problem.measurements
    if not _long_enough(given, measurements):
        return np.full(1, np.nan)
    folds = list(_folds(measurements))
    words = "predicting stretches from one another"
    squares = list(at_once([(words, partial(_square, given, answer, *fold)) for fold in folds]))
    return np.array([np.inf if isinstance(square, Exception) else square for square in squares])


def median_explained(before: Array, after: Array) -> float:
    """Median over stretches of the share of squared error above the noise that an effect explains,
    or adds, -1 to 1.

    The median, as a stretch that goes far beyond the others, or for which a refit ends in another
    minimum, says little of the effect.

    Parameters
    ----------
    before, after : (k,) mean square errors without and with it, see `crossed_squares`
    """
    with np.errstate(invalid="ignore", divide="ignore"):
        gains = before - after
        shares = np.where(gains == 0.0, 0.0, gains / np.maximum(before - 1.0, np.abs(gains)))
    return float(np.median(np.where(np.isinf(after), -1.0, shares)))


def _square(
    given: Model,
    answer: Answer,
    left_out: Measurement,
    others: Sequence[Measurement],
    check: Check,
) -> float:
    """Mean square error on a stretch, predicted from the others."""
    start = answer.result.model
    fitted = refit(given, answer.added, others, [start], ENOUGH, check).result
    initial = fitted.problem.begun(fitted.model, left_out)
    motion = simulate_measurement(fitted.model, left_out, initial)
    residuals = beyond_rounding(residuals_of(motion, left_out), left_out)
    return float(np.mean(stack([residuals], [noise_floors(left_out)]) ** 2))


def _long_enough(model: Model, measurements: Sequence[Measurement]) -> bool:
    return not any(part.static for part in measurements) and all(
        len(stretch.time) > max(SETTLINGS * settling_samples(model, part), FEWEST)
        for part in measurements
        for stretch in _stretches(part, len(measurements))
    )


def _folds(
    measurements: Sequence[Measurement],
) -> Iterator[tuple[Measurement, tuple[Measurement, ...]]]:
    """Each stretch, and all others."""
    stretches = [
        stretch for part in measurements for stretch in _stretches(part, len(measurements))
    ]
    for number, left_out in enumerate(stretches):
        yield left_out, (*stretches[:number], *stretches[number + 1 :])


def _stretches(measurement: Measurement, recordings: int) -> Iterator[Measurement]:
    """Parts of one recording, of about equal length."""
    count = max(STRETCHES // recordings, 1)
    for part in np.array_split(np.arange(len(measurement.time)), count):
        yield measurement.samples(slice(int(part[0]), int(part[-1]) + 1))
