"""Refits of sets of effects, two at a time, each begun at all that is known by then."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor, wait
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import partial
from operator import attrgetter
from threading import Event
from typing import TypeVar

import numpy as np

from elastic_tendon.actuator.parameters import Model
from elastic_tendon.actuator.variables import interface
from elastic_tendon.comparison.residuals import simulate_measurement
from elastic_tendon.diagnosis.answer import Answer, refit, with_nulls
from elastic_tendon.diagnosis.candidates import elsewhere
from elastic_tendon.diagnosis.data import Data
from elastic_tendon.diagnosis.evidence import AT_NOISE, Evidence, worth_hearing
from elastic_tendon.diagnosis.resonance import Resonance, holds_swinging, swings
from elastic_tendon.diagnosis.sets import Set, model_with, richer, simpler, told
from elastic_tendon.diagnosis.torque_screen import Estimate, Screen
from elastic_tendon.diagnosis.trajectory_screen import TrajectoryScreen
from elastic_tendon.errors import ElasticTendonError, ModelError
from elastic_tendon.estimation.coordinates import free_parameters
from elastic_tendon.estimation.fit import Effort
from elastic_tendon.estimation.problem import TOLERANCE
from elastic_tendon.native.library import library_path
from elastic_tendon.progress import Progress
from elastic_tendon.simulation.work import AFFORDABLE, Work, counted, enough, multiplications_of

Check = Callable[[float], None]  # called on the way with the share that is done; may end the work
T = TypeVar("T")

AT_ONCE = 2  # refits; simulations let Python go on
PATIENCE = 0.5  # s between reports of a refit that takes long
FAILURES = (ElasticTendonError, ArithmeticError, ValueError)  # of a refit; the search goes on
# multiplications after which nothing more is tried, and those of the way to a first answer
MOST_WORK, CLIMBING = 5e9, 2.5e9
EFFORT = Effort(
    scouted=4, scouting=4, polished=0, evaluations=40, rounds=1, tolerance=1e-5, most=AFFORDABLE
)
# share of the mean square without it that an effect which swings leaves at most where its frequency
# is looked for again
EXPLAINS = 0.5
FEWEST = 8  # evaluations of a descent where each is dear
# share of the mean square, from which a refit begins at other parameters of what was refitted; how
# many of these at once, and how often
OTHER_MINIMUM, KEPT_MINIMA, MOST_MOVES = 0.97, 2, 6
NEAR = 100.0  # mean square above which more is missing than another minimum
LITTLE = 0.01  # of a damping's prior, from which a start with hardly any begins

mean_square = attrgetter("mean_square")


@dataclass(kw_only=True)
class Refits:
    """Refitted sets, and where refits begin.

    `answers` : refitted sets; `estimates` and `starts` : from the torque and the trajectory screen;
    `failures` : why sets could not be refitted; `work` : what refits took, see `_cost`, and
    `limit` : how much of it ends the search.
    """

    data: Data
    progress: Progress
    screen: Screen
    evidence: Evidence
    answers: dict[Set, Answer] = field(default_factory=dict)
    estimates: dict[Set, Estimate] = field(default_factory=dict)
    starts: dict[Set, list[Model]] = field(default_factory=dict)
    failures: dict[Set, str] = field(default_factory=dict)
    work: float = 0.0
    limit: float = CLIMBING

    def _refit(self, sets: Sequence[Set], words: str, *, again: bool = False) -> None:
        """Refit sets, two at a time; failures are kept with their reasons.

        Parameters
        ----------
        sets : to be refitted
        words : what is told of it
        again : also those that were, from other starts; the better answer stays
        """
        wanted = [
            added
            for added in sets
            if added not in self.failures and (again or added not in self.answers)
        ]
        self._take({added: partial(self._refitted, added) for added in wanted}, words)

    def _take(self, tasks: Mapping[Set, Callable[[Check], Answer]], words: str) -> None:
        """Keep what refits of sets give, where it is better than what was known.

        Only once all are done, or stopped: else it would depend on their timing which of them begin
        at what others have found.
        """
        work = [(told(words, added), partial(self._judged, task)) for added, task in tasks.items()]
        found: list[tuple[Set, Answer]] = []
        try:
            for added, answer in self._without_failures(list(tasks), self._at_once(work)):
                found.append((added, answer))
        finally:
            for added, answer in found:
                known = self.answers.get(added, answer)
                self.answers[added] = self.evidence.likeliest([known, answer])
            self.evidence.expect_like(self.answers[added] for added, _ in found)
        if found:
            self.progress(words, 1.0)  # for who looks on: only now they are among the answers

    def _judged(self, task: Callable[[Check], Answer], check: Check) -> Answer:
        """A refit of a set; a first one is judged by held-out recordings on the same processor."""
        answer = task(check)
        if answer.added not in self.answers:
            self.evidence.heldout_square(answer)
        return answer

    def _without_failures(
        self, sets: Sequence[Set], results: Iterable[T | Exception]
    ) -> Iterator[tuple[Set, T]]:
        """Sets with their results; failures are kept with their reasons."""
        for added, result in zip(sets, results, strict=True):
            if not isinstance(result, Exception):
                yield added, result
            elif added not in self.answers:
                self.failures[added] = f"{result}"

    def _at_once(self, work: Sequence[tuple[str, Callable[[Check], T]]]) -> Iterator[T | Exception]:
        """Results of work, each with what is told of it, two at a time; or why there are none."""
        stopped = Event()

        def check(_share: float) -> None:
            if stopped.is_set():
                raise KeyboardInterrupt

        def run(task: Callable[[Check], T], own: Work) -> T:
            with counted(own):
                return task(check)

        pool = ThreadPoolExecutor(AT_ONCE)
        counts = [Work() for _ in work]
        try:
            futures = [
                pool.submit(run, task, own) for (_, task), own in zip(work, counts, strict=True)
            ]
            for done, ((text, _), future) in enumerate(zip(work, futures, strict=True)):
                while future not in wait([future], PATIENCE).done:
                    self.progress(text, done / len(work))  # whoever wants to stop does so here
                error = future.exception()
                self.work += counts[done].multiplications
                if error is not None and not isinstance(error, FAILURES):
                    raise error
                yield error if error is not None else future.result()
                self.progress(text, (done + 1) / len(work))
        finally:  # an interrupt does not wait for the rest
            stopped.set()
            pool.shutdown(wait=False, cancel_futures=True)

    def _refitted(self, added: Set, check: Check) -> Answer:
        given, fitted = self.data.given, self.data.fitted
        library_path((*given.effect_ids, *added), given.kind)
        starts = list(self._starts(added))
        smaller = sorted(self._smaller(added), key=self._left)[:1]
        nothing = [
            with_nulls(self.answers[part].result.model, came)
            for part in smaller
            for came in [[effect_id for effect_id in added if effect_id not in part]]
            if not holds_swinging(came)  # a mass of nothing would swing endlessly fast
        ]
        effort = self._effort([*starts, *nothing])
        first = replace(effort, in_segments=added not in self.answers)
        answer = refit(given, added, fitted, starts, first, check)
        if nothing and answer.mean_square > self._left(smaller[0]):
            # misled by its starts: it begins where nothing of it is there
            again = refit(given, added, fitted, nothing, effort, check)
            answer = self.evidence.likeliest([answer, again])
        dear = effort.scouted < EFFORT.scouted
        if not smaller or dear or answer.mean_square > self.evidence.far_more:
            return answer
        if answer.mean_square < EXPLAINS * self._left(smaller[0]):
            answer = self._at_other_frequencies(answer, effort, check)
        heard = worth_hearing(self._left(smaller[0]), answer.mean_square)
        if heard and answer.mean_square < NEAR:
            answer = self._from_other_minima(answer, effort, check)
        return answer

    def _from_other_minima(self, answer: Answer, effort: Effort, check: Check) -> Answer:
        """A refit, or a better one beside it: each number of swings before dry friction holds the
        joint has its minimum, and so has each shape of a law."""
        for _ in range(MOST_MOVES):
            check(0.0)
            models = elsewhere(answer.result.model, answer.added, self.data.fitted)
            looks = TrajectoryScreen(answer).beside(models)
            near = [model for share, model in looks[:KEPT_MINIMA] if share < OTHER_MINIMUM]
            if not near or enough():
                break
            again = refit(self.data.given, answer.added, self.data.fitted, near, effort, check)
            before, answer = answer, self.evidence.likeliest([answer, again])
            if answer.mean_square > OTHER_MINIMUM * before.mean_square:
                break
        return answer

    def _at_other_frequencies(self, answer: Answer, effort: Effort, check: Check) -> Answer:
        """A refit, or a better one beside it: each frequency of what swings has its minimum."""
        data, added = self.data, answer.added
        for effect_id in filter(swings, added):
            if answer.mean_square < AT_NOISE or enough():
                break
            resonance = Resonance(data.given, added, effect_id, data.fitted, check)
            near = [part.result.model for part in resonance.around(answer)]
            again = refit(data.given, added, data.fitted, near, effort, check)
            answer = self.evidence.likeliest([answer, again])
        return answer

    def _simpler(self, added: Set) -> list[Set]:
        """Sets with a simpler law, see `simpler`, that may be the answer."""
        return list(filter(self.data.may_add, simpler(added)))

    def _richer(self, added: Set) -> list[Set]:
        """Sets with a richer law, see `richer`, that may be the answer."""
        return list(filter(self.data.may_add, richer(added)))

    def _smaller(self, added: Set) -> list[Set]:
        """Refitted sets with fewer of the effects."""
        return [known for known in list(self.answers) if set(known) < set(added)]

    @property
    def _tired(self) -> bool:
        """Whether so much was simulated that the search should come to its end."""
        return self.work > self.limit

    @property
    def _weary(self) -> bool:
        """Whether so much was simulated that the next refits may be the last."""
        return self.work > self.limit - AFFORDABLE

    def _effort(self, models: Sequence[Model]) -> Effort:
        """How long to search where derivatives are as dear as those of some models."""
        dearest = max(map(self._cost, models), default=0.0)
        affordable = AFFORDABLE / max(dearest, 1.0)  # jacobians
        return replace(
            EFFORT,
            scouted=int(np.clip(affordable / 16, 1, EFFORT.scouted)),
            evaluations=int(np.clip(affordable / 3, FEWEST, EFFORT.evaluations)),
            hopeless=self.evidence.far_more,
        )

    def _dear(self, answer: Answer) -> bool:
        """Whether refits beside an answer take so long that they are cut short."""
        return self._effort([answer.result.model]).evaluations < EFFORT.evaluations

    def _cost(self, model: Model) -> float:
        """Multiplications, about, that the derivatives of one simulation of all recordings take."""
        base = self.answers.get(())
        if base is None:
            return 0.0
        with suppress(*FAILURES):
            columns = len(free_parameters(model)) * len(interface(*model.structure).states)
            return multiplications_of(_evaluations(model, base), columns)
        return 0.0

    def _starts(self, added: Set) -> Iterator[Model]:
        """Where the refit of a set begins: what the screens estimate, also with hardly any damping;
        refits of fewer effects with what else comes in, and of more without the rest."""
        yield from self.starts.get(added, ())
        if added in self.estimates:
            values = self.estimates[added].values
            paths = self.screen.structure(added).coordinates.of_model
            start = model_with(self.data.given, added, {path: values[path] for path in paths})
            yield start
            little = {
                path: LITTLE * self.data.given.uncertainty_of(path)
                for path in paths
                if path.endswith(".damping") and not path.startswith("effects.")
            }
            with suppress(ModelError):
                yield start.with_values(little)
            if known := list(self.answers.values()):
                # another law may have found parameters that suit this one too
                base = min(known, key=mean_square).result.model.values()
                own = self._of_effects(values, added)
                with suppress(ModelError):
                    yield model_with(self.data.given, added, {**base, **own})
        yield from self._exchanged(added)
        if added in self.answers:
            yield self.answers[added].result.model
        larger = [part for part in list(self.answers) if set(part) > set(added)]
        if smaller := self._smaller(added):
            best = min(smaller, key=self._left)
            for part in dict.fromkeys((best, min(smaller, key=len))):
                yield from self._grown(added, part)
        if larger and added:
            more = self.answers[min(larger, key=self._left)]
            yield model_with(self.data.given, added, more.result.model.values())

    def _exchanged(self, added: Set) -> Iterator[Model]:
        """The best answer with one of its effects exchanged for another, as that one is estimated
        by itself: nothing may tell the two apart."""
        best = min(list(self.answers.values()), key=mean_square, default=None)
        if best is None or len(best.added) != len(added):
            return
        new = tuple(effect_id for effect_id in added if effect_id not in best.added)
        if len(new) == 1 and new in self.estimates:
            own = self._of_effects(self.estimates[new].values, new)
            with suppress(ModelError):
                yield model_with(self.data.given, added, {**best.result.model.values(), **own})

    def _left(self, added: Set) -> float:
        return self.answers[added].mean_square

    def _grown(self, added: Set, smaller: Set) -> Iterator[Model]:
        """The refit of fewer effects with what else comes in, as estimated."""
        values = self.answers[smaller].result.model.values()
        came = [effect_id for effect_id in added if effect_id not in smaller]
        if added not in self.estimates:
            return
        estimated = self._of_effects(self.estimates[added].values, came)
        given = {**self.data.given.values(), **self._of_effects(values, smaller)}
        # from the parameters refitted without it, and from those given
        for base in (values, given):
            with suppress(ModelError):
                yield model_with(self.data.given, added, {**base, **estimated})

    @staticmethod
    def _of_effects(values: Mapping[str, float], effect_ids: Sequence[str]) -> dict[str, float]:
        starts = tuple(f"effects.{effect_id}." for effect_id in effect_ids)
        return {path: value for path, value in values.items() if path.startswith(starts)}


def _evaluations(model: Model, like: Answer) -> int:
    """Right-hand sides that a simulation of all recordings takes."""
    result = like.result
    return sum(
        simulate_measurement(model, part, initial, TOLERANCE).statistics["rates"]
        for part, initial in zip(result.problem.measurements, result.initial_states, strict=True)
    )
