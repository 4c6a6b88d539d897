"""Fits of recordings in segments, for machines that nearly integrate.

What drives such a machine adds up: from parameters that are far off it is soon far away, and a
descent on a whole recording ends where one error makes up for another. Over a short segment with an
initial state of its own (multiple shooting, Bock 1983) it stays near, and its parameters show.
"""

from contextlib import suppress
from dataclasses import replace
from itertools import pairwise

import numpy as np

from elastic_tendon.actuator.variables import moved_states
from elastic_tendon.comparison.residuals import Array, noise_floors, sensitivity, stack
from elastic_tendon.errors import SimulationError
from elastic_tendon.estimation.problem import Problem
from elastic_tendon.measurement import Measurement

COUNTS = (8, 4, 2)  # segments of all recordings together, one fit after the other
FEWEST = 20  # samples in a segment
LASTING = 0.5  # share of a shift at the beginning that is there on average: springs take it back
MUCH = 2.25  # mean square, in the noise's, from which more than noise is left
# times by which the mean square of segments promises to fall: up to 3.3 where fits of EMPS and of
# simulated axes had ended as low as any, 8 and more where they had not
PROMISING = 5.0


def in_segments(problem: Problem, count: int) -> Problem:
    """The problem with its recordings cut into about so many segments of equal length, each with an
    initial state of its own; recordings that are no longer than that stay whole."""
    longest = sum(map(_duration, problem.measurements)) / count
    pieces = (
        piece
        for part in problem.measurements
        for piece in _cut(part, round(_duration(part) / longest))
    )
    return replace(problem, measurements=tuple(pieces))


def nearly_integrates(problem: Problem, vector: Array) -> bool:
    """Whether what is moved stays where it was shifted to at the beginning of the longest
    recording, as an axis without springs does, or a motor with its joint on no others."""
    index = max(range(len(problem.measurements)), key=lambda i: _duration(problem.measurements[i]))
    part, initial = problem.measurements[index], problem.initial_states(vector)[index]
    found = sensitivity(problem.model(vector), part, initial, (), problem.tolerance).derivatives
    positions = moved_states(problem.kind)[::2]
    shifts = [np.mean(found[name][:, ::2].sum(axis=1)) for name in positions if name in found]
    return any(bool(shift > LASTING) for shift in shifts)


def promise_less(problem: Problem, vector: Array) -> bool:
    """Whether segments tell of other parameters than those of a fit of whole recordings.

    Where the machine nearly integrates and more than noise is left: whether the error of segments
    falls far more with parameters than with the initial states alone, along the derivatives.
    """
    if any(part.static for part in problem.measurements):
        return False
    segments = in_segments(problem, COUNTS[0])
    if len(segments.measurements) == len(problem.measurements):
        return False
    with suppress(SimulationError):
        if problem.mean_square(vector) > MUCH and nearly_integrates(problem, vector):
            start = segments.start(problem.model_with_recordings(vector))
            floors = tuple(map(noise_floors, segments.measurements))
            errors = stack(segments.errors(start), floors)
            slopes = segments.data_jacobian(start, floors)
            states = slopes[:, len(problem.coordinates.paths) :]
            return _left(states, errors) > PROMISING * _left(slopes, errors)
    return False


def _cut(measurement: Measurement, count: int) -> list[Measurement]:
    """Segments of a recording, with the noise of the whole."""
    if count < 2 or len(measurement.time) < FEWEST * count:
        return [measurement]
    ends = np.linspace(0, len(measurement.time), count + 1).astype(int).tolist()
    pieces = [measurement.samples(slice(*pair)) for pair in pairwise(ends)]
    for piece in pieces:  # few samples show it badly, and to look for it takes longest of all
        vars(piece)["noise"] = measurement.noise
    return pieces


def _duration(measurement: Measurement) -> float:
    return float(measurement.time[-1] - measurement.time[0])


def _left(slopes: Array, errors: Array) -> float:
    """Sum of squares of errors (N,) that their derivatives (N, k) cannot take away."""
    return float(np.sum((errors - slopes @ np.linalg.lstsq(slopes, errors)[0]) ** 2))
