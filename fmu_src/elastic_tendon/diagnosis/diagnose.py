"""The loop: refit, screen, add what is surely missing, take out what is needless, and conclude."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from elastic_tendon import effects
from elastic_tendon.diagnosis.answer import UNDECIDED, Answer, bics, refit
from elastic_tendon.diagnosis.candidates import prepare
from elastic_tendon.diagnosis.confirm import heldout_errors, refuted
from elastic_tendon.diagnosis.experiment import Undecidable, next_experiment
from elastic_tendon.diagnosis.inputs import smoothed
from elastic_tendon.diagnosis.lack_of_fit import LackOfFit, lack_of_fit
from elastic_tendon.diagnosis.learned import learn
from elastic_tendon.diagnosis.result import (
    Diagnosis,
    Experiment,
    LearnedTerm,
    Remaining,
    Round,
    Verdict,
)
from elastic_tendon.diagnosis.revise import alternatives, without_needless
from elastic_tendon.diagnosis.rounds import Data, look
from elastic_tendon.diagnosis.separation import Rival
from elastic_tendon.identify.add import Report, check_apart, with_estimates
from elastic_tendon.identify.compare import Comparison, compare
from elastic_tendon.identify.ladder import AS_GIVEN, REFIT, Step, climb
from elastic_tendon.identify.locate import locate
from elastic_tendon.measurement import Measurement
from elastic_tendon.parameters import Model

MOST_ROUNDS = 6
FALSE_SHIFTS = 0.05  # of any number, where none is wrong
Ask = Callable[[Round], bool]


def _silent(_text: str, _share: float) -> None:
    """Progress that nobody asked for."""


@dataclass
class _Found:
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
    check_apart(measurements, validation)
    data = Data(model, tuple(map(smoothed, measurements)), tuple(map(smoothed, validation)))
    found = _Found()
    interrupted = False
    report("refitting the parameters", 0.0)
    prepare([model.effect_ids], report)
    base = refit(model, (), data.fitted, progress=lambda share: report(REFIT, share))
    found.path.append((REFIT, None, base))
    try:
        if not base.result.interrupted:
            _search(data, found, report, ask)
            _judge_what_remains(data, found, report)
            _propose_experiment(data, found, report)
    except KeyboardInterrupt:
        interrupted = True
    return _conclude(data, found, report, interrupted or base.result.interrupted)


def _search(data: Data, found: _Found, report: Report, ask: Ask | None) -> None:
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


def _revise(data: Data, found: _Found, report: Report) -> None:
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


def _replace(found: _Found, answer: Answer) -> None:
    """Go on with an answer that has fewer or other effects, and remember the one it surpassed."""
    before = found.answer
    gone = [one for one in before.added if one not in answer.added]
    came = [one for one in answer.added if one not in before.added]
    words = [f"- {effects.BY_ID[one].title}" for one in gone]
    words += [f"+ {effects.BY_ID[one].title}" for one in came]
    for old, new in zip(gone, came, strict=False):
        found.rivals[new] = found.rivals.pop(old, ())
    found.path.append((", ".join(words), came[0] if came else None, answer))


# ---- what remains, and what would decide -----------------------------------------------------


def _judge_what_remains(data: Data, found: _Found, report: Report) -> None:
    """Does it depend on the state of the machine; and if no effect is the cause, how?"""
    report("judging what remains", 0.0)
    found.lack = lack_of_fit(found.answer.result, report)
    found.unknown = _more_remains(data, found)
    if found.unknown and found.answer.added:
        _take_all_out(found)
        found.lack = lack_of_fit(found.answer.result, report)
    if found.unknown:
        found.learned = learn(found.answer.result, report)


def _more_remains(data: Data, found: _Found) -> bool:
    """Whether more remains than effects explained, and not by chance."""
    if not any(one.significant for one in found.lack.values()):
        return False
    errors = (heldout_errors(one, data.heldout) for one in (found.path[0][2], found.answer))
    base, last = (float(np.mean(one**2)) for one in errors)  # 1 is the noise
    return not found.answer.added or last - 1.0 > base - last


def _take_all_out(found: _Found) -> None:
    """Back to the refitted model: effects that leave more than they explain are not the cause."""
    base = found.path[0][2]
    titles = [f"- {effects.BY_ID[one].title}" for one in found.answer.added]
    found.path.append((", ".join(titles), None, base))
    found.classes = []


def _propose_experiment(data: Data, found: _Found, report: Report) -> None:
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


def _conclude(data: Data, found: _Found, report: Report, interrupted: bool) -> Diagnosis:
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


def _steps(data: Data, found: _Found) -> tuple[Step, ...]:
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
    """Numbers of the given model that surely moved; Holm's correction over all of them."""
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
        moved.append(estimates[index].path)
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
