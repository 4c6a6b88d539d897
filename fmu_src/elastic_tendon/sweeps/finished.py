"""A table that a sweep has finished, taken apart again: to add runs, or to do failed ones again."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path
from typing import BinaryIO

import numpy as np
import pandas as pd

from elastic_tendon.errors import SweepError
from elastic_tendon.sweeps.formats import FORMATS, encode_csv
from elastic_tendon.sweeps.parts import Parts, keep, missing, writing
from elastic_tendon.sweeps.store import is_part, read_name
from elastic_tendon.sweeps.task import FAILURE, RUN
from elastic_tendon.sweeps.work import Done, Order, Piece, work

CHUNK = 20_000_000  # bytes of a part
SAMPLE = 8  # runs of a table that are done again, to see whether it is of the same sweep
_GOOD = b",\n"  # how a row of CSV ends that has no failure


@dataclass(frozen=True)
class Chunk:
    """Some runs of a table, of which `failed` failed."""

    piece: Piece
    failed: int
    content: bytes


def runs_in(output: Path) -> int:
    """How many runs a table has; 0 where it is no table of results."""
    try:
        if output.suffix == ".parquet":
            from pyarrow import parquet

            with parquet.ParquetFile(output) as file:
                last = file.read_row_group(file.num_row_groups - 1, columns=[RUN])
            return int(last[RUN][-1].as_py()) + 1
        with output.open("rb") as text:
            if not text.readline().startswith(f"{RUN},".encode()):
                return 0
            text.seek(max(0, output.stat().st_size - 1_000_000))
            return int(text.read().splitlines()[-1].partition(b",")[0]) + 1
    except (OSError, ValueError, IndexError, ImportError, KeyError):
        return 0


def take_apart(order: Order, output: Path, parts: Parts, *, without_failed: bool) -> None:
    """Make parts of a finished table, if some of its runs, done again, are what it says.

    Raises
    ------
    SweepError : the table is of another sweep
    """
    count = runs_in(output)
    probes = set(np.linspace(0, count - 1, min(SAMPLE, count, order.task.batch())).astype(int))
    with writing(output), output.open("rb") as file:
        for chunk in _chunks(output.suffix, file, without_failed=False):
            start, stop = chunk.piece
            for run in sorted(probe for probe in probes if start <= probe < stop):
                _compare(order, output, int(run), chunk.content)
    with writing(output), output.open("rb") as file:
        for chunk in _chunks(output.suffix, file, without_failed=without_failed):
            keep(parts, chunk.piece, chunk.failed, chunk.content)


def drop_failed(parts: Parts) -> None:
    """Forget the runs of parts that failed, so that they are done again."""
    with writing(parts.store):
        for name in [name for name in parts.store.names() if is_part(name)]:
            piece, failed, _ = read_name(name)
            if not failed or missing(parts.share, [piece]) == [parts.share]:
                continue
            content = parts.store.read(name)
            parts.store.remove(name)
            for chunk in _chunks(parts.output.suffix, BytesIO(content), without_failed=True):
                keep(parts, chunk.piece, chunk.failed, chunk.content)


def _compare(order: Order, output: Path, run: int, content: bytes) -> None:
    kept = _text_of(output.suffix, content, run)
    if kept[FAILURE].iloc[0]:  # a failure may have been of that night
        return
    again = work(order, run, run + 1)
    if isinstance(again, Done) and not kept.equals(_text_of(output.suffix, again.content, run)):
        raise SweepError(
            f"{output}: run {run} of this table is not what this sweep gives, so nothing can be "
            "added to it; give --force to replace it, or name another output"
        )


def _text_of(suffix: str, content: bytes, run: int) -> pd.DataFrame:
    """Rows of a run, as text."""
    if suffix == ".parquet":
        content = encode_csv(pd.read_parquet(BytesIO(content)))
    table = pd.read_csv(BytesIO(content), dtype=str, keep_default_na=False)
    return table[table[RUN] == str(run)].reset_index(drop=True)


def _chunks(suffix: str, file: BinaryIO, *, without_failed: bool) -> Iterator[Chunk]:
    rows = _rows_csv(file) if suffix == ".csv" else _rows_parquet(file)
    gathered = _Gathered(suffix)
    for row in rows:
        if without_failed and row.failed:
            yield from gathered.taken()
            continue
        if row.first not in (gathered.last, gathered.last + 1) or (
            gathered.size > CHUNK and row.first > gathered.last
        ):
            yield from gathered.taken()
        gathered.add(row)
    yield from gathered.taken()


@dataclass(frozen=True)
class _Rows:
    """Rows of the runs `first` to `last`, all good or one that `failed`."""

    first: int
    last: int
    failed: bool
    content: bytes | pd.DataFrame
    header: bytes = b""


@dataclass
class _Gathered:
    """Rows of runs without a gap."""

    suffix: str
    rows: list[_Rows] = field(default_factory=list)
    size: int = 0

    @property
    def last(self) -> int:
        return self.rows[-1].last if self.rows else -2

    def add(self, rows: _Rows) -> None:
        self.rows.append(rows)
        content = rows.content
        self.size += len(content) if isinstance(content, bytes) else 8 * content.size

    def taken(self) -> Iterator[Chunk]:
        """What is gathered, which is then forgotten."""
        rows, self.rows, self.size = self.rows, [], 0
        if not rows:
            return
        if self.suffix == ".csv":
            lines = [row.content for row in rows if isinstance(row.content, bytes)]
            content = b"".join((rows[0].header, *lines))
        else:
            tables = [row.content for row in rows if isinstance(row.content, pd.DataFrame)]
            content = FORMATS[self.suffix].encode(pd.concat(tables, ignore_index=True))
        failed = sum(row.failed for row in rows)
        yield Chunk((rows[0].first, rows[-1].last + 1), failed, content)


def _rows_csv(file: BinaryIO) -> Iterator[_Rows]:
    header = file.readline()
    for line in file:
        run = int(line.partition(b",")[0])
        yield _Rows(run, run, not line.endswith(_GOOD), line, header)


def _rows_parquet(file: BinaryIO) -> Iterator[_Rows]:
    """Stretches of good rows, and each failed one; a run that two groups share comes twice."""
    from pyarrow import parquet

    with parquet.ParquetFile(file) as groups:
        for number in range(groups.num_row_groups):
            table = groups.read_row_group(number).to_pandas()
            bad = (table[FAILURE] != "").to_numpy()
            begins = bad | np.concatenate(([True], bad[:-1]))
            stretches = np.cumsum(begins)
            for _, stretch in table.groupby(stretches, sort=False):
                runs = stretch[RUN]
                failed = bool(stretch[FAILURE].iloc[0])
                yield _Rows(int(runs.iloc[0]), int(runs.iloc[-1]), failed, stretch)
