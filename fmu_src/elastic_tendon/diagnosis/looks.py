"""Looks along trajectories: what one more effect would leave beside a refitted set.

One simulation a start, see `trajectory_screen`; what swings is sought at its frequencies, see
`resonance`. What they find is where a refit begins.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial
from operator import itemgetter
from typing import TypeVar

import numpy as np

from elastic_tendon import effects
from elastic_tendon.actuator.parameters import Model
from elastic_tendon.comparison.residuals import Array
from elastic_tendon.diagnosis.answer import Answer
from elastic_tendon.diagnosis.around import UNSEEN_SHARES
from elastic_tendon.diagnosis.candidates import starts
from elastic_tendon.diagnosis.doubts import Doubts
from elastic_tendon.diagnosis.evidence import AT_NOISE
from elastic_tendon.diagnosis.refits import EFFORT, Check
from elastic_tendon.diagnosis.resonance import Resonance, swings
from elastic_tendon.diagnosis.sets import Set, in_order, model_with, told
from elastic_tendon.diagnosis.torque_screen import scaled_strengths
from elastic_tendon.diagnosis.trajectory_screen import TrajectoryScreen
from elastic_tendon.native.library import library_path

# of typical strengths, at which trajectories are looked at; what a weak effect changes is linear
SHARES, SMALL_SHARES = (0.3,), (0.03, 0.3)
# share of the mean square below which an effect that the screen does not see is tried, and of what
# the better of two leaves alone for both
WORTH = 0.9
MOST_TIMES = 10.0  # its start, as which such an effect comes in at the most
# starts of one effect that are looked at, of a finer grid evenly spread ones: alone, with another
MOST_LOOKS, MOST_OF_TWO = 18, 6
KEPT = 3  # starts of such a look, the best first, from which a refit begins

T = TypeVar("T")


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
        found = {}
        for near, best in self._look_at_each(added, self._additions(added, effect_ids), self._look):
            self.starts[near] = [model for _, model in best]
            found[near] = min(share for share, _ in best)
        return found

    def _two_at_once(self, added: Set, effect_ids: Iterable[str]) -> list[Set]:
        """Sets with two more effects of which either alone would leave far more, the likeliest
        first, by the trajectory screen: one may only make room for what the other explains."""
        sets, answer = self._additions(added, effect_ids), self.answers[added]
        begun = [
            (sets[near], values, change)
            for near, changes in self._look_at_each(added, sets, self._changes)
            for values, change in changes
        ]
        shares, times = TrajectoryScreen(answer).together([change for _, _, change in begun])
        found: dict[Set, list[tuple[float, Model]]] = {}
        for pair in zip(*np.nonzero(np.triu(shares < WORTH, 1)), strict=True):
            two = [begun[number][0] for number in pair]
            near = in_order((*added, *two))
            alone = min(shares[number, number] for number in pair)
            if two[0] == two[1] or shares[pair] > WORTH * alone or not self.screen.goes(near):
                continue
            values = dict(answer.result.model.values())
            for number, partner in (pair, pair[::-1]):
                effect_id, start, _ = begun[number]
                many = min(times[number, partner], MOST_TIMES)
                values |= {**start, **scaled_strengths(effect_id, start, many)}
            model = model_with(self.data.given, near, values)
            found.setdefault(near, []).append((shares[pair], model))
        for near, best in found.items():
            best.sort(key=itemgetter(0))
            self.starts[near] = [model for _, model in best[:KEPT]]
        return sorted(found, key=lambda near: found[near][0][0])

    def _look_at_each(
        self,
        added: Set,
        sets: Mapping[Set, str],
        look: Callable[[TrajectoryScreen, Set, str, Check], T],
    ) -> Iterator[tuple[Set, T]]:
        """Sets with what a look at their one effect more finds; failures are kept."""
        alone, given = TrajectoryScreen(self.answers[added]), self.data.given
        together = self._in_one_library(added, list(sets.values()))
        shared = dict.fromkeys(together, TrajectoryScreen(self.answers[added], together))

        def compiled(near: Set, effect_id: str, check: Check) -> T:
            screen = shared.get(effect_id, alone)
            built = in_order((*near, *screen.nulls))
            library_path((*given.effect_ids, *built), given.kind)
            return look(screen, added, effect_id, check)

        work = [
            (told("looking at additions", near), partial(compiled, near, effect_id))
            for near, effect_id in sets.items()
        ]
        return self._without_failures(list(sets), self._at_once(work))

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
        near, answer = in_order((*added, effect_id)), self.answers[added]
        if swings(effect_id) and (found := self._look_along(answer, near, effect_id, check)):
            return found
        return screen.best(self._begun(added, effect_id, MOST_LOOKS), check)[:KEPT]

    def _changes(
        self, screen: TrajectoryScreen, added: Set, effect_id: str, check: Check
    ) -> list[tuple[Mapping[str, float], Array]]:
        """Starts of one more effect, its parameters by path, and what each changes along the
        trajectory (N,); one that may have either sign changes the opposite with the other."""
        found: list[tuple[Mapping[str, float], Array]] = []
        strength = effects.BY_ID[effect_id].strength
        path = f"effects.{effect_id}.{strength.name}"
        for model in self._begun(added, effect_id, MOST_OF_TWO):
            check(0.0)
            change = screen.changed(model)
            if change is not None and np.isfinite(change).all():
                start = self._of_effects(model.values(), [effect_id])
                found.append((start, change))
                if strength.lower < strength.null:
                    opposite = {**start, path: 2.0 * strength.null - start[path]}
                    found.append((opposite, -change))
        return found

    def _begun(self, added: Set, effect_id: str, most: int) -> list[Model]:
        """Where a look at one more effect begins, with so many of its shapes at the most."""
        near, answer = in_order((*added, effect_id)), self.answers[added]
        seen = SMALL_SHARES if answer.mean_square < AT_NOISE else SHARES
        shares = seen if self.screen.sees(effect_id) else UNSEEN_SHARES
        law, fitted = effects.BY_ID[effect_id], self.data.fitted
        models = self.starts.get(near, [])[:KEPT]
        for share in shares:
            values = list(starts(self.data.given, law, fitted, (share,)))
            some = values[:: -(-len(values) // most)]
            models = [*models, *self._models_beside(answer, near, effect_id, some)]
        return models

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
