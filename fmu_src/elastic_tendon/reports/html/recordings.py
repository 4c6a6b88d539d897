"""What a report says of recordings: the overlay, where the model fails, how they were read."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import tomli_w

from elastic_tendon.comparison.comparison import Comparison, FileComparison
from elastic_tendon.comparison.locate import FileLocation, Location
from elastic_tendon.measurement.preparation import preparation_json
from elastic_tendon.reports.comparison_tables import (
    OVER_ALL,
    bin_tables,
    error_table,
    noise_sentence,
    sentences,
)
from elastic_tendon.reports.html.blocks import (
    Block,
    Code,
    Heading,
    Listing,
    Paragraphs,
    Plot,
    Table,
    as_table,
    plot,
)
from elastic_tendon.reports.interactive.loop import torque_loop
from elastic_tendon.reports.interactive.overlay import Run, overlay
from elastic_tendon.reports.interactive.places import error_maps
from elastic_tendon.reports.interactive.residual import residual
from elastic_tendon.reports.interactive.torque import missing_torque
from elastic_tendon.reports.units import SMALL_RATIO, number, shown, times_noise

# signals that are drawn, each with those that repeat it at a fixed ratio
Alike = Mapping[str, Sequence[str]]
MOST = 8  # recordings that are drawn; neither the file nor who reads it bears many more


@dataclass(frozen=True)
class Recording:
    """A recording in a report: what it was used for, "" where all serve the same, and the models
    beside it, the one as given first.
    """

    used: str
    runs: tuple[Run, ...]

    @property
    def file(self) -> FileComparison:
        """Beside the last model."""
        return self.runs[-1].file

    @property
    def title(self) -> str:
        """Its name, and what it was used for."""
        name = self.file.measurement.name
        return f"{name} ({self.used} data)" if self.used else name


def overlays(recordings: Sequence[Recording], alike: Alike) -> Iterator[Block]:
    """Every recording with its simulations and their errors, a figure for each signal."""
    if repeated := _repeating(alike):
        yield Paragraphs(repeated)
    for recording in recordings[:MOST]:
        yield Heading(recording.title)
        for signal in alike:
            if signal not in recording.file.signals:
                continue
            yield _overlay(recording, signal)
            # the error as given is so much larger that it hides the other
            if len(recording.runs) > 1 and not _hidden(recording, signal):
                yield _residual(recording, signal)
    yield from _left_out(len(recordings) - MOST)


def _repeating(alike: Alike) -> tuple[str, ...]:
    """A sentence for each signal that is drawn for others, too."""
    notes = []
    for name, others in alike.items():
        if others:
            words = " and ".join(shown(repeated).words for repeated in others)
            repeat = "repeats" if len(others) == 1 else "repeat"
            notes.append(
                f"The {words} {repeat} the {shown(name).words} at a fixed ratio; what is drawn and "
                "said of the latter holds for the former, too."
            )
    return tuple(notes)


def _hidden(recording: Recording, signal: str) -> bool:
    """Whether the last model's error is a flat line within the noise."""
    return recording.file.signals[signal].noise_ratio < SMALL_RATIO


def _overlay(recording: Recording, signal: str) -> Plot:
    runs = recording.runs
    quantity = shown(signal, static=recording.file.measurement.static)
    sizes = [quantity.error(run.file.signals[signal].rmse) for run in runs]
    ratio = times_noise(recording.file.signals[signal].noise_ratio)
    error = f"the RMS error is {sizes[-1]}, {ratio}."
    if len(runs) > 1:
        error = f"the RMS error is {sizes[0]} {runs[0].label} and {sizes[-1]} {runs[-1].label}, "
        error += f"{ratio}."
        if _hidden(recording, signal):
            error += " The latter is lost in the noise and not drawn alone."
    return plot(
        lambda theme: overlay(runs, signal, theme=theme),
        f"{recording.title}: measured and simulated {quantity.words}, and the error below; {error}",
    )


def _residual(recording: Recording, signal: str) -> Plot:
    last = recording.runs[-1]
    error = recording.file.signals[signal]
    quantity = shown(signal, static=recording.file.measurement.static)
    return plot(
        lambda theme: residual(last, signal, theme=theme),
        f"{recording.title}: the {quantity.words} error {last.label} alone, with the noise behind "
        f"it; at most {quantity.error(error.max_abs)}.",
    )


def _left_out(count: int) -> Iterator[Block]:
    if count > 0:
        text = f"{count} more recordings are not drawn; the option --figures draws all."
        yield Paragraphs((text,), "faint")


# ---- where a model fails -----------------------------------------------------------------------


def places(comparison: Comparison, location: Location, alike: Alike) -> Iterator[Block]:
    """Where a model fails in each recording: in words, on maps, in bins, as a missing torque."""
    located = list(zip(comparison.files, location.files, strict=True))
    for file, file_location in located[:MOST]:
        yield Heading(file.measurement.name)
        in_words = {name: words for name, words in file_location.in_words.items() if name in alike}
        yield Paragraphs(tuple(sentences(file, replace(file_location, in_words=in_words))))
        yield as_table(error_table(comparison, file))
        if file.selection is not None:
            yield Paragraphs((OVER_ALL,))
        yield _maps(file, file_location)
        for table in bin_tables(file, file_location):
            yield as_table(table)
        if file_location.missing_torque.known:
            if comparison.model.kind.has_springs:
                yield _loop(comparison, file, file_location)
            yield torque(file, file_location)
    yield from _left_out(len(located) - MOST)


def _maps(file: FileComparison, location: FileLocation) -> Plot:
    name = file.measurement.name
    return plot(
        lambda theme: error_maps(file, location, theme=theme),
        f"{name}: maps of the error and of the missing torque over what the joint did.",
    )


def _loop(comparison: Comparison, file: FileComparison, location: FileLocation) -> Plot:
    return plot(
        lambda theme: torque_loop(comparison.model, file, location, theme=theme),
        f"{file.measurement.name}: torque over deflection by slack state, beside the curve of "
        f"{comparison.model.name}.",
    )


def torque(file: FileComparison, location: FileLocation) -> Plot:
    """The torque that a model lacks in a recording, against what the joint did."""
    size = number(float(np.sqrt(np.mean(location.missing_torque.torque**2))))
    return plot(
        lambda theme: missing_torque(file, location, theme=theme),
        f"{file.measurement.name}: torque that the model lacks to move as measured, against what "
        f"the joint did; {size} N·m RMS.",
    )


# ---- how recordings were read ------------------------------------------------------------------


def facts(recordings: Sequence[Recording]) -> Iterator[Block]:
    """Size, rate and noise of each recording, and what was done to it on reading."""
    head = ("recording", "used as", "samples", "duration (s)", "rate (Hz)", "measured signals")
    rows = tuple(_row(recording) for recording in recordings)
    numeric = (False, False, True, True, True, False)
    yield Table("Recordings", head, rows, numeric)
    for recording in recordings:
        measurement = recording.file.measurement
        yield Heading(f"How {measurement.name} was read")
        yield Paragraphs((noise_sentence(recording.file),))
        if measurement.notes:
            yield Listing(tuple(("", note) for note in measurement.notes))
        text = tomli_w.dumps(preparation_json(measurement.preparation)).strip()
        yield Code("Preparation, as a TOML file for --map", text or "# as it stands in the file")


def _row(recording: Recording) -> tuple[str, ...]:
    measurement = recording.file.measurement
    duration = float(measurement.time[-1] - measurement.time[0])
    steps = np.median(np.diff(measurement.time))
    in_time = (
        ("static curve", "-") if measurement.static else (f"{duration:.4g}", f"{1 / steps:.4g}")
    )
    return (
        measurement.name,
        recording.used or "compared",
        str(len(measurement.time)),
        *in_time,
        ", ".join(name.replace("_", " ") for name in measurement.signals),
    )
