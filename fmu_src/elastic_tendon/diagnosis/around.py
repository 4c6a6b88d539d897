"""Refits from places around an answer: other starts, other frequencies, another law's parameters.

Where a joint sticks, strikes or rings, the sum of squares has many minima, and a refit that began
beside the best of them ends in another.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import count, islice
from math import log

import numpy as np

from elastic_tendon import effects
from elastic_tendon.actuator.parameters import Model, typical_value
from elastic_tendon.comparison.residuals import Array
from elastic_tendon.diagnosis.answer import Answer, refit
from elastic_tendon.diagnosis.candidates import is_damping, starts
from elastic_tendon.diagnosis.evidence import AT_NOISE, DECISIVE, HELDOUT_AT_NOISE, MUCH, misfit
from elastic_tendon.diagnosis.refits import AT_ONCE, EFFORT, NEAR, Check, Refits
from elastic_tendon.diagnosis.resonance import holds_swinging
from elastic_tendon.diagnosis.sets import Set, in_order, model_with, simpler, size_of, told
from elastic_tendon.diagnosis.torque_screen import BETTER, Estimate, badness
from elastic_tendon.effects.base import Effect, Spread
from elastic_tendon.errors import ModelError
from elastic_tendon.estimation.coordinates import Coordinates
from elastic_tendon.estimation.fit import Effort
from elastic_tendon.simulation.work import AFFORDABLE

# refits from around an answer: how many, how many in vain, how far in standard deviations, and how
# far at the most, in those of the prior
HOPS, FRUITLESS, DISTANCES, FARTHEST = 60, 24, (1.0, 10.0, 50.0), 0.5
# along what an answer leaves to the prior, in its standard deviations: slackness may decide there
STEPS, OPEN = (-0.25, 0.25, -0.4, 0.4, -0.6, 0.6, -0.8, 0.8, -1.0, 1.0, -1.5, 1.5), 2.0
# scans over the frequency of what swings, and the mean square at which it is surely right
MOST_SCANS, SETTLED = 8, 1.02
HOPPING = Effort(
    scouted=2,
    scouting=12,
    polished=0,
    evaluations=1,
    rounds=0,
    tolerance=1e-3,
    most=AFFORDABLE,
)
# places where one more effect is tried, its share of the typical strength there, and places that
# the screens propose
SPREAD, MODERATE, OWN = 8, 0.3, 3
SCOUTING = replace(HOPPING, scouting=6)
# sets besides, and how many times the answer's mean square they may leave
DISPUTED, POOR = 2, 10.0
WORTH_HOPPING, FAR_HOP = 0.98, 0.9  # share of the mean square that one, and all, have to leave
# of typical strengths, from which an effect begins of which little is known
STIFFER = 30.0  # times typical
UNSEEN_SHARES = (0.1, 0.2, 0.35, 0.5, 0.7, 1.0, 1.4, 2.0, 4.0)


@dataclass(kw_only=True)
class Around(Refits):
    """Refits of which the best, and what disputes with it, are refitted again.

    `refused` : sets of which an effect may be chance.
    """

    refused: dict[Set, str] = field(default_factory=dict)
    _hopped: dict[Set, Answer] = field(default_factory=dict)
    _hopped_on_screen: dict[Set, Answer] = field(default_factory=dict)
    _refitted_on: dict[Set, Answer] = field(default_factory=dict)
    _tuned: dict[Set, Answer] = field(default_factory=dict)

    @property
    def answer(self) -> Answer:
        """The best so far."""
        return self.evidence.best(self.allowed)

    @property
    def allowed(self) -> list[Answer]:
        """Refitted sets that may be the answer."""
        return self.evidence.allowed(list(self.answers.values()), self.refused)

    def why_refused(self, added: Set) -> str:
        """Why a set cannot be the answer, "" where it can, or was not refitted."""
        if added in self.failures:
            return self.failures[added]
        if added in self.refused or added not in self.answers:
            return self.refused.get(added, "")
        return self.evidence.refusal(self.answers[added], list(self.answers.values()))

    def _badness(self, added: Set) -> float:
        return badness(self.estimates[added]) if added in self.estimates else np.inf

    def _estimate(self, answer: Answer) -> Estimate:
        """The screen's estimate of a refitted set, from its refitted parameters."""
        return self.screen.fit(in_order(answer.added), answer.result.model.values(), 6)

    def _own(self, added: Set) -> Estimate:
        refitted = self._estimate(self.answers[added])
        known = self.estimates.get(added)
        return refitted if known is None else min(refitted, known, key=badness)

    def _keep(self, found: Iterable[Estimate]) -> None:
        for estimate in found:
            known = self.estimates.get(estimate.added)
            if known is None or badness(estimate) < badness(known):
                self.estimates[estimate.added] = estimate

    def _hop(self) -> bool:
        """Refit the answer, and what the screen holds for better, from places around them.

        Where a joint sticks or strikes, the sum of squares has many minima.

        Returns
        -------
        whether the answer has changed, or leaves far less
        """
        answer, before = self.answer, self.answer.mean_square
        self._lead_back()
        disputed = self._disputed()
        self._refit(disputed, "refitting again", again=True)
        for added in (answer.added, *disputed):
            self._scan_around(added) if holds_swinging(added) else self._hop_around(added)
        after = self.answer
        return after.added != answer.added or after.mean_square < FAR_HOP * before

    def _at_noise(self) -> bool:
        """Whether the best so far leaves nothing but noise, on held-out recordings too."""
        return self._meets_noise(self.answer)

    def _meets_noise(self, answer: Answer) -> bool:
        heldout = self.evidence.heldout_square(answer)
        return answer.mean_square < AT_NOISE and heldout < HELDOUT_AT_NOISE

    def _refit_on(self) -> None:
        """Where hardly more than noise is left, go on from the answer: its refit may have ended for
        want of evaluations."""
        answer = self.answer
        over = answer is self._refitted_on.get(answer.added) or answer.mean_square > MUCH
        if not (over or self._at_noise()):
            words, start = "refitting on", answer.result.model
            self._take({answer.added: partial(self._from, answer.added, start, EFFORT)}, words)
            self._refitted_on[answer.added] = self.answers[answer.added]

    def _tune(self) -> None:
        """Look at other frequencies of what swings: thoroughly where so little is left that these
        may be what is wrong, else if a refit was too dear to do so."""
        answer, added = self.answer, self.answer.added
        if not holds_swinging(added) or self._tired or self._at_noise():
            return
        if answer.mean_square < NEAR:
            self._scan_around(added)
        elif self._dear(answer) and answer is not self._tuned.get(added):
            effort = self._effort([answer.result.model])
            way = partial(self._at_other_frequencies, answer, effort)
            self._take({added: way}, "refitting at other frequencies")
            self._tuned[added] = self.answers[added]

    def _hop_on_screen(self) -> None:
        """Refit the answer from where the screen finds better numbers around its own."""
        answer = self.answer
        hopped = answer is self._hopped_on_screen.get(answer.added)
        over = hopped or self._tired or self._at_noise()
        if over or not all(map(self.screen.sees, answer.added)):
            return
        known = self._own(answer.added)
        words = told("estimating again", answer.added)
        found = self.screen.hopped(known, partial(self.progress, words))
        if badness(found) < BETTER * badness(known):
            self._keep([found])
            self._refit([answer.added], "refitting again", again=True)
        self._hopped_on_screen[answer.added] = self.answers[answer.added]

    def _disputed(self) -> list[Set]:
        """Sets that do better than the answer on the screen and worse when refitted."""
        own, least = self._badness(self.answer.added), self._left(self.answer.added)
        if not np.isfinite(own):  # the screen does not see the answer
            return []
        better = [
            added
            for added in self.answers
            if self._badness(added) < own and least < self._left(added) < POOR * least
        ]
        return sorted(filter(self._could_win, better), key=self._badness)[:DISPUTED]

    def _could_win(self, added: Set) -> bool:
        """Whether a set would do better than the answer if it left nothing but noise."""
        answer = self.answer
        facts = self.evidence.facts([answer])
        more = size_of(added) - size_of(answer.added)
        square = answer.mean_square * max(self.evidence.heldout_square(answer), 1.0)
        least = log(facts) * more - facts * misfit(square)
        return least < (DECISIVE if more < 0 else -DECISIVE)

    def _lead_back(self) -> None:
        """Laws that do worse than a simpler one of the same thing, which they need not, begin
        beside its parameters; and simpler ones that fail on held-out data where the answer does
        not, beside the answer's."""
        simple = self.answer
        misled = [
            added
            for added in self.answers
            if simple.added in simpler(added)
            and self._left(added) > simple.mean_square
            and self._could_win(added)
        ]
        self._take_beside(simple, misled, "refitting again")
        laws = [added for added in simpler(self.answer.added) if added in self.answers]
        most = HELDOUT_AT_NOISE * self.evidence.heldout_square(self.answer)
        failing = [
            added for added in laws if self.evidence.heldout_square(self.answers[added]) > most
        ]
        self._take_beside(self.answer, failing, "refitting again")
        if laws and self._could_win(self.answer.added):
            closest = self.answers[min(laws, key=self._left)]
            self._take_beside(closest, [self.answer.added], "refitting again")

    def _take_beside(self, simple: Answer, laws: Sequence[Set], words: str) -> None:
        """Refit sets with one other law than an answer from its parameters."""
        self._take({added: partial(self._beside, simple, added) for added in laws}, words)

    def _beside(self, simple: Answer, added: Set, check: Check) -> Answer:
        (law,), (own,) = (
            map(effects.BY_ID.__getitem__, set(has) - set(lacks))
            for has, lacks in ((added, simple.added), (simple.added, added))
        )
        near = simple.mean_square < MUCH
        values = self._starts_like(law, own, simple.values(own.id), near=near)
        models = self._models_beside(simple, added, law.id, values)
        effort = self._effort(models)
        return refit(self.data.given, added, self.data.fitted, models, effort, check)

    def _starts_like(
        self, law: Effect, own: Effect, known: Mapping[str, float], *, near: bool = False
    ) -> list[dict[str, float]]:
        """Parameters of a law from which a refit begins, where another law of the same thing has
        known ones: about as strong, or just as strong at every speed, which is the simpler law; and
        `near` it, where hardly more than noise is left, with far more of what is in that without
        end, as the stiffness of bristles, which would else follow what is missing."""
        alike = {part.name: known[part.name] for part in law.parameters if part.name in known}
        shares: tuple[float, ...] = UNSEEN_SHARES
        level: dict[str, float] = {}
        unit = own.strength.unit
        endless = [
            part.name
            for part in law.parameters
            if near and law.singular_null
            if not (part.shape or part.unit == unit or is_damping(part))
        ]
        if law.strength.unit == unit:
            strength = known[own.strength.name]
            typical = typical_value(self.data.given, law.strength)
            shares = (max(strength / typical, UNSEEN_SHARES[0]),)
            strengths = [part for part in law.parameters if not part.shape and part.unit == unit]
            level = {part.name: strength for part in strengths}
        found: list[dict[str, float]] = []
        for start in starts(self.data.given, law, self.data.fitted, shares):
            stiff = {name: STIFFER * start[name] for name in endless}
            for more in ({}, level, stiff, level | stiff):
                begun = start | more | alike
                if begun not in found:
                    found.append(begun)
        return found

    def _scan_around(self, added: Set) -> None:
        """Refit a set of which something swings at other frequencies, go on from where it is, or
        refit it from other minima, as long as that helps."""
        for _ in range(MOST_SCANS):
            before = self.answers[added]
            if self._hopped.get(added) is before or before.mean_square < SETTLED:
                break
            if not any(self._scanned(before)):
                self._hopped[added] = self.answers[added]

    def _scanned(self, before: Answer) -> Iterator[bool]:
        """Whether one way after the other has led to less; each is a piece of work of its own."""
        added = before.added
        ways = (
            partial(self._at_other_frequencies, before, EFFORT),
            partial(self._from, added, before.result.model, EFFORT),
            partial(self._from_other_minima, before, EFFORT),
        )
        for way in ways:
            if not self._tired:
                self._take({added: way}, "refitting at other frequencies")
                yield self._left(added) <= WORTH_HOPPING * before.mean_square

    def _hop_around(self, added: Set) -> None:
        first = answer = self.answers[added]
        if self._hopped.get(added) is first:
            return
        random = np.random.default_rng(0)
        starts, vain, least = self._around(answer, random), 0, answer.mean_square
        for _ in range(0, HOPS, AT_ONCE):
            if vain >= FRUITLESS or answer.mean_square < AT_NOISE or self._tired:
                break
            work = [
                ("refitting from places around", partial(self._from, added, start, HOPPING))
                for start in islice(starts, AT_ONCE)
            ]
            found = [part for part in self._at_once(work) if isinstance(part, Answer)]
            # what leaves as much as one that held-out data refuted is not judged by them again
            better = [part for part in found if part.mean_square < WORTH_HOPPING * least]
            least = min((part.mean_square for part in better), default=least)
            best = self.evidence.likeliest([answer, *better])
            if best is answer:
                vain += AT_ONCE
            else:
                answer, vain, starts = best, 0, self._around(best, random)
        if answer is not first:
            self.answers[added] = answer
            self._refit([added], "refitting from there", again=True)
        self._hopped[added] = self.answers[added]

    def _around(self, answer: Answer, random: np.random.Generator) -> Iterator[Model]:
        """Models around an answer without end: along what it leaves open, then anywhere."""
        problem, vector = answer.result.problem, answer.result.vector
        lower, upper = problem.bounds()
        _, singular, axes = np.linalg.svd(answer.result.derivatives, full_matrices=False)
        inside = (lower < vector) & (vector < upper)
        left_open = (singular < OPEN) & (np.linalg.norm(axes * inside, axis=1) > 0.5)
        steps = [step * axis for axis in axes[left_open] for step in STEPS]
        for number in count():
            if number < len(steps):
                step = steps[number]
            else:
                distance = DISTANCES[number % len(DISTANCES)]
                reach = distance / np.maximum(singular, distance / FARTHEST)
                step = axes.T @ (reach * random.standard_normal(len(reach)))
            moved = np.clip(_turned(problem.coordinates, vector + step), lower, upper)
            with suppress(ModelError):
                yield problem.model(moved)

    def _from(self, added: Set, start: Model, effort: Effort, check: Check) -> Answer:
        return refit(self.data.given, added, self.data.fitted, [start], effort, check)

    def _scouted(self, answer: Answer, added: Set, effect_id: str, check: Check) -> Answer:
        """A short refit of an answer with one more effect, begun in many places: where a joint
        sticks, hardly any of them leads to the best minimum, and none looks like it."""
        law, fitted = effects.BY_ID[effect_id], self.data.fitted
        values = list(starts(self.data.given, law, fitted, (MODERATE,)))
        spread = values[:: -(-len(values) // SPREAD)]
        own = islice(self._starts(added), OWN)
        models = [*own, *self._models_beside(answer, added, effect_id, spread)]
        effort = replace(SCOUTING, scouted=len(models))
        return refit(self.data.given, added, fitted, models, effort, check)

    def _models_beside(
        self, answer: Answer, added: Set, effect_id: str, values: Iterable[Mapping[str, float]]
    ) -> list[Model]:
        """Models of a set with an answer's parameters and these of one effect."""
        own = answer.result.model.values()
        paths = [
            {f"effects.{effect_id}.{name}": value for name, value in start.items()}
            for start in values
        ]
        return [model_with(self.data.given, added, {**own, **start}) for start in paths]


def _turned(coordinates: Coordinates, vector: Array) -> Array:
    """A vector whose angles are within half a turn of zero."""
    count = len(coordinates.paths)
    values = coordinates.values(vector[:count])
    for index, path in enumerate(coordinates.paths):
        if _is_angle(path):
            values[index] = (values[index] + np.pi) % (2.0 * np.pi) - np.pi
    return np.concatenate([coordinates.variables(values), vector[count:]])


def _is_angle(path: str) -> bool:
    section, effect_id, name = (*path.split("."), "", "")[:3]
    return section == "effects" and any(
        parameter.name == name and parameter.spread is Spread.TURN
        for parameter in effects.BY_ID[effect_id].parameters
    )
