"""Work beside the page: it reports, stops, fails in a sentence, and leaves nothing half done."""

from collections.abc import Iterator
from pathlib import Path
from threading import Event

import pytest

from elastic_tendon.actuator.parameters import load_model
from elastic_tendon.app.document import Document, new_document
from elastic_tendon.app.workspace import (
    CANCELLED,
    RESULTS,
    SESSIONS,
    Cache,
    Failure,
    Result,
    Session,
    Workspace,
)
from elastic_tendon.errors import MeasurementError
from elastic_tendon.progress import Enough, Progress
from waiting import LONG, wait_for


@pytest.fixture
def workspace() -> Iterator[Workspace]:
    made = Workspace(new_document(load_model("biorob_x4_joint_3")), {})
    yield made
    made.close()


def renamed(document: Document) -> Document:
    return document.renamed("1", "changed")


def finished(session: Session) -> bool:
    return session.job is not None and session.job.state != "running"


def test_work_changes_the_document_when_it_is_done(workspace: Workspace) -> None:
    session = workspace.open(None)
    before = session.revision
    assert session.start("add", "changing", lambda _progress: renamed)
    wait_for(lambda: finished(session))
    assert session.document.version.title == "changed"
    assert session.revision > before


def test_one_piece_of_work_at_a_time(workspace: Workspace) -> None:
    session, go_on = workspace.open(None), Event()

    def waits(_progress: Progress) -> None:
        assert go_on.wait(LONG)

    assert session.start("add", "waiting", waits)
    assert not session.start("add", "another", waits)
    go_on.set()
    wait_for(lambda: finished(session))
    assert session.start("add", "the next", lambda _progress: None)


def test_cancel_comes_back_at_once_and_nothing_is_kept(workspace: Workspace) -> None:
    session, go_on, ended = workspace.open(None), Event(), Event()

    def swallows_the_interrupt(progress: Progress) -> object:
        assert go_on.wait(LONG)
        try:
            progress("going on", 0.5)
        except KeyboardInterrupt:  # as a fit does, which keeps its best so far
            ended.set()
        return renamed

    session.start("add", "fitting", swallows_the_interrupt)  # type: ignore[arg-type]
    session.stop()
    assert finished(session)
    assert session.start("add", "the next", lambda _progress: None)
    go_on.set()
    assert ended.wait(LONG)
    wait_for(lambda: finished(session))
    assert session.document.version.title == "as given"


def test_a_cancelled_result_is_not_computed_again_unasked(workspace: Workspace) -> None:
    session, go_on = workspace.open(None), Event()

    def slow(_cache: Cache, _progress: Progress) -> int:
        assert go_on.wait(LONG)
        return 1

    result = Result(("slow",), "computing", slow)
    session.compute("compare", result)
    session.stop()
    assert session.cache.find(result) == Failure(CANCELLED)
    session.cache.forget_failures()
    assert session.cache.find(result) is None
    go_on.set()


def test_what_a_stopped_fit_brings_back_is_no_result() -> None:
    def interrupted(_words: str, share: float) -> None:
        if share == 1.0:
            raise KeyboardInterrupt

    cache, result = Cache(), Result(("fit",), "fitting", lambda _cache, _progress: "best so far")
    with pytest.raises(KeyboardInterrupt):
        cache.obtain(result, interrupted)
    assert cache.find(result) is None


@pytest.mark.parametrize("may_end", [True, False])
def test_the_best_so_far_is_taken_once_where_there_is_one(
    workspace: Workspace, may_end: bool
) -> None:
    session, begun, go_on = workspace.open(None), Event(), Event()
    told: list[str] = []

    def search(progress: Progress) -> object:
        begun.set()
        assert go_on.wait(LONG)
        try:
            progress("searching", 0.5)
        except Enough:
            told.append("ended")
        progress("concluding", 1.0)
        return renamed

    session.start("effect", "searching", search, may_end=may_end)  # type: ignore[arg-type]
    assert begun.wait(LONG)
    session.take_best()
    go_on.set()
    wait_for(lambda: finished(session))
    assert session.document.version.title == "changed"
    assert told == (["ended"] if may_end else [])


def test_where_nothing_is_known_yet_the_best_so_far_is_nothing(workspace: Workspace) -> None:
    session, go_on = workspace.open(None), Event()

    def reads(progress: Progress) -> None:
        assert go_on.wait(LONG)
        progress("reading the motion", 0.0)

    session.start("effect", "reading", reads, may_end=True)
    session.take_best()
    go_on.set()
    wait_for(lambda: finished(session))
    assert session.job is not None
    assert session.job.state == "stopped"


def test_what_goes_wrong_is_told_where_it_was_asked_for(workspace: Workspace) -> None:
    session = workspace.open(None)

    def refused(_progress: Progress) -> None:
        raise MeasurementError("run.csv: row 3 is empty")

    session.start("data", "reading", refused)
    wait_for(lambda: finished(session))
    assert session.job is not None
    assert (session.job.step, session.job.state) == ("data", "failed")
    assert session.job.sentence == "run.csv: row 3 is empty"


def test_a_fault_of_ours_is_told_too_and_not_tried_again(workspace: Workspace) -> None:
    def broken(_cache: Cache, _progress: Progress) -> int:
        raise ZeroDivisionError("by zero")

    session, result = workspace.open(None), Result(("broken",), "dividing", broken)
    session.compute("compare", result)
    wait_for(lambda: finished(session))
    found = session.cache.find(result)
    assert isinstance(found, Failure)
    assert found.sentence == "dividing failed, which should not happen (ZeroDivisionError: by zero)"


def test_the_cache_lets_go_of_what_was_not_asked_for_the_longest() -> None:
    cache = Cache()
    results = [Result((str(i),), "", lambda _cache, _progress: "there") for i in range(RESULTS + 1)]
    for result in results[:-1]:
        cache.put(result, "there")
    cache.find(results[0])
    cache.put(results[-1], "there")
    assert [cache.find(result) for result in results[:2]] == ["there", None]


def test_a_dropped_session_comes_back_by_its_document(workspace: Workspace) -> None:
    first = workspace.open(None)
    first.change(renamed)
    stored = first.stored()
    others = [workspace.open(None) for _ in range(SESSIONS)]
    assert workspace.open(others[-1].stored()) is others[-1]
    again = workspace.open(stored)
    assert again is not first
    assert again.id == first.id
    assert again.document == first.document


def test_uploads_lie_under_names_of_our_own_and_go_with_the_server(workspace: Workspace) -> None:
    key = workspace.add_file(b"time_s\n")
    path: Path = workspace.open(None).files[key]
    assert path.read_bytes() == b"time_s\n"
    assert path.name == key
    workspace.close()
    assert not path.exists()
