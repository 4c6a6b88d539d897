"""Take away: the FMU, the model, the report, linear models, and the data behind what was seen."""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

from dash import ALL, Dash, Input, Output, State, ctx, dcc, html, no_update
from dash.development.base_component import Component
from flask import Response, make_response, send_file

from elastic_tendon.app import busy, results, takeaway
from elastic_tendon.app.document import Document
from elastic_tendon.app.results import Files
from elastic_tendon.app.step import PageStep, while_open
from elastic_tendon.app.takeaway import Built, Depot, FmuChoice, Kind
from elastic_tendon.app.uploads import size_in_words
from elastic_tendon.app.workspace import Failure, Result, Session, Workspace
from elastic_tendon.errors import BuildError, ElasticTendonError
from elastic_tendon.native.compiler import ALL as EVERY_PLATFORM
from elastic_tendon.native.compiler import PLATFORMS, host_platform
from elastic_tendon.progress import Progress

ID = "take_away"
GONE = "This file is no longer there; build it again."

# names of `PLATFORMS` in words
IN_WORDS = {
    "x86_64-linux": "Linux, x86-64",
    "aarch64-linux": "Linux, ARM",
    "x86_64-windows": "Windows, x86-64",
    "x86_64-darwin": "macOS, Intel",
    "aarch64-darwin": "macOS, Apple silicon",
}
PATIENCE = (
    "Binaries for platforms other than this one can take minutes the first time; after that they "
    "are kept."
)


@dataclass(frozen=True)
class Offer:
    """A kind of file on the page: what it is, and what the button says that builds it."""

    kind: Kind
    title: str
    words: str
    button: str


OFFERS = (
    Offer(
        "fmu",
        "FMU",
        "The model as a Functional Mock-up Unit, for co-simulation and model exchange in your "
        "system simulator; it needs no Python.",
        "Build the FMU",
    ),
    Offer(
        "model",
        "Model",
        "All parameters and effects as model.toml, to go on with here or on the command line; "
        "comments at its head say how it came about.",
        "Write the model",
    ),
    Offer(
        "report",
        "Report",
        "All that was compared and found as one page that needs no network and can be printed: "
        "figures, tables, numbers with intervals, and how the data were read.",
        "Write the report",
    ),
    Offer(
        "linear",
        "Linear models",
        "State space, poles, zeros and stiffness in the slack states I, II and III, before and "
        "after: JSON for Python, MAT for MATLAB and Octave, in one archive.",
        "Linearise",
    ),
    Offer(
        "data",
        "Data of the figures",
        "A CSV table of each figure, and of each recording with all samples: time, measured, "
        "simulated and error, with units in the header; in one archive.",
        "Collect the data",
    ),
    Offer(
        "findings",
        "Findings for programs",
        "Errors, estimates and evidence, and how each recording was read, as JSON.",
        "Write the findings",
    ),
)


def _layout() -> Sequence[Component]:
    return [
        busy.store(ID),
        html.P(id=f"{ID}-version"),
        html.P(id=f"{ID}-waits", className="quiet"),
        html.Div(
            [html.Div([_card(offer) for offer in column]) for column in (OFFERS[:2], OFFERS[2:])],
            className="offers",
        ),
    ]


def _card(offer: Offer) -> Component:
    return html.Section(
        [
            html.H3(offer.title),
            html.P(offer.words),
            *(_fmu_options() if offer.kind == "fmu" else ()),
            html.Div(
                [
                    html.Button(offer.button, id={f"{ID}-make": offer.kind}),
                    html.Span(id={f"{ID}-name": offer.kind}, className="quiet"),
                ],
                id={f"{ID}-row": offer.kind},
                className="row",
            ),
            html.Div(id={f"{ID}-offer": offer.kind}, role="status"),
        ],
        className="card",
    )


def _fmu_options() -> Sequence[Component]:
    """Kept by the browser for as long as its tab is open."""
    return [
        _group(
            "Version of FMI",
            dcc.RadioItems(
                options=[{"label": f"{version}.0", "value": version} for version in (2, 3)],
                value=2,
                id=f"{ID}-fmi",
                inline=True,
                persistence=True,
                persistence_type="session",
            ),
        ),
        _group(
            "Platforms it is to run on",
            dcc.Checklist(
                options=_platforms(),
                value=_here(),
                id=f"{ID}-platforms",
                className="two-columns",
                persistence=True,
                persistence_type="session",
            ),
            html.P(PATIENCE, className="quiet"),
        ),
        _group(
            "For other platforms",
            dcc.Checklist(
                options=[{"label": "pack the C source too", "value": "source"}],
                value=[],
                id=f"{ID}-source",
                persistence=True,
                persistence_type="session",
            ),
        ),
    ]


def _group(legend: str, *inside: Component) -> Component:
    return html.Fieldset([html.Legend(legend), *inside])


def _platforms() -> list[dict[str, str]]:
    here = _here()
    named = [
        {"label": IN_WORDS[name] + (" (this one)" if name in here else ""), "value": name}
        for name in PLATFORMS
    ]
    return [*named, {"label": "all of these", "value": EVERY_PLATFORM}]


def _here() -> list[str]:
    """This computer's platform, none where no binary can be built for it."""
    try:
        return [host_platform().name]
    except BuildError:
        return []


def offered(
    document: Document, files: Files, choice: FmuChoice, depot: Depot
) -> Mapping[Kind, Result[Built]]:
    """What can be built of the current version, by kind."""
    return {
        "fmu": takeaway.fmu(document, choice, depot),
        "model": takeaway.model_file(document, files, depot),
        "report": takeaway.report_page(document, files, depot),
        "linear": takeaway.linear(document, depot),
        "data": takeaway.data(document, files, depot),
        "findings": takeaway.findings(document, files, depot),
    }


def choice_of(fmi_version: Any, platforms: Any, source: Any) -> FmuChoice:
    """What the options say."""
    return FmuChoice(3 if fmi_version == 3 else 2, tuple(sorted(platforms or ())), bool(source))


def _shown(session: Session, result: Result[Built], app: Dash) -> Component | str:
    built = session.cache.find(result)
    if built is None:
        return ""
    if isinstance(built, Failure):
        return html.P(built.sentence, className="sentence", role="alert")
    link = html.A(
        f"Download {built.name}",
        href=app.get_relative_path(f"/file/{built.key}"),
        download=built.name,
        className="button",
    )
    return html.Div(
        [link, html.Span(size_in_words(built.size), className="quiet")], className="row"
    )


def build(
    session: Session, kind: Kind, choice: FmuChoice, depot: Depot, progress: Progress
) -> None:
    """Build a file, once it is known which recordings can be used: what was found is found again by
    those that can. An error is shown beside its button, from the cache."""
    for source in session.document.used:
        with suppress(ElasticTendonError):
            session.cache.obtain(results.parts(session.document, source, session.files), progress)
    results.judge_files(session)
    with suppress(ElasticTendonError):
        made = offered(session.document, session.files, choice, depot)[kind]
        session.cache.obtain(made, progress)


def _register(app: Dash, workspace: Workspace) -> None:
    depot = Depot(workspace)
    busy.register(app, ID)
    _register_waiting(app)
    _register_files(app, depot)
    options = (
        (f"{ID}-fmi", "value"),
        (f"{ID}-platforms", "value"),
        (f"{ID}-source", "value"),
    )

    @app.callback(
        Output(f"{ID}-version", "children"),
        Output({f"{ID}-name": ALL}, "children"),
        Output({f"{ID}-offer": ALL}, "children"),
        Output({f"{ID}-row": ALL}, "hidden"),
        *while_open(ID),
        *(Input(*option) for option in options),
    )
    def show(stored: Any, opened: str, *chosen: Any) -> Any:
        if not stored or opened != ID:
            return no_update
        session = workspace.open(stored)
        document = session.document
        results_by_kind = offered(document, session.files, choice_of(*chosen), depot)
        offers = [_shown(session, results_by_kind[offer.kind], app) for offer in OFFERS]
        return (
            f"Of {document.version.loaded().name}: {takeaway.path_of(document)}.",
            [takeaway.file_name(document, offer.kind) for offer in OFFERS],
            offers,
            [isinstance(part, html.Div) for part in offers],  # what is there is not built again
        )

    @app.callback(
        Output("pulse", "data", allow_duplicate=True),
        Output(f"{ID}-waits", "children", allow_duplicate=True),
        Input({f"{ID}-make": ALL}, "n_clicks"),
        State("session", "data"),
        *(State(*option) for option in options),
        prevent_initial_call=True,
    )
    def make(clicks: list[int | None], stored: Any, *chosen: Any) -> Any:
        if not stored or not any(clicks):
            return no_update, no_update
        session = workspace.open(stored)
        kind, choice = ctx.triggered_id[f"{ID}-make"], choice_of(*chosen)
        session.cache.forget_failures()
        words = offered(session.document, session.files, choice, depot)[kind].words
        begun = session.start(ID, words, lambda told: build(session, kind, choice, depot, told))
        return sum(click or 0 for click in clicks), no_update if begun else busy.WORDS


def _register_waiting(app: Dash) -> None:
    @app.callback(
        Output({f"{ID}-make": ALL}, "disabled"),
        Output(f"{ID}-waits", "children"),
        Input(f"{ID}-busy", "data"),
    )
    def wait(waits: bool) -> tuple[list[bool], str]:
        return [waits] * len(OFFERS), busy.WORDS if waits else ""


def _register_files(app: Dash, depot: Depot) -> None:
    """Files go past Dash, so that large ones need not fit into an answer as text."""

    @app.server.get(f"{app.config.url_base_pathname}file/<key>")
    def file(key: str) -> Response:
        built = depot.find(key)
        if built is None:
            return make_response(f"{GONE}\n", 404, {"Content-Type": "text/plain; charset=utf-8"})
        return send_file(
            built.path,
            mimetype="application/octet-stream",
            as_attachment=True,
            download_name=built.name,
        )


def _needs(_document: Document, _files: Files) -> Sequence[Result[Any]]:
    return []


STEP = PageStep(id=ID, title="Take away", layout=_layout, register=_register, needs=_needs)
