"""What is done of a sweep, on disk: one file for each batch, until all are put together."""

import json
import re
import shutil
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from importlib.metadata import version
from importlib.util import find_spec
from io import BytesIO
from pathlib import Path
from typing import Any
from zlib import crc32

import pandas as pd
from filelock import FileLock, Timeout

from elastic_tendon.errors import SweepError
from elastic_tendon.output import OutputError, check_writable, write_file
from elastic_tendon.sweeps.execution import Done, Piece
from elastic_tendon.sweeps.task import FAILURE, Task

DESCRIPTION = "sweep.json"
_NAME = re.compile(r"(\d{12})-(\d{12})-(\d+)-([0-9a-f]{8})\.(csv|parquet)")
_UNFINISHED = ".unfinished"
_ROW_GROUP = 16_000_000  # bytes of a table that Parquet compresses together


@dataclass(frozen=True)
class Parts:
    """The folder beside an output, of one sweep.

    Parameters
    ----------
    folder : has `DESCRIPTION`, and a file for each piece that is done; its name has first run,
        the one after the last, how many failed, and the checksum of its content
    output : where all of it will be put together
    runs : of the whole sweep
    batch : runs of a piece; the last may have fewer
    """

    folder: Path
    output: Path
    runs: int
    batch: int

    @property
    def pieces(self) -> Iterator[Piece]:
        """All pieces of the sweep, in order."""
        for start in range(0, self.runs, self.batch):
            yield start, min(start + self.batch, self.runs)


@dataclass(frozen=True)
class _Format:
    encode: Callable[[pd.DataFrame], bytes]
    join: Callable[[list[Path], Path], None]


def folder_of(output: Path) -> Path:
    """Where the parts of a sweep are until all is done."""
    return output.with_name(f"{output.name}.parts")


@contextmanager
def alone(output: Path) -> Iterator[None]:
    """Let nobody else sweep into this output meanwhile; a process that dies lets go.

    Raises
    ------
    SweepError : another sweep does so now
    OutputError : the folder cannot be written
    """
    path = output.with_name(f"{output.name}.lock")
    lock = FileLock(path)
    with _writing(path):
        try:
            lock.acquire(blocking=False)
        except Timeout:  # to Python an OSError
            raise SweepError(
                f"{output}: another sweep is writing it now; wait for that one, or name another "
                "output"
            ) from None
    try:
        yield
    finally:
        with suppress(OSError):  # where what is open cannot be removed it stays
            path.unlink()
        lock.release()


def check_output(output: Path, *, force: bool) -> None:
    """Refuse, before any work is done, an output that could not be written after it.

    Raises
    ------
    OutputError : it exists and `force` is not given, has no folder, is neither CSV nor Parquet,
        or is Parquet and pyarrow is not installed
    """
    if output.suffix not in _FORMATS:
        raise OutputError(f"{output}: results are written as .csv or .parquet; name such a file")
    if output.suffix == ".parquet" and find_spec("pyarrow") is None:
        raise OutputError(
            f"{output}: Parquet needs pyarrow, which is not installed; "
            'pip install "elastic-tendon[formats]", or name a .csv file'
        )
    check_writable(output, force=force)


def open_parts(task: Task, output: Path, batch: int | None, *, force: bool) -> Parts:
    """The parts of this sweep: those that it has already, or a new folder for them.

    Parameters
    ----------
    task, output : of the sweep
    batch : runs of a piece, from 1, or None for `task.batch()`; where the sweep goes on, the
        batch with which it began is kept
    force : whether parts of another sweep may be removed

    Raises
    ------
    SweepError : the folder has parts of another sweep, and `force` is not given
    OutputError : the folder cannot be written, or has files that no sweep has put there
    """
    folder = folder_of(output)
    wanted = _description(task)
    if folder.exists():
        description = _found(folder)
        different = _differences(wanted, description)
        if not different:
            return Parts(folder, output, task.runs, description["batch"])
        if _files(folder) and not force:
            raise SweepError(
                f"{folder}: here are parts of another sweep (different: {', '.join(different)}); "
                "give --force to remove them and begin anew, or name another output to keep both"
            )
    if batch is None:
        batch = max(1, task.batch())
    with _writing(folder):
        if folder.exists():
            shutil.rmtree(folder)
        folder.mkdir()
        _put(folder / DESCRIPTION, json.dumps({**wanted, "batch": batch}, indent=1).encode())
    return Parts(folder, output, task.runs, batch)


def done_before(parts: Parts) -> dict[Piece, int]:
    """The pieces that are done, and how many runs of each failed; files that are damaged or of
    other batches are removed.

    Raises
    ------
    OutputError : the folder cannot be read or written
    """
    done = {}
    pieces = set(parts.pieces)
    with _writing(parts.folder):
        for path in _files(parts.folder):
            piece, failed, checksum = _read_name(path)
            if piece in pieces and crc32(path.read_bytes()) == checksum:
                done[piece] = failed
            else:
                path.unlink()
    return done


def add(parts: Parts, done: Done) -> int:
    """Keep the results of one piece; the number of its runs that failed.

    Raises
    ------
    OutputError : the folder cannot be written; what was done before is kept
    """
    content = _FORMATS[parts.output.suffix].encode(done.table)
    failed = int((done.table[FAILURE] != "").sum())
    name = f"{done.start:012d}-{done.stop:012d}-{failed}-{crc32(content):08x}"
    with _writing(parts.folder):
        _put(parts.folder / f"{name}{parts.output.suffix}", content)
    return failed


def finish(parts: Parts, *, force: bool) -> None:
    """Put all parts together into the output, in the order of the runs, and remove them.

    Raises
    ------
    SweepError : parts are missing
    OutputError : the output cannot be written; the parts are kept
    """
    files = _files(parts.folder)
    if [_read_name(path)[0] for path in files] != list(parts.pieces):
        raise SweepError(f"{parts.folder}: parts are missing; repeat the command to do them again")
    join = _FORMATS[parts.output.suffix].join
    write_file(parts.output, lambda target: join(files, target), force=force)
    with _writing(parts.folder):
        shutil.rmtree(parts.folder)


def _description(task: Task) -> dict[str, Any]:
    return {
        "elastic-tendon": version("elastic-tendon"),
        "runs": task.runs,
        "identity": dict(task.identity),
    }


def _found(folder: Path) -> dict[str, Any]:
    """What `DESCRIPTION` says; nothing where there is none, or it is damaged."""
    if not folder.is_dir():
        raise OutputError(f"{folder}: this file is where the parts of the sweep go; move it away")
    for path in folder.iterdir():
        if not (path.name == DESCRIPTION or path.suffix == _UNFINISHED or _is_part(path)):
            raise OutputError(f"{path}: no sweep has put this here; move it away")
    try:
        description = json.loads((folder / DESCRIPTION).read_bytes())
        intact = isinstance(description["identity"], dict) and description["batch"] >= 1
    except (FileNotFoundError, ValueError, KeyError, TypeError):
        intact = False
    return description if intact else {}


def _differences(wanted: dict[str, Any], description: dict[str, Any]) -> list[str]:
    """Names of what differs between two descriptions."""
    if not description:
        return [f"{DESCRIPTION} is missing or damaged"]
    asked, kept = wanted["identity"], description["identity"]
    inside = [key for key in {**asked, **kept} if asked.get(key) != kept.get(key)]
    around = [key for key in ("elastic-tendon", "runs") if wanted[key] != description.get(key)]
    return [*around, *inside]


def _is_part(path: Path) -> bool:
    return _NAME.fullmatch(path.name) is not None


def _files(folder: Path) -> list[Path]:
    return sorted(path for path in folder.iterdir() if _is_part(path))


def _read_name(path: Path) -> tuple[Piece, int, int]:
    """Piece, number of failed runs, and checksum of a part."""
    start, stop, failed, checksum, _ = path.name.replace(".", "-").split("-")
    return (int(start), int(stop)), int(failed), int(checksum, 16)


def _put(path: Path, content: bytes) -> None:
    unfinished = path.with_suffix(_UNFINISHED)
    unfinished.write_bytes(content)
    unfinished.replace(path)


@contextmanager
def _writing(folder: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise OutputError(
            f"{folder}: cannot be written ({error.strerror}); what is done is kept, so mend this "
            "and repeat the command to go on"
        ) from error


def _encode_csv(table: pd.DataFrame) -> bytes:
    # pandas writes the shortest text from which the same number is read
    return table.to_csv(index=False, lineterminator="\n").encode()


def _join_csv(files: Iterable[Path], target: Path) -> None:
    with target.open("wb") as output:
        for number, path in enumerate(files):
            with path.open("rb") as part:
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


def _join_parquet(files: list[Path], target: Path) -> None:
    import pyarrow.parquet as pq

    schema = pq.read_schema(files[0])
    with target.open("wb") as output, pq.ParquetWriter(output, schema) as writer:
        for group in _row_groups(files):
            writer.write_table(group)


def _row_groups(files: Iterable[Path]) -> Iterator[Any]:
    import pyarrow as pa
    import pyarrow.parquet as pq

    waiting: list[Any] = []
    for path in files:
        waiting.append(pq.read_table(path))
        if sum(table.nbytes for table in waiting) > _ROW_GROUP:
            yield pa.concat_tables(waiting).combine_chunks()
            waiting = []
    if waiting:
        yield pa.concat_tables(waiting).combine_chunks()


_FORMATS = {
    ".csv": _Format(_encode_csv, _join_csv),
    ".parquet": _Format(_encode_parquet, _join_parquet),
}
