"""The loop walked by hand: what the search says of a version, and the work that makes new ones."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Literal, cast, get_args

import elastic_tendon as et
from elastic_tendon import effects
from elastic_tendon.app import results
from elastic_tendon.app.document import Document, Version
from elastic_tendon.app.own_effects import of_others
from elastic_tendon.app.results import Compared, Files
from elastic_tendon.app.workspace import Cache, Change, Result, Session, Work
from elastic_tendon.diagnosis import by_hand
from elastic_tendon.diagnosis.answer import Answer
from elastic_tendon.diagnosis.by_hand import LeftOpen, Outcome, Proposed, Ranked, SoFar
from elastic_tendon.diagnosis.data import Data, data_of
from elastic_tendon.diagnosis.diagnose import for_search
from elastic_tendon.diagnosis.options import Options
from elastic_tendon.diagnosis.result import Round
from elastic_tendon.errors import ElasticTendonError
from elastic_tendon.estimation.add import named_after
from elastic_tendon.estimation.ladder import REFIT, FittedStep, Step, climb
from elastic_tendon.native.library import library_path
from elastic_tendon.progress import Progress, silent
from elastic_tendon.simulation.signature import Signature, shown_on, signature

SEARCHING = "finding which effect is missing"
PROPOSING = "searching the experiment that decides"
REFITTED_AGAIN = "refitted to other data"
Kind = Literal["refit", "search", "try", "add", "propose"]  # of work that is asked for
KINDS: tuple[str, ...] = get_args(Kind)
EXAMPLE = "biorob_x4_joint_3"  # bundled model on which effects are shown


@dataclass(frozen=True)
class Tried:
    """A candidate beside the data, and the errors of the version without and with it."""

    compared: Compared
    before: Step
    after: Step


@dataclass(frozen=True)
class Interim:
    """What is known of a search under way.

    `version` : id of the one that it looks on from. `best` : the error with what it would take as
    far as it knows, None where that is nothing.
    """

    version: str
    round: Round
    best: Step | None


def is_fitted(document: Document, version: Version) -> bool:
    """Whether a version was fitted to the data that are chosen now."""
    return version.fitted_to == document.data_key()


def was_searched(document: Document, version: Version) -> bool:
    """Whether the search looked on from a version, in the data that are chosen now and with the
    effects that are known now."""
    return is_fitted(document, version) and version.searched == document.search_key()


# ---- results -------------------------------------------------------------------------------


def given_data(document: Document, version: Version, files: Files) -> Result[Data]:
    """The model as given from which a version was made, with the data as the search uses them."""

    def compute(cache: Cache, progress: Progress) -> Data:
        measurements = cache.obtain(results.data(document.at(version.id), files), progress)
        model, options = _root(document, version).loaded(), Options(without=of_others(document))
        return data_of(
            model, *for_search(model, measurements.fitted, measurements.heldout, options)
        )

    return Result(_key("given data", document, version), "preparing the data", compute)


def answer(document: Document, version: Version, files: Files) -> Result[Answer]:
    """A version's parameters refitted; where they are fitted to these data already, they stay."""

    def compute(cache: Cache, progress: Progress) -> Answer:
        data = cache.obtain(given_data(document, version, files), progress)
        if version.parent is None:
            return by_hand.base(data, progress)
        return by_hand.again(data, version.added, version.loaded(), progress)

    root = _root(document, version).model
    key = ("answer", document.data_key(), root, version.model, *version.added)
    return Result(key, f"refitting {version.title}", compute)


def outcome(
    document: Document, version: Version, files: Files, so_far: SoFar | None = None
) -> Result[Outcome]:
    """What the search finds when it looks on from a version that is fitted to these data."""

    def compute(cache: Cache, progress: Progress) -> Outcome:
        data = cache.obtain(given_data(document, version, files), progress)
        current = cache.obtain(answer(document, version, files), progress)
        return by_hand.next_round(data, current, progress, so_far)

    key = _key("outcome", document, version, version.model, *version.added)
    return Result(key, SEARCHING, compute)


def ranked(
    document: Document, version: Version, files: Files, so_far: SoFar | None = None
) -> Result[Ranked]:
    """What people look at of that: small, so a session's file keeps it."""

    def compute(cache: Cache, progress: Progress) -> Ranked:
        found = cache.obtain(outcome(document, version, files, so_far), progress)
        return by_hand.ranked(version.loaded(), found)

    key = _key("ranked", document, version, version.model, *version.added)
    return Result(key, SEARCHING, compute, Ranked)


def tried(document: Document, version: Version, effect_id: str, files: Files) -> Result[Tried]:
    """A version with a candidate of its round, beside the data; nothing is added."""

    def compute(cache: Cache, progress: Progress) -> Tried:
        found = cache.obtain(ranked(document, version, files), progress)
        return _tried(document.at(version.id), found, effect_id, files, cache, progress)

    key = _key("tried", document, version, version.model, effect_id)
    return Result(key, f"trying {effects.BY_ID[effect_id].title}", compute)


def _tried(
    document: Document,
    found: Ranked,
    effect_id: str,
    files: Files,
    cache: Cache,
    progress: Progress,
) -> Tried:
    """The current version with a candidate of what was found from it."""
    version, title = document.version, effects.BY_ID[effect_id].title
    before = cache.obtain(results.compared(document, version, files), progress)
    model = by_hand.preview(version.loaded(), found, effect_id)
    library_path(*model.structure, progress)
    progress(f"trying {title}", 0.5)
    data = cache.obtain(results.data(document, files), progress)
    heldout = et.compare(model, data.heldout) if data.heldout else None
    after = Compared(et.compare(model, data.fitted), heldout)
    names = (version.title, f"+ {title}")
    steps = climb([_step(*pair) for pair in zip(names, (before, after), strict=True)])
    return Tried(after, steps[0], steps[1])


def suggested(document: Document, version: Version, files: Files) -> Result[Step]:
    """The error with what the search would take, tried; of the version where that is nothing."""

    def compute(cache: Cache, progress: Progress) -> Step:
        chosen = cache.obtain(ranked(document, version, files), progress).round.chosen
        if not chosen:
            return cache.obtain(results.climbed(document.at(version.id), files), progress)[-1]
        # not put into the cache: the page shows what was tried only where somebody asked for it
        return tried(document, version, chosen[0], files).compute(cache, progress).after

    key = _key("suggested", document, version, version.model)
    return Result(key, "trying what the search would take", compute)


def _step(title: str, comparison: Compared) -> FittedStep:
    return FittedStep(title, None, 0, 0.0, comparison.fitted, comparison.heldout)


def shows(effect_id: str) -> Result[Signature]:
    """How an effect shows on the bundled `EXAMPLE`, at its typical size."""
    effect = effects.BY_ID[effect_id]

    def compute(_cache: Cache, progress: Progress) -> Signature:
        example = et.load_model(EXAMPLE)
        library_path((effect_id,), shown_on(effect, example).kind, progress)
        progress(f"drawing how {effect.title} shows", 0.5)
        return signature(effect, example)

    return Result(("shows", effect_id), f"drawing how {effect.title} shows", compute)


def concluded(document: Document, files: Files) -> Result[et.Diagnosis]:
    """The diagnosis that the way to the current version amounts to.

    The search looks on from that version, to tell whether more is missing.
    """
    path = document.path()

    def compute(cache: Cache, progress: Progress) -> et.Diagnosis:
        data = cache.obtain(given_data(document, path[0], files), progress)
        walk = _walked(document, files, cache, progress)
        if not walk:
            first = cache.obtain(answer(document, path[0], files), progress)
            walk.append(by_hand.Walked(REFIT, None, first, None))
        return by_hand.concluded(data, walk, progress)

    titles = (version.title for version in path)
    key = _key("concluded", document, path[-1], *titles, *_way(document))
    return Result(key, "concluding", compute)


def left_open(document: Document, files: Files) -> Result[LeftOpen]:
    """What the way to the current version, which was searched from, leaves open."""
    path = document.path()

    def compute(cache: Cache, progress: Progress) -> LeftOpen:
        data = cache.obtain(given_data(document, path[0], files), progress)
        return by_hand.left_open(data, _walked(document, files, cache, progress), progress)

    key = _key("left open", document, path[-1], *_way(document))
    return Result(key, "asking what is left open", compute, LeftOpen)


def proposed(document: Document, files: Files) -> Result[Proposed]:
    """The experiment that decides between what is left open."""
    path = document.path()

    def compute(cache: Cache, progress: Progress) -> Proposed:
        data = cache.obtain(given_data(document, path[0], files), progress)
        return by_hand.proposed(data, _walked(document, files, cache, progress), progress)

    key = _key("proposed", document, path[-1], *_way(document))
    return Result(key, PROPOSING, compute, Proposed)


def _walked(
    document: Document, files: Files, cache: Cache, progress: Progress
) -> list[by_hand.Walked]:
    """The way to the current version, from which the search looks on."""
    path = document.path()
    return [
        by_hand.Walked(
            title=version.title,
            added=version.change,
            answer=cache.obtain(answer(document, version, files), progress),
            outcome=cache.obtain(outcome(document, version, files), progress)
            if was_searched(document, version) or version is path[-1]
            else None,
        )
        for version in path[1:]
    ]


def _way(document: Document) -> list[str]:
    """Changes whenever another way led to the current version, whatever its steps are called."""
    return [f"{was_searched(document, step)}\n{step.model}" for step in document.path()]


def _key(kind: str, document: Document, version: Version, *others: str) -> tuple[str, ...]:
    """Names what follows from data, candidates, the model as given, and more."""
    return (kind, document.search_key(), _root(document, version).model, *others)


def _root(document: Document, version: Version) -> Version:
    """The model as given from which a version was made."""
    return document.at(version.id).path()[0]


def round_of(session: Session) -> Round | None:
    """The round of the current version, None where it was not searched from, or not yet again."""
    found = _ranked_of(session)
    return found.round if found is not None else None


def ended_early(session: Session) -> bool:
    """Whether the search from the current version was ended before it had tried everything."""
    found = _ranked_of(session)
    return found is not None and not found.complete


def _ranked_of(session: Session) -> Ranked | None:
    document = session.document
    if not was_searched(document, document.version):
        return None
    found = session.cache.find(ranked(document, document.version, session.files))
    return found if isinstance(found, Ranked) else None


def left_open_of(session: Session) -> LeftOpen | None:
    """What the current version leaves open, None where it was not searched from, or not yet."""
    document = session.document
    if not was_searched(document, document.version):
        return None
    found = session.cache.find(left_open(document, session.files))
    return found if isinstance(found, LeftOpen) else None


def proposed_of(session: Session) -> Proposed | None:
    """What came of seeking an experiment from the current version, None where that was not done."""
    if left_open_of(session) is None:
        return None
    found = session.cache.find(proposed(session.document, session.files))
    return found if isinstance(found, Proposed) else None


def before_the_choice(document: Document, left_open: LeftOpen) -> Document:
    """Look at the last version on the way that has no more effects than all that is left open."""
    before = [step for step in document.path() if left_open.shared.issuperset(step.added)]
    return document.at(before[-1].id)


def interim(session: Session) -> Interim | None:
    """What is known of the search that is under way from the current version."""
    job = session.job
    known = job.so_far if job is not None and job.state == "running" else None
    if isinstance(known, Interim) and known.version == session.document.current:
        return known
    return None


# ---- work that the user asks for -----------------------------------------------------------


def begin(session: Session, kind: Kind, effect_id: str = "") -> bool:
    """Begin work that a button asks for; False where other work is under way.

    Parameters
    ----------
    session : Session
    kind : of work
    effect_id : that is to be tried or added, "" for other work
    """
    title = effects.BY_ID[effect_id].title if effect_id else ""
    kinds: dict[Kind, tuple[str, str, Callable[[Session], Work]]] = {
        "refit": ("add", "refitting the parameters", refitting),
        "search": ("effect", SEARCHING, searching),
        "try": ("effect", f"trying {title}", partial(trying, effect_id=effect_id)),
        "add": ("add", f"adding {title}", partial(adding, effect_id=effect_id)),
        "propose": ("effect", PROPOSING, proposing),
    }
    step, words, make = kinds[kind]
    may_end = kind not in ("try", "propose")
    return session.start(step, words, make(session), asked=f"{kind} {effect_id}", may_end=may_end)


def begin_again(session: Session) -> None:
    """Begin anew what was under way when the server ended, if anything was."""
    kind, _, effect_id = session.asked.partition(" ")
    running = session.job is not None and session.job.state == "running"
    if not running and kind in KINDS and (not effect_id or effect_id in effects.BY_ID):
        begin(session, cast(Kind, kind), effect_id)


def refitting(session: Session) -> Work:
    """Refit the current version to the data; a version below it comes of that."""
    asked = session.document

    def work(progress: Progress) -> Change:
        document = _judged(asked, session, progress)
        return _growth(document.current, _refitted(document, session, progress))

    return work


def searching(session: Session) -> Work:
    """Find which effect the current version misses; refit it first where it is not."""
    asked, files, cache = session.document, session.files, session.cache

    def work(progress: Progress) -> Change | None:
        document = _judged(asked, session, progress)
        again = ended_early(session)
        grown, place = _fitted(document, session, progress)
        if grown is not document and _interrupted(grown, session, progress):
            return None
        cache.obtain(results.climbed(grown, files), progress)  # for the page, which waits
        if again:
            for make in (ranked, outcome):
                cache.forget(make(grown, grown.version, files))
            for conclude in (left_open, proposed):
                cache.forget(conclude(grown, files))

        def tell(found: Ranked) -> None:
            session.tell(Interim(place, found.round, _best(grown, found, session)))

        cache.obtain(ranked(grown, grown.version, files, tell), progress)
        key = document.search_key()
        return lambda latest: latest.with_search(place, key) if _has(latest, place) else latest

    return work


def _interrupted(document: Document, session: Session, progress: Progress) -> bool:
    """Whether somebody had enough of the current version's refit, which is the best so far."""
    refit = answer(document, document.version, session.files)
    return session.cache.obtain(refit, progress).result.interrupted


def _best(document: Document, found: Ranked, session: Session) -> Step | None:
    """The error with what a search from the current version would take, None where it is nothing
    or cannot be simulated in all recordings."""
    if not found.round.chosen:
        return None
    (chosen,) = found.round.chosen
    try:
        return _tried(document, found, chosen, session.files, session.cache, silent).after
    except ElasticTendonError:
        return None


def trying(session: Session, effect_id: str) -> Work:
    """Find how a candidate of its round changes the current version; nothing is added."""
    document = session.document

    def work(progress: Progress) -> None:
        session.cache.obtain(tried(document, document.version, effect_id, session.files), progress)

    return work


def proposing(session: Session) -> Work:
    """Seek the experiment that decides between what is left open; nothing is added."""
    document = session.document

    def work(progress: Progress) -> None:
        session.cache.obtain(proposed(document, session.files), progress)

    return work


def adding(session: Session, effect_id: str) -> Work:
    """Add an effect to the current version and refit both; refit it first where it is not."""
    asked, files, cache = session.document, session.files, session.cache

    def work(progress: Progress) -> Change:
        document = _judged(asked, session, progress)
        grown, place = _fitted(document, session, progress)
        data = cache.obtain(given_data(grown, grown.version, files), progress)
        current = cache.obtain(answer(grown, grown.version, files), progress)
        addition = by_hand.with_effect(data, current, effect_id, progress)
        title = f"+ {effects.BY_ID[effect_id].title}"
        progress(title, 1.0)  # a fit that was stopped comes back with its best so far
        version = _version(grown, title, addition).model_copy(update={"change": effect_id})
        _keep(grown, version, addition, session)
        return _growth(place, version)

    return work


def _judged(document: Document, session: Session, progress: Progress) -> Document:
    """A document that says which files cannot be used; the session's says so, too."""
    session.cache.obtain(results.data(document, session.files), progress)
    results.judge_files(session)
    return results.judged(document, session.files, session.cache)


def _fitted(document: Document, session: Session, progress: Progress) -> tuple[Document, str]:
    """A document whose current version is fitted to the data, and its id in the session, "" where
    that has it no longer.

    Where a refit had to come below it, the session has it at once and keeps it, whatever becomes
    of the work that goes on from there.
    """
    if is_fitted(document, document.version):
        return document, document.current
    grow = _growth(document.current, _refitted(document, session, progress))
    latest = session.change(grow)
    return grow(document), latest.current if _has(latest, document.current) else ""


def _refitted(document: Document, session: Session, progress: Progress) -> Version:
    before = document.version
    refitted = session.cache.obtain(answer(document, before, session.files), progress)
    version = _version(document, REFIT if before.parent is None else REFITTED_AGAIN, refitted)
    _keep(document, version, refitted, session)
    return version


def _version(document: Document, title: str, answer: Answer) -> Version:
    """An answer as a version below the current one, its id yet to come.

    Its uncertainties are those of the model as given, or further fits to the same data would
    count them twice.
    """
    return Version(
        id="",
        parent=document.current,
        title=title,
        added=answer.added,
        model=named_after(document.path()[0].loaded(), answer.result.model).to_toml(),
        effective=answer.result.findings.effective,
        fitted_to=document.data_key(),
    )


def _keep(document: Document, version: Version, kept: Answer, session: Session) -> None:
    grown = document.adding(version)
    session.cache.put(answer(grown, grown.version, session.files), kept)


def _growth(base: str, version: Version) -> Change:
    """Add a version below another, unless that was deleted meanwhile."""

    def change(latest: Document) -> Document:
        if not _has(latest, base):
            return latest
        return latest.adding(version.model_copy(update={"parent": base}))

    return change


def _has(document: Document, version_id: str) -> bool:
    return any(version.id == version_id for version in document.versions)
