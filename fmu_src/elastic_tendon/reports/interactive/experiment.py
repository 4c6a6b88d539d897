"""The experiment to run next."""

import numpy as np
import plotly.graph_objects as go
from plotly.subplots import make_subplots

from elastic_tendon.diagnosis.result import Experiment
from elastic_tendon.reports.interactive.theme import LIGHT, Theme, blank
from elastic_tendon.reports.thinning import envelope


def experiment(proposed: Experiment, *, theme: Theme = LIGHT) -> go.Figure:
    """Motor motion, and the load where one is to act, over time."""
    rows = [("motor position (rad)", proposed.motor_position, theme.after)]
    if np.any(proposed.load_torque):
        rows.append(("load torque (N·m)", proposed.load_torque, theme.before))
    title = "The experiment to run next" + ("" if len(rows) > 1 else ", without load")
    empty = blank(theme, title=title, height=130 + 190 * len(rows))
    figure = make_subplots(len(rows), 1, shared_xaxes=True, vertical_spacing=0.06, figure=empty)
    for row, (label, values, colour) in enumerate(rows, start=1):
        time, thinned = envelope(proposed.time, values)
        figure.add_scatter(
            x=time,
            y=thinned,
            mode="lines",
            line={"color": colour, "width": 1.5},
            showlegend=False,
            hovertemplate="%{x:.4g} s: %{y:.4g}<extra></extra>",
            row=row,
            col=1,
        )
        figure.update_yaxes(title=label, row=row, col=1)
    figure.update_xaxes(title="time (s)", row=len(rows), col=1)
    return figure
