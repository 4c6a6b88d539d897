"""Where parts of a sweep are kept: a folder, or whatever fsspec opens by a URL."""

import re
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import Any, BinaryIO, Protocol
from zlib import crc32

from elastic_tendon.errors import SweepError

_NAME = re.compile(r"(\d{12})-(\d{12})-(\d+)-([0-9a-f]{8})\.(csv|parquet)")
UNFINISHED = ".unfinished"


class Store(Protocol):
    """A folder of files; every method raises OSError where it cannot be used."""

    def names(self) -> list[str]:
        """Of all files, sorted; none where there is no such folder."""
        ...

    def read(self, name: str) -> bytes:
        """Content of a file."""
        ...

    def open(self, name: str) -> BinaryIO:
        """A file, to be read bit by bit."""
        ...

    def put(self, name: str, content: bytes) -> None:
        """Write a file, which appears whole or not at all, and the folder where it is absent."""
        ...

    def remove(self, name: str) -> None:
        """Remove a file."""
        ...

    def clear(self) -> None:
        """Remove all files, and the folder."""
        ...


@dataclass(frozen=True)
class Folder:
    """A folder of this computer, or one that several computers share."""

    path: Path

    def __str__(self) -> str:
        return str(self.path)

    def names(self) -> list[str]:
        return sorted(path.name for path in self.path.iterdir()) if self.path.exists() else []

    def read(self, name: str) -> bytes:
        return (self.path / name).read_bytes()

    def open(self, name: str) -> BinaryIO:
        return (self.path / name).open("rb")

    def put(self, name: str, content: bytes) -> None:
        self.path.mkdir(exist_ok=True)
        unfinished = self.path / f"{name}{UNFINISHED}"
        unfinished.write_bytes(content)
        unfinished.replace(self.path / name)

    def remove(self, name: str) -> None:
        (self.path / name).unlink()

    def clear(self) -> None:
        for name in self.names():
            self.remove(name)
        if self.path.exists():
            self.path.rmdir()


@dataclass(frozen=True)
class Remote:
    """A folder of an object store or another file system, by its URL."""

    url: str

    def __str__(self) -> str:
        return self.url

    def _system(self) -> tuple[Any, str]:
        try:
            import fsspec
        except ModuleNotFoundError:
            raise SweepError(
                f"{self.url}: a URL needs fsspec, which is not installed; "
                'pip install "elastic-tendon[cluster]"'
            ) from None
        try:
            system, path = fsspec.core.url_to_fs(self.url)
        except (ValueError, ImportError) as error:
            raise SweepError(f"{self.url}: cannot be opened ({error}); check the URL") from None
        return system, path.rstrip("/")

    def names(self) -> list[str]:
        system, path = self._system()
        system.invalidate_cache()
        try:
            found = system.ls(path, detail=False)
        except FileNotFoundError:
            return []
        return sorted(entry.rsplit("/", 1)[-1] for entry in found)

    def read(self, name: str) -> bytes:
        system, path = self._system()
        return bytes(system.cat_file(f"{path}/{name}"))

    def open(self, name: str) -> BinaryIO:
        return BytesIO(self.read(name))

    def put(self, name: str, content: bytes) -> None:
        system, path = self._system()
        system.makedirs(path, exist_ok=True)
        system.pipe_file(f"{path}/{name}", content)

    def remove(self, name: str) -> None:
        system, path = self._system()
        system.rm_file(f"{path}/{name}")

    def clear(self) -> None:
        system, path = self._system()
        if system.exists(path):
            system.rm(path, recursive=True)


def store_of(place: str) -> Store:
    """The store that a user names: a folder, or a URL such as s3://bucket/folder."""
    if "://" in place:
        return Remote(place)
    return Folder(Path(place).absolute())


def part_name(start: int, stop: int, failed: int, content: bytes, suffix: str) -> str:
    """Name of a part: its runs, how many failed, and the checksum of its content."""
    return f"{start:012d}-{stop:012d}-{failed}-{crc32(content):08x}{suffix}"


def is_part(name: str) -> bool:
    """Whether a file is a part."""
    return _NAME.fullmatch(name) is not None


def read_name(name: str) -> tuple[tuple[int, int], int, int]:
    """Piece, number of failed runs, and checksum of a part."""
    start, stop, failed, checksum, _ = name.replace(".", "-").split("-")
    return (int(start), int(stop)), int(failed), int(checksum, 16)
