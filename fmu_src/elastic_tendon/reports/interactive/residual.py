"""The error of one model alone, large enough to be seen beside the noise."""

import plotly.graph_objects as go

from elastic_tendon.reports.interactive.overlay import Run
from elastic_tendon.reports.interactive.theme import LIGHT, Theme, blank, noise_band, plain
from elastic_tendon.reports.thinning import envelope
from elastic_tendon.reports.units import shown


def residual(run: Run, signal: str, *, theme: Theme = LIGHT) -> go.Figure:
    """Error of one signal over time, of a static curve over deflection, with the noise behind it.

    Parameters
    ----------
    run : Run
    signal : name of the signal
    theme : Theme

    Returns
    -------
    plotly.graph_objects.Figure
    """
    measurement = run.file.measurement
    quantity = shown(signal, static=measurement.static)
    figure = blank(theme, height=300)
    error = quantity.small * run.error(signal)
    if measurement.static:
        style = {"x": measurement.signals[signal], "y": error, "mode": "markers"}
    else:
        across, up = envelope(measurement.time, error)
        style = {"x": across, "y": up, "mode": "lines"}
    figure.add_scatter(
        **style,
        name=f"error, {plain(run.label)}",
        line={"color": theme.after, "width": 1},
        showlegend=True,
        hovertemplate=f"%{{y:.3g}} {quantity.small_unit}<extra></extra>",
    )
    figure.add_hrect(**noise_band(quantity.small * run.file.signals[signal].noise.sigma, theme))
    figure.update_yaxes(title=f"error ({quantity.small_unit})")
    figure.update_xaxes(title="deflection (rad)" if measurement.static else "time (s)")
    return figure
