"""Where an effect that swings may hide: a light mass that is hardly damped rings for long.

Its frequency has to be right to half a percent, and the more of it there is the farther the other
parameters are from where they were found without it. So these follow it first, damped well, from
little of it to much; around each of these places its frequency is scanned finely.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from elastic_tendon import effects
from elastic_tendon.diagnosis.answer import Answer, refit_rest
from elastic_tendon.diagnosis.candidates import is_damping, starts
from elastic_tendon.diagnosis.sets import model_with
from elastic_tendon.diagnosis.trajectory_screen import TrajectoryScreen
from elastic_tendon.effects.base import Effect
from elastic_tendon.errors import ElasticTendonError
from elastic_tendon.identify.coordinates import SPRINGS
from elastic_tendon.identify.fit import Effort
from elastic_tendon.identify.work import enough
from elastic_tendon.measurement import Measurement
from elastic_tendon.parameters import Model

SHARES = (0.1, 0.2, 0.35, 0.6, 1.0, 1.6, 2.5, 4.0)  # of the typical strength
WORSE = 2.0  # times the least mean square, from which more of the effect is too much
PLACES = 2  # of these, the best first, that are scanned with all dampings
# steps of the logarithm of what sets the frequency, and how far they lead from a place, and from a
# refit, which may be in a wrong minimum
STEP, NEAR, WIDE = 0.01, 0.27, 0.75
DAMPINGS, LIKELIEST = (0.1, 0.25, 0.6), 0.25  # times the typical one
FOLLOWED, KEPT = 6, 4  # minima of a scan that are followed, and refitted
# times the value of a refit, at which a minimum beside its own may lie that is too near for a scan
NEXT = (0.98, 0.985, 0.99, 0.995, 1.005, 1.01, 1.015, 1.02)
FOLLOWING = Effort(scouted=1, scouting=4, polished=0, evaluations=1, rounds=0, tolerance=1e-2)


def swings(effect_id: str) -> bool:
    """Whether an effect has a parameter that sets a frequency."""
    return any(one.resonant for one in effects.BY_ID[effect_id].parameters)


@dataclass(frozen=True)
class Resonance:
    """An effect that swings, beside others `added` to a given model, in some recordings.

    `check` is called before each simulation; it may end the work.
    """

    given: Model
    added: tuple[str, ...]
    effect_id: str
    measurements: Sequence[Measurement]
    check: Callable[[float], None]

    def beside(self, answer: Answer) -> list[Answer]:
        """Some of the effect beside a refit without it, the most promising first."""
        dampings = self._spring_dampings()
        held = [*self._paths(), *dampings]
        places: list[Answer] = []
        model = answer.result.model
        for values in starts(model, self._effect, self.measurements, SHARES, (1.0,)):
            own = {f"effects.{self.effect_id}.{name}": value for name, value in values.items()}
            start = model_with(self.given, self.added, {**model.values(), **dampings, **own})
            places += self._followed([start], held)
            if not places:
                return []
            model = places[-1].result.model
            if places[-1].mean_square > WORSE * min(one.mean_square for one in places):
                break
        found = []
        for rank, place in enumerate(sorted(places, key=lambda one: one.mean_square)):
            found += self._scanned(place, DAMPINGS if rank < PLACES else (LIKELIEST,), NEAR)
        best = self._best(_least(found), [*self._paths(only_resonant=True), *dampings])
        return [*best, min(places, key=lambda one: one.mean_square)]

    def around(self, answer: Answer) -> list[Answer]:
        """The effect at other frequencies near those of a refit, the most promising first."""
        held = self._paths(only_resonant=True)
        own = answer.result.model
        models = [
            own.with_values({path: own.values()[path] * times for path in held}) for times in NEXT
        ]
        for place in self._followed([own], held):
            models += _least(self._scanned(place, (1.0,), WIDE))
        return self._best(models, held)

    def _best(self, models: Sequence[Model], held: Sequence[str]) -> list[Answer]:
        return sorted(self._followed(models, held), key=lambda one: one.mean_square)[:KEPT]

    def _scanned(
        self, place: Answer, dampings: Sequence[float], reach: float
    ) -> list[tuple[float, Model]]:
        """Minima of the mean square over the frequency, all else following to first order."""
        screen, own = TrajectoryScreen(place), place.result.model
        minima: list[tuple[float, Model]] = []
        for damping in dampings:
            models = list(self._along(own, damping, reach))
            left = []
            for model in models:
                self.check(0.0)
                if enough():
                    return minima
                left.append(place.mean_square * screen.beside(model))
            around = np.concatenate([[np.inf], left, [np.inf]])
            least = (around[1:-1] < around[:-2]) & (around[1:-1] <= around[2:])
            minima += [(left[index], models[index]) for index in np.flatnonzero(least)]
        return minima

    def _along(self, model: Model, damping: float, reach: float) -> Iterator[Model]:
        values = model.values()
        for share in np.exp(np.arange(-reach, reach, STEP)):
            yield model.with_values(
                {
                    path: values[path] * share * (damping if is_damping(one) else 1.0)
                    for path, one in zip(self._paths(), self._effect.parameters, strict=True)
                }
            )

    def _followed(self, models: Sequence[Model], held: Sequence[str]) -> list[Answer]:
        """All else refitted, where that can be simulated."""
        found = []
        for model in models:
            if enough():
                break
            try:
                found.append(
                    refit_rest(
                        self.given,
                        self.added,
                        self.measurements,
                        model,
                        held,
                        FOLLOWING,
                        self.check,
                    )
                )
            except ElasticTendonError:
                continue
        return found

    @property
    def _effect(self) -> Effect:
        return effects.BY_ID[self.effect_id]

    def _paths(self, *, only_resonant: bool = False) -> list[str]:
        return [
            f"effects.{self.effect_id}.{one.name}"
            for one in self._effect.parameters
            if one.resonant or not only_resonant
        ]

    def _spring_dampings(self) -> dict[str, float]:
        """As given: without the effect they were driven to where it would not ring."""
        values = self.given.values()
        return {path: values[path] for path in (f"{spring}.damping" for spring in SPRINGS)}


def _least(found: list[tuple[float, Model]]) -> list[Model]:
    return [model for _, model in sorted(found, key=lambda pair: pair[0])[:FOLLOWED]]
