"""Where an effect that swings may hide: a light mass that is hardly damped rings for long.

Over a whole recording its frequency has to be right to half a percent, or the fit ends in a wrong
minimum. Over the beginning of it a rough one will do. So many frequencies are refitted to a short
beginning, the best of them to a longer one, and so on to the whole.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from operator import attrgetter

import numpy as np

from elastic_tendon import effects
from elastic_tendon.actuator.parameters import Model
from elastic_tendon.diagnosis.answer import Answer, refit
from elastic_tendon.diagnosis.candidates import starts
from elastic_tendon.diagnosis.sets import model_with
from elastic_tendon.errors import ElasticTendonError
from elastic_tendon.estimation.coordinates import SPRINGS
from elastic_tendon.estimation.fit import Effort
from elastic_tendon.measurement import Measurement
from elastic_tendon.simulation.work import enough

SHARES = tuple(np.geomspace(0.1, 4.0, 15))  # of the typical strength
DAMPING = 0.25  # times the typical one
# share of a recording that is refitted, and how many of the best are refitted to the next
STAGES = ((0.125, 8), (0.2, 4), (0.35, 4), (0.6, 2), (1.0, 4))
WORSE = 4.0  # times the least mean square, from which no refit goes on
BESIDE = (1.0, 0.975, 1.025)  # times what sets the frequency, where the next refits begin
AROUND = tuple(np.geomspace(0.5, 2.0, 15))  # likewise, around a refit
REFITTING = Effort(scouted=1, scouting=10, polished=0, evaluations=1, rounds=0, tolerance=1e-3)


def swings(effect_id: str) -> bool:
    """Whether an effect has a parameter that sets a frequency."""
    return any(parameter.resonant for parameter in effects.BY_ID[effect_id].parameters)


@dataclass(frozen=True)
class Resonance:
    """An effect that swings, beside others `added` to a given model, in some recordings.

    `check` is called before each refit; it may end the work.
    """

    given: Model
    added: tuple[str, ...]
    effect_id: str
    measurements: Sequence[Measurement]
    check: Callable[[float], None]

    def beside(self, answer: Answer) -> list[Answer]:
        """Some of the effect beside a refit without it, the most promising first."""
        given, found = self.given.values(), answer.result.model.values()
        # without the effect they were driven to where it would not ring
        dampings = {path: given[path] for path in (f"{spring}.damping" for spring in SPRINGS)}
        effect = effects.BY_ID[self.effect_id]
        models = [
            model_with(
                self.given,
                self.added,
                found
                | own
                | {f"effects.{self.effect_id}.{name}": value for name, value in start.items()},
            )
            for own in (given, dampings)
            for start in starts(self.given, effect, self.measurements, SHARES, (DAMPING,))
        ]
        return self._best(models)

    def around(self, answer: Answer) -> list[Answer]:
        """The effect at other frequencies around those of a refit, the most promising first."""
        return self._best([self._at(answer.result.model, times) for times in AROUND])

    def _best(self, models: Sequence[Model]) -> list[Answer]:
        best: list[Answer] = []
        for share, kept in STAGES:
            beginnings = [_beginning(part, share) for part in self.measurements]
            found = self._refitted(models, beginnings)
            if not found:
                break
            found.sort(key=attrgetter("mean_square"))
            worst = WORSE * found[0].mean_square
            best = [answer for answer in found if answer.mean_square <= worst][:kept]
            models = [self._at(answer.result.model, times) for answer in best for times in BESIDE]
        return best

    def _at(self, model: Model, times: float) -> Model:
        """The model with another frequency."""
        own = model.values()
        paths = [
            f"effects.{self.effect_id}.{parameter.name}"
            for parameter in effects.BY_ID[self.effect_id].parameters
            if parameter.resonant
        ]
        return model.with_values({path: times * own[path] for path in paths})

    def _refitted(
        self, models: Sequence[Model], measurements: Sequence[Measurement]
    ) -> list[Answer]:
        """Refits from models, where these can be simulated."""
        found = []
        for model in models:
            if enough():
                break
            self.check(0.0)
            try:
                found.append(
                    refit(self.given, self.added, measurements, [model], REFITTING, self.check)
                )
            except ElasticTendonError:
                continue
        return found


def _beginning(measurement: Measurement, share: float) -> Measurement:
    return measurement.samples(slice(int(np.ceil(share * len(measurement.time)))))
