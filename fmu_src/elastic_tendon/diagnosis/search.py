"""The search: sets of effects from the screen, refits of the likely ones, until no neighbour wins.

Every set is scored by the screen first (`torque_screen`); few deserve a refit of the whole
trajectory, which starts at the screen's own estimates. An answer is final when no addition,
removal, exchange or simpler law among its neighbours does better (`evidence`), refits from places
around it included, or when enough was simulated (`refits.MOST_WORK`).
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import filterfalse
from math import log

import numpy as np

from elastic_tendon.actuator.parameters import Model
from elastic_tendon.diagnosis.answer import Answer
from elastic_tendon.diagnosis.data import Data
from elastic_tendon.diagnosis.detours import FIRST, REFITTED, Detours
from elastic_tendon.diagnosis.evidence import (
    DECISIVE,
    DECISIVE_IN_PLACE,
    MUCH,
    Evidence,
    misfit,
    worth_hearing,
)
from elastic_tendon.diagnosis.likeliest_sets import CLOSE, FOLLOWED
from elastic_tendon.diagnosis.looks import WORTH
from elastic_tendon.diagnosis.refits import AT_ONCE, MOST_WORK
from elastic_tendon.diagnosis.resonance import holds_swinging, swings
from elastic_tendon.diagnosis.sets import (
    Set,
    aliases,
    in_order,
    model_with,
    richer,
    simpler,
    size_of,
    without,
)
from elastic_tendon.diagnosis.torque_screen import Screen
from elastic_tendon.diagnosis.trajectory_screen import TrajectoryScreen
from elastic_tendon.errors import ElasticTendonError
from elastic_tendon.estimation.stretches import independent_facts
from elastic_tendon.progress import Progress
from elastic_tendon.simulation.work import AFFORDABLE

TRUSTED = 2.0  # mean square on the torque screen of an answer that leaves nothing but noise
LOOKED = 6  # sets with one more effect that are estimated beside the best
FEW = 2  # neighbours that promise more, refitted in one round at the noise ...
EQUALS = 2  # ... and those that promise about as much with no more parameters
ABOUT = 100.0  # evidence by which these may seem worse on the screen, where facts are few
LONG = 3e8  # multiplications after which a search that is not at the noise has lasted long
SMALL = 25.0  # mean square of an error that is hardly larger than noise: torques hide it
MOST_ROUNDS, MOST_REFITS = 8, 20
AFTER_TIME = 3  # rounds more, where time is up and an addition promises to leave half
BLIND = 10.0  # times the mean square of the trajectory that the torque screen leaves there


@dataclass(kw_only=True)
class Search(Detours):
    """What a search has so far; an interrupt leaves it as it is."""

    @classmethod
    def of(cls, data: Data, progress: Progress) -> "Search":
        """A search that has not begun."""
        progress("reading the motion", 0.0)
        return cls(
            data=data,
            progress=progress,
            screen=Screen(data.given, data.motions),
            evidence=Evidence(data.heldout),
        )

    # ---- the loop ----------------------------------------------------------------------------

    def settle(self) -> None:
        """From where the climb ended to an answer that no neighbour beats."""
        self.limit = MOST_WORK
        while True:
            if not (self._at_noise() or self._tired or self._disturbed()):
                self._follow_neighbours(np.inf)
                if self._hop():
                    continue
            if self._better_detour() or self._doubted() or self._fades_in_time():
                continue
            if self._warned_of():
                continue
            if not self._explained_by_rare():
                break
            self._follow_neighbours(np.inf)
        self._after_time()
        added = self.answer.added
        if self.work > MOST_WORK and added not in self.neighbours:
            self.neighbours[added] = self._expected(added, self._neighbours(added))

    def _after_time(self) -> None:
        """Where so much was simulated that the search ends: refit a neighbour all the same that
        promises to leave half, a few times."""
        for _ in range(AFTER_TIME):
            if not self._tired:
                return
            added = self.answer.added
            shares = self._neighbours(added)
            self.neighbours[added] = self._expected(added, shares)
            self.limit = self.work + AFFORDABLE
            if not self._half_gone(added, shares, np.inf):
                return
            while self._doubted() or self._fades_in_time():
                pass

    def climb(self) -> Iterator[None]:
        """From the base to sets whose neighbours do worse, with refits from places around them.

        Yields
        ------
        where the answer may be another than before
        """
        if not self._at_noise():
            yield from self._first_answer()
        self._explained_at_once_by_rare()
        for _ in range(MOST_ROUNDS):
            self._follow_neighbours()
            yield
            if self._tired or (self._disturbed() and not self.answer.added):
                break
            if self._hop():  # an effect that is not where it belongs leaves much that is shapeless
                continue
            if self._disturbed():
                break
            if not (
                self._better_law()
                or self._doubted()
                or self._better_addition()
                or self._better_single()
            ):
                return

    def _first_answer(self) -> Iterator[None]:
        """The likeliest single effect, then the likeliest pair and three effects, refitted."""
        ids = self._screened()
        self._screen_singles(ids, None)
        better_base = self._better_base()
        self._refit_in_turn(self._best_single())
        if self.answer.mean_square > FIRST * self._left(()):  # else it comes beside what was found
            self._better_ringing(())
        yield
        if self._disturbed() and not self.answer.added:
            return
        if better_base and not self._at_noise():
            self._screen_singles(ids, self.estimates[()].values)
        if not self._at_noise():
            self._refit_in_turn([*self._best_pair(ids), *self._best_single()])
            yield
        self._better_law()
        if self.answer.mean_square > MUCH:  # three effects leave more where none is found
            self._refit_in_turn(self._best_three())
            yield

    def base(self) -> None:
        """The model as given, its parameters refitted."""
        self.estimates[()] = self.screen.fit((), {}, 8)
        self._refit([()], "refitting the parameters")
        if () not in self.answers:
            raise ElasticTendonError(self.failures[()])

    def begin_at(self, answer: Answer) -> None:
        """Refit what was found on other data, so that the climb starts from there."""
        added = in_order(answer.added)
        self.starts[added] = [answer.result.model]
        self._refit([added], "refitting what was found")

    def exchange_alike(self, before: Set, alike: Iterable[Set]) -> None:
        """Refit what other data did not tell from a set, and what came to that since beside it."""
        further = set(self.answer.added) - set(before)
        if set(before) <= set(self.answer.added):
            sets = [in_order({*added, *further}) for added in alike]
            self._refit(sets, "refitting what was not told apart")

    def look_on_from(self, answer: Answer) -> None:
        """One round by hand: additions to a model that somebody chose, the likeliest refitted."""
        added = in_order(answer.added)
        self.answers[added] = answer
        self._screen_singles(self._screened(), None)
        own = self._own(added)
        self.progress("looking at what could do better", 0.0)
        others = [effect_id for effect_id in self._screened() if effect_id not in added]
        found, _ = self.screen.combined(own, others, len(others))
        self._keep([own, *found.values()])
        grown = sorted(found, key=self._badness)[:REFITTED]
        forms = [form for near in grown for form in self._simpler(near) if set(added) < set(form)]
        self._refit(list(dict.fromkeys([*grown, *forms])), "refitting the likeliest")
        if not self._at_noise():
            likely = [
                near for near, left in self._looks(added, self._unseen()).items() if left < WORTH
            ]
            self._refit(likely, "refitting what only the motion shows")

    def starts_beside(self, answer: Answer, effect_id: str) -> list[Model]:
        """Where a refit with one more effect may begin: the screen's estimate beside an answer."""
        added = in_order((*answer.added, effect_id))
        if not self.screen.sees(effect_id):
            self.answers[in_order(answer.added)] = answer
            self._looks(in_order(answer.added), [effect_id])
            return list(self._starts(added))
        self.screen.single(effect_id)
        found, _ = self.screen.combined(self._estimate(answer), [effect_id], 1)
        self._keep(found.values())
        return list(self._starts(added))

    def _refit_in_turn(self, short: Sequence[Set]) -> None:
        """Refit what is likeliest, until the rest cannot win any more."""
        for start in range(0, len(short), AT_ONCE):
            if self._at_noise():
                return
            self._refit(short[start : start + AT_ONCE], "refitting the likeliest sets")

    def _follow_neighbours(self, most: float = MOST_REFITS) -> None:
        """Refit neighbours of the best until it stays the best, or so many sets are refitted.

        What is dear comes last: what swings, and then refits of every addition. Where long
        work leaves more than noise, the catalogue may lack something, and what does not last is not
        built upon.
        """
        for _ in range(MOST_ROUNDS):
            self._tune()
            while self._doubtful() and (self._errs_as_refused() or self._fades_in_time()):
                self._tune()
            self._refit_on()
            self._hop_on_screen()
            dear = holds_swinging(self.answer.added)  # beside it other laws come last
            if self._better_with_less() or (not dear and self._better_law()):
                continue
            added = self.answer.added
            shares = self._neighbours(added)
            self.neighbours[added] = self._expected(added, shares)
            if self._half_gone(added, shares, most):
                continue
            if any(better() for better in self._tries(added, most)):
                continue
            if swinging := self._swinging(added):
                self.neighbours[added] = self._expected(added, shares | swinging)
            if not self._promised(added, most):
                return

    def _doubtful(self) -> bool:
        """Whether the search has lasted so long that what it found is doubted on the way."""
        return self.work > LONG and not self._tired

    def _tries(self, added: Set, most: float) -> list[Callable[[], bool]]:
        """Ways from a set to a better one, the likeliest first: what torques promise, unless they
        mislead; what swings, before that where something rings; then every addition."""
        screened = partial(self._promised, added, most)
        ringing = partial(self._better_ringing, added)
        if self._blind(added) and not self._promises(added):
            return [ringing, self._better_with_two, self._affordable_addition, screened]
        if self._rings(added):
            return [ringing, screened, self._better_with_two, self._affordable_addition]
        return [screened, ringing, self._better_with_two, self._affordable_addition]

    def _blind(self, added: Set) -> bool:
        """Whether the torque screen errs so much more than the trajectory that what it promises is
        worth little."""
        return self._own(added).square > BLIND * self.answer.mean_square

    def _swinging(self, added: Set) -> dict[Set, float]:
        """What additions that swing would leave, unless nothing is left or time for it."""
        if self._at_noise() or self._tired:
            return {}
        return self._looks(added, filter(swings, self.data.candidates))

    def _half_gone(self, added: Set, shares: Mapping[Set, float | None], most: float) -> bool:
        """Refit neighbours if one of them promises to leave half; whether the best has changed."""
        untried = [near for near in shares if near not in {*self.answers, *self.failures}]
        half = any((shares[near] or 1.0) <= FIRST for near in untried)
        return half and self._promised(added, most)

    def _promised(self, added: Set, most: float) -> bool:
        """Refit the neighbours of a set that may do better, unless enough was refitted; whether the
        best has changed."""
        if self._tired or len(self.answers) >= most:
            return False
        chosen = list(self._promising(added))
        turn = AT_ONCE if self._weary else max(len(chosen), 1)
        for start in range(0, len(chosen), turn):
            if not self._tired:
                self._refit(chosen[start : start + turn], "refitting what may do better")
        return self.answer.added != added

    def ladder(self, *, refit: bool) -> list[Set]:
        """Sets from the first effect to the answer, each with one more, the best first.

        Parameters
        ----------
        refit : also what is missing on the way; else a step may bring several effects
        """
        whole = self.answer.added
        ladder = [whole] if whole else []
        while ladder and len(ladder[0]) > 1:
            fewer = [without(ladder[0], effect_id) for effect_id in ladder[0]]
            fewer.sort(key=self._badness)
            known = [added for added in fewer if added in self.answers]
            if refit and not known:
                self._refit(fewer[:1], "refitting the way to the answer")
                known = [added for added in fewer if added in self.answers]
            if not known:
                break
            ladder.insert(0, min(known, key=lambda added: self.answers[added].mean_square))
        return ladder

    # ---- neighbours ---------------------------------------------------------------------------

    def _neighbours(self, added: Set) -> dict[Set, float | None]:
        """Share of the mean square that every addition, removal, exchange and simpler law would
        leave, None where the screens cannot say; looks at what swings come later."""
        self.progress("looking at what could do better", 0.0)
        at_noise = self._at_noise()
        shares: dict[Set, float | None] = {}
        if self._trusted(added):
            shares |= self._screened_neighbours(added)
            unlooked = self._unseen()
        else:
            if at_noise:
                shares |= self._hardly_worse(added)
            shares |= dict.fromkeys(self._exchanges_by_torque(added))
            shares |= {without(added, effect_id): None for effect_id in added}
            shares |= dict.fromkeys(self._simpler(added))
            unlooked = list(self.data.candidates)
        if self._tired:
            return shares
        if not at_noise:
            return {**shares, **self._looks(added, filterfalse(swings, unlooked))}
        # what is as small as noise shows in trajectories, or else in torques
        looks = {} if self._white(self.answers[added]) else self._looks(added, self._quick)
        left = self._left(added)
        heard = any(worth_hearing(left, share * left) for share in looks.values())
        shares = {**shares, **looks} if heard else {**looks, **shares}
        return shares | self._exchanges(added, self._quick)

    def _exchanges(self, added: Set, effect_ids: Sequence[str]) -> dict[Set, float]:
        """Share of the mean square that sets with one other effect would leave, as trajectories
        have it; only where what they have in common was refitted, and leaves little."""
        shares: dict[Set, float] = {}
        for effect_id in added:
            less = without(added, effect_id)
            if less in self.answers and self._left(less) < SMALL:
                looks = self._looks(less, effect_ids)
                # looks from far away promise too little: alike of rivals and of what they rival
                own = looks.pop(added, self._left(added) / self._left(less))
                shares |= {near: share / own for near, share in looks.items()}
        return shares

    def _exchanges_by_torque(self, added: Set) -> list[Set]:
        """The likeliest sets with another of the effects that torques show, where they do not show
        all: of those that seemed about as likely without the rest, what trajectories bear best."""
        answer, seen = self.answers[added], tuple(filter(self.screen.sees, added))
        screen, laws = TrajectoryScreen(answer), {*simpler(seen), *richer(seen)}
        looks: dict[Set, float] = {}
        for near, expected in self.neighbours.get(seen, {}).items():
            exchanged = len(near) == len(seen) and near not in laws and near in self.estimates
            if not exchanged or expected is None or expected > self._about(added):
                continue
            whole = in_order((*near, *(set(added) - set(seen))))
            new = self._of_effects(self.estimates[near].values, tuple(set(near) - set(seen)))
            start = model_with(self.data.given, whole, {**answer.result.model.values(), **new})
            for share, model in screen.beside([start]):
                looks[whole], self.starts[whole] = share, [model]
        return sorted(looks, key=looks.__getitem__)[:EQUALS]

    def _expected(self, added: Set, shares: Mapping[Set, float | None]) -> dict[Set, float | None]:
        """Evidence of neighbours less that of a set, the most promising first."""
        facts = self._facts_beside(added, shares)
        left, size = self._left(added), size_of(added)
        found = {
            near: None
            if share is None
            else expected_evidence(left, share, facts, size_of(near) - size)
            for near, share in shares.items()
        }
        return dict(sorted(found.items(), key=lambda pair: pair[1] or 0.0))

    def _facts_beside(self, added: Set, shares: Mapping[Set, float | None]) -> float:
        """Number of independent facts that errors hold, of a set or with its best neighbour: what
        one effect leaves hangs together, and is worth more facts once that is explained."""
        answer = self.answers[added]
        facts = self.evidence.facts([answer])
        likely = [near for near in self.starts if (shares.get(near) or 1.0) < 1.0]
        if not likely:
            return facts
        best = min(likely, key=lambda near: shares[near] or 0.0)
        left = TrajectoryScreen(answer).left(self.starts[best][0])
        if left is None:
            return facts
        return max(facts, independent_facts(answer.result.model, self.data.fitted, left))

    def _trusted(self, added: Set) -> bool:
        """Whether the torque screen can tell neighbours of a set: it sees all of its effects, and
        shows no error of its own where the trajectory has none."""
        if not all(self.screen.sees(effect_id) for effect_id in added):
            return False
        return not self._at_noise() or self._own(added).square < TRUSTED

    def _hardly_worse(self, added: Set) -> dict[Set, float]:
        """Additions and exchanges where nothing is left, though the torque screen still errs."""
        if not all(self.screen.sees(effect_id) for effect_id in added):
            return {}
        own, screen = self._own(added), self.screen
        less = [without(added, effect_id) for effect_id in added]
        origins = [own, *(screen.fit(part, own.values, 6) for part in less)]
        shares: dict[Set, float] = {}
        for origin in origins:
            others = [effect_id for effect_id in self._screened() if effect_id not in origin.added]
            _, looked = screen.combined(origin, others, 0)
            shares |= {near: max(look.square / own.square, 1.0) for near, look in looked.items()}
        shares.pop(added, None)
        return shares

    def _screened_neighbours(self, added: Set) -> dict[Set, float]:
        """Share of the mean square that neighbours would leave, as the torque screen has it."""
        screen, seen = self.screen, self._screened()
        own, refitted = self._own(added), self.answers[added].result.model.values()
        origins = [(added, own)]
        for effect_id in added:
            less = without(added, effect_id)
            origins.append((less, screen.fit(less, own.values, 6)))
        origins += [(low, screen.followed(low, own.values)) for low in self._simpler(added)]
        self._keep([own, *(estimate for _, estimate in origins)])
        looks: dict[Set, float] = {estimate.added: estimate.square for _, estimate in origins}
        for number, (origin, estimate) in enumerate(origins):
            self.progress("looking at what could do better", number / len(origins))
            others = [effect_id for effect_id in seen if effect_id not in origin]
            most = LOOKED if origin == added else FOLLOWED
            found, looked = screen.combined(estimate, others, most, anew=origin == added)
            self._keep(found.values())
            for near, look in looked.items():
                start = {**look.start, **(refitted if origin == added else {})}
                self.starts[near] = [model_with(self.data.given, near, start)]
            expected = {near: look.square for near, look in looked.items()}
            looks = {**expected, **looks, **{near: part.square for near, part in found.items()}}
        looks.pop(added)
        return {near: square / own.square for near, square in looks.items()}

    def _about(self, added: Set) -> float:
        """Evidence by which a neighbour of a set may seem worse on the screen and be better."""
        return max(ABOUT, self.evidence.facts([self.answers[added]]) * log(CLOSE))

    def _promising(self, added: Set) -> Iterator[Set]:
        """Neighbours that deserve a refit."""
        fresh = [
            (near, expected)
            for near, expected in self.neighbours[added].items()
            if near not in self.answers and near not in self.failures
        ]
        scored = [(near, expected) for near, expected in fresh if expected is not None]
        at_noise = self._at_noise()
        most, enough = (FEW, -DECISIVE) if at_noise else (REFITTED, 0.0)
        better = [near for near, expected in scored if expected < enough][:most]
        worst = DECISIVE_IN_PLACE if at_noise else self._about(added)
        equal = [
            near
            for near, expected in scored
            if expected < worst and size_of(near) <= size_of(added) and near not in better
        ][:EQUALS]
        alike = [near for near in aliases(added) if near in dict(scored)]
        yield from dict.fromkeys((*better, *equal, *alike))
        yield from (near for near, expected in fresh if expected is None)


def expected_evidence(before: float, share: float, facts: float, size: int) -> float:
    """Evidence that the screen expects of a change; one that nobody would hear of does no better.

    Parameters
    ----------
    before : mean square before it, in units of the noise's
    share : of that which is left
    facts : number of independent facts
    size : number of parameters that come in
    """
    value = facts * (misfit(max(share * before, 1e-9)) - misfit(before)) + log(facts) * size
    return value if worth_hearing(before, share * before) else max(value, 0.0)
