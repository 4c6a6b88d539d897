"""What the step Which effect says: the ranked list, its groups, and words for what can be done."""

from elastic_tendon import effects
from elastic_tendon.actuator.parameters import Model
from elastic_tendon.actuator.quantity import unit_text
from elastic_tendon.app import walk
from elastic_tendon.app.document import Document
from elastic_tendon.diagnosis.result import Candidate, Round
from elastic_tendon.diagnosis.verdict import hedge
from elastic_tendon.effects.base import Effect
from elastic_tendon.errors import ModelError
from elastic_tendon.estimation.add import check_welcome
from elastic_tendon.reports.diagnosis_tables import unsure_sentence
from elastic_tendon.reports.tables import fall_sentences
from elastic_tendon.simulation.signature import Signature

SEARCH = "Find which effect is missing"
SEARCH_AGAIN = "Find what else is missing"


def refitted(judged: Round) -> list[tuple[Candidate, ...]]:
    """Candidates that were refitted, in groups that these data cannot tell apart, likeliest first.

    Parameters
    ----------
    judged : Round

    Returns
    -------
    list of tuple of Candidate; a tuple of one where nothing else explains as much
    """
    left = [candidate for candidate in judged.candidates if candidate.fitted]
    groups = []
    while left:
        alike = {left[0].ids, *left[0].equivalence_class}
        groups.append(tuple(candidate for candidate in left if candidate.ids in alike))
        left = [candidate for candidate in left if candidate.ids not in alike]
    return groups


def unlikely(judged: Round) -> list[Candidate]:
    """Candidates of which the screen expects too little for a refit."""
    return [candidate for candidate in judged.candidates if not candidate.fitted]


def known(judged: Round, effect_id: str) -> Candidate | None:
    """The candidate that is an effect alone, None where it is none of the round."""
    return next((row for row in judged.candidates if row.ids == (effect_id,)), None)


def suggestion(judged: Round) -> str:
    """What the search would do next, and why."""
    if not judged.chosen:
        return f"The search would add nothing: {judged.reason}. {unsure_sentence(judged)}".rstrip()
    return f"{judged.reason}, and is {hedge(_chance(judged))} there. The choice is yours."


def _chance(judged: Round) -> float:
    """Probability of what was chosen, or of what these data cannot tell from it, 0 to 1."""
    chosen = next(row for row in judged.candidates if row.ids == judged.chosen)
    return sum(
        row.probability
        for row in judged.candidates
        if set(chosen.ids) <= set(row.ids) or row.ids in chosen.equivalence_class
    )


def search_words(document: Document) -> tuple[str, str]:
    """What the button for the search is called, and what it would do; "" where it is done."""
    version = document.version
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


def why_not_tried(judged: Round | None) -> str:
    """Why an effect that is no candidate of the round cannot be tried."""
    if judged is None:
        return "Try is available after the search."
    return "The search knows no numbers for it on this model; adding it has it fitted."


def choices(model: Model | None = None) -> list[dict[str, str]]:
    """Effects as options to choose from; only those that a model can take, where one is given."""
    return [
        {"value": effect.id, "label": effect.title}
        for effect in effects.BY_ID.values()
        if model is None or not refusal(model, effect)
    ]


def first_choice(judged: Round | None) -> str | None:
    """The effect that is looked at first: what the search names; none where it names none."""
    return next(iter(judged.chosen), None) if judged is not None else None


def tried_sentences(found: walk.Tried, candidate: Candidate) -> list[str]:
    """How the error would change, before anything is added.

    Parameters
    ----------
    found : Tried
    candidate : what was tried
    """
    sentences = fall_sentences(found.before, found.after)
    if not candidate.fitted:
        sentences.append("These are the numbers that the screen expects; adding fits them.")
    return [*sentences, "Nothing was added."]


def signature_words(found: Signature) -> str:
    """What the picture of an effect shows, and on which machine."""
    units = {parameter.name: unit_text(parameter.unit) for parameter in found.effect.parameters}
    numbers = ", ".join(
        f"{name} {value:.3g}" + ("" if units[name] == "1" else f" {units[name]}")
        for name, value in found.numbers.items()
    )
    size = "typical" if found.times_typical == 1.0 else f"{found.times_typical:g} times typical"
    return f"On {found.example}, {size}: {numbers}."
