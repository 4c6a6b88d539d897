"""What follows from a document: each a `Result`, named by all that it depends on.

Steps of the page say which they need (`PageStep.needs`); the server computes the first that is not
there yet, one after the other, and the page shows what there is.
"""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from hashlib import sha256
from itertools import chain
from pathlib import Path

import elastic_tendon as et
from elastic_tendon.app.document import Document, Source, Version
from elastic_tendon.app.uploads import check_harmless
from elastic_tendon.app.workspace import Cache, CancelledError, Failure, Result, Session
from elastic_tendon.estimation.ladder import FittedStep, Step, climb
from elastic_tendon.measurement import Measurement
from elastic_tendon.measurement.formats import open_source
from elastic_tendon.measurement.formats.base import label
from elastic_tendon.measurement.reader import read_prepared
from elastic_tendon.measurement.recording import window_text
from elastic_tendon.misreadings.belief import believed
from elastic_tendon.native.library import library_path
from elastic_tendon.progress import Progress

Files = Mapping[str, Path]


@dataclass(frozen=True)
class Data:
    """Recordings that are fitted, and those that are held out."""

    fitted: tuple[Measurement, ...]
    heldout: tuple[Measurement, ...]


@dataclass(frozen=True)
class Compared:
    """A model beside the recordings that are fitted, and beside those held out, if there are."""

    fitted: et.Comparison
    heldout: et.Comparison | None


def contents(source: Source, files: Files) -> Result[tuple[str, ...]]:
    """Names of the columns of a file, by which a mapping finds them."""

    def compute(_cache: Cache, progress: Progress) -> tuple[str, ...]:
        with _calling_it(source, files) as path:
            progress(f"opening {source.name}", 0.0)
            check_harmless(path, source.name)
            groups = open_source(path).groups
        return tuple(label(group.name, column) for group in groups for column in group.columns)

    return Result(("contents", source.key, source.name), f"opening {source.name}", compute)


def reading(source: Source, files: Files) -> Result[tuple[Measurement, ...]]:
    """The recordings of one file, as it says it is read, not yet checked."""

    def compute(cache: Cache, progress: Progress) -> tuple[Measurement, ...]:
        cache.obtain(contents(source, files), progress)
        with _calling_it(source, files) as path:
            measurements = read_prepared(
                str(path) + (window_text(*source.window) if any_end(source) else ""),
                source.options,
                progress,
            )
        return tuple(
            replace(recording, name=recording.name.replace(path.name, source.name))
            for recording in measurements
        )

    return Result(("reading", _how(source)), f"reading {source.name}", compute)


def _how(source: Source) -> str:
    """Changes whenever a file is read otherwise."""
    return source.model_dump_json(
        exclude={"role": True, "split": True, "left_out": True, "options": {"as_declared"}}
    )


@contextmanager
def _calling_it(source: Source, files: Files) -> Iterator[Path]:
    """Path of a file; errors call it as the user does, for it may lie under a name of our own."""
    path = files.get(source.key)
    if path is None:
        raise et.MeasurementError(f"{source.name}: the app holds it no longer; add it again")
    try:
        yield path
    except et.MeasurementError as error:
        sentence = str(error).replace(str(path), source.name).replace(path.name, source.name)
        raise et.MeasurementError(sentence) from None


def any_end(source: Source) -> bool:
    """Whether only a part of the file is read."""
    return any(end is not None for end in source.window)


def checked(document: Document, source: Source, files: Files) -> Result[tuple[Measurement, ...]]:
    """The recordings of one file, believed as far as the model as given tells; noise is known."""
    root = document.path()[0]

    def compute(cache: Cache, progress: Progress) -> tuple[Measurement, ...]:
        read = cache.obtain(reading(source, files), progress)
        measurements = believed(
            root.loaded(), read, progress, as_declared=source.options.as_declared
        )
        for index, recording in enumerate(measurements):
            progress(f"finding the noise of {recording.name}", index / len(measurements))
            _ = recording.noise  # kept by the measurement
        return tuple(measurements)

    key = ("checked", _how(source), str(source.options.as_declared), _hash(root.model))
    return Result(key, f"checking {source.name}", compute)


def data(document: Document, files: Files) -> Result[Data]:
    """All recordings that are used, believed as far as the model as given tells, and split."""

    def compute(cache: Cache, progress: Progress) -> Data:
        found: list[Data] = []
        faults: list[str] = []
        for source in document.used:
            try:
                found.append(cache.obtain(parts(document, source, files), progress))
            except CancelledError:
                raise
            except et.ElasticTendonError as error:  # it keeps none of the others back
                faults.append(str(error))
        fitted = tuple(recording for part in found for recording in part.fitted)
        if not fitted:
            nothing = "no recording is fitted; add one and let it be fitted"
            raise et.MeasurementError(faults[0] if faults else nothing)
        return Data(fitted, tuple(recording for part in found for recording in part.heldout))

    root = _hash(document.path()[0].model)
    return Result(("data", document.data_key(), root), "reading the data", compute)


def parts(document: Document, source: Source, files: Files) -> Result[Data]:
    """What of one file is fitted, and what is held out."""
    recordings = checked(document, source, files)

    def compute(cache: Cache, progress: Progress) -> Data:
        pairs = [split_up(source, part) for part in cache.obtain(recordings, progress)]
        fitted, heldout = (tuple(chain.from_iterable(side)) for side in zip(*pairs, strict=True))
        return Data(fitted, heldout)

    key = ("parts", *recordings.key, source.role, str(source.split))
    return Result(key, f"reading {source.name}", compute)


def judged(document: Document, files: Files, cache: Cache) -> Document:
    """The same, where files that cannot be used say why, as far as that is known."""

    def judge(source: Source) -> Source:
        known = cache.find(parts(document, source, files))
        if known is None or (isinstance(known, Failure) and known.cancelled):
            return source
        left_out = ""
        if isinstance(known, Failure):
            why = known.sentence.removeprefix(f"{source.name}: ")
            left_out = f"{source.name} is left out: {why}."
        return source.model_copy(update={"left_out": left_out})

    return document.with_sources(list(map(judge, document.sources)))


def judge_files(session: Session) -> None:
    """Let the session's document say which files cannot be used, as far as that is known."""
    files, cache = session.files, session.cache
    if judged(session.document, files, cache) != session.document:
        session.change(lambda latest: judged(latest, files, cache))


def as_used(document: Document, files: Files, cache: Cache) -> Document:
    """The same less files that cannot be used, as far as that is known."""
    return document.with_sources(judged(document, files, cache).used)


def split_up(source: Source, recording: Measurement) -> tuple[list[Measurement], list[Measurement]]:
    """The part of a recording that is fitted, and the part that is held out.

    Raises
    ------
    MeasurementError : one of the parts is too short
    """
    if source.role == "validate":
        return [], [recording]
    if source.role == "split" and source.split is not None:
        later = recording.time[
            recording.time > source.split
        ]  # a sample at the split is fitted only
        start = float(later[0]) if len(later) else source.split
        return [recording.window(None, source.split)], [recording.window(start, None)]
    return [recording], []


def compared(document: Document, version: Version, files: Files) -> Result[Compared]:
    """A version beside the data."""

    def compute(cache: Cache, progress: Progress) -> Compared:
        measurements = cache.obtain(data(document, files), progress)
        model = version.loaded()
        library_path(*model.structure, progress)
        progress(f"comparing {version.title}", 0.5)
        heldout = et.compare(model, measurements.heldout) if measurements.heldout else None
        return Compared(et.compare(model, measurements.fitted), heldout)

    return Result(
        ("compared", document.data_key(), _hash(version.model)),
        f"comparing {version.title}",
        compute,
    )


def located(document: Document, version: Version, files: Files) -> Result[et.Location]:
    """Where a version fails, in the recordings that are fitted."""

    def compute(cache: Cache, progress: Progress) -> et.Location:
        comparison = cache.obtain(compared(document, version, files), progress)
        return et.locate(comparison.fitted, progress)

    return Result(
        ("located", document.data_key(), _hash(version.model)),
        f"finding where {version.title} fails",
        compute,
    )


def climbed(document: Document, files: Files) -> Result[tuple[Step, ...]]:
    """The ladder of errors from the root to the current version."""
    path = document.path()

    def compute(cache: Cache, progress: Progress) -> tuple[Step, ...]:
        return climb(ladder_steps(document, files, cache, progress))

    hashes = [_hash(version.model + version.title) for version in path]
    return Result(("climbed", document.data_key(), *hashes), "comparing each step", compute)


def ladder_steps(
    document: Document, files: Files, cache: Cache, progress: Progress
) -> tuple[FittedStep, ...]:
    """The versions from the root to the current one as steps of a ladder."""
    steps = []
    for version in document.path():
        comparison = cache.obtain(compared(document, version, files), progress)
        added = version.change
        steps.append(
            FittedStep(
                title=version.title,
                added=added,
                parameters=len(et.effects.BY_ID[added].parameters) if added else 0,
                effective=version.effective,
                comparison=comparison.fitted,
                heldout=comparison.heldout,
            )
        )
    return tuple(steps)


def _hash(text: str) -> str:
    return sha256(text.encode()).hexdigest()
