"""Of what a report is made: paragraphs, tables, figures; text stays text until the page is made."""

import json
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

import plotly.graph_objects as go
from rich.table import Table as TerminalTable
from rich.text import Text

from elastic_tendon.reports.interactive.theme import DARK, LIGHT, Theme

Draw = Callable[[Theme], go.Figure]
HEAD = 64  # pixels, above a figure; a legend of two rows has room in it


@dataclass(frozen=True)
class Heading:
    """Within a section."""

    kind: ClassVar[str] = "heading"
    text: str


@dataclass(frozen=True)
class Paragraphs:
    """Sentences, each a paragraph of its own; a sentence that begins with two blanks is a command.

    `standing` is "plain", "verdict" or "faint".
    """

    kind: ClassVar[str] = "paragraphs"
    sentences: tuple[str, ...]
    standing: str = "plain"


@dataclass(frozen=True)
class Listing:
    """Items of a list; each may begin with a `term`, else that is ""."""

    kind: ClassVar[str] = "listing"
    items: tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class Code:
    """Text to copy; `label` says what it is."""

    kind: ClassVar[str] = "code"
    label: str
    text: str


@dataclass(frozen=True)
class Table:
    """Rows of cells, the first of each names its row; `numeric` says which columns hold numbers."""

    kind: ClassVar[str] = "table"
    title: str
    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    numeric: tuple[bool, ...]
    note: str = ""


@dataclass(frozen=True)
class Plot:
    """A figure as JSON, and what the dark theme changes of it; `words` say what it shows."""

    kind: ClassVar[str] = "plot"
    words: str
    height: int
    light: str
    dark: str


@dataclass(frozen=True)
class Beside:
    """Sentences with a figure to their right, or below them where there is no room."""

    kind: ClassVar[str] = "beside"
    sentences: Paragraphs
    figure: Plot


Block = Heading | Paragraphs | Listing | Code | Table | Plot | Beside


@dataclass(frozen=True)
class Section:
    """A part of the report; `anchor` is its id in the page."""

    anchor: str
    title: str
    blocks: tuple[Block, ...]


def plot(draw: Draw, words: str, head: int = HEAD) -> Plot:
    """A figure in both themes.

    Parameters
    ----------
    draw : makes the figure in a theme
    words : what it shows, with its main number, for whom does not see it
    head : pixels above its axes, for a legend
    """
    figure = draw(LIGHT)
    light, dark = (_tree(themed, head) for themed in (figure, draw(DARK)))
    changed = _changes(light, dark)
    return Plot(words, int(figure.layout.height or 450), *map(script_safe, (light, changed)))


def _tree(figure: go.Figure, head: int) -> Any:
    # headings and words tell what it is
    return json.loads(figure.update_layout(title=None, margin={"t": head}).to_json())


def _changes(before: Any, after: Any) -> Any:
    """What of a tree is to be replaced to get another; items of a list go by their number."""
    if isinstance(before, dict) and isinstance(after, dict):
        pairs = {key: (before.get(key), value) for key, value in after.items()}
    elif isinstance(before, list) and isinstance(after, list) and len(before) == len(after):
        pairs = {str(key): pair for key, pair in enumerate(zip(before, after, strict=True))}
    else:
        return after
    return {key: _changes(*pair) for key, pair in pairs.items() if pair[0] != pair[1]}


def script_safe(tree: Any) -> str:
    """JSON that cannot end the script element it stands in, nor begin a comment there."""
    text = json.dumps(tree, separators=(",", ":"), ensure_ascii=False, allow_nan=False)
    for letter in "<>&":  # they occur in strings only
        text = text.replace(letter, f"\\u{ord(letter):04x}")
    return text


def as_table(table: TerminalTable, title: str | None = None) -> Table:
    """What the terminal shows, so that both say the same.

    Parameters
    ----------
    table : rich.table.Table
    title : another one
    """
    columns = [[_words(cell) for cell in column.cells] for column in table.columns]
    head = (_words(column.header) for column in table.columns)
    return Table(
        title=_words(table.title or "") if title is None else title,
        head=tuple(head),
        rows=tuple(zip(*columns, strict=True)),
        numeric=tuple(column.justify == "right" for column in table.columns),
        note=_words(table.caption or ""),
    )


def _words(cell: Any) -> str:
    return cell.plain if isinstance(cell, Text) else Text.from_markup(str(cell)).plain
