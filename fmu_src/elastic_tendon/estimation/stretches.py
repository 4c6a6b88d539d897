"""How estimates scatter when a stretch of time is left out (jackknife).

Errors that hang together, by coloured noise or by disturbances that nobody recorded, make every
estimate look surer than it is when samples are counted one by one. Stretches longer than the
memory of the errors are nearly independent, whatever the noise.
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
MEMORIES = 4.0  # in a stretch, so that neighbours hardly hang together
SETTLED_ROWS = 10.0  # of a static curve, in which a wrong law changes its error


def settling_samples(model: Model, measurement: Measurement) -> float:
    """Number of samples in which the joint swings twice; by then it has answered to any push.

    What hangs together longer was not stirred up by chance: it is the lack of fit itself.
    """
    if measurement.static:
        return SETTLED_ROWS
    period = 2.0 * pi / sizes_of(model.transmission, model.link).frequency
    step = float(measurement.time[-1] - measurement.time[0]) / (len(measurement.time) - 1)
    return 2.0 * period / step


def independent_facts(model: Model, measurements: Sequence[Measurement], values: Array) -> float:
    """How many independent facts there are in the stacked samples (N,) of all signals.

    Those that hang together count as one, but no longer than the joint takes to settle.
    """
    facts, first = 0.0, 0
    for one in measurements:
        settled = settling_samples(model, one)
        for _ in one.signals:
            own = values[first : first + len(one.time)]
            facts += len(own) / min(autocorrelation_time(own), settled)
            first += len(own)
    return facts


def stretch_numbers(measurements: Sequence[Measurement], memory: float) -> NDArray[np.int_]:
    """Number of the stretch of time to which each of the N stacked samples belongs.

    Signals of one recording share their stretches, as one disturbance shows in all.

    Parameters
    ----------
    measurements : of n samples each
    memory : number of samples that hang together; a stretch is several times as long, if that
        leaves enough of them

    Returns
    -------
    (N,) array of int, from 0
    """
    total = sum(len(one.time) for one in measurements)
    numbers: list[NDArray[np.int_]] = []
    first = 0
    for one in measurements:
        samples = len(one.time)
        step = (one.time[-1] - one.time[0]) / (samples - 1)
        # rows of a static curve have no time that means anything
        shortest = FEWEST_SAMPLES if one.static else max(FEWEST_SAMPLES, SHORTEST / step)
        wanted = np.clip(total / (MEMORIES * memory), FEWEST_STRETCHES, MOST_STRETCHES)
        count = max(int(min(wanted * samples / total, samples / shortest)), 1)
        numbers += [first + (np.arange(samples) * count) // samples] * len(one.signals)
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
    (B, k) array, in the unit of each column's number
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
