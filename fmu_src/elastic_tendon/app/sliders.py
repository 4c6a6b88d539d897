"""Sliders for the numbers of a model: what they were moved to, and what comes of that.

The page keeps what was moved, see assets/sliders.js; it is no part of the document until the user
takes it into the model.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from threading import Lock
from typing import Any

from dash import ALL, ClientsideFunction, Dash, Input, Output, State, ctx, dcc, html, no_update
from dash.development.base_component import Component

from elastic_tendon.app.document import Version
from elastic_tendon.app.readings import Window
from elastic_tendon.app.step import aria, dom_id, while_open
from elastic_tendon.app.workspace import Workspace
from elastic_tendon.comparison.compare import compare
from elastic_tendon.comparison.comparison import FileComparison
from elastic_tendon.comparison.conditions import Selection
from elastic_tendon.comparison.initial_state import estimate_initial_state
from elastic_tendon.comparison.residuals import rms
from elastic_tendon.comparison.selection import at
from elastic_tendon.errors import ElasticTendonError, ModelError
from elastic_tendon.fmu.live import groups
from elastic_tendon.measurement import Measurement
from elastic_tendon.reports.interactive.overlay import Run
from elastic_tendon.reports.thinning import within
from elastic_tendon.reports.units import shown

LABEL, COLOUR = "with the sliders", 2  # of the model that they make, beside others
LONGEST = 500_000  # samples that are simulated at once; more would not follow the hand
STILL = "Each slider simulates the recording anew. The model stays as it is until you take them."
Held = Mapping[str, Any]  # "of": `Version.mark`; "values": what was moved, SI, by dotted path


def sliders() -> Component:
    """The sliders' place on the page."""
    buttons = [
        html.Button("Take these values into the model", id="compare-take", className="plain"),
        html.Button("Back to the model's values", id="compare-back", className="plain"),
    ]
    return html.Details(
        [
            html.Summary("Move parameters"),
            html.P(STILL, id="compare-moved-words", role="status", **aria(live="polite")),
            html.P(id="compare-moved-fault", className="sentence", role="alert"),
            html.Div(buttons, className="row"),
            html.Div(id="compare-sliders"),
        ],
        id="compare-move",
    )


def moved_values(version: Version, held: Held | None) -> dict[str, float]:
    """What the sliders of a version were moved to, SI by dotted path; nothing else's."""
    return dict(held["values"]) if held and held["of"] == version.mark else {}


def moved_runs(
    version: Version, file: FileComparison, held: Held | None, window: Window | None = None
) -> tuple[tuple[Run, ...], str]:
    """The model that the sliders make beside a recording; none, and why, where it cannot be.

    Parameters
    ----------
    version : whose numbers are moved
    file : the recording beside it; the same samples are compared
    held : what was moved; none where that is nothing
    window : that is seen, s, None for all. A recording that is long is simulated in this alone,
        and in the beginning of it where that is long too
    """
    values = moved_values(version, held)
    if not values:
        return (), ""
    time = file.measurement.time
    kept = within(time, window) if len(time) > LONGEST else slice(None)
    first, end, _ = kept.indices(len(time))
    with _ONE:  # curves and table ask at the same time, and again with every cursor and zoom
        return _moved_runs(version, tuple(values.items()), _Same(file), first, end)


_ONE = Lock()


@dataclass(frozen=True, eq=False)
class _Same:
    """A recording that is only equal to itself: to compare its samples takes long."""

    file: FileComparison

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Same) and other.file is self.file

    def __hash__(self) -> int:
        return id(self.file)


@lru_cache(maxsize=1)
def _moved_runs(
    version: Version, values: tuple[tuple[str, float], ...], same: _Same, first: int, end: int
) -> tuple[tuple[Run, ...], str]:
    measurement, selection = _stretch(same, first, min(end, first + LONGEST))
    if selection is not None and not selection.chosen.any():
        return (), "No sample that is selected is in the stretch that the sliders simulate."
    try:
        model = version.loaded().with_values(dict(values))
        # how its inputs ran was found with the model's own values
        (beside,) = compare(model, measurement, [estimate_initial_state(model, measurement)]).files
    except ElasticTendonError as fault:
        return (), f"{fault}."
    return (Run(LABEL, at(model, beside, selection), COLOUR),), ""


@lru_cache(maxsize=1)
def _stretch(same: _Same, first: int, end: int) -> tuple[Measurement, Selection | None]:
    """Some samples of a recording, which keep what is found of them, and those selected."""
    measurement, selection, kept = same.file.measurement, same.file.selection, slice(first, end)
    if end - first == len(measurement.time):
        return measurement, selection
    if selection is not None:
        selection = replace(selection, chosen=selection.chosen[kept])
    return measurement.samples(kept), selection


def moved_words(version: Version, runs: Sequence[Run], moved: Sequence[Run], signal: str) -> str:
    """How the error of a signal changes with the sliders, over what these simulate.

    Parameters
    ----------
    version : whose numbers are moved
    runs : its model beside a recording, the last of these
    moved : what the sliders make of it, nothing where they were not moved
    signal : of the recording
    """
    if not moved:
        return STILL
    whole, part = runs[-1].file.measurement, moved[-1].file.measurement
    ends = float(part.time[0]), float(part.time[-1])
    before = runs[-1].error(signal)[within(whole.time, ends)]
    selection = moved[-1].file.selection
    chosen = slice(None) if selection is None else selection.chosen
    quantity = shown(signal, static=whole.static)
    errors = (moved[-1].error(signal), before)
    now, was = (quantity.error(rms(error[chosen])) for error in errors)
    words = [f"RMS error of the {quantity.words}: {now} {LABEL}, {was} with the model's values."]
    if len(part.time) < len(whole.time):
        seconds = f"{ends[0]:.4g} s to {ends[1]:.4g} s"
        words.append(
            f"Both from {seconds}: of a long recording the sliders simulate what is seen alone, "
            f"at most {LONGEST} samples."
        )
    if version.loaded().kind.has_springs:
        words.append("The loop stays that of the model.")
    return " ".join(words)


def _groups(version: Version, moved: Mapping[str, float]) -> list[Component]:
    return [
        html.Fieldset(
            [
                html.Legend(group["title"]),
                *(_slider(number, moved) for number in group["numbers"]),
            ]
        )
        for group in groups(version.loaded())
    ]


def _slider(number: Mapping[str, Any], moved: Mapping[str, float]) -> Component:
    place = {"compare-slider": number["path"]}
    return html.Div(
        [
            html.Label(number["label"], htmlFor=dom_id(place), title=number["note"]),
            html.Span(id={"compare-moved-to": number["path"]}),
            dcc.Input(
                id=place,
                type="range",
                min=number["low"],
                max=number["high"],
                step=1 if number["whole"] else "any",
                value=moved.get(number["path"], number["value"]),
            ),
        ],
        className="slider",
    )


def register(app: Dash, workspace: Workspace) -> None:
    """Connect the sliders; what they make is drawn by the step Compare."""
    _register_browser(app)

    @app.callback(
        Output("compare-sliders", "children"),
        Output("compare-numbers", "data"),
        Output("compare-move", "open"),
        *while_open("compare"),
        Input("compare-back", "n_clicks"),
        State("compare-numbers", "data"),
        State("compare-moved", "data"),
    )
    def fill(stored: Any, opened: str, _back: int | None, numbers: Any, held: Any) -> Any:
        if not stored or opened != "compare":
            return no_update, no_update, no_update
        version = workspace.open(stored).document.version
        back = ctx.triggered_id == "compare-back"
        # sliders of this version are left alone: someone may be moving one
        if numbers and numbers["of"] == version.mark and not back:
            return no_update, no_update, no_update
        moved = {} if back else moved_values(version, held)
        model = version.loaded()
        now = {
            "of": version.mark,
            "values": model.values(),
            "units": {
                number["path"]: number["unit"]
                for group in groups(model)
                for number in group["numbers"]
            },
        }
        return _groups(version, moved), now, True if moved else no_update

    @app.callback(
        Output("session", "data", allow_duplicate=True),
        Input("compare-take", "n_clicks"),
        State("compare-moved", "data"),
        State("session", "data"),
        prevent_initial_call=True,
    )
    def take(_clicks: int | None, held: Any, stored: Any) -> Any:
        session = workspace.open(stored)
        version = session.document.version
        values = moved_values(version, held)
        if not values:
            return no_update
        try:
            model = version.loaded().with_values(values)
        except ModelError:  # told beside the sliders
            return no_update
        session.change(lambda document: document.edited(model))
        return session.stored()


def _register_browser(app: Dash) -> None:
    def script(name: str) -> ClientsideFunction:
        return ClientsideFunction("elastic_tendon_sliders", name)

    app.clientside_callback(
        script("move"),
        Output({"compare-moved-to": ALL}, "children"),
        Input({"compare-slider": ALL}, "value"),
        State({"compare-slider": ALL}, "id"),
        State("compare-numbers", "data"),
        State("compare-moved", "data"),
    )
    app.clientside_callback(script("drawn"), Input("compare-drawn", "data"))
