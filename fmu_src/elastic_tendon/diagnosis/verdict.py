"""The verdict: what was found, what is left, how sure that is; and the one sentence for it.

Every word for a probability has a fixed meaning (`hedge`), so that no sentence says more than the
numbers beside it.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from scipy.stats import norm

from elastic_tendon import effects
from elastic_tendon.comparison.comparison import Comparison
from elastic_tendon.comparison.residuals import noise_floors
from elastic_tendon.diagnosis.answer import Answer
from elastic_tendon.diagnosis.experiment_text import titled
from elastic_tendon.diagnosis.lack_of_fit import SIGNIFICANT, LackOfFit
from elastic_tendon.diagnosis.result import RecordingSummary, Remaining, Verdict
from elastic_tendon.estimation.determinability import Estimate

LEFT = 1.5  # times the noise, up to which nobody wants to hear of what is left
OFF = 3.0  # times the noise, from which the error as given is no matter of its initial state
# times the noise, and the error on fitted recordings, that one on a held-out one may have
ELSEWHERE, MORE_THAN_FITTED = 5.0, 3.0
FALSE_SHIFTS = 0.05  # of any parameter, where none is wrong
UNDECIDED = "these data do not tell"
MOST_NAMED = 3  # rivals of an answer in a sentence; all of them are listed beside it
SURELY, PROBABLY = 0.99, 0.9  # probabilities from which these words are used


def hedge(probability: float) -> str:
    """Word for a probability: surely from 0.99, probably from 0.9, else perhaps."""
    if probability >= SURELY:
        return "surely"
    return "probably" if probability >= PROBABLY else "perhaps"


def remaining_of(
    given: Comparison, last: Comparison, lack: Mapping[str, LackOfFit], relevance: float = 0.0
) -> dict[str, Remaining]:
    """What is left of each signal's error.

    Parameters
    ----------
    given, last : the model as given and the answer beside the fitted recordings
    lack : whether what is left depends on the state of the machine; where that was not judged,
        what is heard above the noise is taken for no chance
    relevance : RMS share of the error as given, both above the noise, up to which what is left
        does not matter, however many times the noise it is
    """
    noise = last.pooled(lambda error: error.noise.sigma)
    before, after = given.rmse(), last.rmse()

    def excess(rmse: Mapping[str, float], name: str) -> float:
        return max(rmse[name] ** 2 - noise[name] ** 2, 0.0)

    found = {}
    for name in after:
        ratio, left, result = after[name] / noise[name], excess(after, name), lack.get(name)
        share = left / max(excess(before, name), 1e-300) if left else 0.0
        found[name] = Remaining(
            noise_ratio=ratio,
            share_of_initial=share,
            significant=bool(ratio > LEFT if result is None else result.significant),
            matters=bool(ratio > LEFT and share > relevance**2),
            p_value=None if result is None else result.p_value,
        )
    return found


def unexplained(remaining: Mapping[str, Remaining]) -> bool:
    """Whether something that is surely there and large is left."""
    return any(part.significant and part.matters for part in remaining.values())


def no_chance(remaining: Mapping[str, Remaining]) -> bool:
    """Whether something is left that is neither noise nor chance, whether it matters or not."""
    return any(part.significant and part.noise_ratio > LEFT for part in remaining.values())


def only_chance(lack: Mapping[str, LackOfFit]) -> bool:
    """Whether nothing that is left depends on the state of the machine, however little it is: at
    the size of the noise one effect easily stands for some of another."""
    return all(part.p_value > SIGNIFICANT for part in lack.values())


def matters_somewhere(given: Comparison, last: Comparison, relevance: float) -> bool:
    """Whether what is left matters in any recording by itself, however little it is over all."""
    return any(
        part.matters
        for before, after in zip(given.files, last.files, strict=True)
        for part in remaining_of(
            replace(given, files=(before,)), replace(last, files=(after,)), {}, relevance
        ).values()
    )


def contradicting_of(recordings: Sequence[RecordingSummary]) -> tuple[str, ...]:
    """Names of the fitted recording that contradicts most others, and of these; or none."""
    fitted = {part.file for part in recordings if part.role == "fitted"}
    found = [
        (part.file, *(rival for rival in part.contradicts if rival in fitted))
        for part in recordings
        if part.role == "fitted"
    ]
    most = max(found, key=len)
    return most if len(most) > 1 else ()


def changed_parameters(
    answer: Answer, given: Comparison, relevance: float
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Parameters of the given model that moved significantly: those that matter, and the others.

    Their intervals exclude the given value, and that is no chance of so many (Holm's correction).
    One matters if its shift alone changes a signal by more than `relevance` of its error as given.
    """
    estimates = [
        estimate
        for estimate in answer.result.findings.estimates
        if estimate.determined and not estimate.path.startswith("effects.") and estimate.sigma > 0.0
    ]
    tails = [
        2.0 * float(norm.sf(abs(estimate.fitted - estimate.given) / estimate.sigma))
        for estimate in estimates
    ]
    moved = []
    for rank, index in enumerate(np.argsort(tails)):
        if tails[index] > FALSE_SHIFTS / (len(tails) - rank):
            break
        estimate = estimates[index]
        # of few stretches of time the interval is wider than a normal distribution's
        if not estimate.interval[0] <= estimate.given <= estimate.interval[1]:
            moved.append(estimate)
    moved.sort(key=lambda estimate: estimates.index(estimate))
    effect = _shown_by(answer, moved)
    floor = max(relevance * max(given.noise_ratio().values()), relevance)
    matter = tuple(part.path for part in moved if effect[part.path] > floor)
    return matter, tuple(part.path for part in moved if part.path not in matter)


def _shown_by(answer: Answer, moved: Sequence[Estimate]) -> dict[str, float]:
    """RMS change of the signals by each parameter's shift, in units of the noise."""
    if not moved:
        return {}
    problem = answer.result.problem
    floors = tuple(noise_floors(recording) for recording in problem.measurements)
    columns = problem.data_jacobian(answer.result.vector, floors)
    paths = problem.coordinates.paths
    return {
        part.path: abs(part.fitted - part.given)
        * float(np.sqrt(np.mean(columns[:, paths.index(part.path)] ** 2)))
        for part in moved
    }


def fails_elsewhere(
    fitted: Comparison, heldout: Comparison | None, recordings: Sequence[RecordingSummary]
) -> str:
    """Name of a held-out recording that the answer errs on as a whole, "" where there is none.

    What a constant explains, such as another zero of an encoder, is no failure, nor is an error
    that the fitted recordings have too.
    """
    explained = {part.file for part in recordings if part.explained_by is not None}
    usual = fitted.noise_ratio()
    for file in heldout.files if heldout is not None else ():
        for name, error in file.signals.items():
            most = max(ELSEWHERE, MORE_THAN_FITTED * usual.get(name, 1.0))
            if error.noise_ratio > most and file.measurement.name not in explained:
                return file.measurement.name
    return ""


def verdict_of(
    added: Sequence[str],
    changed: Sequence[str],
    remaining: Mapping[str, Remaining],
    fell: float,
    relevance: float,
    elsewhere: str = "",
    contradicting: Sequence[str] = (),
    as_given: float = 1.0,
) -> Verdict:
    """The verdict.

    Parameters
    ----------
    added : effects
    changed : parameters that moved significantly and matter
    remaining : by signal
    fell : share by which the error fell from the model as given, 0 to 1
    relevance : share below which that is not worth a verdict
    elsewhere : held-out recording on which the answer fails
    contradicting : fitted recordings that no parameters suit together
    as_given : error of the model as given, times the noise; where it is large parameters are off,
        even if the data show only how they are off together
    """
    if unexplained(remaining) or contradicting or (elsewhere and not added):
        return "unexplained"
    if added:
        return "missing_effect"
    off = bool(changed) or as_given > OFF
    return "wrong_parameter" if off and fell > relevance else "adequate"


def fall(given: Comparison, last: Comparison) -> float:
    """Share by which the error fell, of the signal where it fell most, 0 to 1."""
    before, after = given.rmse(), last.rmse()
    return max(1.0 - after[name] / before[name] if before[name] else 0.0 for name in before)


def sentence_of(
    verdict: Verdict,
    added: Sequence[str],
    certainty: Mapping[str, float],
    alike: Sequence[str],
    changed: Sequence[str],
    given: Comparison,
    last: Comparison,
    *,
    elsewhere: str = "",
    contradicting: Sequence[str] = (),
    ignored: float | None = None,
    structured: bool = False,
    chosen: bool = False,
    complete: bool,
) -> str:
    """The verdict in words.

    Parameters
    ----------
    verdict, added, changed : what was found
    certainty : probability of each added effect, 0 to 1
    alike : names of what the data cannot tell from what was added, "+" between ids of a set
    given, last : the model as given and the answer beside the fitted recordings
    elsewhere : held-out recording on which the answer fails
    contradicting : a fitted recording and those that it contradicts
    ignored : share of the error as given up to which what is left does not matter, where it is no
        chance
    structured : whether some of what is left depends on the motion by more than chance
    chosen : whether the user left effects of the catalogue out
    complete : whether the search came to its end
    """
    tried = ("that was asked for" if chosen else "of the catalogue") if complete else "tried so far"
    nothing = f"no effect {tried} explains"
    ratios = last.noise_ratio()
    worst = max(ratios, key=lambda name: ratios[name])
    before, after = given.noise_ratio()[worst], ratios[worst]
    of_signal = f" of {worst.replace('_', ' ')}" if len(ratios) > 1 else ""
    left = f"{_number(after)} times the noise{of_signal}"
    falls = f"the error falls from {_number(before)} to {left}"
    if verdict == "adequate":
        text = f"{given.model.name} explains these data: what is left is {left}"
    elif verdict == "wrong_parameter":
        numbers = f"{', '.join(changed)} {'is' if len(changed) == 1 else 'are'} off"
        if not changed:
            numbers = "parameters are off together, of which these data determine none by itself"
        slight = " that matters" if structured else ""
        text = f"No effect{slight} is missing, but {numbers}: refitted, {falls}"
    elif verdict == "missing_effect":
        text = f"{missing(added, certainty, alike)}: {falls}"
    elif added:
        text = (
            f"{missing(added, certainty, alike)}; beyond "
            f"{'it' if len(added) == 1 else 'them'} {left} is left that {nothing}"
        )
    elif not complete:
        text = f"No effect tried so far explains these data: {left} is left"
    elif after > LEFT or not elsewhere:
        text = f"Something is missing that {nothing}: {left} is left"
    else:
        text = f"Something is missing that the fitted recordings do not show: {left} is left there"
    if after > LEFT and verdict != "unexplained":
        text += (
            "; this depends on the motion by no more than chance, as a disturbance would"
            if ignored is None
            else f"; what of it is no chance is less than {100.0 * ignored:.3g} % of the error as "
            "given, and was not to matter"
        )
    elif structured and verdict != "unexplained":
        text += (
            "; some of that depends on the motion by more than chance, but is too small to matter"
        )
    if contradicting:
        first, *others = contradicting
        text += f"; {first} contradicts {' and '.join(others)}: no parameters suit them together"
    if elsewhere:
        text += f"; {elsewhere}, which was held out, is not explained"
    return f"{text}." if complete else f"{text}; the search was stopped before its end."


def missing(added: Sequence[str], certainty: Mapping[str, float], alike: Sequence[str] = ()) -> str:
    """What is missing, as "Coulomb friction is surely missing" or "Coulomb friction or Stribeck
    friction is surely missing, and these data do not tell which".

    Parameters
    ----------
    added, certainty, alike : see `sentence_of`
    """
    titles = [effects.BY_ID[effect_id].title for effect_id in added]
    words = [hedge(certainty.get(effect_id, 0.0)) for effect_id in added]
    instead = few([titled(name) for name in dict.fromkeys(filter(None, alike))])
    if len(titles) == 1 and instead:
        # what is so certain is that one of them is there
        return f"{_listed([*titles, *instead], 'or')} is {words[0]} missing, and {UNDECIDED} which"
    rivals = f", or else {_listed(instead, 'or')}, which {UNDECIDED} apart" if instead else ""
    if len(set(words)) == 1:
        verb = "is" if len(titles) == 1 else "are"
        return f"{_listed(titles, 'and')} {verb} {words[0]} missing{rivals}"
    parts = [f"{title} {word}" for title, word in zip(titles, words, strict=True)]
    return f"Missing: {', '.join(parts)}{rivals}"


def few(names: Sequence[str]) -> Sequence[str]:
    """Names of rivals that a sentence can hold: of many the first, and how many others."""
    others = len(names) - MOST_NAMED + 1
    return [*names[: MOST_NAMED - 1], f"one of {others} others"] if others > 1 else names


def _listed(titles: Sequence[str], word: str) -> str:
    """As "A, B or C", with that word before the last."""
    *first, last = titles
    return f"{', '.join(first)} {word} {last}" if first else last


def _number(value: float) -> str:
    digits = 0 if value >= 100.0 else (1 if value >= 10.0 else 2)
    return f"{value:.{digits}f}"
