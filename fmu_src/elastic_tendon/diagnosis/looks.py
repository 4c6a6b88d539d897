"""Looks along trajectories: what one more effect would leave beside a refitted set.

One simulation a start, see `trajectory_screen`; what swings is sought at its frequencies, see
`resonance`. What they find is where a refit begins.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import partial

from elastic_tendon import effects
from elastic_tendon.actuator.parameters import Model
from elastic_tendon.diagnosis.answer import Answer
from elastic_tendon.diagnosis.around import UNSEEN_SHARES
from elastic_tendon.diagnosis.candidates import starts
from elastic_tendon.diagnosis.doubts import Doubts
from elastic_tendon.diagnosis.evidence import AT_NOISE
from elastic_tendon.diagnosis.refits import EFFORT, Check
from elastic_tendon.diagnosis.resonance import Resonance, swings
from elastic_tendon.diagnosis.sets import Set, in_order, told
from elastic_tendon.diagnosis.trajectory_screen import TrajectoryScreen
from elastic_tendon.native.library import library_path

# of typical strengths, at which trajectories are looked at; what a weak effect changes is linear
SHARES, SMALL_SHARES = (0.3,), (0.03, 0.3)
MOST_LOOKS = 18  # starts of one effect that are looked at, of a finer grid evenly spread ones
KEPT = 3  # starts of such a look, the best first, from which a refit begins


@dataclass(kw_only=True)
class Looks(Doubts):
    """Additions that were looked at; `starts` keeps where their refits begin."""

    # additions that swing, as they were looked at last: beside which answer, and starts
    _looked: dict[Set, tuple[Answer, list[tuple[float, Model]]]] = field(default_factory=dict)

    def _unseen(self) -> list[str]:
        """Effects that only whole trajectories show."""
        return [effect_id for effect_id in self.data.candidates if not self.screen.sees(effect_id)]

    def _additions(self, added: Set, effect_ids: Iterable[str]) -> dict[Set, str]:
        """Sets with one more effect that a model can take, and which effect that is."""
        sets = {
            in_order((*added, effect_id)): effect_id
            for effect_id in effect_ids
            if effect_id not in added
        }
        return {near: effect_id for near, effect_id in sets.items() if self.screen.goes(near)}

    def _looks(self, added: Set, effect_ids: Iterable[str]) -> dict[Set, float]:
        """Share of the mean square that additions would leave, by the trajectory screen."""
        sets = self._additions(added, effect_ids)
        alone = TrajectoryScreen(self.answers[added])
        together = self._in_one_library(added, list(sets.values()))
        shared = dict.fromkeys(together, TrajectoryScreen(self.answers[added], together))
        work = [
            (
                told("looking at additions", near),
                partial(self._look, shared.get(effect_id, alone), added, effect_id),
            )
            for near, effect_id in sets.items()
        ]
        found = {}
        for near, best in self._without_failures(list(sets), self._at_once(work)):
            self.starts[near] = [model for _, model in best]
            found[near] = min(share for share, _ in best)
        return found

    def _in_one_library(self, added: Set, effect_ids: Iterable[str]) -> Set:
        """Those of some effects that one library has beside a set, so that looks at them compile
        once: what has memory, or switches, would make all of them dear to simulate."""
        together: Set = ()
        for effect_id in effect_ids:
            effect = effects.BY_ID[effect_id]
            light = not (effect.states or effect.relations or effect.law_of)
            if light and self.screen.goes(in_order((*added, *together, effect_id))):
                together = (*together, effect_id)
        return together

    def _look(
        self, screen: TrajectoryScreen, added: Set, effect_id: str, check: Check
    ) -> list[tuple[float, Model]]:
        """The best starts of one more effect, and what share of the mean square each leaves."""
        near = in_order((*added, effect_id))
        built = in_order((*near, *screen.nulls))
        library_path((*self.data.given.effect_ids, *built), self.data.given.kind)
        answer = self.answers[added]
        if swings(effect_id) and (found := self._look_along(answer, near, effect_id, check)):
            return found
        seen = SMALL_SHARES if answer.mean_square < AT_NOISE else SHARES
        shares = seen if self.screen.sees(effect_id) else UNSEEN_SHARES
        law, fitted = effects.BY_ID[effect_id], self.data.fitted
        models = self.starts.get(near, [])[:KEPT]
        for share in shares:
            values = list(starts(self.data.given, law, fitted, (share,)))
            some = values[:: -(-len(values) // MOST_LOOKS)]
            models = [*models, *self._models_beside(answer, near, effect_id, some)]
        return screen.best(models, check)[:KEPT]

    def _look_along(
        self, answer: Answer, near: Set, effect_id: str, check: Check
    ) -> list[tuple[float, Model]]:
        """The best frequencies of an effect that swings, unless that takes too long."""
        if self._effort([answer.result.model]).scouted < EFFORT.scouted:
            return []
        before, found = self._looked.get(near, (None, []))
        if before is not answer:
            resonance = Resonance(self.data.given, near, effect_id, self.data.fitted, check)
            found = [
                (near_answer.mean_square / answer.mean_square, near_answer.result.model)
                for near_answer in resonance.beside(answer)
            ]
            self._looked[near] = answer, found
        return found
