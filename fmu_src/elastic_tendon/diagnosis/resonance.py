"""Where an effect that swings may hide: a light mass that is hardly damped rings for long.

It shows as a peak in the spectrum of what is left without it. Over a whole recording its frequency
has to be right to half a percent, or the fit ends in a wrong minimum; over the beginning of it a
rough one will do. So frequencies about the peaks are refitted to a short beginning, the best of
them to a longer one, and so on to the whole. Where much is left noise may hide the peak: there as
many frequencies as a short beginning tells apart are refitted to that too.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from operator import attrgetter

import numpy as np

from elastic_tendon import effects
from elastic_tendon.actuator.parameters import Model, sizes_of
from elastic_tendon.comparison.residuals import Array
from elastic_tendon.diagnosis.answer import Answer, refit
from elastic_tendon.diagnosis.candidates import starts
from elastic_tendon.diagnosis.evidence import MUCH
from elastic_tendon.diagnosis.peaks import strongest
from elastic_tendon.diagnosis.sets import model_with
from elastic_tendon.effects.base import Parameter, Sizes
from elastic_tendon.errors import ElasticTendonError
from elastic_tendon.estimation.coordinates import SPRINGS
from elastic_tendon.estimation.fit import Effort
from elastic_tendon.measurement import Measurement
from elastic_tendon.simulation.work import enough

LEAST, MOST = 0.03, 10.0  # times what is typical, of what sets the frequency of a peak
TRIED = np.geomspace(0.1, 1e3, 400)  # times the natural frequency, of which those are in range
PEAKS = 3  # that are tried, the highest first
ABOUT = (1.0, 0.96, 1.04)  # times the frequency of a peak, where refits begin
APART = 1.14  # times the frequency before, of those that are tried where noise may hide a peak
DAMPING = 0.25  # times the typical one
# share of a recording that is refitted, and how many of the best are refitted to the next
STAGES = ((0.125, 8), (0.2, 4), (0.35, 4), (0.6, 2), (1.0, 4))
SHORTEST = 0.4  # s, of a beginning that is refitted alone
WORSE = 4.0  # times the least mean square, from which no refit goes on
ALIKE = 0.01, 0.05  # shares by which frequency setting and mean square of one minimum differ
SCATTER = 3.0  # standard deviations by which the mean square of noise alone may exceed 1
# mean square of a beginning, times that of a refit without the effect, from which the effect does
# not show in it; if it errs there at least half as much as over the whole
WORTH, TELLING = 0.9, 0.5
HIDDEN_WORTH = 0.5  # the same where no peak tells that anything swings, if it errs much
BESIDE = (0.975, 1.025)  # times what sets the frequency, where the next refits begin too
AROUND = tuple(np.geomspace(0.6, 1.6, 7))  # likewise, around a refit
REFITTING = Effort(scouted=1, scouting=10, polished=0, evaluations=1, rounds=0, tolerance=1e-3)


def swings(effect_id: str) -> bool:
    """Whether an effect has a parameter that sets a frequency."""
    return any(map(_sets_frequency, effects.BY_ID[effect_id].parameters))


def holds_swinging(added: Iterable[str]) -> bool:
    """Whether any of some effects swings."""
    return any(map(swings, added))


def frequencies(effect_id: str, answer: Answer) -> list[float]:
    """Angular frequencies (rad/s) at which what an answer leaves may swing as an effect does, the
    likeliest first."""
    bounds = _range(_resonant(effect_id), _sizes(answer.result.model))
    errors = [
        (recording.time, error)
        for recording, by_signal in zip(
            answer.result.problem.measurements, answer.errors, strict=True
        )
        for error in by_signal.values()
    ]
    return strongest(errors, PEAKS, bounds)


def may_hide(answer: Answer) -> bool:
    """Whether an answer leaves so much that noise may hide the peak of what swings."""
    return answer.mean_square > MUCH


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
        """Some of the effect beside a refit without it, the most promising first; none where
        nothing swings."""
        given, found = self.given.values(), answer.result.model.values()
        # without the effect they were driven to where it would not ring
        dampings = {path: given[path] for path in (f"{spring}.damping" for spring in SPRINGS)}
        effect = effects.BY_ID[self.effect_id]
        tried = [
            (times * frequency, own)
            for frequency in frequencies(self.effect_id, answer)
            for own in (given, dampings)
            for times in ABOUT
        ]
        tried += [(frequency, dampings) for frequency in self._all_frequencies(answer)]
        models = [
            model_with(
                self.given,
                self.added,
                found
                | own
                | {f"effects.{effect.id}.{name}": value for name, value in start.items()}
                | self._tuned(answer, frequency),
            )
            for frequency, own in tried
            for start in starts(self.given, effect, self.measurements, (1.0,), (DAMPING,))
        ]
        return self._best(models, found | dampings, answer)

    def _all_frequencies(self, answer: Answer) -> Array:
        """Angular frequencies (rad/s) that recordings can show, where noise may hide a peak."""
        if not may_hide(answer):
            return np.empty(0)
        lowest, highest = _range(_resonant(self.effect_id), _sizes(answer.result.model))
        step = max(float(np.median(np.diff(part.time))) for part in self.measurements)
        highest = min(highest, np.pi / step)
        return np.exp(np.arange(np.log(lowest), np.log(highest), np.log(APART)))

    def around(self, answer: Answer) -> list[Answer]:
        """The effect at other frequencies than that of a refit, the most promising first."""
        own = answer.result.model
        tuned = [
            own.with_values(self._tuned(answer, frequency))
            for frequency in frequencies(self.effect_id, answer)
        ]
        return self._best([*tuned, *(self._at(own, times) for times in AROUND)], own.values())

    def _best(
        self, models: Sequence[Model], origin: Mapping[str, float], without: Answer | None = None
    ) -> list[Answer]:
        """The best refits of the whole, from the best of ever longer beginnings; other parameters
        begin where such a refit left them, and at their origin, as a beginning may not show
        them. None where a beginning is met as well without the effect."""
        best: list[Answer] = []
        ways, rivals = [[model] for model in models], len(models)
        longest = max(float(part.time[-1] - part.time[0]) for part in self.measurements)
        for share, kept in STAGES:
            if share < 1.0 and share * longest < SHORTEST:
                continue
            beginnings = [_beginning(part, share) for part in self.measurements]
            # a short beginning may be met at many frequencies
            found = self._distinct(self._refitted(ways, rivals, beginnings))
            if not found:
                break
            if without is not None and self._needless(found[0], without, beginnings):
                return []
            worst = WORSE * found[0].mean_square
            best = [answer for answer in found if answer.mean_square <= worst][:kept]
            alike = _mean_square_of_noise(beginnings) ** 2 * found[0].mean_square
            rivals = sum(answer.mean_square <= alike for answer in best)
            ways = [self._ways_on(answer.result.model, origin) for answer in best]
        return best

    def _ways_on(self, model: Model, origin: Mapping[str, float]) -> list[Model]:
        """Where refits to a longer beginning start, of a refit to a shorter one."""
        return [model, self._moved(model, origin), *(self._at(model, times) for times in BESIDE)]

    def _distinct(self, found: Iterable[Answer]) -> list[Answer]:
        """One refit of each minimum, the best first."""
        distinct: list[Answer] = []
        for answer in sorted(found, key=attrgetter("mean_square")):
            if not any(self._alike(answer, known) for known in distinct):
                distinct.append(answer)
        return distinct

    def _alike(self, first: Answer, second: Answer) -> bool:
        """Whether two refits are in the same minimum."""
        settings = [part.result.model.values()[self._path] for part in (first, second)]
        squares = first.mean_square, second.mean_square
        return all(
            max(pair) <= (1.0 + share) * min(pair)
            for share, pair in zip(ALIKE, (settings, squares), strict=True)
        )

    def _needless(self, found: Answer, without: Answer, beginnings: Sequence[Measurement]) -> bool:
        """Whether beginnings that show as much error as the whole are met as well without it; where
        it has no peak, whether it explains less than half of beginnings that show much."""
        own = [without.result.model]
        before = refit(self.given, without.added, beginnings, own, REFITTING, self.check)
        left = before.mean_square
        if not frequencies(self.effect_id, without):
            return left > MUCH and found.mean_square > HIDDEN_WORTH * left
        return left > TELLING * without.mean_square and found.mean_square > WORTH * left

    @property
    def _path(self) -> str:
        return f"effects.{self.effect_id}.{_resonant(self.effect_id).name}"

    def _tuned(self, answer: Answer, frequency: float) -> dict[str, float]:
        """What sets the frequency, for an angular frequency (rad/s), by dotted path."""
        return {
            self._path: _value_at(frequency, _resonant(self.effect_id), _sizes(answer.result.model))
        }

    def _moved(self, model: Model, origin: Mapping[str, float]) -> Model:
        """The effect of a model among other values of all else, at the same frequency."""
        own = f"effects.{self.effect_id}."
        moved = model.with_values(
            {path: origin.get(path, value) for path, value in model.values().items()}
            | {path: value for path, value in model.values().items() if path.startswith(own)}
        )
        before, after = (
            _value_at(1.0, _resonant(self.effect_id), _sizes(of)) for of in (model, moved)
        )
        return self._at(moved, after / before)

    def _at(self, model: Model, times: float) -> Model:
        """The model with another frequency."""
        return model.with_values({self._path: times * model.values()[self._path]})

    def _refitted(
        self, ways: Sequence[Sequence[Model]], rivals: int, measurements: Sequence[Measurement]
    ) -> list[Answer]:
        """Refits from models, where these can be simulated: from the first of each way, then from
        the second. A way ends once it leaves no more than noise; then only rivals of the best, the
        first ways, go on."""
        found: list[Answer] = []
        least = _mean_square_of_noise(measurements)
        ended: set[int] = set()
        for models in zip(*ways, strict=True):
            for number, model in enumerate(models):
                if number in ended or (ended and number >= rivals):
                    continue
                if enough():
                    return found
                self.check(0.0)
                with suppress(ElasticTendonError):
                    answer = refit(
                        self.given, self.added, measurements, [model], REFITTING, self.check
                    )
                    found.append(answer)
                    if answer.mean_square < least:
                        ended.add(number)
        return found


def _sets_frequency(parameter: Parameter) -> bool:
    return parameter.at_frequency is not None


def _resonant(effect_id: str) -> Parameter:
    """What sets the frequency of an effect that swings."""
    return next(filter(_sets_frequency, effects.BY_ID[effect_id].parameters))


def _value_at(frequency: float, parameter: Parameter, sizes: Sizes) -> float:
    """Value of what sets a frequency, for an angular frequency, rad/s."""
    assert parameter.at_frequency is not None
    return parameter.at_frequency(sizes, frequency)


def _range(parameter: Parameter, sizes: Sizes) -> tuple[float, float]:
    """Lowest and highest angular frequency of what is typical, rad/s; where none is, no range."""
    tried = sizes.frequency * TRIED
    values = np.array([_value_at(frequency, parameter, sizes) for frequency in tried])
    shares = values / parameter.typical_for(sizes)
    inside = tried[(shares >= LEAST) & (shares <= MOST)]
    return float(inside.min(initial=np.inf)), float(inside.max(initial=0.0))


def _sizes(model: Model) -> Sizes:
    return sizes_of(model.transmission, model.link)


def _mean_square_of_noise(measurements: Sequence[Measurement]) -> float:
    """That noise alone hardly exceeds by chance."""
    count = sum(len(part.time) * len(part.signals) for part in measurements)
    return 1.0 + SCATTER * float(np.sqrt(2.0 / count))


def _beginning(measurement: Measurement, share: float) -> Measurement:
    return measurement.samples(slice(int(np.ceil(share * len(measurement.time)))))
