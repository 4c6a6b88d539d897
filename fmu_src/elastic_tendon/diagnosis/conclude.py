"""What is concluded from a search: what remains, what would decide, and the diagnosis itself."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from math import sqrt
from operator import is_

from elastic_tendon import effects
from elastic_tendon.actuator.interfaces import AS_RECORDED
from elastic_tendon.actuator.parameters import Model, quantities
from elastic_tendon.actuator.quantity import unit_suffix
from elastic_tendon.comparison.compare import compare
from elastic_tendon.comparison.comparison import Comparison
from elastic_tendon.comparison.locate import locate
from elastic_tendon.diagnosis import too_small
from elastic_tendon.diagnosis.answer import Answer
from elastic_tendon.diagnosis.beginnings import beginning_notes
from elastic_tendon.diagnosis.candidates import starts
from elastic_tendon.diagnosis.confirmation import leaves_far_more, on_everything
from elastic_tendon.diagnosis.contradictions import FARTHER, contradictions
from elastic_tendon.diagnosis.data import Data
from elastic_tendon.diagnosis.evidence import (
    MUCH,
    PLAUSIBLE,
    beside_unknown,
    implausible_values,
    is_plausible,
    probabilities,
)
from elastic_tendon.diagnosis.experiment import next_experiment
from elastic_tendon.diagnosis.lack_of_fit import LackOfFit
from elastic_tendon.diagnosis.learned import learn
from elastic_tendon.diagnosis.options import Options
from elastic_tendon.diagnosis.remaining_text import remaining_sentences
from elastic_tendon.diagnosis.result import (
    Diagnosis,
    Experiment,
    LearnedTerm,
    RecordingSummary,
    Remaining,
    Round,
    Verdict,
    WouldShow,
)
from elastic_tendon.diagnosis.rounds import as_sure, neighbours_of
from elastic_tendon.diagnosis.search import Search
from elastic_tendon.diagnosis.separation import Rival
from elastic_tendon.diagnosis.sets import Set, in_order, model_with
from elastic_tendon.diagnosis.torque_screen import revealing
from elastic_tendon.diagnosis.trajectory_screen import TrajectoryScreen
from elastic_tendon.diagnosis.verdict import (
    LEFT,
    changed_parameters,
    contradicting_of,
    fails_elsewhere,
    fall,
    matters_somewhere,
    no_chance,
    only_chance,
    remaining_of,
    sentence_of,
    unexplained,
    verdict_of,
)
from elastic_tendon.estimation.add import named_after, with_estimates
from elastic_tendon.estimation.ladder import AS_GIVEN, FittedStep, climb
from elastic_tendon.measurement import Measurement
from elastic_tendon.measurement.noise import NoiseFloor
from elastic_tendon.misreadings.constants import explained_by
from elastic_tendon.progress import Progress

CLOSER = 4  # steps from a typical size to the one that would show
# samples of a held-out recording on which a search that was stopped seeks the constant that
# explains it: whoever stopped it waits
SOON = 5_000
LEFT_OPEN = (
    "The parameters as fitted do not explain {}, which was held out; fitted to all recordings they "
    "do: the fitted ones leave them open. Fit both together before you use them."
)
RIVALS = 5  # answers at most that one experiment is to tell apart


@dataclass
class Found:
    """What a diagnosis has so far; an interrupt leaves it as it is.

    `ladder` : title, effect that came in, and answer of each step after the model as given.
    `alike` : answers that cannot be told apart, the one taken first. `confirmed` : sets -> fits to
    everything, where the search worked on excerpts.
    """

    ladder: list[tuple[str, str | None, Answer]] = field(default_factory=list)
    rounds: list[Round] = field(default_factory=list)
    alike: tuple[Answer, ...] = ()
    confirmed: Mapping[Set, Answer] = field(default_factory=dict)
    lack: Mapping[str, LackOfFit] = field(default_factory=dict)
    learned: LearnedTerm | None = None
    experiment: Experiment | None = None
    no_experiment: str = ""
    would_show: tuple[WouldShow, ...] = ()
    contradictions: Mapping[str, tuple[str, ...]] = field(default_factory=dict)

    @property
    def answer(self) -> Answer:
        """The last one."""
        return self.ladder[-1][2]


def judge(data: Data, search: Search, found: Found, options: Options, report: Progress) -> None:
    """What remains, whether anything can be learned from it, and what would decide."""
    report("judging what remains", 0.0)
    answer = found.answer
    regression = search.regressed(answer)
    found.lack = search.lack_of_fit(answer)
    given, last = compare(data.given, data.fitted), _compared(answer, data.fitted)
    if unexplained(remaining_of(given, last, found.lack, options.least_left)):
        found.learned = learn(regression)
    apart = matters_somewhere(given, last, options.least_left)
    far = search.evidence.heldout_square(answer) > FARTHER**2
    if options.horizon is None and (apart or far):  # windows are no recordings of their own
        everything = (*data.fitted, *data.heldout)
        found.contradictions = contradictions(data.given, answer, everything, report)
    found.would_show = _would_show(search, answer)
    if found.alike:
        proposal = experiment_between(found.alike, found.confirmed, report)
        if isinstance(proposal, str):
            found.no_experiment = proposal
        else:
            found.experiment = proposal
    if data.excerpts:
        title, effect_id, answer = found.ladder[-1]
        whole = found.confirmed.get(answer.added) or on_everything(data, answer, report)
        found.ladder[-1] = (title, effect_id, whole)
        if leaves_far_more(whole, answer):
            found.lack = {name: _at_other_times(lack) for name, lack in found.lack.items()}


def _at_other_times(lack: LackOfFit) -> LackOfFit:
    """Of a signal that errs far more where no excerpt was taken: no noise or disturbance does."""
    return replace(lack, p_value=0.0, significant=True, variables=("time",))


def _compared(answer: Answer, recordings: Sequence[Measurement]) -> Comparison:
    """An answer beside recordings, which begin as the fit found them to where it was to these; each
    has its own zeros, where the fit gave some."""
    result = answer.result
    fitted = result.problem.measurements
    if len(fitted) == len(recordings) and all(map(is_, fitted, recordings)):
        return compare(result.model, recordings, result.initial_states)
    if not result.problem.coordinates.of_recording:
        return compare(result.model, recordings)
    recordings = [part.to_compare(result.model) for part in recordings]
    states = [result.problem.begun(result.model, part) for part in recordings]
    return compare(result.model, recordings, states)


def _improved(answer: Answer, heldout: Comparison | None) -> Model:
    """The model of an answer, with how uncertain it is and what held-out recordings have of their
    own."""
    result = answer.result
    improved = with_estimates(result.model, result.findings.estimates)
    if not result.problem.coordinates.of_recording or heldout is None:
        return improved
    return improved.with_recordings(
        {file.measurement.recording: file.initial_state.own for file in heldout.files}
    )


def _would_show(search: Search, answer: Answer) -> tuple[WouldShow, ...]:
    """For each effect that was not found, the size that would have shown."""
    if answer.added not in search.estimates:
        return ()
    estimate, trajectory = search.estimates[answer.added], TrajectoryScreen(answer)
    sizes = answer.result.problem.coordinates.sizes
    found = []
    for effect_id in search.data.candidates:
        together = in_order((*answer.added, effect_id))
        if effect_id in answer.added or not search.screen.goes(together):
            continue  # it is there, or another law of the same thing is
        search.progress(f"what would have shown: {effects.BY_ID[effect_id].title}", 0.0)
        motion = answer.result.model.motion
        declared = motion.quantities(quantities([effect_id]))
        units = {quantity.path: quantity.unit for quantity in declared}
        path = f"effects.{effect_id}.{effects.BY_ID[effect_id].strength.name}"
        if search.screen.sees(effect_id):
            smallest = search.screen.smallest(estimate, effect_id)
        else:
            smallest = _smallest(search.data, trajectory, answer, effect_id)
        if smallest is not None and not is_plausible(answer.result.model, path, smallest, sizes):
            smallest = None
        found.append(WouldShow(effect_id, path, units[path], smallest))
    return tuple(found)


def _smallest(
    data: Data, trajectory: TrajectoryScreen, answer: Answer, effect_id: str
) -> float | None:
    """Size of an effect that only whole trajectories show, in its unit; see `Screen.smallest`."""
    effect, needed = effects.BY_ID[effect_id], revealing(len(answer.floored))
    together = in_order((*answer.added, effect_id))
    share, size = 1.0, None
    for _ in range(CLOSER):
        (values, *_) = starts(data.given, effect, data.fitted, (share,), dampings=(1.0,))
        added = {f"effects.{effect_id}.{name}": value for name, value in values.items()}
        model = model_with(data.given, together, {**answer.result.model.values(), **added})
        told = trajectory.told(model)
        if not 0.0 < share * needed <= PLAUSIBLE * sqrt(told):
            return None
        share *= needed / sqrt(told)
        size = abs(values[effect.strength.name]) * needed / sqrt(told)
    return size


def experiment_between(
    alike: Sequence[Answer], confirmed: Mapping[Set, Answer], report: Progress
) -> Experiment | str:
    """The experiment that decides between answers that cannot be told apart, or why none can.

    Parameters
    ----------
    alike : two or more, the one taken first
    confirmed : see `Found`
    report : called with words and the share of the work at hand that is done
    """
    answers = [confirmed.get(part.added, part) for part in alike]
    names = different([answer.added for answer in answers])
    rivals = [Rival(name, answer.result) for name, answer in zip(names, answers, strict=True)]
    # beside much that nothing explains two are enough: its noise is not what decides there
    rivals = rivals[: 2 if alike[0].mean_square > MUCH else RIVALS]
    return next_experiment(rivals, rivals[0].fit.problem.measurements, report)


@dataclass(frozen=True)
class _Judged:
    """What an answer is worth. `changed` : parameters that moved and matter, `small` : and do not.
    `elsewhere` : held-out recording on which it fails; `left_open` : one that the fitted recordings
    leave open. `sure` : probability of each effect. `unheard` : answers with an effect more, which
    is there and too small to matter."""

    given: Comparison
    final: Comparison
    remaining: Mapping[str, Remaining]
    recordings: tuple[RecordingSummary, ...]
    verdict: Verdict
    changed: tuple[str, ...]
    small: tuple[str, ...]
    elsewhere: str
    left_open: str
    sure: Mapping[str, float]
    unheard: Sequence[Answer]

    @property
    def matter(self) -> tuple[str, ...]:
        """Parameters that the verdict is about."""
        return () if self.verdict == "adequate" else self.changed

    @property
    def slight(self) -> tuple[str, ...]:
        """Parameters that surely moved and are no matter of the verdict."""
        return (*self.small, *(path for path in self.changed if path not in self.matter))


def conclude(
    data: Data,
    search: Search,
    found: Found,
    options: Options,
    report: Progress,
    *,
    complete: bool,
    notes: Sequence[str] = (),
) -> Diagnosis:
    """All that follows from what was found.

    Parameters
    ----------
    data, search, found : with at least one answer
    options : Options
    report : called with words and the share of the work at hand that is done
    complete : false where more may be missing than was found
    notes : what else is worth telling
    """
    answer = found.answer
    steps = _steps(data, search, found)
    judged = _judged(search, found, options, steps, complete=complete)
    names = different([part.added for part in found.alike])
    tiny = too_small.ids_beside(answer, judged.unheard)
    sentence = _sentence(judged, found, options, names[1:], complete=complete)
    told = (*notes, *_notes(judged, found, options))
    return Diagnosis(
        verdict=judged.verdict,
        sentence=data.given.motion.words(sentence),
        notes=tuple(map(data.given.motion.words, told)),
        given=data.unsettled(data.given),
        model=named_after(data.given, data.unsettled(_improved(answer, steps[-1].heldout))),
        added=_in_order_added(found),
        certainty=judged.sure,
        parameters_changed=judged.matter,
        findings=answer.result.findings,
        steps=steps,
        ladder=climb(steps),
        rounds=tuple(as_sure(entry, judged.sure) for entry in found.rounds),
        neighbours=neighbours_of(search, _searched(search, answer)),
        would_show=found.would_show,
        recordings=judged.recordings,
        remaining=judged.remaining,
        noise=_noise(judged.final),
        comparison=judged.final,
        location=locate(judged.final, report),
        indistinguishable=tuple(filter(None, (tuple(names), tiny if tiny[1:] else ()))),
        next_experiment=found.experiment,
        no_experiment=found.no_experiment,
        learned=found.learned,
        complete=complete,
    )


def _judged(
    search: Search, found: Found, options: Options, steps: Sequence[FittedStep], *, complete: bool
) -> _Judged:
    answer, given, final = found.answer, steps[0].comparison, steps[-1].comparison
    remaining = remaining_of(given, final, found.lack, options.least_left)
    changed, small = changed_parameters(answer, given, options.least_change)
    recordings = _recordings(
        answer.result.model, steps[-1], found.contradictions, None if complete else SOON
    )
    elsewhere = fails_elsewhere(final, steps[-1].heldout, recordings)
    left_open = ""  # by the fitted recordings, which may be all that is wrong elsewhere
    if elsewhere and search.evidence.heldout_square(answer) < LEFT**2:
        left_open, elsewhere = elsewhere, ""
    verdict = verdict_of(
        answer.added, changed, remaining, fall(given, final), options.least_change, elsewhere,
        contradicting_of(recordings), as_given=max(given.noise_ratio().values()),
    )  # fmt: skip
    explained = (
        verdict != "unexplained"
        and only_chance(found.lack)
        and not (_structured(remaining) or elsewhere)
    )
    return _Judged(
        given=given,
        final=final,
        remaining=remaining,
        recordings=recordings,
        verdict=verdict,
        changed=changed,
        small=small,
        elsewhere=elsewhere,
        left_open=left_open,
        sure=certainty(search, answer, found.alike, explained=explained),
        unheard=too_small.answers(search.evidence, answer, list(search.answers.values())),
    )


def _structured(remaining: Mapping[str, Remaining]) -> bool:
    """Whether some of what is left depends on the motion by more than chance."""
    return any(part.significant for part in remaining.values())


def _sentence(
    judged: _Judged, found: Found, options: Options, alike: Sequence[str], *, complete: bool
) -> str:
    return sentence_of(
        judged.verdict,
        found.answer.added,
        judged.sure,
        alike,
        judged.matter,
        judged.given,
        judged.final,
        elsewhere=judged.elsewhere,
        contradicting=contradicting_of(judged.recordings),
        ignored=options.relevance if no_chance(judged.remaining) else None,
        structured=_structured(judged.remaining) or bool(judged.unheard),
        chosen=bool(options.only or options.without),
        complete=complete,
    )


def _notes(judged: _Judged, found: Found, options: Options) -> Iterator[str]:
    """What is worth telling beside the sentence."""
    yield from remaining_sentences(found.lack)
    if judged.left_open:
        yield LEFT_OPEN.format(judged.left_open)
    yield from _slight_shifts(found.answer, judged.slight)
    yield from doubtful_values(found.answer)
    yield from too_small.sentences(found.answer, judged.unheard)
    if options.horizon is None:  # windows are no recordings
        yield from beginning_notes(judged.final)


def certainty(
    search: Search, answer: Answer, alike: Sequence[Answer], *, explained: bool
) -> dict[str, float]:
    """Probability of each effect of an answer, or of what cannot be told from it, among all sets
    that were refitted.

    Parameters
    ----------
    search : Search
    answer : what was found
    alike : answers that the data cannot tell from it
    explained : false where something that no effect explains is left, see `beside_unknown`
    """
    same = {part.added for part in alike}
    answers = search.allowed
    if answer.added not in {part.added for part in answers}:
        return dict.fromkeys(answer.added, 0.0)
    weights = probabilities(search.evidence.of(answers))

    def of(effect_id: str) -> float:
        has = [effect_id in known.added or known.added in same for known in answers]
        share = sum(weight for weight, there in zip(weights, has, strict=True) if there)
        if explained:
            return share
        lacking = (known for known, there in zip(answers, has, strict=True) if not there)
        without = min(known.mean_square for known in lacking)
        return min(share, beside_unknown(without, search.answers[answer.added].mean_square))

    return {effect_id: of(effect_id) for effect_id in answer.added}


def _in_order_added(found: Found) -> tuple[str, ...]:
    came = [effect_id for _, effect_id, _ in found.ladder if effect_id is not None]
    return tuple(dict.fromkeys([*came, *found.answer.added]))


def _slight_shifts(answer: Answer, paths: Sequence[str]) -> Iterator[str]:
    """Parameters that surely moved and do not matter, a sentence each."""
    estimates = {part.path: part for part in answer.result.findings.estimates}
    for path in paths:
        yield (
            f"{path} moved from {estimates[path].given:.4g} to {estimates[path].fitted:.4g}, which "
            "changes the error too little to matter."
        )


def doubtful_values(answer: Answer) -> Iterator[str]:
    """Values of added effects that no real actuator has, or that lie at a bound, each a sentence.

    Parameters
    ----------
    answer : Answer
    """
    implausible = implausible_values(answer)
    for effect_id in answer.added:
        effect = effects.BY_ID[effect_id]
        for parameter in effect.parameters:
            value = answer.values(effect_id)[parameter.name]
            told = f"{effect.title}: {parameter.name.replace('_', ' ')} {value:.3g}"
            unit = unit_suffix(parameter.unit)
            if value in (parameter.lower, parameter.upper) and value != parameter.null:
                yield f"{told}{unit} is at the end of what it may be."
            elif f"effects.{effect_id}.{parameter.name}" in implausible:
                yield f"{told}{unit} is implausible: no real actuator of this size has it."


def _steps(data: Data, search: Search, found: Found) -> tuple[FittedStep, ...]:
    searched = [_searched(search, answer) for _, _, answer in found.ladder]
    values = search.evidence.of(searched, search.allowed)

    def step(
        title: str,
        added: str | None,
        evidence: float | None,
        compared: Callable[[Sequence[Measurement]], Comparison],
    ) -> FittedStep:
        return FittedStep(
            title=title,
            added=added,
            parameters=0 if added is None else len(effects.BY_ID[added].parameters),
            effective=0.0,
            comparison=compared(data.whole),
            heldout=compared(data.heldout) if data.heldout else None,
            evidence=evidence,
        )

    ways = [
        step(title, added, value, partial(_compared, answer))
        for (title, added, answer), value in zip(found.ladder, values, strict=True)
    ]
    return (step(AS_GIVEN, None, None, partial(compare, data.given)), *ways)


def _searched(search: Search, answer: Answer) -> Answer:
    """An answer as it was when others were held against it, before it was confirmed."""
    return search.answers.get(in_order(answer.added), answer)


def _recordings(
    model: Model, last: FittedStep, contradicting: Mapping[str, tuple[str, ...]], judged: int | None
) -> tuple[RecordingSummary, ...]:
    """How the answer does on each; constants are sought on so many of its samples, None: all."""
    rows = []
    for role, comparison in (("fitted", last.comparison), ("validation", last.heldout)):
        for file in comparison.files if isinstance(comparison, Comparison) else ():
            part = file.measurement.samples(slice(judged))
            asked = role == "validation" and model.kind in AS_RECORDED
            constant = explained_by(model, part) if asked else None
            rows.append(
                RecordingSummary(
                    file=file.measurement.name,
                    role="fitted" if role == "fitted" else "validation",
                    rmse={name: error.rmse for name, error in file.signals.items()},
                    explained_by=None if constant is None else constant.kind,
                    sentence="" if constant is None else model.motion.words(constant.sentence),
                    contradicts=contradicting.get(file.measurement.name, ()),
                )
            )
    return tuple(rows)


def _noise(comparison: Comparison) -> dict[str, NoiseFloor]:
    """Noise of each signal over all recordings; its kind is that of the first that has it."""
    sigmas = comparison.pooled(lambda error: error.noise.sigma)
    first = {
        name: error.noise
        for file in reversed(comparison.files)
        for name, error in file.signals.items()
    }
    return {name: replace(first[name], sigma=sigma) for name, sigma in sigmas.items()}


def different(sets: Sequence[Set]) -> list[str]:
    """What sets of effects do not all have, that taken first; "+" between the ids of one. A name is
    missing where a set has no more than all have."""
    common = set.intersection(*map(set, sets)) if sets else set()
    names = ["+".join(effect_id for effect_id in part if effect_id not in common) for part in sets]
    return names if not names or names[0] else names[1:]
