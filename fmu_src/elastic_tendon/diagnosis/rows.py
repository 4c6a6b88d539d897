"""The whitened errors of all recordings, row by row, and their sums over blocks."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from elastic_tendon.comparison.partition import Integers
from elastic_tendon.comparison.residuals import Array, beyond_rounding, slopes_beyond_rounding
from elastic_tendon.diagnosis.block_test import Products
from elastic_tendon.diagnosis.columns import Term, responses
from elastic_tendon.diagnosis.motion import Motion
from elastic_tendon.estimation.fit import FitResult

# blocks of all recordings together: more say no more, fewer say nothing
MOST, FEWEST = 40, 10
SMALLEST = 3  # samples in a block
# a block is so many times as long as the error's autocorrelation time
MEMORIES = 10.0


@dataclass(frozen=True)
class Rows:
    """Errors and derivatives of f recordings, divided by sigma.

    `names` of all signals; `counts` (f,) blocks of each recording. For each recording, by signal:
    `sigmas`, `errors` (n,), `derivatives` (n, p) to the fitted parameters and initial states.
    `prior` (p, p) is their precision before the data.
    """

    motions: tuple[Motion, ...]
    names: tuple[str, ...]
    counts: Integers
    sigmas: tuple[Mapping[str, float], ...]
    errors: tuple[Mapping[str, Array], ...]
    derivatives: tuple[Mapping[str, Array], ...]
    prior: Array

    def columns(self, index: int, term: Term) -> dict[str, Array]:
        """Derivatives and what a term's k columns do to the error, by signal, (n, p + k)."""
        motion = self.motions[index]
        moved = slopes_beyond_rounding(
            responses(motion, term.acts, term.columns(motion)), motion.errors, motion.measurement
        )
        return {
            name: np.hstack([own, moved[name] / self.sigmas[index][name]])
            for name, own in self.derivatives[index].items()
        }

    def _edges(self, index: int) -> list[int]:
        """Where the blocks of a recording begin and end, in samples."""
        samples = len(self.motions[index].time)
        edges: list[int] = np.linspace(0, samples, self.counts[index] + 1).astype(int).tolist()
        return edges

    def left_by(self, term: Term, weights: Array) -> list[dict[str, Array]]:
        """Errors of each recording, less what a term and the fitted parameters make of them.

        Parameters
        ----------
        term : Term of k columns
        weights : (b, p + k), one row for each block
        """
        found, first = [], 0
        for index, errors in enumerate(self.errors):
            edges = self._edges(index)
            by_sample = np.repeat(weights[first : first + len(edges) - 1], np.diff(edges), axis=0)
            first += len(edges) - 1
            columns = self.columns(index, term)
            found.append(
                {
                    name: error - np.einsum("ij,ij->i", columns[name], by_sample)
                    for name, error in errors.items()
                }
            )
        return found

    def products(self, term: Term) -> Products:
        """Sums of products over the blocks of all recordings."""
        grams, scores, squares = [], [], []
        for index in range(len(self.motions)):
            columns, errors = self.columns(index, term), self.errors[index]
            for start, end in pairwise(self._edges(index)):
                # a signal that this recording does not hold has no rows
                rows = [slice(start, end if name in errors else start) for name in self.names]
                held = [name if name in errors else next(iter(errors)) for name in self.names]
                parts = [
                    (columns[name][row], errors[name][row])
                    for name, row in zip(held, rows, strict=True)
                ]
                grams.append([part.T @ part for part, _ in parts])
                scores.append([part.T @ error for part, error in parts])
                squares.append([error @ error for _, error in parts])
        return Products(np.array(grams), np.array(scores), np.array(squares), self.prior)

    def longer_blocks(self, memory: float) -> Integers:
        """First of the blocks that are taken together so that neighbours are uncorrelated.

        Parameters
        ----------
        memory : autocorrelation time of the error, samples
        """
        samples = sum(len(motion.time) for motion in self.motions)
        return self.merged_to(max(samples / (MEMORIES * memory), FEWEST))

    def merged_to(self, wanted: float) -> Integers:
        """First of the blocks that are taken together to make so many, or all that there are."""
        lengths = np.array([len(motion.time) for motion in self.motions])
        shares = wanted * lengths / np.sum(lengths)
        firsts: list[Integers] = []
        first = 0
        for share, count in zip(shares, self.counts, strict=True):
            number = min(max(1, round(share)), count)
            firsts.append(first + (np.arange(number) * count) // number)
            first += count
        return np.concatenate(firsts)


def rows_of(result: FitResult, motions: Sequence[Motion]) -> Rows:
    """Rows at the optimum of a fit; `motions` of its recordings."""
    problem, sigmas = result.problem, result.sigmas
    jacobian = result.derivatives
    held = jacobian[len(jacobian) - len(problem.coordinates.paths) :]
    first, errors, derivatives = 0, [], []
    for motion, own in zip(motions, sigmas, strict=True):
        by_name = {}
        for name, error in motion.errors.items():
            by_name[name] = jacobian[first : first + len(error)]
            first += len(error)
        derivatives.append(by_name)
        beyond = beyond_rounding(motion.errors, motion.measurement)
        errors.append({name: error / own[name] for name, error in beyond.items()})
    return Rows(
        motions=tuple(motions),
        names=tuple(dict.fromkeys(name for motion in motions for name in motion.errors)),
        counts=_counts([len(motion.time) for motion in motions]),
        sigmas=sigmas,
        errors=tuple(errors),
        derivatives=tuple(derivatives),
        prior=held.T @ held,
    )


def _counts(lengths: Sequence[int]) -> Integers:
    """Number of blocks of recordings of so many samples."""
    number = np.minimum(MOST * np.array(lengths) / np.sum(lengths), np.array(lengths) / SMALLEST)
    return np.asarray(np.maximum(np.round(number), 1.0), dtype=np.int_)
