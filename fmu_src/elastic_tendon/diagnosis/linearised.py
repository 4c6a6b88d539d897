"""The errors of a fitted model, and what its own free numbers could still make of them.

A change of the errors that the free numbers, or an initial state, can imitate says nothing about
a missing effect. It is projected out, with the prior's share, before anything is scored.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from elastic_tendon.identify.fit import FitResult
from elastic_tendon.identify.problem import Sigmas
from elastic_tendon.identify.residuals import Array, noise_floors, rms

# directions weaker than this share of the strongest are rounding
ROUNDING = 1e-10


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
