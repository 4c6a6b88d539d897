"""What the step Add says: the tree of versions, and how each compares."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from elastic_tendon import effects
from elastic_tendon.app import walk
from elastic_tendon.app.document import Document, Version
from elastic_tendon.app.results import Compared
from elastic_tendon.app.view import SIGNAL
from elastic_tendon.identify.ladder import Rung
from elastic_tendon.report.tables import alias_sentences, distrust_sentences, fall_sentences
from elastic_tendon.report.units import noise_ratio, shown

UNKNOWN = "-"  # where a version was not compared with these data yet


@dataclass(frozen=True)
class Row:
    """A version in the tree: `depth` below its root, whether it is the `current` one.

    `fitted`, `heldout` : error with its unit, and `ratio` times the noise; `below` : how many
    versions were made from it. `deletable` : it is not the only root.
    """

    version: Version
    depth: int
    current: bool
    below: int
    deletable: bool
    fitted: str = UNKNOWN
    heldout: str = UNKNOWN
    ratio: str = UNKNOWN


def tree(document: Document) -> list[Row]:
    """All versions, each followed by those made from it; not compared with anything."""
    roots = [one for one in document.versions if one.parent is None]
    return [row for root in roots for row in _branch(document, root, 0, len(roots))]


def _branch(document: Document, version: Version, depth: int, roots: int) -> Iterator[Row]:
    rows = [
        row
        for child in document.children(version.id)
        for row in _branch(document, child, depth + 1, roots)
    ]
    deletable = version.parent is not None or roots > 1
    yield Row(version, depth, version.id == document.current, len(rows), deletable)
    yield from rows


def errors_of(found: Compared, signal: str) -> tuple[str, str, str]:
    """Error on fitted and on held-out data with unit, and the former over the noise."""
    quantity = shown(signal)
    heldout = found.heldout.rmse() if found.heldout is not None else {}
    return (
        quantity.error(found.fitted.rmse()[signal]),
        quantity.error(heldout[signal]) if signal in heldout else UNKNOWN,
        noise_ratio(found.fitted.noise_ratio()[signal]),
    )


def told_signal(found: Compared) -> str:
    """The signal whose error stands in the tree."""
    signals = list(found.fitted.rmse())
    return SIGNAL if SIGNAL in signals else signals[0]


def step_sentences(rungs: Sequence[Rung]) -> list[str]:
    """What the last step of the way did; none where there was no step."""
    if len(rungs) < 2:
        return []
    before, last = rungs[-2:]
    sentences = fall_sentences(before, last)
    if last.added is not None:
        sentences += distrust_sentences(before, last)
        sentences += alias_sentences(effects.BY_ID[last.added])
    return sentences


def refit_words(document: Document) -> str:
    """What the button that refits is called, "" where there is nothing to refit."""
    version = document.version
    if walk.is_fitted(document, version):
        return ""
    return "Refit the parameters" if version.parent is None else "Refit to the data chosen now"
