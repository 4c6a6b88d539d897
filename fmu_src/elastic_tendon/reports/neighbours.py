"""How sure an answer is: what comes nearest to it, and what would have shown had it been there."""

from collections.abc import Mapping, Sequence

from rich.box import SIMPLE_HEAD
from rich.markup import escape
from rich.table import Table

from elastic_tendon.actuator.quantity import unit_suffix
from elastic_tendon.diagnosis.evidence import DECISIVE
from elastic_tendon.diagnosis.result import Diagnosis, Neighbour, WouldShow
from elastic_tendon.reports.diagnosis_tables import called
from elastic_tendon.reports.units import evidence_text, number, shown

NEAREST = 5  # neighbours that are shown; the option --all-candidates shows all
UNDOMINATED = "Nothing in the catalogue does better; nearest:"
UNDECIDED = "Nothing in the catalogue does clearly better; nearest:"
NEAREST_ONLY = "The nearest answers; not all of those that may do better were refitted:"


def change_words(change: str) -> str:
    """A change of the answer for people.

    Parameters
    ----------
    change : "+id", "-id" or "id -> id"
    """
    gone, arrow, came = change.partition(" -> ")
    if arrow:
        return f"{called(came)} instead of {called(gone)}"
    return f"{'with' if change.startswith('+') else 'without'} {called(change[1:])}"


def neighbours_table(diagnosis: Diagnosis, *, every: bool = False) -> Table | None:
    """Sets that differ from the answer by one change, and how much worse they do.

    Parameters
    ----------
    diagnosis : Diagnosis
    every : all of them, instead of the first `NEAREST`

    Returns
    -------
    Table, or None where none was looked at
    """
    if not diagnosis.neighbours:
        return None
    table = Table(
        title=_title(diagnosis), title_justify="left", box=SIMPLE_HEAD, caption_justify="left"
    )
    table.add_column("the answer", overflow="fold", ratio=4)
    table.add_column("evidence\nworse by", justify="right", no_wrap=True)
    table.add_column("error\n(RMS)", justify="right", no_wrap=True)
    table.add_column("evidence from", overflow="fold", ratio=3)
    chosen = diagnosis.neighbours if every else diagnosis.neighbours[:NEAREST]
    for neighbour in chosen:
        table.add_row(
            escape(change_words(neighbour.change)),
            evidence_text(neighbour.evidence),
            _errors(neighbour.rmse) or "-",
            escape(_evidence_of(neighbour)),
        )
    captions = ["evidence: 10 decide"]
    if left := len(diagnosis.neighbours) - len(chosen):
        captions.append(f"{left} more, see --all-candidates")
    table.caption = "; ".join(captions)
    return table


def _title(diagnosis: Diagnosis) -> str:
    """What the table shows: no more is claimed than was looked at."""
    known = [near.evidence for near in diagnosis.neighbours if near.evidence is not None]
    least = min(known, default=0.0)
    if not diagnosis.complete or least <= -DECISIVE:
        return NEAREST_ONLY
    return UNDOMINATED if least >= 0.0 else UNDECIDED


def _errors(rmse: Mapping[str, float]) -> str:
    return "\n".join(shown(signal).error(value) for signal, value in rmse.items())


def _evidence_of(neighbour: Neighbour) -> str:
    how = "a refit" if neighbour.refitted else "the screen alone"
    if neighbour.evidence is None:
        return neighbour.reason or "nothing: the screen cannot say"
    return f"{how}; {neighbour.reason}" if neighbour.reason else how


def would_show_table(limits: Sequence[WouldShow]) -> Table | None:
    """From which size on effects that were not found would have shown.

    Parameters
    ----------
    limits : WouldShow of each

    Returns
    -------
    Table, or None where that was not judged
    """
    if not limits:
        return None
    title = "What would have shown, had it been there (95 %)"
    table = Table(title=title, title_justify="left", box=SIMPLE_HEAD, caption_justify="left")
    table.add_column("effect", overflow="fold")
    table.add_column("would have shown", overflow="fold")
    for limit in limits:
        if limit.smallest is not None:
            table.add_row(escape(called(limit.id)), escape(_above(limit, limit.smallest)))
    if hidden := [called(limit.id) for limit in limits if limit.smallest is None]:
        table.add_row(escape(", ".join(hidden)), "at no plausible size")
    return table


def _above(limit: WouldShow, smallest: float) -> str:
    name = limit.path.rpartition(".")[2].replace("_", " ")
    return f"{name} above {number(smallest)}{unit_suffix(limit.unit)}"
