"""Where a report comes from: the command, the software, and the files with their checksums."""

import platform
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from datetime import datetime
from hashlib import sha256
from importlib.metadata import version
from pathlib import Path

SOFTWARE = ("elastic-tendon", "numpy", "scipy", "casadi", "control", "plotly")
_CHUNK = 1 << 20  # bytes that are read at once


@dataclass(frozen=True)
class File:
    """A file that was read: what it was for, `size` in bytes, and SHA-256 in hexadecimal."""

    purpose: str
    name: str
    size: int
    checksum: str


@dataclass(frozen=True)
class Origin:
    """What whoever asks for a report knows of it.

    `command` : that makes it again. `made` : date and time as of ISO 8601, with time zone.
    `software` : versions by name. `files` : that were read. `advice` : what to do next, sentences
    and, after two blanks, commands.
    """

    command: str
    made: str
    software: Mapping[str, str]
    files: tuple[File, ...]
    advice: tuple[str, ...] = ()


def origin_of(command: str, read: Iterable[tuple[str, Path]], advice: Iterable[str] = ()) -> Origin:
    """The origin of a report that is made now, by this software.

    Parameters
    ----------
    command : that makes it again
    read : purpose and path of what was read; each path is looked at once, one that is no file
        (a bundled model's name) not at all, and of a folder each file
    advice : what to do next
    """
    purposes: dict[Path, dict[str, None]] = {}
    for purpose, path in read:
        purposes.setdefault(path, {})[purpose] = None
    every = ((", ".join(used), path) for path, used in purposes.items())
    return Origin(
        command=command,
        made=datetime.now().astimezone().isoformat(timespec="seconds"),
        software={"Python": platform.python_version()}
        | {package: version(package) for package in SOFTWARE},
        files=tuple(file for entry in every for file in _files(*entry)),
        advice=tuple(advice),
    )


def _files(purpose: str, path: Path) -> Iterator[File]:
    if path.is_dir():
        for inside in sorted(path.iterdir()):
            yield from _files(purpose, inside)
    elif path.is_file():
        checksum = sha256()
        with path.open("rb") as stream:
            while chunk := stream.read(_CHUNK):
                checksum.update(chunk)
        yield File(purpose, str(path), path.stat().st_size, checksum.hexdigest())
