"""How an effect shows: the same experiments on a machine with it and without it."""

from dataclasses import dataclass

import plotly.graph_objects as go
from plotly.subplots import make_subplots

from elastic_tendon.reports.interactive.theme import LIGHT, Theme, dressed
from elastic_tendon.reports.thinning import path
from elastic_tendon.simulation.signature import HIDDEN, Beside, Signature

DEFLECTION, TIME = "deflection (rad)", "time (s)"


@dataclass(frozen=True)
class _Panel:
    """An experiment with its title and axes; `is_step` has the motor's motion beside it."""

    beside: Beside
    title: str
    across: str
    upward: str
    is_step: bool = False


def signature_figure(
    signature: Signature, *, telling_only: bool = False, theme: Theme = LIGHT
) -> go.Figure:
    """Load over deflection, torque over deflection and a step, with the effect and without.

    Parameters
    ----------
    signature : Signature
    telling_only : the one experiment in which the effect shows most, for narrow places
    theme : Theme

    Returns
    -------
    plotly.graph_objects.Figure
    """
    panels = _panels(signature)
    if telling_only:
        panels = [max(panels, key=lambda panel: panel.beside.difference)]
    titles = [_title(panel) for panel in panels]
    figure = make_subplots(1, len(panels), subplot_titles=titles, horizontal_spacing=0.09)
    dressed(figure, theme, height=260, margin={"t": 54, "b": 44, "l": 56, "r": 11})
    figure.update_layout(legend={"y": 1.12})
    for column, panel in enumerate(panels, start=1):
        _draw(figure, panel, signature, theme, column)
    return figure


def _panels(signature: Signature) -> list[_Panel]:
    torque = "tendon torque (N·m)"
    loading, swinging, stepping = signature.experiments
    return [
        _Panel(signature.slow_loop, loading, DEFLECTION, "load torque (N·m)"),
        _Panel(signature.fast_loop, swinging, DEFLECTION, torque),
        _Panel(signature.step, stepping, TIME, "joint position (rad)", is_step=True),
    ]


def _title(panel: _Panel) -> str:
    hidden = panel.beside.difference < HIDDEN
    return panel.title + ("; hardly any difference" if hidden else "")


def _draw(
    figure: go.Figure, panel: _Panel, signature: Signature, theme: Theme, column: int
) -> None:
    place = {"row": 1, "col": column}
    curves = [
        (panel.beside.without, "without", theme.before, 4.0, "solid"),
        (panel.beside.with_it, "with the effect", theme.after, 1.8, "solid"),
    ]
    if panel.is_step:
        curves.insert(0, (signature.motor, "motor", theme.muted, 1.2, "dash"))
    for curve, label, colour, width, dash in curves:
        across, up = path(curve.x, curve.y)
        figure.add_scatter(
            x=across,
            y=up,
            mode="lines",
            name=label,
            legendgroup=label,
            showlegend=column == 1 or label == "motor",
            line={"color": colour, "width": width, "dash": dash},
            opacity=0.55 if label == "without" else 1.0,
            hoverinfo="skip",
            **place,
        )
    dotted = {"color": theme.muted, "width": 1, "dash": "dot"}
    for boundary in () if panel.is_step else signature.slack_boundaries:
        figure.add_vline(x=boundary, line=dotted, **place)
    if column == 1 and not panel.is_step:  # of lines across a panel the legend knows nothing
        name = "a tendon falls slack"
        figure.add_scatter(x=[None], y=[None], mode="lines", name=name, line=dotted, **place)
    figure.update_xaxes(title=panel.across, **place)
    figure.update_yaxes(title=panel.upward, **place)
