"""What Compare and Where look at: one recording and one signal, alone or beside the start."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from hashlib import sha256
from typing import Any

from elastic_tendon.app import results
from elastic_tendon.app.document import Document, Version
from elastic_tendon.app.results import Compared, Files
from elastic_tendon.app.workspace import Cache, Failure, Result, Session
from elastic_tendon.comparison.comparison import Comparison, FileComparison
from elastic_tendon.comparison.locate import FileLocation, Location, locate
from elastic_tendon.comparison.selection import at, only_where
from elastic_tendon.progress import Progress
from elastic_tendon.reports.interactive.overlay import Run
from elastic_tendon.reports.units import shown

FITTED, HELDOUT = "fitted", "held out"
SIGNAL = "joint_position"  # that is looked at first
AS_GIVEN, MADE = 0, 1  # colours of models, by their numbers in a theme


@dataclass(frozen=True)
class View:
    """A recording, by its key of `recordings`, and a signal; `before`: beside the model as given
    too; `tolerances`: signal -> largest error that is accepted, its unit, None where none is.
    """

    recording: str
    signal: str
    before: bool = True
    tolerances: Mapping[str, float | None] = field(default_factory=dict)

    @property
    def tolerance(self) -> float | None:
        """Of the signal that is looked at."""
        return self.tolerances.get(self.signal)

    def stored(self) -> dict[str, Any]:
        """As the page keeps it."""
        return asdict(self)


def recordings(compared: Compared) -> dict[str, FileComparison]:
    """All recordings beside a model; keys say whether they are fitted, and number them."""
    kinds = {FITTED: compared.fitted, HELDOUT: compared.heldout}
    return {
        f"{kind} {index}": file
        for kind, comparison in kinds.items()
        for index, file in enumerate(comparison.files if comparison else ())
    }


def is_fitted(recording: str) -> bool:
    """Whether a key of `recordings` is of one that is fitted."""
    return recording.startswith(FITTED)


def view_of(stored: Mapping[str, Any] | None, comparison: Compared) -> View:
    """What the page looks at; where it says nothing, or what is no longer there, the first.

    Parameters
    ----------
    stored : as `View.stored`
    comparison : Compared
    """
    chosen = stored or {}
    files = recordings(comparison)
    recording = _one_of(files, chosen.get("recording"))
    signal = _one_of(files[recording].signals, chosen.get("signal"), SIGNAL)
    tolerances = dict(chosen.get("tolerances", {}))
    return View(recording, signal, bool(chosen.get("before", True)), tolerances)


def fitted_view(stored: Mapping[str, Any] | None, comparison: Compared) -> View:
    """As `view_of`; the first recording that is fitted where one is looked at that is held out."""
    view = view_of(stored, comparison)
    return view if is_fitted(view.recording) else view_of(None, comparison)


def _one_of(names: Iterable[str], *wanted: str | None) -> str:
    """The first that is wanted and among the names, else the first of these."""
    held = list(names)
    return next((name for name in wanted if name is not None and name in held), held[0])


def recording_options(comparison: Compared, *, fitted_only: bool = False) -> list[dict[str, str]]:
    """Choices of recordings; where some are held out, each says what it is."""
    tell = comparison.heldout is not None and not fitted_only
    return [
        {
            "value": key,
            "label": file.measurement.name + (f" ({key.rsplit(' ', 1)[0]})" if tell else ""),
        }
        for key, file in recordings(comparison).items()
        if is_fitted(key) or not fitted_only
    ]


def signal_options(file: FileComparison) -> list[dict[str, str]]:
    """Choices of signals, with units."""
    options = {signal: shown(signal, static=file.measurement.static) for signal in file.signals}
    return [
        {"value": signal, "label": f"{quantity.words} ({quantity.unit})"}
        for signal, quantity in options.items()
    ]


# ---- what is in the cache ------------------------------------------------------------------


def before_of(document: Document) -> Version | None:
    """The model as given from which the current version was made; None where it is that."""
    root = document.path()[0]
    return None if root.id == document.current else root


def compared_now(session: Session) -> Compared | None:
    """The current version beside the data, None where it was not compared yet."""
    document = session.document
    comparison = session.cache.find(results.compared(document, document.version, session.files))
    return comparison if isinstance(comparison, Compared) else None


def runs_of(session: Session, view: View, where: Sequence[str] = ()) -> tuple[Run, ...]:
    """The models beside the recording that is looked at, the current version last.

    Empty where this one was not compared yet; the model as given is left out until it was. It has
    one colour, what was made from it another, wherever they are drawn. All are compared over the
    samples for which the conditions hold as the current version takes them.

    Raises
    ------
    MeasurementError : a condition cannot be read, or holds for no sample
    """
    comparison = compared_now(session)
    if comparison is None:
        return ()
    document = session.document
    root = before_of(document)
    file = recordings(comparison)[view.recording]
    (file,) = only_where(Comparison(comparison.fitted.model, (file,)), where).files
    runs: tuple[Run, ...] = (Run(document.version.title, file, AS_GIVEN if root is None else MADE),)
    if view.before and root is not None:
        start = session.cache.find(results.compared(document, root, session.files))
        if isinstance(start, Compared):
            title = root.title if root.title != document.version.title else f"{root.title}, before"
            beside = recordings(start)[view.recording]
            beside = at(start.fitted.model, beside, file.selection)
            runs = (Run(title, beside, AS_GIVEN), *runs)
    return runs


def fingerprint(session: Session, rests_on: Sequence[Result[Any]], *parts: object) -> str:
    """Equal for figures that would be drawn equal, so that those need not be drawn again.

    Parameters
    ----------
    rests_on : results that the figure shows, as far as they are there
    parts : all else that it depends on
    """
    there = [result.key for result in rests_on if session.cache.find(result) is not None]
    titles = [version.title for version in session.document.path()]
    return sha256(repr((there, titles, parts)).encode()).hexdigest()


def while_waiting(session: Session, rests_on: Sequence[Result[Any]], words: str) -> str:
    """What is said until the results are there: nothing where one failed, for the page tells why.

    Parameters
    ----------
    rests_on : results that are waited for
    words : str
    """
    results = [session.cache.find(result) for result in rests_on]
    return "" if any(isinstance(part, Failure) for part in results) else words


def located_heldout(document: Document, version: Version, files: Files) -> Result[Location]:
    """Where a version fails, in the recordings that are held out; none where there are none."""

    def compute(cache: Cache, progress: Progress) -> Location:
        comparison = cache.obtain(results.compared(document, version, files), progress)
        return locate(comparison.heldout or Comparison(version.loaded(), ()), progress)

    of_fitted = results.located(document, version, files)
    words = f"{of_fitted.words} in the recordings held out"
    return Result(("located held out", *of_fitted.key[1:]), words, compute)


def location_of(session: Session, view: View) -> FileLocation | None:
    """Where the current version fails in the recording that is looked at, once that was found."""
    document = session.document
    make = results.located if is_fitted(view.recording) else located_heldout
    location = session.cache.find(make(document, document.version, session.files))
    if not isinstance(location, Location):
        return None
    return location.files[int(view.recording.rsplit(" ", 1)[1])]
