"""The missing torque over what orders it."""

import numpy as np
import plotly.graph_objects as go

from elastic_tendon.comparison.comparison import FileComparison
from elastic_tendon.comparison.locate import FileLocation
from elastic_tendon.comparison.missing_torque import TorqueCurve
from elastic_tendon.comparison.residuals import Array
from elastic_tendon.reports.interactive.theme import LIGHT, Theme, panels, place_of, plain, upright
from elastic_tendon.reports.names import abridged
from elastic_tendon.reports.thinning import some

DOTS = 1000  # in each panel; the browser draws each by itself
LABELS = ("each sample", "95 % interval of the mean", "mean")


def missing_torque(
    file: FileComparison, location: FileLocation, *, theme: Theme = LIGHT
) -> go.Figure:
    """Missing torque over time and against each variable, with its 95 % band.

    Parameters
    ----------
    file : FileComparison
    location : FileLocation of the same recording
    theme : Theme

    Returns
    -------
    plotly.graph_objects.Figure; a panel for each variable
    """
    missing = location.missing_torque
    chosen = some(len(missing.torque), DOTS)
    name = plain(abridged(file.measurement.name))
    curves = missing.curves
    title = {"text": f"{name}: missing torque on the joint"}
    figure = panels(theme, len(curves), title=title, legend={"itemsizing": "constant"})
    for index, curve in enumerate(curves):
        cloud = None
        if curve.by in location.variables:
            cloud = location.variables[curve.by][chosen], missing.torque[chosen]
        _draw_curve(figure, curve, cloud, theme, place_of(index, len(curves)), first=index == 0)
    return figure


def _draw_curve(
    figure: go.Figure,
    curve: TorqueCurve,
    cloud: tuple[Array, Array] | None,
    theme: Theme,
    place: dict[str, int],
    *,
    first: bool,
) -> None:
    dots, band, mean = ({"name": label, "legendgroup": label, **place} for label in LABELS)
    if cloud is not None:
        figure.add_scatter(
            x=cloud[0],
            y=cloud[1],
            mode="markers",
            marker={"color": theme.quiet, "size": 2.5},
            hoverinfo="skip",
            showlegend=first,
            **dots,
        )
    figure.add_scatter(
        x=np.concatenate([curve.centre, curve.centre[::-1]]),
        y=np.concatenate([curve.low, curve.high[::-1]]),
        mode="lines",
        line={"width": 0, "color": theme.after},
        fill="toself",
        hoverinfo="skip",
        showlegend=first,
        **band,
    )
    figure.add_scatter(
        x=curve.centre,
        y=curve.mean,
        mode="lines+markers",
        line={"color": theme.after, "width": 1.6},
        marker={"size": 5},
        hovertemplate=f"%{{x:.4g}} {curve.unit}: %{{y:.3g}} N·m<extra></extra>",
        showlegend=first,
        **mean,
    )
    figure.update_xaxes(title=f"{curve.by.replace('_', ' ')} ({curve.unit})", **place)
    figure.update_yaxes(
        title=upright("missing torque (N·m)"),
        zeroline=True,
        zerolinecolor=theme.muted,
        **place,
    )
