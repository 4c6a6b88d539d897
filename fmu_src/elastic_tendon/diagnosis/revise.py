"""Is each effect still needed, and still the best of its like, now that others came in?"""

from collections.abc import Mapping, Sequence

from elastic_tendon.diagnosis.answer import UNDECIDED, Answer, bics, refit
from elastic_tendon.diagnosis.candidates import prepare
from elastic_tendon.diagnosis.rounds import Data
from elastic_tendon.errors import ModelError, SimulationError
from elastic_tendon.identify.add import Report
from elastic_tendon.identify.fit import QUICK


def without_needless(data: Data, answer: Answer, report: Report) -> Answer:
    """Take out, one after the other, effects that the others make needless (by BIC)."""
    while len(answer.added) > 1:
        report("checking what is still needed", 0.0)
        simpler = [
            found
            for one in answer.added[:-1]
            if (found := _variant(data, answer, one, None)) is not None
        ]
        best = min(simpler, key=lambda one: bics([answer, one])[1], default=None)
        if best is None:
            return answer
        own, other = bics([answer, best])
        if other - own >= UNDECIDED:
            return answer
        answer = best
    return answer


def alternatives(
    data: Data, answer: Answer, rivals: Mapping[str, Sequence[Answer]], report: Report
) -> dict[str, list[Answer]]:
    """For each added effect, answers with one of its rivals in its place.

    Parameters
    ----------
    data : Data
    answer : with all effects
    rivals : effect id -> answers that explained alike when it came in, the rival added last
    report : called with words and the share that is done
    """
    pairs = [(one, rival) for one in answer.added for rival in rivals.get(one, ())]
    pairs = [(one, rival) for one, rival in pairs if rival.added[-1] not in answer.added]
    found: dict[str, list[Answer]] = {}
    for index, (one, rival) in enumerate(pairs):
        report("trying what else could be meant", index / len(pairs))
        if (other := _variant(data, answer, one, rival)) is not None:
            found.setdefault(one, []).append(other)
    return found


def _variant(data: Data, answer: Answer, out: str, rival: Answer | None) -> Answer | None:
    """The answer without one effect, or with a rival in its place; None where there is none."""
    model, added = data.given, [one for one in answer.added if one != out]
    values = answer.result.model.values()
    try:
        for one in added:
            model = model.with_effect(one, answer.values(one))
        model = model.with_values({path: values[path] for path in model.values()})
        if rival is not None:
            added.append(rival.added[-1])
            model = model.with_effect(added[-1], rival.values(added[-1]))
        prepare([model.effect_ids], lambda _text, _share: None)
        return refit(data.given, added, data.fitted, [model], QUICK)
    except (ModelError, SimulationError):  # they do not go together
        return None
