"""The loop: refit, screen, add what is surely missing, take out what is needless, and conclude."""

from collections.abc import Callable, Sequence

from elastic_tendon import effects
from elastic_tendon.diagnosis.answer import UNDECIDED, Answer, bics
from elastic_tendon.diagnosis.by_hand import base, data_of
from elastic_tendon.diagnosis.conclude import (
    Found,
    conclude,
    judge_what_remains,
    propose_experiment,
)
from elastic_tendon.diagnosis.confirm import heldout_errors, refuted
from elastic_tendon.diagnosis.lack_of_fit import lack_of_fit
from elastic_tendon.diagnosis.learned import learn
from elastic_tendon.diagnosis.result import Diagnosis, Round
from elastic_tendon.diagnosis.revise import alternatives, without_needless
from elastic_tendon.diagnosis.rounds import Data, look
from elastic_tendon.identify.add import Report
from elastic_tendon.identify.ladder import REFIT
from elastic_tendon.measurement import Measurement
from elastic_tendon.parameters import Model

MOST_ROUNDS = 6
Ask = Callable[[Round], bool]


def _silent(_text: str, _share: float) -> None:
    """Progress that nobody asked for."""


def diagnose(
    model: Model,
    measurements: Sequence[Measurement],
    validation: Sequence[Measurement] = (),
    *,
    report: Report = _silent,
    ask: Ask | None = None,
) -> Diagnosis:
    """Find out whether a model is adequate, its numbers are wrong, or an effect is missing.

    The same call gives the same answer. An interrupt (Ctrl-C) keeps what was found.

    Parameters
    ----------
    model : Model as given; its uncertainties are the prior of every step
    measurements : fitted
    validation : never fitted, only judges; gives its initial state on its first 0.1 s
    report : called with words and the share of the work at hand that is done
    ask : called after each round; False stops the search there

    Returns
    -------
    Diagnosis

    Raises
    ------
    MeasurementError : a recording is both fitted and held out
    SimulationError : the model as given cannot be simulated
    BuildError : the compiler refuses an effect
    """
    data = data_of(model, measurements, validation)
    found = Found()
    interrupted = False
    first = base(data, report)
    found.path.append((REFIT, None, first))
    try:
        if not first.result.interrupted:
            _search(data, found, report, ask)
            _judge_what_remains(data, found, report)
            propose_experiment(data, found, report)
    except KeyboardInterrupt:
        interrupted = True
    return conclude(data, found, report, interrupted or first.result.interrupted)


def _search(data: Data, found: Found, report: Report, ask: Ask | None) -> None:
    while len(found.rounds) < MOST_ROUNDS:
        outcome = look(data, found.answer, report)
        found.rounds.append(outcome.round)
        if outcome.chosen is None:
            return
        answer = outcome.chosen
        effect_id = answer.added[-1]
        found.path.append((f"+ {effects.BY_ID[effect_id].title}", effect_id, answer))
        found.rivals[effect_id] = (*outcome.alike, *outcome.others)
        found.classes = [(answer, *outcome.alike)]
        if len(answer.added) > 1:
            _revise(data, found, report)
        if ask is not None and not ask(outcome.round):
            return


def _revise(data: Data, found: Found, report: Report) -> None:
    """Take out what others made needless, and put a rival in the place of what it surpasses."""
    answer = without_needless(data, found.answer, report)
    variants = alternatives(data, answer, found.rivals, report)
    flat = [one for others in variants.values() for one in others]
    own, *values = bics([answer, *flat])
    best = min(zip(values, flat, strict=True), key=lambda pair: pair[0], default=None)
    if best is not None and best[0] < own - UNDECIDED:
        answer = best[1]
        variants = {}
    else:
        bic = dict(zip(map(id, flat), values, strict=True))
        heldout, judges = heldout_errors(answer, data.heldout), data.heldout or data.fitted
        variants = {
            one: [
                other
                for other in others
                if bic[id(other)] < own + UNDECIDED
                and not refuted(heldout_errors(other, data.heldout), heldout, judges)
            ]
            for one, others in variants.items()
        }
    found.classes = [(answer, *others) for others in variants.values()]
    if answer.added != found.answer.added:
        _replace(found, answer)


def _replace(found: Found, answer: Answer) -> None:
    """Go on with an answer that has fewer or other effects, and remember the one it surpassed."""
    before = found.answer
    gone = [one for one in before.added if one not in answer.added]
    came = [one for one in answer.added if one not in before.added]
    words = [f"- {effects.BY_ID[one].title}" for one in gone]
    words += [f"+ {effects.BY_ID[one].title}" for one in came]
    for old, new in zip(gone, came, strict=False):
        found.rivals[new] = found.rivals.pop(old, ())
    found.path.append((", ".join(words), came[0] if came else None, answer))


def _judge_what_remains(data: Data, found: Found, report: Report) -> None:
    """Does it depend on the state of the machine; and if no effect is the cause, how?"""
    judge_what_remains(data, found, report)
    if found.unknown and found.answer.added:
        _take_all_out(found)
        found.lack = lack_of_fit(found.answer.result, report)
    if found.unknown:
        found.learned = learn(found.answer.result, report)


def _take_all_out(found: Found) -> None:
    """Back to the refitted model: effects that leave more than they explain are not the cause."""
    base = found.path[0][2]
    titles = [f"- {effects.BY_ID[one].title}" for one in found.answer.added]
    found.path.append((", ".join(titles), None, base))
    found.classes = []
