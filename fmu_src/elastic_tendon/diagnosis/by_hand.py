"""The loop by hand: somebody else says which effect comes in next, or takes it out again.

Whatever comes in, the prior is that of the model as given: one that carries what the same data
told before would count them twice.
"""

from collections.abc import Callable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, replace

from elastic_tendon.actuator.parameters import Model, model_from_toml
from elastic_tendon.diagnosis.answer import Answer, bounded, refit
from elastic_tendon.diagnosis.conclude import (
    Found,
    conclude,
    different,
    experiment_between,
    judge,
)
from elastic_tendon.diagnosis.data import Data
from elastic_tendon.diagnosis.options import Options
from elastic_tendon.diagnosis.result import Candidate, Diagnosis, Experiment, Round
from elastic_tendon.diagnosis.rounds import LESSER, TAKEN, answers_alike, round_at
from elastic_tendon.diagnosis.search import Search
from elastic_tendon.diagnosis.sets import in_order
from elastic_tendon.errors import ModelError
from elastic_tendon.estimation.add import check_welcome, effect_by_id
from elastic_tendon.estimation.fit import THOROUGH
from elastic_tendon.native.library import library_path
from elastic_tendon.progress import Enough, Progress

REFITTING = "refitting the parameters"
SUGGESTED = "the search would take it"
LESS_THAN_SUGGESTED = "explains less, or is less simple, than what the search would take"
BY_HAND = "taken by hand"


@dataclass(frozen=True)
class Outcome:
    """A round, and the search behind it; not `complete` where that was ended early."""

    round: Round
    search: Search
    complete: bool = True


@dataclass(frozen=True)
class Ranked:
    """A round and what it refitted, as text: all of a search that people look at.

    `models` : for each effect that was refitted alone, the TOML text of the model with it.
    `complete` : of the search.
    """

    round: Round
    models: Mapping[str, str]
    complete: bool = True


SoFar = Callable[[Ranked], object]  # is given what a search has found by now


@dataclass(frozen=True)
class LeftOpen:
    """Sets of effects that these data do not tell apart, the one taken first; none where they do.

    `complete` : of the search that found them.
    """

    sets: tuple[tuple[str, ...], ...]
    complete: bool

    @property
    def names(self) -> list[str]:
        """What tells them apart; "+" between the ids of a set."""
        return different(self.sets)

    @property
    def shared(self) -> frozenset[str]:
        """Effects that all of them have."""
        return frozenset.intersection(*map(frozenset, self.sets))


@dataclass(frozen=True)
class Proposed:
    """What came of seeking an experiment that decides; `reason` : why there is none, else ""."""

    experiment: Experiment | None
    reason: str


@dataclass(frozen=True)
class Walked:
    """A step of a walk by hand.

    `title` : what it is called. `added` : id of the effect that came in, None where none did.
    `outcome` : the search's next round from here, None where there was none.
    """

    title: str
    added: str | None
    answer: Answer
    outcome: Outcome | None


def base(data: Data, progress: Progress) -> Answer:
    """The model as given with its parameters refitted.

    Raises
    ------
    SimulationError : it cannot be simulated
    BuildError : the compiler refuses an effect
    """
    return _refitted(data, (), [], REFITTING, progress)


def next_round(
    data: Data,
    current: Answer,
    progress: Progress,
    so_far: SoFar | None = None,
) -> Outcome:
    """The round that the search makes from a model: every single effect is screened, the likeliest
    are refitted, nothing is added.

    Parameters
    ----------
    data : Data
    current : the model so far
    progress : called with words and the share of the work at hand that is done; where it raises
        `Enough`, the round is made of what was refitted by then
    so_far : called with what is known, whenever more is

    Raises
    ------
    BuildError : the compiler refuses an effect
    SimulationError : the current model cannot be simulated
    """
    search = Search.of(data, progress)
    if so_far is not None:
        search.progress = _telling(search, current, progress, so_far)
    try:
        search.look_on_from(current)
    except Enough:
        return Outcome(_round(search, current), search, complete=False)
    return Outcome(_round(search, current), search)


def _round(search: Search, current: Answer) -> Round:
    came = tuple(effect_id for effect_id in search.answer.added if effect_id not in current.added)
    return round_at(search, in_order(current.added), came)


def _telling(search: Search, current: Answer, progress: Progress, so_far: SoFar) -> Progress:
    """Progress that tells what was found so far too, whenever sets were refitted."""
    told = 1  # the current model, which is an answer from the beginning

    def telling(words: str, share: float) -> None:
        nonlocal told
        progress(words, share)
        if len(search.answers) > told:
            told = len(search.answers)
            so_far(ranked(current.result.model, Outcome(_round(search, current), search, False)))

    return telling


def with_effect(data: Data, current: Answer, effect_id: str, progress: Progress) -> Answer:
    """Add an effect to what was found so far, and refit.

    Parameters
    ----------
    data : Data
    current : the model so far
    effect_id : of the catalogue or of one's own, absent from the model
    progress : called with words and the share of the work at hand that is done

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
    search = Search.of(data, progress)
    added = in_order((*current.added, effect_id))
    progress(f"screening {effect_by_id(effect_id).title}", 0.0)
    starts = [model.with_effect(effect_id, None), *search.starts_beside(current, effect_id)]
    words = f"refitting with {effect_by_id(effect_id).title}"
    return _refitted(data, added, starts, words, progress)


def again(data: Data, added: Sequence[str], model: Model, progress: Progress) -> Answer:
    """Refit a model that is fitted already, to these or to other data.

    Parameters
    ----------
    data : Data
    added : ids of the effects that came in since the model as given, in this order
    model : with these effects; where the fit starts
    progress : called with words and the share of the work at hand that is done

    Raises
    ------
    SimulationError : it cannot be simulated
    BuildError : the compiler refuses an effect
    """
    return _refitted(data, added, [model], REFITTING, progress)


def _refitted(
    data: Data, added: Sequence[str], starts: Sequence[Model], words: str, progress: Progress
) -> Answer:
    progress(words, 0.0)
    library_path((*data.given.effect_ids, *added), data.given.kind, progress)
    return refit(
        data.given, added, data.fitted, starts, THOROUGH, lambda share: progress(words, share)
    )


def ranked(current: Model, outcome: Outcome) -> Ranked:
    """What people look at of a search that looked on from a model."""
    models: dict[str, str] = {}
    for added, answer in outcome.search.answers.items():
        came = set(added) - set(current.effect_ids)
        if len(came) == 1:
            models.setdefault(came.pop(), answer.result.model.to_toml())
    return Ranked(outcome.round, models, outcome.complete)


def preview(current: Model, found: Ranked, effect_id: str) -> Model:
    """What a model would be with a candidate of its round, before it is fitted in earnest.

    Parameters
    ----------
    current : Model from which the round was made
    found : of the round
    effect_id : of a candidate

    Returns
    -------
    Model; as the round fitted it, else the current one with the effect as the screen expects it

    Raises
    ------
    ModelError : the round has no such candidate, or its expected values do not go together
    """
    if effect_id in found.models:
        return model_from_toml(found.models[effect_id], current.name)
    expected = {row.ids: row.expected_parameters for row in found.round.candidates}.get(
        (effect_id,)
    )
    if not expected:
        raise ModelError(
            effect_by_id(effect_id).title,
            ["the search knows no parameters for it on this model; add it to have it fitted"],
        )
    own = {path.rpartition(".")[2]: value for path, value in expected.items()}
    return bounded(current, effect_id, own)


def decided(found: Round, taken: str | None) -> Round:
    """A round as it went on by hand.

    Parameters
    ----------
    found : Round
    taken : id of the effect that came in then, None where none did

    Returns
    -------
    Round; what the search would have taken is told as such where it was not
    """
    chosen = () if taken is None else (taken,)
    if chosen == found.chosen:
        return found

    def told(candidate: Candidate) -> Candidate:
        reason = candidate.reason.replace(LESSER, LESS_THAN_SUGGESTED)
        if reason == TAKEN:
            reason = SUGGESTED
        if candidate.ids == chosen:
            reason = f"{BY_HAND}; {reason}"
        return replace(candidate, reason=reason)

    return replace(found, chosen=chosen, candidates=tuple(map(told, found.candidates)))


def concluded(data: Data, walk: Sequence[Walked], progress: Progress) -> Diagnosis:
    """The diagnosis that a walk by hand amounts to.

    It is complete where the search made a round from the last step and found no more to add.

    Parameters
    ----------
    data : Data
    walk : steps after the model as given, the refitted one first
    progress : called with words and the share of the work at hand that is done

    Returns
    -------
    Diagnosis
    """
    last = walk[-1].outcome
    search = _whole_search(data, walk, progress)
    found = Found(ladder=[(step.title, step.added, step.answer) for step in walk])
    for step, following in zip(walk, [*walk[1:], None], strict=True):
        if step.outcome is not None:
            taken = None if following is None else following.added
            found.rounds.append(decided(step.outcome.round, taken))
    found.alike = answers_alike(search, walk[-1].answer)
    options = Options()
    judge(data, search, found, options, progress)
    complete = last is not None and last.complete and not last.round.chosen
    return conclude(data, search, found, options, progress, complete=complete)


def left_open(data: Data, walk: Sequence[Walked], progress: Progress) -> LeftOpen:
    """What a walk by hand leaves open.

    Parameters
    ----------
    data, progress : as of `concluded`
    walk : as of `concluded`; the search looked on from its last step
    """
    alike = _alike(data, walk, progress)
    last = walk[-1].outcome
    return LeftOpen(
        tuple(answer.added for answer in alike), complete=last is not None and last.complete
    )


def proposed(data: Data, walk: Sequence[Walked], progress: Progress) -> Proposed:
    """The experiment that decides between what a walk by hand leaves open; see `left_open`."""
    proposal = experiment_between(_alike(data, walk, progress), {}, progress)
    return Proposed(None, proposal) if isinstance(proposal, str) else Proposed(proposal, "")


def _alike(data: Data, walk: Sequence[Walked], progress: Progress) -> tuple[Answer, ...]:
    """Answers that these data do not tell apart: what the search would take from the last step, or
    where that is nothing the last step itself, before all others that were refitted."""
    last = walk[-1]
    answer = last.answer
    if last.outcome is not None and last.outcome.round.chosen:
        answer = last.outcome.search.answer
    return answers_alike(_whole_search(data, walk, progress), answer)


def _whole_search(data: Data, walk: Sequence[Walked], progress: Progress) -> Search:
    """The search from the last step, which knows all that was refitted on the way, too."""
    outcomes = [step.outcome for step in walk if step.outcome is not None]
    search = copy(outcomes[-1].search) if outcomes else Search.of(data, progress)
    search.answers = {
        added: answer for outcome in outcomes for added, answer in outcome.search.answers.items()
    }
    search.answers |= {in_order(step.answer.added): step.answer for step in walk}
    return search
