"""Figures of where a model fails, one function for each; nothing is computed here."""

import re
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import Normalize, TwoSlopeNorm
from matplotlib.figure import Figure, SubFigure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import PercentFormatter

from elastic_tendon.actuator.parameters import Model
from elastic_tendon.actuator.transmission import SlackState
from elastic_tendon.comparison.bins import Bin
from elastic_tendon.comparison.comparison import Comparison, FileComparison
from elastic_tendon.comparison.correlations import Correlation
from elastic_tendon.comparison.locate import FileLocation, Location
from elastic_tendon.comparison.maps import CellMap
from elastic_tendon.comparison.maps import error_maps as maps_of
from elastic_tendon.comparison.missing_torque import TorqueCurve
from elastic_tendon.comparison.residuals import Array
from elastic_tendon.reports.bin_axis import axis_below, by_variable
from elastic_tendon.reports.comparison_figures import (
    BLACK,
    BLUE,
    GREEN,
    ORANGE,
    PURPLE,
    VERMILLION,
    overlay,
    tidy,
)
from elastic_tendon.reports.comparison_tables import STATES, sample_shares
from elastic_tendon.reports.loops import measured_loop, springs_over, torque_source
from elastic_tendon.reports.names import shortened
from elastic_tendon.reports.residual_tests import BAND, CORRELATION, LAG, partner
from elastic_tendon.reports.thinning import envelope, path, some
from elastic_tendon.reports.units import shown, with_unit

BLANK = "0.85"  # of cells without samples; white is zero
COLUMNS = 3  # panels side by side
MOST_PARTS = 10  # of a figure of all signals; a longer one could not be read
STATE_COLOURS = {
    SlackState.I: (BLUE, STATES["I"]),
    SlackState.II: (ORANGE, STATES["II"]),
    SlackState.III: (GREEN, STATES["III"]),
    SlackState.BOTH: (PURPLE, "both slack"),
}
Drawing = Callable[[], Figure]


def all_figures(comparison: Comparison, location: Location) -> Iterator[tuple[str, Drawing]]:
    """Every figure of a comparison: the name of its file without suffix, and what draws it.

    Parameters
    ----------
    comparison : Comparison
    location : Location of the same comparison
    """
    names = file_names([file.measurement.name for file in comparison.files])
    for name, file, file_location in zip(names, comparison.files, location.files, strict=True):
        yield f"{name}_overlay", partial(overlay, Comparison(comparison.model, (file,)))
        yield from _of_one_file(name, comparison.model, file, file_location)


def _of_one_file(
    name: str, model: Model, file: FileComparison, location: FileLocation
) -> Iterator[tuple[str, Drawing]]:
    if location.missing_torque.known:
        if model.kind.has_springs:
            yield f"{name}_torque_over_deflection", partial(torque_loop, model, file, location)
        yield f"{name}_missing_torque", partial(missing_torque, file, location)
    for signal in file.signals:
        yield f"{name}_{signal}_share_of_error", partial(share_of_error, file, location, signal)
    if file.measurement.static:
        return  # it has no velocity and no time to draw maps and correlations over
    yield f"{name}_error_maps", partial(error_maps, file, location)
    for signal in file.signals:
        yield f"{name}_{signal}_correlation", partial(residual_correlation, file, location, signal)


def file_names(recordings: Sequence[str]) -> list[str]:
    """Recordings' names as parts of file names, each once."""
    names: list[str] = []
    for index, recording in enumerate(recordings, start=1):
        without_suffix = re.sub(r"\.\w+(?=$|[\[#])", "", recording)
        plain = re.sub(r"[^\w.-]+", "_", without_suffix).strip("_.")
        names.append(f"{plain}_{index}" if plain in names else plain)
    return names


# ---- torque over deflection ----------------------------------------------------------------


def torque_loop(model: Model, file: FileComparison, location: FileLocation) -> Figure:
    """Torque of the tendons over deflection, coloured by slack state, with the model's own.

    Parameters
    ----------
    model : Model
    file : FileComparison
    location : FileLocation of the same recording

    Returns
    -------
    matplotlib.figure.Figure
    """
    figure = Figure(figsize=(7.5, 5.5), layout="constrained")
    axes = figure.subplots()
    deflection, torque = measured_loop(model, file, location)
    _draw_model(axes, model, file, deflection)
    states = np.round(location.variables["slack_state"])
    for state, (colour, label) in STATE_COLOURS.items():
        inside = np.flatnonzero(states == state)
        inside = inside[some(len(inside))]
        if len(inside):
            places = deflection[inside], torque[inside]
            axes.scatter(*places, s=5, color=colour, label=label, linewidths=0, rasterized=True)
    figure.suptitle(f"{shortened(file.measurement.name)}: torque over deflection")
    axes.set_xlabel("deflection as measured (rad)")
    axes.set_ylabel(f"joint torque (N·m)\n{torque_source(file.measurement)}")
    figure.legend(loc="outside lower center", ncols=3, frameon=False, markerscale=2.0)
    tidy(axes)
    return figure


def _draw_model(axes: Axes, model: Model, file: FileComparison, deflection: Array) -> None:
    simulated = path(file.trajectory["deflection"], file.trajectory["joint_torque"])
    axes.plot(*simulated, color="0.6", linewidth=0.8, label="simulated")
    springs = springs_over(model, deflection)
    axes.set_xlim(*springs.ends)
    style: dict[str, Any] = {"color": BLACK, "lw": 1.6, "zorder": 3}
    axes.plot(springs.deflection, springs.torque, label="model's springs, static", **style)
    for index, boundary in enumerate(springs.boundaries):
        label = None if index else "slack boundary, paper (14)"
        axes.axvline(boundary, color=BLACK, linestyle=":", linewidth=1.2, label=label)


# ---- maps ----------------------------------------------------------------------------------


def error_maps(file: FileComparison, location: FileLocation) -> Figure:
    """RMS error and mean missing torque over what the joint did, see `maps.error_maps`.

    Parameters
    ----------
    file : FileComparison of a time series
    location : FileLocation of the same recording

    Returns
    -------
    matplotlib.figure.Figure
    """
    figure = Figure(figsize=(11.0, 8.0), layout="constrained")
    maps = maps_of(file, location)
    for panels, error_map in zip(figure.subplots(len(maps), 2), maps, strict=True):
        quantity = shown(error_map.signal)
        words = f"RMS error, {quantity.words}\n({quantity.small_unit})"
        _draw_map(panels[0], error_map.rms, error_map.variables, words, quantity.small)
        words = "mean missing torque (N·m)"
        _draw_map(panels[1], error_map.torque, error_map.variables, words, signed=True)
    figure.suptitle(f"{shortened(file.measurement.name)}: where the error lies")
    return figure


def _draw_map(
    axes: Axes,
    cell_map: CellMap | None,
    pair: tuple[str, str],
    words: str,
    factor: float = 1.0,
    *,
    signed: bool = False,
) -> None:
    """`factor`, to the unit that is shown; signed values are drawn about zero."""
    axes.set_xlabel(with_unit(pair[0]))
    axes.set_ylabel(with_unit(pair[1]))
    axes.spines[["top", "right"]].set_visible(False)
    if cell_map is None:
        axes.text(0.5, 0.5, "too few samples, or not known", transform=axes.transAxes, ha="center")
        return
    values = factor * cell_map.values
    axes.set_facecolor(BLANK)
    largest = float(np.nanmax(np.abs(values))) or 1.0
    norm = TwoSlopeNorm(0.0, -largest, largest) if signed else Normalize(0.0, largest)
    mesh = axes.pcolormesh(
        *(cell_map.horizontal, cell_map.vertical, values),
        cmap="RdBu_r" if signed else "viridis",
        norm=norm,
        rasterized=True,
    )
    figure = axes.figure
    assert isinstance(figure, Figure)
    figure.colorbar(mesh, ax=axes, label=words)


# ---- shares by bin -------------------------------------------------------------------------


def share_of_error(file: FileComparison, location: FileLocation, signal: str) -> Figure:
    """Share of the squared error in every bin beside its share of the samples.

    Parameters
    ----------
    file : FileComparison
    location : FileLocation of the same recording
    signal : name of a compared signal

    Returns
    -------
    matplotlib.figure.Figure; a panel for each variable
    """
    split = by_variable(location.bins[signal])
    figure = Figure(figsize=_size(len(split)), layout="constrained")
    _draw_shares(figure, file, location, signal)
    return figure


def shares_of_error(location: Location) -> Figure:
    """Share of the squared error in every bin, of all signals of all recordings.

    Parameters
    ----------
    location : Location

    Returns
    -------
    matplotlib.figure.Figure; a part as of `share_of_error` for each, the first `MOST_PARTS`
    """
    every = [
        (file_location, signal) for file_location in location.files for signal in file_location.bins
    ][:MOST_PARTS]
    sizes = [_size(len(by_variable(file_location.bins[signal]))) for file_location, signal in every]
    widths, heights = zip(*sizes, strict=True)
    figure = Figure(figsize=(max(widths), sum(heights)), layout="constrained")
    parts = figure.subfigures(len(every), 1, squeeze=False, height_ratios=heights)
    for part, (file_location, signal) in zip(parts.flat, every, strict=True):
        _draw_shares(part, file_location.comparison, file_location, signal)
    return figure


def _draw_shares(
    figure: Figure | SubFigure, file: FileComparison, location: FileLocation, signal: str
) -> None:
    bins = location.bins[signal]
    shares = sample_shares(bins)
    split = by_variable(bins)
    panels = _panels(figure, len(split))
    for axes, chosen in zip(panels, split.values(), strict=True):
        _draw_bars(axes, chosen, [shares[bin_] for bin_ in chosen])
    quantity = shown(signal, static=file.measurement.static)
    figure.suptitle(f"{shortened(file.measurement.name)}: share of the {quantity.words} error")
    marks = [
        Patch(color=VERMILLION, label="squared error, stands out"),
        Patch(color="0.75", label="squared error, does not stand out"),
        Line2D([], [], color=BLACK, marker="_", ls="none", markersize=12, mew=1.6, label="samples"),
    ]
    figure.legend(handles=marks, loc="outside lower center", ncols=3, frameon=False)


def _draw_bars(axes: Axes, bins: Sequence[Bin], samples: Sequence[float]) -> None:
    places = np.arange(len(bins))
    colours = [VERMILLION if bin_.stands_out else "0.75" for bin_ in bins]
    axes.bar(places, [bin_.share for bin_ in bins], color=colours, width=0.8)
    axes.hlines(samples, places - 0.42, places + 0.42, color=BLACK, linewidth=1.6)
    _draw_ticks(axes, bins)
    axes.yaxis.set_major_formatter(PercentFormatter(1.0, symbol=""))
    axes.set_ylim(bottom=0.0)
    axes.set_ylabel("share of all (%)")
    tidy(axes)
    axes.grid(visible=False, axis="x")
    axes.set_axisbelow(True)


def _draw_ticks(axes: Axes, bins: Sequence[Bin]) -> None:
    below = axis_below(bins)
    axes.tick_params(axis="x", labelsize="small")
    style: dict[str, Any] = {"rotation": 45, "ha": "right", "rotation_mode": "anchor"}
    axes.set_xticks(below.places, below.labels, **(style if below.edges else {}))
    axes.set_xlabel(below.title)


# ---- missing torque ------------------------------------------------------------------------


def missing_torque(file: FileComparison, location: FileLocation) -> Figure:
    """Missing torque over time and against each variable, with its 95 % band.

    Parameters
    ----------
    file : FileComparison
    location : FileLocation of the same recording

    Returns
    -------
    matplotlib.figure.Figure; a panel for each variable
    """
    missing = location.missing_torque
    chosen = some(len(missing.torque))
    figure = Figure(figsize=_size(len(missing.curves)), layout="constrained")
    panels = _panels(figure, len(missing.curves))
    for axes, curve in zip(panels, missing.curves, strict=True):
        if curve.by in location.variables:
            cloud = location.variables[curve.by][chosen], missing.torque[chosen]
            axes.plot(*cloud, ".", markersize=1.5, color="0.7", rasterized=True)
        _draw_curve(axes, curve)
    figure.suptitle(f"{shortened(file.measurement.name)}: missing torque on the joint")
    marks = [
        Line2D([], [], color="0.7", marker=".", linestyle="none", label="each sample"),
        Line2D([], [], color=BLUE, marker="o", markersize=3, label="mean"),
        Patch(color=BLUE, alpha=0.25, label="95 % interval of the mean"),
    ]
    figure.legend(handles=marks, loc="outside lower center", ncols=3, frameon=False)
    return figure


def _draw_curve(axes: Axes, curve: TorqueCurve) -> None:
    axes.axhline(0.0, color="0.5", linewidth=0.8)
    axes.fill_between(curve.centre, curve.low, curve.high, color=BLUE, alpha=0.25, linewidth=0)
    axes.plot(curve.centre, curve.mean, color=BLUE, marker="o", markersize=3, linewidth=1.2)
    axes.set_xlabel(f"{curve.by.replace('_', ' ')} ({curve.unit})")
    axes.set_ylabel("missing torque (N·m)")
    tidy(axes)


# ---- correlation ---------------------------------------------------------------------------


def residual_correlation(file: FileComparison, location: FileLocation, signal: str) -> Figure:
    """Correlation of a residual with its own past and with the inputs, beside honest bounds.

    Parameters
    ----------
    file : FileComparison of a time series
    location : FileLocation of the same recording
    signal : name of a compared signal

    Returns
    -------
    matplotlib.figure.Figure
    """
    every = location.correlations[signal]
    figure = Figure(figsize=_size(len(every), columns=2), layout="constrained")
    panels = _panels(figure, len(every), columns=2)
    for axes, correlation in zip(panels, every, strict=True):
        _draw_correlation(axes, correlation)
    quantity = shown(signal)
    name = shortened(file.measurement.name)
    figure.suptitle(f"{name}: does the residual of the {quantity.words} follow anything?")
    band = Patch(color="0.85", label=BAND)
    figure.legend(handles=[band], loc="outside lower center", frameon=False)
    return figure


def _draw_correlation(axes: Axes, correlation: Correlation) -> None:
    ends = correlation.expected - correlation.bound, correlation.expected + correlation.bound
    axes.fill_between(correlation.lag, *ends, color="0.85", linewidth=0)
    axes.axhline(0.0, color="0.5", linewidth=0.8)
    axes.plot(*envelope(correlation.lag, correlation.values), color=BLUE, linewidth=1.2)
    axes.set_title(partner(correlation), fontsize="medium")
    axes.set_xlabel(LAG)
    axes.set_ylabel(CORRELATION)
    tidy(axes)


def _grid(count: int, columns: int) -> tuple[int, int]:
    """Rows and columns of so many panels."""
    columns = max(1, min(columns, count))
    return -(-count // columns), columns


def _size(count: int, columns: int = COLUMNS) -> tuple[float, float]:
    """Width and height of a figure of so many panels, inch."""
    rows, columns = _grid(count, columns)
    return 3.7 * columns + 0.3, 2.9 * rows + 0.9


def _panels(figure: Figure | SubFigure, count: int, columns: int = COLUMNS) -> list[Axes]:
    """So many panels in a figure, left to right and downwards."""
    rows, columns = _grid(count, columns)
    panels = list(figure.subplots(rows, columns, squeeze=False).flat) if count else []
    for axes in panels[count:]:
        axes.set_visible(False)
    return panels[:count]
