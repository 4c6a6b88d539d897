"""Tables of results as bytes, and many of them put together: CSV and Parquet."""

import shutil
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import Any, BinaryIO

import pandas as pd

ROW_GROUP = 16_000_000  # bytes of a table that Parquet compresses together
NUMBER = 8  # bytes


@dataclass(frozen=True)
class Format:
    """`encode` makes bytes of a table; `join` writes many of them, in order, as one file, whose
    bytes depend on the rows alone and not on how they were cut."""

    encode: Callable[[pd.DataFrame], bytes]
    join: Callable[[Iterable[BinaryIO], Path], None]


def encode_csv(table: pd.DataFrame) -> bytes:
    """A table as text, each number as the shortest text from which the same number is read."""
    return table.to_csv(index=False, lineterminator="\n").encode()


def _join_csv(files: Iterable[BinaryIO], target: Path) -> None:
    with target.open("wb") as output:
        for number, part in enumerate(files):
            header = part.readline()
            if number == 0:
                output.write(header)
            shutil.copyfileobj(part, output)


def _encode_parquet(table: pd.DataFrame) -> bytes:
    import pyarrow as pa
    import pyarrow.parquet as pq

    arrow = pa.Table.from_pandas(table, preserve_index=False)
    # text has several types in pandas, and what pandas notes of them would differ between parts
    kinds = [
        (column.name, pa.string() if _is_text(column.type) else column.type)
        for column in arrow.schema
    ]
    content = BytesIO()
    pq.write_table(arrow.cast(pa.schema(kinds)), content)
    return content.getvalue()


def _is_text(kind: Any) -> bool:
    import pyarrow as pa

    return bool(pa.types.is_string(kind) or pa.types.is_large_string(kind))


def _join_parquet(files: Iterable[BinaryIO], target: Path) -> None:
    import pyarrow.parquet as pq

    writer = None
    with target.open("wb") as output:
        for group in _row_groups(files):
            if writer is None:
                writer = pq.ParquetWriter(output, group.schema)
            writer.write_table(group, row_group_size=group.num_rows)
        if writer is not None:
            writer.close()


def _row_groups(files: Iterable[BinaryIO]) -> Iterator[Any]:
    """Tables of as many rows as a group has, however many each file has."""
    import pyarrow as pa

    waiting: list[Any] = []
    for table in _tables(files):
        rows = max(1, ROW_GROUP // (NUMBER * table.num_columns))
        while table.num_rows:
            free = rows - sum(part.num_rows for part in waiting)
            waiting.append(table.slice(0, free))
            table = table.slice(free)
            if waiting[-1].num_rows == free:
                yield pa.concat_tables(waiting).combine_chunks()
                waiting = []
    if waiting:
        yield pa.concat_tables(waiting).combine_chunks()


def _tables(files: Iterable[BinaryIO]) -> Iterator[Any]:
    import pyarrow.parquet as pq

    for file in files:
        with pq.ParquetFile(file) as parts:
            for group in range(parts.num_row_groups):
                yield parts.read_row_group(group)


FORMATS = {
    ".csv": Format(encode_csv, _join_csv),
    ".parquet": Format(_encode_parquet, _join_parquet),
}
