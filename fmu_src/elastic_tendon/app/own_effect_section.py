"""An effect of the user's own, written in the step Which effect: tried, kept, handed out."""

from collections.abc import Sequence
from functools import partial
from typing import Any

from dash import ALL, Dash, Input, Output, State, ctx, dcc, html, no_update
from dash.development.base_component import Component

from elastic_tendon.app import own_effects
from elastic_tendon.app.document import Document, OwnEffect
from elastic_tendon.app.step import aria, while_open
from elastic_tendon.app.workspace import Workspace
from elastic_tendon.errors import EffectError

ROWS = 24  # of the editor
WARNING = (
    "An effect is a Python file: what it is, its parameters, its equations. It runs on this "
    "machine and may do all that you may: try what you wrote or trust."
)
UNKNOWN = (
    "The editor holds a text that this session does not have; try it, or empty the editor first."
)
REMOVED = "{} is no longer known to this session; its text stays in the editor."


def section() -> Component:
    """The editor, which is folded, and below it the effects that the session has."""
    return html.Details(
        [
            html.Summary("Write an effect of your own"),
            html.P(WARNING),
            html.Label("The effect, in Python", htmlFor="own-effect-text"),
            dcc.Textarea(
                id="own-effect-text",
                value=own_effects.template(),
                rows=ROWS,
                spellCheck=False,
                persistence=True,
                persistence_type="session",
            ),
            html.Div(
                [
                    html.Button("Try it", id="own-effect-try"),
                    html.Button("Begin with the template", id="own-effect-new", className="plain"),
                ],
                className="row",
            ),
            html.P(id="own-effect-refusal", className="sentence", role="alert"),
            html.Pre(id="own-effect-line", **aria(label="The line at fault")),
            html.P(id="own-effect-told", role="status"),
            html.Div(id="own-effect-list"),
            dcc.Download(id="own-effect-file"),
            dcc.Store(id="own-effect-chosen"),  # the one that is to be looked at, and which try
        ],
        id="own-effect",
    )


def _list(document: Document) -> Sequence[Component]:
    if not document.own_effects:
        return []
    return [
        html.H3("Effects of this session"),
        *(
            html.Div(
                [
                    html.Span(own.id),
                    html.Button(
                        f"Download {own.file_name}",
                        id={"own-effect-download": own.id},
                        className="plain",
                    ),
                    *(
                        html.Button(
                            words,
                            id={f"own-effect-{words.lower()}": own.id},
                            className="plain",
                            **aria(label=f"{words} {own.id}"),
                        )
                        for words in ("Edit", "Remove")
                    ),
                ],
                className="row",
            )
            for own in document.own_effects
        ),
    ]


# ---- callbacks -----------------------------------------------------------------------------


def register(app: Dash, workspace: Workspace) -> None:
    """Connect its callbacks."""
    _register_try(app, workspace)
    _register_list(app, workspace)
    _register_text(app, workspace)


def _register_try(app: Dash, workspace: Workspace) -> None:
    @app.callback(
        Output("session", "data", allow_duplicate=True),
        Output("own-effect-refusal", "children"),
        Output("own-effect-line", "children"),
        Output("own-effect-told", "children"),
        Output("own-effect-chosen", "data"),
        Input("own-effect-try", "n_clicks"),
        State("own-effect-text", "value"),
        State("session", "data"),
        running=[(Output("own-effect-try", "disabled"), True, False)],
        prevent_initial_call=True,
    )
    def try_it(clicks: int | None, text: str | None, stored: Any) -> tuple[Any, ...]:
        if not clicks or not stored:
            return (no_update,) * 5
        session, written = workspace.open(stored), text or ""
        try:
            effect = own_effects.typed(written, shared=workspace.shared)
        except EffectError as error:
            return no_update, *own_effects.fault(error, written), "", no_update
        own = OwnEffect(id=effect.id, text=written)
        session.change(partial(Document.with_own_effect, own=own))
        return session.stored(), "", "", own_effects.welcome(effect), [effect.id, clicks]


def _register_list(app: Dash, workspace: Workspace) -> None:
    @app.callback(
        Output("own-effect-list", "children"),
        *while_open("effect"),
    )
    def show(stored: Any, opened: str) -> Any:
        if not stored or opened != "effect":
            return no_update
        return _list(workspace.open(stored).document)

    @app.callback(
        Output("own-effect-file", "data"),
        Input({"own-effect-download": ALL}, "n_clicks"),
        State("session", "data"),
        prevent_initial_call=True,
    )
    def download(clicks: list[int | None], stored: Any) -> Any:
        if not stored or not any(clicks) or not ctx.triggered[0]["value"]:
            return no_update
        own = _found(workspace.open(stored).document, ctx.triggered_id["own-effect-download"])
        return {"content": own.text, "filename": own.file_name, "type": "text/x-python"}


def _register_text(app: Dash, workspace: Workspace) -> None:
    @app.callback(
        Output("own-effect-text", "value"),
        Output("own-effect-refusal", "children", allow_duplicate=True),
        Output("own-effect-line", "children", allow_duplicate=True),
        Output("own-effect-told", "children", allow_duplicate=True),
        Output("session", "data", allow_duplicate=True),
        Input("own-effect-new", "n_clicks"),
        Input({"own-effect-edit": ALL}, "n_clicks"),
        Input({"own-effect-remove": ALL}, "n_clicks"),
        State("own-effect-text", "value"),
        State("session", "data"),
        prevent_initial_call=True,
    )
    def write(
        _new: int | None, _edits: Any, _removals: Any, written: str | None, stored: Any
    ) -> tuple[Any, ...]:
        if not stored or not ctx.triggered[0]["value"]:
            return (no_update,) * 5
        session = workspace.open(stored)
        if own_effects.would_be_lost(written or "", session.document):
            return no_update, UNKNOWN, "", "", no_update
        if ctx.triggered_id == "own-effect-new":
            return own_effects.template(), "", "", "", no_update
        ((what, effect_id),) = ctx.triggered_id.items()
        text = _found(session.document, effect_id).text
        if what == "own-effect-edit":
            return text, "", "", "", no_update
        try:
            workspace.forget_effect(session, effect_id)
        except EffectError as error:
            return no_update, f"{error}.", "", "", no_update
        return text, "", "", REMOVED.format(effect_id), session.stored()


def _found(document: Document, effect_id: str) -> OwnEffect:
    return {own.id: own for own in document.own_effects}[effect_id]
