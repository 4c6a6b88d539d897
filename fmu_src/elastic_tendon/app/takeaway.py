"""What can be taken away: each kind of file as a result, built on disk beside the page."""

import json
import re
import secrets
import shlex
import zipfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from hashlib import sha256
from importlib.metadata import version as installed
from io import TextIOWrapper
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal
from weakref import WeakValueDictionary, finalize

import elastic_tendon as et
from elastic_tendon.app import results, walk
from elastic_tendon.app.document import Document, Version
from elastic_tendon.app.figure_data import figures, recordings
from elastic_tendon.app.results import Files
from elastic_tendon.app.workspace import Cache, Result, Workspace
from elastic_tendon.comparison.comparison import SLACK_STATES
from elastic_tendon.diagnosis.by_hand import Ranked
from elastic_tendon.diagnosis.result import Round
from elastic_tendon.estimation.add import with_estimates
from elastic_tendon.fmu.export import FmiVersion, model_identifier
from elastic_tendon.progress import Progress
from elastic_tendon.reports.provenance import comments

if TYPE_CHECKING:
    import pandas as pd

    from elastic_tendon.reports.html.origin import Origin

Kind = Literal["fmu", "model", "report", "linear", "data", "findings"]
ENDINGS: Mapping[Kind, str] = {
    "fmu": ".fmu",
    "model": ".toml",
    "report": "_report.html",
    "linear": "_linear.zip",
    "data": "_data.zip",
    "findings": "_findings.json",
}
PURPOSES = {"fit": "fitted", "split": "fitted in part", "validate": "held out"}
_ROWS = 50_000  # of a table that are written between two reports


@dataclass(frozen=True, eq=False)
class Built:
    """A file to take away: `key` names it in a URL, `name` is what the user gets, `size` bytes."""

    key: str
    path: Path
    name: str
    size: int


class Depot:
    """Files that were built; each is there as long as a session keeps it in its cache."""

    def __init__(self, workspace: Workspace) -> None:
        self._workspace = workspace
        self._built: WeakValueDictionary[str, Built] = WeakValueDictionary()

    def build(self, name: str, write: Callable[[Path], object]) -> Built:
        """Let `write` fill a file; `name` is safe and is no part of its path but for the suffix."""
        path = self._workspace.new_path(Path(name).suffix)
        try:
            write(path)
        except BaseException:
            path.unlink(missing_ok=True)
            raise
        built = Built(secrets.token_hex(16), path, name, path.stat().st_size)
        finalize(built, _delete, path)
        self._built[built.key] = built
        return built

    def find(self, key: str) -> Built | None:
        """A file that was built, None where it is no longer there."""
        return self._built.get(key)


def _delete(path: Path) -> None:
    with suppress(OSError):  # where it is being sent it stays until the workspace is closed
        path.unlink()


@dataclass(frozen=True)
class FmuChoice:
    """How the FMU is to be; `platforms` by name, "all" among them for all."""

    fmi_version: FmiVersion = 2
    platforms: tuple[str, ...] = ()
    source: bool = False


def safe_name(text: str) -> str:
    """Letters, digits and underscores of a name, for a file; never empty."""
    return re.sub(r"\W+", "_", text, flags=re.ASCII).strip("_")[:60] or "unnamed"


def path_of(document: Document) -> str:
    """The way to the current version, in the titles of its steps."""
    return " → ".join(version.title for version in document.path())


def file_name(document: Document, kind: Kind) -> str:
    """What a file of the current version is called."""
    return model_identifier(document.version.loaded().name) + ENDINGS[kind]


def _result(
    kind: Kind,
    words: str,
    document: Document,
    compute: Callable[[Cache, Progress], Built],
    *options: str,
) -> Result[Built]:
    way = "\n".join(
        version.model_dump_json(exclude={"id", "parent"}) for version in document.path()
    )
    key = (kind, document.search_key(), sha256(way.encode()).hexdigest(), *options)
    return Result(key, words, compute)


# ---- the model ---------------------------------------------------------------------------------


def fmu(document: Document, choice: FmuChoice, depot: Depot) -> Result[Built]:
    """The FMU of the current version."""

    def compute(_cache: Cache, progress: Progress) -> Built:
        if not choice.platforms:
            raise et.BuildError("no platform is chosen; choose at least one for the FMU to run on")

        def write(path: Path) -> None:
            et.export_fmu(
                *(document.version.loaded(), path),
                fmi_version=choice.fmi_version,
                platforms=choice.platforms,
                source=choice.source,
                progress=progress,
            )

        return depot.build(file_name(document, "fmu"), write)

    options = (str(choice.fmi_version), ",".join(choice.platforms), str(choice.source))
    return _result("fmu", "building the FMU", document, compute, *options)


def model_file(document: Document, files: Files, depot: Depot) -> Result[Built]:
    """The current version as model.toml, with comments on where it comes from."""

    def compute(cache: Cache, progress: Progress) -> Built:
        version, notes = (
            document.version,
            list(_provenance(results.as_used(document, files, cache))),
        )
        text = version.model
        if version.parent is not None and walk.is_fitted(document, version):
            answer = cache.obtain(walk.answer(document, version, files), progress).result
            text = with_estimates(answer.model, answer.findings.estimates).to_toml()
            notes.append("uncertainties: as estimated from what was fitted")
        name = file_name(document, "model")
        whole = comments(notes) + text
        return depot.build(name, lambda path: path.write_text(whole, encoding="utf-8"))

    return _result("model", "writing the model file", document, compute)


def _provenance(document: Document) -> Iterator[str]:
    yield f"made by elastic-tendon {installed('elastic-tendon')}, in its app"
    yield f"steps: {path_of(document)}"
    for role, words in PURPOSES.items():
        if names := [source.name for source in document.sources if source.role == role]:
            yield f"{words}: {', '.join(names)}"


def linear(document: Document, depot: Depot) -> Result[Built]:
    """Linear models of each slack state, of the model as given and of the current version."""

    def compute(_cache: Cache, progress: Progress) -> Built:
        way = document.path()
        ends = [("as_given", way[0])] if len(way) == 1 else [("before", way[0]), ("after", way[-1])]

        def write(path: Path) -> None:
            with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
                for index, (label, version) in enumerate(ends):
                    progress(f"linearising {version.title}", index / len(ends))
                    _add_linear(archive, label, version.loaded(), depot)

        return depot.build(file_name(document, "linear"), write)

    return _result("linear", "linearising", document, compute)


def _add_linear(archive: zipfile.ZipFile, label: str, model: et.Model, depot: Depot) -> None:
    from elastic_tendon.linear.linear_json import linear_json
    from elastic_tendon.linear.mat import write_mat

    models, faults = [], []
    for state in SLACK_STATES.values():
        try:
            models.append(et.linearise(model, state))
        except et.LinearisationError as fault:
            faults.append(fault)
    if not models:
        raise faults[0]
    if faults:
        archive.writestr(f"{label}_notes.txt", "".join(f"{fault}\n" for fault in faults))
    archive.writestr(f"{label}.json", _json(linear_json(model.name, models)))
    built = depot.build(f"{label}.mat", lambda path: write_mat(model.name, models, path))
    archive.write(built.path, built.name)


# ---- what was found ----------------------------------------------------------------------------


def findings(document: Document, files: Files, depot: Depot) -> Result[Built]:
    """What was found, as JSON for programs: a diagnosis; where nothing was fitted, a comparison."""
    from elastic_tendon.comparison.comparison_json import comparison_json
    from elastic_tendon.diagnosis.diagnosis_json import diagnosis_json

    def compute(cache: Cache, progress: Progress) -> Built:
        if _was_walked(document):
            content = diagnosis_json(cache.obtain(walk.concluded(document, files), progress))
        else:
            content = comparison_json(
                *_compared(document, document.version, files, cache, progress)
            )
        text, name = _json(content), file_name(document, "findings")
        return depot.build(name, lambda path: path.write_text(text, encoding="utf-8"))

    return _result("findings", "writing the findings", document, compute)


def report_page(document: Document, files: Files, depot: Depot) -> Result[Built]:
    """The report that stands alone: of a diagnosis; where nothing was fitted, of a comparison."""

    def compute(cache: Cache, progress: Progress) -> Built:
        from elastic_tendon.reports.html.document import comparison_document, diagnosis_document

        walked = _was_walked(document)
        shown = document.path()[0] if walked else document.version
        comparison, where = _compared(document, shown, files, cache, progress)
        origin = _origin(results.as_used(document, files, cache), files)
        if walked:
            diagnosis = cache.obtain(walk.concluded(document, files), progress)
            text = diagnosis_document(diagnosis, where, origin, progress)
        else:
            text = comparison_document(comparison, where, origin, progress)
        name = file_name(document, "report")
        return depot.build(name, lambda path: path.write_text(text, encoding="utf-8"))

    return _result("report", "writing the report", document, compute)


def _was_walked(document: Document) -> bool:
    """Whether every step to the current version was fitted to the data that are chosen now."""
    steps = document.path()[1:]
    return bool(steps) and all(walk.is_fitted(document, step) for step in steps)


def _compared(
    document: Document, version: Version, files: Files, cache: Cache, progress: Progress
) -> tuple[et.Comparison, et.Location]:
    """A version beside the recordings that are fitted, and where it fails."""
    compared = cache.obtain(results.compared(document, version, files), progress)
    return compared.fitted, cache.obtain(results.located(document, version, files), progress)


def _origin(document: Document, files: Files) -> "Origin":
    """How to come to the same again; files go by the names that the user knows."""
    from elastic_tendon.reports.html.origin import origin_of

    used = [source for source in document.sources if source.role != "off" and source.key in files]
    names = {str(files[source.key]): source.name for source in used}
    origin = origin_of(
        _command(document), [(PURPOSES[source.role], files[source.key]) for source in used]
    )
    return replace(
        origin,
        files=tuple(replace(file, name=names.get(file.name, file.name)) for file in origin.files),
    )


def _command(document: Document) -> str:
    """What to type, and then to do on the page."""
    first, *steps = document.path()
    model = file_name(document.at(first.id), "model")
    fitted = [source.name for source in document.sources if source.role in ("fit", "split")]
    if not steps:
        return shlex.join(["elastic-tendon", "compare", model, *fitted])
    heldout = [source.name for source in document.sources if source.role == "validate"]
    words = ["elastic-tendon", "app", model, *fitted]
    words += [word for name in heldout for word in ("--validate", name)]
    words += [word for own in document.own_effects for word in ("--effect", own.file_name)]
    then = ", then ".join(step.title for step in steps)
    return f"{shlex.join(words)}  # {model}: as given; on the page: {then}"


def data(document: Document, files: Files, depot: Depot) -> Result[Built]:
    """What the figures show, a table each, and every recording beside its simulation."""

    def compute(cache: Cache, progress: Progress) -> Built:
        ends = dict.fromkeys((document.path()[0], document.version))
        known = [
            cache.obtain(results.compared(document, version, files), progress) for version in ends
        ]
        located = cache.obtain(results.located(document, document.version, files), progress)
        steps = cache.obtain(results.climbed(document, files), progress)
        rounds = _rounds(document, files, cache)
        tables = [*figures(known, located, steps, rounds), *recordings(known)]

        def write(path: Path) -> None:
            with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
                for index, table in enumerate(tables):
                    member = f"{table.folder}/{index + 1:02}_{safe_name(table.name)}.csv"
                    share = partial(progress, f"writing {member}", index / len(tables))
                    _add_table(archive, member, table.make(), share)

        return depot.build(file_name(document, "data"), write)

    return _result("data", "writing the data", document, compute)


def _rounds(document: Document, files: Files, cache: Cache) -> list[Round]:
    """What the search found on the way, as far as it is at hand; it is not worth another search."""
    rounds = []
    for version in document.path():
        if walk.was_searched(document, version):
            found = cache.find(walk.ranked(document, version, files))
            if isinstance(found, Ranked):
                rounds.append(found.round)
    return rounds


def _add_table(
    archive: zipfile.ZipFile, member: str, table: "pd.DataFrame", progress: Callable[[], object]
) -> None:
    """Write a table row by row, so that the user can stop it."""
    with archive.open(member, "w", force_zip64=True) as binary:
        text = TextIOWrapper(binary, encoding="utf-8", newline="")
        for start in range(0, max(len(table), 1), _ROWS):
            progress()
            table.iloc[start : start + _ROWS].to_csv(text, index=False, header=start == 0)
        text.flush()
        text.detach()


def _json(content: dict[str, Any]) -> str:
    return json.dumps(content, indent=2, allow_nan=False) + "\n"
