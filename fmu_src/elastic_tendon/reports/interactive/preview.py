"""A recording at a glance: its angles over time and its torques below."""

from typing import Any

import plotly.graph_objects as go
from plotly.subplots import make_subplots

from elastic_tendon.measurement import Measurement
from elastic_tendon.reports.comparison_figures import static_torque
from elastic_tendon.reports.interactive.theme import LIGHT, Theme, blank, dressed
from elastic_tendon.reports.thinning import envelope

BUCKETS = 400  # a small figure has fewer pixels across than twice as many
ANGLES = ("motor_position", "joint_position")
TORQUES = ("load_torque", "joint_torque", "motor_torque")


def preview(
    measurement: Measurement, *, split: float | None = None, theme: Theme = LIGHT, **layout: Any
) -> go.Figure:
    """Signals of a recording as they were read, thinned.

    Parameters
    ----------
    measurement : Measurement
    split : s; where what is fitted ends, None where nothing does
    theme : Theme
    layout : as of `plotly.graph_objects.Layout`

    Returns
    -------
    plotly.graph_objects.Figure; of a static curve torque over deflection
    """
    if measurement.static:
        return _static(measurement, theme, layout)
    held = measurement.inputs | dict(measurement.signals)
    torques = [name for name in TORQUES if name in held]
    heights = [0.62, 0.38] if torques else [1.0]
    rows = make_subplots(len(heights), 1, shared_xaxes=True, row_heights=heights)
    figure = dressed(rows, theme, **layout)
    colours = (theme.measured, theme.after, theme.before)
    for row, (names, unit) in enumerate(((ANGLES, "rad"), (torques, "N·m")), start=1):
        present = [name for name in names if name in held]
        for name, colour in zip(present, colours, strict=False):
            time, values = envelope(measurement.time, held[name], BUCKETS)
            words = name.replace("_", " ")
            dash = "4px,2px" if name.startswith("motor") else "solid"
            figure.add_scatter(
                x=time,
                y=values,
                mode="lines",
                name=words,
                line={"color": colour, "width": 1.3, "dash": dash},
                hovertemplate=f"{words}: %{{y:.4g}} {unit}<extra></extra>",
                row=row,
                col=1,
            )
        if present:
            figure.update_yaxes(title_text=unit, row=row, col=1)
    figure.update_xaxes(title_text="time (s)", row=len(heights), col=1)
    if split is not None:
        figure.add_vline(x=split, line={"color": theme.ink, "width": 1.5, "dash": "dot"})
    return figure


def _static(measurement: Measurement, theme: Theme, layout: dict[str, Any]) -> go.Figure:
    figure = blank(
        theme,
        xaxis={"title": {"text": "deflection (rad)"}},
        yaxis={"title": {"text": "joint torque (N·m)"}},
        **layout,
    )
    figure.add_scatter(
        x=measurement.signals["joint_position"],
        y=static_torque(measurement),
        mode="markers",
        name="measured",
        marker={"color": theme.measured, "size": 4},
        hovertemplate="%{x:.4g} rad: %{y:.4g} N·m<extra></extra>",
    )
    return figure
