"""A session that brings effects of its own: they are shown, and run only when the user asks."""

from collections.abc import Sequence
from typing import Any

from dash import Dash, Input, Output, State, html, no_update
from dash.development.base_component import Component

from elastic_tendon.app import own_effects
from elastic_tendon.app.document import Document
from elastic_tendon.app.workspace import Session, Workspace
from elastic_tendon.errors import ElasticTendonError

TITLE = "This session brings effects of its own"
WARNING = (
    "They are Python and may do on this machine all that you may. Read them, and run them only if "
    "you wrote them or trust who did. Nothing of them has run yet, and until then the session "
    "stays closed. Whoever does not want that closes this page."
)


def layout() -> Component:
    """Where they are shown; while it is not hidden, the steps are."""
    return html.Div(
        [
            html.H2(TITLE),
            html.P(WARNING),
            html.Div(id="gate-effects"),
            html.P(id="gate-sentence", className="sentence", role="alert"),
            html.Button("Run them and open the session", id="gate-run"),
        ],
        id="gate",
        hidden=True,
    )


def shown(document: Document) -> Sequence[Component]:
    """The texts that were not run yet."""
    return [
        html.Details(
            [html.Summary(own.file_name), html.Pre(own.text, tabIndex="0")],
            open=True,
        )
        for own in own_effects.waiting(document)
    ]


def register(app: Dash, workspace: Workspace) -> None:
    """Open the session that a browser kept, or the app's; where it brings effects, when told."""

    def opened(session: Session, step: str | None) -> tuple[Any, Any]:
        return session.stored(), step or session.opened or no_update

    @app.callback(
        Output("session", "data"),
        Output("open", "data"),
        Output("gate", "hidden"),
        Output("gate-effects", "children"),
        Input("remembered", "data"),
    )
    def begin(remembered: dict[str, Any] | None) -> tuple[Any, ...]:
        if remembered is None:  # the browser has not looked yet
            return (no_update,) * 4
        session = workspace.open(remembered.get("session"))
        if own_effects.waiting(session.document):
            return no_update, no_update, False, shown(session.document)
        return *opened(session, remembered.get("open")), True, []

    @app.callback(
        Output("session", "data", allow_duplicate=True),
        Output("open", "data", allow_duplicate=True),
        Output("gate", "hidden", allow_duplicate=True),
        Output("gate-sentence", "children"),
        Input("gate-run", "n_clicks"),
        State("remembered", "data"),
        prevent_initial_call=True,
    )
    def run(clicks: int | None, remembered: Any) -> tuple[Any, ...]:
        if not clicks:
            return (no_update,) * 4
        session = workspace.open(remembered.get("session"))
        try:
            own_effects.run_all(session.document, shared=workspace.shared)
        except ElasticTendonError as error:
            return no_update, no_update, no_update, f"{error}."
        return *opened(session, remembered.get("open")), True, ""
