"""How estimates scatter when a stretch of time is left out (jackknife).

Errors that are correlated, by coloured noise or by disturbances that nobody recorded, make every
estimate look surer than it is when samples are counted one by one. Stretches longer than the
autocorrelation time of the errors are nearly independent, whatever the noise.
"""

from collections.abc import Sequence
from math import pi

import numpy as np
from numpy.typing import NDArray

from elastic_tendon.actuator.parameters import Model, sizes_of
from elastic_tendon.comparison.residuals import Array, autocorrelation_time
from elastic_tendon.measurement import Measurement

# fewer stretches say little of how they scatter; more are no more independent
FEWEST_STRETCHES, MOST_STRETCHES = 10, 24
SHORTEST = 0.5  # s
FEWEST_SAMPLES = 10  # in a stretch
MEMORIES = 4.0  # in a stretch, so that neighbours are hardly correlated
MOSTLY_SLOW, SLOW = 0.5, 2.0  # share of white noise; facts in a recording of slow noise alone
SETTLED_ROWS = 10.0  # of a static curve, in which a wrong law changes its error


def settling_samples(model: Model, measurement: Measurement) -> float:
    """Number of samples in which the joint swings twice; by then it has answered to any push.

    What is correlated for longer was not stirred up by chance: it is the lack of fit itself.
    """
    if measurement.static:
        return SETTLED_ROWS
    period = 2.0 * pi / sizes_of(model.transmission, model.link).frequency
    return 2.0 * period / _sampling_interval(measurement)


def _sampling_interval(measurement: Measurement) -> float:
    return float(measurement.time[-1] - measurement.time[0]) / (len(measurement.time) - 1)


def independent_facts(model: Model, measurements: Sequence[Measurement], values: Array) -> float:
    """How many independent samples the stacked ones (N,) of all signals are worth.

    Samples within the autocorrelation time count as one, at most those in which the joint settles.
    """
    count, first = 0.0, 0
    for measurement in measurements:
        settled = settling_samples(model, measurement)
        for name in measurement.signals:
            own = values[first : first + len(measurement.time)]
            facts = len(own) / min(autocorrelation_time(own), settled)
            share = measurement.noise[name].white_share
            slow = share < MOSTLY_SLOW and not measurement.static
            count += min(facts, max(share * len(own), SLOW)) if slow else facts
            first += len(own)
    return count


def stretch_numbers(measurements: Sequence[Measurement], memory: float) -> NDArray[np.int_]:
    """Number of the stretch of time to which each of the N stacked samples belongs.

    Signals of one recording share their stretches, as one disturbance shows in all.

    Parameters
    ----------
    measurements : of n samples each
    memory : autocorrelation time in samples; a stretch is several times as long, if that leaves
        enough of them

    Returns
    -------
    (N,) array of int, from 0
    """
    total = sum(len(measurement.time) for measurement in measurements)
    numbers: list[NDArray[np.int_]] = []
    first = 0
    for measurement in measurements:
        samples = len(measurement.time)
        # rows of a static curve have no time that means anything
        shortest: float = FEWEST_SAMPLES
        if not measurement.static:
            shortest = max(shortest, SHORTEST / _sampling_interval(measurement))
        wanted = np.clip(total / (MEMORIES * memory), FEWEST_STRETCHES, MOST_STRETCHES)
        count = max(int(min(wanted * samples / total, samples / shortest)), 1)
        numbers += [first + (np.arange(samples) * count) // samples] * len(measurement.signals)
        first += count
    return np.concatenate(numbers).astype(np.int_)


def left_out(columns: Array, errors: Array, numbers: NDArray[np.int_]) -> Array:
    """By how much the least-squares solution moves when each stretch in turn is left out.

    Parameters
    ----------
    columns : (N + p, k) array, derivatives of the errors, and below them those of p priors
    errors : (N + p,) array
    numbers : (N,) array, stretch of each sample, see `stretch_numbers`

    Returns
    -------
    (B, k) array, in the unit of each column's parameter
    """
    scale = np.linalg.norm(columns, axis=0)
    scale[scale == 0.0] = 1.0
    scaled = columns / scale
    whole = scaled.T @ scaled
    gradient = scaled.T @ errors
    moves = np.empty((int(numbers.max()) + 1, columns.shape[1]))
    for index in range(len(moves)):
        own = np.flatnonzero(numbers == index)
        part = scaled[own]
        rest = whole - part.T @ part
        moves[index] = -np.linalg.lstsq(rest, gradient - part.T @ errors[own], rcond=1e-12)[0]
    return np.asarray(moves / scale)
