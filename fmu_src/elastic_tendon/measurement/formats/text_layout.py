"""What the first lines of a text tell, separator, names and encoding, and what a row must hold."""

import csv
import re
from dataclasses import dataclass
from pathlib import Path

from elastic_tendon.errors import MeasurementError
from elastic_tendon.measurement.formats.base import MAXIMUM_COLUMNS, too_many_columns

_BYTE_ORDER_MARK = b"\xef\xbb\xbf"
# bytes in a line, at most
LONGEST_LINE = 1 << 20
_OTHER_SEPARATORS = {";": "semicolons", "|": "vertical bars", " ": "spaces"}
DECIMAL_COMMA = re.compile(r"\s*[+-]?\d+,\d+(?:[eE][+-]?\d+)?\s*")
_INTEGER = re.compile(r"\s*[+-]?\d+(?:[eE][+-]?\d+)?\s*")
_NUMBER = re.compile(r"\s*[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?\s*")


@dataclass(frozen=True)
class Layout:
    """How a file is laid out: what its first lines tell."""

    names: tuple[str, ...]
    separator: str
    encoding: str
    start: int  # byte where the samples begin
    first_row: int  # row of the first sample, counted from 1 with the header


def read_layout(path: Path) -> Layout:
    """Read the header and the first sample.

    The header's length comes first: a line of a million columns is never taken apart.

    Raises
    ------
    MeasurementError : there is no header, there are no samples, or the values are separated by
        neither commas nor tabs
    """
    with path.open("rb") as file:
        start = len(_BYTE_ORDER_MARK) if file.peek(3).startswith(_BYTE_ORDER_MARK) else 0
        file.seek(start)
        row = 1
        while not (header := file.readline(LONGEST_LINE)).strip() and header:
            row += 1
        start = file.tell()
        _check_header(path, header, row)
        sample = b""
        sample_row = row
        while not sample.strip() and (sample := file.readline(LONGEST_LINE)):
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
    named = tuple(name or f"column {i + 1}" for i, name in enumerate(names))
    layout = Layout(named, separator, encoding, start, row + 1)
    check_row(path.name, first, layout, sample_row)
    return layout


def _check_header(path: Path, header: bytes, row: int) -> None:
    separators = max(header.count(separator) for separator in (b",", b"\t", b";"))
    if separators >= MAXIMUM_COLUMNS:
        count = f"{separators + 1}" if header.endswith(b"\n") else f"more than {separators}"
        raise MeasurementError(too_many_columns(path, count))
    if not header.endswith(b"\n") and len(header) == LONGEST_LINE:
        raise long_line(path, row)
    if b"\0" in header:
        raise MeasurementError(
            f"{path.name}: this is no text, nor any other format that is read; save the table as "
            "CSV"
        )
    if b"\r" in header.rstrip(b"\r\n"):
        raise MeasurementError(
            f"{path.name}: its lines end with a carriage return alone; save it with line feeds"
        )
    if header.lower().startswith(b"sep="):
        raise MeasurementError(
            f"{path.name}: row {row} is {header.decode('latin-1').strip()!r}, which only "
            "spreadsheets read; remove this row, so that the first one names the columns"
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
        separator = next((candidate for candidate in (";", "|") if candidate in sample), " ")
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
    line = line.rstrip("\r\n")
    try:
        return next(csv.reader([line], delimiter=separator, skipinitialspace=True), [])
    except csv.Error:  # a carriage return within, or a cell as long as a book
        return line.split(separator)


def check_row(source: str, line: str, layout: Layout, row: int) -> None:
    """Refuse a row that has not as many values as the header has names.

    Parameters
    ----------
    source : name of the file
    line : the row's text
    layout : of the file
    row : its number

    Raises
    ------
    MeasurementError : it has more or fewer; decimal commas are told as such
    """
    cells, names = _cells(line, layout.separator), layout.names
    if len(cells) == len(names):
        return
    if len(names) < len(cells) <= 2 * len(names) and all(map(_INTEGER.fullmatch, cells)):
        raise decimal_commas(source, row, ",".join(cells[-2:]))
    raise MeasurementError(
        f"{source}: row {row} holds {len(cells)} values and the header {len(names)} names; give "
        "every row one value for each name"
    )


def decimal_commas(source: str, row: int, cell: str) -> MeasurementError:
    """Say where decimal commas are, with one of them."""
    return MeasurementError(
        f"{source}: row {row} seems to have decimal commas ({cell.strip()}); save it with decimal "
        "points"
    )


def long_line(path: Path, row: int) -> MeasurementError:
    """Say which row has no end in sight."""
    return MeasurementError(
        f"{path.name}: row {row} is longer than {LONGEST_LINE} bytes; this is no table with one "
        "row for each sample"
    )
