"""Parquet comes back with types, units and times; a damaged file is refused."""

from decimal import Decimal
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from whole import assert_refused, truncated, whole

from elastic_tendon.measurement.formats import open_source, parquet

N = 1000


def write(path: Path) -> Path:
    fields = [
        pa.field("time", pa.timestamp("us")),
        pa.field("q", pa.float64(), metadata={"unit": "deg"}),
        pa.field("count", pa.int32()),
        pa.field("on", pa.bool_()),
        pa.field("price", pa.decimal128(5, 2)),
        pa.field("label", pa.string()),
        pa.field("list", pa.list_(pa.float64())),
    ]
    index = range(N)
    columns = [
        [1_700_000_000_000_000 + 500 * i for i in index],
        [0.1 * i for i in index],
        [None if i == 4 else i for i in index],
        [i % 2 == 0 for i in index],
        [Decimal(i % 100) / 4 for i in index],
        [f"run {i // 500}" for i in index],
        [[1.0]] * N,
    ]
    arrays = [pa.array(c, field.type) for c, field in zip(columns, fields, strict=True)]
    pq.write_table(pa.Table.from_arrays(arrays, schema=pa.schema(fields)), path)
    return path


def test_numbers_units_and_text_come_back(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setattr(parquet, "CHUNK_ROWS", 300)
    source = open_source(write(tmp_path / "run.parquet"))
    (group,) = source.groups
    assert group.columns == ("time", "q", "count", "on", "price", "label")
    assert group.units == {"time": "s", "q": "deg"}
    assert group.rows == N
    assert source.first_row == 1
    table = whole(source)
    assert np.allclose(np.diff(table["time"]), 5e-4, atol=5e-7)
    assert table["time"][0] == 1_700_000_000.0
    assert np.array_equal(table["q"], [0.1 * i for i in range(N)])
    assert np.flatnonzero(np.isnan(table["count"])).tolist() == [4]
    assert table["on"][:3].tolist() == [True, False, True]
    assert table["on"].dtype == bool
    assert table["price"][1] == 0.25
    assert table["label"][-1] == "run 1"


def test_progress_is_told_by_rows(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setattr(parquet, "CHUNK_ROWS", 250)
    source = open_source(write(tmp_path / "run.parquet"))
    shares: list[float] = []
    lengths = [len(c["q"]) for c in source.read("", ["q"], lambda _t, s: shares.append(s))]
    assert lengths == [250] * 4
    assert shares == [0.25, 0.5, 0.75, 1.0]


def test_a_truncated_file_is_refused(tmp_path: Path) -> None:
    path = write(tmp_path / "run.parquet")
    assert_refused(truncated(path), "Parquet file is damaged or not complete; export it again")


def test_damage_inside_is_refused_on_reading(tmp_path: Path) -> None:
    path = write(tmp_path / "run.parquet")
    content = bytearray(path.read_bytes())
    content[4:2000] = b"\xff" * 1996
    path.write_bytes(content)
    assert_refused(path, "Parquet file is damaged or not complete")


def test_duplicate_columns_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "run.parquet"
    pq.write_table(pa.Table.from_arrays([pa.array([1.0])] * 2, names=["q", "q"]), path)
    assert_refused(path, "columns 1 and 2 are both called q")
