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
NOTHING = 1e-10  # part of what the largest direction of initial states makes


@dataclass(frozen=True)
class Rows:
    """Errors and derivatives of f recordings, divided by sigma.

    `names` of all signals; `counts` (f,) blocks of each recording. For each recording, by signal:
    `sigmas`, `errors` (n,), `derivatives` (n, p) to the fitted parameters and initial states.
    `prior` (p, p) is their precision before the data. A recording of one block tells its initial
    state alone: what that can make, the span of its `beginnings` (rows of all signals, s), is taken
    out of its rows instead (Frisch & Waugh, Econometrica 1, 1933).
    """

    motions: tuple[Motion, ...]
    names: tuple[str, ...]
    counts: Integers
    sigmas: tuple[Mapping[str, float], ...]
    errors: tuple[Mapping[str, Array], ...]
    derivatives: tuple[Mapping[str, Array], ...]
    beginnings: tuple[Array, ...]
    prior: Array

    def columns(self, index: int, term: Term) -> dict[str, Array]:
        """Derivatives and what a term's k columns do to the error, by signal, (n, p + k)."""
        motion = self.motions[index]
        moved = slopes_beyond_rounding(
            responses(motion, term.acts, term.columns(motion)), motion.errors, motion.measurement
        )
        scaled = {name: moved[name] / self.sigmas[index][name] for name in motion.errors}
        further = _without(self.beginnings[index], scaled)
        return {
            name: np.hstack([own, further[name]]) for name, own in self.derivatives[index].items()
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
    problem, sigmas, jacobian = result.problem, result.sigmas, result.derivatives
    count, states = len(problem.coordinates.paths), problem.states
    counts = _counts([len(motion.time) for motion in motions])
    own = [
        slice(count + states * index, count + states * (index + 1)) for index in range(len(counts))
    ]
    shared = np.ones(jacobian.shape[1], dtype=bool)
    for columns, number in zip(own, counts, strict=True):
        shared[columns] = number > 1
    first, errors, derivatives, beginnings = 0, [], [], []
    for index, motion in enumerate(motions):
        last = first + sum(map(len, motion.errors.values()))
        rows, first = jacobian[first:last], last
        beginning = (
            _spanned(rows[:, own[index]]) if counts[index] == 1 else np.zeros((len(rows), 0))
        )
        beyond = beyond_rounding(motion.errors, motion.measurement)
        scaled = {name: error / sigmas[index][name] for name, error in beyond.items()}
        ends = np.cumsum([len(error) for error in scaled.values()])[:-1]
        slopes = dict(zip(scaled, np.split(rows[:, shared], ends), strict=True))
        errors.append(_without(beginning, scaled))
        derivatives.append(_without(beginning, slopes))
        beginnings.append(beginning)
    held = jacobian[first:, shared]
    return Rows(
        motions=tuple(motions),
        names=tuple(dict.fromkeys(name for motion in motions for name in motion.errors)),
        counts=counts,
        sigmas=sigmas,
        errors=tuple(errors),
        derivatives=tuple(derivatives),
        beginnings=tuple(beginnings),
        prior=held.T @ held,
    )


def _spanned(columns: Array) -> Array:
    """Orthonormal columns that make the same."""
    directions, sizes, _ = np.linalg.svd(columns, full_matrices=False)
    return np.asarray(directions[:, sizes > NOTHING * max(sizes, default=0.0)])


def _without(beginning: Array, by_signal: Mapping[str, Array]) -> Mapping[str, Array]:
    """Rows less what the initial state can make of them."""
    if not beginning.shape[1]:
        return by_signal
    rows = np.concatenate(list(by_signal.values()))
    ends = np.cumsum([len(part) for part in by_signal.values()])[:-1]
    left = rows - beginning @ (beginning.T @ rows)
    return dict(zip(by_signal, np.split(left, ends), strict=True))


def _counts(lengths: Sequence[int]) -> Integers:
    """Number of blocks of recordings of so many samples."""
    number = np.minimum(MOST * np.array(lengths) / np.sum(lengths), np.array(lengths) / SMALLEST)
    return np.asarray(np.maximum(np.round(number), 1.0), dtype=np.int_)
