"""Compare."""

from collections.abc import Sequence
from typing import Any

from dash import Dash, Input, Output, html
from dash.development.base_component import Component

from elastic_tendon.app import results
from elastic_tendon.app.document import Document
from elastic_tendon.app.results import Files
from elastic_tendon.app.step import Step
from elastic_tendon.app.workspace import Result, Workspace


def _layout() -> Sequence[Component]:
    return [html.Div(id="compare-body")]


def _needs(document: Document, files: Files) -> Sequence[Result[Any]]:
    return [results.compared(document, document.version, files)]


def _register(app: Dash, workspace: Workspace) -> None:
    @app.callback(
        Output("compare-body", "children"), Input("session", "data"), Input("open", "data")
    )
    def show(stored: Any, opened: str) -> Any:
        if not stored or opened != "compare":
            return ""
        session = workspace.open(stored)
        found = session.shelf.find(_needs(session.document, session.files)[0])
        return str(found)[:200]


STEP = Step(id="compare", title="Compare", layout=_layout, register=_register, needs=_needs)
