"""Files that users keep: never overwritten unasked, never left half written."""

import os
import tempfile
from collections.abc import Callable
from pathlib import Path

from elastic_tendon.errors import ElasticTendonError

written: list[Path] = []  # by this process, so that who stops it hears what is there


class OutputError(ElasticTendonError):
    """A file that cannot be written; the message says why and what to do."""


def check_writable(path: Path, *, force: bool) -> None:
    """Refuse, before any work is done, what could not be written after it.

    Parameters
    ----------
    path : file to be written
    force : whether an existing file may be replaced

    Raises
    ------
    OutputError : the file exists and `force` is not given, or its folder does not exist
    """
    if path.is_dir():
        raise OutputError(f"{path}: this is a folder; name a file in it")
    if not path.parent.is_dir():
        raise OutputError(f"{path}: there is no folder {path.parent}; create it first")
    if path.exists() and not force:
        raise OutputError(f"{path}: the file exists already; choose another name or give --force")


def write_file(path: Path, write: Callable[[Path], object], *, force: bool) -> None:
    """Let `write` fill a file beside `path`, then put it in place in one step.

    Parameters
    ----------
    path : file to be written
    write : called with the path of a temporary file of the same suffix
    force : whether an existing file may be replaced

    Raises
    ------
    OutputError : see `check_writable`, or the folder cannot be written
    """
    check_writable(path, force=force)
    try:
        with tempfile.TemporaryDirectory(dir=path.parent, prefix=".elastic-tendon-") as folder:
            temporary = Path(folder) / f"output{path.suffix}"
            write(temporary)
            os.replace(temporary, path)
            written.append(path)
    except OSError as error:
        raise OutputError(f"{path}: cannot be written ({error.strerror})") from error


def write_text(path: Path, text: str, *, force: bool) -> None:
    """`write_file` for text, in UTF-8."""
    write_file(path, lambda target: target.write_text(text, encoding="utf-8"), force=force)


def check_folder(path: Path, *, force: bool) -> None:
    """Refuse, before any work is done, a folder that could not be filled after it.

    Parameters
    ----------
    path : folder to be filled; it is made where it is absent
    force : whether files in it may be replaced

    Raises
    ------
    OutputError : a file has this name, the folder holds something and `force` is not given, or
        the folder around it does not exist
    """
    if path.exists() and not path.is_dir():
        raise OutputError(f"{path}: this is a file; name a folder")
    if not path.parent.is_dir():
        raise OutputError(f"{path}: there is no folder {path.parent}; create it first")
    if path.is_dir() and any(path.iterdir()) and not force:
        raise OutputError(f"{path}: the folder is not empty; name a new one or give --force")


def write_folder(path: Path, write: Callable[[Path], object], *, force: bool) -> None:
    """Let `write` fill a folder beside `path`, then put its files in place.

    Parameters
    ----------
    path : folder; made where it is absent
    write : called with the path of a temporary folder
    force : whether files in the folder may be replaced

    Raises
    ------
    OutputError : see `check_folder`, or the folder cannot be written
    """
    check_folder(path, force=force)
    try:
        with tempfile.TemporaryDirectory(dir=path.parent, prefix=".elastic-tendon-") as folder:
            write(Path(folder))
            path.mkdir(exist_ok=True)
            written.append(path)
            for file in Path(folder).iterdir():
                os.replace(file, path / file.name)
    except OSError as error:
        raise OutputError(f"{path}: cannot be written ({error.strerror})") from error
