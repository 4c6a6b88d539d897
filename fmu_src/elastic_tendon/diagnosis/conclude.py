"""What is concluded from a way: what remains, what would decide, and the diagnosis itself."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from elastic_tendon import effects
from elastic_tendon.diagnosis.answer import Answer
from elastic_tendon.diagnosis.confirm import heldout_errors
from elastic_tendon.diagnosis.experiment import Undecidable, next_experiment
from elastic_tendon.diagnosis.lack_of_fit import LackOfFit, lack_of_fit
from elastic_tendon.diagnosis.result import (
    Diagnosis,
    Experiment,
    LearnedTerm,
    Remaining,
    Round,
    Verdict,
)
from elastic_tendon.diagnosis.rounds import Data
from elastic_tendon.diagnosis.separation import Rival
from elastic_tendon.identify.add import Report, with_estimates
from elastic_tendon.identify.compare import Comparison, compare
from elastic_tendon.identify.ladder import AS_GIVEN, Step, climb
from elastic_tendon.identify.locate import locate
from elastic_tendon.parameters import Model

FALSE_SHIFTS = 0.05  # of any number, where none is wrong


@dataclass
class Found:
    """What a diagnosis has so far; an interrupt leaves it as it is."""

    path: list[tuple[str, str | None, Answer]] = field(default_factory=list)  # title, what came in
    rounds: list[Round] = field(default_factory=list)
    # added effect -> answers with another in its place, the other one last
    rivals: dict[str, tuple[Answer, ...]] = field(default_factory=dict)
    # for each added effect the answers that cannot be told apart, the one taken first
    classes: list[tuple[Answer, ...]] = field(default_factory=list)
    lack: dict[str, LackOfFit] = field(default_factory=dict)
    unknown: bool = False
    learned: LearnedTerm | None = None
    experiment: Experiment | None = None
    undecidable: list[str] = field(default_factory=list)  # why no experiment decides

    @property
    def answer(self) -> Answer:
        return self.path[-1][2]


# ---- what remains, and what would decide -----------------------------------------------------


def judge_what_remains(data: Data, found: Found, report: Report) -> None:
    """Does it depend on the state of the machine; and is more left than effects explained?"""
    report("judging what remains", 0.0)
    found.lack = lack_of_fit(found.answer.result, report)
    found.unknown = _more_remains(data, found)


def _more_remains(data: Data, found: Found) -> bool:
    """Whether more remains than effects explained, and not by chance."""
    if not any(one.significant for one in found.lack.values()):
        return False
    errors = (heldout_errors(one, data.heldout) for one in (found.path[0][2], found.answer))
    base, last = (float(np.mean(one**2)) for one in errors)  # 1 is the noise
    return not found.answer.added or last - 1.0 > base - last


def propose_experiment(data: Data, found: Found, report: Report) -> None:
    """One that decides the first class that any can decide; and why none can."""
    for answers in found.classes:
        if len(answers) < 2 or found.experiment is not None:
            continue
        names = _different(answers)
        rivals = [Rival(name, one.result) for name, one in zip(names, answers, strict=True)]
        proposal = next_experiment(rivals, data.fitted, report)
        if isinstance(proposal, Undecidable):
            found.undecidable.append(proposal.text)
        else:
            found.experiment = proposal


# ---- conclusions -------------------------------------------------------------------------------


def conclude(data: Data, found: Found, report: Report, interrupted: bool) -> Diagnosis:
    """All that follows from what was found.

    Parameters
    ----------
    data : Data
    found : with at least one answer
    report : called with words and the share of the work at hand that is done
    interrupted : more may be missing than was found

    Returns
    -------
    Diagnosis
    """
    answer = found.answer
    steps = _steps(data, found)
    changed = _changed(answer)
    final = steps[-1].comparison
    return Diagnosis(
        verdict=_verdict(answer, found.unknown, changed),
        words=tuple(found.undecidable),
        given=data.given,
        model=with_estimates(answer.result.model, answer.result.findings.estimates),
        added=answer.added,
        parameters_changed=changed,
        findings=answer.result.findings,
        steps=steps,
        ladder=climb(steps),
        rounds=tuple(found.rounds),
        remaining=_remaining(steps, found.lack),
        noise={name: one.noise for name, one in final.files[0].signals.items()},
        comparison=final,
        location=locate(final, report),
        indistinguishable=tuple(
            tuple(_different(answers)) for answers in found.classes if len(answers) > 1
        ),
        next_experiment=found.experiment,
        learned=found.learned,
        interrupted=interrupted,
    )


def _steps(data: Data, found: Found) -> tuple[Step, ...]:
    def step(title: str, added: str | None, effective: float, model: Model) -> Step:
        return Step(
            title=title,
            added=added,
            parameters=0 if added is None else len(effects.BY_ID[added].parameters),
            effective=effective,
            comparison=compare(model, data.fitted),
            heldout=compare(model, data.heldout) if data.heldout else None,
        )

    ways = [
        step(title, added, answer.result.findings.effective, answer.result.model)
        for title, added, answer in found.path
    ]
    return (step(AS_GIVEN, None, 0.0, data.given), *ways)


def _changed(answer: Answer) -> tuple[str, ...]:
    """Numbers of the given model that surely moved: their intervals exclude what was given, and
    that is no chance of so many numbers (Holm's correction)."""
    from scipy.stats import norm

    estimates = [
        one
        for one in answer.result.findings.estimates
        if one.determined and not one.path.startswith("effects.") and one.sigma > 0.0
    ]
    tails = [2.0 * float(norm.sf(abs(one.fitted - one.given) / one.sigma)) for one in estimates]
    moved = []
    for rank, index in enumerate(np.argsort(tails)):
        if tails[index] > FALSE_SHIFTS / (len(tails) - rank):
            break
        one = estimates[index]
        # of few stretches of time the interval is wider than a normal distribution's
        if not one.interval[0] <= one.given <= one.interval[1]:
            moved.append(one.path)
    return tuple(moved)


def _verdict(answer: Answer, unknown: bool, changed: Sequence[str]) -> Verdict:
    if unknown:
        return "unknown_effect"
    if answer.added:
        return "missing_effect"
    return "wrong_parameter" if changed else "adequate"


def _remaining(steps: Sequence[Step], lack: dict[str, LackOfFit]) -> dict[str, Remaining]:
    first, last = steps[0].comparison, steps[-1].comparison
    floors = last.pooled(lambda error: error.noise.sigma)
    ratios = last.noise_ratio()

    def excess(comparison: Comparison, name: str) -> float:
        return max(comparison.rmse()[name] ** 2 - floors[name] ** 2, 0.0)

    return {
        name: Remaining(
            noise_ratio=ratios[name],
            share_of_initial=excess(last, name) / max(excess(first, name), 1e-300)
            if excess(last, name)
            else 0.0,
            significant=one.significant,
            p_value=one.p_value,
        )
        for name, one in lack.items()
    }


def _different(answers: Sequence[Answer]) -> list[str]:
    """The ids in which the answers of a class differ, the one taken first."""
    first, *others = answers
    own = [one for one in first.added if any(one not in other.added for other in others)]
    return [*own[:1], *(one.added[-1] for one in others)]
