"""Comma- and tab-separated text.

A file of moderate size that is nothing but numbers, one for each name in each row, is left to
pandas as a whole, which parses it by several threads. Any other is read in blocks of bytes. There
pandas would fill short rows with blanks and, asked for some columns only, overlook values too
many; so the separators of a block are counted, which costs little, and where their number is not
that of the header, its rows are looked at one by one.
"""

import csv
import io
import re
import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from elastic_tendon.errors import MeasurementError
from elastic_tendon.measurement.formats.base import (
    MAXIMUM_COLUMNS,
    Chunk,
    Group,
    Report,
    as_numbers,
    check_columns,
    reading,
    too_many_columns,
)

_BYTE_ORDER_MARK = b"\xef\xbb\xbf"
# bytes of a file that is parsed as a whole, of a block else
_WHOLE = 1 << 27
_BLOCK = 1 << 21
# bytes in a line, at most
_LONGEST_LINE = 1 << 20
_OTHER_SEPARATORS = {";": "semicolons", "|": "vertical bars", " ": "spaces"}
_DECIMAL_COMMA = re.compile(r"\s*[+-]?\d+,\d+(?:[eE][+-]?\d+)?\s*")
_INTEGER = re.compile(r"\s*[+-]?\d+(?:[eE][+-]?\d+)?\s*")
_NUMBER = re.compile(r"\s*[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?\s*")
_BLANK = b" \t\r\n"


@dataclass(frozen=True)
class _Layout:
    """How a file is laid out: what its first lines tell."""

    names: tuple[str, ...]
    separator: str
    encoding: str
    start: int  # byte where the samples begin
    first_row: int  # row of the first sample, counted from 1 with the header


def open_file(path: Path) -> "TextSource":
    """Open a table of comma- or tab-separated values with a header.

    The text is UTF-8, with or without a mark; where the header is not, Latin-1.

    Raises
    ------
    MeasurementError : there is no header, there are no samples, or the values are separated
        otherwise
    """
    layout = _layout(path)
    groups = check_columns(path, [Group("", layout.names)])
    return TextSource(path, layout, groups)


@dataclass(frozen=True)
class TextSource:
    """A `Source` of one group without a name."""

    path: Path
    layout: _Layout
    groups: tuple[Group, ...]

    @property
    def name(self) -> str:
        return self.path.name

    @property
    def first_row(self) -> int:
        return self.layout.first_row

    def read(self, group: str, columns: Sequence[str], report: Report) -> Iterator[Chunk]:  # noqa: ARG002
        """Read some columns in chunks, see `base.Source`."""
        size = self.path.stat().st_size
        table = self._regular_table() if size <= _WHOLE else None
        if table is not None:
            yield {name: as_numbers(table[name].to_numpy()) for name in columns}
            report(reading(self.path), 1.0)
            return
        row = self.first_row
        with self.path.open("rb") as file:
            file.seek(self.layout.start)
            while block := _next_block(file, self.path, row):
                yield self._parse(block, row, columns)
                row += _count(block, b"\n")
                report(reading(self.path), file.tell() / size)

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
        lines = _count(block, b"\n")
        separators = lines * (len(self.layout.names) - 1)
        if _count(block, self.layout.separator.encode()) != separators:
            self._check_rows(block, row)
        try:
            table = self._table(io.BytesIO(block), usecols=list(columns), low_memory=False)
        except pd.errors.ParserError as error:
            raise _broken_line(self.name, block, row) from error
        if len(table) != lines:
            raise _broken_line(self.name, block, row)
        return {name: self._values(table[name], row) for name in columns}

    def _values(self, column: "pd.Series[Any]", row: int) -> NDArray[Any]:
        values = as_numbers(column.to_numpy())
        if values.dtype == object:
            for i, cell in enumerate(values):
                if isinstance(cell, str) and _DECIMAL_COMMA.fullmatch(cell):
                    raise _decimal_commas(self.name, row + i, cell)
        return values

    def _check_rows(self, block: bytes, row: int) -> None:
        """Refuse the first row that has not as many values as the header has names."""
        text = block.decode(self.layout.encoding, errors="replace")
        for i, line in enumerate(text.splitlines()):
            if line.strip():
                cells = _cells(line, self.layout.separator)
                _check_row(self.name, cells, self.layout.names, row + i)


def _count(block: bytes, byte: bytes) -> int:
    # several times as fast as bytes.count
    return int(np.count_nonzero(np.frombuffer(block, np.uint8) == ord(byte)))


def _next_block(file: io.BufferedReader, path: Path, row: int) -> bytes:
    """Whole lines, each with its end; blank lines at the end of the file are left away."""
    block = file.read(_BLOCK)
    if block and not block.endswith(b"\n"):
        block += file.readline(_LONGEST_LINE)
    if block.endswith(b"\n") and file.peek(1):
        return block
    if len(block) - block.rfind(b"\n", 0, -1) > _LONGEST_LINE:
        raise _long_line(path, row + block.count(b"\n"))
    while block and not (last := block[block.rfind(b"\n", 0, -1) + 1 :]).strip(b",;" + _BLANK):
        block = block[: -len(last)]
    return block if block.endswith(b"\n") or not block else block + b"\n"


def _layout(path: Path) -> _Layout:
    """Read the header and the first sample.

    The header's length comes first: a line of a million columns is never taken apart.
    """
    with path.open("rb") as file:
        start = len(_BYTE_ORDER_MARK) if file.peek(3).startswith(_BYTE_ORDER_MARK) else 0
        file.seek(start)
        row = 1
        while not (header := file.readline(_LONGEST_LINE)).strip() and header:
            row += 1
        start = file.tell()
        _check_header(path, header, row)
        sample = b""
        sample_row = row
        while not sample.strip() and (sample := file.readline(_LONGEST_LINE)):
            sample_row += 1
    if not sample.strip():
        raise MeasurementError(
            f"{path.name}: it holds a header and no samples; it needs one row for each sample"
        )
    encoding = _encoding(header)
    text, first = (line.decode(encoding, errors="replace") for line in (header, sample))
    separator = _separator(path.name, text, first, row)
    names = [name.strip() for name in _cells(text, separator)]
    if all(_NUMBER.fullmatch(name) for name in names):
        raise MeasurementError(
            f"{path.name}: row {row} holds numbers; the first row must be a header that names the "
            "columns"
        )
    _check_row(path.name, _cells(first, separator), names, sample_row)
    named = tuple(name or f"column {i + 1}" for i, name in enumerate(names))
    return _Layout(named, separator, encoding, start, row + 1)


def _check_header(path: Path, header: bytes, row: int) -> None:
    separators = max(header.count(separator) for separator in (b",", b"\t", b";"))
    if separators >= MAXIMUM_COLUMNS:
        count = f"{separators + 1}" if header.endswith(b"\n") else f"more than {separators}"
        raise MeasurementError(too_many_columns(path, count))
    if not header.endswith(b"\n") and len(header) == _LONGEST_LINE:
        raise _long_line(path, row)
    if b"\0" in header:
        raise MeasurementError(
            f"{path.name}: this is no text, nor any other format that is read; save the table as "
            "CSV"
        )
    if b"\r" in header.rstrip(b"\r\n"):
        raise MeasurementError(
            f"{path.name}: its lines end with a carriage return alone; save it with line feeds"
        )
    if header.lstrip()[:1] in (b"#", b"%"):
        raise MeasurementError(
            f"{path.name}: row {row} is a comment; the first row must be the header that names the "
            "columns, without a mark before it"
        )


def _encoding(header: bytes) -> str:
    try:
        header.decode("utf-8")
    except UnicodeDecodeError:
        return "latin-1"
    return "utf-8"


def _separator(source: str, header: str, sample: str, row: int) -> str:
    """Comma or tab; any other separator is refused by its name."""
    counts = {separator: header.count(separator) for separator in (",", "\t", ";", "|")}
    separator = max(counts, key=lambda key: counts[key])
    if not counts[separator]:
        if "," in sample or "\t" in sample:
            raise MeasurementError(
                f"{source}: row {row} is no header of the columns below it "
                f"({header.strip()[:40]!r}); remove the rows above the header"
            )
        separator = next((other for other in (";", "|") if other in sample), " ")
        if separator == " " and len(header.split()) < 2:
            raise MeasurementError(
                f"{source}: it has one column, {header.strip()[:40]!r}; it needs time and the "
                "signals, separated by commas"
            )
    if separator in _OTHER_SEPARATORS:
        point = " and decimal points" if re.search(r"\d,\d", sample) else ""
        raise MeasurementError(
            f"{source}: its columns seem to be separated by {_OTHER_SEPARATORS[separator]}; save "
            f"it with commas{point}"
        )
    return separator


def _cells(line: str, separator: str) -> list[str]:
    return next(csv.reader([line.rstrip("\r\n")], delimiter=separator, skipinitialspace=True), [])


def _check_row(source: str, cells: Sequence[str], names: Sequence[str], row: int) -> None:
    if len(cells) == len(names):
        return
    if len(names) < len(cells) <= 2 * len(names) and sum(map(_is_integer, cells)) == len(cells):
        raise _decimal_commas(source, row, ",".join(cells[-2:]))
    raise MeasurementError(
        f"{source}: row {row} holds {len(cells)} values and the header {len(names)} names; give "
        "every row one value for each name"
    )


def _is_integer(cell: str) -> bool:
    return _INTEGER.fullmatch(cell) is not None


def _decimal_commas(source: str, row: int, cell: str) -> MeasurementError:
    return MeasurementError(
        f"{source}: row {row} seems to have decimal commas ({cell.strip()}); save it with decimal "
        "points"
    )


def _broken_line(source: str, block: bytes, row: int) -> MeasurementError:
    """Say where lines and rows part: a quotation mark joins lines, a carriage return parts one."""
    lines = enumerate(block.split(b"\n"), row)
    bad = next((i for i, line in lines if line.count(b'"') % 2 or b"\r" in line[:-1]), row)
    return MeasurementError(
        f"{source}: row {bad} holds a quotation mark without a partner, or a carriage return; give "
        "every sample one line of its own"
    )


def _long_line(path: Path, row: int) -> MeasurementError:
    return MeasurementError(
        f"{path.name}: row {row} is longer than {_LONGEST_LINE} bytes; this is no table with one "
        "row for each sample"
    )
