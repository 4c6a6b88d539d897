"""Measured and simulated signals of one recording above each other, the errors below."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import plotly.graph_objects as go
from numpy.typing import NDArray

from elastic_tendon.comparison.comparison import FileComparison
from elastic_tendon.comparison.residuals import Array
from elastic_tendon.reports.comparison_figures import FAINT, static_torque
from elastic_tendon.reports.interactive.theme import LIGHT, Theme, blank, noise_band, plain, upright
from elastic_tendon.reports.names import abridged
from elastic_tendon.reports.thinning import BUCKETS, envelope, path, some, stretches, within
from elastic_tendon.reports.units import Shown, shown

UPPER, LOWER = (0.36, 1.0), (0.0, 0.30)  # shares of the height
CURSORS = ("A", "B")
# the name stands in `meta`: in the template itself its letters could be taken for commands
HOVER, HOVER_ERROR = "%{meta}: %{y:.4g} UNIT<extra></extra>", "error: %{y:.3g} UNIT<extra></extra>"
DASHES = "4px,2px"


@dataclass(frozen=True)
class Run:
    """A model beside a recording; `label` says which model, as "improved".

    `colour` is the number of its colour in `Theme.runs`, for a model that is seen now alone, now
    beside others; None: its number among those it stands beside.
    """

    label: str
    file: FileComparison
    colour: int | None = None

    def simulated(self, signal: str) -> Array:
        """What the sensor of a signal would read, (n,) in the unit of the signal."""
        return self.file.trajectory[self.file.trajectory.measured(signal)]

    def error(self, signal: str) -> Array:
        """Simulated less measured, (n,) in the unit of the signal."""
        return self.simulated(signal) - self.file.measurement.signals[signal]


@dataclass(frozen=True)
class Reading:
    """Values at a cursor: `time` of the sample, s, its number from 0 as `index`, and what was
    measured and simulated by name, in the unit of the signal; NaN where it was not simulated.
    """

    time: float
    index: int
    values: tuple[tuple[str, float], ...]


def overlay(
    runs: Sequence[Run],
    signal: str,
    *,
    theme: Theme = LIGHT,
    window: tuple[float, float] | None = None,
    highlighted: NDArray[np.bool_] | None = None,
    cursors: Sequence[float | None] = (),
    tolerance: float | None = None,
    buckets: int = BUCKETS,
) -> go.Figure:
    """One signal of one recording, with the simulations of several models and their errors.

    The errors below share the axis of the time, so a zoom moves both. A static curve is drawn as
    torque over deflection; it has neither window nor cursors. Samples that are not selected are
    drawn faint.

    Parameters
    ----------
    runs : models beside the same recording, at least one; after the first also beside a stretch
    signal : name of the signal
    theme : Theme
    window : start and end, s; only this stretch is drawn, as finely as the whole would be
    highlighted : (n,), samples that are marked
    cursors : up to two times, s, marked A and B; None where one is not set
    tolerance : largest error that is accepted, in the unit of the signal; drawn about the errors
    buckets : stretches of a long curve of which the extremes are kept

    Returns
    -------
    plotly.graph_objects.Figure
    """
    measurement = runs[0].file.measurement
    quantity = shown(signal, static=measurement.static)
    figure = blank(theme, **_layout(runs[0].file, signal, quantity))
    if measurement.static:
        _draw_curves(figure, runs, quantity, theme, highlighted)
    else:
        _draw_series(figure, runs, signal, quantity, theme, window, buckets)
        _mark_samples(figure, measurement.time, window, highlighted, theme)
        _veil(figure, runs[0].file, window, theme)
        if window is not None:
            figure.update_xaxes(range=list(window))
        for letter, time in zip(CURSORS, cursors, strict=False):
            if time is not None:
                _mark_cursor(figure, letter, time, theme)
    _draw_noise(figure, runs, signal, quantity, theme)
    if tolerance is not None:
        _draw_tolerance(figure, tolerance, quantity, theme)
    return figure


def values_at(runs: Sequence[Run], signal: str, time: float) -> Reading:
    """What was measured and simulated at the sample nearest to a time.

    Parameters
    ----------
    runs : models beside the same recording, at least one
    signal : name of the signal
    time : float, s

    Returns
    -------
    Reading
    """
    measurement = runs[0].file.measurement
    after = int(np.searchsorted(measurement.time, time).clip(1, len(measurement.time) - 1))
    middle = 0.5 * (measurement.time[after - 1] + measurement.time[after])
    index = after if time >= middle else after - 1
    at = float(measurement.time[index])
    values = [("measured", float(measurement.signals[signal][index]))]
    values += [(run.label, _simulated_at(run, signal, at)) for run in runs]
    return Reading(at, index, tuple(values))


def _simulated_at(run: Run, signal: str, time: float) -> float:
    """Value at a sample; NaN where the run is of a stretch that does not hold it."""
    index = int(np.searchsorted(run.file.measurement.time, time))
    there = run.file.measurement.time[index : index + 1] == time
    return float(run.simulated(signal)[index]) if there.any() else np.nan


def line_of_run(index: int, count: int, theme: Theme) -> dict[str, Any]:
    """Colour, width and dash of a run of so many, by its number from 0.

    The first is dashed beside others, so that it differs in more than its colour.
    """
    dash = DASHES if index == 0 and count > 1 else "solid"
    return {"color": theme.runs[index % len(theme.runs)], "width": 1.5, "dash": dash}


def _line(runs: Sequence[Run], index: int, theme: Theme) -> dict[str, Any]:
    line, colour = line_of_run(index, len(runs), theme), runs[index].colour
    return line if colour is None else line | {"color": theme.runs[colour % len(theme.runs)]}


def _layout(file: FileComparison, signal: str, quantity: Shown) -> dict[str, Any]:
    """Two axes above each other over one. Names are ids: of the recording, zoom in time belongs
    to that; the zoom of values to its signal, too.
    """
    name = file.measurement.name
    static = file.measurement.static
    values = "joint torque (N·m)" if static else f"{quantity.words} ({quantity.unit})"
    return {
        "title": {"text": plain(abridged(name))},
        "uirevision": name,
        "hovermode": "closest" if static else "x unified",
        "hoversubplots": "axis",
        "xaxis": {
            "title": {"text": "deflection (rad)" if static else "time (s)"},
            "anchor": "y2",
            "uirevision": name,
            "unifiedhovertitle": {"text": "%{x:.4f} s"},
        },
        "yaxis": {
            "title": {"text": upright(values)},
            "domain": UPPER,
            "uirevision": f"{name}: {signal}",
        },
        "yaxis2": {
            "title": {"text": upright(f"error ({quantity.small_unit})")},
            "domain": LOWER,
            "zeroline": True,
            "uirevision": f"{name}: {signal}",
        },
    }


def _label(run: Run, signal: str, quantity: Shown) -> str:
    return f"{plain(abridged(run.label))}: RMS {quantity.error(run.file.signals[signal].rmse)}"


def _draw_series(
    figure: go.Figure,
    runs: Sequence[Run],
    signal: str,
    quantity: Shown,
    theme: Theme,
    window: tuple[float, float] | None,
    buckets: int,
) -> None:
    measurement = runs[0].file.measurement
    kept = within(measurement.time, window, 1)
    across, up = envelope(measurement.time[kept], measurement.signals[signal][kept], buckets)
    figure.add_scatter(
        x=across,
        y=up,
        mode="lines",
        name="measured",
        line={"color": theme.measured, "width": 2.6},
        meta="measured",
        hovertemplate=HOVER.replace("UNIT", quantity.unit),
    )
    for index, run in enumerate(runs):
        style = {
            "mode": "lines",
            "line": _line(runs, index, theme),
            "legendgroup": f"run {index}",
        }
        simulated, error = run_curves(run, signal, window=window, buckets=buckets)
        figure.add_scatter(
            **simulated,
            meta=plain(abridged(run.label)),
            hovertemplate=HOVER.replace("UNIT", quantity.unit),
            **style,
        )
        figure.add_scatter(
            **error,
            name=f"error, {plain(run.label)}",
            hovertemplate=HOVER_ERROR.replace("UNIT", quantity.small_unit),
            yaxis="y2",
            showlegend=False,
            **style,
        )


def run_curves(
    run: Run,
    signal: str,
    *,
    window: tuple[float, float] | None = None,
    buckets: int = BUCKETS,
) -> tuple[dict[str, Any], dict[str, Any]]:
    """What changes of a model's two curves in `overlay` with its numbers: simulated, and error.

    Parameters
    ----------
    run, signal, window, buckets : as of `overlay`; the recording has a time

    Returns
    -------
    two dict : ``x``, ``y``, (m,) arrays, and of the first ``name``, as in a trace of plotly
    """
    measurement = run.file.measurement
    quantity = shown(signal, static=measurement.static)
    kept = within(measurement.time, window, 1)
    time, simulated = measurement.time[kept], run.simulated(signal)[kept]
    error = quantity.small * (simulated - measurement.signals[signal][kept])
    of_signal, of_error = (
        dict(zip("xy", envelope(time, curve, buckets), strict=True)) for curve in (simulated, error)
    )
    return of_signal | {"name": _label(run, signal, quantity)}, of_error


def _draw_curves(
    figure: go.Figure,
    runs: Sequence[Run],
    quantity: Shown,
    theme: Theme,
    highlighted: NDArray[np.bool_] | None,
) -> None:
    """A static curve: torque over deflection, and by how much the models' deflection is off."""
    signal = "joint_position"
    measurement = runs[0].file.measurement
    torque, measured = static_torque(measurement), measurement.signals[signal]
    kept = some(len(torque))
    selection = runs[-1].file.selection
    faint = 1.0 if selection is None else np.where(selection.chosen[kept], 1.0, FAINT)
    figure.add_scatter(
        x=measured[kept],
        y=torque[kept],
        mode="markers",
        name="measured",
        marker={"color": theme.measured, "size": 4, "opacity": faint},
    )
    for index, run in enumerate(runs):
        line = _line(runs, index, theme)
        group = {"legendgroup": f"run {index}", "mode": "lines", "line": line}
        across, up = path(run.simulated(signal), torque)
        figure.add_scatter(x=across, y=up, name=_label(run, signal, quantity), **group)
        across, up = path(measured, quantity.small * run.error(signal))
        figure.add_scatter(
            x=across,
            y=up,
            name=f"error, {plain(run.label)}",
            yaxis="y2",
            showlegend=False,
            **group,
        )
    if highlighted is not None and highlighted.any():
        chosen = np.flatnonzero(highlighted)
        chosen = chosen[some(len(chosen))]
        figure.add_scatter(
            x=measured[chosen],
            y=torque[chosen],
            mode="markers",
            name="chosen samples",
            marker={"color": theme.highlight, "size": 10},
            hoverinfo="skip",
        )


def _draw_noise(
    figure: go.Figure, runs: Sequence[Run], signal: str, quantity: Shown, theme: Theme
) -> None:
    sigma = runs[-1].file.signals[signal].noise.sigma
    _mark_errors(figure, type="rect", **noise_band(quantity.small * sigma, theme))


def _draw_tolerance(figure: go.Figure, tolerance: float, quantity: Shown, theme: Theme) -> None:
    for bound in (tolerance, -tolerance):
        _mark_errors(
            figure,
            type="line",
            y0=quantity.small * bound,
            y1=quantity.small * bound,
            line={"color": theme.ink, "width": 1.2, "dash": "dot"},
            name=f"tolerance ± {quantity.error(tolerance)}",
            showlegend=bound > 0.0,
        )


def _mark_errors(figure: go.Figure, **shape: Any) -> None:
    """Mark a range of errors over the whole width."""
    figure.add_shape(xref="x domain", yref="y2", x0=0.0, x1=1.0, **shape)


def _mark_samples(
    figure: go.Figure,
    time: Array,
    window: tuple[float, float] | None,
    highlighted: NDArray[np.bool_] | None,
    theme: Theme,
) -> None:
    """Shade the stretches of chosen samples; all of them are one shape, which is drawn fast."""
    if highlighted is not None:
        # stretches shorter than a pixel are seen by their outline
        line = {"color": theme.highlight, "width": 0.7}
        look = {"fillcolor": theme.highlight, "line": line, "layer": "below"}
        _shade(figure, time, window, highlighted, name="chosen samples", showlegend=True, **look)


def _veil(
    figure: go.Figure, file: FileComparison, window: tuple[float, float] | None, theme: Theme
) -> None:
    """Let the ground of the page nearly cover the stretches that are not selected."""
    if file.selection is not None:
        left_out = ~file.selection.chosen
        look = {"fillcolor": theme.background, "opacity": 1.0 - FAINT, "line": {"width": 0}}
        time = file.measurement.time
        _shade(figure, time, window, left_out, layer="above", **look)


def _shade(
    figure: go.Figure,
    time: Array,
    window: tuple[float, float] | None,
    samples: NDArray[np.bool_],
    **look: Any,
) -> None:
    """One shape over all stretches of some samples."""
    kept = within(time, window, 1)
    path = "".join(
        f"M{start:.9g},0V1H{end:.9g}V0Z" for start, end in stretches(time[kept], samples[kept])
    )
    if path:
        place = {"xref": "x", "yref": "paper"}
        figure.add_shape(type="path", path=path, **place, **look)


def _mark_cursor(figure: go.Figure, letter: str, time: float, theme: Theme) -> None:
    place = {"xref": "x", "yref": "paper"}
    line = {"color": theme.ink, "width": 1.2, "dash": "dot"}
    figure.add_shape(type="line", x0=time, x1=time, y0=0.0, y1=1.0, line=line, **place)
    label = {"text": letter, "showarrow": False, "bgcolor": theme.grid}
    figure.add_annotation(x=time, y=1.0, yanchor="top", xanchor="left", **label, **place)
