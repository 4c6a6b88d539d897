"""Tables of a search for people: the candidates of each step, and the neighbours of the answer."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from elastic_tendon import effects
from elastic_tendon.comparison.residuals import Array, rms
from elastic_tendon.diagnosis.answer import Answer
from elastic_tendon.diagnosis.evidence import (
    DECISIVE,
    DECISIVE_IN_PLACE,
    implausible_values,
    probabilities,
)
from elastic_tendon.diagnosis.result import Candidate, Neighbour, Round
from elastic_tendon.diagnosis.search import Search, expected_evidence
from elastic_tendon.diagnosis.sets import Set, change_between, in_order, size_of
from elastic_tendon.estimation.coordinates import parameter_of

TAKEN = "taken"
LESSER = "explains less, or is less simple, than what was taken"
NOT_ENOUGH = "explains no more than its parameters cost"
ESTIMATED = 3  # candidates of a round, the best first, whose parameters get intervals
NO_REFIT = "the screen expects too little of it for a refit"
ENDED = "the search took so long that it ended before it refitted what the screen expects most of"
IN_VAIN = "not refitted: refits of what the screen expected more of gained nothing"


def round_at(search: Search, before: Set, chosen: Set) -> Round:
    """The candidates that were considered when a set was the model.

    Sets that hold what was chosen and more are no rivals of it: they belong to later rounds, and
    their probability to what was chosen.

    Parameters
    ----------
    search : Search
    before : a refitted set
    chosen : ids that came in next, none where nothing did
    """
    taken = in_order((*before, *chosen))
    grown = _grown(search.answers, before)
    later = _grown((*grown, *search.failures), taken) if chosen else []
    refitted = [added for added in grown if added not in later]
    evidence = _evidence(search, search.answers[before], grown)
    expected, reason = _expected_beside(search, before), NO_REFIT
    if refitted and not chosen:  # those that were as likely did not do better
        expected, reason = {added: max(value, 0.0) for added, value in expected.items()}, IN_VAIN
    weight = _probabilities(_possible(search, evidence) | expected)
    weight[taken] = sum(weight.get(added, 0.0) for added in (taken, *later))
    candidates = _Candidates(search, before, evidence, weight)
    told = sorted(refitted, key=evidence.__getitem__)[:ESTIMATED]
    rows = [candidates.refitted(added, chosen, told=added in told) for added in refitted]
    rows += [candidates.screened(added, value, reason) for added, value in expected.items()]
    failed = _grown(search.failures, before)
    rows += [candidates.failed(added) for added in failed if added not in later]
    rows.sort(key=lambda row: (row.ids != chosen, not row.fitted, _order(row.evidence)))
    return Round(chosen, tuple(rows), _reason(rows, chosen))


def as_sure(entry: Round, certainty: Mapping[str, float]) -> Round:
    """A round whose chosen candidate is no likelier than the verdict has its effects."""
    sure = min((certainty[effect_id] for effect_id in entry.chosen), default=1.0)
    rows = (
        replace(row, probability=min(row.probability, sure)) if row.ids == entry.chosen else row
        for row in entry.candidates
    )
    return replace(entry, candidates=tuple(rows))


def neighbours_of(search: Search, answer: Answer) -> tuple[Neighbour, ...]:
    """Sets one change away from the answer, the nearest in evidence first, then the refused."""
    evidence = _evidence(
        search, answer, [added for added in search.answers if added != answer.added]
    )
    possible = _possible(search, evidence)
    worse: dict[Set, float | None] = {added: possible.get(added) for added in evidence}
    # where the likeliest were refitted and disappointed, the others would not do better either
    expected_of = search.neighbours.get(answer.added, {})
    tried = any(added in worse for added in expected_of)
    worse |= {
        added: max(expected, 0.0) if tried and expected else expected
        for added, expected in expected_of.items()
        if added not in worse
    }
    chance = _probabilities(
        {
            added: value
            for added, value in worse.items()
            if value is not None and added not in search.failures
        }
    )
    rows = [
        Neighbour(
            change=change,
            evidence=value,
            probability=chance.get(added, 0.0),
            rmse=rmse_of(search.answers[added]) if added in search.answers else {},
            refitted=added in search.answers,
            reason=search.why_refused(added),
        )
        for added, value in worse.items()
        if (change := change_between(answer.added, added)) is not None
    ]
    return tuple(sorted(rows, key=lambda row: _order(row.evidence)))


def answers_alike(search: Search, answer: Answer) -> tuple[Answer, ...]:
    """The answer, then the refitted sets that these data cannot tell from it; none without any."""
    others = [
        part
        for part in search.allowed
        if 0 < len(part.added) <= len(answer.added) and not set(part.added) <= set(answer.added)
    ]
    values = search.evidence.of([answer, *others], search.allowed)
    alike = tuple(
        part
        for part, value in zip(others, values[1:], strict=True)
        if value < values[0] + undecided(answer, part)
    )
    return (answer, *alike) if alike and answer.added else ()


def undecided(answer: Answer, part: Answer) -> float:
    """Difference of evidence up to which data do not tell another set from an answer; more where
    only one effect is exchanged, for one with no more parameters."""
    new = set(part.added) - set(answer.added)
    same_size = len(part.added) == len(answer.added)
    in_its_place = same_size and len(new) == 1 and part.complexity <= answer.complexity
    return DECISIVE_IN_PLACE if in_its_place else DECISIVE


def rmse_of(answer: Answer) -> dict[str, float]:
    """Root mean square error of each signal over all recordings, in its unit."""
    names = {name for part in answer.errors for name in part}
    return {
        name: rms(np.concatenate([part[name] for part in answer.errors if name in part]))
        for name in sorted(names)
    }


def _grown(sets: Iterable[Set], before: Set) -> list[Set]:
    return [added for added in sets if set(before) < set(added)]


def _order(evidence: float | None) -> float:
    return np.inf if evidence is None or not np.isfinite(evidence) else evidence


def _evidence(search: Search, base: Answer, sets: Sequence[Set]) -> dict[Set, float]:
    """Evidence of refitted sets less that of an answer."""
    answers = [base, *(search.answers[added] for added in sets)]
    own, *values = search.evidence.of(answers, search.allowed)  # the scale of the choice
    return {added: value - own for added, value in zip(sets, values, strict=True)}


def _possible(search: Search, evidence: Mapping[Set, float]) -> dict[Set, float]:
    """What of it belongs to sets that may be the answer."""
    allowed = {answer.added for answer in search.allowed}
    return {added: value for added, value in evidence.items() if added in allowed}


def _probabilities(evidence: Mapping[Set, float]) -> dict[Set, float]:
    """Of sets whose evidence is that less that of what they are held against."""
    return dict(zip(evidence, probabilities([0.0, *evidence.values()])[1:], strict=True))


def _expected_beside(search: Search, before: Set) -> dict[Set, float]:
    """What the screen expects of one effect more, where none was refitted."""
    if before not in search.estimates:  # the search was ended before it looked from there
        return {}
    known = (*search.answers, *search.failures)
    return {
        added: _expected(search, before, added)
        for added in _grown(search.estimates, before)
        if added not in known and len(added) == len(before) + 1
    }


def _expected(search: Search, before: Set, added: Set) -> float:
    """What the screen expects of a set, in evidence beside another."""
    own, grown = search.estimates[before], search.estimates[added]
    facts = min(float(len(own.residuals)), search.evidence.facts([search.answers[before]]))
    left = search.answers[before].mean_square
    share, size = grown.square / own.square, size_of(added) - size_of(before)
    return expected_evidence(left, share, facts, size)


@dataclass(frozen=True)
class _Candidates:
    """Rows of the candidates beside the set `before`.

    `evidence` : of refitted sets less its own; `probabilities` of those that may be the answer.
    """

    search: Search
    before: Set
    evidence: Mapping[Set, float]
    probabilities: Mapping[Set, float]

    def refitted(self, added: Set, chosen: Set, *, told: bool) -> Candidate:
        """`told` : whether its parameters get intervals."""
        search, row = self.search, self._row(added)
        answer, base = search.answers[added], search.answers[self.before]
        heldout_errors = search.evidence.heldout_errors
        findings = answer.result.findings.estimates if told or row.ids == chosen else ()
        return replace(
            row,
            evidence=self.evidence[added],
            fitted=True,
            fitted_parameters=tuple(
                estimate for estimate in findings if estimate.path.split(".")[1] in row.ids
            ),
            gain=_gain(base.floored, answer.floored),
            heldout_gain=_gain(heldout_errors(base), heldout_errors(answer))
            if search.evidence.heldout
            else None,
            equivalence_class=tuple(
                self._came(near)
                for near, value in self.evidence.items()
                if abs(value - self.evidence[added]) < DECISIVE and len(near) <= len(added)
            ),
            reason=TAKEN if row.ids == chosen else self._why(added, answer),
        )

    def screened(self, added: Set, expected: float, reason: str) -> Candidate:
        own, grown = self.search.estimates[self.before], self.search.estimates[added]
        gain = 1.0 - grown.square / own.square
        return replace(self._row(added), evidence=expected, gain=gain, reason=reason)

    def failed(self, added: Set) -> Candidate:
        reason = f"could not be refitted: {self.search.failures[added]}"
        return replace(self._row(added), reason=reason)

    def _row(self, added: Set) -> Candidate:
        ids = self._came(added)
        paths = tuple(f"effects.{effect_id}." for effect_id in ids)
        estimate = self.search.estimates.get(added)
        values = {} if estimate is None else estimate.values
        expected = {
            path: value
            for path, value in values.items()
            if path.startswith(paths) and path == parameter_of(path)
        }
        return Candidate(
            ids=ids,
            probability=self.probabilities.get(added, 0.0),
            expected_parameters=expected,
            equivalence_class=(ids,),
        )

    def _came(self, added: Set) -> Set:
        return tuple(effect_id for effect_id in added if effect_id not in self.before)

    def _why(self, added: Set, answer: Answer) -> str:
        """Why a refitted set was not taken."""
        if self.evidence[added] > -DECISIVE:
            return NOT_ENOUGH
        if refusal := self.search.why_refused(added):
            return refusal
        if implausible := implausible_values(answer):
            return f"{LESSER}; implausible: {', '.join(implausible)}"
        return LESSER


def _gain(before: Array, after: Array) -> float | None:
    """Share by which the sum of squares falls."""
    if not (np.isfinite(before).all() and np.isfinite(after).all()):
        return None
    return 1.0 - float(after @ after) / float(before @ before)


def _reason(rows: Sequence[Candidate], chosen: Set) -> str:
    best = next((row for row in rows if row.ids == chosen), None)
    if best is not None and best.gain is not None:
        titles = " and ".join(effects.BY_ID[effect_id].title for effect_id in chosen)
        return f"{titles} explains {100.0 * best.gain:.0f} % of the squared error"
    tried = [row for row in rows if row.fitted]
    if not tried:
        promised = min((row.evidence or 0.0 for row in rows), default=0.0) < -DECISIVE
        return ENDED if promised else "no effect explains more of the error than chance would"
    titles = " and ".join(effects.BY_ID[effect_id].title for effect_id in tried[0].ids)
    return f"no effect was taken; the best, {titles}, {tried[0].reason}"
