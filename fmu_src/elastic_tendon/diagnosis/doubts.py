"""Doubts: may an effect of the best answer be chance, or stand for something that is not there?

Beside held-out recordings, stretches of time that a refit did not see tell: what does not exist
explains far less of these.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from elastic_tendon import effects
from elastic_tendon.actuator.effect_numbers import cautions
from elastic_tendon.comparison.residuals import Array
from elastic_tendon.diagnosis.answer import Answer
from elastic_tendon.diagnosis.around import POOR
from elastic_tendon.diagnosis.cross_validation import Tasks, crossed_squares, median_explained
from elastic_tendon.diagnosis.evidence import (
    FADES,
    FADES_IN_TIME,
    HELDOUT_AT_NOISE,
    LASTING,
    MUCH,
    SURELY,
    WORSE_ELSEWHERE,
    explained,
)
from elastic_tendon.diagnosis.lack_of_fit import OVERWHELMING
from elastic_tendon.diagnosis.likeliest_sets import LikeliestSets
from elastic_tendon.diagnosis.sets import Set, limiting, without
from elastic_tendon.diagnosis.significance import (
    CHANCE,
    COMMON,
    heldout_significance,
    heldout_worse,
    significance,
)
from elastic_tendon.diagnosis.trajectory_screen import TrajectoryScreen

CONVINCING = 0.95  # share of a held-out mean square: who lowers it so far is no chance
SURELY_HELDOUT = 2.0  # SURELY, on held-out recordings
BEYOND_CHANCE = 10.0  # ... on stretches of time that a fit did not see
NEARLY = 1.5  # times the square on the torque screen, from where a refit may come to as little
ALIKE = 0.02  # share of the mean square by which errors that are alike differ


@dataclass(kw_only=True)
class Doubts(LikeliestSets):
    """What speaks against the best so far; an answer in doubt is refused, and the next is best."""

    _simplified: dict[Set, Answer] = field(default_factory=dict)  # whose simpler laws were tried
    # answers, and their mean square errors on stretches that were left out of the fit
    _across: dict[Set, tuple[Answer, Array]] = field(default_factory=dict)

    def _doubted(self) -> bool:
        """Whether effects of the answer, or of a better set, were in doubt and it has changed."""
        return self._errs_as_refused() or self._refuse_one()

    def _errs_as_refused(self) -> bool:
        """Where much is left and nothing is held out: refuse an answer that errs as a refused one
        of as many effects does, for it is no surer."""
        answer = self.answer
        if answer.mean_square <= MUCH or self.data.heldout:
            return False
        for added, why in self.refused.items():
            if len(added) != len(answer.added):
                continue
            apart = np.mean((self.answers[added].floored - answer.floored) ** 2)
            if apart < ALIKE * answer.mean_square:
                titles = " with ".join(effects.BY_ID[effect_id].title for effect_id in added)
                self.refused[answer.added] = f"errs like {titles}: {why}"
                return True
        return False

    def _refuse_one(self) -> bool:
        """Take out the effect of the answer that is least surely there, if any is in doubt, or
        refuse the whole if it does not last on held-out recordings."""
        answer = self.answer
        if self._better_as_simple():
            return True
        less = [without(answer.added, effect_id) for effect_id in answer.added]
        if not self._tired or answer.mean_square <= MUCH:  # else what is known has to do
            self._refit(less, "checking what is needed")
        if not self._tired:
            close = [added for added in less if self._close(added, answer)]
            self._refit(close, "checking what is needed", again=True)
        doubts = [
            (reason, chance)
            for effect_id in answer.added
            if (found := self._doubt(answer, effect_id)) is not None
            for reason, chance in [found]
        ]
        if self.answer is not answer:
            return True
        if self.evidence.fades(answer, self.answers[()]):
            self.refused[answer.added] = FADES
            return True
        if not doubts:
            return False
        self.refused[answer.added] = max(doubts, key=lambda doubt: doubt[1])[0]
        return True

    def _better_as_simple(self) -> bool:
        """Refit simpler laws of what was found, or what it comes to, from its parameters, and sets
        with an effect less where these do better than their refit: what came in may stand for what
        was not yet found, or have led the way.

        Returns
        -------
        whether the best has changed
        """
        answer, words = self.answer, "checking what is needed"
        if answer is self._simplified.get(answer.added):
            return False
        self._simplified[answer.added] = answer
        limits = filter(self.data.may_add, limiting(answer.added))
        self._take_beside(answer, [*self._simpler(answer.added), *limits], words)
        screen, bare = TrajectoryScreen(answer), {}
        for effect_id in answer.added:
            less, model = without(answer.added, effect_id), answer.result.model.without([effect_id])
            if less in self.answers:
                leaves = screen.as_it_is(model) * answer.mean_square
                if leaves < self._left(less):
                    bare[less] = partial(self._from, less, model, self._effort([model]))
        self._take(bare, words)
        return self.answer is not answer

    def _warned_of(self) -> bool:
        """Where much is left: refuse an answer with numbers that an effect itself warns of, for it
        stands for something else."""
        answer = self.answer
        if answer.mean_square <= MUCH:
            return False
        present = [effects.BY_ID[effect_id] for effect_id in answer.added]
        warnings = cautions(answer.result.model.effects, present)
        if warnings:
            self.refused[answer.added] = warnings[0]
        return bool(warnings)

    def _fades_in_time(self) -> bool:
        """Where much is left: refuse an answer of which an effect explains far less on stretches of
        time that were left out of the fit."""
        answer = self.answer
        if answer.mean_square <= MUCH or not answer.added or self.data.heldout:
            return False
        fewer = [without(answer.added, effect_id) for effect_id in answer.added]
        known = [added for added in fewer if added in self.answers]
        if all(self._lasts(answer.added, added) for added in known):
            return False
        self.refused[answer.added] = FADES_IN_TIME
        return True

    def _lasts(self, more: Set, less: Set) -> bool:
        """Whether what a set explains beside another is found on stretches left out of the fit, or
        is so much that no chance explains it: a stop may be reached in one stretch only."""
        if self._left(less) > BEYOND_CHANCE * self._left(more):
            return True
        fitted = explained(self._left(less), self._left(more))
        crossed = median_explained(self._crossed(less), self._crossed(more))
        return not crossed < LASTING * fitted

    def _crossed(self, added: Set) -> Array:
        """Mean square errors of a set on stretches that it was not fitted to."""
        answer = self.answers[added]
        known, squares = self._across.get(added, (None, np.empty(0)))
        if known is not answer:
            squares = crossed_squares(self.data.given, answer, self._uncounted)
            self._across[added] = answer, squares
        return squares

    def _uncounted(self, tasks: Tasks) -> Iterator[float | Exception]:
        """Results of tasks, two at a time; who doubts much has no less time to search."""
        before = self.work
        yield from self._at_once(tasks)
        self.work = before

    def _close(self, added: Set, answer: Answer) -> bool:
        """Whether a set leaves not much more than an answer, or would by the torque screen from
        where that is: from there it may do better."""
        if added in self.answers and self._left(added) < POOR * answer.mean_square:
            return True
        if not all(self.screen.sees(effect_id) for effect_id in answer.added):
            return False
        own = self._own(answer.added)
        less = self.screen.fit(added, own.values, 6)
        self._keep([less])
        return less.square < NEARLY * own.square

    def _doubt(self, answer: Answer, effect_id: str) -> tuple[str, float] | None:
        """Why an effect of an answer may not be there, and how likely that is by chance."""
        before = self.answers.get(without(answer.added, effect_id))
        if before is None:
            return None
        title, left = effects.BY_ID[effect_id].title, answer.mean_square
        chance = significance(before, answer, effect_id)
        gain, sure = before.mean_square / left, SURELY
        if self.data.heldout:
            squares = [self.evidence.heldout_square(part) for part in (before, answer)]
            # a stop may be reached in the fitted ones only
            unreached = max(squares) <= HELDOUT_AT_NOISE
            if unreached and left <= MUCH and gain > OVERWHELMING**2:
                return None
            gain, sure = squares[0] / squares[1], SURELY_HELDOUT
            if left <= MUCH and squares[1] < CONVINCING * squares[0]:
                return None
            was, after = (self.evidence.heldout_errors(part) for part in (before, answer))
            judged = heldout_significance(was, after, self.data.heldout)
            # either convinces, and two are paid for; but what is beside something unknown may take
            # some of that for its own, and so has to do so on both
            chance = max(chance, judged) if left > MUCH else min(1.0, 2.0 * min(chance, judged))
            worse = heldout_worse(after, was, self.data.heldout)
            if worse and not self.evidence.says_little(before, answer):
                return f"{title} {WORSE_ELSEWHERE}", chance
        if gain > sure:
            return None  # however the errors hang together
        if chance > (COMMON if effects.BY_ID[effect_id].of_recording else CHANCE):
            return f"{title} may be chance, p = {chance:.2g}", chance
        return None
