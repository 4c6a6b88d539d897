"""The answer on all samples, where a search worked on excerpts of long recordings."""

from collections.abc import Mapping

import numpy as np

from elastic_tendon.diagnosis.answer import Answer, refit
from elastic_tendon.diagnosis.data import Data
from elastic_tendon.diagnosis.evidence import MUCH
from elastic_tendon.diagnosis.rounds import answers_alike, undecided
from elastic_tendon.diagnosis.search import Search
from elastic_tendon.diagnosis.sets import Set, model_with, without
from elastic_tendon.estimation.fit import Effort
from elastic_tendon.progress import Progress

CONFIRMING = Effort(
    scouted=1, scouting=3, polished=0, evaluations=5, rounds=0, tolerance=1e-6
)  # of a fit to everything that starts at the answer
MOST = 4  # answers that excerpts do not tell apart, which are fitted to everything
FAR_MORE = 4.0  # times the mean square on excerpts and on everything by which these differ
LESS = "explains less of all samples than what was taken"
MORE = "errs more over all samples than without one of its effects"


def on_everything(
    data: Data, answer: Answer, report: Progress, beside: Answer | None = None
) -> Answer:
    """An answer that was found on excerpts, fitted to everything; from the parameters of another
    beside it, as far as it has them, where there is one."""
    words = "confirming the answer on all samples"
    report(words, 0.0)
    values = answer.result.model.values()
    if beside is not None:
        other = beside.result.model.values()
        values |= {path: other[path] for path in values.keys() & other}
    start = [model_with(data.given, answer.added, values)]
    whole = refit(
        data.given, answer.added, data.whole, start, CONFIRMING, lambda share: report(words, share)
    )
    report(words, 1.0)  # the fit ends quietly where it was interrupted
    return whole


def leaves_far_more(answer: Answer, other: Answer) -> bool:
    """Whether of one answer, on excerpts and on everything, the one leaves far more."""
    return answer.mean_square > max(FAR_MORE * other.mean_square, MUCH)


def confirm(data: Data, search: Search, report: Progress) -> Mapping[Set, Answer]:
    """Fit to everything the answer and what excerpts do not tell from it; refuse what explains less
    there, or errs more than with fewer effects, until an answer remains.

    Parameters
    ----------
    data : Data
    search : that has ended
    report : called with words and the share of the work at hand that is done

    Returns
    -------
    sets of effects -> fits to everything, the answer's among them
    """
    whole: dict[Set, Answer] = {}
    while True:
        answer = search.answer
        # where much is left, more samples of it do not decide
        others = answers_alike(search, answer)[1:MOST] if answer.mean_square <= MUCH else ()
        alike = (answer, *others)
        for part in alike:
            if part.added not in whole:
                whole[part.added] = on_everything(data, part, report)
        fits = [whole[part.added] for part in alike]
        values = search.evidence.of_fitted(fits)  # held-out recordings took part in the search
        best = fits[values.index(min(values))]
        for fit, value in zip(fits, values, strict=True):
            most = min(values) + undecided(best, fit)
            if value > most:  # excerpts may have led it where all samples do not want it
                again = on_everything(data, fit, report, best)
                if search.evidence.of_fitted([*fits, again])[-1] > most:
                    search.refused[fit.added] = LESS
                else:
                    whole[fit.added] = again
        if answer.added in search.refused:
            continue
        if not errs_more(data, search, whole[answer.added], report):
            return whole
        search.refused[answer.added] = MORE


def errs_more(data: Data, search: Search, whole: Answer, report: Progress) -> bool:
    """Whether the answer, where it leaves far more of all samples than of excerpts, leaves more
    than it would without one of its effects."""
    if not leaves_far_more(whole, search.answer):
        return False
    fewer = (without(whole.added, effect_id) for effect_id in whole.added)
    parts = [search.answers[added] for added in fewer if added in search.answers]
    left = [on_everything(data, part, report).mean_square for part in parts]
    return min(left, default=np.inf) < whole.mean_square
