"""A session in which the search and its experiment were found already: made by hand, not sought."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from threading import Thread

from elastic_tendon import demo
from elastic_tendon.app import walk
from elastic_tendon.app.document import Document, Source, Version, new_document
from elastic_tendon.app.results import Files
from elastic_tendon.app.server import Served, listen
from elastic_tendon.app.session_file import SessionFile, open_session
from elastic_tendon.diagnosis.by_hand import LeftOpen, Proposed, Ranked
from elastic_tendon.diagnosis.result import Experiment
from hand_made_diagnosis import COULOMB, friction_found, next_experiment

LUGRE = "lugre_friction"
OPEN = LeftOpen(((COULOMB,), (LUGRE,)), complete=True)
SEARCHED = "2"  # id of the version from which the search was begun
FILES = {"fit": demo.DATA / "demo_fit.csv"}


def searched() -> Document:
    """The parameters refitted, and searched from."""
    found = friction_found()
    document = new_document(found.given, [Source(key="fit", name="demo_fit.csv")])
    key = document.data_key()
    refitted = Version(
        id="",
        parent="1",
        title="parameters refitted",
        model=found.steps[1].comparison.model.to_toml(),
        fitted_to=key,
        searched=key,
    )
    return document.adding(refitted)


def with_friction() -> Document:
    """The same, and what the search suggests added; it is looked at."""
    document = searched()
    added = {
        "parent": document.current,
        "title": "+ Coulomb friction",
        "model": friction_found().model.to_toml(),
        "added": (COULOMB,),
        "change": COULOMB,
        "searched": "",
    }
    return document.adding(document.version.model_copy(update=added))


def searched_session(path: Path, document: Document | None = None) -> SessionFile:
    """The file of a session in which the experiment was found.

    Parameters
    ----------
    path : of the file
    document : that is looked at; None: as `searched`
    """
    found = friction_found()
    models = {effect_id: found.model.to_toml() for effect_id in (COULOMB, LUGRE)}
    first = found.rounds[0]
    singles = tuple(candidate for candidate in first.candidates if len(candidate.ids) == 1)
    made = session_with(
        path,
        searched(),
        FILES,
        Ranked(replace(first, candidates=singles), models),
        next_experiment(),
    )
    if document is not None:
        made.put("document", document.model_dump_json())
    return made


def session_with(
    path: Path, document: Document, files: Files, ranked: Ranked, experiment: Experiment
) -> SessionFile:
    """The file of a session, with what was found from the version that is looked at.

    Parameters
    ----------
    path : of the file
    document, files : as of a session
    ranked : what the search found; its first two candidates are left open
    experiment : that decides between these
    """
    made = open_session(path)
    made.begin(document, files)
    ids = tuple(candidate.ids for candidate in ranked.round.candidates[:2])
    for result, value in (
        (walk.ranked(document, document.version, files), ranked),
        (walk.left_open(document, files), LeftOpen(ids, complete=True)),
        (walk.proposed(document, files), Proposed(experiment, "")),
    ):
        made.keep(result.key, value)
    return made


@contextmanager
def served_session(file: SessionFile) -> Iterator[Served]:
    """The app that goes on with a session, in this process."""
    before = file.reopen()
    assert before is not None
    served = listen(before.document, before.files, kept=file)
    Thread(target=served.run, daemon=True).start()
    try:
        yield served
    finally:
        served.close()
