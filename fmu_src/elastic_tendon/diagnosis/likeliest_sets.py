"""The likeliest sets of one, two and three effects, by the torque screen alone."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

from elastic_tendon.diagnosis.around import Around
from elastic_tendon.diagnosis.evidence import AT_NOISE
from elastic_tendon.diagnosis.sets import Set, in_order, richer, simpler, size_of, told
from elastic_tendon.diagnosis.torque_screen import POLISHING, badness

# times the square of the likeliest set, up to which others are refitted too, and how many: which of
# two that are close is better, only the trajectory can tell
CLOSE, CLOSEST = 1.2, 4
FAR_BETTER = 0.5  # share of the best square of fewer effects that a larger set leaves at most
PAIRED = 8  # singles, the best first, that are looked at with every other effect
TRIED = 8  # effects of the likeliest pairs, of which any three are tried
# singles whose base is tried, and the share of the square it must leave
BASES, BETTER_BASE = 3, 0.8
BEGUN = 3  # steps after which only such three go on that leave less than the best pair
FOLLOWED = 3  # sets with one more effect that are estimated, from each origin
PROMISING = 0.95  # of the base's square, which a single has to leave at most for pairs to be tried


@dataclass(kw_only=True)
class LikeliestSets(Around):
    """Sets that a search begins with: what explains most, alone and with others."""

    def _screened(self) -> list[str]:
        """Candidates that the screen sees."""
        return [effect_id for effect_id in self.data.candidates if self.screen.sees(effect_id)]

    def _best_single(self) -> list[Set]:
        """The likeliest single effect, and a second if it is close; simpler laws of each first."""
        singles = sorted(self._sets(1), key=self._badness)[:2]
        most = CLOSE * min(map(self._badness, singles), default=0.0)
        close = [single for single in singles if self._badness(single) <= most]
        return [form for single in close for form in (*self._simpler(single), single)]

    def _best_singles(self) -> list[Set]:
        """The likeliest singles, that are looked at with every other effect.

        Of several laws of one thing only one takes part, see `_law_preferred`; the others are tried
        beside the best that is found.
        """
        singles = [single for single in self._sets(1) if self._law_preferred(single[0])]
        return sorted(singles, key=self._badness)[:PAIRED]

    def _law_preferred(self, effect_id: str) -> bool:
        """Whether an effect is the simplest law of its thing that no richer one does far better
        than by itself."""
        laws = [(effect_id,), *simpler((effect_id,)), *richer((effect_id,))]
        known = sorted((law for law in laws if law in self.estimates), key=size_of)
        preferred = known[0]
        for law in known[1:]:
            if self._badness(law) < FAR_BETTER * self._badness(preferred):
                preferred = law
        return preferred == (effect_id,)

    def _best_pair(self, ids: Sequence[str]) -> list[Set]:
        """The likeliest pair, simpler laws first, if it leaves far less than any single."""
        singles = self._best_singles()
        if not singles:
            return []
        best = min(map(self._badness, self._sets(1)))
        if best < AT_NOISE or best > PROMISING * self._badness(()):
            return []
        others = [effect_id for effect_id in ids if self._law_preferred(effect_id)]
        self._pairs(singles, others)
        if min(map(self._badness, self._sets(2)), default=0.0) > FAR_BETTER * best:
            self._pairs(singles, others, as_given=True)
        return self._far_better(2, best)

    def _best_three(self) -> list[Set]:
        """The likeliest three effects, simpler laws first, if they leave far less than any pair.

        Three may explain all of what no two of them begin to. So all of the effects that do well in
        pairs are tried, each from its own estimate, beside the parameters as given.
        """
        pairs = sorted(self._sets(2), key=self._badness)
        effect_ids = list(dict.fromkeys(effect_id for pair in pairs for effect_id in pair))
        threes = [in_order(three) for three in combinations(effect_ids[:TRIED], 3)]
        possible = [three for three in threes if self.screen.goes(three)]
        for number, three in enumerate(possible):
            self.progress("screening three effects at once", number / len(possible))
            start: dict[str, float] = {}
            for effect_id in three:
                single = (effect_id,)
                start |= self._of_effects(self.estimates[single].values, single)
            estimate = self.screen.fit(three, start, BEGUN)
            if badness(estimate) < self._badness(pairs[0]):
                estimate = self.screen.fit(three, estimate.values, POLISHING)
            self._keep([estimate])
        return self._far_better(3, self._badness(pairs[0])) if pairs else []

    def _far_better(self, size: int, best: float) -> list[Set]:
        """The likeliest of the sets of a size and those close to it, simpler laws of each first,
        that leave far less than the best of those with fewer."""
        likely = sorted(self._sets(size), key=self._badness)[:CLOSEST]
        most = min(CLOSE * min(map(self._badness, likely), default=0.0), FAR_BETTER * best)
        close = [added for added in likely if self._badness(added) <= most]
        return list(
            dict.fromkeys(form for added in close for form in (*self._simpler(added), added))
        )

    def _screen_singles(self, ids: Sequence[str], base: Mapping[str, float] | None) -> None:
        for number, effect_id in enumerate(ids):
            self.progress(told("screening", (effect_id,)), number / len(ids))
            self._keep([self.screen.single(effect_id, base)])

    def _better_base(self) -> bool:
        """Whether the model alone does far better from where an effect has led its parameters."""
        before = self._badness(())
        for single in sorted(self._sets(1), key=self._badness)[:BASES]:
            self._keep([self.screen.fit((), self.estimates[single].values, 8)])
        if self._badness(()) > BETTER_BASE * before:
            return False
        del self.answers[()]
        self._refit([()], "refitting the parameters")
        return True

    def _pairs(self, singles: Sequence[Set], ids: Sequence[str], *, as_given: bool = False) -> None:
        """Look at every effect beside some singles, or beside their strengths in the model as
        given: one effect alone may have led the other parameters far away."""
        for number, single in enumerate(singles):
            self.progress("screening pairs", number / len(singles))
            origin = self.estimates[single]
            if as_given:
                origin = self.screen.fit(single, self._of_effects(origin.values, single), 0)
            others = [effect_id for effect_id in ids if effect_id not in single]
            # looks are linear, and see nothing of what the likeliest single has taken for its own
            followed = FOLLOWED if number else len(others)
            found, _ = self.screen.combined(origin, others, followed)
            self._keep(found.values())

    def _sets(self, size: int) -> list[Set]:
        return [added for added in self.estimates if len(added) == size]
