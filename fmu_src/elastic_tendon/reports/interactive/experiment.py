"""The experiment to run next."""

import plotly.graph_objects as go
from plotly.subplots import make_subplots

from elastic_tendon.diagnosis.result import Experiment
from elastic_tendon.reports.experiment_panels import panels_of, title_of
from elastic_tendon.reports.interactive.theme import LIGHT, Theme, blank, plain, upright
from elastic_tendon.reports.thinning import envelope


def experiment(proposed: Experiment, *, theme: Theme = LIGHT) -> go.Figure:
    """Motor motion, the load where one is to act, and what the answers predict, over time."""
    panels = list(panels_of(proposed))
    empty = blank(theme, title=title_of(proposed), height=130 + 190 * len(panels))
    figure = make_subplots(len(panels), 1, shared_xaxes=True, vertical_spacing=0.06, figure=empty)
    named = set()  # in the legend
    for row, panel in enumerate(panels, start=1):
        for index, (name, values) in enumerate(panel.curves.items()):
            time, thinned = envelope(proposed.time, values)
            figure.add_scatter(
                x=time,
                y=thinned,
                mode="lines",
                name=plain(name),
                line={"color": theme.runs[index] if panel.predicted else theme.ink, "width": 1.5},
                showlegend=panel.predicted and name not in named,
                legendgroup=name,
                hovertemplate=f"{plain(name)}, %{{x:.4g}} s: %{{y:.4g}}<extra></extra>",
                row=row,
                col=1,
            )
            named |= {name} if panel.predicted else set()
        figure.update_yaxes(title=upright(plain(panel.label)), row=row, col=1)
    figure.update_xaxes(title="time (s)", row=len(panels), col=1)
    return figure
