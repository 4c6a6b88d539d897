"""A session on disk: whole or not at all after each step, and never overwritten by mistake."""

import os
import signal
import sqlite3
import subprocess
import sys
from collections.abc import Iterator
from math import inf, nan
from pathlib import Path
from threading import Event

import pytest
from typer.testing import CliRunner

pytest.importorskip("dash")

from elastic_tendon import cli
from elastic_tendon.actuator.parameters import load_model
from elastic_tendon.app import walk
from elastic_tendon.app.document import Document, Source, new_document
from elastic_tendon.app.session_file import SessionFile, open_session
from elastic_tendon.app.workspace import Result, Session, Workspace
from elastic_tendon.diagnosis.by_hand import Ranked
from elastic_tendon.diagnosis.result import Candidate, Round
from elastic_tendon.errors import ElasticTendonError
from elastic_tendon.progress import Progress
from waiting import LONG, wait_for

START = new_document(
    load_model("biorob_x4_joint_3"), [Source(key="named-0", name="run.csv", role="fit")]
)
FOUND = Ranked(
    Round((), (Candidate(("coulomb_friction",), 0.25, {"a": nan}, (), evidence=-inf),), "chance"),
    {"coulomb_friction": "name = 'x'"},
)


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "night.session"


@pytest.fixture
def recording(tmp_path: Path) -> Path:
    made = tmp_path / "run.csv"
    made.write_text("time_s\n0\n")
    return made


@pytest.fixture
def file(path: Path) -> SessionFile:
    return open_session(path)


@pytest.fixture
def workspace(file: SessionFile, recording: Path) -> Iterator[Workspace]:
    """A new session with one recording of the user's."""
    assert file.reopen() is None
    files = {"named-0": recording}
    file.begin(START, files)
    made = Workspace(START, files, file)
    yield made
    made.close()


def reopened(path: Path) -> tuple[Session, Workspace, tuple[str, ...]]:
    """The session as a server finds it that begins with the same file."""
    file = open_session(path)
    before = file.reopen()
    assert before is not None
    made = Workspace(before.document, before.files, file)
    return made.open(None), made, before.notes


def renamed(document: Document) -> Document:
    return document.renamed("1", "changed")


def ranked() -> Result[Ranked]:
    return walk.ranked(START, START.version, {})


# ---- what is kept --------------------------------------------------------------------------------


def test_what_was_done_is_there_again(workspace: Workspace, path: Path) -> None:
    session = workspace.open(None)
    session.change(renamed)
    session.look_at("where")
    workspace.close()
    again, other, notes = reopened(path)
    assert (again.document, again.opened, notes) == (session.document, "where", ())
    assert again.name == "night.session"
    other.close()


def test_every_tab_looks_at_the_session_of_the_file(workspace: Workspace) -> None:
    session = workspace.open(None)
    assert workspace.open({"id": "another", "revision": 3, "document": "{}"}) is session


def test_what_a_search_found_is_not_searched_again(workspace: Workspace, path: Path) -> None:
    workspace.open(None).cache.put(ranked(), FOUND)
    workspace.close()
    again, other, _ = reopened(path)
    assert repr(again.cache.find(ranked())) == repr(FOUND)  # nan is not equal to itself
    other.close()


def test_files_that_were_sent_come_back_until_they_are_removed(
    workspace: Workspace, path: Path
) -> None:
    keys = [workspace.add_file(content) for content in (b"one", b"two")]
    session = workspace.open(None)
    session.change(lambda document: document.with_sources([Source(key=keys[0], name="one.csv")]))
    workspace.close()
    again, other, _ = reopened(path)
    assert again.files[keys[0]].read_bytes() == b"one"
    assert keys[1] not in again.files
    other.close()


def test_a_recording_that_changed_counts_as_another(
    workspace: Workspace, path: Path, recording: Path
) -> None:
    before = workspace.open(None).document
    workspace.close()
    recording.write_text("time_s\n1\n")
    again, other, notes = reopened(path)
    (source,) = again.document.sources
    assert again.files[source.key] == recording
    assert again.document.data_key() != before.data_key()
    assert notes == (f"{recording} has changed; what was found in it before counts no longer",)
    other.close()


def test_a_recording_that_is_gone_is_told(
    workspace: Workspace, path: Path, recording: Path
) -> None:
    workspace.close()
    recording.unlink()
    again, other, notes = reopened(path)
    assert again.files == {}
    assert notes[0].startswith(f"{recording} is gone; bring it back")
    other.close()


def test_what_was_under_way_is_on_disk_until_it_is_done_or_cancelled(
    workspace: Workspace, file: SessionFile
) -> None:
    session, go_on = workspace.open(None), Event()

    def waits(_progress: Progress) -> None:
        assert go_on.wait(LONG)

    session.start("effect", "searching", waits, asked="search ")
    assert file.get("asked") == "search "
    session.stop()
    assert file.get("asked") == ""
    session.start("add", "refitting", waits, asked="refit ")
    go_on.set()
    wait_for(lambda: file.get("asked") == "")


def test_what_was_under_way_begins_again(workspace: Workspace, path: Path, monkeypatch) -> None:
    session, go_on = workspace.open(None), Event()
    session.start("effect", "searching", lambda _: go_on.wait(LONG), asked="search ")
    workspace.close()  # as by Ctrl-C; a killed server leaves the file just so
    go_on.set()
    again, other, _ = reopened(path)
    begun: list[str] = []
    monkeypatch.setattr(walk, "searching", lambda _session: lambda _: begun.append("search"))
    walk.begin_again(again)
    wait_for(lambda: bool(begun))
    assert begun == ["search"]
    other.close()


def test_a_disk_that_is_full_is_told_and_the_user_goes_on(
    workspace: Workspace, file: SessionFile
) -> None:
    session = workspace.open(None)
    file._database.execute("PRAGMA max_page_count = 1")
    session.change(lambda document: document.renamed("1", "x" * 100_000))
    assert len(session.document.version.title) == 100_000
    assert "cannot be written (database or disk is full)" in session.unsaved
    file._database.execute("PRAGMA max_page_count = 10000")
    session.change(renamed)
    assert session.unsaved == ""


WRITER = """
import sys
from pathlib import Path
from elastic_tendon.app.session_file import open_session
file = open_session(Path(sys.argv[1]))
for count in range(1_000_000):
    file.put("count", f"{count:06}" * 5000)
    print(count, flush=True)
"""


@pytest.mark.parametrize("lines", [1, 7, 20])
def test_who_kills_the_server_finds_the_last_value_or_the_next(path: Path, lines: int) -> None:
    process = subprocess.Popen(
        [sys.executable, "-c", WRITER, str(path)], stdout=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    for _ in range(lines):
        told = int(process.stdout.readline())
    os.kill(process.pid, signal.SIGKILL)
    rest = process.communicate()[0].split()
    told = int(rest[-1]) if rest else told
    file = open_session(path)
    value = file.get("count")
    assert value in {f"{count:06}" * 5000 for count in (told, told + 1)}
    file.close()


# ---- what is no session --------------------------------------------------------------------------


def refused(path: Path) -> str:
    """Why a file is not opened; it stays as it is."""
    before = path.read_bytes()
    with pytest.raises(ElasticTendonError) as caught:
        open_session(path).reopen()
    assert path.read_bytes() == before
    return str(caught.value)


@pytest.mark.parametrize("content", [b"", b"time_s\n0\n", b"SQLite format 3\0" + bytes(84)])
def test_another_file_is_refused_and_stays(path: Path, content: bytes) -> None:
    path.write_bytes(content)
    assert refused(path).startswith(f"{path}: this ")
    assert "it stays as it is; name another file" in refused(path)


def test_a_damaged_session_is_refused_and_stays(workspace: Workspace, path: Path) -> None:
    workspace.close()
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 2])
    assert refused(path).startswith(f"{path}: this session is damaged; it stays as it is")
    path.write_bytes(whole[:5000] + bytes(3000) + whole[8000:])
    assert refused(path).startswith(f"{path}: this session is damaged; it stays as it is")


def test_a_document_that_is_none_is_refused(workspace: Workspace, path: Path) -> None:
    workspace.close()
    file = open_session(path)
    file.put("document", "{}")
    file.close()
    assert refused(path).startswith(f"{path}: this session is damaged")


def test_a_session_of_another_version_is_refused(workspace: Workspace, path: Path) -> None:
    workspace.close()
    database = sqlite3.connect(path)
    database.execute("PRAGMA user_version = 2")
    database.close()
    assert "a session of version 2, and this elastic-tendon reads version 1" in refused(path)


def test_two_apps_do_not_share_a_session(workspace: Workspace, path: Path) -> None:
    with pytest.raises(ElasticTendonError, match="another app has it open"):
        open_session(path)
    assert workspace.open(None).unsaved == ""


def test_a_session_is_for_its_user_alone(workspace: Workspace, path: Path) -> None:
    assert path.stat().st_mode & 0o077 == 0
    assert workspace.name == path.name


def test_the_command_says_in_a_sentence_what_is_wrong(recording: Path) -> None:
    result = CliRunner().invoke(cli.app, ["app", "--no-browser", "--session", str(recording)])
    assert result.exit_code == 1
    words = " ".join(result.stderr.split())
    assert words == (
        f"elastic-tendon: {recording}: this is no session of the app; it stays as it is; name "
        "another file"
    )
