"""What every format gives: groups of columns with common rows, read in chunks, unconverted."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

from numpy.typing import NDArray

from elastic_tendon.errors import MeasurementError

Report = Callable[[str, float], None]  # what is being done, and the share of all that is done
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
    """

    name: str
    columns: tuple[str, ...]
    units: Mapping[str, str] = field(default_factory=dict)
    rows: int | None = None


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

    def read(self, group: str, columns: Sequence[str], report: Report) -> Iterator[Chunk]:
        """Read some columns of a group, chunk by chunk.

        Parameters
        ----------
        group : name of a `Group`
        columns : some of its columns
        report : is told the share of the file that is read

        Yields
        ------
        column -> (k,) array as the file holds it: numbers, or objects where a cell holds text;
        k > 0 differs from chunk to chunk

        Raises
        ------
        MeasurementError : the file is damaged; the message names it, and the row where it can
        """


def silent(text: str, share: float) -> None:  # noqa: ARG001 - a `Report` that nobody reads
    """Report to nobody."""


def damaged(path: Path, kind: str) -> MeasurementError:
    """Say that a file begins like one of its kind and cannot be read."""
    return MeasurementError(f"{path.name}: this {kind} is damaged or not complete; export it again")


def missing_library(path: Path, kind: str) -> MeasurementError:
    """Say how to install what reads a kind of file."""
    return MeasurementError(
        f"{path.name}: reading {kind} needs a library that is not installed; "
        'pip install "elastic-tendon[formats]"'
    )


def reading(path: Path) -> str:
    """Text that a `Report` shows while a file is read."""
    return f"reading {path.name}"
