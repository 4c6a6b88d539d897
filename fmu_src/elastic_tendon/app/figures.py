"""Figures of the page, with buttons that save them as a picture or as numbers."""

from typing import Any

from dash import dcc, html

from elastic_tendon.app.step import aria
from elastic_tendon.reports.interactive.theme import CONFIG

GESTURES: Any = CONFIG | {"scrollZoom": False}  # the wheel scrolls the page
FORMATS = ("PNG", "SVG", "CSV")


def saveable(file_name: str, config: Any = GESTURES, **properties: Any) -> html.Div:
    """A figure and what saves it, see assets/save.js.

    Parameters
    ----------
    file_name : of what is saved, without its end
    config : buttons and gestures of plotly
    properties : of the dcc.Graph
    """
    buttons = [
        html.Button(
            name, value=file_name, className="save", **aria(label=f"Save this figure as {name}")
        )
        for name in FORMATS
    ]
    saving = html.P(["Save as ", *buttons], className="quiet saving")
    return html.Div([dcc.Graph(config=config, **properties), saving], className="saveable")
