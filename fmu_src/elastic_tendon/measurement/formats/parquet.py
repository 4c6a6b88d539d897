"""Parquet: one table with types."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from elastic_tendon.measurement.formats.base import (
    CHUNK_ROWS,
    Chunk,
    FileSource,
    Group,
    as_numbers,
    check_columns,
    reading,
    refusing_damage,
)
from elastic_tendon.progress import Progress

_KIND = "Parquet file"
# bytes of a column read at a time; without it a whole row group is
_BUFFER = 1 << 20
_UNIT_KEYS = (b"unit", b"units")


def open_file(path: Path) -> "ParquetSource":
    """Open a Parquet file; dates and durations become s, since 1970 where they are dates.

    Columns of lists and structures are left out; a field's metadata may name its ``unit``.

    Raises
    ------
    MeasurementError : the file is damaged or holds no usable column
    """
    with refusing_damage(path, _KIND), pq.ParquetFile(path) as file:
        schema, rows = file.schema_arrow, file.metadata.num_rows
    fields = [field for field in schema if not pa.types.is_nested(field.type)]
    units = {field.name: unit for field in fields if (unit := _unit(field))}
    group = Group("", tuple(field.name for field in fields), units, rows)
    return ParquetSource(path, check_columns(path, [group]))


def _unit(field: pa.Field) -> str | None:
    if pa.types.is_timestamp(field.type) or pa.types.is_duration(field.type):
        return "s"
    metadata = field.metadata or {}
    return next((metadata[key].decode() for key in _UNIT_KEYS if key in metadata), None)


class ParquetSource(FileSource):
    """A `Source` of one group without a name."""

    def read(self, group: str, columns: Sequence[str], progress: Progress) -> Iterator[Chunk]:  # noqa: ARG002
        """Read some columns in chunks, see `base.Source`."""
        done, rows = 0, self.groups[0].rows
        with (
            refusing_damage(self.path, _KIND),
            pq.ParquetFile(self.path, buffer_size=_BUFFER, pre_buffer=False) as file,
        ):
            for batch in file.iter_batches(CHUNK_ROWS, columns=list(columns)):
                yield {name: _values(batch.column(name)) for name in columns}
                done += batch.num_rows
                progress(reading(self.path), done / (rows or done))


def _values(column: pa.Array) -> NDArray[Any]:
    kind = column.type
    if pa.types.is_timestamp(kind) or pa.types.is_duration(kind):
        counts = column.cast(pa.int64()).to_numpy(zero_copy_only=False)
        seconds: NDArray[Any] = counts / {"s": 1.0, "ms": 1e3, "us": 1e6, "ns": 1e9}[kind.unit]
        return seconds
    if pa.types.is_decimal(kind):
        column = column.cast(pa.float64())
    return as_numbers(np.asarray(column.to_numpy(zero_copy_only=False)))
