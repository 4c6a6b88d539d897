"""A model with effects added, fitted."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from elastic_tendon import effects
from elastic_tendon.actuator.parameters import Model
from elastic_tendon.comparison.residuals import Array, noise_floors, stack
from elastic_tendon.diagnosis.candidates import sensible
from elastic_tendon.estimation.fit import THOROUGH, Effort, FitResult, ShareProgress, fit
from elastic_tendon.estimation.stretches import independent_facts
from elastic_tendon.measurement import Measurement


@dataclass(frozen=True)
class Answer:
    """The given model with effects `added`, fitted to the data."""

    added: tuple[str, ...]
    result: FitResult

    @cached_property
    def errors(self) -> list[dict[str, Array]]:
        """For each recording, signal -> (n,) simulated less measured, the signal's unit."""
        return self.result.problem.errors(self.result.vector)

    @property
    def complexity(self) -> int:
        """Number of parameters that came in with the effects."""
        starts = tuple(f"effects.{effect_id}." for effect_id in self.added)
        return sum(path.startswith(starts) for path in self.result.problem.coordinates.paths)

    @cached_property
    def floored(self) -> Array:
        """Errors (N,) in units of their noise."""
        return stack(self.errors, tuple(map(noise_floors, self.result.problem.measurements)))

    @cached_property
    def mean_square(self) -> float:
        """Mean square error in units of the noise's."""
        return float(np.mean(self.floored**2))

    @cached_property
    def implausibility(self) -> float:
        """Sum of squares by which parameters of the given model left their prior, in its sigmas."""
        problem = self.result.problem
        coordinates = problem.coordinates
        shift = coordinates.values(problem.numbers(self.result.vector)) - coordinates.centre
        own = [not path.startswith("effects.") for path in coordinates.paths]
        return float(np.sum((shift / coordinates.sigma)[own] ** 2))

    def values(self, effect_id: str) -> Mapping[str, float]:
        """Fitted parameters of one of its effects, by name."""
        return self.result.model.effects[effect_id]


def refit(
    given: Model,
    added: Sequence[str],
    measurements: Sequence[Measurement],
    starts: Sequence[Model] = (),
    effort: Effort = THOROUGH,
    progress: ShareProgress = lambda _share: None,
) -> Answer:
    """Fit the given model with some effects, from its nulls and from other models.

    Parameters
    ----------
    given : Model; centre of the prior
    added : ids of the effects
    measurements : fitted together
    starts : models with the same effects
    effort : how long to search
    progress : called with the share of the work done, 0 to 1

    Returns
    -------
    Answer; never worse, in cost, than any start

    Raises
    ------
    SimulationError : not even the nulls can be simulated, or the motion found is unstable
    """
    start = with_nulls(given, added)
    result = fit(
        start,
        measurements,
        starts=starts,
        limits=sensible(start, added, measurements),
        effort=effort,
        progress=progress,
    )
    _ = result.derivatives  # all that follows needs them: without them there is no answer
    return Answer(tuple(added), result)


def with_nulls(model: Model, added: Sequence[str]) -> Model:
    """The model with effects that do nothing yet."""
    for effect_id in added:
        model = model.with_effect(effect_id, None)
    return model


def bounded(model: Model, effect_id: str, values: Mapping[str, float]) -> Model:
    """The model with an effect of these values, or the nearest that it may have.

    Raises
    ------
    ModelError : the model cannot take the effect, or the values do not go together
    """
    inside = {
        parameter.name: min(max(values[parameter.name], parameter.lower), parameter.upper)
        for parameter in effects.BY_ID[effect_id].parameters
    }
    return model.with_effect(effect_id, inside)


def facts_between(before: Answer, after: Answer) -> float:
    """Number of independent samples that tell the change from one answer to another.

    What decides between them is the product of this change and the errors that are left; its
    samples within the autocorrelation time count as one, see `independent_facts`.

    Parameters
    ----------
    before, after : Answer of the same measurements

    Returns
    -------
    float, at least 2
    """
    change = before.floored - after.floored
    if not change.any():
        return float(max(len(change), 2))
    result = after.result
    products = change * after.floored
    return max(independent_facts(result.model, result.problem.measurements, products), 2.0)
