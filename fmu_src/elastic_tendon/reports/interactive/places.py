"""Where a model fails: maps, and bars; each cell and bar names the samples that it stands for."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import plotly.graph_objects as go
from numpy.typing import NDArray
from plotly.subplots import make_subplots

from elastic_tendon.comparison.bins import Bin
from elastic_tendon.comparison.comparison import FileComparison
from elastic_tendon.comparison.locate import FileLocation
from elastic_tendon.comparison.maps import CellMap, samples_in_cell
from elastic_tendon.comparison.maps import error_maps as maps_of
from elastic_tendon.reports.bin_axis import axis_below, by_variable
from elastic_tendon.reports.comparison_tables import sample_shares
from elastic_tendon.reports.interactive.theme import (
    LIGHT,
    Theme,
    broken,
    dressed,
    panels,
    place_of,
    plain,
)
from elastic_tendon.reports.names import abridged
from elastic_tendon.reports.units import Shown, shown, with_unit

Mark = Sequence[str | int]  # what a clicked bar or cell says of itself
HEIGHT = 600  # of the maps, pixels
BAR = 0.8  # width


def error_maps(file: FileComparison, location: FileLocation, *, theme: Theme = LIGHT) -> go.Figure:
    """RMS error of the joint position and mean missing torque over what the joint did.

    The custom data of each cell are understood by `samples_of`.

    Parameters
    ----------
    file : FileComparison of a time series
    location : FileLocation of the same recording
    theme : Theme

    Returns
    -------
    plotly.graph_objects.Figure
    """
    maps = maps_of(file, location)
    title = {"text": f"{plain(abridged(file.measurement.name))}: where the error lies"}
    figure = make_subplots(len(maps), 2, horizontal_spacing=0.27, vertical_spacing=0.18)
    style = {"height": HEIGHT, "margin": {"t": 48}, "plot_bgcolor": theme.blank}
    dressed(figure, theme, title=title, **style)
    for row, error_map in enumerate(maps, start=1):
        quantity = shown(error_map.signal)
        rms = f"RMS error, {quantity.words} ({quantity.small_unit})"
        drawn = (
            (error_map.rms, quantity.small, rms),
            (error_map.torque, 1.0, "mean missing torque (N·m)"),
        )
        for column, (cells, factor, words) in enumerate(drawn, start=1):
            place = {"row": row, "col": column}
            figure.update_xaxes(title=with_unit(error_map.variables[0]), showgrid=False, **place)
            figure.update_yaxes(title=with_unit(error_map.variables[1]), showgrid=False, **place)
            if cells is not None:
                style = _colours(factor * cells.values, words, theme, signed=column == 2)
                _draw_map(figure, cells, factor, error_map.variables, place, style)
    return figure


def _colours(values: NDArray[np.float64], words: str, theme: Theme, *, signed: bool) -> Any:
    largest = float(np.nanmax(np.abs(values))) or 1.0
    return {
        "colorscale": theme.diverging if signed else theme.sequential,
        "zmin": -largest if signed else 0.0,
        "zmax": largest,
        "name": words,
        "colorbar": {
            "title": {"text": broken(words), "side": "right"},
            "thickness": 14,
            "outlinewidth": 0,
        },
    }


def _draw_map(
    figure: go.Figure,
    cells: CellMap,
    factor: float,
    variables: tuple[str, str],
    place: dict[str, int],
    style: dict[str, Any],
) -> None:
    marks = [
        [
            None if np.isnan(value) else [*variables, column, row]
            for column, value in enumerate(line)
        ]
        for row, line in enumerate(cells.values)
    ]
    figure.add_heatmap(
        x=cells.horizontal,
        y=cells.vertical,
        z=factor * cells.values,
        customdata=marks,
        hoverongaps=False,
        hovertemplate="%{x:.3g}, %{y:.3g}: %{z:.3g}<extra></extra>",
        **style,
        **place,
    )
    # beside its own axes
    axes = figure.get_subplot(**place)
    low, high = axes.yaxis.domain
    bar = {"x": axes.xaxis.domain[1] + 0.01, "y": 0.5 * (low + high), "len": high - low}
    figure.data[-1].colorbar.update(xanchor="left", **bar)


def shares(
    file: FileComparison, location: FileLocation, signal: str, *, theme: Theme = LIGHT
) -> go.Figure:
    """Share of the squared error in every bin beside its share of the samples.

    The custom data of each bar are understood by `samples_of`.

    Parameters
    ----------
    file : FileComparison
    location : FileLocation of the same recording
    signal : name of a compared signal
    theme : Theme

    Returns
    -------
    plotly.graph_objects.Figure; a panel for each variable
    """
    bins = location.bins[signal]
    samples = sample_shares(bins)
    split = by_variable(bins)
    quantity = shown(signal, static=file.measurement.static)
    words = f"{plain(abridged(file.measurement.name))}: share of the {quantity.words} error"
    figure = panels(theme, len(split), title={"text": words}, barmode="overlay", bargap=1 - BAR)
    for index, chosen in enumerate(split.values()):
        place = place_of(index, len(split))
        _draw_bars(figure, chosen, quantity, theme, place)
        figure.add_scatter(
            x=[bin_.bin for bin_ in chosen],
            y=[100.0 * samples[bin_] for bin_ in chosen],
            mode="markers",
            name="samples",
            legendgroup="samples",
            showlegend=index == 0,
            marker={
                "symbol": "line-ew",
                "size": 16,
                "line": {"width": 2, "color": theme.measured},
            },
            hovertemplate="%{y:.3g} % of the samples<extra></extra>",
            customdata=_marks(chosen),
            **place,
        )
        _draw_ticks(figure, chosen, place)
    return figure


def _draw_bars(
    figure: go.Figure, bins: Sequence[Bin], quantity: Shown, theme: Theme, place: dict[str, int]
) -> None:
    """Two traces, so that the legend distinguishes them; they share the axis of all bins."""
    kinds = (
        (True, "squared error, stands out", theme.stands_out),
        (False, "squared error, does not stand out", theme.quiet),
    )
    for stands_out, label, colour in kinds:
        chosen = [bin_ for bin_ in bins if bin_.stands_out == stands_out]
        if not chosen:
            continue
        known = any(trace.name == label for trace in figure.data)
        figure.add_bar(
            x=[bin_.bin for bin_ in chosen],
            y=[100.0 * bin_.share for bin_ in chosen],
            width=BAR,
            name=label,
            legendgroup=label,
            showlegend=not known,
            marker={
                "color": colour,
                "line": {"color": theme.ink, "width": 1.5 if stands_out else 0.0},
            },
            text=[f"RMS error {quantity.error(bin_.rmse)}" for bin_ in chosen],
            textposition="none",
            customdata=_marks(chosen),
            hovertemplate="%{x}<br>%{y:.3g} % of the squared error<br>%{text}<extra></extra>",
            **place,
        )


def _marks(bins: Sequence[Bin]) -> list[list[str]]:
    return [[bin_.by, bin_.bin] for bin_ in bins]


def _draw_ticks(figure: go.Figure, bins: Sequence[Bin], place: dict[str, int]) -> None:
    below = axis_below(bins)
    figure.update_xaxes(
        type="category",
        categoryorder="array",
        categoryarray=[bin_.bin for bin_ in bins],
        range=[-0.5, len(bins) - 0.5],
        tickvals=below.places,
        ticktext=below.labels,
        tickangle=-45 if below.edges else 0,
        tickfont={"size": 11},
        title=below.title,
        showgrid=False,
        **place,
    )
    figure.update_yaxes(rangemode="tozero", title="share of all (%)", **place)


def samples_of(location: FileLocation, mark: Mark) -> NDArray[np.bool_]:
    """Samples of a bar of `shares` or of a cell of `error_maps`, (n,).

    Parameters
    ----------
    location : FileLocation from which the figure was made
    mark : custom data of what was clicked: variable and bin of a bar, variables across and up
        with column and row of a cell; a bin of the frequency holds no samples

    Raises
    ------
    KeyError, ValueError, TypeError : the mark is none of this figure
    """
    if len(mark) == len(("variable", "bin")):
        return location.samples_of(str(mark[0]), str(mark[1]))
    across, up, column, row = mark
    values = location.variables[str(across)], location.variables[str(up)]
    return samples_in_cell(*values, int(column), int(row))
