"""Comma- and tab-separated text.

A file of moderate size that is nothing but numbers, one for each name in each row, is left to
pandas as a whole, which parses it by several threads. Any other is read in blocks of bytes. There
pandas would fill short rows with blanks and, asked for some columns only, overlook values too
many; so the separators of each line are counted, which costs little, and where a number is not that
of the header, the rows of the block are looked at one by one.
"""

import io
import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from elastic_tendon.errors import MeasurementError
from elastic_tendon.measurement.formats import text_layout
from elastic_tendon.measurement.formats.base import (
    Chunk,
    FileSource,
    Group,
    as_numbers,
    check_columns,
    reading,
)
from elastic_tendon.progress import Progress

# bytes of a file that is parsed as a whole, of a block else
_WHOLE = 1 << 27
_BLOCK = 1 << 21
_BLANK = b", \t\r\n"


def open_file(path: Path) -> "TextSource":
    """Open a table of comma- or tab-separated values with a header.

    The text is UTF-8, with or without a mark; where the header is not, Latin-1.

    Raises
    ------
    MeasurementError : there is no header, there are no samples, or the values are separated
        otherwise
    """
    layout = text_layout.read_layout(path)
    groups = check_columns(path, [Group("", layout.names)])
    return TextSource(path, groups, layout)


@dataclass(frozen=True)
class TextSource(FileSource):
    """A `Source` of one group without a name."""

    layout: text_layout.Layout

    @property
    def first_row(self) -> int:
        return self.layout.first_row

    def read(self, group: str, columns: Sequence[str], progress: Progress) -> Iterator[Chunk]:  # noqa: ARG002
        """Read some columns in chunks, see `base.Source`."""
        size = self.path.stat().st_size
        table = self._regular_table() if size <= _WHOLE else None
        if table is not None:
            yield {name: as_numbers(table[name].to_numpy()) for name in columns}
            progress(reading(self.path), 1.0)
            return
        row = self.first_row
        with self.path.open("rb") as file:
            file.seek(self.layout.start)
            while block := _next_block(file, self.path, row):
                chunk = self._parse(block, row, columns)
                yield chunk
                row += len(chunk[columns[0]])
                progress(reading(self.path), file.tell() / size)

    def _regular_table(self) -> pd.DataFrame | None:
        """All columns of a file of numbers only; None where rows must be looked at."""
        # NUL bytes end a number for pandas, which goes on without a word
        with self.path.open("rb") as file:
            while block := file.read(_BLOCK):
                if b"\0" in block:
                    return None
        try:
            # it warns of mixed types and of values that it cuts off
            with warnings.catch_warnings(action="error"):
                table = self._table(self.path, skiprows=self.first_row - 1)
        except (pd.errors.ParserError, pd.errors.ParserWarning, pd.errors.DtypeWarning):
            return None
        numbers = all(dtype.kind in "if" for dtype in table.dtypes)
        # a row too short, or a blank one, has no number at its end
        return table if numbers and not table.iloc[:, -1].hasnans else None

    def _table(self, text: Path | io.BytesIO, **options: Any) -> pd.DataFrame:
        table: pd.DataFrame = pd.read_csv(
            text,
            header=None,
            names=list(self.layout.names),
            index_col=False,
            sep=self.layout.separator,
            encoding=self.layout.encoding,
            encoding_errors="replace",
            skip_blank_lines=False,
            skipinitialspace=True,
            **options,
        )
        return table

    def _parse(self, block: bytes, row: int, columns: Sequence[str]) -> Chunk:
        if b"\0" in block:
            bad = row + block.count(b"\n", 0, block.index(b"\0"))
            raise MeasurementError(
                f"{self.name}: row {bad} holds a NUL byte, which no text has; export it again"
            )
        ends = _places(block, b"\n")
        separators = _places(block, self.layout.separator.encode())
        if not _even(separators, ends, len(self.layout.names) - 1):
            self._check_rows(block, row)
        try:
            table = self._table(io.BytesIO(block), usecols=list(columns), low_memory=False)
        except pd.errors.ParserError as error:
            raise _broken_line(self.name, block, row) from error
        if len(table) != len(ends):
            raise _broken_line(self.name, block, row)
        return {name: self._values(table[name], row) for name in columns}

    def _values(self, column: "pd.Series[Any]", row: int) -> NDArray[Any]:
        values = as_numbers(column.to_numpy())
        if values.dtype == object:
            for i, cell in enumerate(values):
                if isinstance(cell, str) and text_layout.DECIMAL_COMMA.fullmatch(cell):
                    raise text_layout.decimal_commas(self.name, row + i, cell)
        return values

    def _check_rows(self, block: bytes, row: int) -> None:
        """Refuse the first row that has not as many values as the header has names."""
        text = block.decode(self.layout.encoding, errors="replace")
        for i, line in enumerate(text.split("\n")):
            if line.strip():
                text_layout.check_row(self.name, line, self.layout, row + i)


def _places(block: bytes, byte: bytes) -> NDArray[np.intp]:
    return np.flatnonzero(np.frombuffer(block, np.uint8) == ord(byte))


def _even(separators: NDArray[np.intp], ends: NDArray[np.intp], per_line: int) -> bool:
    """Whether every line has so many separators, by the places of these and of the lines' ends."""
    if len(separators) != per_line * len(ends):
        return False
    # the first and the last of those that a line should have lie within it
    table = separators.reshape(len(ends), per_line)
    return bool(np.all(table[:, -1] < ends) and np.all(table[1:, 0] > ends[:-1]))


def _next_block(file: io.BufferedReader, path: Path, row: int) -> bytes:
    """Whole lines, each with its end; blank lines at the end of the file are left away."""
    block = file.read(_BLOCK)
    if block and not block.endswith(b"\n"):
        block += file.readline(text_layout.LONGEST_LINE)
    if block.endswith(b"\n") and file.peek(1):
        return block
    if len(block) - block.rfind(b"\n", 0, -1) > text_layout.LONGEST_LINE:
        raise text_layout.long_line(path, row + block.count(b"\n"))
    end = len(block)
    while end and not block[(start := block.rfind(b"\n", 0, end - 1) + 1) : end].strip(_BLANK):
        end = start
    block = block[:end]
    return block if block.endswith(b"\n") or not block else block + b"\n"


def _broken_line(source: str, block: bytes, row: int) -> MeasurementError:
    """Say where lines and rows part: a quotation mark joins lines, a carriage return parts one."""
    lines = enumerate(block.split(b"\n"), row)
    bad = next((i for i, line in lines if line.count(b'"') % 2 or b"\r" in line[:-1]), row)
    return MeasurementError(
        f"{source}: row {bad} holds a quotation mark without a partner, or a carriage return; give "
        "every sample one line of its own"
    )
