"""The loop by hand: somebody else says which effect comes in next, or takes it out again.

Whatever comes in, the prior is that of the model as given: one that carries what the same data
told before would count them twice.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

from elastic_tendon.diagnosis.answer import Answer, bounded, refit
from elastic_tendon.diagnosis.candidates import prepare
from elastic_tendon.diagnosis.conclude import (
    Found,
    conclude,
    judge_what_remains,
    propose_experiment,
)
from elastic_tendon.diagnosis.inputs import smoothed
from elastic_tendon.diagnosis.learned import learn
from elastic_tendon.diagnosis.result import Candidate, Diagnosis, Round
from elastic_tendon.diagnosis.rounds import LESSER, TAKEN, Data, Outcome, starts_with
from elastic_tendon.diagnosis.screen import screen
from elastic_tendon.errors import ModelError
from elastic_tendon.identify.add import (
    Report,
    add_typical,
    check_apart,
    check_welcome,
    effect_by_id,
)
from elastic_tendon.identify.fit import THOROUGH
from elastic_tendon.measurement import Measurement
from elastic_tendon.parameters import Model

REFITTING = "refitting the parameters"
SUGGESTED = "the search would take it"
LESS_THAN_SUGGESTED = "explains less, or is less simple, than what the search would take"
BY_HAND = "taken by hand"


@dataclass(frozen=True)
class Walked:
    """A step of a walk by hand.

    `title` : what it is called. `added` : id of the effect that came in, None where none did.
    `outcome` : what was seen when the search looked on from here, None where it did not.
    """

    title: str
    added: str | None
    answer: Answer
    outcome: Outcome | None


def data_of(
    model: Model, measurements: Sequence[Measurement], validation: Sequence[Measurement]
) -> Data:
    """What a diagnosis works on, the noise of the motor's encoder taken away.

    Parameters
    ----------
    model : Model as given; its uncertainties are the prior of every step
    measurements : fitted
    validation : never fitted, only judges

    Raises
    ------
    MeasurementError : a recording is both fitted and held out
    """
    check_apart(measurements, validation)
    return Data(model, tuple(map(smoothed, measurements)), tuple(map(smoothed, validation)))


def base(data: Data, report: Report) -> Answer:
    """The model as given with its parameters refitted.

    Raises
    ------
    SimulationError : it cannot be simulated
    BuildError : the compiler refuses an effect
    """
    report(REFITTING, 0.0)
    prepare([data.given.effect_ids], report)
    return refit(data.given, (), data.fitted, progress=lambda share: report(REFITTING, share))


def with_effect(data: Data, current: Answer, effect_id: str, report: Report) -> Answer:
    """Add an effect to what was found so far, and refit.

    Parameters
    ----------
    data : Data
    current : the model so far
    effect_id : of the catalogue or of one's own, absent from the model
    report : called with words and the share of the work at hand that is done

    Returns
    -------
    Answer; never worse, in cost, than the effect at its null on the current model

    Raises
    ------
    ModelError : no such effect, or one that the model has already or cannot take
    SimulationError : not even the nulls can be simulated
    BuildError : the compiler refuses an effect
    """
    model = current.result.model
    check_welcome(model, effect_id)
    origin = model.without(current.added)
    prepare([(*origin.effect_ids, effect_id), (*model.effect_ids, effect_id)], report)
    scores = screen(current.result, origin, [effect_id], report)
    starts = [model.with_effect(effect_id, None)]
    if scores:
        starts += starts_with(data, current, effect_id, scores[0].expected)
    else:  # to first order nothing is seen of it
        starts.append(add_typical(model, effect_id))
    words = f"refitting with {effect_by_id(effect_id).title}"
    return refit(
        data.given,
        (*current.added, effect_id),
        data.fitted,
        starts,
        THOROUGH,
        lambda share: report(words, share),
    )


def again(data: Data, added: Sequence[str], model: Model, report: Report) -> Answer:
    """Refit a model that is fitted already, to these or to other data.

    Parameters
    ----------
    data : Data
    added : ids of the effects that came in since the model as given, in this order
    model : with these effects; where the fit starts
    report : called with words and the share of the work at hand that is done

    Raises
    ------
    SimulationError : it cannot be simulated
    BuildError : the compiler refuses an effect
    """
    prepare([model.effect_ids], report)
    return refit(
        data.given, added, data.fitted, [model], THOROUGH, lambda share: report(REFITTING, share)
    )


def preview(current: Model, outcome: Outcome, effect_id: str) -> Model:
    """What a model would be with a candidate of its round, before it is fitted in earnest.

    Parameters
    ----------
    current : Model that the round looked at
    outcome : of the round
    effect_id : of a candidate

    Returns
    -------
    Model; as the round fitted it, else the current one with the effect as the score expects it

    Raises
    ------
    ModelError : the round has no such candidate, or its expected numbers do not go together
    """
    for answer in outcome.refitted:
        if answer.added[-1] == effect_id:
            return answer.result.model
    expected = {one.id: one.expected for one in outcome.round.candidates}.get(effect_id)
    if expected is None:
        raise ModelError(
            effect_by_id(effect_id).title,
            ["the search knows no numbers for it on this model; add it to have it fitted"],
        )
    own = {path.rpartition(".")[2]: value for path, value in expected.items()}
    return bounded(current, effect_id, own)


def decided(one: Round, taken: str | None) -> Round:
    """A round as it went on by hand.

    Parameters
    ----------
    one : Round
    taken : id of the effect that came in then, None where none did

    Returns
    -------
    Round; what the search would have taken is told as such where it was not
    """
    if taken == one.chosen:
        return one
    words = {TAKEN: SUGGESTED, LESSER: LESS_THAN_SUGGESTED}

    def told(candidate: Candidate) -> Candidate:
        verdict = words.get(candidate.verdict, candidate.verdict)
        if candidate.id == taken:
            verdict = f"{BY_HAND}; {verdict}"
        return replace(candidate, verdict=verdict)

    return replace(one, chosen=taken, candidates=tuple(map(told, one.candidates)))


def concluded(data: Data, walk: Sequence[Walked], report: Report) -> Diagnosis:
    """The diagnosis that a walk by hand amounts to.

    It is `interrupted` unless the search looked on from the last step and found no more to add.

    Parameters
    ----------
    data : Data
    walk : steps after the model as given, the refitted one first
    report : called with words and the share of the work at hand that is done

    Returns
    -------
    Diagnosis
    """
    found = Found(path=[(one.title, one.added, one.answer) for one in walk])
    for one, following in zip(walk, [*walk[1:], None], strict=True):
        if one.outcome is not None:
            taken = None if following is None else following.added
            found.rounds.append(decided(one.outcome.round, taken))
    found.classes = _classes(walk)
    judge_what_remains(data, found, report)
    if found.unknown:
        found.learned = learn(found.answer.result, report)
    propose_experiment(data, found, report)
    last = walk[-1].outcome
    return conclude(data, found, report, last is None or last.round.chosen is not None)


def _classes(walk: Sequence[Walked]) -> list[tuple[Answer, ...]]:
    """The last effect that came in with those that the data could not tell from it then."""
    for before, after in reversed(list(pairwise(walk))):
        if after.added is None:
            continue
        if before.outcome is None:
            return []
        alike = {
            other
            for one in before.outcome.round.candidates
            if one.id == after.added
            for other in one.equivalence_class
        }
        others = (one for one in before.outcome.refitted if one.added[-1] in alike)
        return [(after.answer, *(one for one in others if one.added[-1] != after.added))]
    return []
