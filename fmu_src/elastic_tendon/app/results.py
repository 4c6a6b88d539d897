"""What follows from a document: each a `Result`, named by all that it depends on.

Steps of the page say which they need (`Step.needs`); the server computes the first that is not
there yet, one after the other, and the page shows what there is.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from hashlib import sha256
from pathlib import Path

from elastic_tendon import compiled, effects
from elastic_tendon.app.document import Document, Source, Version
from elastic_tendon.app.workspace import Report, Result, Shelf
from elastic_tendon.errors import MeasurementError
from elastic_tendon.identify.belief import believed
from elastic_tendon.identify.compare import Comparison, compare
from elastic_tendon.identify.ladder import Rung, Step, climb
from elastic_tendon.identify.locate import Location, locate
from elastic_tendon.measurement import Measurement
from elastic_tendon.measurement.reader import read_prepared
from elastic_tendon.measurement.recording import window_text

Files = Mapping[str, Path]


@dataclass(frozen=True)
class Data:
    """Recordings that are fitted, and those that only judge."""

    fitted: tuple[Measurement, ...]
    heldout: tuple[Measurement, ...]


@dataclass(frozen=True)
class Compared:
    """A model beside the recordings that are fitted, and beside those held out, if there are."""

    fitted: Comparison
    heldout: Comparison | None


def reading(source: Source, files: Files) -> Result[tuple[Measurement, ...]]:
    """The recordings of one file, as it says it is read; whether they are right is not judged."""

    def compute(_shelf: Shelf, report: Report) -> tuple[Measurement, ...]:
        path = files.get(source.key)
        if path is None:
            raise MeasurementError(f"{source.name}: the app holds it no longer; add it again")
        try:
            found = read_prepared(
                str(path) + (window_text(*source.window) if any_end(source) else ""),
                source.mapping,
                time_shift=source.time_shift,
                resample=source.resample,
                remove_offset=source.remove_offset,
                interpolation=source.interpolation,
                report=report,
            )
        except MeasurementError as error:
            # the file lies under a name of the server's own
            sentence = str(error).replace(str(path), source.name).replace(path.name, source.name)
            raise MeasurementError(sentence) from None
        return tuple(replace(one, name=one.name.replace(path.name, source.name)) for one in found)

    how = source.model_dump_json(exclude={"role", "split", "as_declared"})
    return Result(("reading", how), f"reading {source.name}", compute)


def any_end(source: Source) -> bool:
    """Whether only a part of the file is read."""
    return any(end is not None for end in source.window)


def data(document: Document, files: Files) -> Result[Data]:
    """All recordings that are used, believed as far as the model as given tells, and split."""
    root = document.path()[0]

    def compute(shelf: Shelf, report: Report) -> Data:
        model = root.loaded()
        fitted: list[Measurement] = []
        heldout: list[Measurement] = []
        for source in document.sources:
            if source.role == "off":
                continue
            found = shelf.obtain(reading(source, files), report)
            for one in believed(model, found, report, as_declared=source.as_declared):
                first, second = _split(source, one)
                fitted += first
                heldout += second
        if not fitted:
            raise MeasurementError("no recording is fitted; add one and let it be fitted")
        return Data(tuple(fitted), tuple(heldout))

    return Result(("data", document.data_key(), _hash(root.model)), "reading the data", compute)


def _split(source: Source, one: Measurement) -> tuple[list[Measurement], list[Measurement]]:
    if source.role == "validate":
        return [], [one]
    if source.role == "split" and source.split is not None:
        return [one.window(None, source.split)], [one.window(source.split, None)]
    return [one], []


def compared(document: Document, version: Version, files: Files) -> Result[Compared]:
    """A version beside the data."""

    def compute(shelf: Shelf, report: Report) -> Compared:
        found = shelf.obtain(data(document, files), report)
        model = version.loaded()
        compiled.library_path(model.effect_ids, report)
        report(f"comparing {version.title}", 0.5)
        heldout = compare(model, found.heldout) if found.heldout else None
        return Compared(compare(model, found.fitted), heldout)

    return Result(
        ("compared", document.data_key(), _hash(version.model)),
        f"comparing {version.title}",
        compute,
    )


def located(document: Document, version: Version, files: Files) -> Result[Location]:
    """Where a version fails, in the recordings that are fitted."""

    def compute(shelf: Shelf, report: Report) -> Location:
        found = shelf.obtain(compared(document, version, files), report)
        return locate(found.fitted, report)

    return Result(
        ("located", document.data_key(), _hash(version.model)),
        f"finding where {version.title} fails",
        compute,
    )


def climbed(document: Document, files: Files) -> Result[tuple[Rung, ...]]:
    """The ladder of errors from the root to the current version."""
    path = document.path()

    def compute(shelf: Shelf, report: Report) -> tuple[Rung, ...]:
        return climb(ladder_steps(document, files, shelf, report))

    hashes = [_hash(one.model + one.title) for one in path]
    return Result(("climbed", document.data_key(), *hashes), "comparing each step", compute)


def ladder_steps(
    document: Document, files: Files, shelf: Shelf, report: Report
) -> tuple[Step, ...]:
    """The versions from the root to the current one as steps of a ladder."""
    steps = []
    for version in document.path():
        found = shelf.obtain(compared(document, version, files), report)
        parameters = 0 if version.change is None else len(effects.BY_ID[version.change].parameters)
        steps.append(
            Step(
                title=version.title,
                added=version.change,
                parameters=parameters,
                effective=version.effective,
                comparison=found.fitted,
                heldout=found.heldout,
            )
        )
    return tuple(steps)


def _hash(text: str) -> str:
    return sha256(text.encode()).hexdigest()
