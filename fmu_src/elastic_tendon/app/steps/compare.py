"""The model beside the recordings: curves, errors, cursors, the loop of torque and deflection."""

from collections.abc import Mapping, Sequence
from typing import Any

from dash import (
    ClientsideFunction,
    Dash,
    Input,
    Output,
    Patch,
    State,
    ctx,
    dcc,
    html,
    no_update,
)
from dash.development.base_component import Component

from elastic_tendon.actuator.parameters import Model
from elastic_tendon.app import figures, results
from elastic_tendon.app.choice import choice
from elastic_tendon.app.document import Document
from elastic_tendon.app.figures import saveable
from elastic_tendon.app.filters import FIELDS, conditions, filters, ranges
from elastic_tendon.app.readings import (
    FORMULAS,
    NO_CURSORS,
    Window,
    cursor_rows,
    error_heads,
    error_rows,
    in_order,
    span,
    with_cursor,
)
from elastic_tendon.app.redrawing import BUCKETS, Seen, moved_curves, note, serve
from elastic_tendon.app.results import Files
from elastic_tendon.app.sliders import (
    LABEL,
    moved_runs,
    moved_values,
    moved_words,
    register,
    sliders,
)
from elastic_tendon.app.step import PageStep, aria, while_open
from elastic_tendon.app.tables import table
from elastic_tendon.app.view import (
    View,
    before_of,
    compared_now,
    fingerprint,
    fitted_view,
    located_heldout,
    location_of,
    recording_options,
    recordings,
    runs_of,
    signal_options,
    view_of,
    while_waiting,
)
from elastic_tendon.app.workspace import Result, Session, Workspace
from elastic_tendon.comparison.comparison import Comparison, FileComparison
from elastic_tendon.comparison.conditions import Selection
from elastic_tendon.comparison.locate import FileLocation
from elastic_tendon.errors import MeasurementError
from elastic_tendon.progress import silent
from elastic_tendon.reports.comparison_tables import failing_sentence, tolerance_sentence
from elastic_tendon.reports.interactive.loop import torque_loop, torque_words
from elastic_tendon.reports.interactive.overlay import Run, overlay
from elastic_tendon.reports.interactive.theme import THEMES, Theme, blank
from elastic_tendon.reports.units import Shown, shown

# a double click shows all, as does a button
GESTURES: Any = figures.GESTURES | {
    "doubleClick": "autosize",
    "showTips": False,
    "modeBarButtonsToRemove": [*figures.GESTURES["modeBarButtonsToRemove"], "resetScale2d"],
}
HEIGHT = 430  # of the curves and of the loop, pixels
HEAD = 56  # of the curves, whose recording is named above, pixels
MODE_BAR = 32  # plotly's own buttons above the loop, pixels
# a legend above would lie below plotly's own buttons where the figure is narrow
BELOW = {"font": {"size": 11}, "y": -0.28, "yanchor": "top"}
DOTS = 1500  # of the loop; more than its panel can distinguish
CURVES = 2  # of each model: simulated, and its error
EMPTY = (None, "")  # fields of numbers
FILTERS = [Input(f"compare-{field}", "value") for field in FIELDS]
NO_READINGS = html.P(
    "Click in the curves to set A, then B; or type their times.", className="quiet"
)
SHOW = {"recording": "Recording", "signal": "Signal"}


# ---- layout --------------------------------------------------------------------------------


def _layout() -> Sequence[Component]:
    return [
        # what is looked at is shared with the step Where; it is kept for a reload
        dcc.Store(id="compare-view", storage_type="session"),
        dcc.Store(id="compare-window", storage_type="session"),
        dcc.Store(id="compare-cursors", storage_type="session"),
        dcc.Store(id="compare-moved", storage_type="session"),
        # numbers of the model that the sliders move
        dcc.Store(id="compare-numbers"),
        # what there is to zoom into in each step, and what was asked of its curves
        dcc.Store(id="compare-spans"),
        dcc.Store(id="compare-gesture"),
        dcc.Store(id="where-gesture"),
        # what the figures show now
        dcc.Store(id="compare-drawn"),
        dcc.Store(id="compare-loop-drawn"),
        html.P(id="compare-waiting", className="quiet"),
        html.Div(
            [
                html.Div([*choosers("compare"), _before()], className="row"),
                html.Div(filters("compare"), className="row", id="compare-filters"),
                html.P(id="compare-filters-fault", className="sentence", role="alert"),
                html.P(id="compare-filters-words", role="status", **aria(live="polite")),
                html.P(id="compare-sentence"),
                html.Div([_curves(), sliders(), _loop()], className="compare-figures"),
                html.Div([_errors(), _readings()], className="compare-tables"),
            ],
            id="compare-body",
            hidden=True,
        ),
    ]


def choosers(step: str) -> list[Component]:
    """Choices of recording and signal; `step` begins their ids."""
    attributes = {"clearable": False, "searchable": False, "className": "chooser"}
    return [choice(f"{step}-{part}", words, **attributes) for part, words in SHOW.items()]


def _before() -> Component:
    boxes = dcc.Checklist(
        [{"label": "Beside the model as given", "value": "before"}], ["before"], id="compare-before"
    )
    return html.Div(boxes, id="compare-before-row")


def _curves() -> Component:
    zoom = [
        _number("compare-from", "Zoom from"),
        _number("compare-to", "to"),
        html.Button("Reset zoom", id="compare-reset", className="plain"),
    ]
    return html.Div(
        [
            saveable("curves", GESTURES, id="compare-overlay", style={"height": HEIGHT}),
            html.Div(zoom, className="row", id="compare-zoom"),
        ]
    )


def _loop() -> Component:
    return html.Div(
        [
            html.P(id="compare-loop-waiting", className="quiet"),
            saveable("loop", GESTURES, id="compare-loop", style={"height": HEIGHT}),
            html.P(id="compare-loop-words", className="quiet"),
        ]
    )


def _errors() -> Component:
    return html.Div(
        [
            html.H3(id="compare-errors-heading"),
            html.Div(id="compare-errors"),
            html.Div(_tolerance(), className="row"),
            html.P(id="compare-tolerance-words"),
            html.Details([html.Summary("What these numbers mean"), html.P(FORMULAS)]),
        ]
    )


def _tolerance() -> Component:
    return html.Label(
        [
            "Tolerance ±",
            dcc.Input(id="compare-tolerance", type="number", step="any", min=0, debounce=True),
            html.Span(id="compare-tolerance-unit"),
        ],
        htmlFor="compare-tolerance",
        className="seconds",
    )


def _readings() -> Component:
    set_by_number = [
        _number("compare-a", "A at"),
        _number("compare-b", "B at"),
        html.Button("Clear cursors", id="compare-clear", className="plain"),
    ]
    return html.Div(
        [
            html.H3("Cursors"),
            html.Div(set_by_number, className="row"),
            html.Div(id="compare-readings"),
        ],
        id="compare-cursors-part",
    )


def _number(component_id: str, words: str) -> Component:
    return html.Label(
        [words, dcc.Input(id=component_id, type="number", step="any", debounce=True), "s"],
        htmlFor=component_id,
        className="seconds",
    )


# ---- callbacks -----------------------------------------------------------------------------


def _needs(document: Document, files: Files) -> Sequence[Result[Any]]:
    version, root = document.version, before_of(document)
    before = [] if root is None else [results.compared(document, root, files)]
    return [
        results.compared(document, version, files),
        *before,
        results.located(document, version, files),
        located_heldout(document, version, files),
    ]


def _register(app: Dash, workspace: Workspace) -> None:
    _register_view(app, workspace)
    _register_filters(app)
    _register_window(app)
    _register_cursors(app)
    _register_curves(app, workspace)
    _register_tables(app, workspace)
    _register_loop(app, workspace)
    register(app, workspace)
    serve(app, workspace)


def _register_view(app: Dash, workspace: Workspace) -> None:
    """Which recording and signal; one callback, for the choices of both steps follow each other."""

    @app.callback(
        Output("compare-view", "data"),
        Output("compare-spans", "data"),
        Output("compare-recording", "options"),
        Output("compare-recording", "value"),
        Output("compare-signal", "options"),
        Output("compare-signal", "value"),
        Output("where-recording", "options"),
        Output("where-recording", "value"),
        Output("where-signal", "options"),
        Output("where-signal", "value"),
        Output("compare-before-row", "hidden"),
        Output("compare-tolerance", "value"),
        Output("compare-tolerance-unit", "children"),
        Input("session", "data"),
        Input("open", "data"),
        Input("compare-recording", "value"),
        Input("compare-signal", "value"),
        Input("where-recording", "value"),
        Input("where-signal", "value"),
        Input("compare-before", "value"),
        Input("compare-tolerance", "value"),
        State("compare-view", "data"),
        State("compare-spans", "data"),
    )
    def choose(stored: Any, opened: str, *chosen: Any) -> Any:
        *values, before, tolerance, view_stored, spans_stored = chosen
        comparison = compared_now(workspace.open(stored)) if stored else None
        if comparison is None or opened not in ("compare", "where"):
            return (no_update,) * 13
        changed = dict(view_stored or {}) | {"before": bool(before)}
        views = (view_of(view_stored, comparison), fitted_view(view_stored, comparison))
        shown = [getattr(view, part) for view in views for part in SHOW]
        # told by what the fields show: a question that a later one overtakes is never answered
        for part, value, was in zip([*SHOW, *SHOW], values, shown, strict=True):
            if value and value != was:
                changed[part] = value
        files = recordings(comparison)
        if ctx.triggered_id == "compare-tolerance":
            looked_at = views[0]
            small = quantity_of(looked_at, files).small
            accepted = tolerance / small if tolerance and tolerance > 0 else None
            changed["tolerances"] = {**looked_at.tolerances, looked_at.signal: accepted}
        view = view_of(changed, comparison)
        fitted = fitted_view(changed, comparison)
        quantity = quantity_of(view, files)
        spans = {
            step: span(chosen_view.recording, files[chosen_view.recording].measurement)
            for step, chosen_view in (("compare", view), ("where", fitted))
        }
        return (
            # what did not change must not draw all figures again, nor ask for the zoom again
            view.stored() if view.stored() != view_stored else no_update,
            spans if spans != spans_stored else no_update,
            recording_options(comparison),
            view.recording,
            signal_options(files[view.recording]),
            view.signal,
            recording_options(comparison, fitted_only=True),
            fitted.recording,
            signal_options(files[fitted.recording]),
            fitted.signal,
            before_of(workspace.open(stored).document) is None,
            "" if view.tolerance is None else float(f"{quantity.small * view.tolerance:.6g}"),
            quantity.small_unit,
        )


def _register_filters(app: Dash) -> None:
    @app.callback(Output("compare-quantity", "options"), *while_open("compare"))
    def offer(stored: Any, opened: str) -> Any:
        return ranges() if stored and opened == "compare" else no_update


def quantity_of(view: View, files: Mapping[str, FileComparison]) -> Shown:
    """How the signal that is looked at is shown."""
    return shown(view.signal, static=files[view.recording].measurement.static)


def _register_window(app: Dash) -> None:
    """Which stretch of time is seen, in the curves of both steps and in the loop; see
    assets/compare.js.
    """

    def script(name: str) -> ClientsideFunction:
        return ClientsideFunction("elastic_tendon_compare", name)

    for step in ("compare", "where"):
        app.clientside_callback(
            script("gesture"),
            Output(f"{step}-gesture", "data"),
            Output(f"{step}-overlay", "relayoutData"),
            Input(f"{step}-overlay", "relayoutData"),
        )
    app.clientside_callback(
        script("zoom"),
        Output("compare-window", "data"),
        Output("compare-from", "value"),
        Output("compare-to", "value"),
        Input("compare-gesture", "data"),
        Input("where-gesture", "data"),
        Input("compare-from", "value"),
        Input("compare-to", "value"),
        Input("compare-reset", "n_clicks"),
        Input("where-reset", "n_clicks"),
        Input("where-mark", "data"),
        Input("compare-spans", "data"),
        State("compare-window", "data"),
        prevent_initial_call=True,
    )


def _register_cursors(app: Dash) -> None:
    @app.callback(
        Output("compare-cursors", "data"),
        Output("compare-a", "value"),
        Output("compare-b", "value"),
        Input("compare-overlay", "clickData"),
        Input("compare-a", "value"),
        Input("compare-b", "value"),
        Input("compare-clear", "n_clicks"),
        Input("compare-view", "data"),
        State("compare-cursors", "data"),
        prevent_initial_call=True,
    )
    def place(clicked: Any, a: Any, b: Any, _clear: Any, view: Any, held: Any) -> Any:
        recording = (view or {}).get("recording")
        if recording is None:  # nothing is seen yet
            return no_update, no_update, no_update
        asked = held or {}
        cursors: Mapping[str, float | None] = NO_CURSORS
        if asked.get("recording") == recording:
            cursors = dict(asked["order"])
        if ctx.triggered_id == "compare-overlay" and clicked:
            cursors = with_cursor(cursors, round(float(clicked["points"][0]["x"]), 6))
        elif ctx.triggered_id in ("compare-a", "compare-b"):
            typed = {name: None if time in EMPTY else time for name, time in (("A", a), ("B", b))}
            cursors = {name: typed[name] for name in cursors}
        elif ctx.triggered_id == "compare-clear":
            cursors = NO_CURSORS
        # as pairs: their order, which tells the older one, must survive the browser
        now = {"recording": recording, "order": [list(cursor) for cursor in cursors.items()]}
        fields = ["" if time is None else time for time in in_order(cursors)]
        return (now if now != held else no_update), *fields


def _register_curves(app: Dash, workspace: Workspace) -> None:
    @app.callback(
        Output("compare-overlay", "figure"),
        Output("compare-body", "hidden"),
        Output("compare-waiting", "children"),
        Output("compare-zoom", "hidden"),
        Output("compare-cursors-part", "hidden"),
        Output("compare-drawn", "data"),
        *while_open("compare"),
        Input("theme", "data"),
        Input("compare-view", "data"),
        Input("compare-window", "data"),
        Input("compare-cursors", "data"),
        Input("compare-moved", "data"),
        *FILTERS,
        State("compare-drawn", "data"),
    )
    def draw(
        stored: Any, opened: str, theme: str, view: Any, seen: Any, held: Any, *others: Any
    ) -> Any:
        slid, *asked, drawn = others
        if not stored or opened != "compare":
            return (no_update,) * 6
        session = workspace.open(stored)
        comparison = compared_now(session)
        rests_on = _needs(session.document, session.files)[:-2]
        if comparison is None:
            words = while_waiting(session, rests_on, "Comparing the model with the recordings…")
            return no_update, True, words, True, True, None
        chosen = view_of(view, comparison)
        version = session.document.version
        rest = fingerprint(session, rests_on, theme, chosen, seen, held, asked)
        values = moved_values(version, slid)
        if drawn and (drawn["rest"], drawn["moved"]) == (rest, values):
            return (no_update,) * 6
        runs, _ = _runs(session, chosen, asked)
        window = window_of(seen, chosen.recording)
        moved, _ = moved_runs(version, runs[-1].file, slid, window)
        static = runs[0].file.measurement.static
        now = {"id": session.id, "rest": rest, "moved": values, "curves": len(moved)}
        file, first = runs[-1].file, 1 + CURVES * len(runs)
        note(session, Seen(rest, version, file, chosen.signal, window, first))
        if moved and not static and drawn and drawn["rest"] == rest and drawn["curves"]:
            curves = moved_curves(moved[-1], chosen.signal, window)
            return moved_only(curves, first), *(no_update,) * 4, now
        figure = overlay(
            [*runs, *moved],
            chosen.signal,
            theme=THEMES[theme],
            window=window,
            cursors=in_order(cursors_of(held, chosen.recording)),
            tolerance=chosen.tolerance,
            buckets=BUCKETS,
        )
        changed: Any = responsive(figure, HEIGHT, seen)
        if drawn and list(ctx.triggered_prop_ids) == ["compare-cursors.data"]:
            changed = marks_only(changed)
        return changed, False, "", static, static, now


def _runs(session: Session, view: View, asked: Sequence[Any]) -> tuple[tuple[Run, ...], str]:
    """The models over the samples that are asked for; over all, and why, where there are none."""
    try:
        return runs_of(session, view, conditions(*asked)), ""
    except MeasurementError as fault:
        return runs_of(session, view), f"{fault}. All samples are shown."


def marks_only(figure: Any) -> Patch:
    """What lies upon and under the curves; these stay, which the browser draws much faster."""
    changed = Patch()
    changed["layout"]["shapes"] = figure.layout.shapes
    changed["layout"]["annotations"] = figure.layout.annotations
    return changed


def moved_only(curves: Sequence[Mapping[str, Any]], first: int) -> Patch:
    """The curves of the model that the sliders make, from their place in the figure; all others
    stay."""
    changed = Patch()
    for place, curve in enumerate(curves, first):
        for name, values in curve.items():
            changed["data"][place][name] = values
    return changed


def window_of(seen: Mapping[str, Any] | None, recording: str) -> tuple[float, float] | None:
    """The stretch of time that is seen of a recording, s, None for all."""
    if not seen or seen["recording"] != recording or not seen["window"]:
        return None
    low, high = seen["window"]
    return low, high


def cursors_of(held: Mapping[str, Any] | None, recording: str) -> Mapping[str, float | None]:
    """The cursors in a recording, s."""
    if not held or held["recording"] != recording:
        return NO_CURSORS
    return dict(held["order"])


def responsive(figure: Any, height: int, seen: Any) -> Any:
    """The figure as the page shows it: time is zoomed by the page alone, values follow."""
    figure.update_layout(height=height, title=None, margin={"t": HEAD})
    figure.update_xaxes(uirevision=str(seen))  # else the browser keeps the zoom it had
    figure.update_yaxes(fixedrange=True)
    return figure


def _register_tables(app: Dash, workspace: Workspace) -> None:
    @app.callback(
        Output("compare-sentence", "children"),
        Output("compare-errors", "children"),
        Output("compare-tolerance-words", "children"),
        Output("compare-readings", "children"),
        Output("compare-filters-fault", "children"),
        Output("compare-filters-words", "children"),
        Output("compare-errors-heading", "children"),
        Output("compare-moved-words", "children"),
        Output("compare-moved-fault", "children"),
        *while_open("compare"),
        Input("compare-view", "data"),
        Input("compare-window", "data"),
        Input("compare-cursors", "data"),
        Input("compare-moved", "data"),
        *FILTERS,
    )
    def tell(
        stored: Any, opened: str, view: Any, seen: Any, held: Any, slid: Any, *asked: Any
    ) -> Any:
        if not stored or opened != "compare":
            return (no_update,) * 9
        session = workspace.open(stored)
        comparison = compared_now(session)
        if comparison is None:
            return (no_update,) * 9
        chosen = view_of(view, comparison)
        runs, fault = _runs(session, chosen, asked)
        version = session.document.version
        window = window_of(seen, chosen.recording)
        moved, moved_fault = moved_runs(version, runs[-1].file, slid, window)
        words = moved_words(version, runs, moved, chosen.signal)
        told = *_filter_words(runs[-1].file.selection, fault), words, moved_fault
        located = location_of(session, chosen)
        failing = failing_sentence(runs[-1].file, located, chosen.signal) if located else ""
        quantity = shown(chosen.signal, static=runs[0].file.measurement.static)
        runs = (*runs, *moved)
        caption = f"By slack state: {runs[-1].label}" if len(runs) > 1 else ""
        errors = table(error_heads(quantity), error_rows(runs, chosen.signal), caption)
        kept = _tolerance_words(version.loaded(), runs[-1], chosen)
        cursors = cursor_rows(runs, chosen.signal, cursors_of(held, chosen.recording))
        read = table(["", "A", "B", "B − A"], cursors) if cursors else NO_READINGS
        return failing, errors, kept, read, *told


def _filter_words(selection: Selection | None, fault: str) -> tuple[str, str, str]:
    """Why no samples are selected, which are, and the heading of their errors."""
    if selection is None:
        return fault, "", "Errors over the whole recording"
    words = f"Only where {selection.words}; others are faint."
    return "", words, "Errors where these conditions hold"


def _tolerance_words(model: Model, run: Run, view: View) -> str:
    """Whether a run keeps the tolerance of the signal that is looked at; "" where there is none."""
    accepted = {} if view.tolerance is None else {view.signal: view.tolerance}
    checks = Comparison(model, (run.file,)).within(accepted)
    moved = f" This is {LABEL}." if checks and run.label == LABEL else ""
    return " ".join(map(tolerance_sentence, checks)) + moved


def _register_loop(app: Dash, workspace: Workspace) -> None:
    @app.callback(
        Output("compare-loop", "figure"),
        Output("compare-loop", "style"),
        Output("compare-loop-waiting", "children"),
        Output("compare-loop-words", "children"),
        Output("compare-loop-drawn", "data"),
        *while_open("compare"),
        Input("theme", "data"),
        Input("compare-view", "data"),
        Input("compare-window", "data"),
        *FILTERS,
        State("compare-loop-drawn", "data"),
    )
    def draw(stored: Any, opened: str, theme: str, view: Any, seen: Any, *others: Any) -> Any:
        *asked, drawn = others
        if not stored or opened != "compare":
            return (no_update,) * 5
        session = workspace.open(stored)
        comparison = compared_now(session)
        if comparison is None:
            return no_update, no_update, "", "", None
        if not session.document.version.loaded().kind.has_springs:
            return no_update, {"display": "none"}, "", "", None
        chosen = view_of(view, comparison)
        rests_on = _needs(session.document, session.files)
        window = window_of(seen, chosen.recording)
        now = fingerprint(session, rests_on, theme, chosen.recording, window, asked)
        if now == drawn:
            return (no_update,) * 5
        located = location_of(session, chosen)
        if located is None:
            words = "The loop of torque and deflection comes once the missing torque is found."
            words = while_waiting(session, rests_on, words)
            return blank(THEMES[theme]), {"height": HEIGHT, "display": "none"}, words, "", now
        runs, _ = _runs(session, chosen, asked)
        file = runs[-1].file
        figure = loop_figure(session, file, located, theme=THEMES[theme], window=window, key=now)
        return figure, {"height": HEIGHT}, "", torque_words(file.measurement), now


def loop_figure(
    session: Session,
    file: FileComparison,
    location: FileLocation,
    *,
    theme: Theme,
    window: Window | None,
    key: str,
) -> Any:
    """`torque_loop` as the page shows it; `key` changes whenever another would be drawn.

    All of a recording, to which every zoom comes back, is drawn once: of a long one it takes long.
    """
    model = session.document.version.loaded()

    def draw(*_: object) -> Any:
        figure = torque_loop(model, file, location, theme=theme, window=window, dots=DOTS)
        look = {"height": HEIGHT, "title": None, "margin": {"t": MODE_BAR}, "legend": BELOW}
        return figure.update_layout(look)

    if window is not None:
        return draw()
    return session.cache.obtain(Result(("loop", key), "drawing the loop", draw), silent)


STEP = PageStep(id="compare", title="Compare", layout=_layout, register=_register, needs=_needs)
