"""One more effect beside a refitted answer, scored along the whole trajectory.

What the effect changes is simulated at a few starts; parameters, initial states and its strength
follow to first order. It sees what torques along the measured motion do not show, such as the
swinging of a spring's own mass, and costs a simulation a start.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from operator import itemgetter

import numpy as np

from elastic_tendon.actuator.parameters import Model
from elastic_tendon.comparison.residuals import (
    Array,
    beyond_rounding,
    residuals_of,
    simulate_measurement,
    stack,
)
from elastic_tendon.diagnosis.answer import Answer, with_nulls
from elastic_tendon.diagnosis.sets import Set
from elastic_tendon.errors import ElasticTendonError
from elastic_tendon.estimation.problem import TOLERANCE
from elastic_tendon.measurement import Measurement
from elastic_tendon.simulation.work import enough

ROUNDING = 1e-10  # sum of squares, in sigmas, that is no change
ALIKE = 1e-6  # of two changes, whose squared sine is smaller
MOST_FAILURES = 3  # simulations, after which no further one would come to an end either


class TrajectoryScreen:
    """An answer with its derivatives, to score what may come in beside it.

    `nulls` : effects that are simulated too, at their nulls, so that models with any of them share
    a library.
    """

    def __init__(self, answer: Answer, nulls: Set = ()) -> None:
        self.nulls = nulls
        result = answer.result
        self._result = result
        jacobian = result.derivatives
        residuals = result.problem.residuals(result.vector, result.sigmas)
        self._count = len(residuals) - len(result.problem.coordinates.paths)  # no prior
        self._residuals = residuals
        own = residuals[: self._count]
        self._before = float(own @ own)
        scale = np.linalg.norm(jacobian, axis=0)
        # what is at a bound does not follow: it might have to go beyond it
        free = result.problem.off_bounds(result.vector) & (scale > 0.0)
        self._directions = np.linalg.qr(jacobian[:, free] / scale[free])[0]

    def best(
        self, models: Iterable[Model], check: Callable[[float], None]
    ) -> list[tuple[float, Model]]:
        """Models with one more effect, the most promising first.

        Parameters
        ----------
        models : with the parameters of the answer, and some of the effect
        check : called before each simulation; may end the work

        Returns
        -------
        share of the answer's mean square that would be left, 0 to 1, and the model
        """
        found: list[tuple[float, Model]] = []
        failures = 0
        for model in models:
            check(0.0)
            left = self.left(model)
            found.append((1.0 if left is None else float(left @ left) / self._before, model))
            failures += left is None
            if failures == MOST_FAILURES or enough():
                break
        return sorted(found, key=itemgetter(0))

    def beside(self, models: Iterable[Model]) -> list[tuple[float, Model]]:
        """Models with other parameters of the answer's own effects, the most promising first.

        Each is taken as it is, not as far as it lies in the right direction: the way to it may lead
        over a hill.

        Returns
        -------
        share of the answer's mean square that is left once all else has followed, and the model
        """
        found: list[tuple[float, Model]] = []
        for model in models:
            change = self.changed(model)
            if change is not None and np.isfinite(change).all():
                left = self._across(self._residuals + change)[: self._count]
                found.append((float(left @ left) / self._before, model))
            if enough():
                break
        return sorted(found, key=itemgetter(0))

    def together(self, changes: Sequence[Array]) -> tuple[Array, Array]:
        """Each two of some changes (N,), once all else has followed.

        Returns
        -------
        share of the mean square that is left, (k, k): 1 where one of them would come in with the
        other sign, on the diagonal what is left with one alone; and how many times the first of
        each two comes in, (k, k)
        """
        across = np.array([self._across(change) for change in changes])
        left = self._across(self._residuals)
        gram, along, before = across @ across.T, -across @ left, left @ left
        own = np.diag(gram)
        area = np.outer(own, own) - gram**2
        with np.errstate(divide="ignore", invalid="ignore"):  # alike, or nothing new
            times = (np.outer(along, own) - along * gram) / area
            falls = times * along[:, np.newaxis]
            both = (times > 0.0) & (times.T > 0.0) & (area > ALIKE * np.outer(own, own))
            shares = np.where(both, 1.0 - (falls + falls.T) / before, 1.0)
        alone = np.maximum(along, 0.0) ** 2 / np.maximum(own, ROUNDING) / before
        np.fill_diagonal(shares, 1.0 - alone)
        return shares, times

    def as_it_is(self, model: Model) -> float:
        """Times the mean square that a model leaves of which nothing follows; infinite where it
        cannot be simulated."""
        change = self.changed(model)
        if change is None:
            return np.inf
        left = (self._residuals + change)[: self._count]
        return float(left @ left) / self._before

    def with_recordings(self, measurements: Sequence[Measurement]) -> float:
        """Share of the mean square that is left with recordings which differ in their inputs, once
        parameters and initial states have followed; infinite where they cannot be simulated."""
        result = self._result
        problem = replace(result.problem, measurements=tuple(measurements))
        try:
            errors = problem.residuals(result.vector, result.sigmas)
        except ElasticTendonError:
            return np.inf
        left = self._across(errors)[: self._count]
        return float(left @ left) / self._before

    def told(self, model: Model) -> float:
        """What the errors tell of a model with one more effect: how much it changes, squared and
        in sigmas, that all else could not follow; 0 where it cannot be simulated."""
        change = self.changed(model)
        if change is None or not np.isfinite(change).all():
            return 0.0
        across = self._across(change)
        return float(across @ across)

    def changed(self, model: Model) -> Array | None:
        """Residuals of a model less those of the answer, (N,), None where the simulation fails."""
        result = self._result
        model = with_nulls(model, [added for added in self.nulls if added not in model.effects])
        try:
            errors = [
                beyond_rounding(
                    residuals_of(simulate_measurement(model, part, initial, TOLERANCE), part), part
                )
                for part, initial in zip(
                    result.problem.measurements, result.initial_states, strict=True
                )
            ]
        except ElasticTendonError:
            return None
        change = np.zeros(len(self._residuals))
        change[: self._count] = stack(errors, result.sigmas) - self._residuals[: self._count]
        return change

    def left(self, model: Model) -> Array | None:
        """Errors (N,) that would be left with a model, in sigmas: those of the answer where it does
        no better, None where it cannot be simulated."""
        own, change = self._residuals[: self._count], self.changed(model)
        if change is None:
            return None
        if not np.isfinite(change).all():
            return own
        before, across = self._across(self._residuals), self._across(change)
        square = float(across @ across)
        along = float(across @ before)
        if square <= ROUNDING or along >= 0.0:  # nothing new, or only with the other sign
            return own
        return np.asarray((before - along / square * across)[: self._count])

    def _across(self, values: Array) -> Array:
        """What parameters and initial states cannot follow."""
        return np.asarray(values - self._directions @ (self._directions.T @ values))
