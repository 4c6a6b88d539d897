"""Add an effect and refit: the tree of versions, the ladder of errors, the estimates."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from dash import ALL, Dash, Input, Output, State, ctx, dcc, html, no_update
from dash.development.base_component import Component

from elastic_tendon import effects
from elastic_tendon.actuator.quantity import unit_text
from elastic_tendon.app import busy, ranking, results, versions, walk
from elastic_tendon.app.choice import choice
from elastic_tendon.app.document import Document
from elastic_tendon.app.figures import saveable
from elastic_tendon.app.results import Compared, Files
from elastic_tendon.app.step import PageStep, while_open
from elastic_tendon.app.tables import Exact, figure_cell, figure_head, scrolling, table
from elastic_tendon.app.view import SIGNAL, compared_now
from elastic_tendon.app.workspace import Failure, Result, Session, Workspace
from elastic_tendon.diagnosis.answer import Answer
from elastic_tendon.estimation.determinability import Estimate, Findings
from elastic_tendon.estimation.ladder import Step
from elastic_tendon.reports.interactive.ladder import ladder
from elastic_tendon.reports.interactive.theme import THEMES, Theme
from elastic_tendon.reports.tables import estimate_cells, open_note, with_interval
from elastic_tendon.reports.units import Shown, shown

LONGEST = 80  # letters of a title
INDENT = 1.4  # rem
HEAD = 40  # above figures, which have headings of the page, pixels


# ---- layout --------------------------------------------------------------------------------


def _layout() -> Sequence[Component]:
    return [
        busy.store("add"),
        dcc.Store(id="add-deleting"),  # the version whose deletion was asked for once
        _controls(),
        html.P(id="add-sentence", className="sentence", role="alert"),
        html.P(id="add-waits", className="quiet"),
        html.Div(id="add-done", role="status"),
        _next(),
        html.H3("Versions"),
        html.Div(id="add-versions"),
        html.Div([html.Div(id="add-ladder"), html.Div(id="add-numbers")], id="add-columns"),
    ]


def _controls() -> Component:
    return html.Div(
        [
            choice(
                "add-choice",
                "Effect",
                clearable=False,
                placeholder="choose one",
                className="chooser",
            ),
            html.Button("Add", id="add-add"),
            html.Button(id="add-refit", className="plain"),
            html.Button("Undo", id="add-undo", className="plain"),
        ],
        className="row",
    )


def _next() -> Component:
    """What comes after a step that was made."""
    return html.Div(
        [
            html.P(id="add-next-words"),
            html.Button("Go to Take away", id="add-next-take", className="plain"),
            html.Button(id="add-next-search", className="plain"),
        ],
        id="add-next",
        className="row",
        hidden=True,
    )


def _tree(rows: Sequence[versions.Row], quantity: Shown, deleting: str | None) -> Component:
    unit = quantity.small_unit
    heads = [f"{quantity.words}: RMS error ({unit})", f"held out ({unit})", "times noise"]
    head = [
        html.Th("Version", scope="col"),
        *map(figure_head, heads),
        html.Th("", scope="col"),
    ]
    body = [_row(row, deleting) for row in rows]
    return scrolling(html.Table([html.Thead(html.Tr(head)), html.Tbody(body)]))


def _row(row: versions.Row, deleting: str | None) -> Component:
    name = row.version.id
    title = html.Label(
        [
            html.Span("Title", className="unseen"),
            dcc.Input(
                value=row.version.title,
                id={"add-title": name},
                debounce=True,
                maxLength=LONGEST,
            ),
        ],
        style={"marginLeft": f"{INDENT * row.depth}rem"},
    )
    model = [html.Span(row.model, className="quiet")] if row.model else []
    figures = (row.fitted, row.heldout, row.ratio)
    return html.Tr(
        [
            html.Th([title, *model], scope="row"),
            *map(figure_cell, figures),
            html.Td(_buttons(row, sure=deleting == name), className="buttons"),
        ],
        className="chosen" if row.current else "",
    )


def _buttons(row: versions.Row, *, sure: bool) -> list[Component]:
    below = f" and {row.below} below" if row.below else ""
    return [
        html.Button(
            "Looked at" if row.current else "Look at it",
            id={"add-look": row.version.id},
            className="plain",
            disabled=row.current,
        ),
        html.Button(
            f"Really delete it{below}" if sure else "Delete",
            id={"add-delete": row.version.id},
            className="plain sure" if sure else "plain",
            disabled=not row.deletable,
        ),
    ]


def _ladders(steps: Sequence[Step], static: bool, theme: Theme) -> list[Component]:
    heading = html.H3("Error after each step")
    figures = {
        signal: ladder(steps, signal, static=static, theme=theme).update_layout(
            title=None, margin={"t": HEAD}
        )
        for signal in steps[0].rmse
    }
    return [
        heading,
        *(saveable(f"ladder_{name}", figure=figure) for name, figure in figures.items()),
    ]


def _numbers(findings: Findings) -> list[Component]:
    heads = ("Parameter", "given", "fitted, 95 % interval", "unit")
    parts: list[Component] = [
        html.H3("Estimated parameters"),
        table(heads, map(_estimate, findings.every)),
    ]
    if note := open_note(findings):
        parts.append(html.P(note, className="quiet"))
    if findings.ratios:
        rows = [
            (
                ratio.name.removeprefix("transmission."),
                Exact(
                    with_interval(ratio.value, ratio.interval),
                    _all_digits(ratio.value, ratio.interval),
                ),
                unit_text(ratio.unit),
            )
            for ratio in findings.ratios
        ]
        words = "Determined as ratios only; J is the link's inertia"
        parts.append(table(("Ratio", "fitted, 95 % interval", "unit"), rows, words))
    return [*parts, *(html.P(sentence) for sentence in findings.sentences)]


def _estimate(estimate: Estimate) -> list[str | Exact]:
    name, given, fitted, unit = estimate_cells(estimate)
    all_digits = f"{estimate.fitted} (open)"
    if estimate.determined:
        all_digits = _all_digits(estimate.fitted, estimate.interval)
    return [name, Exact(given, estimate.given), Exact(fitted, all_digits), unit]


def _all_digits(value: float, interval: tuple[float, float]) -> str:
    low, high = interval
    return f"{value} ({low} to {high})"


# ---- what is in the cache ------------------------------------------------------------------


def _needs(document: Document, files: Files) -> Sequence[Result[Any]]:
    version = document.version
    needed: list[Result[Any]] = [
        results.compared(document, version, files),
        results.climbed(document, files),
    ]
    if walk.is_fitted(document, version):
        needed.append(walk.answer(document, version, files))
    return needed


def _rows(session: Session, signal: str) -> list[versions.Row]:
    document = session.document
    rows = []
    for row in versions.tree(document):
        # another model as given may believe the data less, but they are the same
        result = results.compared(document.at(row.version.id), row.version, session.files)
        answer = session.cache.find(result)
        if isinstance(answer, Compared):
            fitted, heldout, ratio = versions.errors_of(answer, signal)
            row = replace(row, fitted=fitted, heldout=heldout, ratio=ratio)
        rows.append(row)
    return rows


def _steps(session: Session) -> tuple[Step, ...]:
    ladder = session.cache.find(results.climbed(session.document, session.files))
    return () if ladder is None or isinstance(ladder, Failure) else ladder


# ---- callbacks -----------------------------------------------------------------------------


def _register(app: Dash, workspace: Workspace) -> None:
    busy.register(app, "add")
    _register_controls(app, workspace)
    _register_waiting(app)
    _register_versions(app, workspace)
    _register_next(app, workspace)
    _register_results(app, workspace)
    _register_work(app, workspace)
    _register_changes(app, workspace)


def _register_controls(app: Dash, workspace: Workspace) -> None:
    @app.callback(
        Output("add-choice", "options"),
        Output("add-choice", "value"),
        Output("add-refit", "children"),
        Output("add-refit", "hidden"),
        Output("add-undo", "disabled"),
        *while_open("add"),
        State("add-choice", "value"),
    )
    def show(stored: Any, opened: str, chosen: str | None) -> tuple[Any, ...]:
        if not stored or opened != "add":
            return (no_update,) * 5
        session = workspace.open(stored)
        document = session.document
        options = ranking.choices(document, document.version.loaded())
        values = [option["value"] for option in options]
        last_round = walk.round_of(session)
        words = versions.refit_words(document)
        return (
            options,
            chosen if chosen in values else ranking.first_choice(last_round),
            words,
            not words,
            document.version.parent is None,
        )


def _register_waiting(app: Dash) -> None:
    @app.callback(
        Output("add-add", "disabled"),
        Output("add-refit", "disabled"),
        Output("add-next-search", "disabled"),
        Output("add-waits", "children"),
        Input("add-busy", "data"),
        Input("add-choice", "value"),
    )
    def wait(waits: bool, chosen: str | None) -> tuple[bool, bool, bool, str]:
        return waits or not chosen, waits, waits, busy.WORDS if waits else ""


def _register_next(app: Dash, workspace: Workspace) -> None:
    @app.callback(
        Output("add-next", "hidden"),
        Output("add-next-words", "children"),
        Output("add-next-search", "children"),
        Output("add-next-search", "hidden"),
        Output("add-next-search", "className"),
        Output("add-next-take", "className"),
        *while_open("add"),
    )
    def show(stored: Any, opened: str) -> tuple[Any, ...]:
        if not stored or opened != "add":
            return (no_update,) * 6
        session = workspace.open(stored)
        advice = versions.what_next(session.document, _steps(session), walk.round_of(session))
        if advice is None:
            return True, "", "", True, "plain", "plain"
        classes = ("plain", "") if advice.done else ("", "plain")
        return False, advice.words, advice.search, not advice.search, *classes

    @app.callback(
        Output("open", "data", allow_duplicate=True),
        Output("pulse", "data", allow_duplicate=True),
        Output("add-sentence", "children", allow_duplicate=True),
        Input("add-next-take", "n_clicks"),
        Input("add-next-search", "n_clicks"),
        State("session", "data"),
        prevent_initial_call=True,
    )
    def go(takes: int | None, searches: int | None, stored: Any) -> tuple[Any, Any, str]:
        if not stored or not ctx.triggered[0]["value"]:
            return no_update, no_update, ""
        if ctx.triggered_id == "add-next-take":
            return "take_away", no_update, ""
        if not walk.begin(workspace.open(stored), "search"):
            return no_update, no_update, busy.WORDS
        return "effect", ["next", takes, searches], ""


def _register_versions(app: Dash, workspace: Workspace) -> None:
    @app.callback(
        Output("add-versions", "children"),
        *while_open("add"),
        Input("add-deleting", "data"),
    )
    def show(stored: Any, opened: str, deleting: str | None) -> Any:
        if not stored or opened != "add":
            return no_update
        session = workspace.open(stored)
        now = compared_now(session)
        signal = SIGNAL if now is None else versions.shown_signal(now)
        static = now is not None and versions.is_static(now)
        return _tree(_rows(session, signal), shown(signal, static=static), deleting)


def _register_results(app: Dash, workspace: Workspace) -> None:
    @app.callback(
        Output("add-done", "children"),
        Output("add-ladder", "children"),
        Output("add-numbers", "children"),
        *while_open("add"),
        Input("theme", "data"),
    )
    def show(stored: Any, opened: str, theme: str) -> tuple[Any, ...]:
        if not stored or opened != "add":
            return (no_update,) * 3
        session = workspace.open(stored)
        document = session.document
        steps = _steps(session)
        answer = None
        if walk.is_fitted(document, document.version):
            answer = session.cache.find(walk.answer(document, document.version, session.files))
        now = compared_now(session)
        static = now is not None and versions.is_static(now)
        figures = _ladders(steps, static, THEMES[theme]) if len(steps) > 1 else []
        numbers = _numbers(answer.result.findings) if isinstance(answer, Answer) else []
        done = [html.P(text) for text in versions.step_sentences(steps, static=static)]
        return done, figures, numbers


def _register_work(app: Dash, workspace: Workspace) -> None:
    @app.callback(
        Output("pulse", "data", allow_duplicate=True),
        Output("add-sentence", "children", allow_duplicate=True),
        Input("add-add", "n_clicks"),
        Input("add-refit", "n_clicks"),
        State("add-choice", "value"),
        State("session", "data"),
        prevent_initial_call=True,
    )
    def begin(adds: int | None, refits: int | None, chosen: str | None, stored: Any) -> Any:
        if not stored or not ctx.triggered[0]["value"]:
            return no_update, ""
        session = workspace.open(stored)
        if ctx.triggered_id == "add-refit":
            started = walk.begin(session, "refit")
        elif chosen is not None and chosen in effects.BY_ID:
            started = walk.begin(session, "add", chosen)
        else:
            return no_update, "Choose an effect to add."
        return ["add", adds, refits], "" if started else busy.WORDS


def _register_changes(app: Dash, workspace: Workspace) -> None:
    @app.callback(
        Output("session", "data", allow_duplicate=True),
        Output("add-deleting", "data"),
        Output("add-sentence", "children", allow_duplicate=True),
        Input("add-undo", "n_clicks"),
        Input({"add-look": ALL}, "n_clicks"),
        Input({"add-delete": ALL}, "n_clicks"),
        Input({"add-title": ALL}, "value"),
        State("add-deleting", "data"),
        State("session", "data"),
        prevent_initial_call=True,
    )
    def change(*given: Any) -> tuple[Any, Any, str]:
        deleting, stored = given[-2:]
        value = ctx.triggered[0]["value"]
        if not stored or not value:
            return no_update, no_update, ""
        session = workspace.open(stored)
        before = session.document
        what, name = _asked(ctx.triggered_id)
        if what == "add-delete" and deleting != name:
            return no_update, name, ""
        after = _changed(before, what, name, str(value))
        if after == before:  # a new row says its title, too
            return no_update, no_update, ""
        session.change(lambda latest: _changed(latest, what, name, str(value)))
        return session.stored(), None, ""


def _asked(triggered: Any) -> tuple[str, str]:
    """What was done on the page, and to which version; "" where it is the current one."""
    if isinstance(triggered, str):
        return triggered, ""
    ((what, name),) = triggered.items()
    return str(what), str(name)


def _changed(document: Document, what: str, name: str, value: str) -> Document:
    """The document after what was done to a version; unchanged where that is gone."""
    if what == "add-undo":
        return document.at(document.version.parent or document.current)
    if all(version.id != name for version in document.versions):
        return document
    if what == "add-look":
        return document.at(name)
    if what == "add-delete":
        return document.without(name)
    title = " ".join(value.split())[:LONGEST]
    return document.renamed(name, title) if title else document


STEP = PageStep(id="add", title="Add", layout=_layout, register=_register, needs=_needs)
