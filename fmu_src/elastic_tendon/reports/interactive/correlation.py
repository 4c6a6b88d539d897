"""Correlation of a residual with its own past and with the inputs."""

import numpy as np
import plotly.graph_objects as go

from elastic_tendon.comparison.correlations import Correlation
from elastic_tendon.comparison.locate import FileLocation
from elastic_tendon.reports.interactive.theme import LIGHT, Theme, panels, place_of, plain
from elastic_tendon.reports.names import abridged
from elastic_tendon.reports.residual_tests import BAND, CORRELATION, LAG, partner
from elastic_tendon.reports.thinning import envelope
from elastic_tendon.reports.units import shown

BUCKETS = 400  # of each curve; more than a panel can distinguish
FEW = 100  # values that are drawn as dots, too


def residual_correlation(location: FileLocation, signal: str, *, theme: Theme = LIGHT) -> go.Figure:
    """Correlation of a residual with itself and with each input over the lag, with its bounds.

    Parameters
    ----------
    location : FileLocation of a time series
    signal : name of a compared signal
    theme : Theme

    Returns
    -------
    plotly.graph_objects.Figure; a panel for each correlation
    """
    every = location.correlations[signal]
    name = plain(abridged(location.comparison.measurement.name))
    title = {"text": f"{name}: residual of the {shown(signal).words}"}
    # above the headings of the panels
    figure = panels(theme, len(every), title=title, legend={"y": 1.06})
    for index, correlation in enumerate(every):
        place = place_of(index, len(every))
        _draw_band(figure, correlation, theme, place, first=index == 0)
        _draw_values(figure, correlation, theme, place)
    return figure


def _draw_band(
    figure: go.Figure,
    correlation: Correlation,
    theme: Theme,
    place: dict[str, int],
    *,
    first: bool,
) -> None:
    lag, expected, bound = correlation.lag, correlation.expected, correlation.bound
    figure.add_scatter(
        x=np.concatenate([lag, lag[::-1]]),
        y=np.concatenate([expected - bound, (expected + bound)[::-1]]),
        mode="lines",
        line={"width": 0, "color": theme.muted},
        fill="toself",
        fillcolor=theme.band,
        # the legend names all bands by the first one
        name=BAND if first else f"{BAND}, {partner(correlation)}",
        showlegend=first,
        hoverinfo="skip",
        **place,
    )


def _draw_values(
    figure: go.Figure, correlation: Correlation, theme: Theme, place: dict[str, int]
) -> None:
    across, up = envelope(correlation.lag, correlation.values, BUCKETS)
    words = partner(correlation)
    figure.add_scatter(
        x=across,
        y=up,
        mode="lines+markers" if len(across) <= FEW else "lines",
        line={"color": theme.after, "width": 1.6},
        marker={"size": 4},
        name=words,
        showlegend=False,
        hovertemplate="lag %{x:.4g} s: %{y:.3f}<extra></extra>",
        **place,
    )
    heading = {"text": words, "showarrow": False, "font": {"size": 13, "color": theme.ink}}
    corner = {"x": 0.0, "y": 1.0, "xanchor": "left", "yanchor": "bottom"}
    figure.add_annotation(xref="x domain", yref="y domain", **heading, **corner, **place)
    figure.update_xaxes(title=LAG, **place)
    figure.update_yaxes(title=CORRELATION, zeroline=True, zerolinecolor=theme.muted, **place)
