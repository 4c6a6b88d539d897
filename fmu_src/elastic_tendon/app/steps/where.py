"""Where the error lies: in words, bars, maps; a click marks the samples in the curves."""

import json
from collections.abc import Sequence
from typing import Any

import plotly.graph_objects as go
from dash import ALL, Dash, Input, Output, State, ctx, dcc, html, no_update
from dash.development.base_component import Component

from elastic_tendon.app import results
from elastic_tendon.app.document import Document
from elastic_tendon.app.figures import saveable
from elastic_tendon.app.readings import (
    beyond,
    chosen_samples,
    chosen_words,
    strongest_bins,
)
from elastic_tendon.app.redrawing import BUCKETS
from elastic_tendon.app.results import Files
from elastic_tendon.app.step import PageStep, aria, while_open
from elastic_tendon.app.steps.compare import (
    GESTURES,
    choosers,
    marks_only,
    responsive,
    window_of,
)
from elastic_tendon.app.tables import Exact, table
from elastic_tendon.app.view import (
    View,
    compared_now,
    fingerprint,
    fitted_view,
    location_of,
    recordings,
    runs_of,
    while_waiting,
)
from elastic_tendon.app.workspace import Result, Session, Workspace
from elastic_tendon.comparison.locate import FileLocation
from elastic_tendon.reports.comparison_tables import NOTHING, bin_cells, sample_shares, sentences
from elastic_tendon.reports.interactive.correlation import residual_correlation
from elastic_tendon.reports.interactive.overlay import overlay
from elastic_tendon.reports.interactive.places import Mark, error_maps, shares
from elastic_tendon.reports.interactive.theme import THEMES, blank
from elastic_tendon.reports.interactive.torque import missing_torque
from elastic_tendon.reports.residual_tests import HEADS, residual_rows
from elastic_tendon.reports.units import shown

HEIGHT, HEAD, FOOT = 190, 24, 38  # of the curves, which stay in sight, and around them, pixels
LEGEND = 40  # above the other figures, pixels
NO_SAMPLES = "A band of frequencies has no samples of its own that could be shown."
BARS = (
    "A coloured bar: more error than the noise explains. The line across: the bin's share of the "
    "samples; where the bar reaches above it, the error is denser than on average."
)
RESIDUALS = (
    "The residual, simulated less measured, is only noise where the model misses nothing: it "
    "follows neither its own past nor the inputs. Neighbouring lags are alike, so that several lie "
    "beyond their bounds at once: more than chance is told of all lags together, with 1 % risk."
)
UNDONE = "The zoom was reset, for none of these samples lay in it."
HINT = "Choose a bin of the table, click a bar or a cell of a map: its samples are marked here."


# ---- layout --------------------------------------------------------------------------------


def _layout() -> Sequence[Component]:
    return [
        dcc.Store(id="where-mark"),
        # what words and figures show now
        dcc.Store(id="where-told"),
        dcc.Store(id="where-curves-drawn"),
        dcc.Store(id="where-drawn"),
        html.P(id="where-waiting", className="quiet"),
        html.Div(
            [
                html.Div(choosers("where"), className="row"),
                html.Ul(id="where-sentences"),
                _curves(),
                html.H3("Where the error is densest"),
                html.Div(id="where-bins", className="where-bins"),
                html.H3("Share of the error in every bin"),
                html.P(BARS, className="quiet"),
                saveable("where_shares", GESTURES, id="where-shares"),
                html.Div(
                    [html.H3("Maps"), saveable("where_maps", GESTURES, id="where-maps")],
                    id="where-maps-part",
                ),
                html.H3("What is missing at the joint"),
                saveable("missing_torque", GESTURES, id="where-torque"),
                _residual_tests(),
            ],
            id="where-body",
            hidden=True,
        ),
    ]


def _curves() -> Component:
    return html.Div(
        [
            saveable("where_curves", GESTURES, id="where-overlay", style={"height": HEIGHT}),
            html.Div(
                [
                    html.P(HINT, id="where-chosen", role="status", **aria(live="polite")),
                    html.Button("Unmark", id="where-clear", className="plain", hidden=True),
                    html.Button("Reset zoom", id="where-reset", className="plain"),
                ],
                className="row",
            ),
        ],
        className="where-curves",
    )


def _residual_tests() -> Component:
    return html.Div(
        [
            html.H3("Residual tests"),
            html.P(RESIDUALS, className="quiet"),
            html.Div(id="where-residual-table", className="where-bins"),
            saveable("residual_tests", GESTURES, id="where-residual"),
        ],
        id="where-residual-part",
    )


# ---- what is looked at ---------------------------------------------------------------------


def _needs(document: Document, files: Files) -> Sequence[Result[Any]]:
    version = document.version
    return [
        results.compared(document, version, files),
        results.located(document, version, files),
    ]


def _seen(session: Session, view: Any) -> tuple[View, FileLocation] | None:
    """The recording that is looked at, the first where that is held out; None while computing."""
    comparison = compared_now(session)
    if comparison is None:
        return None
    chosen = fitted_view(view, comparison)
    location = location_of(session, chosen)
    return None if location is None else (chosen, location)


# ---- callbacks -----------------------------------------------------------------------------


def _register(app: Dash, workspace: Workspace) -> None:
    _register_words(app, workspace)
    _register_mark(app, workspace)
    _register_curves(app, workspace)
    _register_figures(app, workspace)


def _register_words(app: Dash, workspace: Workspace) -> None:
    @app.callback(
        Output("where-body", "hidden"),
        Output("where-waiting", "children"),
        Output("where-sentences", "children"),
        Output("where-bins", "children"),
        Output("where-residual-table", "children"),
        Output("where-told", "data"),
        *while_open("where"),
        Input("compare-view", "data"),
        State("where-told", "data"),
    )
    def tell(stored: Any, opened: str, view: Any, told: Any) -> Any:
        if not stored or opened != "where":
            return (no_update,) * 6
        session = workspace.open(stored)
        seen = _seen(session, view)
        comparison = compared_now(session)
        rests_on = _needs(session.document, session.files)
        if seen is None or comparison is None:
            words = while_waiting(session, rests_on, "Finding where the model fails…")
            return True, words, [], [], [], None
        chosen, location = seen
        now = fingerprint(session, rests_on, chosen)
        if now == told:  # buttons made anew would forget a click that is not yet answered
            return (no_update,) * 6
        file = recordings(comparison)[chosen.recording]
        items = [html.Li(sentence) for sentence in sentences(file, location)]
        static = file.measurement.static
        bins = _bin_table(location, chosen.signal, static=static)
        tests = residual_rows(location.correlations.get(chosen.signal, ()))
        return False, "", items, bins, table(HEADS, tests), now


def _bin_table(location: FileLocation, signal: str, *, static: bool) -> Component:
    bins = location.bins[signal]
    quantity = shown(signal, static=static)
    held = sample_shares(bins)
    rows = []
    for error_bin in strongest_bins(bins):
        by, where, *figures = bin_cells(error_bin, quantity, held[error_bin])
        sizes = [quantity.small * size for size in (error_bin.rmse, error_bin.bias)]
        exact = [*sizes, 100.0 * error_bin.share, 100.0 * held[error_bin]]
        button: Any = html.Span("–", title=NO_SAMPLES)
        if error_bin.by != "frequency":
            number = bins.index(error_bin)
            words = {"label": f"Show the samples of {by} {where}"}
            button = html.Button(
                "Show", id={"where-bin": number}, className="plain", **aria(**words)
            )
        cells = (
            text if text == NOTHING else Exact(text, value)
            for text, value in zip(figures, exact, strict=True)
        )
        rows.append([f"{by} {where}", *cells, button])
    if not rows:
        return html.P("No bin holds more error than the noise explains.", className="quiet")
    unit = quantity.small_unit
    heads = ["where", f"RMS ({unit})", f"bias ({unit})", "share of error (%)"]
    return table([*heads, "share of samples (%)", ""], rows)


def _register_mark(app: Dash, workspace: Workspace) -> None:
    @app.callback(
        Output("where-mark", "data"),
        Input("where-shares", "clickData"),
        Input("where-maps", "clickData"),
        Input({"where-bin": ALL}, "n_clicks"),
        Input("where-clear", "n_clicks"),
        Input("compare-view", "data"),
        State("session", "data"),
        State("compare-window", "data"),
        State("where-mark", "data"),
        prevent_initial_call=True,
    )
    def mark(bar: Any, cell: Any, rows: list[Any], _clear: Any, view: Any, *states: Any) -> Any:
        stored, window, held = states
        seen = _seen(workspace.open(stored), view) if stored else None
        if seen is None:
            return no_update
        chosen, location = seen
        marked = None
        if ctx.triggered_id == "where-shares":
            marked = _clicked(bar)
        elif ctx.triggered_id == "where-maps":
            marked = json.loads(_clicked(cell) or "null")
        elif ctx.triggered_id == "compare-view":
            if held and held["recording"] == chosen.recording:
                return no_update  # another signal of the same samples
        elif isinstance(ctx.triggered_id, dict):
            if not any(rows):
                return no_update  # the table came, nobody clicked
            error_bin = location.bins[chosen.signal][ctx.triggered_id["where-bin"]]
            marked = [error_bin.by, error_bin.bin]
        samples, seen_of = chosen_samples(location, marked), window_of(window, chosen.recording)
        hidden = samples is not None and beyond(samples, location.variables["time"], seen_of)
        # a stretch of time in which none of the samples lies is seen no longer
        undoes = window if hidden else None
        return {"recording": chosen.recording, "mark": marked, "undoes": undoes}


def _clicked(happened: Any) -> Any:
    """Custom data of what was clicked, None where it has none."""
    return happened["points"][0].get("customdata") if happened else None


def _register_curves(app: Dash, workspace: Workspace) -> None:
    @app.callback(
        Output("where-overlay", "figure"),
        Output("where-chosen", "children"),
        Output("where-clear", "hidden"),
        Output("where-reset", "hidden"),
        Output("where-curves-drawn", "data"),
        *while_open("where"),
        Input("theme", "data"),
        Input("compare-view", "data"),
        Input("compare-window", "data"),
        Input("where-mark", "data"),
        State("where-curves-drawn", "data"),
    )
    def draw(
        stored: Any, opened: str, theme_name: str, view: Any, window: Any, held: Any, drawn: Any
    ) -> Any:
        if not stored or opened != "where":
            return (no_update,) * 5
        session = workspace.open(stored)
        seen = _seen(session, view)
        if seen is None:
            return (*(no_update,) * 4, None)
        chosen, location = seen
        rests_on = _needs(session.document, session.files)
        now = fingerprint(session, rests_on, theme_name, chosen, window, held)
        if now == drawn:
            return (no_update,) * 5
        run = runs_of(session, chosen)[-1]
        mark: Mark = held["mark"] if held and held["recording"] == chosen.recording else ()
        samples = chosen_samples(location, mark)
        figure = overlay(
            [run],
            chosen.signal,
            theme=THEMES[theme_name],
            window=window_of(window, chosen.recording),
            highlighted=samples,
            buckets=BUCKETS,
        )
        words = HINT
        if samples is not None:
            words = chosen_words(run, chosen.signal, location, mark, samples)
            if held["undoes"] and window_of(window, chosen.recording) is None:
                words = f"{words} {UNDONE}"
        changed: Any = _low(responsive(figure, HEIGHT, window))
        # the chosen samples of a static curve are points, not marks
        static = run.file.measurement.static
        if not static and drawn and list(ctx.triggered_prop_ids) == ["where-mark.data"]:
            changed = marks_only(changed)
        return changed, words, samples is None, static, now


def _low(figure: go.Figure) -> go.Figure:
    """The figure without what it can spare: units below the names, the time close to its axis."""
    for axis, domain in zip(figure.select_yaxes(), ((0.47, 1.0), (0.0, 0.37)), strict=True):
        axis.update(
            domain=domain,
            title={"text": axis.title.text.replace(" (", "<br>("), "font": {"size": 10}},
            tickfont={"size": 11},
            nticks=4,
        )
    figure.update_xaxes(title={"standoff": 0, "font": {"size": 11}}, tickfont={"size": 11})
    return figure.update_layout(margin={"t": HEAD, "b": FOOT}, legend={"font": {"size": 11}})


def _register_figures(app: Dash, workspace: Workspace) -> None:
    @app.callback(
        Output("where-shares", "figure"),
        Output("where-maps", "figure"),
        Output("where-torque", "figure"),
        Output("where-residual", "figure"),
        Output("where-shares", "style"),
        Output("where-maps", "style"),
        Output("where-torque", "style"),
        Output("where-residual", "style"),
        Output("where-maps-part", "hidden"),
        Output("where-residual-part", "hidden"),
        Output("where-drawn", "data"),
        *while_open("where"),
        Input("theme", "data"),
        Input("compare-view", "data"),
        State("where-drawn", "data"),
    )
    def draw(stored: Any, opened: str, theme_name: str, view: Any, drawn: Any) -> Any:
        if not stored or opened != "where":
            return (no_update,) * 11
        session = workspace.open(stored)
        seen, compared = _seen(session, view), compared_now(session)
        if seen is None or compared is None:
            return (*(no_update,) * 10, None)
        chosen, location = seen
        rests_on = _needs(session.document, session.files)
        now = fingerprint(session, rests_on, theme_name, chosen)
        if now == drawn:
            return (no_update,) * 11
        file, theme = recordings(compared)[chosen.recording], THEMES[theme_name]
        static = file.measurement.static
        maps = blank(theme) if static else clickable(error_maps(file, location, theme=theme))
        bars = shares(file, location, chosen.signal, theme=theme)
        torque = missing_torque(file, location, theme=theme)
        tests = (
            blank(theme) if static else residual_correlation(location, chosen.signal, theme=theme)
        )
        figures = [_untitled(figure) for figure in (bars, maps, torque, tests)]
        heights = [{"height": figure.layout.height} for figure in figures]
        return *figures, *heights, static, static, now


def _untitled(figure: go.Figure) -> go.Figure:
    """The figure without its title, which stands above it on the page."""
    above = figure.layout.margin.t or figure.layout.template.layout.margin.t
    spare = max(above - LEGEND, 0)
    height = figure.layout.height and figure.layout.height - spare
    return figure.update_layout(title=None, height=height, margin={"t": above - spare})


def clickable(maps: go.Figure) -> go.Figure:
    """The figure with marks that a click brings back; Dash drops those of cells but for text."""
    for trace in maps.data:
        trace.customdata = [
            [None if cell is None else json.dumps(list(cell)) for cell in row]
            for row in trace.customdata
        ]
    return maps


STEP = PageStep(id="where", title="Where", layout=_layout, register=_register, needs=_needs)
