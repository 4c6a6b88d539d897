"""One round: screen all effects, refit the likely ones, take the best that is surely there."""

from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor, wait
from dataclasses import dataclass
from math import exp, log
from threading import Event

from elastic_tendon import effects
from elastic_tendon.diagnosis.answer import UNDECIDED, Answer, bics, facts_between, refit, starts_of
from elastic_tendon.diagnosis.candidates import candidates, prepare
from elastic_tendon.diagnosis.confirm import (
    CHANCE,
    heldout_errors,
    heldout_significance,
    refuted,
    significance,
)
from elastic_tendon.diagnosis.result import Candidate, Round
from elastic_tendon.diagnosis.screen import Score, screen
from elastic_tendon.errors import ModelError, SimulationError
from elastic_tendon.identify.add import Report
from elastic_tendon.identify.determinability import Estimate
from elastic_tendon.identify.fit import QUICK
from elastic_tendon.identify.residuals import Array
from elastic_tendon.measurement import Measurement
from elastic_tendon.parameters import Model

# a refit is worth its time where the score test expects this share of the best gain ...
PROMISING = 0.2
FEWEST, MOST = 3, 6  # ... and for so many effects at least and at most, simpler laws aside
NEAR = 0.3  # share of the chosen gain that makes a rival
MOST_RIVALS = 3
# chi-squared of the score test; a refit finds more of an effect, but not ever so much more
HOPELESS = 4.0
_AT_ONCE = 2  # refits; the compiled library lets Python go on
_PATIENCE = 0.5  # s between reports of a refit that takes long
TAKEN = "taken"
LESSER = "explains less, or is less simple, than what was taken"


@dataclass(frozen=True)
class Data:
    """What a diagnosis works on: the model as given, fitted recordings, and those that judge."""

    given: Model
    fitted: tuple[Measurement, ...]
    heldout: tuple[Measurement, ...]


@dataclass(frozen=True)
class Judged:
    """A refitted answer beside the model it would improve.

    `bic` : less that of the current model. `gain`, `heldout_gain` : shares of the squared error.
    `heldout` : errors on held-out data, see `heldout_errors`.
    """

    effect_id: str
    answer: Answer
    bic: float
    p_value: float
    gain: float
    heldout_gain: float
    heldout: Array


@dataclass(frozen=True)
class Outcome:
    """A round with the answer it chose.

    `alike` : other answers that these data cannot tell from it. `others` : those that
    explain clearly less now, but may prove better when the next effect has come in.
    `refitted` : all that were fitted.
    """

    round: Round
    chosen: Answer | None
    alike: tuple[Answer, ...]
    others: tuple[Answer, ...]
    refitted: tuple[Answer, ...]


def look(data: Data, current: Answer, report: Report) -> Outcome:
    """Find the effect that the current model misses most, if it misses any.

    Parameters
    ----------
    data : Data
    current : the model so far
    report : called with words and the share of this round that is done

    Returns
    -------
    Outcome

    Raises
    ------
    BuildError : the compiler refuses an effect
    SimulationError : the current model cannot be simulated
    """
    model = current.result.model
    origin = model.without(current.added)
    known = candidates(model, data.fitted)
    prepare([(*origin.effect_ids, one) for one in known], report)
    scores = screen(current.result, origin, known, report)
    promising = _promising(scores)
    prepare([(*model.effect_ids, one.effect_id) for one in promising], report)
    judged = _judge(data, current, _refit(data, current, promising, report))
    refusals = {one.effect_id: _refusal(one) for one in judged}
    chosen = _choose(judged, refusals)
    alike: list[Judged] = []
    others: list[Judged] = []
    if chosen is not None:
        alike = [one for one in _class_of(chosen, judged, data) if one is not chosen]
        others = [
            one
            for one in judged
            if one is not chosen and one not in alike and one.gain > NEAR * chosen.gain
        ]
    return Outcome(
        round=Round(
            chosen=None if chosen is None else chosen.effect_id,
            candidates=_table(data, scores, judged, refusals, chosen, current),
            reason=_reason(judged, refusals, chosen),
        ),
        chosen=None if chosen is None else chosen.answer,
        alike=tuple(one.answer for one in alike),
        others=tuple(one.answer for one in others[:MOST_RIVALS]),
        refitted=tuple(one.answer for one in judged),
    )


def _promising(scores: Sequence[Score]) -> list[Score]:
    worth = [one for one in sorted(scores, key=lambda one: -one.score) if one.score > HOPELESS]
    likely = [one for one in worth if one.score >= PROMISING * worth[0].score]
    taken = worth[: min(max(len(likely), FEWEST), MOST)]
    # a law is not taken before its simpler forms were tried, which may score too low
    laws = {effects.BY_ID[one.effect_id].law_of for one in taken} - {""}
    others = [one for one in scores if effects.BY_ID[one.effect_id].law_of in laws]
    return [*taken, *(one for one in others if one not in taken)]


def _refit(data: Data, current: Answer, scores: Sequence[Score], report: Report) -> list[Answer]:
    """Refit with each effect; one that cannot be simulated at its null is left out."""
    stopped = Event()

    def check(_share: float) -> None:
        if stopped.is_set():
            raise KeyboardInterrupt

    def one(score: Score) -> Answer | None:
        starts = starts_with(data, current, score.effect_id, score.expected)
        added = (*current.added, score.effect_id)
        try:
            return refit(data.given, added, data.fitted, starts, QUICK, check)
        except (SimulationError, ModelError):
            return None

    pool = ThreadPoolExecutor(_AT_ONCE)
    try:
        futures = [pool.submit(one, score) for score in scores]
        for done, future in enumerate(futures):
            words = f"refitting with {scores[done].effect_id}"
            while future not in wait([future], _PATIENCE).done:
                report(words, done / len(scores))  # whoever wants to stop it can do so here
            report(words, (done + 1) / len(scores))
    finally:  # an interrupt does not wait for fits that have not begun, nor for the rest of others
        stopped.set()
        pool.shutdown(cancel_futures=True)
    return [answer for future in futures if (answer := future.result()) is not None]


def starts_with(
    data: Data, current: Answer, effect_id: str, expected: Mapping[str, float]
) -> list[Model]:
    """Models from which a fit with one more effect may start.

    Parameters
    ----------
    data : Data
    current : the model so far
    effect_id : that comes in
    expected : its parameters by name, as the score test has them
    """
    # where effects are strong, the numbers that were refitted without them are far off
    origins = [current.result.model, _with_given_numbers(data.given, current)]
    return starts_of(origins, effect_id, expected)


def _with_given_numbers(given: Model, current: Answer) -> Model:
    """The given model with the effects found so far, as they were fitted."""
    for effect_id in current.added:
        given = given.with_effect(effect_id, current.values(effect_id))
    return given


def _judge(data: Data, current: Answer, answers: Sequence[Answer]) -> list[Judged]:
    """Answers in the order of their BIC, the best first."""
    base, *others = bics([current, *answers])
    heldout = heldout_errors(current, data.heldout)
    judged = []
    for answer, bic in zip(answers, others, strict=True):
        after = heldout_errors(answer, data.heldout)
        p_value = significance(current, answer, answer.added[-1])
        if data.heldout:  # either kind of data may convince; that there are two is paid for
            p_value = min(p_value, heldout_significance(heldout, after, data.heldout))
            p_value = min(1.0, 2.0 * p_value)
        judged.append(
            Judged(
                effect_id=answer.added[-1],
                answer=answer,
                bic=bic - base,
                p_value=p_value,
                gain=1.0 - _squares(answer.floored) / _squares(current.floored),
                heldout_gain=1.0 - _squares(after) / _squares(heldout),
                heldout=after,
            )
        )
    return sorted(judged, key=lambda one: one.bic)


def _squares(errors: Array) -> float:
    return float(errors @ errors)


def _refusal(one: Judged) -> str:
    """Why an effect cannot be taken, "" where it can."""
    if one.bic > -UNDECIDED:
        return "explains no more than its parameters cost"
    if one.heldout_gain <= 0.0:
        return "makes the error on held-out data larger"
    if one.p_value > CHANCE:
        return f"may be chance, p = {one.p_value:.2g}"
    return ""


def _choose(judged: Sequence[Judged], refusals: Mapping[str, str]) -> Judged | None:
    """The simplest of those that cannot be told from the best.

    What held-out data speak against is out of the race. But where the best of the others may be
    chance, one that explains clearly less is not taken in its place.
    """
    lasting = [one for one in judged if one.heldout_gain > 0.0]
    alike = [one for one in lasting if one.bic - lasting[0].bic < UNDECIDED]
    allowed = [one for one in alike if not refusals[one.effect_id]]
    if not allowed:
        return None
    order = effects.BY_ID.ids()  # the catalogue begins with what is most common
    return min(allowed, key=lambda one: (one.answer.complexity, order.index(one.effect_id)))


def _class_of(one: Judged, judged: Sequence[Judged], data: Data) -> list[Judged]:
    """Those that neither fitted nor held-out data tell from it."""
    return [
        other
        for other in judged
        if abs(other.bic - one.bic) < UNDECIDED
        and not refuted(other.heldout, one.heldout, data.heldout or data.fitted)
    ]


def _reason(judged: Sequence[Judged], refusals: Mapping[str, str], chosen: Judged | None) -> str:
    if chosen is not None:
        title = effects.BY_ID[chosen.effect_id].title
        return f"{title} explains {100.0 * chosen.gain:.0f} % of the squared error"
    if not judged:
        return "no effect explains more of the error than chance would"
    best = judged[0]
    title = effects.BY_ID[best.effect_id].title
    return f"no effect is surely there; the best, {title}, {refusals[best.effect_id]}"


def _table(
    data: Data,
    scores: Sequence[Score],
    judged: Sequence[Judged],
    refusals: Mapping[str, str],
    chosen: Judged | None,
    current: Answer,
) -> tuple[Candidate, ...]:
    """All candidates: what was taken, then by likelihood; those that were not refitted last."""
    probabilities = _probabilities(scores, judged, current)
    by_id = {one.effect_id: one for one in scores}
    ranked = sorted(judged, key=lambda one: one is not chosen)
    rows = [
        Candidate(
            id=one.effect_id,
            kind="effect",
            score=by_id[one.effect_id].score,
            probability=probabilities[one.effect_id],
            expected=_paths(by_id[one.effect_id]),
            fitted=_estimates(one),
            p_value=one.p_value,
            gain=one.gain,
            heldout_gain=one.heldout_gain,
            equivalence_class=tuple(other.effect_id for other in _class_of(one, judged, data)),
            verdict=TAKEN if one is chosen else refusals[one.effect_id] or LESSER,
        )
        for one in ranked
    ]
    refitted = {one.effect_id for one in judged}
    rest = [one for one in by_id.values() if one.effect_id not in refitted]
    return (*rows, *(_unfitted(one, probabilities[one.effect_id]) for one in rest))


def _unfitted(score: Score, probability: float) -> Candidate:
    return Candidate(
        id=score.effect_id,
        kind="effect",
        score=score.score,
        probability=probability,
        expected=_paths(score),
        fitted=(),
        p_value=None,
        gain=score.gain,
        heldout_gain=None,
        equivalence_class=(score.effect_id,),
        verdict="the score test expects too little of it for a refit",
    )


def _paths(score: Score) -> dict[str, float]:
    return {f"effects.{score.effect_id}.{name}": value for name, value in score.expected.items()}


def _estimates(one: Judged) -> tuple[Estimate, ...]:
    own = f"effects.{one.effect_id}."
    found = one.answer.result.findings.estimates
    return tuple(estimate for estimate in found if estimate.path.startswith(own))


def _probabilities(
    scores: Sequence[Score], judged: Sequence[Judged], current: Answer
) -> dict[str, float]:
    """Weight exp(-BIC / 2) of each effect among all and the current model; by the score where
    there is no refit."""
    facts = max([facts_between(current, one.answer) for one in judged], default=2.0)
    bic = {
        one.effect_id: len(effects.BY_ID[one.effect_id].parameters) * log(facts) - one.score
        for one in scores
    }
    bic |= {one.effect_id: one.bic for one in judged}
    least = min([0.0, *bic.values()])
    weights = {name: exp(-0.5 * (value - least)) for name, value in bic.items()}
    total = sum(weights.values()) + exp(0.5 * least)  # the current model has a BIC of 0
    return {name: weight / total for name, weight in weights.items()}
