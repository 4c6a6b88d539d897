"""A diagnosis for the terminal: the answer in words, then the evidence; 80 columns suffice."""

import shlex
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from rich.markup import escape
from rich.table import Table

from elastic_tendon import effects
from elastic_tendon.actuator.parameters import quantities
from elastic_tendon.actuator.quantity import unit_suffix
from elastic_tendon.diagnosis.result import (
    Candidate,
    Diagnosis,
    Experiment,
    LearnedTerm,
    Round,
)
from elastic_tendon.estimation.determinability import Estimate
from elastic_tendon.reports.recordings import recording_sentences
from elastic_tendon.reports.tables import TIGHT, alias_sentences, with_interval
from elastic_tendon.reports.units import evidence_text, shown, times_noise

# candidates that are shown of a round; the option --all-candidates shows all
CANDIDATES = 5
CHANCE = 0.05  # probability from which on a dependence is not reported
TOO_LITTLE = ", too little to matter"
NONE = "none of them"
LIKELY = 0.5  # probability from which on it needs no word that nothing was added
NAMED = 3  # recordings with values of their own that a sentence lists
SMALLEST = 0.005  # shares below it are shown as "<1 %"


def called(answer: str) -> str:
    """An answer for people: effects by their titles, a parameter by its path.

    Parameters
    ----------
    answer : ids of effects with "+" between them, or the dotted path of a parameter
    """
    return " + ".join(map(_called, ids_in(answer)))


def _called(name: str) -> str:
    effect = effects.BY_ID.get(name)
    return name.removeprefix("transmission.") if effect is None else effect.title


def ids_in(answer: str) -> tuple[str, ...]:
    """Effects of a set whose ids are joined by "+"."""
    return tuple(answer.split("+"))


def size_sentences(diagnosis: Diagnosis) -> Iterator[str]:
    """How large what was added or moved is."""
    if diagnosis.added:
        yield f"Added: {'; '.join(_sized(diagnosis, added) for added in diagnosis.added)}."
    if diagnosis.parameters_changed:
        wrong = diagnosis.verdict == "wrong_parameter"
        estimates = _estimates(diagnosis)
        changes = [
            (_moved if wrong else _shift)(estimates[path]) for path in diagnosis.parameters_changed
        ]
        if wrong:
            yield f"Wrong parameters: {'; '.join(changes)}."
        else:
            yield f"Parameters that are off too: {', '.join(changes)}."


def _estimates(diagnosis: Diagnosis) -> dict[str, Estimate]:
    return {estimate.path: estimate for estimate in diagnosis.findings.estimates}


def _sized(diagnosis: Diagnosis, effect_id: str) -> str:
    """An effect with its parameters, as "Coulomb friction, torque 0.350 ± 0.002 N·m"."""
    numbers = []
    estimates = _estimates(diagnosis)
    for name, value in diagnosis.model.effects[effect_id].items():
        path = f"effects.{effect_id}.{name}"
        estimate = estimates.get(path)
        words = name.replace("_", " ")
        if own := [part for part in diagnosis.findings.of_recordings if part.path == path]:
            numbers.append(f"{words} {_of_recordings(own)}")
        elif estimate is None:
            numbers.append(f"{words} {value:.3g}")
        elif estimate.determined:
            numbers.append(f"{words} {_with_unit(estimate)}")
        else:
            unit = unit_suffix(estimate.unit)
            numbers.append(
                f"{words} about {estimate.fitted:.3g}{unit}, which these data leave open"
            )
    return ", ".join([called(effect_id), *numbers])


def _of_recordings(own: Sequence[Estimate]) -> str:
    """What each recording has of its own, as "0.02 ± 0.001 rad in a.csv, 0.01 ± 0.001 rad in
    b.csv"."""
    if len(own) <= NAMED:
        return ", ".join(f"{_with_unit(part)} in {part.recording}" for part in own)
    low, high = (of(part.fitted for part in own) for of in (min, max))
    return f"{low:.3g} to {high:.3g}{unit_suffix(own[0].unit)}, another in each recording"


def _moved(estimate: Estimate) -> str:
    """A wrong parameter, as "link.inertia is 0.0337 ± 0.0004 kg·m2, not 0.03 (+12 %)"."""
    change = f" ({_change(estimate)})" if estimate.given else ""
    return f"{called(estimate.path)} is {_with_unit(estimate)}, not {estimate.given:.4g}{change}"


def _shift(estimate: Estimate) -> str:
    """A parameter that moved, as "link.inertia by +12 %"."""
    if estimate.given:
        return f"{called(estimate.path)} by {_change(estimate)}"
    return f"{called(estimate.path)} is {_with_unit(estimate)}, not 0"


def _change(estimate: Estimate) -> str:
    percent = 100.0 * (estimate.fitted / estimate.given - 1.0)
    return f"{percent:+.{0 if abs(percent) >= 10.0 else 1}f} %"


def _with_unit(estimate: Estimate) -> str:
    return f"{with_interval(estimate.fitted, estimate.interval)}{unit_suffix(estimate.unit)}"


def doubt_sentences(diagnosis: Diagnosis) -> list[str]:
    """What these data cannot distinguish, what they leave open, which recordings do not fit in,
    and what remains of the error."""
    sentences = []
    for alike in diagnosis.indistinguishable:
        text = indistinguishable_sentence(alike)
        taken = [answer for answer in alike if set(ids_in(answer)) <= set(diagnosis.added)]
        if taken:
            text += f" {called(taken[0])} was added; the others would do as well."
        sentences.append(text)
    changes = {near.change for near in diagnosis.neighbours if near.refitted}
    kind = diagnosis.model.kind
    for effect_id in diagnosis.added:
        refitted = {change.removeprefix(f"{effect_id} -> ") for change in changes}
        sentences += alias_sentences(effects.BY_ID[effect_id], refitted, kind)
    sentences += [diagnosis.no_experiment] * bool(diagnosis.no_experiment)
    sentences += diagnosis.findings.sentences
    sentences += [*recording_sentences(diagnosis.recordings), *diagnosis.notes]
    return [*sentences, *_remains(diagnosis)]


def _remains(diagnosis: Diagnosis) -> Iterator[str]:
    for name, remaining in diagnosis.remaining.items():
        quantity = shown(name)
        text = f"What remains of the {quantity.words} error, {times_noise(remaining.noise_ratio)}, "
        if remaining.p_value is None:
            yield f"{text}was not tested."
        elif remaining.significant:
            yield (
                f"{text}{_dependence(remaining.p_value)} (p = {remaining.p_value:.2g}); "
                f"it is {percent(remaining.share_of_initial)} of the squared error above the "
                f"noise that the model had as given{'' if remaining.matters else TOO_LITTLE}."
            )
            yield from _where(diagnosis, name)
        else:
            yield f"{text}does not depend on what the machine does by more than chance."


def _dependence(p_value: float) -> str:
    if p_value <= CHANCE:
        return "still depends on what the machine does"
    return "is far too large for noise, though what it depends on cannot be told"


def _where(diagnosis: Diagnosis, signal: str) -> Iterator[str]:
    for file, location in zip(diagnosis.comparison.files, diagnosis.location.files, strict=True):
        if signal in location.in_words:
            yield f"{file.measurement.name}: {location.in_words[signal]}."


def indistinguishable_sentence(answers: Sequence[str]) -> str:
    """That data do not tell answers apart; two or more, as of `called`."""
    return f"These data cannot distinguish: {listed(answers)}."


def listed(answers: Sequence[str]) -> str:
    """Answers for people, two or more, as of `called`."""
    return " and ".join([", ".join(map(called, answers[:-1])), called(answers[-1])])


def percent(share: float) -> str:
    """A share for people, 0 to 1 or negative; one that is next to nothing as "<1 %"."""
    if abs(share) < SMALLEST:
        return "<1 %" if share > 0.0 else "0 %"
    return f"{100.0 * share:.0f} %"


# ---- what to do next ---------------------------------------------------------------------------


@dataclass(frozen=True)
class Call:
    """What the user gave and what was written, as words of a command.

    `model` and `data` (one or more) as given; `effects` the options that load the user's own,
    `reading` those about reading data, and `search` those that only a diagnosis has; `saved`,
    `learned` and `experiment` are files that were written, None where none was.
    """

    model: str
    data: tuple[str, ...]
    effects: tuple[str, ...]
    reading: tuple[str, ...]
    saved: str | None
    learned: str | None
    experiment: str | None
    search: tuple[str, ...] = ()

    def line(self, *words: str) -> str:
        """A command to type, with the effects that it needs."""
        return "  " + shlex.join(["elastic-tendon", *words, *self.effects])


def next_lines(diagnosis: Diagnosis, call: Call) -> list[str]:
    """What to do next: sentences, and below them the commands to type.

    Parameters
    ----------
    diagnosis : Diagnosis
    call : Call that made it
    """
    lines = []
    if diagnosis.next_experiment is not None:
        lines += _next_experiment(diagnosis.next_experiment, call)
    if diagnosis.learned is not None:
        lines += _next_learned(diagnosis.learned, call)
    if diagnosis.added:
        lines.append("How to make sure on the machine, and how to be rid of it:")
        lines += [call.line("effects", effect_id) for effect_id in meant(diagnosis)]
    if call.saved is not None:
        fmu = str(Path(call.saved).with_suffix(".fmu"))
        lines += ["To ship the model:", call.line("export", call.saved, "-o", fmu)]
    elif diagnosis.verdict != "adequate":
        lines.append("To keep the improved model, give --save-model improved.toml.")
    return lines


def meant(diagnosis: Diagnosis) -> tuple[str, ...]:
    """Ids of the effects that were added, and of those that could stand in their place."""
    alike = (answer for group in diagnosis.indistinguishable for answer in group)
    rivals = (effect_id for answer in alike for effect_id in ids_in(answer))
    return tuple(dict.fromkeys([*diagnosis.added, *rivals]))


def _next_experiment(experiment: Experiment, call: Call) -> list[str]:
    if call.experiment is None:
        return [experiment.text, "To have it as a table, give --next-experiment experiment.csv."]
    model = call.saved or call.model
    return [
        experiment.text,
        f"Run {call.experiment} on the machine, and diagnose with both recordings:",
        call.line(
            "diagnose", call.model, *call.data, "new_recording.csv", *call.reading, *call.search
        ),
        "What the model does there:",
        call.line("simulate", model, call.experiment, "-o", "predicted.csv"),
    ]


def _next_learned(term: LearnedTerm, call: Call) -> list[str]:
    variables = " and ".join(variable.replace("_", " ") for variable in term.variables)
    text = (
        f"A smooth function of {variables} explains {percent(term.explains)} of what remains, "
        "judged on samples that it was not fitted to."
    )
    if call.learned is None or call.saved is None:
        return [text, "To have it as an effect of your own, give --save-model improved.toml."]
    added = ("-o", "with_learned.toml", "--effect", call.learned)
    return [
        f"{text} It is offered, not added: {call.learned} has it as an effect of your own.",
        call.line("add", call.saved, term.id, *call.data, *call.reading, *added),
    ]


# ---- the evidence ------------------------------------------------------------------------------


def round_title(number_of_round: int, candidate_round: Round) -> str:
    """What a round decided, and why."""
    decided = called("+".join(candidate_round.chosen)) if candidate_round.chosen else "Nothing"
    return f"Round {number_of_round}: {candidate_round.reason}. {decided} was added."


def unsure_sentence(candidate_round: Round) -> str:
    """Why a round added nothing, though its probabilities leave little for that; "" elsewhere."""
    nothing = none_of_them(candidate_round)
    if candidate_round.chosen or not candidate_round.candidates or nothing >= LIKELY:
        return ""
    best = candidate_round.candidates[0]
    return (
        f"Nothing was added although only {percent(nothing)} are left for “{NONE}”: probabilities "
        "are shared out by the evidence alone, and what is added has to be decidedly more than "
        f"chance. The likeliest, {called_set(best)}: {best.reason}."
    )


def called_set(candidate: Candidate) -> str:
    """A candidate for people: the titles of its effects."""
    return called("+".join(candidate.ids))


def candidates_table(candidate_round: Round, *, every: bool = False) -> Table | None:
    """Candidates of a round, with the evidence for each; its numbers, and why, are below its name.

    Parameters
    ----------
    candidate_round : Round
    every : all of them, instead of the first `CANDIDATES`

    Returns
    -------
    Table, or None where there were no candidates
    """
    if not candidate_round.candidates:
        return None
    table = Table(**TIGHT, caption_justify="left")
    table.add_column("candidate", overflow="fold")
    for heading in ("probability", "evidence", "gain\nfitted", "gain\nheld out"):
        table.add_column(heading, justify="right", no_wrap=True)
    chosen = candidate_round.candidates if every else candidate_round.candidates[:CANDIDATES]
    for candidate in chosen:
        below = [*candidate_numbers(candidate), candidate.reason]
        table.add_row(
            escape("\n  ".join([called_set(candidate), *below])),
            percent(candidate.probability),
            evidence_text(candidate.evidence),
            gain(candidate.gain),
            gain(candidate.heldout_gain),
        )
    table.add_row(NONE, percent(none_of_them(candidate_round)), *("-",) * 3)
    captions = [
        "evidence: beside the model before the round, less is better, 10 decide",
        "gain: share by which the squared error falls; held out: on samples that the",
        "fit has not seen, other recordings or one stretch after the other",
    ]
    if left := len(candidate_round.candidates) - len(chosen):
        captions.append(f"{left} more, see --all-candidates")
    table.caption = "\n".join(captions)
    return table


def none_of_them(candidate_round: Round) -> float:
    """Probability, 0 to 1, that no candidate of a round is to be added."""
    return max(0.0, 1.0 - sum(candidate.probability for candidate in candidate_round.candidates))


def gain(share: float | None) -> str:
    """By how much an error falls, "-" where that was not judged."""
    return "-" if share is None else percent(share)


def candidate_numbers(candidate: Candidate) -> Iterator[str]:
    """Estimated parameters with interval; those that the screen expects, where none was fitted."""
    fitted = {estimate.path: estimate for estimate in candidate.fitted_parameters}
    units = _units([*fitted, *candidate.expected_parameters])
    for path in units:
        if path not in fitted:
            text = f"about {candidate.expected_parameters[path]:.3g}{units[path]}"
        elif fitted[path].determined:
            text = with_interval(fitted[path].fitted, fitted[path].interval) + units[path]
        else:
            text = f"{fitted[path].fitted:.3g}{units[path]} (open)"
        yield f"{_short(path)} {text}"


def _short(path: str) -> str:
    """A parameter within its effect, or in the whole model where it is none of an effect's."""
    return (
        path.rpartition(".")[2].replace("_", " ") if path.startswith("effects.") else called(path)
    )


def _units(paths: Sequence[str]) -> Mapping[str, str]:
    """Unit of each parameter as it follows a number."""
    present = {path.split(".")[1] for path in paths if path.startswith("effects.")}
    declared = {quantity.path: quantity.unit for quantity in quantities(present)}
    return {path: unit_suffix(declared[path]) for path in paths}
