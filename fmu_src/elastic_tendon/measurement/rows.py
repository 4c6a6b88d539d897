"""From rows of a file to signals on clocks: runs apart, cut to the window, every row looked at.

Chunks are converted and cut as they come, and averaged where the recording is resampled, so the
memory needed is that of what is kept.
"""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from elastic_tendon.errors import MeasurementError
from elastic_tendon.measurement.columns import RUN, Column, Layout
from elastic_tendon.measurement.formats import Source
from elastic_tendon.measurement.formats.base import Chunk
from elastic_tendon.measurement.preparation import Preparation
from elastic_tendon.measurement.tracks import Array, Bins, Track, reduced
from elastic_tendon.progress import Progress

Numbers = NDArray[np.intp]
# "1" and "1.0" are one run, "01" is a name
_WHOLE_NUMBER = re.compile(r"-?(?:0|[1-9][0-9]*)(?:\.0*)?")
_NO_CELL = np.array([np.nan])
_KINDS = {"boolean": "truth values", "complex": "complex numbers"}
_WITH_UNIT = re.compile(r"\s*[-+.0-9eE]+ ?[A-Za-z]+\s*|\s*[0-9]+:[0-9:.]+\s*")

Label = int | str | None  # of a run; None: the file has no runs

# samples kept of a file: hours at 1 kHz, and some two gigabytes with all that is made of them
MAXIMUM_SAMPLES = 12_000_000


@dataclass(frozen=True)
class _Part:
    """Some rows: the cells of each column, and the rows' numbers in messages."""

    cells: Chunk
    numbers: Numbers

    def rows(self, keep: NDArray[np.bool_]) -> "_Part":
        return _Part({name: raw[keep] for name, raw in self.cells.items()}, self.numbers[keep])


@dataclass
class _Rows:
    """What was read of one group in one run, so far."""

    times: list[Array] = field(default_factory=list)
    values: dict[str, list[Array]] = field(default_factory=dict)
    bins: dict[str, list[Bins]] = field(default_factory=dict)
    # the last row, to which the first of the next chunk is compared
    last_time: float = -np.inf
    last: dict[str, NDArray[Any]] = field(default_factory=dict)
    first_time: float = np.inf
    cut: int = 0
    repeated: int = 0


@dataclass(frozen=True)
class Run:
    """Signals of one run, each on its clock, in the units of the file.

    `span`: first and last time that the file holds; `cut`: rows outside the window;
    `repeated`: rows that stood twice.
    """

    label: Label
    tracks: Mapping[str, Track]
    span: tuple[float, float]
    cut: int
    repeated: int


def read_runs(
    source: Source, layout: Layout, preparation: Preparation, progress: Progress
) -> list[Run]:
    """Read the signals of a file.

    Parameters
    ----------
    source : an opened file
    layout : which column is which signal
    preparation : its window, runs and step are used
    progress : is told the share of the file that is read

    Returns
    -------
    list of Run, in the order in which they begin

    Raises
    ------
    MeasurementError : a row cannot be used, with its number; there are too many; a run is missing
    """
    groups = sorted({column.group for column in layout.signals})
    gathered: list[dict[Label, _Rows]] = []
    for index, group in enumerate(groups):

        def part(text: str, share: float, index: int = index) -> None:
            progress(text, (index + share) / len(groups))

        reader = _GroupReader(source, layout, group, preparation)
        gathered.append(reader.read(part))
    labels = list(dict.fromkeys(label for rows in gathered for label in rows if label is not None))
    wanted = preparation.runs
    for label in wanted or ():
        if label not in labels:
            present = (
                f"found: {', '.join(map(str, labels))}" if labels else "no column is named run"
            )
            raise MeasurementError(f"{source.name}: there is no run {label!r} ({present})")
    taken: list[Label] = [label for label in labels if wanted is None or label in wanted]
    if not labels:
        taken = [None]
    return [_run(label, gathered, layout, preparation.resample) for label in taken]


class _GroupReader:
    """Reads one group chunk by chunk."""

    def __init__(
        self, source: Source, layout: Layout, group: str, preparation: Preparation
    ) -> None:
        self.source = source
        self.group = group
        self.columns = layout.of_group(group)
        self.time = layout.times.get(group)
        self.has_runs = group in layout.runs
        self.preparation = preparation
        self.runs: dict[Label, _Rows] = {}
        self.kept = 0

    def read(self, progress: Progress) -> dict[Label, _Rows]:
        """Read all chunks.

        Raises
        ------
        MeasurementError : see `read_runs`
        """
        names = [column.name for column in self.columns]
        names += [self.time.name] if self.time is not None else []
        names += [RUN] if self.has_runs else []
        row = self.source.first_row
        for chunk in self.source.read(self.group, list(dict.fromkeys(names)), progress):
            count = len(next(iter(chunk.values())))
            numbers = np.arange(row, row + count)
            for label, part in self._parts(chunk, numbers):
                self._take(self.runs.setdefault(label, _Rows()), label, part)
            row += count
        return self.runs

    def _parts(self, chunk: Chunk, numbers: Numbers) -> Iterator[tuple[Label, _Part]]:
        """Rows of each run in a chunk, in their order."""
        if not self.has_runs:
            yield None, _Part(chunk, numbers)
            return
        codes, runs = pd.factorize(chunk[RUN])
        if np.any(codes < 0):
            bad = int(numbers[np.argmax(codes < 0)])
            raise MeasurementError(
                f"{self.source.name}: column run, row {bad} is blank; say to which run it belongs"
            )
        labels = list(map(_label, runs))
        for label in dict.fromkeys(labels):
            alike = [code for code, present in enumerate(labels) if present == label]
            yield label, _Part(chunk, numbers).rows(np.isin(codes, alike))

    def _take(self, into: _Rows, label: Label, part: _Part) -> None:
        """Add the rows of one run in a chunk to what was read."""
        wanted = self.preparation.runs
        if wanted is not None and label is not None and label not in wanted:
            return
        if self.time is None:
            time = part.numbers.astype(np.float64)
        else:
            time = self._numbers(part, self.time, blanks=False)
            if (self.time.factor, self.time.prepared.offset) != (1.0, 0.0):
                time = time * self.time.factor + self.time.prepared.offset
            keep = self._in_order(into, time, part) & self._in_window(into, time)
            if not np.all(keep):
                time, part = time[keep], part.rows(keep)
        resample = self.preparation.resample
        for column in self.columns:
            values = self._numbers(part, column, blanks=resample is not None)
            if resample is None:
                into.values.setdefault(column.signal, []).append(values)
            else:
                there = np.isfinite(values)
                bins = Bins.of(time[there], values[there], resample)
                into.bins.setdefault(column.signal, []).append(bins)
        into.times.append(time if resample is None else time[:0])
        self._count(into, len(time))

    def _count(self, into: _Rows, kept: int) -> None:
        """Refuse more samples than the memory is meant for."""
        if self.preparation.resample is not None:
            kept = max((len(bins[-1].index) for bins in into.bins.values()), default=0)
        self.kept += kept
        if self.kept > MAXIMUM_SAMPLES:
            raise MeasurementError(
                f"{self.source.name}: it holds more than {MAXIMUM_SAMPLES} samples; read a part of "
                f"it with {self.source.name}[start:end] in s, or average it with --resample STEP"
            )

    def _in_window(self, into: _Rows, time: Array) -> NDArray[np.bool_]:
        if len(time):
            into.first_time = min(into.first_time, float(time[0]))
        window = self.preparation.window
        if window is None:
            return np.ones(len(time), dtype=bool)
        keep = (time >= window[0]) & (time <= window[1])
        into.cut += len(time) - int(np.count_nonzero(keep))
        return keep

    def _in_order(self, into: _Rows, time: Array, part: _Part) -> NDArray[np.bool_]:
        """Which rows to keep: not those that repeat the one before; refuses falling times."""
        keep = np.ones(len(time), dtype=bool)
        if len(time) and not (time[0] > into.last_time and np.all(time[1:] > time[:-1])):
            steps = np.diff(time, prepend=into.last_time)
            self._check_forward(steps, time, into.last_time, part.numbers)
            # resampling averages equal times, as of a clock that counts coarsely
            if self.preparation.resample is None:
                keep = steps > 0.0
                self._check_repeated(~keep, into, time, part)
                into.repeated += int(np.count_nonzero(~keep))
        if len(time):
            into.last_time = float(time[-1])
            for column in self.columns:
                into.last[column.signal] = part.cells[column.name][-1:]
        return keep

    def _check_repeated(
        self, again: NDArray[np.bool_], into: _Rows, time: Array, part: _Part
    ) -> None:
        """Refuse a row with the time of the one before and other values."""
        for column in self.columns:
            values = self._numbers(part, column, blanks=True)
            last = pd.to_numeric(into.last.get(column.signal, _NO_CELL), errors="coerce")
            before = np.concatenate([last, values[:-1]])
            same = (values == before) | (np.isnan(values) & np.isnan(before))
            bad = np.flatnonzero(again & ~same)
            if len(bad):
                raise MeasurementError(
                    f"{self.source.name}: the time does not increase at row {part.numbers[bad[0]]} "
                    f"({_seconds(time[bad[0]])} again, with another {column.label}); drop one of "
                    "the two rows, write the time with more digits, or average with --resample STEP"
                )

    def _check_forward(self, steps: Array, time: Array, last: float, numbers: Numbers) -> None:
        bad = np.flatnonzero(steps < 0.0)
        if not len(bad):
            return
        index = int(bad[0])
        before = time[index - 1] if index else last
        backwards = len(bad) > 1 and np.all(steps[1:] <= 0.0)
        whole = "the time runs backwards" if backwards else "the time does not increase"
        raise MeasurementError(
            f"{self.source.name}: {whole} at row {numbers[index]} ({_seconds(time[index])} after "
            f"{_seconds(before)}); sort the rows by time, or, where a new run begins there, "
            "number the runs in a column run"
        )

    def _numbers(self, part: _Part, column: Column, *, blanks: bool) -> Array:
        """Column as numbers; refuses text, infinities and, unless allowed, blanks."""
        raw = part.cells[column.name]
        values: Array
        if raw.dtype.kind == "b":
            raise self._no_numbers(column, "truth values")
        if raw.dtype.kind in "iuf":
            values = raw.astype(np.float64, copy=False)
            blank = np.isnan(values)
        else:
            cells = pd.Series(raw)
            kind = pd.api.types.infer_dtype(cells, skipna=True)
            if kind in ("boolean", "complex"):
                raise self._no_numbers(column, _KINDS[kind])
            values = pd.to_numeric(cells, errors="coerce").to_numpy(dtype=np.float64)
            blank = (cells.isna() | (cells.astype(str).str.strip() == "")).to_numpy()
        bad = ~np.isfinite(values)
        if blanks:
            bad &= ~blank
        if np.any(bad):
            index = int(np.argmax(bad))
            raise self._bad_cell(column, int(part.numbers[index]), raw[index], bool(blank[index]))
        return values

    def _no_numbers(self, column: Column, cell: str) -> MeasurementError:
        return MeasurementError(
            f"{self.source.name}: column {column.label} holds {cell}; {column.signal} needs real "
            f"numbers, choose another column with --map {column.signal}=COLUMN"
        )

    def _bad_cell(self, column: Column, row: int, cell: object, blank: bool) -> MeasurementError:
        content = "no number" if blank else repr(str(cell))
        bridged = column is not self.time and blank
        cure = "; drop the row, or fill it"
        if bridged:
            cure = "; fill it, drop the row, or have blanks bridged with --resample STEP"
        elif _WITH_UNIT.fullmatch(str(cell)):
            cure = "; write plain numbers without a unit, times in s"
        return MeasurementError(
            f"{self.source.name}: column {column.label}, row {row} holds {content}; every sample "
            f"needs a finite number{cure}"
        )


def _label(cell: object) -> int | str:
    """How a preparation writes a run: whole numbers plainly, all else as text."""
    text = str(cell).strip()
    return int(text.partition(".")[0]) if _WHOLE_NUMBER.fullmatch(text) else text


def _seconds(value: float) -> str:
    return f"{value:.15g} s"


def _joined(parts: list[Array]) -> Array:
    return parts[0] if len(parts) == 1 else np.concatenate(parts)


def _run(
    label: Label, gathered: list[dict[Label, _Rows]], layout: Layout, resample: float | None
) -> Run:
    """Join the chunks of one run; a group without runs belongs to every run."""
    parts = [rows.get(label, rows.get(None)) for rows in gathered]
    rows_of_run = [rows for rows in parts if rows is not None]
    tracks: dict[str, Track] = {}
    for rows in rows_of_run:
        if resample is not None:
            tracks |= {signal: reduced(bins, resample) for signal, bins in rows.bins.items()}
        elif rows.times:
            time = _joined(rows.times)
            for signal, values in rows.values.items():
                tracks[signal] = Track(time, _joined(values))
    order = [column.signal for column in layout.signals if column.signal in tracks]
    return Run(
        label,
        {signal: tracks[signal] for signal in order},
        (
            min((rows.first_time for rows in rows_of_run), default=np.inf),
            max((rows.last_time for rows in rows_of_run), default=-np.inf),
        ),
        sum(rows.cut for rows in rows_of_run),
        sum(rows.repeated for rows in rows_of_run),
    )
