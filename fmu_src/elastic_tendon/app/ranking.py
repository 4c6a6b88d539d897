"""What the step Which effect says: the ranked list, its groups, and words for what can be done."""

from collections.abc import Sequence

from elastic_tendon import effects
from elastic_tendon.actuator.parameters import Model
from elastic_tendon.actuator.quantity import unit_text
from elastic_tendon.app import walk
from elastic_tendon.app.document import Document
from elastic_tendon.app.mapping import enumerated
from elastic_tendon.app.own_effects import known as known_effects
from elastic_tendon.diagnosis.by_hand import LeftOpen, Proposed
from elastic_tendon.diagnosis.experiment_text import titled, undisputed_text
from elastic_tendon.diagnosis.result import Candidate, Round
from elastic_tendon.diagnosis.verdict import LEFT, UNDECIDED, few, hedge
from elastic_tendon.effects.base import Effect
from elastic_tendon.errors import ModelError
from elastic_tendon.estimation.add import check_welcome
from elastic_tendon.estimation.ladder import Step
from elastic_tendon.reports.diagnosis_tables import (
    indistinguishable_sentence,
    listed,
    unsure_sentence,
)
from elastic_tendon.reports.first_screen import UNFINISHED, FirstScreen, first_screen
from elastic_tendon.reports.tables import fall_sentences
from elastic_tendon.simulation.signature import Signature

SEARCH = "Find which effect is missing"
SEARCH_AGAIN = "Find what else is missing"
SEARCH_ON = "Search to the end"


def refitted(search_round: Round) -> list[tuple[Candidate, ...]]:
    """Candidates that were refitted, in indistinguishable classes, likeliest first.

    Parameters
    ----------
    search_round : Round

    Returns
    -------
    list of tuple of Candidate; a tuple of one where nothing else explains as much
    """
    left = [candidate for candidate in search_round.candidates if candidate.fitted]
    groups = []
    while left:
        alike = {left[0].ids, *left[0].equivalence_class}
        groups.append(tuple(candidate for candidate in left if candidate.ids in alike))
        left = [candidate for candidate in left if candidate.ids not in alike]
    return groups


def unlikely(search_round: Round) -> list[Candidate]:
    """Candidates of which the screen expects too little for a refit."""
    return [candidate for candidate in search_round.candidates if not candidate.fitted]


def known(search_round: Round, effect_id: str) -> Candidate | None:
    """The candidate that is an effect alone, None where it is none of the round."""
    return next((row for row in search_round.candidates if row.ids == (effect_id,)), None)


def screen(
    search_round: Round | None,
    steps: Sequence[Step],
    with_it: Step | None,
    *,
    button: str = SEARCH,
    static: bool = False,
    left_open: LeftOpen | None = None,
    complete: bool = True,
) -> FirstScreen:
    """What heads the step: what is missing, how far the error falls with it, what to do next.

    Parameters
    ----------
    search_round : what the search found, None where it was not asked yet
    steps : the way from the model as given to the current version
    with_it : the error with what the search would take; None where it is not known yet
    button : what the one that searches is called
    static : the errors are those of static curves
    left_open : what these data do not tell apart, None where that is not known yet
    complete : the search has tried everything; it neither goes on nor was ended early
    """
    if search_round is None:
        verdict = "Which effect is missing was not searched from here yet."
        return first_screen(verdict, steps, f"press “{button}”.", static=static)
    fall = [] if with_it is None or not steps else [steps[0], with_it]
    advice = "go to Take away for the FMU, the model and the report."
    if search_round.chosen:
        title = effects.BY_ID[search_round.chosen[0]].title
        advice = f"add {title}, and search again. The choice is yours."
    elif steps and max(steps[-1].noise_ratio.values()) > LEFT:
        advice = "see in Where what is left of the error, and record the machine in other motions."
    if left_open is not None and left_open.sets:
        rivals = listed(left_open.names)
        advice = f"see below which experiment decides between {rivals}; or {advice}"
    if not complete:
        advice = UNFINISHED
    return first_screen(suggestion(search_round, left_open), fall, advice, static=static)


def experiment_words(left_open: LeftOpen, found: Proposed | None) -> str:
    """What is said of an experiment that decides.

    Parameters
    ----------
    left_open : what the data do not tell apart
    found : what came of seeking it, None where it was not sought
    """
    if not left_open.sets:
        return f"None is proposed: {undisputed_text(complete=left_open.complete)}."
    if found is not None:
        return found.reason if found.experiment is None else found.experiment.text
    return (
        f"{indistinguishable_sentence(left_open.names)} A motion of motor and load may tell them "
        "apart; it stays near what was recorded, as far as that is enough."
    )


def taken_words(names: Sequence[str]) -> str:
    """What becomes of recordings of an experiment, "" where there are none."""
    if not names:
        return ""
    fitted = "is fitted" if len(names) == 1 else "are fitted"
    return (
        f"{enumerated(names)} {fitted} together with the other recordings from now on. "
        f"“{SEARCH}” searches in all of them."
    )


def suggestion(search_round: Round, left_open: LeftOpen | None = None) -> str:
    """What the search would do next, and why; see `screen`."""
    reason = search_round.reason
    if not search_round.chosen:
        return f"The search would add nothing: {reason}. {unsure_sentence(search_round)}".rstrip()
    sure = hedge(_chance(search_round))
    instead = [titled(name) for name in left_open.names[1:]] if left_open is not None else []
    if not instead:
        return f"{reason}, and is {sure} there."
    return f"{reason}; it or {' or '.join(few(instead))} is {sure} there, and {UNDECIDED} which."


def _chance(search_round: Round) -> float:
    """Probability of what was chosen, or of what these data cannot distinguish from it, 0 to 1."""
    chosen = next(row for row in search_round.candidates if row.ids == search_round.chosen)
    return sum(
        row.probability
        for row in search_round.candidates
        if row is chosen or row.ids in chosen.equivalence_class
    )


def search_words(document: Document, *, ended_early: bool = False) -> tuple[str, str]:
    """What the button for the search is called, and what it would do; "" where it is done.

    Parameters
    ----------
    document : Document
    ended_early : a search from the current version was
    """
    version = document.version
    if ended_early:
        return SEARCH_ON, "The search was ended early: what it had not tried may do better."
    if walk.was_searched(document, version):
        return SEARCH, ""
    if walk.is_fitted(document, version):
        words = "Every effect of the catalogue is held against what is left of the error"
        words += ", and the likely ones are refitted. Nothing is added by that."
        return SEARCH_AGAIN if version.added else SEARCH, words
    refit = "The parameters are refitted first, as a version of its own; then every effect of the "
    refit += (
        "catalogue is held against what is left of the error, and the likely ones are refitted."
    )
    return SEARCH, refit


def refusal(model: Model, effect: Effect) -> str:
    """Why a model cannot take an effect, "" where it can."""
    if effect.id in model.effect_ids:
        return "This model has it already."
    try:
        check_welcome(model, effect.id)
    except ModelError as error:
        return f"{error}"
    return ""


def why_not_tried(search_round: Round | None) -> str:
    """Why an effect that is no candidate of the round cannot be tried."""
    if search_round is None:
        return "Try is available after the search."
    return "The search knows no parameters for it on this model; adding it has it fitted."


def choices(document: Document, model: Model | None = None) -> list[dict[str, str]]:
    """Effects as options to choose from; only those that a model can take, where one is given."""
    return [
        {"value": effect.id, "label": effect.title}
        for effect in known_effects(document)
        if model is None or not refusal(model, effect)
    ]


def first_choice(search_round: Round | None) -> str | None:
    """The effect that is looked at first: what the search names; none where it names none."""
    return next(iter(search_round.chosen), None) if search_round is not None else None


def tried_sentences(trial: walk.Tried, candidate: Candidate) -> list[str]:
    """How the error would change, before anything is added.

    Parameters
    ----------
    trial : Tried
    candidate : what was tried
    """
    sentences = fall_sentences(trial.before, trial.after)
    if not candidate.fitted:
        sentences.append("These are the values that the screen expects; adding fits them.")
    return [*sentences, "Nothing was added."]


def signature_words(signature: Signature) -> str:
    """What the picture of an effect shows, and on which machine."""
    units = {parameter.name: unit_text(parameter.unit) for parameter in signature.effect.parameters}
    numbers = ", ".join(
        f"{name} {value:.3g}" + ("" if units[name] == "1" else f" {units[name]}")
        for name, value in signature.numbers.items()
    )
    size = (
        "typical"
        if signature.times_typical == 1.0
        else f"{signature.times_typical:g} times typical"
    )
    return f"On {signature.example}, {size}: {numbers}."
