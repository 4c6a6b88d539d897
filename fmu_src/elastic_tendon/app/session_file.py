"""The file of a session: what the user chose, sent and found, on disk after each step.

It is a database of SQLite, for then every change is there whole or not at all, whatever ends the
server. It holds numbers and text only; effects that its user typed are run when whoever opens it
asks for it, see `own_effects`.
"""

import os
import sqlite3
from collections.abc import Mapping
from dataclasses import dataclass
from hashlib import file_digest, sha256
from json import dumps
from pathlib import Path
from threading import RLock
from typing import Any, TypeVar

import numpy as np
from pydantic import TypeAdapter, ValidationError
from pydantic_core import to_json

from elastic_tendon.app.document import Document
from elastic_tendon.app.own_effects import waiting
from elastic_tendon.errors import ElasticTendonError
from elastic_tendon.output import OutputError, check_writable, write_file

T = TypeVar("T")

MARK, VERSION = 0x656C7465, 1  # of the application, and of the tables below
BEGINNING = b"SQLite format 3\0"
TABLES = """
    CREATE TABLE state (name TEXT PRIMARY KEY, value TEXT);
    CREATE TABLE files (key TEXT PRIMARY KEY, path TEXT, digest TEXT, content BLOB);
    CREATE TABLE results (key TEXT PRIMARY KEY, value TEXT);
"""
STAYS = "it stays as it is; name another file"


@dataclass(frozen=True)
class Reopened:
    """What a session's file held: `files` by key, and a sentence for each that is not as it was."""

    document: Document
    files: Mapping[str, Path]
    notes: tuple[str, ...]


class SessionFile:
    """A session's file, which one app at a time has open; see `open_session`."""

    def __init__(self, path: Path, database: sqlite3.Connection) -> None:
        self.path = path
        self._database = database
        self._lock = RLock()

    @property
    def name(self) -> str:
        """What the page calls the session."""
        return self.path.name

    def close(self) -> None:
        """Let another app have it."""
        with self._lock:
            self._database.close()

    # ---- one value each ----------------------------------------------------------------------

    def get(self, name: str) -> str:
        """A value that was kept, "" where none was."""
        return str(self._one("SELECT value FROM state WHERE name = ?", name) or "")

    def put(self, name: str, value: str) -> None:
        """Keep a value; when this returns, it is on disk.

        Raises
        ------
        OutputError : the disk does not take it
        """
        self._write("INSERT OR REPLACE INTO state VALUES (?, ?)", name, value)

    # ---- results -----------------------------------------------------------------------------

    def find(self, key: tuple[str, ...], kind: type[T]) -> T | None:
        """A result that was kept, None where none was, or none that can be used."""
        text = self._one("SELECT value FROM results WHERE key = ?", _named(key))
        try:
            return None if text is None else TypeAdapter(kind).validate_json(text)
        except ValidationError:
            return None

    def keep(self, key: tuple[str, ...], value: object) -> None:
        """Keep a result that is a data class of numbers, arrays of them, and text.

        Raises
        ------
        OutputError : the disk does not take it
        """
        text = to_json(value, inf_nan_mode="constants", fallback=np.ndarray.tolist).decode()
        self._write("INSERT OR REPLACE INTO results VALUES (?, ?)", _named(key), text)

    def drop(self, key: tuple[str, ...]) -> None:
        """Keep a result no longer.

        Raises
        ------
        OutputError : the disk does not take it
        """
        self._write("DELETE FROM results WHERE key = ?", _named(key))

    # ---- files of measurements ---------------------------------------------------------------

    def keep_upload(self, key: str, content: bytes) -> None:
        """Keep a file that was sent, whole.

        Raises
        ------
        OutputError : the disk does not take it
        """
        self._write("INSERT OR REPLACE INTO files VALUES (?, NULL, NULL, ?)", key, content)

    def refer(self, key: str, path: Path) -> None:
        """Keep where a file of the user's is, and a digest of what it holds.

        Raises
        ------
        OutputError : the disk does not take it
        """
        self._write(
            "INSERT OR REPLACE INTO files VALUES (?, ?, ?, NULL)", key, str(path), _digest(path)
        )

    def begin(self, document: Document, files: Mapping[str, Path]) -> None:
        """Keep what a new session begins with; the document last, for with it the session is one.

        Raises
        ------
        OutputError : the disk does not take it
        """
        for key, path in files.items():
            self.refer(key, path)
        self.put("document", document.model_dump_json())

    def reopen(self) -> Reopened | None:
        """What the file holds, None where it holds no session yet.

        A file of the user's that has changed meanwhile counts as another one, so that what was
        found in the earlier one is not taken for found in it.

        Raises
        ------
        OutputError : it is damaged, or its models cannot be loaded here
        """
        if not (text := self.get("document")):
            return None
        document = self._document(text)
        files: dict[str, Path] = {}
        notes = []
        used = {source.key for source in document.sources}
        for key, name, digest in self._rows("SELECT key, path, digest FROM files"):
            path = Path(name or "")
            if key not in used:  # it was removed on the page
                self._write("DELETE FROM files WHERE key = ?", key)
            elif name is None:  # it was sent, see `put_uploads`
                continue
            elif not path.is_file():
                notes.append(f"{path} is gone; bring it back, or add the file again on the page")
            elif (now := _digest(path)) == digest:
                files[key] = path
            else:
                notes.append(f"{path} has changed; what was found in it before counts no longer")
                new_key = f"{key.partition('.')[0]}.{now[:8]}"
                document = document.with_sources(
                    [
                        source.changed(key=new_key) if source.key == key else source
                        for source in document.sources
                    ]
                )
                files[new_key] = path
                self.refer(new_key, path)
        if waiting(document):
            notes.append(f"{self.path} brings effects of its own; the page runs them when asked to")
        self.put("document", document.model_dump_json())
        return Reopened(document, files, tuple(notes))

    def put_uploads(self, folder: Path) -> dict[str, Path]:
        """Put files that were sent into a folder; their paths by key."""
        paths = {}
        for key, content in self._rows("SELECT key, content FROM files WHERE path IS NULL"):
            paths[key] = folder / key
            paths[key].write_bytes(content)
        return paths

    def _document(self, text: str) -> Document:
        try:
            document = Document.model_validate_json(text)
            if waiting(document):  # without them its models cannot be loaded
                return document
            for version in document.versions:
                version.loaded()
        except ValidationError:
            raise _damaged(self.path) from None
        except ElasticTendonError as error:
            raise OutputError(
                f"{self.path}: its model cannot be loaded here ({error}); give --effect for each "
                "effect of your own, as before"
            ) from None
        return document

    # ---- the database ------------------------------------------------------------------------

    def _rows(self, question: str, *values: str) -> list[Any]:
        with self._lock:
            return self._database.execute(question, values).fetchall()

    def _one(self, question: str, *values: str) -> Any:
        found = self._rows(question, *values)
        return found[0][0] if found else None

    def _write(self, order: str, *values: str | bytes) -> None:
        try:
            with self._lock, self._database:
                self._database.execute(order, values)
        except sqlite3.Error as error:
            raise OutputError(
                f"{self.path}: cannot be written ({error}); what is done from now on is kept in "
                "the browser's tab only"
            ) from None


def open_session(path: Path) -> SessionFile:
    """Open a session's file, or make it where there is none.

    Raises
    ------
    OutputError : it is something else, damaged, of another version, or open elsewhere
    """
    if not path.exists():
        write_file(path, _make, force=False)
    else:
        check_writable(path, force=True)
    try:
        with path.open("rb") as file:
            beginning = file.read(len(BEGINNING))
        if beginning != BEGINNING:
            raise _foreign(path)
        database = sqlite3.connect(path, timeout=1.0, check_same_thread=False)
        return SessionFile(path, _checked(path, database))
    except OSError as error:
        raise OutputError(f"{path}: cannot be read ({error.strerror}); {STAYS}") from None
    except sqlite3.OperationalError as error:
        if error.sqlite_errorcode == sqlite3.SQLITE_BUSY:
            text = "another app has it open; close that one, or name another file"
            raise OutputError(f"{path}: {text}") from None
        raise OutputError(f"{path}: cannot be written ({error}); name another file") from None
    except sqlite3.DatabaseError:
        raise _damaged(path) from None


def _make(path: Path) -> None:
    """An empty session, for its user alone: it holds the secret part of the page's address."""
    os.close(os.open(path, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o600))
    database = sqlite3.connect(path)
    database.executescript(
        f"PRAGMA application_id = {MARK}; PRAGMA user_version = {VERSION}; {TABLES}"
    )
    database.close()


def _checked(path: Path, database: sqlite3.Connection) -> sqlite3.Connection:
    """A database that is a whole session of this version, locked until it is closed."""
    try:
        if (fault := _fault_of(path, database)) is None:
            database.execute("PRAGMA locking_mode = EXCLUSIVE")
            database.execute("BEGIN EXCLUSIVE")
            database.execute("COMMIT")
            return database
    except BaseException:
        database.close()
        raise
    database.close()
    raise fault


def _fault_of(path: Path, database: sqlite3.Connection) -> OutputError | None:
    def told(name: str) -> Any:
        return database.execute(f"PRAGMA {name}").fetchone()[0]

    if told("application_id") != MARK:
        return _foreign(path)
    if (version := told("user_version")) != VERSION:
        return OutputError(
            f"{path}: this is a session of version {version}, and this elastic-tendon reads "
            f"version {VERSION}; {STAYS}"
        )
    return None if told("quick_check") == "ok" else _damaged(path)


def _foreign(path: Path) -> OutputError:
    return OutputError(f"{path}: this is no session of the app; {STAYS}")


def _damaged(path: Path) -> OutputError:
    return OutputError(f"{path}: this session is damaged; {STAYS}, or bring back a copy")


def _named(key: tuple[str, ...]) -> str:
    return sha256(dumps(key).encode()).hexdigest()


def _digest(path: Path) -> str:
    """Of what a file holds, "" where it cannot be read: whoever opens it tells why."""
    try:
        with path.open("rb") as file:
            return file_digest(file, "sha256").hexdigest()
    except OSError:
        return ""
