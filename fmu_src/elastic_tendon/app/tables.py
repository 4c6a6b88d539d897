"""Tables of the page, as readers of the screen know them too."""

from collections.abc import Iterable, Sequence
from typing import Any

from dash import html

from elastic_tendon.app.step import aria


def table(heads: Sequence[str], rows: Iterable[Sequence[Any]], caption: str = "") -> html.Div:
    """A table whose first column says what each row is; the others hold figures.

    Parameters
    ----------
    heads : of the columns
    rows : cells, text or components
    caption : above the table; "" for none
    """
    first, *others = heads
    head = [html.Th(first, scope="col")]
    head += [html.Th(title, scope="col", className="figure") for title in others]
    body = [
        html.Tr(
            [html.Th(name, scope="row"), *(html.Td(cell, className="figure") for cell in cells)]
        )
        for name, *cells in rows
    ]
    above = [html.Caption(caption)] if caption else []
    return scrolling(html.Table([*above, html.Thead(html.Tr(head)), html.Tbody(body)]))


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
