"""Tables of a search for people: the candidates of each step, and the neighbours of the answer."""

from collections.abc import Iterable, Sequence

import numpy as np

from elastic_tendon import effects
from elastic_tendon.diagnosis.answer import Answer
from elastic_tendon.diagnosis.evidence import DECISIVE, audible, implausible_values, probabilities
from elastic_tendon.diagnosis.result import Candidate, Neighbour, Round
from elastic_tendon.diagnosis.search import Search, expected_evidence
from elastic_tendon.diagnosis.sets import Set, change_between, size_of
from elastic_tendon.identify.residuals import Array, rms

TAKEN = "taken"
LESSER = "explains less, or is less simple, than what was taken"
NOT_ENOUGH = "explains no more than its parameters cost"
ESTIMATED = 3  # candidates of a round, the best first, whose parameters get intervals
WORSE_ELSEWHERE = "makes the error on held-out data larger"
TOO_LITTLE = "explains too little for anybody to hear of it"
NO_REFIT = "the screen expects too little of it for a refit"


def round_at(search: Search, before: Set, chosen: Set) -> Round:
    """The candidates that were considered when a set was the model.

    Parameters
    ----------
    search : Search
    before : a refitted set
    chosen : ids that came in next, none where nothing did
    """
    base = search.answers[before]
    refitted = _grown(search.answers, before)
    values = search.evidence.of([base, *(search.answers[added] for added in refitted)])
    own, evidence = values[0], dict(zip(refitted, values[1:], strict=True))
    screened = [
        added
        for added in _grown(search.estimates, before)
        if added not in evidence and added not in search.failures and len(added) == len(before) + 1
    ]
    expected = {added: _expected(search, before, added) for added in screened}
    failed = _grown(search.failures, before)
    allowed = {answer.added for answer in search.allowed}
    weighed = {added: value - own for added, value in evidence.items() if added in allowed}
    weighed |= expected
    weights = probabilities([0.0, *weighed.values()])
    weight = dict.fromkeys(evidence, 0.0) | dict(zip(weighed, weights[1:], strict=True))
    told = sorted(evidence, key=lambda added: evidence[added])[:ESTIMATED]
    rows = [
        _candidate(search, before, added, weight[added], evidence, own, chosen, added in told)
        for added in evidence
    ]
    rows += [
        _screened(search, before, added, value, weight[added]) for added, value in expected.items()
    ]
    rows += [_failed(search, before, added) for added in failed]
    rows.sort(key=lambda row: (row.ids != chosen, not row.fitted, _order(row.evidence)))
    return Round(chosen, tuple(rows), _reason(rows, chosen))


def neighbours_of(search: Search, answer: Answer) -> tuple[Neighbour, ...]:
    """Sets one change away from the answer, the nearest in evidence first, then the refused."""
    allowed = {part.added for part in search.allowed}
    refitted = [added for added in search.answers if added != answer.added]
    values = search.evidence.of([answer, *(search.answers[added] for added in refitted)])
    worse: dict[Set, float | None] = {
        added: value - values[0] if added in allowed else None
        for added, value in zip(refitted, values[1:], strict=True)
    }
    # where the likeliest were refitted and disappointed, the others would not do better either
    tried = any(added in worse for added in search.neighbours)
    worse |= {
        added: max(expected, 0.0) if tried and expected else expected
        for added, expected in search.neighbours.items()
        if added not in worse
    }
    known = {
        added: value
        for added, value in worse.items()
        if value is not None and added not in search.failures
    }
    chances = probabilities([0.0, *known.values()])
    chance = dict(zip(known, chances[1:], strict=True))
    rows = [
        Neighbour(
            change=change_between(answer.added, added),
            evidence=value,
            probability=chance.get(added, 0.0),
            rmse=rmse_of(search.answers[added]) if added in search.answers else {},
            refitted=added in search.answers,
            reason=why_refused(search, added),
        )
        for added, value in worse.items()
    ]
    return tuple(sorted(rows, key=lambda row: _order(row.evidence)))


def why_refused(search: Search, added: Set) -> str:
    """Why a set cannot be the answer, "" where it can."""
    if added in search.failures:
        return search.failures[added]
    if added in search.refused:
        return search.refused[added]
    if added not in search.answers:
        return ""
    answers, answer = list(search.answers.values()), search.answers[added]
    if not audible(answer, answers):
        return TOO_LITTLE
    return "" if search.evidence.lasting(answer, answers) else WORSE_ELSEWHERE


def equivalence_classes(search: Search, answer: Answer) -> tuple[tuple[Answer, ...], ...]:
    """The answer with the refitted sets that these data cannot tell from it; none: no class."""
    others = [
        part
        for part in search.allowed
        if 0 < len(part.added) <= len(answer.added) and part.added != answer.added
    ]
    values = search.evidence.of([answer, *others])
    alike = tuple(
        part for part, value in zip(others, values[1:], strict=True) if value < values[0] + DECISIVE
    )
    return ((answer, *alike),) if alike and answer.added else ()


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


def _expected(search: Search, before: Set, added: Set) -> float:
    """What the screen expects of a set, in evidence beside another."""
    own, grown = search.estimates[before], search.estimates[added]
    facts = min(float(len(own.residuals)), search.evidence.facts([search.answers[before]]))
    left = search.answers[before].mean_square
    share, size = grown.square / own.square, size_of(added) - size_of(before)
    return expected_evidence(left, share, facts, size)


def _candidate(
    search: Search,
    before: Set,
    added: Set,
    probability: float,
    all_evidence: dict[Set, float],
    own: float,
    chosen: Set,
    told: bool,
) -> Candidate:
    answer, base = search.answers[added], search.answers[before]
    ids = tuple(effect_id for effect_id in added if effect_id not in before)
    alike = tuple(
        tuple(effect_id for effect_id in other if effect_id not in before)
        for other, value in all_evidence.items()
        if abs(value - all_evidence[added]) < DECISIVE and len(other) <= len(added)
    )
    return Candidate(
        ids=ids,
        probability=probability,
        evidence=all_evidence[added] - own,
        expected=_expected_parameters(search, added, ids),
        fitted=True,
        estimates=tuple(
            estimate
            for estimate in (answer.result.findings.estimates if told or ids == chosen else ())
            if estimate.path.split(".")[1] in ids
        ),
        gain=_gain(base.floored, answer.floored),
        heldout_gain=_gain(
            search.evidence.heldout_errors(base), search.evidence.heldout_errors(answer)
        )
        if search.evidence.heldout
        else None,
        equivalence_class=alike,
        reason=_why(search, added, all_evidence[added] - own, answer, ids == chosen),
    )


def _why(search: Search, added: Set, evidence: float, answer: Answer, taken: bool) -> str:
    if taken:
        return TAKEN
    if evidence > -DECISIVE:
        return NOT_ENOUGH
    if refusal := why_refused(search, added):
        return refusal
    if implausible := implausible_values(answer):
        return f"{LESSER}; implausible: {', '.join(implausible)}"
    return LESSER


def _screened(
    search: Search, before: Set, added: Set, expected: float, probability: float
) -> Candidate:
    ids = tuple(effect_id for effect_id in added if effect_id not in before)
    own, grown = search.estimates[before], search.estimates[added]
    return Candidate(
        ids=ids,
        probability=probability,
        evidence=expected,
        expected=_expected_parameters(search, added, ids),
        fitted=False,
        estimates=(),
        gain=1.0 - grown.square / own.square,
        heldout_gain=None,
        equivalence_class=(ids,),
        reason=NO_REFIT,
    )


def _failed(search: Search, before: Set, added: Set) -> Candidate:
    ids = tuple(effect_id for effect_id in added if effect_id not in before)
    return Candidate(
        ids=ids,
        probability=0.0,
        evidence=None,
        expected=_expected_parameters(search, added, ids),
        fitted=False,
        estimates=(),
        gain=None,
        heldout_gain=None,
        equivalence_class=(ids,),
        reason=f"could not be refitted: {search.failures[added]}",
    )


def _expected_parameters(search: Search, added: Set, ids: Set) -> dict[str, float]:
    if added not in search.estimates:
        return {}
    values = search.estimates[added].values
    starts = tuple(f"effects.{effect_id}." for effect_id in ids)
    return {path: value for path, value in values.items() if path.startswith(starts)}


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
        return "no effect explains more of the error than chance would"
    titles = " and ".join(effects.BY_ID[effect_id].title for effect_id in tried[0].ids)
    return f"no effect is surely there; the best, {titles}, {tried[0].reason}"
