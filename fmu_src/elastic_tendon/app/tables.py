"""Tables of the page, as readers of the screen know them too."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from dash import html

from elastic_tendon.app.step import aria


@dataclass(frozen=True)
class Exact:
    """What a cell shows, and what is copied in its place: a number with all its digits."""

    shown: str
    copied: float | str

    @property
    def text(self) -> str:
        """What is copied."""
        return self.copied if isinstance(self.copied, str) else repr(float(self.copied))


def table(heads: Sequence[str], rows: Iterable[Sequence[Any]], caption: str = "") -> html.Div:
    """A table whose first column says what each row is; the others hold figures.

    Parameters
    ----------
    heads : of the columns
    rows : cells, text or components
    caption : above the table; "" for none
    """
    first, *others = heads
    head = [html.Th(first, scope="col"), *map(figure_head, others)]
    body = [
        html.Tr([html.Th(name, scope="row"), *map(figure_cell, cells)]) for name, *cells in rows
    ]
    above = [html.Caption(caption)] if caption else []
    return scrolling(html.Table([*above, html.Thead(html.Tr(head)), html.Tbody(body)]))


def figure_head(title: str | Exact) -> html.Th:
    """The head of a column of figures."""
    if not isinstance(title, Exact):
        return html.Th(title, scope="col", className="figure")
    return html.Th(title.shown, scope="col", className="figure", **_copied(title))


def figure_cell(content: Any) -> html.Td:
    """A cell of figures: text, a component, or what is copied with all digits."""
    if not isinstance(content, Exact):
        return html.Td(content, className="figure")
    return html.Td(content.shown, className="figure", title=content.text, **_copied(content))


def _copied(cell: Exact) -> dict[str, Any]:
    """The attribute from which assets/copy.js copies, as a keyword of a component."""
    return {"data-copied": cell.text}


def copied_unless_edited(field: Exact) -> dict[str, Any]:
    """Attributes of a cell with a field: all digits are copied while it shows what it showed."""
    return _copied(field) | {"data-shown": field.shown}


def scrolling(wide: html.Table, looks: str = "") -> html.Div:
    """A table in a frame that scrolls, also by the keyboard, with a button that copies it.

    Parameters
    ----------
    wide : the table
    looks : further class of CSS
    """
    named = aria(label="Table")
    copy = html.Button("Copy this table", className="copy")  # see assets/copy.js
    frame = f"table {looks}".strip()
    return html.Div([wide, copy], className=frame, tabIndex="0", role="group", **named)
