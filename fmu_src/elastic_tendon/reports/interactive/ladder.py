"""The error after each step, falling towards the noise floor."""

from collections.abc import Sequence
from math import ceil, log10
from typing import Any

import plotly.graph_objects as go

from elastic_tendon.estimation.ladder import Step
from elastic_tendon.reports.interactive.theme import LIGHT, Theme, blank, broken, plain
from elastic_tendon.reports.units import number, shown

# of the two labels at a step, that of the larger error stands above its line
_ABOVE, _BELOW = "top right", "bottom left"
FEW_DECADES = 2.5
# letters in a line of a step's name: of more than so many steps, and of fewer
CROWD, FEW, MANY = 2, 12, 20
MOST_LABELS = 8
_ROOM = 0.35  # beside the first and the last step, in steps


def ladder(
    steps: Sequence[Step], signal: str, *, static: bool = False, theme: Theme = LIGHT
) -> go.Figure:
    """RMS error after each step, on fitted and held-out data, beside the noise floor.

    Parameters
    ----------
    steps : entries of the ladder, the model as given first
    signal : name of the signal
    static : the errors are those of static curves
    theme : Theme

    Returns
    -------
    plotly.graph_objects.Figure
    """
    quantity = shown(signal, static=static)
    fitted = [quantity.small * step.rmse[signal] for step in steps]
    held = [quantity.small * step.heldout_rmse[signal] for step in steps if step.heldout_rmse]
    heldout = held if len(held) == len(steps) else []
    floor = quantity.small * _floor(steps, signal)
    scale = _scale([*fitted, *heldout, floor])
    bottom = 10.0 ** scale["range"][0]
    figure = blank(theme, title="Error after each step", height=420, hovermode="x unified")
    lines = [("fitted data", fitted, heldout, theme.after, "circle")]
    if heldout:
        lines.append(("held-out data", heldout, fitted, theme.before, "square"))
    for label, values, others, colour, symbol in lines:
        figure.add_scatter(
            x=list(range(len(steps))),
            y=[max(value, bottom) for value in values],
            name=label,
            mode="lines+markers+text",
            text=[number(value) if value else "0" for value in values],
            textposition=_positions(values, others),
            textfont={"color": colour},
            line={"color": colour, "width": 2},
            marker={"symbol": symbol, "size": 9},
            cliponaxis=False,
            hovertemplate=f"%{{text}} {quantity.small_unit}",
        )
    figure.add_scatter(
        x=[-_ROOM, len(steps) - 1 + _ROOM],
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
    figure.update_yaxes(
        type="log",
        **scale,
        tickformat="~g",
        title=f"RMS error, {quantity.words} ({quantity.small_unit})",
    )
    figure.update_xaxes(
        tickvals=list(range(len(steps))),
        ticktext=[broken(plain(step.title), FEW if len(steps) > CROWD else MANY) for step in steps],
        range=[-_ROOM, len(steps) - 1 + _ROOM],
        showgrid=False,
    )
    return figure


def _positions(values: Sequence[float], others: Sequence[float]) -> list[str]:
    """Where each value stands beside its point, so that two lines do not write over each other."""
    if not others:
        return [_ABOVE] * len(values)
    pairs = zip(values, others, strict=True)
    return [_ABOVE if value >= beside else _BELOW for value, beside in pairs]


def _floor(steps: Sequence[Step], signal: str) -> float:
    """Noise floor of a signal, in its unit; 0 where no step has an error to tell it by."""
    for step in steps:
        if step.noise_ratio[signal] > 0.0:
            return step.rmse[signal] / step.noise_ratio[signal]
    return 0.0


def _scale(values: Sequence[float]) -> dict[str, Any]:
    """Ends of a logarithmic axis, as exponents, and the steps of its labels.

    An error of a simulated recording can be 0; it is drawn at the lower end.
    """
    exponents = [log10(value) for value in values if value > 0.0] or [0.0]
    decades = max(exponents) - min(exponents)
    margin = max(0.15, 0.2 * decades)  # for the labels of the lowest and the highest
    # labels at 1, 2 and 5 of each decade, or at every so many decades
    step = "D2" if decades < FEW_DECADES else ceil(decades / MOST_LABELS)
    return {"range": [min(exponents) - margin, max(exponents) + margin], "dtick": step}
