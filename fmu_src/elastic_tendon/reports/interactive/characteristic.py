"""The static characteristic of a model's springs, with the deflections where a tendon slackens."""

from typing import Any

import numpy as np
import plotly.graph_objects as go
from numpy.typing import NDArray

from elastic_tendon.actuator.design import CharacteristicCurve, characteristic_curves
from elastic_tendon.actuator.motion_kind import MotionKind
from elastic_tendon.actuator.parameters import Model
from elastic_tendon.actuator.transmission import SlackState
from elastic_tendon.reports.interactive.theme import LIGHT, Theme, blank, broken

MARGIN = 0.07  # on each side of the curves, share of their range
TINT = 0.13  # opacity of what lies behind a slack state
WIDE = 0.19  # share of the deflections; a slack state that takes less has no room for its words


def characteristic(
    model: Model, *, given: Model | None = None, theme: Theme = LIGHT, **layout: Any
) -> go.Figure:
    """Torque on the joint over its deflection at rest; the model's effects do not take part.

    Parameters
    ----------
    model : Model
    given : the model before its numbers were changed; drawn dashed where its curve differs
    theme : Theme
    layout : as of `plotly.graph_objects.Layout`

    Returns
    -------
    plotly.graph_objects.Figure
    """
    curve = _curve(model)
    figure = blank(
        theme,
        xaxis={"title": {"text": "joint deflection q − ʲθ (rad)"}, "zeroline": True},
        yaxis={"title": {"text": "torque on the joint (N·m)"}, "zeroline": True},
        **layout,
    )
    _draw_states(figure, curve, theme)
    before = curve if given is None else _curve(given)
    if not _alike(before, curve):
        dashed = {"color": theme.before, "width": 1.6, "dash": "4px,2px"}
        _draw_line(figure, before, "as loaded", dashed)
    _draw_line(figure, curve, "now", {"color": theme.after, "width": 2.6})
    _draw_marks(figure, curve, theme)
    figure.update_xaxes(range=_with_margin(before.deflection, curve.deflection))
    figure.update_yaxes(range=_with_margin(before.torque, curve.torque))
    return figure


def _with_margin(*drawn: NDArray[np.float64]) -> list[float]:
    """Ends of an axis; by itself plotly lets lines without marks run into the edge."""
    low, high = min(map(np.min, drawn)), max(map(np.max, drawn))
    margin = MARGIN * (high - low)
    return [float(low - margin), float(high + margin)]


def _curve(model: Model) -> CharacteristicCurve:
    (curve,) = characteristic_curves(model, [model.transmission.pretension_force])
    return curve


def _alike(first: CharacteristicCurve, second: CharacteristicCurve) -> bool:
    return np.array_equal(first.deflection, second.deflection) and np.array_equal(
        first.torque, second.torque
    )


def _draw_states(figure: go.Figure, curve: CharacteristicCurve, theme: Theme) -> None:
    """Shade where each slack state holds; above (30) no tendon slackens within the limits."""
    low, high = curve.deflection[[0, -1]]
    start, end = curve.slack_boundaries
    start = low if np.isnan(start) else start
    end = high if np.isnan(end) else end
    parts = ((low, start, SlackState.I), (start, end, SlackState.III), (end, high, SlackState.II))
    for left, right, state in parts:
        if right <= left:
            continue
        figure.add_vrect(
            x0=left,
            x1=right,
            fillcolor=theme.states[state - 1],
            opacity=TINT,
            line_width=0,
            layer="below",
        )
        figure.add_annotation(
            x=0.5 * (left + right),
            # beside the curve, which falls everywhere
            y=0.0 if state is SlackState.I else 1.0,
            yref="paper",
            yanchor="bottom" if state is SlackState.I else "top",
            text=_name_of(state, (right - left) / (high - low)),
            hovertext=state.label,
            font={"size": 11},
            showarrow=False,
        )


def _name_of(state: SlackState, share: float) -> str:
    """The paper's numeral, with words in lines below it where there is room."""
    return broken(state.label, 13) if share >= WIDE else state.name


def _draw_line(
    figure: go.Figure, curve: CharacteristicCurve, name: str, line: dict[str, Any]
) -> None:
    figure.add_scatter(
        x=curve.deflection,
        y=curve.torque,
        customdata=np.degrees(curve.deflection),
        mode="lines",
        name=name,
        line=line,
        hovertemplate=_hover(curve),
    )


def _hover(curve: CharacteristicCurve) -> str:
    degrees = ", %{customdata:.3g}°" if curve.motion is MotionKind.ROTARY else ""
    return f"%{{x:.4g}} rad{degrees}: %{{y:.4g}} N·m<extra></extra>"


def _draw_marks(figure: go.Figure, curve: CharacteristicCurve, theme: Theme) -> None:
    ends = [0, -1]
    circle = {"symbol": "circle-open", "size": 10, "line": {"width": 2}, "color": theme.ink}
    upright = {"symbol": "line-ns-open", "size": 14, "line": {"width": 2.5}, "color": theme.ink}
    marks = (
        ("slack boundary (14)", curve.slack_boundaries, curve.boundary_torques, circle),
        ("largest deflection (16)", curve.deflection[ends], curve.torque[ends], upright),
    )
    for name, deflection, torque, marker in marks:
        kept = np.isfinite(deflection)
        if kept.any():
            figure.add_scatter(
                x=deflection[kept],
                y=torque[kept],
                customdata=np.degrees(deflection[kept]),
                mode="markers",
                name=name,
                marker=marker,
                hovertemplate=_hover(curve),
            )
