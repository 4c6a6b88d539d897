"""Frequency responses from motor to joint in each slack state, before and after."""

from collections.abc import Mapping, Sequence

import control
import numpy as np
import plotly.graph_objects as go
from plotly.subplots import make_subplots

from elastic_tendon.comparison.residuals import Array
from elastic_tendon.linear.analysis import JOINT_POSITION, analyse, frequencies
from elastic_tendon.linear.drive import MOTOR_POSITION
from elastic_tendon.linear.result import LinearModel
from elastic_tendon.linear.selection import selected
from elastic_tendon.reports.comparison_tables import STATES
from elastic_tendon.reports.interactive.overlay import line_of_run
from elastic_tendon.reports.interactive.theme import LIGHT, Theme, dressed, plain

# by slack state
LinearModels = Mapping[str, LinearModel]


def bode(runs: Sequence[tuple[str, LinearModels]], *, theme: Theme = LIGHT) -> go.Figure:
    """Magnitude and phase of the joint's position by that of the motor.

    Parameters
    ----------
    runs : what each is called, as "as given", and its linear models by slack state "I", "II" or
        "III", driven by the motor's position; states may be absent
    theme : Theme

    Returns
    -------
    plotly.graph_objects.Figure; a column for each state
    """
    states = [state for state in STATES if any(state in models for _, models in runs)]
    figure = make_subplots(
        *(2, len(states)),
        shared_xaxes=True,
        shared_yaxes=True,
        subplot_titles=[f"state {STATES[state]}" for state in states],
        horizontal_spacing=0.03,
        vertical_spacing=0.05,
    )
    # the legend stands above the names of the states
    dressed(figure, theme, height=520, hovermode="x unified", legend={"y": 1.08})
    every = [analyse(model) for _, models in runs for model in models.values()]
    omega = frequencies(every)
    for column, state in enumerate(states, start=1):
        for index, (label, models) in enumerate(runs):
            if state in models:
                style = {
                    "line": line_of_run(index, len(runs), theme),
                    "name": plain(label),
                    "legendgroup": label,
                }
                first = column == 1
                _draw(figure, models[state], omega, column, showlegend=first, **style)
    _label(figure, len(states))
    return figure


def _draw(
    figure: go.Figure, model: LinearModel, omega: Array, column: int, **style: object
) -> None:
    channel = selected(model, (MOTOR_POSITION,), (JOINT_POSITION,))
    response = control.frequency_response(channel, omega)
    magnitude = np.asarray(response.magnitude)
    phase = np.degrees(np.unwrap(np.asarray(response.phase)))
    for row, values, hover in ((1, magnitude, "%{y:.3g}"), (2, phase, "%{y:.0f}°")):
        place = {"row": row, "col": column}
        figure.add_scatter(x=omega, y=values, hovertemplate=hover, mode="lines", **place, **style)
        style = style | {"showlegend": False}


def _label(figure: go.Figure, columns: int) -> None:
    figure.update_xaxes(type="log", dtick=1, exponentformat="power")
    figure.update_yaxes(type="log", dtick=1, exponentformat="power", row=1)
    figure.update_yaxes(dtick=90, row=2)
    figure.update_yaxes(title="joint over motor (rad/rad)", row=1, col=1)
    figure.update_yaxes(title="phase (°)", row=2, col=1)
    for column in range(1, columns + 1):
        figure.update_xaxes(title="angular frequency (rad/s)", row=2, col=column)
