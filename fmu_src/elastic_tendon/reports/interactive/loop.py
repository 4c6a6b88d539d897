"""Torque of the tendons over their deflection, by slack state."""

from typing import Any

import numpy as np
import plotly.graph_objects as go
from numpy.typing import NDArray

from elastic_tendon.actuator.parameters import Model
from elastic_tendon.actuator.transmission import SlackState
from elastic_tendon.comparison.comparison import FileComparison
from elastic_tendon.comparison.locate import FileLocation
from elastic_tendon.measurement import Measurement
from elastic_tendon.reports.comparison_figures import FAINT
from elastic_tendon.reports.comparison_tables import STATES
from elastic_tendon.reports.interactive.theme import LIGHT, Theme, blank, plain
from elastic_tendon.reports.loops import (
    MEASURED,
    Springs,
    measured_deflection,
    measured_loop,
    springs_over,
    torque_source,
)
from elastic_tendon.reports.names import abridged
from elastic_tendon.reports.thinning import path, some, within

DOTS = 4000  # of all states together; the browser draws each by itself
LABELS = {
    SlackState.I: STATES["I"],
    SlackState.II: STATES["II"],
    SlackState.III: STATES["III"],
    SlackState.BOTH: "both slack",
}
SYMBOLS = ("triangle-down", "triangle-up", "circle", "x")  # so that states differ in more than hue


def torque_loop(
    model: Model,
    file: FileComparison,
    location: FileLocation,
    *,
    theme: Theme = LIGHT,
    window: tuple[float, float] | None = None,
    dots: int = DOTS,
) -> go.Figure:
    """Torque of the tendons over deflection, coloured by slack state, with the model's own.

    Samples that are not selected are drawn faint.

    Parameters
    ----------
    model : Model
    file : FileComparison
    location : FileLocation of the same recording
    theme : Theme
    window : start and end, s; only what was measured and simulated between them is drawn
    dots : at most, of all states together

    Returns
    -------
    plotly.graph_objects.Figure
    """
    kept = within(file.measurement.time, window)
    deflection, torque = measured_loop(model, file, location, kept)
    time = file.measurement.time[kept]
    springs = springs_over(model, measured_deflection(model, file, location))
    torque_is = "measured" if torque_source(file.measurement) == MEASURED else "estimated"
    figure = blank(
        theme,
        title={"text": f"{plain(abridged(file.measurement.name))}: torque over deflection"},
        uirevision=file.measurement.name,
        xaxis={"title": {"text": "deflection as measured (rad)"}, "range": list(springs.ends)},
        yaxis={"title": {"text": f"{torque_is} torque (N·m)"}},
        legend={"itemsizing": "constant"},
    )
    selected = np.ones(len(time), np.bool_)
    if file.selection is not None:
        selected = file.selection.chosen[kept]
    opacity, some_faint = np.where(selected, 1.0, FAINT), not selected.all()
    states = np.round(location.variables["slack_state"][kept])
    share = dots / max(len(time), dots)
    for (state, label), colour, symbol in zip(LABELS.items(), theme.states, SYMBOLS, strict=True):
        chosen = np.flatnonzero(states == state)
        chosen = chosen[some(len(chosen), int(np.ceil(share * len(chosen))))]
        if len(chosen):
            figure.add_scatter(
                x=deflection[chosen],
                y=torque[chosen],
                mode="markers",
                name=label,
                marker={"color": colour, "size": 4, "symbol": symbol}
                | ({"opacity": opacity[chosen]} if some_faint else {}),
                customdata=time[chosen],
                hovertemplate="%{x:.4g} rad, %{y:.4g} N·m at %{customdata:.4f} s",
            )
    # upon the dots, which would hide it, and upon the springs, which it may well follow
    _draw_springs(figure, springs, theme)
    if some_faint:
        every = np.ones_like(selected)
        _draw_simulated(figure, file, kept, every, theme, opacity=FAINT, showlegend=False)
    _draw_simulated(figure, file, kept, selected, theme)
    return figure


def torque_words(measurement: Measurement) -> str:
    """What the torque of `torque_loop` is, in a sentence."""
    if torque_source(measurement) == MEASURED:
        return "The torque is the measured one."
    return (
        "No torque was measured: each point is the torque of the model's springs at the measured "
        "deflection plus the missing torque, which the recorded motion calls for."
    )


def _draw_simulated(
    figure: go.Figure,
    file: FileComparison,
    kept: slice,
    drawn: NDArray[np.bool_],
    theme: Theme,
    **style: Any,
) -> None:
    deflection, torque = file.trajectory["deflection"], file.trajectory["joint_torque"]
    across, up = path(deflection[kept], torque[kept], drawn=drawn)
    figure.add_scatter(
        x=across,
        y=up,
        mode="lines",
        name="simulated",
        line={"color": theme.quiet, "width": 1.0},
        hoverinfo="skip",
        **style,
    )


def _draw_springs(figure: go.Figure, springs: Springs, theme: Theme) -> None:
    figure.add_scatter(
        x=springs.deflection,
        y=springs.torque,
        mode="lines",
        name="model's springs, static",
        line={"color": theme.measured, "width": 2.4},
        hovertemplate="%{x:.4g} rad, %{y:.4g} N·m",
    )
    style: dict[str, Any] = {"line": {"color": theme.ink, "dash": "dot", "width": 1.4}}
    for index, boundary in enumerate(springs.boundaries):
        figure.add_shape(
            type="line",
            x0=boundary,
            x1=boundary,
            y0=0.0,
            y1=1.0,
            yref="y domain",
            name="slack boundary, paper (14)",
            legendgroup="boundaries",
            showlegend=index == 0,
            **style,
        )
