"""Model: choose one, edit its parameters, see what they make of its characteristic."""

from collections.abc import Mapping, Sequence
from hashlib import sha256
from typing import Any

from dash import ALL, Dash, Input, Output, State, ctx, dcc, get_asset_url, html, no_update
from dash.development.base_component import Component

import elastic_tendon as et
from elastic_tendon.actuator.parameters import model_from_toml
from elastic_tendon.app.choice import choice
from elastic_tendon.app.document import Document, Version
from elastic_tendon.app.figures import saveable
from elastic_tendon.app.numbers import (
    Number,
    edited,
    sections,
    shown,
    unit_in_words,
    with_minus,
)
from elastic_tendon.app.results import Files
from elastic_tendon.app.step import PageStep, dom_id, while_open
from elastic_tendon.app.tables import Exact, copied_unless_edited, scrolling, table
from elastic_tendon.app.upload_field import upload
from elastic_tendon.app.uploads import content_of, size_in_words
from elastic_tendon.app.workspace import Result, Workspace
from elastic_tendon.reports.html.papers import MODEL as PAPER
from elastic_tendon.reports.interactive.characteristic import characteristic
from elastic_tendon.reports.interactive.theme import THEMES, blank

LARGEST = 256 * 1024  # bytes of a model.toml
HEIGHT = 330  # of the figure, pixels
SIGNS = (
    "F_p is the pretension of both tendons at rest; the deflection is q − ʲθ, where ʲθ = θ r / R. "
    "A positive one stretches the lower tendon, and what it exerts on the joint is negative. Slack "
    "is in I the lower tendon, in II the upper one, in III none."
)
NO_SPRINGS = "Without springs there is no characteristic: the load alone moves the link."
MARGIN = {"l": 64, "r": 16, "t": 56, "b": 48}  # of the figure; it has no title
# of the design's table, what changes the machine's feel
SHOWN = (
    "stiffness_state_3",
    "stiffness_state_1",
    "stiffness_state_2",
    "negative_slack_boundary",
    "positive_slack_boundary",
    "negative_max_deflection",
    "positive_max_deflection",
    "negative_max_torque",
    "positive_max_torque",
    "recommended_pretension",
    "frequency_state_3",
)


def _layout() -> Sequence[Component]:
    return [
        html.Div(
            [
                choice(
                    "model-bundled",
                    "Bundled model",
                    options=[],
                    placeholder="choose",
                    className="chooser",
                ),
                html.Button("Take this one", id="model-take", className="plain"),
                upload(
                    "model-upload",
                    f"or your model.toml: choose it, or drop it here ({size_in_words(LARGEST)})",
                    LARGEST,
                    tell="model-refusal",
                ),
            ],
            className="row",
        ),
        html.Div(id="model-refusal", className="sentence", role="alert"),
        # what the fields showed when they were last filled in
        dcc.Store(id="model-shown"),
        html.Div(
            [
                html.Div(
                    [
                        html.Div(
                            [
                                html.Span(id="model-head"),
                                html.Button("Take edits back", id="model-back", className="plain"),
                            ],
                            className="row",
                        ),
                        html.Div(id="model-numbers"),
                    ]
                ),
                html.Div(
                    [
                        _sketch(),
                        saveable("characteristic", id="model-figure", style={"height": HEIGHT}),
                        html.Div(id="model-design"),
                    ],
                    className="beside",
                ),
            ],
            id="model-columns",
        ),
    ]


def _sketch() -> Component:
    drawn = (
        "Motor pulley of radius r on the left, joint pulley of radius R with the link on the right"
    )
    return html.Figure(
        [
            html.Img(src=get_asset_url("actuator.svg"), alt=drawn),
            html.Figcaption(SIGNS, className="quiet small"),
        ],
        id="model-sketch",
    )


# ---- what it shows -------------------------------------------------------------------------


def fields(version: Version, refused: Mapping[str, str]) -> list[Component]:
    """The table of numbers, section by section."""
    columns = ("parameter", "value", "unit", "allowed")
    head = html.Thead(html.Tr([html.Th(title, scope="col") for title in columns]))
    bodies = [
        html.Tbody(
            [
                html.Tr(html.Th(html.H3(section.title), colSpan=len(columns), scope="rowgroup")),
                *(
                    _row(number, section.title, refused.get(number.path, ""))
                    for number in section.numbers
                ),
            ]
        )
        for section in sections(version.loaded(), version.as_loaded())
    ]
    return [scrolling(html.Table([head, *bodies]))]


def _row(number: Number, section: str, refused: str) -> html.Tr:
    field = {"model-value": number.path}
    name: list[Any] = [html.Span(f"{section}: ", className="unseen"), number.words]
    return html.Tr(
        [
            html.Th(
                [
                    html.Label(name, htmlFor=dom_id(field)),
                    html.Div(number.meaning, className="quiet small"),
                ],
                scope="row",
            ),
            html.Td(
                [
                    _field(field, number.text),
                    html.Div(note(number, refused), id={"model-note": number.path}, role="status"),
                ],
                className="value",
                **copied_unless_edited(Exact(number.text, number.value)),
            ),
            html.Td(number.unit),
            html.Td(number.bounds, className="quiet bounds"),
        ]
    )


def _field(field: Mapping[str, str], text: str) -> dcc.Input:
    # of text: a browser would drop what is no number, where it ought to be told
    return dcc.Input(
        id=dict(field),
        value=text,
        type="text",
        autoComplete="off",
        debounce=True,
    )


def note(number: Number, refused: str) -> Any:
    """What stands below a field: why it is refused, or what it was before."""
    if refused:
        return html.Span(refused, className="sentence")
    return (
        html.Span(f"was {number.was} {number.unit}", className="changed") if number.changed else ""
    )


def notes(version: Version, refused: Mapping[str, str]) -> dict[str, Any]:
    """`note` of each number, by its path."""
    return {
        number.path: note(number, refused.get(number.path, ""))
        for section in sections(version.loaded(), version.as_loaded())
        for number in section.numbers
    }


def head(version: Version) -> list[Component | str]:
    """Which model and version this is, and how many parameters were edited."""
    changed = sum(
        number.changed
        for section in sections(version.loaded(), version.as_loaded())
        for number in section.numbers
    )
    parts: list[Component | str] = [html.Strong(f"{version.loaded().name}: {version.title}")]
    if changed:
        parameters = "1 parameter" if changed == 1 else f"{changed} parameters"
        parts.append(f", {parameters} changed")
    return parts


def design_numbers(model: et.Model) -> list[Component]:
    """Warnings of a model, and what its springs come to."""
    proposal = et.design(model)
    rows = proposal.rows()
    effects = (
        [html.P("The curve and these numbers are of the springs alone.", className="quiet")]
        if model.effect_ids
        else []
    )
    return [
        *(html.P(warning, className="sentence") for warning in model.warnings()),
        *effects,
        table(
            ("what the springs come to", "value", "unit", "paper"),
            [
                (
                    row.name,
                    Exact(with_minus(f"{row.value:.4g}"), row.value),
                    unit_in_words(row.unit),
                    row.equation.removesuffix(" corrected"),
                )
                for row in (rows[name] for name in SHOWN)
            ],
        ),
        html.P(f"Paper: {PAPER[1]}.", className="quiet small"),
    ]


def machine(version: Version) -> str:
    """Stays the same while numbers of one model are edited."""
    return sha256((version.given or version.model).encode()).hexdigest()


def showing(version: Version) -> dict[str, Any]:
    """What the fields show of a version: its texts by path, and what tells it from others."""
    texts = {path: shown(value) for path, value in version.loaded().values().items()}
    return {"mark": version.mark, "machine": machine(version), "texts": texts}


# ---- callbacks -----------------------------------------------------------------------------


def _register(app: Dash, workspace: Workspace) -> None:
    _register_numbers(app, workspace)
    _register_back(app, workspace)
    _register_figure(app, workspace)
    _register_choice(app, workspace)


def _register_numbers(app: Dash, workspace: Workspace) -> None:
    @app.callback(
        Output("model-numbers", "children"),
        Output("model-shown", "data"),
        *while_open("model"),
        State("model-shown", "data"),
    )
    def fill(stored: Any, opened: str, filled: Any) -> tuple[Any, Any]:
        if not stored or opened != "model":
            return no_update, no_update
        version = workspace.open(stored).document.version
        now = showing(version)
        # fields that show this already are left alone: someone may be typing in one
        return (no_update, no_update) if filled == now else (fields(version, {}), now)

    @app.callback(
        Output("session", "data", allow_duplicate=True),
        Output("model-shown", "data", allow_duplicate=True),
        Output({"model-note": ALL}, "children"),
        Input({"model-value": ALL}, "value"),
        State({"model-value": ALL}, "id"),
        State("model-shown", "data"),
        State("session", "data"),
        prevent_initial_call=True,
    )
    def edit(
        texts: list[str | None], ids: list[dict[str, str]], filled: Any, stored: Any
    ) -> tuple[Any, Any, list[Any]]:
        places = [output["id"]["model-note"] for output in ctx.outputs_list[2]]
        nothing = no_update, no_update, [no_update] * len(places)
        if not stored or not filled:
            return nothing
        session = workspace.open(stored)
        if machine(session.document.version) != filled["machine"]:
            return nothing  # the fields are of another model, and are about to be replaced
        held = {place["model-value"]: (text or "") for place, text in zip(ids, texts, strict=True)}
        # what a field was filled with is no edit: the model may have been changed since
        typed = {path: text for path, text in held.items() if text != filled["texts"].get(path)}

        def take(document: Document) -> Document:
            model, _ = edited(document.version.loaded(), typed)
            same = model.to_toml() == document.version.model
            return document if same else document.edited(model)

        changed = take(session.document) is not session.document
        version = (session.change(take) if changed else session.document).version
        model, refused = edited(version.loaded(), typed)
        below = notes(version, refused)
        # else they are about to be replaced
        alike = edited(model, held)[0] == model
        return (
            session.stored() if changed else no_update,
            showing(version) if alike else no_update,
            [below.get(place, "") for place in places],
        )


def _register_back(app: Dash, workspace: Workspace) -> None:
    @app.callback(
        Output("session", "data", allow_duplicate=True),
        Input("model-back", "n_clicks"),
        State("session", "data"),
        prevent_initial_call=True,
    )
    def take_back(clicks: int | None, stored: Any) -> Any:
        if not clicks or not stored:
            return no_update
        session = workspace.open(stored)
        session.change(lambda document: document.edited(document.version.as_loaded()))
        return session.stored()


def _register_figure(app: Dash, workspace: Workspace) -> None:
    @app.callback(
        Output("model-head", "children"),
        Output("model-back", "hidden"),
        Output("model-figure", "figure"),
        Output("model-design", "children"),
        *while_open("model"),
        Input("theme", "data"),
    )
    def draw(stored: Any, opened: str, theme: str) -> tuple[Any, Any, Any, Any]:
        if not stored or opened != "model":
            return no_update, no_update, no_update, no_update
        version = workspace.open(stored).document.version
        model = version.loaded()
        if not model.kind.has_springs:
            return head(version), not version.given, blank(THEMES[theme]), NO_SPRINGS
        figure = characteristic(
            model,
            given=version.as_loaded() if version.given else None,
            theme=THEMES[theme],
            height=HEIGHT,
            margin=MARGIN,
        )
        return head(version), not version.given, figure, design_numbers(model)


def _register_choice(app: Dash, workspace: Workspace) -> None:
    @app.callback(Output("model-bundled", "options"), Input("open", "data"))
    def offer(_opened: str) -> list[str]:
        return list(et.models)

    @app.callback(
        Output("session", "data", allow_duplicate=True),
        Output("model-refusal", "children"),
        Output("model-upload", "contents"),
        Input("model-take", "n_clicks"),
        Input("model-upload", "contents"),
        State("model-upload", "filename"),
        State("model-bundled", "value"),
        State("session", "data"),
        prevent_initial_call=True,
    )
    def choose(
        _clicks: int | None,
        sent: list[str] | None,
        names: list[str] | None,
        bundled: str | None,
        stored: Any,
    ) -> tuple[Any, Any, Any]:
        try:
            model = _chosen(sent if ctx.triggered_id == "model-upload" else None, names, bundled)
        except et.ModelError as error:
            return no_update, refusal(error.problems, error.source), None
        except et.ElasticTendonError as error:
            return no_update, refusal([str(error)]), None
        if not stored or (ctx.triggered_id == "model-upload" and sent is None):
            return no_update, no_update, no_update
        if model is None:
            return no_update, refusal(["choose one of the bundled models first"]), no_update
        session = workspace.open(stored)
        session.change(lambda document: document.with_model(model))
        return session.stored(), "", None  # so that the same file can be chosen again


def _chosen(
    sent: list[str] | None, names: list[str] | None, bundled: str | None
) -> et.Model | None:
    """The model of an upload, else the bundled one that was chosen; None where there is none."""
    if sent and names:
        if len(sent) > 1:
            raise et.ElasticTendonError(
                f"{len(sent)} files are one too many; choose one model.toml"
            )
        return model_from_toml(content_of(sent[0], names[0], LARGEST), names[0])
    return et.load_model(bundled) if bundled and bundled in et.models else None


def refusal(problems: Sequence[str], source: str = "") -> Any:
    """Why a model is refused, all at once."""
    if len(problems) == 1:
        return ": ".join(filter(None, [source, problems[0]]))
    return [
        f"{source}: {len(problems)} things keep it from being used:",
        html.Ul([html.Li(problem) for problem in problems]),
    ]


def _needs(_document: Document, _files: Files) -> Sequence[Result[Any]]:
    return []


STEP = PageStep(id="model", title="Model", layout=_layout, register=_register, needs=_needs)
