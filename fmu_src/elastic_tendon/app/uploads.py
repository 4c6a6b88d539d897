"""Files that a browser sends, and files that might end the whole app when they are opened."""

import binascii
import subprocess
import sys
from base64 import b64decode
from collections.abc import Sequence
from functools import partial
from pathlib import Path

from elastic_tendon.app.document import Document, Source
from elastic_tendon.app.safety import UPLOAD
from elastic_tendon.app.workspace import Session, Workspace
from elastic_tendon.errors import ElasticTendonError, MeasurementError

LONGEST_NAME = 120  # letters of an upload's name

# formats whose libraries are known to crash on some damaged files, by how they begin
_CRASHING = (b"MATLAB 5.0", b"MATLAB 7.3", b"\x89HDF\r\n\x1a\n")
_TRY = """
import sys
from pathlib import Path
from elastic_tendon.errors import ElasticTendonError
from elastic_tendon.measurement.formats import open_source
try:
    source = open_source(Path(sys.argv[1]))
    for group in source.groups:
        for _ in source.read(group.name, group.columns, silent):
            pass
except ElasticTendonError:
    pass
"""
_PATIENCE = 120.0  # s
_UNITS = ("bytes", "kB", "MB", "GB")


def content_of(sent: str, name: str, most: int) -> bytes:
    """The bytes of an upload, which comes as ``data:TYPE;base64,TEXT``.

    Parameters
    ----------
    sent : str
    name : what the user calls the file; only for messages
    most : bytes that are taken

    Raises
    ------
    ElasticTendonError : it is too large, or did not arrive whole
    """
    try:
        content = b64decode(sent.partition(",")[2], validate=True)
    except (binascii.Error, ValueError):
        raise ElasticTendonError(f"{name}: it did not arrive whole; upload it again") from None
    if len(content) > most:
        raise ElasticTendonError(
            f"{name}: it is larger than {size_in_words(most)}; name it on the command line instead"
        )
    return content


def add_recordings(
    workspace: Workspace, session: Session, sent: Sequence[str], names: Sequence[str]
) -> tuple[list[str], list[str]]:
    """Let uploads be fitted with what a session has.

    Parameters
    ----------
    workspace, session : Workspace and Session
    sent, names : uploads and what they are called, see `content_of`

    Returns
    -------
    names of those that were added, and a sentence for each that was refused
    """
    added, refused = [], []
    for encoded, name in zip(sent, names, strict=True):
        called = name[-LONGEST_NAME:]
        try:
            key = workspace.add_file(content_of(encoded, called, UPLOAD))
        except ElasticTendonError as error:
            refused.append(str(error))
            continue
        session.change(partial(_with, Source(key=key, name=called)))
        added.append(called)
    return added, refused


def _with(source: Source, document: Document) -> Document:
    return document.with_sources([*document.sources, source])


def size_in_words(size: int) -> str:
    """Bytes for people, with two digits or more; a kB has 1024 of them."""
    value, unit = float(size), 0
    while value >= 1023.5 and unit < len(_UNITS) - 1:
        value, unit = value / 1024.0, unit + 1
    digits = 1 if unit > 0 and value < 9.95 else 0
    return f"{value:.{digits}f} {_UNITS[unit]}"


def check_harmless(path: Path, name: str) -> None:
    """Refuse a file on which a library crashes, which would end the app; tried in a process.

    Parameters
    ----------
    path : of the file
    name : what the user calls it

    Raises
    ------
    MeasurementError : it is damaged
    """
    try:
        with path.open("rb") as file:
            beginning = file.read(16)
    except OSError:
        return  # whoever opens it tells why it cannot be read
    if not beginning.startswith(_CRASHING):
        return
    command = [sys.executable, "-P", "-c", _TRY, str(path)]
    try:
        done = subprocess.run(command, capture_output=True, timeout=_PATIENCE, check=False)
    except subprocess.TimeoutExpired:
        raise MeasurementError(f"{name}: reading it takes too long; save it as CSV") from None
    if done.returncode not in (0, 1):  # 1: a fault that Python tells, not a crash
        raise MeasurementError(f"{name}: the file is damaged; export it again")
