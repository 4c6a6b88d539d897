"""Candidates of a round beside each other: how likely each is, and what it gains."""

from collections.abc import Sequence

import plotly.graph_objects as go
from plotly.subplots import make_subplots

from elastic_tendon.diagnosis.result import Candidate, Round
from elastic_tendon.reports.diagnosis_tables import (
    NONE,
    SMALLEST,
    called_set,
    none_of_them,
    percent,
)
from elastic_tendon.reports.interactive.theme import LIGHT, Theme, blank, broken, plain

HEAD, BAR, TEXT = 140, 34, 23  # heights of all but the bars, of a bar, of a line of text, pixels
BARS = 8  # candidates of a round that are drawn
LINE = 26  # letters of a candidate's name in one line; three effects have long names
WORST = -100.0  # %; a candidate that ruins held-out data would hide all others
_KINDS = (("gain", "on fitted data"), ("heldout_gain", "held out"))


def candidates(candidate_round: Round, *, theme: Theme = LIGHT) -> go.Figure:
    """Probability and gains of the likeliest candidates of a round.

    Parameters
    ----------
    candidate_round : Round with candidates
    theme : Theme

    Returns
    -------
    plotly.graph_objects.Figure; two panels that share the candidates, one where none gains anything
    """
    drawn = candidate_round.candidates[:BARS]
    names = [broken(plain(called_set(candidate)), LINE) for candidate in drawn]
    lines = 1 + max((name.count("<br>") for name in names), default=0)
    taken = [candidate.ids == candidate_round.chosen for candidate in drawn]
    colours = [theme.ink if chosen else theme.quiet for chosen in taken]
    likely = [100.0 * candidate.probability for candidate in drawn]
    likely.append(100.0 * none_of_them(candidate_round))
    height = HEAD + max(BAR, TEXT * lines) * (len(drawn) + 1)
    empty = blank(theme, height=height, barmode="group", bargap=0.3)
    gaining = any(map(_gains, drawn))
    columns = 2 if gaining else 1
    figure = make_subplots(1, columns, shared_yaxes=True, horizontal_spacing=0.04, figure=empty)
    figure.add_bar(
        x=likely,
        y=[*names, NONE],
        orientation="h",
        marker={"color": [*colours, theme.quiet]},
        text=[percent(0.01 * value) for value in likely],
        textposition="outside",
        cliponaxis=False,
        showlegend=False,
        hovertemplate="%{y}: %{x:.3g} %<extra></extra>",
        row=1,
        col=1,
    )
    kinds = zip(_KINDS, (theme.after, theme.before), strict=True) if gaining else ()
    for (kind, label), colour in kinds:
        gains = [getattr(candidate, kind) for candidate in drawn]
        if all(gain is None for gain in gains):
            continue
        figure.add_bar(
            x=[None if gain is None else max(100.0 * gain, WORST) for gain in gains],
            y=names,
            orientation="h",
            marker={"color": colour},
            name=label,
            hovertemplate="%{y}: %{x:.3g} %<extra>" + label + "</extra>",
            row=1,
            col=2,
        )
    figure.update_xaxes(
        title="probability (%)", range=[0, 125], tickvals=[0, 25, 50, 75, 100], row=1, col=1
    )
    if gaining:
        figure.update_xaxes(title="squared error explained (%)", range=_span(drawn), row=1, col=2)
    figure.update_xaxes(zeroline=True, zerolinecolor=theme.muted)
    figure.update_yaxes(autorange="reversed", showgrid=False)
    return figure


def _gains(candidate: Candidate) -> bool:
    """Whether a candidate has a gain to be drawn: from a refit, or one that can be seen."""
    return candidate.heldout_gain is not None or abs(candidate.gain or 0.0) >= SMALLEST


def _span(drawn: Sequence[Candidate]) -> list[float]:
    """Range of the axis of gains, %; a percent or so, where nothing explains even that."""
    gains = [
        gain
        for candidate in drawn
        for gain in (candidate.gain, candidate.heldout_gain)
        if gain is not None
    ]
    low = max(100.0 * min(gains, default=0.0), WORST)
    high = 100.0 * max(gains, default=0.0)
    return [min(0.0, 1.05 * low), max(1.0, 1.05 * high)]
