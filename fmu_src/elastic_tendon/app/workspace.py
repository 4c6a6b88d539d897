"""What the server holds for a browser's session: document, files, results, and work under way."""

import logging
import secrets
import shutil
import tempfile
from collections import OrderedDict
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from threading import RLock, Thread
from typing import Any, Generic, Literal, TypeVar

from pydantic import ValidationError

from elastic_tendon import effects
from elastic_tendon.app.document import Document, from_browser
from elastic_tendon.app.session_file import SessionFile
from elastic_tendon.errors import EffectError, ElasticTendonError
from elastic_tendon.output import OutputError
from elastic_tendon.progress import Enough, Progress

T = TypeVar("T")
Change = Callable[[Document], Document]
Work = Callable[[Progress], Change | None]
Stored = Mapping[str, object]  # what the browser keeps: id, revision, document

SESSIONS = 8  # that are held; the browser brings back the document of one that was dropped
RESULTS = 200  # of a session; each file of measurements has three, and all of them must fit
CANCELLED = "Cancelled; choose the step again to begin anew."


class Stopped(KeyboardInterrupt):
    """The user stopped the work; a fit keeps its best so far on it, as on Ctrl-C."""


def fault_sentence(words: str, error: Exception) -> str:
    """A sentence about a fault of ours."""
    return f"{words} failed, which should not happen ({type(error).__name__}: {error})"


@dataclass(frozen=True)
class Failure:
    """Why there is no result, in one sentence."""

    sentence: str

    @property
    def cancelled(self) -> bool:
        """Whether the user wanted none."""
        return self.sentence == CANCELLED


class CancelledError(ElasticTendonError):
    """The user cancelled what a result rests on."""


class Cache:
    """Results that were computed, by key; those not asked for the longest go first.

    Parameters
    ----------
    kept : file of the session, which has what is dear on disk too; None where there is none
    """

    def __init__(self, kept: SessionFile | None = None) -> None:
        self._kept = kept
        self._lock = RLock()
        self._held: OrderedDict[tuple[str, ...], object] = OrderedDict()

    def find(self, result: "Result[T]") -> T | Failure | None:
        """A result, why there is none, or None where it was not computed yet."""
        with self._lock:
            if result.key not in self._held and not self._brought_back(result):
                return None
            self._held.move_to_end(result.key)
            return self._held[result.key]  # type: ignore[return-value]  # its key is its own

    def _brought_back(self, result: "Result[T]") -> bool:
        """Whether the session's file has a result, which is held then."""
        if self._kept is None or result.kept_as is None:
            return False
        value = self._kept.find(result.key, result.kept_as)
        if value is not None:
            self._hold(result, value)
        return value is not None

    def obtain(self, result: "Result[T]", progress: Progress) -> T:
        """A result, computed here and now if need be.

        Raises
        ------
        ElasticTendonError : it cannot be computed; the reason is kept as a `Failure`
        CancelledError : the user cancelled it before
        Stopped : the user stopped the work
        """
        value = self.find(result)
        if isinstance(value, Failure):
            raise (CancelledError if value.cancelled else ElasticTendonError)(value.sentence)
        if value is not None:
            return value
        try:
            computed = result.compute(self, progress)
            progress(result.words, 1.0)  # a fit that was stopped comes back with its best so far
        except ElasticTendonError as error:
            self.put(result, Failure(str(error)))
            raise
        except Exception as error:
            raise self._fault(result, error) from error
        self.put(result, computed)
        return computed

    def _fault(self, result: "Result[T]", error: Exception) -> ElasticTendonError:
        """A fault of ours: told where it occurred, and not tried again and again."""
        logging.getLogger(__name__).exception("%s failed", result.words)
        fault = ElasticTendonError(fault_sentence(result.words, error))
        self.put(result, Failure(str(fault)))
        return fault

    def forget(self, result: "Result[Any]") -> None:
        """Let a result be computed anew.

        Raises
        ------
        OutputError : the session's file does not take it
        """
        with self._lock:
            self._held.pop(result.key, None)
        if self._kept and result.kept_as:
            self._kept.drop(result.key)

    def put(self, result: "Result[T]", value: T | Failure) -> None:
        """Keep a result that was computed elsewhere.

        Raises
        ------
        OutputError : the session's file does not take it; it is held all the same
        """
        self._hold(result, value)
        if self._kept and result.kept_as and not isinstance(value, Failure):
            self._kept.keep(result.key, value)

    def _hold(self, result: "Result[T]", value: T | Failure) -> None:
        with self._lock:
            self._held[result.key] = value
            self._held.move_to_end(result.key)
            while len(self._held) > RESULTS:
                self._held.popitem(last=False)

    def clear(self) -> None:
        """Let everything be computed anew but what the session's file has."""
        with self._lock:
            self._held.clear()

    def forget_failures(self) -> None:
        """Let what failed be tried again."""
        with self._lock:
            for key in [key for key, value in self._held.items() if isinstance(value, Failure)]:
                del self._held[key]


@dataclass(frozen=True)
class Result(Generic[T]):
    """Something that follows from a document: what names it, and how it is computed.

    `key` : equal for equal results. `words` : what computing it is called. `compute` is given the
    cache, to obtain what it rests on, and a function to report progress. `kept_as` : its data
    class, of numbers and text, where it is too dear to be computed again when the server ends.
    """

    key: tuple[str, ...]
    words: str
    compute: Callable[[Cache, Progress], T] = field(compare=False)
    kept_as: type[T] | None = None


@dataclass
class Job:
    """Work under way or done; `step` is where on the page it was asked for.

    `result` : what it computes for the page, None where the user asked for something else.
    `may_end` : it has a best so far, which can be taken. `so_far` : what of it can be looked at.
    """

    step: str
    words: str
    result: Result[Any] | None = None
    may_end: bool = False
    so_far: object = None
    share: float = 0.0
    state: Literal["running", "done", "stopped", "failed"] = "running"
    sentence: str = ""
    stopping: bool = False
    ending: bool = False

    def progress(self, words: str, share: float) -> None:
        """Note how far the work is.

        Raises
        ------
        Stopped : the user asked for it
        Enough : the user takes the best so far; once, for the work then goes on to its end
        """
        if self.stopping:
            raise Stopped
        if self.ending:
            self.ending = False
            raise Enough
        self.words, self.share = words, min(max(share, 0.0), 1.0)


class Session:
    """One tab of a browser, or all tabs that look at a session's file.

    One piece of work at a time runs beside it. `name` : of the file, "" where there is none.
    `opened` : id of the step that was looked at last. `asked` : the work that a user asked for and
    that was under way when the server ended, as it was given to `start`; "" where none was.
    `unsaved` : why the file does not have the latest, "" where it does.
    """

    def __init__(
        self,
        session_id: str,
        document: Document,
        files: Mapping[str, Path],
        kept: SessionFile | None = None,
    ) -> None:
        self.id = session_id
        self.files = files
        self.cache = Cache(kept)
        self.revision = 0
        self.job: Job | None = None
        self.name = kept.name if kept else ""
        self.opened, self.asked = (kept.get("opened"), kept.get("asked")) if kept else ("", "")
        self.unsaved = ""
        self._kept = kept
        self._document = document
        self._lock = RLock()

    @property
    def document(self) -> Document:
        """What the user has chosen and reached."""
        return self._document

    def change(self, make: Change) -> Document:
        """Put another document in place, and return it; `make` is given the latest one."""
        with self._lock:
            self._document = make(self._document)
            self.revision += 1
            self._save("document", self._document.model_dump_json())
            return self._document

    def look_at(self, step: str) -> None:
        """Note which step is open."""
        if step != self.opened:
            self.opened = step
            self._save("opened", step)

    def _save(self, name: str, value: str) -> None:
        if self._kept is None:
            return
        try:
            self._kept.put(name, value)
            self.unsaved = ""
        except OutputError as error:  # what the user does goes on all the same
            self.unsaved = str(error)

    def stored(self) -> dict[str, object]:
        """What the browser keeps of the session."""
        with self._lock:
            return {
                "id": self.id,
                "revision": self.revision,
                "document": self._document.model_dump_json(),
            }

    def compute(self, step: str, result: Result[Any]) -> bool:
        """Begin to compute what a step shows; see `start`."""

        def work(progress: Progress) -> None:
            self.cache.obtain(result, progress)

        return self.start(step, result.words, work, result)

    def start(
        self,
        step: str,
        words: str,
        work: Work,
        result: Result[Any] | None = None,
        asked: str = "",
        may_end: bool = False,
    ) -> bool:
        """Begin a piece of work beside the page; False where one is under way already.

        Parameters
        ----------
        step : id of the step that asks for it; its error is shown there
        words : what is being done
        work : is given the function to report progress; leaves what it found in the cache, and
            returns the change of the document that follows, None where none does; what was
            stopped changes nothing
        result : what it computes for the page
        asked : what a user asked for, so that it can be begun again where the server ends before
        may_end : it has a best so far, see `take_best`
        """
        with self._lock:
            if self.job is not None and self.job.state == "running":
                return False
            self.job = Job(step, words, result, may_end)
            self._note_asked(asked)
            Thread(target=self._run, args=(self.job, work), daemon=True).start()
            return True

    def stop(self) -> None:
        """Let go of the work under way: when it next tells how far it is, it ends with nothing."""
        with self._lock:
            if self.job is not None and self.job.state == "running":
                self.job.stopping = True
                self.job.state = "stopped"
                if self.job.result is not None:  # else the page would ask for it again
                    self.cache.put(self.job.result, Failure(CANCELLED))
                self._note_asked("")
                self.revision += 1

    def take_best(self) -> None:
        """End the work under way with the best so far; where it has none yet, with nothing."""
        with self._lock:
            if self.job is not None and self.job.state == "running":
                self.job.ending = self.job.may_end

    def tell(self, so_far: object) -> None:
        """Let the page look at what is known of the work under way."""
        with self._lock:
            if self.job is not None and self.job.state == "running":
                self.job.so_far = so_far
                self.revision += 1

    def _run(self, job: Job, work: Work) -> None:
        state: Literal["done", "failed"] = "done"
        change: Change | None = None
        try:
            change = work(job.progress)
        except Stopped:
            return
        except Enough:  # nothing was known yet
            self.stop()
            return
        except ElasticTendonError as error:
            state, job.sentence = "failed", str(error)
        except Exception as error:  # a fault of ours: the page must not wait for ever
            logging.getLogger(__name__).exception("%s failed", job.words)
            state, job.sentence = "failed", fault_sentence(job.words, error)
        with self._lock:
            if job.stopping:
                return
            if change is not None:
                self.change(change)
            job.state = state
            self._note_asked("")
            self.revision += 1

    def _note_asked(self, asked: str) -> None:
        if asked != self.asked:
            self.asked = asked
            self._save("asked", asked)


class Workspace:
    """All sessions and the files that they may use.

    Parameters
    ----------
    start : what a new session begins with
    files : key -> path of files named on the command line
    kept : file of the one session that all tabs look at then; None: each tab has its own
    shared : other machines may use it, so it runs nothing that is typed on the page
    """

    def __init__(
        self,
        start: Document,
        files: Mapping[str, Path],
        kept: SessionFile | None = None,
        *,
        shared: bool = False,
    ) -> None:
        self.shared = shared
        self._start = start
        self._files = dict(files)
        self._folder = Path(tempfile.mkdtemp(prefix="elastic-tendon-app-"))
        self._kept = kept
        self._only: Session | None = None
        if kept is not None:
            self._files |= kept.put_uploads(self._folder)
            self._only = Session("", start, self._files, kept)
        self._sessions: OrderedDict[str, Session] = OrderedDict()
        self._lock = RLock()

    @property
    def name(self) -> str:
        """Of the file that keeps the session, "" where there is none."""
        return "" if self._kept is None else self._kept.name

    def close(self) -> None:
        """Stop all work and delete what was uploaded."""
        if self._kept is not None and self._only is not None:
            self._kept.close()  # first, for what is under way now begins again next time
            self._only.stop()
        for session in self._sessions.values():
            session.stop()
        shutil.rmtree(self._folder, ignore_errors=True)

    def add_file(self, content: bytes) -> str:
        """Keep an upload; its name, which a stranger may have chosen, is no part of the path.

        Raises
        ------
        OutputError : the session's file does not take it
        """
        path = self.new_path()
        if self._kept is not None:
            self._kept.keep_upload(path.name, content)
        path.write_bytes(content)
        with self._lock:
            self._files[path.name] = path
        return path.name

    def forget_effect(self, session: Session, effect_id: str) -> None:
        """Let a session know an effect of its user's no more; nobody else's, its id is free again.

        Raises
        ------
        EffectError : a version has it, or work is under way, which may use it
        """
        with self._lock:
            if session.job is not None and session.job.state == "running":
                raise EffectError(
                    "something is being computed; wait until it is done, or cancel it"
                )
            session.change(lambda document: document.without_own_effect(effect_id))
            sessions = [self._only] if self._only else self._sessions.values()
            kept = {own.id for known in sessions for own in known.document.own_effects}
            if effect_id in effects.BY_ID.from_texts - kept:
                effects.BY_ID.forget(effect_id)
                session.cache.clear()

    def new_path(self, suffix: str = "") -> Path:
        """A path for a file of the server's own, which goes with the workspace at the latest."""
        return self._folder / (secrets.token_hex(8) + suffix)

    def find(self, session_id: str) -> Session | None:
        """The session of this id that is open; where a file has one, always that."""
        return self._only or self._sessions.get(session_id)

    def open(self, stored: Stored | None) -> Session:
        """The session that a browser kept, or a new one; where a file has one, always that.

        Raises
        ------
        ElasticTendonError : the browser kept none
        """
        with self._lock:
            if self._only is not None:
                return self._only
            try:
                session_id = str(stored["id"]) if stored else secrets.token_hex(8)
                session = self._sessions.get(session_id)
                document = from_browser(stored) if stored and not session else self._start
            except (KeyError, TypeError, ValidationError):
                raise ElasticTendonError(
                    "the browser's copy of this session is damaged; open the app in a new tab"
                ) from None
            if session is None:
                session = Session(session_id, document, self._files)
                self._sessions[session.id] = session
            self._sessions.move_to_end(session.id)
            while len(self._sessions) > SESSIONS:
                self._sessions.popitem(last=False)[1].stop()
            return session
