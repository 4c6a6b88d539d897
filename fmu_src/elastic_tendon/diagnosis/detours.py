"""Ways to a better answer where no neighbour is: other laws, what rings, two effects at once, every
addition, every single effect, sets that were passed by, rare effects.
"""

from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import filterfalse

from elastic_tendon.diagnosis.answer import Answer, refit
from elastic_tendon.diagnosis.evidence import AT_NOISE, AUDIBLE, DECISIVE, MUCH
from elastic_tendon.diagnosis.lack_of_fit import OVERWHELMING, LackOfFit, Regression, regress
from elastic_tendon.diagnosis.likeliest_sets import FAR_BETTER
from elastic_tendon.diagnosis.looks import WORTH, Looks
from elastic_tendon.diagnosis.refits import AT_ONCE, EFFORT, FAILURES
from elastic_tendon.diagnosis.resonance import frequencies, holds_swinging, may_hide, swings
from elastic_tendon.diagnosis.sets import Set, told, without

REFITTED = 3  # sets that promise more, refitted in one round
FIRST = 0.5  # share of the mean square; who promises less is refitted before all others
RACED = 4  # additions, of which short refits leave least
WHITE = 0.9  # share of the samples that are independent facts, of noise alone
DETOURS = 4  # sets of fewer effects than the answer, the best first, that are grown too
UNLIKE = 4.0  # times the fitted recordings' mean square, above which held-out ones are not alike
# of a fit to all recordings that starts at an answer
AGAIN = replace(EFFORT, scouted=1, evaluations=10)
HARDLY_MORE = 1.5  # mean square up to which a rare effect may win
RARE = "it is tried on request only, as more than noise is left with it"
HARDLY_BETTER = 0.1  # of the base's mean square; singles may do better than what leaves more


@dataclass(kw_only=True)
class Detours(Looks):
    """What was tried besides neighbours; `neighbours` : for each set that was the best, those one
    change away with their evidence less its own as the screens expect it, None where they could not
    say.
    """

    neighbours: dict[Set, dict[Set, float | None]] = field(default_factory=dict)
    _exhausted: set[Set] = field(default_factory=set)
    _passed: set[Set] = field(default_factory=set)
    # answers of which richer laws were tried
    _other_laws: dict[Set, Answer] = field(default_factory=dict)
    _paired: dict[Set, Answer] = field(default_factory=dict)  # of which two additions were tried
    # the latest answer of which that was asked, and what it leaves
    _regressed: tuple[Answer, Regression] | None = None
    _lack: tuple[Answer, Mapping[str, LackOfFit]] | None = None

    @property
    def _quick(self) -> list[str]:
        """Candidates that do not swing: a look at what does is dear."""
        return list(filterfalse(swings, self.data.candidates))

    def _better_with_less(self) -> bool:
        """Where nothing but noise is left: sets without one of the effects, before any other.

        Returns
        -------
        whether the best has changed
        """
        answer = self.answer
        if self._at_noise():
            less = [without(answer.added, effect_id) for effect_id in answer.added]
            self._refit(less, "trying fewer effects")
        return self.answer.added != answer.added

    def _better_law(self) -> bool:
        """Where anything audible is left: richer laws of what was found, from its parameters.

        Returns
        -------
        whether the best has changed
        """
        answer = self.answer
        if self._tired or answer is self._other_laws.get(answer.added):
            return False
        self._other_laws[answer.added] = answer
        if self._white(answer) or answer.mean_square < 1.0 + AUDIBLE**2:
            return False
        self._take_beside(answer, self._richer(answer.added), "trying other laws")
        return self.answer.added != answer.added

    def _white(self, answer: Answer) -> bool:
        """Whether what an answer leaves is independent from sample to sample, as noise alone is."""
        return self.evidence.facts([answer]) > WHITE * len(answer.floored)

    def _better_ringing(self, added: Set) -> bool:
        """Refit additions to the best set that swing as what it leaves does; whether the best has
        changed."""
        self._refit(self._ringing(added), "refitting what rings")
        return self.answer.added != added

    def _ringing(self, added: Set) -> list[Set]:
        """Additions that swing, where what a set leaves does, or may, and they would leave less."""
        if self._at_noise() or self._tired:
            return []
        answer = self.answers[added]
        ringing = [
            effect_id
            for effect_id in filter(swings, self.data.candidates)
            if frequencies(effect_id, answer) or may_hide(answer)
        ]
        looks = self._looks(added, ringing)
        return [near for near, share in looks.items() if share < WORTH]

    def _rings(self, added: Set) -> bool:
        """Whether what a set leaves has a peak where something that swings would show."""
        swinging = filter(swings, self.data.candidates)
        return any(frequencies(effect_id, self.answers[added]) for effect_id in swinging)

    def _promises(self, added: Set) -> bool:
        """Whether the likeliest neighbour of a set is expected to do surely better, and was not
        refitted."""
        near, expected = next(iter(self.neighbours.get(added, {}).items()), ((), None))
        untried = near not in self.answers and near not in self.failures
        return untried and (expected or 0.0) < -DECISIVE

    def _better_with_two(self) -> bool:
        """Where much is left: two additions of which neither does better without the other. Any two
        explain much of something unknown, so they are kept only where nothing but noise is left.

        Returns
        -------
        whether the best has changed
        """
        answer, added = self.answer, self.answer.added
        done = answer is self._paired.get(added)
        if done or self._tired or answer.mean_square < MUCH or self._dear(answer):
            return False
        self._paired[added] = answer
        likely = self._two_at_once(added, self._quick)[:REFITTED]
        untried = [near for near in likely if near not in self.answers]
        self._refit(untried, "refitting two at once")
        for near in filter(self.answers.__contains__, untried):
            if not self._meets_noise(self.answers[near]):
                del self.answers[near]
        return self.answer is not answer

    def _affordable_addition(self) -> bool:
        """A better addition, where refits do not take so long that they are cut short."""
        return not self._dear(self.answer) and self._better_addition()

    def _better_addition(self) -> bool:
        """Where much is left: additions, the likeliest first, whatever the torque screen says, but
        for what swings.

        Returns
        -------
        whether the best has changed
        """
        answer = self.answer
        if self._tired or answer.mean_square < MUCH or answer.added in self._exhausted:
            return False
        if self._disturbed():
            return False
        self._exhausted.add(answer.added)
        if self._dear(answer):
            looks = self._looks(answer.added, self._quick)
            likely = sorted(looks, key=looks.__getitem__)[:AT_ONCE]
        else:
            likely = self._raced(answer, self._quick)
        for start in range(0, len(likely), AT_ONCE):
            self._refit(likely[start : start + AT_ONCE], "trying every addition", again=True)
            if self._at_noise() or self._tired:
                break
        return self.answer is not answer

    def _raced(self, answer: Answer, effect_ids: Iterable[str]) -> list[Set]:
        """Additions that do best in short refits, where they begin from now on."""
        sets = self._additions(answer.added, effect_ids)
        words = "trying every addition"
        work = [
            (told(words, near), partial(self._scouted, answer, near, effect_id))
            for near, effect_id in sets.items()
        ]
        found = dict(self._without_failures(list(sets), self._at_once(work)))
        for near, scouted in found.items():
            self.starts[near] = [scouted.result.model]
        best = sorted(found, key=lambda near: found[near].mean_square)
        return [near for near in best if found[near].mean_square < answer.mean_square][:RACED]

    def _better_single(self) -> bool:
        """Where much is left, or one effect explains the little that the base leaves: every single
        effect, whatever the screens say, but for what swings.

        Returns
        -------
        whether the best has changed
        """
        answer, base = self.answer, self._left(())
        little = len(answer.added) == 1 and base < MUCH and not self._dear(answer)
        if self._tired or not (little or answer.mean_square >= max(MUCH, HARDLY_BETTER * base)):
            return False
        self._refit([(effect_id,) for effect_id in self._quick], "trying every effect")
        return self.answer is not answer

    def _better_detour(self) -> bool:
        """Where much is left: additions to, and richer laws of, refused sets that leave far less,
        which may lack what they were refused for; and additions to the best sets of fewer
        effects, which the way to the answer may have passed by.

        Returns
        -------
        whether the best has changed
        """
        answer = self.answer
        if answer.mean_square < MUCH or self._disturbed():
            return False
        fewer = [part for part in self.allowed if len(part.added) < len(answer.added)]
        values = dict(zip((part.added for part in fewer), self.evidence.of(fewer), strict=True))
        refused = sorted(filter(self._refused_for_less, self.answers), key=self._left)
        for added in (*refused, *sorted(values, key=values.__getitem__))[:DETOURS]:
            if self._tired or added in self._passed:
                continue
            self._passed.add(added)
            if added in refused:
                self._take_beside(self.answers[added], self._richer(added), "trying other laws")
            looks = self._looks(added, self._quick)
            likely = [near for near in sorted(looks, key=looks.__getitem__) if looks[near] < WORTH]
            self._refit(likely[:REFITTED], "refitting what was passed by")
        return self.answer is not answer

    def _refused_for_less(self, added: Set) -> bool:
        """Whether a set that cannot be the answer leaves far less than the answer."""
        refused = bool(self.why_refused(added))
        return refused and self._left(added) < FAR_BETTER * self.answer.mean_square

    def _explained_by_rare(self) -> bool:
        """Where much is left: effects that are else tried on request only. One of them looks like
        two common ones, so it is an answer only where hardly more than noise is left with it.

        Returns
        -------
        whether the best has changed
        """
        answer, added = self.answer, self.answer.added
        if answer.mean_square < HARDLY_MORE:
            return False
        sets = self._additions(added, self.data.rare)
        untried = [near for near in sets if near not in {*self.answers, *self.failures}]
        half = FIRST * (1.0 + 1.0 / answer.mean_square)  # of what is left beside the noise
        if untried and all(map(self.screen.sees, (*added, *sets.values()))):
            own = self._own(added)
            found, _ = self.screen.combined(own, [sets[near] for near in untried], len(untried))
            self._keep(found.values())
            untried = [near for near in untried if self._badness(near) < half * own.square]
        elif self._dear(answer):
            looks = self._looks(added, [sets[near] for near in untried])
            untried = [near for near in untried if looks.get(near, 1.0) < half]
        self._refit(untried, "trying rare effects")
        most = HARDLY_MORE if answer.mean_square > MUCH else AT_NOISE
        elsewhere = max(HARDLY_MORE, self.evidence.heldout_square(answer))
        for near in filter(self.answers.__contains__, untried):
            tried = self.answers[near]
            if tried.mean_square > most or self.evidence.heldout_square(tried) > elsewhere:
                self.refused[near] = RARE
        return self.answer is not answer

    def _explained_at_once_by_rare(self) -> None:
        """The same early, for one may spare a long search; what explains too little is forgotten,
        so that nothing is built upon it."""
        if self._at_noise() or not self.answer.added:
            return
        known = set(self.answers)
        self._explained_by_rare()
        for added in set(self.answers) - known:
            if self.refused.get(added) == RARE:
                del self.answers[added], self.refused[added]

    # ---- what an answer leaves ---------------------------------------------------------------

    def regressed(self, answer: Answer) -> Regression:
        """What an answer leaves, regressed on the state of the machine."""
        if self._regressed is None or self._regressed[0] is not answer:
            self._regressed = answer, regress(answer.result, self.progress)
        return self._regressed[1]

    def lack_of_fit(self, answer: Answer) -> Mapping[str, LackOfFit]:
        """Whether what an answer leaves depends on the state of the machine, by signal.

        Where fitted recordings cannot tell, held-out ones that it meets alike are asked too, with
        its parameters fitted to all of them: chance does not come twice at the same state.
        """
        if self._lack is None or self._lack[0] is not answer:
            found = self.regressed(answer).found
            told = any(lack.significant for lack in found.values())
            unlike = self.evidence.heldout_square(answer) > UNLIKE * answer.mean_square
            over = told or unlike or answer.mean_square < AT_NOISE or self._dear(answer)
            if self.data.heldout and not over:
                everything, start = (*self.data.fitted, *self.data.heldout), [answer.result.model]
                with suppress(*FAILURES):
                    whole = refit(self.data.given, answer.added, everything, start, AGAIN)
                    again = regress(whole.result, self.progress).found
                    found = {name: lack.or_surely(again[name]) for name, lack in found.items()}
            self._lack = answer, found
        return self._lack[1]

    def _disturbed(self) -> bool:
        """Whether more than noise is left that does not depend on the state of the machine at all,
        as a disturbance that nobody recorded: no effect explains it, nor is expected to."""
        answer = self.answer
        timed = not any(recording.static for recording in self.data.fitted)
        if not (timed and AT_NOISE < answer.mean_square < OVERWHELMING**2):
            return False
        if self._promises(answer.added) or holds_swinging(answer.added):
            return False  # what remembers, or swings, depends on more than the state
        alone = self.regressed(answer).found
        return _shapeless(alone) and _shapeless(self.lack_of_fit(answer))


def _shapeless(found: Mapping[str, LackOfFit]) -> bool:
    return all(lack.shapeless for lack in found.values())
