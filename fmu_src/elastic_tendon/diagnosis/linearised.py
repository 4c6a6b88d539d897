"""The errors of a fitted model, and what its own free numbers could still make of them.

A change of the errors that the free numbers, or an initial state, can imitate says nothing about
a missing effect. It is projected out, with the prior's share, before anything is scored.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from elastic_tendon.identify.fit import FitResult
from elastic_tendon.identify.problem import Sigmas
from elastic_tendon.identify.residuals import Array, autocorrelation_time, noise_floors, rms

# directions weaker than this share of the strongest are rounding
ROUNDING = 1e-10
BLOCKS_WANTED = 24  # fewer say little of how the blocks scatter
SHORTEST_BLOCK = 0.5  # s
FEWEST_SAMPLES = 10  # in a block
BLOCK_TIMES = 4.0  # autocorrelation times in a block, so that neighbours hardly hang together


@dataclass(frozen=True)
class Linearised:
    """Whitened errors of N samples with m prior residuals below them, and nuisance directions.

    `errors` (N + m,) with what the nuisances explain taken away; `nuisance` (N + m, r) an
    orthonormal basis; `samples` N; `sigmas` by which signals were divided.
    """

    errors: Array
    nuisance: Array
    samples: int
    sigmas: Sigmas

    @classmethod
    def of(cls, result: FitResult) -> Self:
        """At the optimum of a fit, each signal in units of its own RMS error or its noise.

        Raises
        ------
        SimulationError : the solver could not go on
        """
        sigmas = plain_sigmas(result)
        jacobian = result.problem.jacobian(result.vector, sigmas)
        errors = result.problem.residuals(result.vector, sigmas)
        basis = orthonormal(jacobian)
        samples = len(errors) - len(result.problem.coordinates.paths)
        return cls(errors - basis @ (basis.T @ errors), basis, samples, sigmas)

    def remaining(self, columns: Array) -> Array:
        """Part (N + m, k) of changes of the errors (N, k) that the nuisances cannot imitate."""
        padded = np.zeros((len(self.errors), columns.shape[1]))
        padded[: self.samples] = columns
        return padded - self.nuisance @ (self.nuisance.T @ padded)


def plain_sigmas(result: FitResult) -> Sigmas:
    """RMS error of each signal, never less than its noise."""
    problem = result.problem
    return tuple(
        {name: max(rms(values), floors[name]) for name, values in errors.items()}
        for errors, floors in zip(
            problem.errors(result.vector), map(noise_floors, problem.measurements), strict=True
        )
    )


def orthonormal(columns: Array) -> Array:
    """Orthonormal basis (N, r) of columns (N, m) of any scale."""
    norms = np.linalg.norm(columns, axis=0)
    scaled = columns[:, norms > 0.0] / norms[norms > 0.0]
    if scaled.shape[1] == 0:
        return np.asarray(scaled)
    basis, singular, _ = np.linalg.svd(scaled, full_matrices=False)
    return np.asarray(basis[:, singular > ROUNDING * singular[0]])


def effective_count(errors: Sequence[Mapping[str, Array]]) -> float:
    """Number of independent facts in the errors of several recordings and signals."""
    return sum(
        len(values) / autocorrelation_time(values) for part in errors for values in part.values()
    )


def block_numbers(result: FitResult, errors: Sequence[Mapping[str, Array]]) -> NDArray[np.int_]:
    """Number of the stretch of time to which each of the N stacked samples belongs.

    Signals of one recording share their stretches, as one disturbance shows in all. A stretch is
    several autocorrelation times of the errors long.
    """
    measurements = result.problem.measurements
    # what a stretch of samples covers; rows of a static curve have no time that means anything
    total = sum(len(one.time) for one in measurements)
    numbers: list[NDArray[np.int_]] = []
    first = 0
    for one, part in zip(measurements, errors, strict=True):
        step = (one.time[-1] - one.time[0]) / (len(one.time) - 1)
        shortest = FEWEST_SAMPLES if one.static else max(FEWEST_SAMPLES, SHORTEST_BLOCK / step)
        memory = max(autocorrelation_time(values) for values in part.values())
        wanted = BLOCKS_WANTED * len(one.time) / total
        length = max(shortest, BLOCK_TIMES * memory)
        count = int(np.clip(len(one.time) / length, 1, max(wanted, 1)))
        own = first + (np.arange(len(one.time)) * count) // len(one.time)
        numbers += [own] * len(part)
        first += count
    return np.concatenate(numbers).astype(np.int_)
