"""A model with effects added, fitted; and how answers compare."""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from math import log

import numpy as np

from elastic_tendon import effects
from elastic_tendon.diagnosis.candidates import sensible
from elastic_tendon.errors import ModelError
from elastic_tendon.identify.fit import THOROUGH, Effort, FitResult, Progress, fit
from elastic_tendon.identify.ladder import LEAST_SHARE_OF_NOISE
from elastic_tendon.identify.residuals import Array, noise_floors, stack
from elastic_tendon.identify.stretches import independent_facts
from elastic_tendon.measurement import Measurement
from elastic_tendon.parameters import Model, typical_value

UNDECIDED = 10.0  # difference of BIC below which data do not decide (Kass & Raftery 1995)
# of what a score test expects; where effects are strong it expects too little or too much
EXPECTED_SHARES = (1.0, 0.3, 1.7, 2.5)


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
        return sum(len(effects.BY_ID[one].parameters) for one in self.added)

    @cached_property
    def floored(self) -> Array:
        """Errors (N,) in units of their noise."""
        floors = tuple(noise_floors(one) for one in self.result.problem.measurements)
        return stack(self.errors, floors)

    @cached_property
    def implausibility(self) -> float:
        """Sum of squares by which numbers of the given model left their prior, in its sigmas."""
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
    progress: Progress = lambda _share: None,
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
    SimulationError : not even the nulls can be simulated
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
    return Answer(tuple(added), result)


def with_nulls(model: Model, added: Sequence[str]) -> Model:
    """The model with effects that do nothing yet."""
    for effect_id in added:
        model = model.with_effect(effect_id, None)
    return model


def starts_of(
    origins: Sequence[Model], effect_id: str, expected: Mapping[str, float]
) -> list[Model]:
    """Models with one more effect from which a fit may start: as expected, weaker, and typical."""
    effect = effects.BY_ID[effect_id]
    models: list[Model] = []
    for origin in origins:
        for share in EXPECTED_SHARES:
            values = {
                one.name: expected[one.name]
                if one.shape
                else one.null + share * (expected[one.name] - one.null)
                for one in effect.parameters
            }
            with suppress(ModelError):  # numbers that do not go together
                models.append(bounded(origin, effect_id, values))
        typical = {
            one.name: expected[one.name] if one.shape else typical_value(origin, one)
            for one in effect.parameters
        }
        with suppress(ModelError):
            models.append(bounded(origin, effect_id, typical))
    return models


def bounded(model: Model, effect_id: str, values: Mapping[str, float]) -> Model:
    """The model with an effect of these numbers, or the nearest that it may have.

    Raises
    ------
    ModelError : the model cannot take the effect, or the numbers do not go together
    """
    inside = {
        one.name: min(max(values[one.name], one.lower), one.upper)
        for one in effects.BY_ID[effect_id].parameters
    }
    return model.with_effect(effect_id, inside)


def bics(answers: Sequence[Answer]) -> list[float]:
    """Bayesian information criterion of answers to the same data; lower is better.

    ``N_eff log(mean square) + prior + parameters log(N_eff)``. How many independent facts N_eff
    the data hold for the question that the answers differ in is judged by the closest of them.
    Numbers of the given model cost what the prior says; those of effects one parameter each.

    Parameters
    ----------
    answers : Answer of the same measurements, the one they start from first

    Returns
    -------
    list of float, one for each
    """
    closest = min(answers, key=lambda one: float(one.floored @ one.floored))
    facts = facts_between(answers[0], closest)
    return [
        facts * log(_mean_square(one)) + one.implausibility + one.complexity * log(facts)
        for one in answers
    ]


def facts_between(before: Answer, after: Answer) -> float:
    """Number of independent facts that the errors hold about the change from one answer to another.

    What decides between them is the product of this change and the errors that are left; samples
    in which it hangs together count as one. But no longer than the joint takes to settle: what
    hangs together longer was not stirred up by chance, it is the lack of fit itself.

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


def _mean_square(answer: Answer) -> float:
    """Of the errors in units of their noise, which simulated recordings can be far below."""
    return max(float(np.mean(answer.floored**2)), LEAST_SHARE_OF_NOISE**2)
