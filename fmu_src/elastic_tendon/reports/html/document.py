"""The report of a diagnosis and that of a comparison: which sections, in which order."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace

from elastic_tendon.actuator.parameters import Model
from elastic_tendon.comparison.comparison import Comparison
from elastic_tendon.comparison.locate import Location
from elastic_tendon.diagnosis.result import Diagnosis
from elastic_tendon.fmu.live import runs_in_page
from elastic_tendon.progress import Progress, silent
from elastic_tendon.reports.comparison_tables import repeats, summary_sentences
from elastic_tendon.reports.diagnosis_tables import doubt_sentences, meant, size_sentences
from elastic_tendon.reports.first_screen import of_diagnosis
from elastic_tendon.reports.html import papers
from elastic_tendon.reports.html.answers import equations, linear_models, numbers
from elastic_tendon.reports.html.blocks import (
    Beside,
    Block,
    Code,
    Heading,
    Listing,
    Paragraphs,
    Section,
    Table,
)
from elastic_tendon.reports.html.evidence import glance, rounds, steps, sureness
from elastic_tendon.reports.html.live import live
from elastic_tendon.reports.html.origin import Origin
from elastic_tendon.reports.html.page import page
from elastic_tendon.reports.html.recordings import Alike, Recording, facts, overlays, places, torque
from elastic_tendon.reports.interactive.overlay import Run
from elastic_tendon.reports.worded import worded_blocks

Part = tuple[str, str, Callable[[], Iterable[Block]]]  # anchor, title, what makes its blocks


def diagnosis_document(
    diagnosis: Diagnosis, where: Location, origin: Origin, progress: Progress = silent
) -> str:
    """The report of a diagnosis.

    Parameters
    ----------
    diagnosis : Diagnosis
    where : Location of ``diagnosis.steps[0].comparison``: where the model fails as given
    origin : Origin
    progress : told what is being made, and the share of all that is done

    Returns
    -------
    str, an HTML file
    """
    used = _recordings(diagnosis)
    alike = repeats([recording.runs[0].file for recording in used])
    parts: tuple[Part, ...] = (
        ("verdict", "Verdict", lambda: _verdict(diagnosis, origin, alike)),
        ("overlay", "Measured and simulated", lambda: overlays(used, alike)),
        ("live", "Try the model", lambda: _live(diagnosis, progress)),
        ("where", "Where the model as given fails", lambda: _where(diagnosis, where, alike)),
        ("effects", "What would explain it", lambda: rounds(diagnosis)),
        ("sure", "How sure the answer is", lambda: sureness(diagnosis)),
        (
            "ladder",
            "The error after each step",
            lambda: steps(diagnosis.ladder, alike, static=_static(diagnosis)),
        ),
        ("parameters", "Parameters of the improved model", lambda: numbers(diagnosis)),
        ("equations", "What was added", lambda: equations(diagnosis)),
        ("linear", "Linear models", lambda: linear_models(diagnosis)),
        ("data", "Data, and how to repeat this", lambda: _data(used, origin)),
        ("papers", "Papers", lambda: [_papers_of(diagnosis)]),
    )
    heading = f"Diagnosis of {diagnosis.given.name}"
    return _written(heading, parts, origin, diagnosis.model, progress)


def comparison_document(
    comparison: Comparison, where: Location, origin: Origin, progress: Progress = silent
) -> str:
    """The report of a comparison.

    Parameters
    ----------
    comparison : Comparison
    where : Location of the same comparison
    origin : Origin
    progress : told what is being made, and the share of all that is done

    Returns
    -------
    str, an HTML file
    """
    model = comparison.model
    used = [Recording("", (Run(model.name, file),)) for file in comparison.files]
    alike = repeats(comparison.files)
    sentences = tuple(summary_sentences(comparison))
    literature = (
        papers.MODEL,
        *papers.of_effects(model.effect_ids),
        *papers.COMPARISON,
        papers.SOLVER,
    )
    parts: tuple[Part, ...] = (
        ("verdict", "Verdict", lambda: [Paragraphs(sentences, "verdict")]),
        ("overlay", "Measured and simulated", lambda: overlays(used, alike)),
        ("live", "Try the model", lambda: live(model, comparison.files, (), progress)),
        ("where", "Where the model fails", lambda: places(comparison, where, alike)),
        ("data", "Data, and how to repeat this", lambda: _data(used, origin)),
        ("papers", "Papers", lambda: [Listing(literature)]),
    )
    heading = f"{model.name} beside measurements"
    return _written(heading, parts, origin, model, progress)


def _written(
    title: str, parts: Sequence[Part], origin: Origin, model: Model, progress: Progress
) -> str:
    shown = {"linear": model.kind.has_springs, "live": runs_in_page(model)}
    possible = [part for part in parts if shown.get(part[0], True)]
    sections = []
    for index, (anchor, heading, make) in enumerate(possible):
        progress(f"report: {heading}", index / len(possible))
        sections.append(Section(anchor, heading, worded_blocks(tuple(make()), model.motion)))
    software = origin.software["elastic-tendon"]
    return page(title, f"Made by elastic-tendon {software} on {origin.made}", sections)


# ---- of a diagnosis ----------------------------------------------------------------------------


def _without_repeats(diagnosis: Diagnosis, alike: Alike) -> Diagnosis:
    """The same without the errors of signals that repeat others."""
    steps = tuple(
        replace(step, rmse={name: error for name, error in step.rmse.items() if name in alike})
        for step in diagnosis.ladder
    )
    remaining = {name: left for name, left in diagnosis.remaining.items() if name in alike}
    return replace(diagnosis, ladder=steps, remaining=remaining)


def _verdict(diagnosis: Diagnosis, origin: Origin, alike: Alike) -> Iterator[Block]:
    once = _without_repeats(diagnosis, alike)
    verdict = Paragraphs(of_diagnosis(once).sentences, "verdict")
    # how far the error fell, at a glance
    if len(once.ladder) > 1:
        yield Beside(verdict, glance(once.ladder, static=_static(diagnosis)))
    else:
        yield verdict
    if more := (*size_sentences(once), *doubt_sentences(once)):
        yield Paragraphs(more)
    if origin.advice:
        yield Heading("What to do next")
        yield Paragraphs(origin.advice)


def _static(diagnosis: Diagnosis) -> bool:
    return all(file.measurement.static for file in diagnosis.comparison.files)


def _recordings(diagnosis: Diagnosis) -> list[Recording]:
    """Fitted and held-out recordings, each beside the models as given and as improved."""
    ends = [("as given", diagnosis.steps[0])]
    if len(diagnosis.steps) > 1:
        ends.append(("improved", diagnosis.steps[-1]))
    sections = []
    for used in ("fitted", "held-out"):
        beside = [
            (label, step.comparison if used == "fitted" else step.heldout) for label, step in ends
        ]
        files = [
            [Run(label, file) for file in compared.files]
            for label, compared in beside
            if compared is not None
        ]
        sections += [Recording(used, runs) for runs in zip(*files, strict=True)]
    return sections


def _where(diagnosis: Diagnosis, where: Location, alike: Alike) -> Iterator[Block]:
    yield from places(diagnosis.steps[0].comparison, where, alike)
    if len(diagnosis.steps) > 1 and any(
        remaining.significant for remaining in diagnosis.remaining.values()
    ):
        yield Heading("What the improved model still lacks")
        yield torque(diagnosis.comparison.files[0], diagnosis.location.files[0])


def _live(diagnosis: Diagnosis, progress: Progress) -> Iterator[Block]:
    files = diagnosis.steps[-1].comparison.files
    return live(diagnosis.model, files, diagnosis.findings.estimates, progress)


def _papers_of(diagnosis: Diagnosis) -> Listing:
    considered = [*diagnosis.model.effect_ids, *meant(diagnosis)]
    return Listing(
        (
            papers.MODEL,
            *papers.of_effects(considered),
            *papers.DIAGNOSIS,
            *papers.COMPARISON,
            papers.SOLVER,
        )
    )


# ---- of both -----------------------------------------------------------------------------------


def _data(used: Sequence[Recording], origin: Origin) -> Iterator[Block]:
    yield from facts(used)
    yield Heading("What it was made with")
    yield Code("The command", origin.command)
    rows = tuple((file.name, file.purpose, str(file.size), file.checksum) for file in origin.files)
    if rows:
        head = ("file", "used as", "bytes", "SHA-256")
        yield Table("Files that were read", head, rows, (False, False, True, False))
    yield Table(
        "Software",
        ("program", "version"),
        tuple(origin.software.items()),
        (False, False),
    )
