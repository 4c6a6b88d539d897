"""Which effect is missing: the ranked list, the page of each, and a try before it is added."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any, cast

from dash import ALL, ClientsideFunction, Dash, Input, Output, State, ctx, dcc, html, no_update
from dash.development.base_component import Component

from elastic_tendon import effects
from elastic_tendon.app import busy, experiment_section, own_effect_section, ranking, results, walk
from elastic_tendon.app.choice import choice
from elastic_tendon.app.document import Document
from elastic_tendon.app.figures import saveable
from elastic_tendon.app.results import Files
from elastic_tendon.app.step import PageStep, while_open
from elastic_tendon.app.tables import Exact, figure_cell, figure_head, scrolling
from elastic_tendon.app.versions import is_static
from elastic_tendon.app.view import compared_now, recordings, view_of
from elastic_tendon.app.workspace import Failure, Result, Session, Workspace
from elastic_tendon.diagnosis.by_hand import decided
from elastic_tendon.diagnosis.result import Candidate, Round
from elastic_tendon.estimation.ladder import Step
from elastic_tendon.reports.diagnosis_tables import (
    NONE,
    called_set,
    candidate_numbers,
    gain,
    none_of_them,
)
from elastic_tendon.reports.effects import effect_sections
from elastic_tendon.reports.first_screen import FirstScreen
from elastic_tendon.reports.interactive.candidates import candidates
from elastic_tendon.reports.interactive.overlay import Run, overlay
from elastic_tendon.reports.interactive.signature import signature_figure
from elastic_tendon.reports.interactive.theme import THEMES
from elastic_tendon.reports.units import evidence_text

TRIED = 340  # height of what was tried, so that the page of the effect is in sight too, pixels
HEAD = 48  # above figures, which have headings of the page, pixels
MEANINGS = (
    "Evidence: beside the model without it; less is better, and a difference of 10 decides. "
    "Gain: share by which the squared error falls; held out: on samples that no fit has seen, "
    "other recordings or one stretch after the other."
)
SO_FAR = "Judged so far; the search goes on. “Take the best so far” below ends it with these."
FIRST_HEAD = "Effect"
HEADS: tuple[str | Exact, ...] = (
    Exact("Probability", "Probability (%)"),
    "Evidence",
    Exact("Gain, fitted", "Gain, fitted (%)"),
    Exact("Gain, held out", "Gain, held out (%)"),
)


# ---- layout --------------------------------------------------------------------------------


def _layout() -> Sequence[Component]:
    return [
        busy.store("effect"),
        html.Div(id="effect-screen", className="verdict", role="status"),
        dcc.Store(id="effect-seen"),  # the round whose suggestion was put forward
        html.Div(
            [
                html.Button(ranking.SEARCH, id="effect-search"),
                html.P(id="effect-search-words", className="quiet"),
            ],
            className="row",
            id="effect-search-row",
        ),
        experiment_section.taken(),
        html.P(id="effect-sentence", className="sentence", role="alert"),
        html.Div(id="effect-tried"),
        html.Div([html.Div(id="effect-list"), _page()], id="effect-columns"),
        experiment_section.section(),
        html.Div(id="effect-evidence"),
        own_effect_section.section(),
    ]


def _page() -> Component:
    return html.Div(
        [
            choice(
                "effect-choice",
                "Effect",
                clearable=False,
                placeholder="read about an effect",
            ),
            html.Div(
                [
                    html.Button("Try", id="effect-try", className="plain"),
                    html.Button("Add", id="effect-add", className="plain"),
                ],
                className="row",
                id="effect-buttons",
                hidden=True,
            ),
            html.P(id="effect-refusal", className="quiet"),
            html.Div(id="effect-tried-words", role="status"),
            html.Div([html.Div(id="effect-shows"), html.Div(id="effect-page")], tabIndex="0"),
        ],
        className="card",
        id="effect-card",
    )


def _list(search_round: Round) -> list[Component]:
    """The ranked list of a round; `decided`, so that nothing is called taken."""
    shown = decided(search_round, None)
    groups = [_group(group) for group in ranking.refitted(shown)]
    last = html.Tr(
        [
            html.Th(NONE, scope="row"),
            figure_cell(_percent(none_of_them(search_round))),
            *(html.Td("-", className="figure") for _ in HEADS[1:]),
        ]
    )
    parts: list[Component] = [
        _table([*groups, html.Tbody(last)]),
        html.P(MEANINGS, className="quiet"),
    ]
    if rest := ranking.unlikely(shown):
        words = f"{len(rest)} more, of which the screen expects too little for a refit"
        body = html.Tbody([row for candidate in rest for row in _rows(candidate)])
        parts.append(html.Details([html.Summary(words), _table([body])]))
    return parts


def _table(bodies: Sequence[Component]) -> Component:
    heads = [html.Th(FIRST_HEAD, scope="col"), *map(figure_head, HEADS)]
    return scrolling(html.Table([html.Thead(html.Tr(heads)), *bodies]))


def _percent(share: float | None) -> str | Exact:
    return gain(share) if share is None else Exact(gain(share), 100.0 * share)


def _group(group: Sequence[Candidate]) -> Component:
    rows = [row for candidate in group for row in _rows(candidate)]
    if len(group) > 1:
        words = "Indistinguishable in these data:"
        rows.insert(0, html.Tr(html.Th(words, colSpan=1 + len(HEADS), scope="rowgroup")))
    return html.Tbody(rows, className="alike" if len(group) > 1 else "")


def _rows(candidate: Candidate) -> list[Component]:
    """The figures of a candidate; below them its numbers, and why it would be taken or not."""
    (effect_id,) = candidate.ids  # a walk by hand goes one effect at a time
    title = html.Button(called_set(candidate), id={"effect-pick": effect_id}, className="link")
    evidence = evidence_text(candidate.evidence)
    figures = (
        _percent(candidate.probability),
        evidence if candidate.evidence is None else Exact(evidence, candidate.evidence),
        _percent(candidate.gain),
        _percent(candidate.heldout_gain),
    )
    cells = map(figure_cell, figures)
    below = [html.Div("; ".join(candidate_numbers(candidate)))]
    if candidate.fitted:  # else all have the same reason
        below.append(html.Div(candidate.reason, className="quiet"))
    return [
        html.Tr([html.Th(title, scope="row"), *cells], className="figures"),
        html.Tr(html.Td(below, colSpan=1 + len(HEADS))),
    ]


# ---- what is in the cache ------------------------------------------------------------------


def _needs(document: Document, files: Files) -> Sequence[Result[Any]]:
    version = document.version
    needed: list[Result[Any]] = [
        results.compared(document, version, files),
        results.climbed(document, files),
    ]
    if walk.was_searched(document, version):
        needed += [make(document, version, files) for make in (walk.ranked, walk.suggested)]
        needed.append(walk.left_open(document, files))
    return needed


def _screen(session: Session) -> FirstScreen | None:
    """What heads the step, None where the error of the version is not known yet."""
    document, files, cache = session.document, session.files, session.cache
    steps, now = cache.find(results.climbed(document, files)), compared_now(session)
    if not isinstance(steps, tuple) or now is None:
        return None
    so_far, ended_early = walk.interim(session), walk.ended_early(session)
    tried = cache.find(walk.suggested(document, document.version, files))
    with_it = so_far.best if so_far else tried if isinstance(tried, Step) else None
    button, _ = ranking.search_words(document, ended_early=ended_early)
    return ranking.screen(
        so_far.round if so_far else walk.round_of(session),
        steps,
        with_it,
        button=button,
        static=is_static(now),
        left_open=walk.left_open_of(session),
        complete=not (so_far or ended_early),
    )


def _tried(session: Session, effect_id: str) -> walk.Tried | None:
    document = session.document
    trial = session.cache.find(walk.tried(document, document.version, effect_id, session.files))
    return trial if isinstance(trial, walk.Tried) else None


# ---- callbacks -----------------------------------------------------------------------------


def _register(app: Dash, workspace: Workspace) -> None:
    busy.register(app, "effect")
    _register_list(app, workspace)
    _register_choice(app, workspace)
    _register_page(app, workspace)
    _register_buttons(app, workspace)
    _register_signature(app, workspace)
    _register_figures(app, workspace)
    _register_evidence(app, workspace)
    _register_work(app, workspace)
    experiment_section.register(app, workspace)
    own_effect_section.register(app, workspace)


def _register_list(app: Dash, workspace: Workspace) -> None:
    @app.callback(
        Output("effect-screen", "children"),
        Output("effect-list", "children"),
        *while_open("effect"),
    )
    def show(stored: Any, opened: str) -> tuple[Any, Any]:
        if not stored or opened != "effect":
            return no_update, no_update
        session = workspace.open(stored)
        first, so_far = _screen(session), walk.interim(session)
        round_shown = so_far.round if so_far else walk.round_of(session)
        going_on = [html.P(SO_FAR, className="quiet")] if so_far else []
        return (
            [html.P(sentence) for sentence in first.sentences] if first else [],
            [*going_on, *_list(round_shown)] if round_shown else [],
        )

    @app.callback(
        Output("effect-search", "children"),
        Output("effect-search", "disabled"),
        Output("effect-search-row", "hidden"),
        Output("effect-search-words", "children"),
        *while_open("effect"),
        Input("effect-busy", "data"),
    )
    def show_search(stored: Any, opened: str, waits: bool) -> tuple[Any, ...]:
        if not stored or opened != "effect":
            return (no_update,) * 4
        session = workspace.open(stored)
        ended_early = walk.ended_early(session)
        name, words = ranking.search_words(session.document, ended_early=ended_early)
        return name, waits, not words, busy.WORDS if waits else words


def _register_choice(app: Dash, workspace: Workspace) -> None:
    @app.callback(
        # at once: a value that is no option yet would be lost
        Output("effect-choice", "options"),
        Output("effect-choice", "value"),
        Output("effect-seen", "data"),
        *while_open("effect"),
        Input({"effect-pick": ALL}, "n_clicks"),
        Input("own-effect-chosen", "data"),
        State("effect-choice", "value"),
        State("effect-seen", "data"),
    )
    def choose(
        stored: Any, opened: str, _picks: Any, own: Any, chosen: str | None, seen: Any
    ) -> tuple[Any, Any, Any]:
        if not stored or opened != "effect":
            return no_update, no_update, no_update
        session = workspace.open(stored)
        options = ranking.choices(session.document)
        if isinstance(ctx.triggered_id, dict):
            pressed = bool(ctx.triggered[0]["value"])  # else the list is new
            picked = ctx.triggered_id["effect-pick"] if pressed else no_update
            return options, picked, no_update
        round_shown = walk.round_of(session)
        now = [session.document.current, round_shown is not None]
        if own and "own-effect-chosen.data" in ctx.triggered_prop_ids:
            return options, own[0], now
        gone = chosen not in (None, *(option["value"] for option in options))
        if now == seen and not gone:
            return options, no_update, no_update
        return options, ranking.first_choice(round_shown), now


def _register_page(app: Dash, workspace: Workspace) -> None:
    @app.callback(
        Output("effect-page", "children"),
        *while_open("effect"),
        Input("effect-choice", "value"),
    )
    def show(stored: Any, opened: str, chosen: str | None) -> Any:
        effect = effects.BY_ID.get(chosen or "")
        if not stored or opened != "effect":
            return no_update
        if effect is None:
            return []
        model = workspace.open(stored).document.version.loaded()
        return [
            part
            for heading, texts in effect_sections(effect, model)
            for part in (html.H3(heading), *map(html.P, texts))
        ]


def _register_buttons(app: Dash, workspace: Workspace) -> None:
    @app.callback(
        Output("effect-buttons", "hidden"),
        Output("effect-try", "children"),
        Output("effect-try", "disabled"),
        Output("effect-add", "children"),
        Output("effect-add", "disabled"),
        Output("effect-add", "className"),
        Output("effect-refusal", "children"),
        *while_open("effect"),
        Input("effect-choice", "value"),
        Input("effect-busy", "data"),
    )
    def show_buttons(stored: Any, opened: str, chosen: str | None, waits: bool) -> tuple[Any, ...]:
        effect = effects.BY_ID.get(chosen or "")
        if not stored or opened != "effect":
            return (no_update,) * 7
        if effect is None:
            return True, "Try", True, "Add", True, "plain", ""
        session = workspace.open(stored)
        round_shown = walk.round_of(session)
        known = round_shown is not None and ranking.known(round_shown, effect.id) is not None
        refused = ranking.refusal(session.document.version.loaded(), effect)
        words = refused or ("" if known else ranking.why_not_tried(round_shown))
        return (
            False,
            f"Try {effect.title}",
            waits or not known or bool(refused),
            f"Add {effect.title}",
            waits or bool(refused),
            "" if round_shown is not None and round_shown.chosen == (effect.id,) else "plain",
            busy.WORDS if waits else words,
        )


def _register_signature(app: Dash, workspace: Workspace) -> None:
    # begun here and shown below: Dash leaves out what would come round to the same callback
    @app.callback(
        Output("pulse", "data", allow_duplicate=True),
        Input("effect-choice", "value"),
        Input("effect-busy", "data"),
        State("open", "data"),
        State("session", "data"),
        prevent_initial_call=True,
    )
    def draw(chosen: str | None, waits: bool, opened: str, stored: Any) -> Any:
        if not stored or opened != "effect" or waits or chosen not in effects.BY_ID:
            return no_update
        session, result = workspace.open(stored), walk.shows(str(chosen))
        if session.cache.find(result) is None and session.compute("effect", result):
            return ["shows", chosen]
        return no_update

    @app.callback(
        Output("effect-shows", "children"),
        *while_open("effect"),
        Input("effect-choice", "value"),
        Input("theme", "data"),
    )
    def show(stored: Any, opened: str, chosen: str | None, theme: str) -> Any:
        if not stored or opened != "effect":
            return no_update
        if chosen not in effects.BY_ID:
            return []
        session = workspace.open(stored)
        signature = session.cache.find(walk.shows(str(chosen)))
        if signature is None or isinstance(signature, Failure):  # the page tells why
            return []
        narrow = walk.round_of(session) is not None  # the ranked list stands beside it
        figure = signature_figure(signature, telling_only=narrow, theme=THEMES[theme])
        return [
            html.H3(f"How {signature.effect.title} shows"),
            saveable(f"signature_of_{signature.effect.id}", figure=figure),
            html.P(ranking.signature_words(signature), className="quiet"),
        ]


def _register_figures(app: Dash, workspace: Workspace) -> None:
    @app.callback(
        Output("effect-tried", "children"),
        Output("effect-tried-words", "children"),
        *while_open("effect"),
        Input("effect-choice", "value"),
        Input("theme", "data"),
        State("compare-view", "data"),
    )
    def show_tried(stored: Any, opened: str, chosen: str, theme: str, view: Any) -> Any:
        if not stored or opened != "effect":
            return no_update, no_update
        session = workspace.open(stored)
        tried = _tried(session, chosen) if chosen in effects.BY_ID else None
        now = compared_now(session)
        last_round = walk.round_of(session)
        if tried is None or now is None or last_round is None:
            return [], []
        seen_view = view_of(view, now)
        runs = [
            Run(title, recordings(compared)[seen_view.recording])
            for title, compared in ((tried.before.title, now), (tried.after.title, tried.compared))
        ]
        figure = overlay(runs, seen_view.signal, theme=THEMES[theme])
        figure.update_layout(title=None, margin={"t": HEAD}, height=TRIED)
        file = runs[0].file.measurement.name
        title = html.H3(f"{file} with {effects.BY_ID[chosen].title}, tried and not added")
        candidate = ranking.known(last_round, chosen)
        assert candidate is not None  # else it could not be tried
        words = [html.P(text) for text in ranking.tried_sentences(tried, candidate)]
        return [title, saveable(f"{Path(file).stem}_with_{chosen}", figure=figure)], words

    app.clientside_callback(
        ClientsideFunction("elastic_tendon_effect", "show"),
        Output("effect-tried", "data-shown"),
        Input("effect-tried", "children"),
        State("effect-try", "n_clicks"),
    )


def _register_evidence(app: Dash, workspace: Workspace) -> None:
    @app.callback(
        Output("effect-evidence", "children"),
        *while_open("effect"),
        Input("theme", "data"),
    )
    def show_evidence(stored: Any, opened: str, theme: str) -> Any:
        if not stored or opened != "effect":
            return no_update
        round_shown = walk.round_of(workspace.open(stored))
        if round_shown is None or not round_shown.candidates:
            return []
        figure = candidates(round_shown, theme=THEMES[theme]).update_layout(margin={"t": HEAD})
        return [
            html.H3("The likeliest beside each other"),
            saveable("candidates", figure=figure),
        ]


def _register_work(app: Dash, workspace: Workspace) -> None:
    pressed = [Input(f"effect-{name}", "n_clicks") for name in ("search", "try", "add", "propose")]

    @app.callback(
        Output("pulse", "data", allow_duplicate=True),
        Output("open", "data", allow_duplicate=True),
        Output("effect-sentence", "children"),
        *pressed,
        State("effect-choice", "value"),
        State("session", "data"),
        prevent_initial_call=True,
    )
    def begin(*given: Any) -> tuple[Any, Any, str]:
        *_, chosen, stored = given
        if not stored or not ctx.triggered[0]["value"]:
            return no_update, no_update, ""
        kind = str(ctx.triggered_id).removeprefix("effect-")
        about = chosen if kind in ("try", "add") else ""
        if not walk.begin(workspace.open(stored), cast(walk.Kind, kind), about):
            return no_update, no_update, busy.WORDS
        return [kind, ctx.triggered[0]["value"]], "add" if kind == "add" else no_update, ""


STEP = PageStep(id="effect", title="Which effect", layout=_layout, register=_register, needs=_needs)
