"""What the step Add says: the tree of versions, and how each compares."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from elastic_tendon import effects
from elastic_tendon.app import walk
from elastic_tendon.app.document import Document, Version
from elastic_tendon.app.results import Compared
from elastic_tendon.app.tables import Exact
from elastic_tendon.app.view import SIGNAL
from elastic_tendon.diagnosis.result import Round
from elastic_tendon.estimation.ladder import Step
from elastic_tendon.reports.tables import alias_sentences, distrust_sentences, fall_sentences
from elastic_tendon.reports.units import noise_ratio, number, shown

NOISE = 1.1  # times the noise, up to which an error is taken for noise
UNKNOWN = "-"  # where a version was not compared with these data yet


@dataclass(frozen=True)
class Row:
    """A version in the tree: `depth` below its root, whether it is the `current` one.

    `fitted`, `heldout` : error in the signal's small unit, and `ratio` times the noise; `below` :
    how many versions were made from it. `deletable` : it is not the only root. `model` : name of a
    root's model, which those below it share; else "".
    """

    version: Version
    depth: int
    current: bool
    below: int
    deletable: bool
    model: str = ""
    fitted: str | Exact = UNKNOWN
    heldout: str | Exact = UNKNOWN
    ratio: str | Exact = UNKNOWN


def tree(document: Document) -> list[Row]:
    """All versions, each followed by those made from it; not compared with anything."""
    roots = [version for version in document.versions if version.parent is None]
    return [row for root in roots for row in _branch(document, root, 0, len(roots))]


def _branch(document: Document, version: Version, depth: int, roots: int) -> Iterator[Row]:
    rows = [
        row
        for child in document.children(version.id)
        for row in _branch(document, child, depth + 1, roots)
    ]
    deletable = version.parent is not None or roots > 1
    name = "" if version.parent is not None else version.loaded().name
    yield Row(version, depth, version.id == document.current, len(rows), deletable, name)
    yield from rows


def errors_of(comparison: Compared, signal: str) -> tuple[Exact, str | Exact, Exact]:
    """Error on fitted and on held-out data, small unit, and the former over the noise."""
    small = shown(signal).small

    def size(rmse: float) -> Exact:
        return Exact(number(small * rmse), small * rmse)

    heldout = comparison.heldout.rmse() if comparison.heldout is not None else {}
    ratio = comparison.fitted.noise_ratio()[signal]
    return (
        size(comparison.fitted.rmse()[signal]),
        size(heldout[signal]) if signal in heldout else UNKNOWN,
        Exact(noise_ratio(ratio), ratio),
    )


def is_static(comparison: Compared) -> bool:
    """Whether all that is fitted are static curves, whose joint position is a deflection."""
    return all(file.measurement.static for file in comparison.fitted.files)


def shown_signal(comparison: Compared) -> str:
    """The signal whose error stands in the tree."""
    signals = list(comparison.fitted.rmse())
    return SIGNAL if SIGNAL in signals else signals[0]


def step_sentences(steps: Sequence[Step], *, static: bool = False) -> list[str]:
    """What the last step of the way did; none where there was no step.

    Parameters
    ----------
    steps : the way to the current version
    static : of static curves alone
    """
    if len(steps) < 2:
        return []
    before, last = steps[-2:]
    sentences = fall_sentences(before, last, static=static)
    if last.added is not None:
        sentences += distrust_sentences(before, last)
        sentences += alias_sentences(effects.BY_ID[last.added])
    return sentences


@dataclass(frozen=True)
class Next:
    """What comes next, in words; the name of the button that searches, "" where that was done.

    `done` : nothing more is to be added, as far as is known.
    """

    words: str
    search: str
    done: bool


def what_next(document: Document, steps: Sequence[Step], last_round: Round | None) -> Next | None:
    """What to do after a version was fitted; None where it was not, or its errors are not known.

    Parameters
    ----------
    document : Document
    steps : the way to the current version
    last_round : what the search found from there, None where it was not asked
    """
    version = document.version
    if len(steps) < 2 or not walk.is_fitted(document, version):
        return None
    done = f"{version.title.removeprefix('+ ')} is in the model. " if version.change else ""
    if last_round is not None and not last_round.chosen:
        return Next(f"{done}The search found nothing more to add; go to Take away.", "", True)
    if walk.was_searched(document, version):
        return Next(f"{done}What else the search found stands in Which effect.", "", False)
    search = f"Search {'again ' if version.added else ''}for what {'else ' * bool(version.added)}"
    search += "is missing"
    if max(steps[-1].noise_ratio.values()) < NOISE:
        words = "What is left is about the noise: there need not be anything more to add."
        return Next(f"{done}{words}", search, True)
    ratio = noise_ratio(max(steps[-1].noise_ratio.values()))
    words = f"What is left is {ratio} times the noise: something may still be missing."
    return Next(f"{done}{words}", search, False)


def refit_words(document: Document) -> str:
    """What the button that refits is called, "" where there is nothing to refit."""
    version = document.version
    if walk.is_fitted(document, version):
        return ""
    return "Refit the parameters" if version.parent is None else "Refit to the data chosen now"
