"""What is done of a sweep: a file for each piece, until all are put together."""

import json
from collections.abc import Iterable, Iterator
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path
from typing import Any, BinaryIO
from zlib import crc32

from filelock import FileLock, Timeout

from elastic_tendon.errors import SweepError
from elastic_tendon.output import OutputError, check_writable, write_file
from elastic_tendon.sweeps.formats import FORMATS
from elastic_tendon.sweeps.store import (
    UNFINISHED,
    Folder,
    Store,
    is_part,
    part_name,
    read_name,
)
from elastic_tendon.sweeps.task import Task
from elastic_tendon.sweeps.work import Done, Piece

DESCRIPTION = "sweep.json"


@dataclass(frozen=True)
class Parts:
    """What is done of one sweep.

    Parameters
    ----------
    store : has `DESCRIPTION`, and a file for each piece that is done; its name has first run,
        the one after the last, how many failed, and the checksum of its content
    output : where all of it will be put together
    share : the runs that are done here; all of them, or a part where others do the rest
    runs : of the whole sweep
    """

    store: Store
    output: Path
    share: Piece
    runs: int


def folder_of(output: Path) -> Path:
    """Where the parts of a sweep are until all is done, if they have no other place."""
    return output.with_name(f"{output.name}.parts")


@contextmanager
def alone(output: Path, share: str = "") -> Iterator[None]:
    """Let nobody else sweep into this output, or do this share of it, meanwhile; a process that
    dies lets go.

    Raises
    ------
    SweepError : another sweep does so now
    OutputError : the folder cannot be written
    """
    path = output.with_name(f"{output.name}{share}.lock")
    lock = FileLock(path)
    with writing(path):
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
    if output.suffix not in FORMATS:
        raise OutputError(f"{output}: results are written as .csv or .parquet; name such a file")
    if output.suffix == ".parquet" and find_spec("pyarrow") is None:
        raise OutputError(
            f"{output}: Parquet needs pyarrow, which is not installed; "
            'pip install "elastic-tendon[formats]", or name a .csv file'
        )
    check_writable(output, force=force)


def open_parts(
    task: Task,
    output: Path,
    *,
    store: Store | None = None,
    share: Piece | None = None,
    force: bool,
) -> Parts:
    """The parts of this sweep: those that it has already, or a new folder for them.

    Parameters
    ----------
    task, output : of the sweep
    store : of the parts; None: a folder beside the output
    share : the runs that are done here; None: all
    force : whether parts of another sweep may be removed

    Raises
    ------
    SweepError : the folder has parts of another sweep, and `force` is not given
    OutputError : the folder cannot be written, or has files that no sweep has put there
    """
    store = Folder(folder_of(output)) if store is None else store
    parts = Parts(store, output, share or (0, task.runs), task.runs)
    wanted = _description(task)
    with writing(store):
        names = store.names()
        if names:
            different = _differences(wanted, _found(store, names))
            if not different:
                return parts
            if any(map(is_part, names)) and not force:
                raise SweepError(
                    f"{store}: here are parts of another sweep (different: "
                    f"{', '.join(different)}); give --force to remove them and begin anew, or name "
                    "another output to keep both"
                )
            store.clear()
        store.put(DESCRIPTION, json.dumps(wanted, indent=1).encode())
    return parts


def done_before(parts: Parts) -> dict[Piece, int]:
    """The pieces of the share that are done, and how many runs of each failed; files that are
    damaged, or done twice, are removed.

    Raises
    ------
    OutputError : the folder cannot be read or written
    """
    done: dict[Piece, int] = {}
    first, last = parts.share
    covered = first
    with writing(parts.store):
        for name in filter(is_part, parts.store.names()):
            (start, stop), failed, checksum = read_name(name)
            if stop <= first or start >= last:
                continue  # another's share
            content = parts.store.read(name)
            if start >= covered and stop <= last and crc32(content) == checksum:
                done[start, stop] = failed
                covered = stop
            else:
                parts.store.remove(name)
    return done


def missing(share: Piece, done: Iterable[Piece]) -> list[Piece]:
    """Runs of a share that are in none of the pieces that are done, which are in order."""
    start, stop = share
    gaps = []
    for piece in (*done, (stop, stop)):
        if piece[0] > start:
            gaps.append((start, piece[0]))
        start = piece[1]
    return gaps


def add(parts: Parts, done: Done) -> int:
    """Keep the results of one piece; the number of its runs that failed.

    Raises
    ------
    OutputError : the folder cannot be written; what was done before is kept
    """
    if done.content:  # else who did it has kept it
        keep(parts, (done.start, done.stop), done.failed, done.content)
    return done.failed


def keep(parts: Parts, piece: Piece, failed: int, content: bytes) -> None:
    """`add` for the content of a file."""
    name = part_name(*piece, failed, content, parts.output.suffix)
    with writing(parts.store):
        parts.store.put(name, content)


def finish(parts: Parts, *, force: bool) -> None:
    """Put all parts together into the output, in the order of the runs, and remove them.

    Raises
    ------
    SweepError : parts are missing
    OutputError : the output cannot be written; the parts are kept
    """
    with writing(parts.store):
        names = [name for name in parts.store.names() if is_part(name)]
    gaps = missing((0, parts.runs), [read_name(name)[0] for name in names])
    if gaps:
        start, stop = gaps[0]
        raise SweepError(
            f"{parts.store}: parts are missing, the first of them runs {start} to {stop - 1}; "
            "repeat the command to do them"
        )
    join = FORMATS[parts.output.suffix].join
    write_file(parts.output, lambda target: join(_opened(parts, names), target), force=force)
    with writing(parts.store):
        parts.store.clear()


def forget(parts: Parts) -> None:
    """Leave nothing behind of a sweep of which nothing is done."""
    with suppress(OSError):
        if not any(map(is_part, parts.store.names())):
            parts.store.clear()


def _opened(parts: Parts, names: Iterable[str]) -> Iterator[BinaryIO]:
    for name in names:
        with closing(parts.store.open(name)) as file:
            yield file


def _description(task: Task) -> dict[str, Any]:
    return {
        "elastic-tendon": version("elastic-tendon"),
        "runs": task.runs,
        "identity": dict(task.identity),
    }


def _found(store: Store, names: Iterable[str]) -> dict[str, Any]:
    """What `DESCRIPTION` says; nothing where there is none, or it is damaged."""
    for name in names:
        if not (name == DESCRIPTION or name.endswith(UNFINISHED) or is_part(name)):
            raise OutputError(f"{store}/{name}: no sweep has put this here; move it away")
    try:
        description = json.loads(store.read(DESCRIPTION))
        intact = isinstance(description["identity"], dict) and description["runs"] >= 1
    except (FileNotFoundError, ValueError, KeyError, TypeError):
        intact = False
    return description if intact else {}


def _differences(wanted: dict[str, Any], description: dict[str, Any]) -> list[str]:
    """Names of what differs between two descriptions; more runs alone go on with what is there."""
    if not description:
        return [f"{DESCRIPTION} is missing or damaged"]
    asked, kept = wanted["identity"], description["identity"]
    inside = [key for key in {**asked, **kept} if asked.get(key) != kept.get(key)]
    around = [key for key in ("elastic-tendon", "runs") if wanted[key] != description.get(key)]
    grown = wanted["runs"] > description["runs"] and around == ["runs"] and not inside
    return [] if grown else [*around, *inside]


@contextmanager
def writing(place: object) -> Iterator[None]:
    """Tell in one sentence why a place cannot be written."""
    try:
        yield
    except NotADirectoryError:
        raise OutputError(
            f"{place}: this file is where the parts of the sweep go; move it away"
        ) from None
    except OSError as error:
        raise OutputError(
            f"{place}: cannot be written ({error.strerror or error}); what is done is kept, so "
            "mend this and repeat the command to go on"
        ) from error
