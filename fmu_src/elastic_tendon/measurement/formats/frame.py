"""A table in memory: a pandas DataFrame, or a mapping of names to columns."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import pandas as pd

from elastic_tendon.measurement.formats.base import Chunk, Group, as_numbers
from elastic_tendon.progress import Progress


@dataclass(frozen=True)
class FrameSource:
    """The columns of a DataFrame, as if they were those of a file."""

    frame: pd.DataFrame
    name: str = "data frame"
    first_row: int = 1

    @property
    def groups(self) -> tuple[Group, ...]:
        """All columns, by their names."""
        return (Group("", tuple(map(str, self.frame.columns)), rows=len(self.frame)),)

    def read(self, _group: str, columns: Sequence[str], progress: Progress) -> Iterator[Chunk]:
        """All rows at once; they are in memory already."""
        names = {str(column): column for column in self.frame.columns}
        yield {column: as_numbers(self.frame[names[column]].to_numpy()) for column in columns}
        progress(f"reading {self.name}", 1.0)
