"""Data: which files, how they are read, what is fitted, and what is odd about them."""

import json
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from hashlib import sha256
from time import time_ns
from typing import Any

from dash import ALL, Dash, Input, Output, State, ctx, dcc, html, no_update
from dash.development.base_component import Component
from plotly.utils import PlotlyJSONEncoder
from pydantic import ValidationError

from elastic_tendon.app import mapping, offers, results, safety
from elastic_tendon.app.document import Document, Source
from elastic_tendon.app.preview import beginnings
from elastic_tendon.app.results import Files
from elastic_tendon.app.source_card import Form, Seen, card, dom_id, facts, overview
from elastic_tendon.app.step import PageStep, while_open
from elastic_tendon.app.upload_field import upload
from elastic_tendon.app.uploads import add_recordings, size_in_words
from elastic_tendon.app.workspace import Failure, Result, Session, Workspace
from elastic_tendon.errors import MeasurementError
from elastic_tendon.reports.interactive.theme import THEMES, Theme

FITTED_SHARE = 0.7  # of a recording that is newly split


def _layout() -> Sequence[Component]:
    return [
        upload(
            "data-upload",
            "Add files of measurements: choose them, or drop them here "
            f"({size_in_words(safety.UPLOAD)} at a time; larger ones on the command line)",
            safety.UPLOAD,
            tell="data-refusal",
        ),
        html.P(id="data-refusal", className="sentence", role="alert"),
        html.P(id="data-sum", role="status"),
        dcc.Store(id="data-shown"),  # what the fields showed when they were made, and their mark
        dcc.Store(id="data-told"),  # key -> mark of what is shown of a file
        html.Div(id="data-cards"),
    ]


# ---- what it shows -------------------------------------------------------------------------


def seen(session: Session, source: Source) -> Seen:
    """What the cache holds of a source."""
    document, files, cache = session.document, session.files, session.cache
    labels = cache.find(results.contents(source, files))
    read = cache.find(results.reading(source, files))
    checked = cache.find(results.checked(document, source, files))
    start = cache.find(beginnings(source, files))
    return Seen(
        source,
        labels,
        read,
        None if source.role == "off" else checked,
        start if isinstance(start, tuple) else (),
        document.version.loaded().motion,
    )


def cards(session: Session) -> tuple[list[Component], Form]:
    """A card for each source, and the fields in them."""
    form = Form()
    return [card(seen(session, source), form) for source in session.document.sources], form


def summary(session: Session) -> str:
    """What is fitted and what validates, or why nothing can be."""
    document = session.document
    if not document.sources:
        return (
            "There are no data yet. A file needs the time, the motor's and the joint's position; "
            "a static curve needs deflection and joint torque."
        )
    measurements = session.cache.find(results.data(document, session.files))
    if measurements is None:
        return "Reading…"
    if isinstance(measurements, Failure):
        if any(seen(session, source).sentence() for source in document.sources):
            return (
                "No file that is to be fitted can be used as it is: correct one, or add another; "
                "until then nothing is compared."
            )
        return f"{measurements.sentence[:1].upper()}{measurements.sentence[1:]}."
    fitted, heldout = len(measurements.fitted), len(measurements.heldout)
    return (
        f"{_count(fitted)} {'is' if fitted == 1 else 'are'} fitted; "
        f"{_count(heldout) if heldout else 'none'} "
        f"{'validate' if heldout > 1 else 'validates'}."
    )


def _count(recordings: int) -> str:
    return "1 recording" if recordings == 1 else f"{recordings} recordings"


def mark(tree: object) -> str:
    """Changes with what the page shows."""
    return sha256(json.dumps(tree, cls=PlotlyJSONEncoder).encode()).hexdigest()


# ---- what is changed -----------------------------------------------------------------------


def changes(known: Seen, field: str, signal: str, value: Any) -> Mapping[str, object]:
    """What becomes of a source when one of its fields is changed.

    Parameters
    ----------
    known : Seen
    field, signal : which; `signal` "" for what belongs to no signal
    value : as the field gives it

    Raises
    ------
    MeasurementError : it cannot be; one sentence
    """
    source = known.source
    if field in ("column", "unit", "times", "plus"):
        (row,) = (row for row in known.rows() if row.signal == signal)
        return {"mapping": mapping.remapped(source, known.columns, row, field, value)}
    if field == "shift":
        return {"time_shift": mapping.shifts_of(source, signal, value)}
    simple: dict[str, Callable[[], Mapping[str, object]]] = {
        "role": lambda: {"role": value, "split": _split(known, value)},
        "split": lambda: {"split": mapping.number_of(value, "the time of the split")},
        "start": lambda: {"window": mapping.window_of(source, field, value)},
        "end": lambda: {"window": mapping.window_of(source, field, value)},
        "resample": lambda: {"resample": mapping.number_of(value, "the step of resampling")},
        "interpolation": lambda: {"interpolation": value},
        "remove_offset": lambda: {"remove_offset": tuple(value)},
        "as_declared": lambda: {"as_declared": bool(value)},
    }
    return simple[field]()


def _split(known: Seen, role: str) -> float | None:
    """Time at which a recording is split; at first where most of it is fitted."""
    if role != "split" or known.source.split is not None or known.first is None:
        return known.source.split
    start, end = known.first.time[[0, -1]]
    return float(f"{start + FITTED_SHARE * (end - start):.4g}")


# ---- callbacks -----------------------------------------------------------------------------


def _register(app: Dash, workspace: Workspace) -> None:
    _register_cards(app, workspace)
    _register_edits(app, workspace)
    _register_offers(app, workspace)
    _register_files(app, workspace)


def _register_cards(app: Dash, workspace: Workspace) -> None:
    fields = {"data-field": ALL, "key": ALL, "signal": ALL}

    @app.callback(
        Output("data-cards", "children"),
        Output("data-shown", "data"),
        Output("data-sum", "children"),
        *while_open("data"),
        State(fields, "value"),
        State(fields, "id"),
        State("data-shown", "data"),
    )
    def show(
        stored: Any, opened: str, values: list[Any], ids: list[dict[str, str]], before: Any
    ) -> tuple[Any, Any, Any]:
        if not stored or opened != "data":
            return no_update, no_update, no_update
        session = workspace.open(stored)
        made, form = cards(session)
        here = dict(zip(map(dom_id, ids), values, strict=True))
        now = mark(form.structure)
        if before and before["mark"] == now and here == form.shown:
            # the fields stay, for someone may be typing in one; what is told is told anew
            return no_update, before | {"fields": form.shown}, summary(session)
        return made, {"mark": now, "fields": form.shown, "made": time_ns()}, summary(session)

    @app.callback(
        Output({"data-facts": ALL}, "children"),
        Output({"data-wrong": ALL}, "children"),
        Output({"data-found": ALL}, "children"),
        Output("data-told", "data"),
        Input("data-shown", "data"),
        Input("theme", "data"),
        State("data-told", "data"),
        State("session", "data"),
    )
    def tell(shown: Any, theme: str, before: Any, stored: Any) -> tuple[Any, ...]:
        keys = [output["id"]["data-facts"] for output in ctx.outputs_list[0]]
        if not stored or not shown:
            return *([no_update] * len(keys) for _ in range(3)), no_update
        session = workspace.open(stored)
        sources = {source.key: source for source in session.document.sources}
        marks, parts = {}, []
        for key in keys:
            known = seen(session, sources[key]) if key in sources else None
            part = _facts(known, THEMES[theme]) if known else (no_update,) * 3
            marks[key] = mark([part, shown["made"]]) if known else ""
            parts.append(part if marks[key] != (before or {}).get(key) else (no_update,) * 3)
        columns = zip(*parts, strict=True) if parts else [(), (), ()]
        return *map(list, columns), marks


def _facts(known: Seen, theme: Theme) -> tuple[Any, Any, Any]:
    return facts(known), known.fault(), overview(known, theme)


def _register_edits(app: Dash, workspace: Workspace) -> None:
    @app.callback(
        Output("session", "data", allow_duplicate=True),
        Output({"data-refused": ALL}, "children"),
        Input({"data-field": ALL, "key": ALL, "signal": ALL}, "value"),
        State("data-shown", "data"),
        State("session", "data"),
        prevent_initial_call=True,
    )
    def edit(_values: list[Any], shown: Any, stored: Any) -> tuple[Any, list[Any]]:
        refused: dict[str, Any] = {
            output["id"]["data-refused"]: no_update for output in ctx.outputs_list[1]
        }
        if not stored or not shown:
            return no_update, list(refused.values())
        session = workspace.open(stored)
        changed = False
        for trigger in ctx.triggered:
            # without a place: the last field has gone with its file
            place = ctx.triggered_prop_ids.get(trigger["prop_id"], {})
            key = place.get("key")
            if key not in refused:
                continue
            refused[key] = ""
            # fields that were just made tell what they show, too
            if shown["fields"].get(dom_id(place)) != trigger["value"]:
                sentence = _edit(session, place, trigger["value"])
                refused[key] = sentence
                changed = changed or not sentence
        return session.stored() if changed else no_update, list(refused.values())

    def _edit(session: Session, place: Mapping[str, str], value: Any) -> str:
        """Change a source; why it cannot be, "" where it can."""
        (source,) = (source for source in session.document.sources if source.key == place["key"])
        try:
            new = changes(seen(session, source), place["data-field"], place["signal"], value)
            session.change(lambda document: document.with_source(source.key, **new))
        except MeasurementError as error:
            return f"{error}."
        except ValidationError as error:
            return f"{value} is not allowed here: {error.errors()[0]['msg']}."
        return ""


def _register_offers(app: Dash, workspace: Workspace) -> None:
    @app.callback(
        Output("session", "data", allow_duplicate=True),
        Input({"data-offer": ALL, "index": ALL}, "n_clicks"),
        State("session", "data"),
        prevent_initial_call=True,
    )
    def take(clicks: list[int | None], stored: Any) -> Any:
        if not stored or not any(clicks) or not ctx.triggered[0]["value"]:
            return no_update
        session = workspace.open(stored)
        key, index = ctx.triggered_id["data-offer"], ctx.triggered_id["index"]
        for source in session.document.sources:
            offered = seen(session, source).offers() if source.key == key else ()
            if index < len(offered):
                new = offers.taken(source, offered[index].items)
                session.change(partial(_remapped, key, new))
        return session.stored()


def _remapped(key: str, items: tuple[str, ...], document: Document) -> Document:
    return document.with_source(key, mapping=items)


def _register_files(app: Dash, workspace: Workspace) -> None:
    @app.callback(
        Output("session", "data", allow_duplicate=True),
        Output("data-refusal", "children"),
        Output("data-upload", "contents"),
        Input("data-upload", "contents"),
        State("data-upload", "filename"),
        State("session", "data"),
        prevent_initial_call=True,
    )
    def add(sent: list[str] | None, names: list[str] | None, stored: Any) -> tuple[Any, Any, Any]:
        if not sent or not names or not stored:
            return no_update, no_update, no_update
        session = workspace.open(stored)
        _, refused = add_recordings(workspace, session, sent, names)
        # emptied, so that the same file can be chosen again
        return session.stored(), "; ".join(refused), None

    @app.callback(
        Output("session", "data", allow_duplicate=True),
        Input({"data-remove": ALL}, "n_clicks"),
        State("session", "data"),
        prevent_initial_call=True,
    )
    def remove(clicks: list[int | None], stored: Any) -> Any:
        if not stored or not any(clicks) or not ctx.triggered[0]["value"]:
            return no_update
        session = workspace.open(stored)
        key = ctx.triggered_id["data-remove"]
        session.change(
            lambda document: document.with_sources(
                [source for source in document.sources if source.key != key]
            )
        )
        return session.stored()


def _needs(document: Document, files: Files) -> Sequence[Result[Any]]:
    used = [source for source in document.sources if source.role != "off"]
    return [
        *(results.contents(source, files) for source in document.sources),
        *(results.reading(source, files) for source in document.sources),
        *(beginnings(source, files) for source in document.sources),
        *(results.parts(document, source, files) for source in used),
        *([results.data(document, files)] if used else []),
    ]


STEP = PageStep(
    id="data",
    title="Data",
    layout=_layout,
    register=_register,
    needs=_needs,
    tells_failures=True,
)
