"""What every format gives: groups of columns with common rows, read in chunks, unconverted."""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from elastic_tendon.errors import MeasurementError
from elastic_tendon.progress import Progress

Chunk = Mapping[str, NDArray[Any]]

# rows read at a time: a few columns of it fit a cache, and a file of any length the memory
CHUNK_ROWS = 200_000
# more columns than any recording has, few enough to be listed and looked through at once
MAXIMUM_COLUMNS = 10_000


@dataclass(frozen=True)
class Group:
    """Columns that share their rows: a table, an MDF channel group, a ROS topic, a HDF5 group.

    Parameters
    ----------
    name : str; "" where the file is one table
    columns : names, each once
    units : column -> unit as the file itself says it; columns without one are absent
    rows : int, or None where it is not known before reading
    bracketed_units : false where brackets in names are places in a message, such as a joint's
    """

    name: str
    columns: tuple[str, ...]
    units: Mapping[str, str] = field(default_factory=dict)
    rows: int | None = None
    bracketed_units: bool = True


class Source(Protocol):
    """An opened file."""

    @property
    def name(self) -> str:
        """Name of the file, for messages."""

    @property
    def first_row(self) -> int:
        """Number that messages give the first sample: 2 for text, whose header is row 1, else 1."""

    @property
    def groups(self) -> tuple[Group, ...]:
        """What the file holds."""

    def read(self, group: str, columns: Sequence[str], progress: Progress) -> Iterator[Chunk]:
        """Read some columns of a group, chunk by chunk.

        Parameters
        ----------
        group : name of a `Group`
        columns : some of its columns
        progress : is told the share of the file that is read

        Yields
        ------
        column -> (k,) array as the file holds it: numbers, truth values, or objects
        where a cell holds text; k > 0 differs from chunk to chunk

        Raises
        ------
        MeasurementError : the file is damaged; the message names it, and the row where it can
        """


@dataclass(frozen=True)
class FileSource:
    """What all opened files have; each kind adds `read`."""

    path: Path
    groups: tuple[Group, ...]

    @property
    def name(self) -> str:
        return self.path.name

    @property
    def first_row(self) -> int:
        return 1

    def rows_of(self, group: str) -> int | None:
        """Rows of a group, None where they are not known before reading."""
        return next(each.rows for each in self.groups if each.name == group)


def label(group: str, column: str) -> str:
    """Name by which a preparation finds a column."""
    return f"{group}/{column}" if group else column


@contextmanager
def refusing_damage(path: Path, kind: str) -> Iterator[None]:
    """Say in one sentence that a file begins like one of its kind and cannot be read.

    Around a library's calls only: on a damaged file libraries raise whatever they stumble over.
    """
    try:
        yield
    except MeasurementError:
        raise
    except Exception as error:
        raise MeasurementError(
            f"{path.name}: this {kind} is damaged or not complete; export it again"
        ) from error


def check_columns(path: Path, groups: Sequence[Group]) -> tuple[Group, ...]:
    """Pass on the groups of a file that has columns to choose from, by names that distinguish them.

    Raises
    ------
    MeasurementError : there is no column, there are too many, or two of a group share a name
    """
    count = sum(len(group.columns) for group in groups)
    if not count:
        raise MeasurementError(
            f"{path.name}: it holds no columns of numbers; it needs one array for each signal"
        )
    if count > MAXIMUM_COLUMNS:
        raise MeasurementError(too_many_columns(path, f"{count}"))
    for group in groups:
        name, times = Counter(group.columns).most_common(1)[0]
        if times > 1:
            places = [str(i + 1) for i, column in enumerate(group.columns) if column == name]
            raise MeasurementError(
                f"{path.name}: columns {' and '.join(places)} are both called {name}; "
                "rename all but one"
            )
    return tuple(groups)


def too_many_columns(path: Path, count: str) -> str:
    """Sentence that refuses a file with too many columns."""
    return (
        f"{path.name}: it has {count} columns and may have {MAXIMUM_COLUMNS}; save time and the "
        "signals that are needed"
    )


def as_numbers(values: NDArray[Any]) -> NDArray[Any]:
    """Numbers as doubles, truth values as they are, all else as objects."""
    if values.dtype.kind == "b":
        return values
    return values.astype(np.float64 if values.dtype.kind in "uif" else object, copy=False)


def row_ranges(rows: int, path: Path, progress: Progress) -> Iterator[slice]:
    """Rows of one chunk after the other; reports the share of them that is read."""
    for start in range(0, rows, CHUNK_ROWS):
        stop = min(start + CHUNK_ROWS, rows)
        yield slice(start, stop)
        progress(reading(path), stop / rows)


def reading(path: Path) -> str:
    """Text that a `Progress` shows while a file is read."""
    return f"reading {path.name}"
