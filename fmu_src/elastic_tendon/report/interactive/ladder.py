"""The error after each step, falling towards the noise floor."""

from collections.abc import Sequence
from math import log10

import plotly.graph_objects as go

from elastic_tendon.identify.ladder import Rung
from elastic_tendon.report.interactive.theme import LIGHT, Theme, blank, broken, plain
from elastic_tendon.report.units import number, shown

# of the two labels at a step, that of the larger error stands above its line
_ABOVE, _BELOW = "top right", "bottom left"
_ROOM = 0.35  # beside the first and the last step, in steps


def ladder(rungs: Sequence[Rung], signal: str, *, theme: Theme = LIGHT) -> go.Figure:
    """RMS error after each step, on fitted and held-out data, beside the noise floor.

    Parameters
    ----------
    rungs : entries of the ladder, the model as given first
    signal : name of the signal
    theme : Theme

    Returns
    -------
    plotly.graph_objects.Figure
    """
    quantity = shown(signal)
    fitted = [quantity.small * one.rmse[signal] for one in rungs]
    held = [quantity.small * one.heldout_rmse[signal] for one in rungs if one.heldout_rmse]
    heldout = held if len(held) == len(rungs) else []
    floor = quantity.small * rungs[0].rmse[signal] / rungs[0].noise_ratio[signal]
    figure = blank(theme, title="Error after each step", height=420, hovermode="x unified")
    lines = [("fitted data", fitted, heldout, theme.after, "circle")]
    if heldout:
        lines.append(("held-out data", heldout, fitted, theme.before, "square"))
    for label, values, others, colour, symbol in lines:
        figure.add_scatter(
            x=list(range(len(rungs))),
            y=values,
            name=label,
            mode="lines+markers+text",
            text=[number(value) for value in values],
            textposition=_positions(values, others),
            textfont={"color": colour},
            line={"color": colour, "width": 2},
            marker={"symbol": symbol, "size": 9},
            cliponaxis=False,
            hovertemplate=f"%{{y:.4g}} {quantity.small_unit}",
        )
    figure.add_scatter(
        x=[-_ROOM, len(rungs) - 1 + _ROOM],
        y=[floor, floor],
        name="noise floor",
        mode="lines+text",
        text=[f"noise floor, {number(floor)} {quantity.small_unit}", ""],
        textposition="top right",
        textfont={"color": theme.muted},
        line={"color": theme.muted, "dash": "dash", "width": 1.5},
        showlegend=False,
        hoverinfo="skip",
    )
    every = [*fitted, *heldout, floor]
    figure.update_yaxes(
        type="log",
        range=_with_room(min(every), max(every)),
        dtick="D2",  # labels at 1, 2 and 5 of each decade
        tickformat="~g",
        title=f"RMS error, {quantity.words} ({quantity.small_unit})",
    )
    figure.update_xaxes(
        tickvals=list(range(len(rungs))),
        ticktext=[broken(plain(one.title)) for one in rungs],
        range=[-_ROOM, len(rungs) - 1 + _ROOM],
        showgrid=False,
    )
    return figure


def _positions(values: Sequence[float], others: Sequence[float]) -> list[str]:
    """Where each value stands beside its point, so that two lines do not write over each other."""
    if not others:
        return [_ABOVE] * len(values)
    pairs = zip(values, others, strict=True)
    return [_ABOVE if one >= other else _BELOW for one, other in pairs]


def _with_room(low: float, high: float) -> list[float]:
    """Ends of a logarithmic axis, as exponents."""
    margin = max(0.15, 0.15 * log10(high / low))
    return [log10(low) - margin, log10(high) + margin]
