"""Files that users keep: never overwritten unasked, never left half written."""

import os
import tempfile
from collections.abc import Callable
from pathlib import Path

from elastic_tendon.errors import ElasticTendonError


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
    except OSError as error:
        raise OutputError(f"{path}: cannot be written ({error.strerror})") from error


def write_text(path: Path, text: str, *, force: bool) -> None:
    """`write_file` for text, in UTF-8."""
    write_file(path, lambda target: target.write_text(text, encoding="utf-8"), force=force)
