"""The experiment that decides, a part of the step Which effect: drawn, handed out, taken back."""

from functools import partial
from typing import Any

from dash import Dash, Input, Output, State, ctx, dcc, html, no_update
from dash.development.base_component import Component

from elastic_tendon.app import ranking, safety, walk
from elastic_tendon.app.figures import saveable
from elastic_tendon.app.step import while_open
from elastic_tendon.app.upload_field import upload
from elastic_tendon.app.uploads import add_recordings, size_in_words
from elastic_tendon.app.workspace import Session, Workspace
from elastic_tendon.diagnosis.experiment import experiment_csv
from elastic_tendon.diagnosis.result import Experiment
from elastic_tendon.fmu.export import model_identifier
from elastic_tendon.reports.interactive.experiment import experiment
from elastic_tendon.reports.interactive.theme import THEMES

HEAD = 48  # above the figure, which has a heading of the page, pixels
TAKE_BACK = (
    "Add the recording of this experiment: choose it, or drop it here "
    f"({size_in_words(safety.UPLOAD)} at a time)"
)


def taken() -> Component:
    """What became of a recording that was taken back, and where to go with it."""
    return html.Div(
        [
            html.P(id="effect-taken-words"),
            html.Button("Go to Compare", id="effect-taken-compare", className="plain"),
        ],
        id="effect-taken",
        className="row",
        role="status",
        hidden=True,
    )


def section() -> Component:
    """Where it is proposed, and once it is, what it is."""
    return html.Div(
        [
            html.H3("The experiment that decides"),
            html.P(id="effect-experiment-words"),
            html.Button("Propose an experiment", id="effect-propose", className="plain"),
            html.Div(id="effect-experiment-figure"),
            _files(),
        ],
        id="effect-experiment",
        hidden=True,
    )


def _files() -> Component:
    return html.Div(
        [
            html.Div(
                [
                    html.Button("Download the experiment", id="effect-experiment-download"),
                    html.Span(
                        "CSV: time and what is done, SI units, a row a sample",
                        className="quiet",
                    ),
                ],
                className="row",
            ),
            dcc.Download(id="effect-experiment-file"),
            upload("effect-recording", TAKE_BACK, safety.UPLOAD, tell="effect-recording-refusal"),
            html.P(id="effect-recording-refusal", className="sentence", role="alert"),
        ],
        id="effect-experiment-files",
        hidden=True,
    )


def file_name(session: Session) -> str:
    """What the experiment's file is called."""
    return f"{model_identifier(session.document.version.loaded().name)}_experiment.csv"


def _experiment(session: Session) -> Experiment | None:
    found = walk.proposed_of(session)
    return None if found is None else found.experiment


# ---- callbacks -----------------------------------------------------------------------------


def register(app: Dash, workspace: Workspace) -> None:
    """Connect its callbacks; the step's own begins to seek it."""
    _register_words(app, workspace)
    _register_figure(app, workspace)
    _register_download(app, workspace)
    _register_recording(app, workspace)


def _register_words(app: Dash, workspace: Workspace) -> None:
    @app.callback(
        Output("effect-experiment", "hidden"),
        Output("effect-experiment-words", "children"),
        Output("effect-propose", "hidden"),
        Output("effect-propose", "disabled"),
        Output("effect-experiment-files", "hidden"),
        *while_open("effect"),
        Input("effect-busy", "data"),
    )
    def show(stored: Any, opened: str, waits: bool) -> tuple[Any, ...]:
        if not stored or opened != "effect":
            return (no_update,) * 5
        session = workspace.open(stored)
        left_open, found = walk.left_open_of(session), walk.proposed_of(session)
        if left_open is None:
            return True, "", True, True, True
        words = ranking.experiment_words(left_open, found)
        done = found is not None or not left_open.sets
        return False, words, done, waits, _experiment(session) is None


def _register_figure(app: Dash, workspace: Workspace) -> None:
    @app.callback(
        Output("effect-experiment-figure", "children"),
        *while_open("effect"),
        Input("theme", "data"),
    )
    def draw(stored: Any, opened: str, theme: str) -> Any:
        if not stored or opened != "effect":
            return no_update
        found = _experiment(workspace.open(stored))
        if found is None:
            return []
        figure = experiment(found, theme=THEMES[theme])
        figure.update_layout(title=None, margin={"t": HEAD})
        return saveable("experiment", figure=figure)


def _register_download(app: Dash, workspace: Workspace) -> None:
    @app.callback(
        Output("effect-experiment-file", "data"),
        Input("effect-experiment-download", "n_clicks"),
        State("session", "data"),
        prevent_initial_call=True,
    )
    def download(clicks: int | None, stored: Any) -> Any:
        session = workspace.open(stored)
        found = _experiment(session)
        if not clicks or found is None:
            return no_update
        return {
            "content": experiment_csv(found, session.document.version.loaded().motion),
            "filename": file_name(session),
            "type": "text/csv",
        }


def _register_recording(app: Dash, workspace: Workspace) -> None:
    @app.callback(
        Output("session", "data", allow_duplicate=True),
        Output("effect-recording", "contents"),
        Output("effect-recording-refusal", "children"),
        Output("effect-taken", "hidden"),
        Output("effect-taken-words", "children"),
        Input("effect-recording", "contents"),
        State("effect-recording", "filename"),
        State("session", "data"),
        prevent_initial_call=True,
    )
    def take(sent: list[str] | None, names: list[str] | None, stored: Any) -> tuple[Any, ...]:
        if not sent or not names or not stored:
            return (no_update,) * 5
        session = workspace.open(stored)
        left_open = walk.left_open_of(session)
        added, refused = add_recordings(workspace, session, sent, names)
        if added and left_open is not None and left_open.sets:
            session.change(partial(walk.before_the_choice, left_open=left_open))
        # emptied, so that the same file can be chosen again
        return session.stored(), None, "; ".join(refused), not added, ranking.taken_words(added)

    @app.callback(
        Output("effect-taken", "hidden", allow_duplicate=True),
        Output("open", "data", allow_duplicate=True),
        Input("effect-taken-compare", "n_clicks"),
        Input("effect-search", "n_clicks"),
        prevent_initial_call=True,
    )
    def go_on(_compare: int | None, _search: int | None) -> tuple[Any, Any]:
        if not ctx.triggered[0]["value"]:
            return no_update, no_update
        return True, "compare" if ctx.triggered_id == "effect-taken-compare" else no_update
