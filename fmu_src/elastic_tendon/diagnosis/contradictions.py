"""Recordings that call for different parameters of the same model."""

from collections.abc import Mapping, Sequence

import numpy as np

from elastic_tendon.actuator.parameters import Model
from elastic_tendon.diagnosis.answer import Answer, refit
from elastic_tendon.diagnosis.held_out import heldout_errors
from elastic_tendon.errors import ElasticTendonError
from elastic_tendon.estimation.fit import Effort
from elastic_tendon.measurement import Measurement
from elastic_tendon.progress import Progress, silent

ALONE = Effort(scouted=1, scouting=4, polished=0, evaluations=20, rounds=1, tolerance=1e-5)
FARTHER = 2.0  # times the error of a fit to one recording, that a fit to another may have on it


def contradictions(
    given: Model,
    answer: Answer,
    recordings: Sequence[Measurement],
    progress: Progress = silent,
) -> Mapping[str, tuple[str, ...]]:
    """Names of recordings, each with those that contradict it.

    Two contradict each other where a fit to either one errs on the other far more than a fit to
    that one, parameters moved as far as the fit leaves them open.

    Parameters
    ----------
    given : Model; centre of the prior of each fit
    answer : Answer whose effects are taken, and from which each fit begins
    recordings : those of one name belong together
    progress : told what is being done, and the share of it that is done
    """
    groups: dict[str, list[Measurement]] = {}
    for part in recordings:
        groups.setdefault(part.recording, []).append(part)
    if len(groups) < 2:
        return dict.fromkeys(groups, ())
    words = "comparing recordings with one another"
    alone: dict[str, Answer | None] = {}
    for name, parts in groups.items():
        progress(words, 0.5 * len(alone) / len(groups))
        alone[name] = _alone(given, answer, parts)
    far = set()
    for index, name in enumerate(groups):
        progress(words, 0.5 + 0.5 * index / len(groups))
        most = FARTHER * max(_errs(alone[name]), 1.0)
        far |= {
            (fitted, name)
            for fitted in groups
            if fitted != name and _errs(alone[fitted], groups[name]) > most
        }
    progress(words, 1.0)
    return {
        name: tuple(rival for rival in groups if {(name, rival), (rival, name)} <= far)
        for name in groups
    }


def _alone(given: Model, answer: Answer, recordings: Sequence[Measurement]) -> Answer | None:
    """The same effects fitted to some recordings only; None where that fails."""
    try:
        return refit(given, answer.added, recordings, [answer.result.model], ALONE)
    except ElasticTendonError:
        return None


def _errs(answer: Answer | None, recordings: Sequence[Measurement] = ()) -> float:
    """RMS error on some recordings, or on those that were fitted, in units of the noise."""
    if answer is None:
        return 1.0  # it cannot say anything against another
    errors = heldout_errors(answer.result, recordings) if recordings else answer.floored
    return float(np.sqrt(np.mean(errors**2)))
