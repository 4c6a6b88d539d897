"""The columns of a file as they stand in it, for users who choose which one is which signal."""

from dataclasses import dataclass
from itertools import islice
from typing import Any

from elastic_tendon.app import results
from elastic_tendon.app.document import Source
from elastic_tendon.app.results import Files
from elastic_tendon.app.workspace import Cache, Result
from elastic_tendon.errors import MeasurementError
from elastic_tendon.measurement.formats import open_source
from elastic_tendon.measurement.formats.base import label
from elastic_tendon.progress import Progress, silent

VALUES = 4  # of a column
COLUMNS = 40  # that are shown
LONGEST = 14  # letters of a cell


@dataclass(frozen=True)
class Beginning:
    """A column of a file: its name and its first values, unconverted."""

    label: str
    values: tuple[str, ...]


def beginnings(source: Source, files: Files) -> Result[tuple[Beginning, ...]]:
    """The first values of the columns of a file; of a column that cannot be read there are none."""

    def compute(cache: Cache, progress: Progress) -> tuple[Beginning, ...]:
        cache.obtain(results.contents(source, files), progress)  # nothing in it crashes a reader
        opened = open_source(files[source.key])
        shown: list[Beginning] = []
        for group in opened.groups:
            columns = group.columns[: COLUMNS - len(shown)]
            if not columns:
                break
            try:
                chunk = next(iter(opened.read(group.name, columns, silent)), {})
            except MeasurementError:
                chunk = {}
            shown += [
                Beginning(
                    label(group.name, column),
                    tuple(map(_cell, islice(chunk.get(column, ()), VALUES))),
                )
                for column in columns
            ]
        return tuple(shown)

    return Result(("beginnings", source.key, source.name), f"looking into {source.name}", compute)


def _cell(value: Any) -> str:
    """A value as the file has it, cut where it is long."""
    try:
        text = f"{float(value):.6g}"
    except (TypeError, ValueError):
        text = str(value)
    return text if len(text) <= LONGEST else f"{text[: LONGEST - 1]}…"
