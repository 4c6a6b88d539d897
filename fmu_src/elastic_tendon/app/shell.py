"""The page around the steps: which step is open, progress and cancel, the look, the session."""

import json
from collections.abc import Sequence
from typing import Any

from dash import ALL, ClientsideFunction, Dash, Input, Output, State, ctx, dcc, html, no_update
from dash.development.base_component import Component

from elastic_tendon.app import gate, results, walk
from elastic_tendon.app.mapping import in_app_words
from elastic_tendon.app.step import PageStep, aria, section
from elastic_tendon.app.workspace import Failure, Session, Workspace
from elastic_tendon.reports.interactive.theme import light_by_dark

TICK = 300  # ms between polls of the work under way


def layout(steps: Sequence[PageStep], session_name: str) -> Component:
    """The whole page; the first step is open.

    Parameters
    ----------
    steps : of the page
    session_name : of the session's file, "" where there is none
    """
    return html.Div(
        [
            # the browser's script keeps `session` and `open` in its session storage
            dcc.Store(id="remembered"),
            dcc.Store(id="session"),
            dcc.Store(id="open", data=steps[0].id),
            dcc.Store(id="theme", data="light"),
            dcc.Store(id="pulse"),  # set by who has started work
            dcc.Interval(id="tick", interval=TICK, disabled=True),
            html.A("Skip to the step", href="#steps", className="skip"),
            html.Header(
                [
                    html.H1("elastic-tendon"),
                    html.P(id="where-we-are", className="quiet"),
                    html.Button("Dark", id="switch-theme", className="plain"),
                ]
            ),
            html.Nav(_links(steps), **aria(label="Steps")),
            html.Main(
                [
                    html.P(
                        id="lost",
                        className="sentence",
                        role="alert",
                        **_words_for_script(session_name),
                    ),
                    html.P(id="unsaved", className="sentence", role="alert"),
                    html.P(id="left-out", className="sentence", role="status"),
                    gate.layout(),
                    *(
                        section(step, following, opened=step is steps[0])
                        for step, following in zip(steps, [*steps[1:], None], strict=True)
                    ),
                ],
                id="steps",
            ),
            html.Footer(
                [
                    html.Progress(id="work-share", max="1", **aria(label="Work done")),
                    html.Span(id="work-words", role="status", **aria(live="polite")),
                    html.Button("Take the best so far", id="take-best", className="plain"),
                    html.Button("Cancel", id="cancel", className="plain"),
                ],
                id="work",
                hidden=True,
            ),
        ],
        id="page",
        **_colours_for_script(),
    )


def _words_for_script(session_name: str) -> dict[str, Any]:
    """What the page says while the server does not answer, see assets/session.js."""
    words = "The server does not answer. This page goes on by itself as soon as it does. "
    if session_name:
        words += f"If it has ended, start it again with --session {session_name}."
    else:
        words += "If it has ended, what was done here is lost; --session FILE keeps it."
    return {"data-words": words}


def _colours_for_script() -> dict[str, Any]:
    """What figures take on paper in place of the dark theme's, see assets/print.js."""
    return {"data-light": json.dumps(light_by_dark())}


def _links(steps: Sequence[PageStep]) -> html.Ol:
    return html.Ol(
        [
            html.Li(
                html.Button(
                    [html.Span(str(number), className="number"), step.title],
                    id={"link": step.id},
                    className="link",
                )
            )
            for number, step in enumerate(steps, start=1)
        ]
    )


def register(app: Dash, workspace: Workspace, steps: Sequence[PageStep]) -> None:
    """Connect the callbacks of the page around the steps."""
    _register_browser(app, steps)
    _register_session(app, workspace)
    _register_steps(app, workspace)
    _register_work(app, workspace, steps)


def _register_browser(app: Dash, steps: Sequence[PageStep]) -> None:
    """What the browser does by itself, see assets/session.js."""

    def script(name: str) -> ClientsideFunction:
        return ClientsideFunction("elastic_tendon", name)

    app.clientside_callback(script("remember"), Output("remembered", "data"), Input("page", "id"))
    app.clientside_callback(
        script("keep"),
        Output("page", "data-kept"),
        Input("session", "data"),
        Input("open", "data"),
    )
    app.clientside_callback(
        script("look"),
        Output("theme", "data"),
        Output("switch-theme", "children"),
        Input("switch-theme", "n_clicks"),
    )
    app.clientside_callback(
        script("pass"),
        *(Output(f"{step.id}-session", "data") for step in steps),
        Input("session", "data"),
        Input("open", "data"),
        *(State(f"{step.id}-session", "id") for step in steps),
    )
    app.clientside_callback(
        script("show"),
        Output({"section": ALL}, "hidden"),
        Output({"link": ALL}, "aria-current"),
        Input("open", "data"),
        State({"section": ALL}, "id"),
    )


def _register_session(app: Dash, workspace: Workspace) -> None:
    gate.register(app, workspace)

    @app.callback(
        Output("where-we-are", "children"),
        Output("unsaved", "children"),
        Output("left-out", "children"),
        Input("session", "data"),
    )
    def tell(stored: Any) -> tuple[str, str, str]:
        if not stored:
            return "", "", ""
        session = workspace.open(stored)
        version = session.document.version
        parts = [session.name, f"{version.loaded().name}: {version.title}"]
        used = session.document.used
        left_out = [source.left_out for source in session.document.sources if source not in used]
        return (
            " · ".join(filter(None, parts)),
            f"{session.unsaved}." if session.unsaved else "",
            _elsewhere(" ".join(filter(None, left_out))),
        )


def _register_steps(app: Dash, workspace: Workspace) -> None:
    @app.callback(
        Output("open", "data", allow_duplicate=True),
        Input({"link": ALL}, "n_clicks"),
        Input({"next": ALL}, "n_clicks"),
        State("session", "data"),
        prevent_initial_call=True,
    )
    def choose(_links: list[int | None], _nexts: list[int | None], stored: Any) -> Any:
        if not ctx.triggered[0]["value"]:
            return no_update
        if stored:  # else the page has only just come
            workspace.open(stored).cache.forget_failures()  # whoever comes back wants another try
        (chosen,) = ctx.triggered_id.values()
        return chosen


def _register_work(app: Dash, workspace: Workspace, steps: Sequence[PageStep]) -> None:
    """What the open step needs is computed, one result after the other; words tell how far."""
    by_id = {step.id: step for step in steps}

    @app.callback(
        Output("tick", "disabled"),
        Output("session", "data", allow_duplicate=True),
        Output("work", "hidden"),
        Output("take-best", "hidden"),
        Output("work-words", "children"),
        Output("work-share", "value"),
        Output({"sentence": ALL}, "children"),
        Input("session", "data"),
        Input("open", "data"),
        Input("pulse", "data"),
        Input("tick", "n_intervals"),
        prevent_initial_call=True,
    )
    def advance(stored: Any, opened: str, _pulse: Any, _ticks: Any) -> tuple[Any, ...]:
        if not stored:
            return True, no_update, True, True, "", "0", [""] * len(steps)
        session = workspace.open(stored)
        session.look_at(opened)
        sentence = _begin_next(session, by_id[opened])
        job = session.job
        busy = job is not None and job.state == "running"
        news = session.revision != stored["revision"]
        sentences = {opened: sentence}
        if job is not None and job.state == "failed":
            tells_failures = by_id[job.step].tells_failures and job.result is not None
            sentences[job.step] = "" if tells_failures else _elsewhere(job.sentence)
        return (
            not busy and not news,
            session.stored() if news else no_update,
            not busy,
            not (job and job.may_end),
            job.words if job and busy else "",
            f"{job.share:.3f}" if job and busy else "0",
            [sentences.get(step.id, "") for step in steps],
        )

    @app.callback(
        Output("pulse", "data", allow_duplicate=True),
        Input("cancel", "n_clicks"),
        Input("take-best", "n_clicks"),
        State("session", "data"),
        prevent_initial_call=True,
    )
    def end(_cancel: int | None, _take_best: int | None, stored: Any) -> Any:
        session = workspace.open(stored)
        if ctx.triggered_id == "cancel":
            session.stop()
        else:
            session.take_best()
        return [ctx.triggered_id, ctx.triggered[0]["value"]]


def _begin_next(session: Session, step: PageStep) -> str:
    """Begin to compute what the step still needs; why the first of it has failed, "" if none."""
    walk.begin_again(session)
    results.judge_files(session)
    sentence = ""
    for result in step.needs(session.document, session.files):
        value = session.cache.find(result)
        if value is None:
            session.compute(step.id, result)
            break
        if isinstance(value, Failure):
            sentence = sentence or value.sentence
            if value.cancelled:
                break
    if step.tells_failures:
        return ""
    return _elsewhere(sentence)


def _elsewhere(sentence: str) -> str:
    """A sentence with advice for the command line, where there are no columns to choose."""
    return in_app_words(sentence).replace("column below", "column in the step Data")
