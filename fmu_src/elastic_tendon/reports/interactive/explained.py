"""What an effect explains: the torque that is missing without it, its own over it, and the rest."""

import numpy as np
import plotly.graph_objects as go
from plotly.subplots import make_subplots

from elastic_tendon.comparison.residuals import Array
from elastic_tendon.diagnosis.explained import Explained, mean_curve
from elastic_tendon.reports.interactive.theme import LIGHT, Theme, blank, plain, upright
from elastic_tendon.reports.thinning import some

DOTS = 1000  # of a cloud; drawing takes long, and more hide each other


def explained(explanation: Explained, title: str, *, theme: Theme = LIGHT) -> go.Figure:
    """Missing torque over what orders it best, without an effect and with it.

    Parameters
    ----------
    explanation : Explained
    title : what it is of; text of users may be in it
    theme : Theme

    Returns
    -------
    plotly.graph_objects.Figure; two panels on the same axes
    """
    own = explanation.modelled_variable, explanation.modelled.torque
    empty = blank(theme, title=plain(title), height=560, legend={"itemsizing": "constant"})
    figure = make_subplots(2, 1, shared_xaxes=True, vertical_spacing=0.06, figure=empty)
    _cloud(
        figure, (explanation.variable, explanation.measured.torque), theme.quiet, "the machine", 1
    )
    _cloud(figure, own, theme.highlight, "the effect", 1)
    _mean(figure, own, theme.stands_out, "the effect, mean", 1)
    left = explanation.remaining_variable, explanation.remaining.torque
    _cloud(figure, left, theme.quiet, None, 2)
    _mean(figure, left, theme.after, "what is left, mean", 2)
    figure.update_yaxes(zeroline=True, zerolinecolor=theme.muted)
    figure.update_yaxes(matches="y", row=2, col=1)
    figure.update_yaxes(title=upright("missing without it (N·m)"), row=1, col=1)
    figure.update_yaxes(title=upright("missing with it (N·m)"), row=2, col=1)
    figure.update_xaxes(
        title=f"{explanation.by.replace('_', ' ')} ({explanation.unit})", row=2, col=1
    )
    return figure


def _cloud(
    figure: go.Figure, cloud: tuple[Array, Array], colour: str, label: str | None, row: int
) -> None:
    kept = some(len(cloud[0]), DOTS)
    horizontal, vertical = (axis[kept].astype(np.float32) for axis in cloud)
    figure.add_scatter(
        x=horizontal,
        y=vertical,
        mode="markers",
        marker={"size": 3, "color": colour},
        name=label,
        showlegend=label is not None,
        hoverinfo="skip",
        row=row,
        col=1,
    )


def _mean(figure: go.Figure, cloud: tuple[Array, Array], colour: str, label: str, row: int) -> None:
    horizontal, vertical = mean_curve(*cloud)
    figure.add_scatter(
        x=horizontal,
        y=vertical,
        mode="lines",
        line={"color": colour, "width": 2.5},
        name=label,
        hovertemplate="%{x:.4g}: %{y:.3g} N·m<extra></extra>",
        row=row,
        col=1,
    )
