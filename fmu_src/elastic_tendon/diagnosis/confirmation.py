"""The answer on all samples, where a search worked on excerpts of long recordings."""

from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import replace

import numpy as np

from elastic_tendon.actuator.parameters import Model
from elastic_tendon.diagnosis.answer import Answer, refit
from elastic_tendon.diagnosis.data import Data
from elastic_tendon.diagnosis.evidence import MUCH
from elastic_tendon.diagnosis.rounds import answers_alike, undecided
from elastic_tendon.diagnosis.search import Search
from elastic_tendon.diagnosis.sets import Set
from elastic_tendon.errors import ModelError
from elastic_tendon.estimation.fit import Effort
from elastic_tendon.progress import Progress

CONFIRMING = Effort(
    scouted=1, scouting=3, polished=0, evaluations=5, rounds=0, tolerance=1e-6
)  # of a fit to everything that starts at the answer
# where much is left, which makes other minima, of so many samples: several starts, how far apart
FEW, PLACES, APART = 50_000, 4, 0.1
SEARCHING = replace(CONFIRMING, scouted=PLACES + 1, scouting=10, evaluations=30)
MOST = 4  # answers that excerpts do not tell apart, which are fitted to everything
LESS = "explains less of all samples than what was taken"


def on_everything(data: Data, answer: Answer, report: Progress) -> Answer:
    """An answer that was found on excerpts, fitted to everything."""
    words = "confirming the answer on all samples"
    report(words, 0.0)
    starts, effort = [answer.result.model], CONFIRMING
    few = sum(len(part.time) for part in data.whole) <= FEW
    if few and answer.mean_square > MUCH:
        starts, effort = [*starts, *_places_around(answer)], SEARCHING
    whole = refit(
        data.given, answer.added, data.whole, starts, effort, lambda share: report(words, share)
    )
    report(words, 1.0)  # the fit ends quietly where it was interrupted
    return whole


def _places_around(answer: Answer) -> Iterator[Model]:
    """Models whose free parameters differ from an answer's by about a tenth."""
    model, random = answer.result.model, np.random.default_rng(0)
    values, paths = model.values(), answer.result.problem.coordinates.paths
    for _ in range(PLACES):
        times = np.exp(APART * random.standard_normal(len(paths)))
        with suppress(ModelError):
            yield model.with_values(
                {
                    path: values[path] * time
                    for path, time in zip(paths, times.tolist(), strict=True)
                }
            )


def confirm(data: Data, search: Search, report: Progress) -> Mapping[Set, Answer]:
    """Fit to everything the answer and what excerpts do not tell from it; refuse what explains less
    there, until an answer remains.

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
            if value > min(values) + undecided(best, fit):
                search.refused[fit.added] = LESS
        if answer.added not in search.refused:
            return whole
