"""Figures of a comparison and of the ladder of errors; nothing is computed here."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from textwrap import fill
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure, SubFigure
from matplotlib.ticker import FuncFormatter, NullFormatter
from numpy.typing import NDArray

from elastic_tendon.comparison.comparison import Comparison, FileComparison
from elastic_tendon.comparison.residuals import Array
from elastic_tendon.estimation.ladder import FittedStep, Step
from elastic_tendon.measurement import Measurement
from elastic_tendon.output import OutputError
from elastic_tendon.reports.names import shortened, verbatim
from elastic_tendon.reports.thinning import envelope, path, some, stretches
from elastic_tendon.reports.units import shown, times_noise

# Okabe and Ito: distinguished with every kind of colour vision
BLACK, ORANGE, SKY, GREEN = "#000000", "#E69F00", "#56B4E9", "#009E73"
BLUE, VERMILLION, PURPLE = "#0072B2", "#D55E00", "#CC79A7"

FAINT = 0.25  # of samples that are not selected, opacity
VISIBLE = 0.02  # share of an axis below which a band needs no legend
SOFTWARE = "elastic-tendon"  # in the metadata of a PNG
PICTURES = (".png", ".svg", ".pdf")
PAIRS = 20  # of axes in an overlay; a longer picture could not be read, nor at length be written
LEGEND: dict[str, Any] = {"framealpha": 0.8, "edgecolor": "none"}  # curves may fill the axes
TITLE = 20  # letters of a step's title in a line
STEP_COLOURS = (SKY, ORANGE, GREEN, PURPLE, VERMILLION)


def overlay(comparison: Comparison, tolerances: Mapping[str, float] | None = None) -> Figure:
    """Measured and simulated signals over time, the residual below each.

    A static curve is drawn as torque over deflection. Samples that are not selected are drawn
    faint.

    Parameters
    ----------
    comparison : Comparison
    tolerances : by signal, rad or N·m, drawn about its error

    Returns
    -------
    matplotlib.figure.Figure; one pair of axes for each recording and signal, the first `PAIRS`
    """
    every = [(file, name) for file in comparison.files for name in file.signals]
    pairs = every[:PAIRS]
    figure = Figure(figsize=(8.0, 0.4 + 3.9 * len(pairs)), layout="constrained")
    title = f"{verbatim(comparison.model.name)}: measured and simulated"
    if len(every) > len(pairs):
        title += f", the first {len(pairs)} of {len(every)} signals"
    figure.suptitle(title)
    parts = figure.subfigures(len(pairs), 1, squeeze=False)
    for part, (file, name) in zip(parts.flat, pairs, strict=True):
        _overlay_one(part, file, name, (tolerances or {}).get(name))
    figure.align_ylabels()
    return figure


def _overlay_one(part: SubFigure, file: FileComparison, name: str, tolerance: float | None) -> None:
    upper, lower = part.subplots(2, 1, sharex=True, gridspec_kw={"height_ratios": [3, 2]})
    if file.measurement.static:
        _draw_curves(upper, lower, file)
    else:
        _draw_series(upper, lower, file, name)
    error = file.signals[name]
    quantity = shown(name, static=file.measurement.static)
    fit = "" if error.fit_percent is None else f", fit {error.fit_percent:.1f} %"
    upper.set_title(
        f"{shortened(file.measurement.name)}: RMSE {quantity.error(error.rmse)}"
        f", {times_noise(error.noise_ratio)}{fit}",
        fontsize="medium",
    )
    band = 2.0 * quantity.small * error.noise.sigma
    lower.axhspan(-band, band, color="0.8", label="± 2σ of the noise")
    lower.axhline(0.0, color="0.5", linewidth=0.8)
    lower.set_ylabel(f"error ({quantity.small_unit})")
    upper.legend(loc="best", **LEGEND)
    if tolerance is not None:
        for bound in (-tolerance, tolerance):
            label = f"tolerance ± {quantity.error(tolerance)}" if bound > 0.0 else None
            looks: dict[str, Any] = {"color": VERMILLION, "linestyle": "--", "linewidth": 1.0}
            lower.axhline(quantity.small * bound, label=label, **looks)
    if tolerance is not None or band > VISIBLE * quantity.small * error.max_abs:
        lower.legend(loc="best", **LEGEND)
    tidy(upper)
    tidy(lower)


def _draw_series(upper: Axes, lower: Axes, file: FileComparison, name: str) -> None:
    quantity = shown(name)
    time = file.measurement.time
    measured = file.measurement.signals[name]
    simulated = file.trajectory[file.trajectory.measured(name)]
    upper.plot(*envelope(time, measured), color=BLACK, linewidth=1.6, label="measured")
    upper.plot(*envelope(time, simulated), color=VERMILLION, linewidth=1.1, label="simulated")
    upper.set_ylabel(f"{quantity.words} ({quantity.unit})")
    error = quantity.small * (simulated - measured)
    lower.plot(*envelope(time, error), color=BLUE, linewidth=0.9)
    lower.set_xlabel("time (s)")
    if file.selection is not None:
        for axes in (upper, lower):
            _veil(axes, time, ~file.selection.chosen)


def _veil(axes: Axes, time: Array, left_out: NDArray[np.bool_]) -> None:
    """Let white nearly cover the stretches of samples that are not selected."""
    spans = [(start, end - start) for start, end in stretches(time, left_out)]
    look: dict[str, Any] = {"facecolor": "white", "alpha": 1.0 - FAINT, "linewidth": 0}
    axes.broken_barh(spans, (0.0, 1.0), transform=axes.get_xaxis_transform(), zorder=2.5, **look)


def _draw_curves(upper: Axes, lower: Axes, file: FileComparison) -> None:
    """A static curve: torque over deflection, and by how much the model's deflection is off."""
    quantity = shown("joint_position", static=True)
    torque = static_torque(file.measurement)
    measured = file.measurement.signals["joint_position"]
    simulated = file.trajectory[file.trajectory.measured("joint_position")]
    kept = some(len(torque))
    dots: dict[str, Any] = {"linestyle": "none", "marker": "."}
    if file.selection is not None:
        upper.plot(measured[kept], torque[kept], color="0.8", label="left out", **dots)
        kept = kept[file.selection.chosen[kept]]
    upper.plot(measured[kept], torque[kept], color=BLACK, label="measured", **dots)
    upper.plot(*path(simulated, torque), color=VERMILLION, lw=1.1, label="simulated")
    upper.set_ylabel("joint torque (N·m)")
    error = quantity.small * (simulated - measured)
    lower.plot(measured[kept], error[kept], color=BLUE, markersize=4, **dots)
    lower.set_xlabel("deflection (rad)")


def static_torque(measurement: Measurement) -> Array:
    """Torque of the tendons in a static curve, (n,) N·m: in equilibrium with the load."""
    load = measurement.load_torque
    return np.zeros(len(measurement.time)) if load is None else -load


def ladder(steps: Sequence[Step], signal: str = "joint_position") -> Figure:
    """Error after each step on fitted and held-out data, beside the noise floor.

    Parameters
    ----------
    steps : entries of the ladder, the model as given first
    signal : name of the signal

    Returns
    -------
    matplotlib.figure.Figure
    """
    figure = Figure(figsize=(max(7.0, 1.5 * len(steps)), 4.2), layout="constrained")
    axes = figure.subplots()
    _draw_ladder(axes, steps, signal)
    figure.suptitle("Error after each step")
    return figure


def _draw_ladder(axes: Axes, steps: Sequence[Step], signal: str) -> None:
    quantity = shown(signal)
    places = np.arange(len(steps))
    lines = [("fitted data", BLUE, "o", [step.rmse[signal] for step in steps])]
    if all(signal in step.heldout_rmse for step in steps):
        heldout = [step.heldout_rmse[signal] for step in steps]
        lines.append(("held-out data", VERMILLION, "s", heldout))
    labels: list[list[tuple[float, str]]] = [[] for _ in steps]
    for label, colour, marker, values in lines:
        small = quantity.small * np.array(values)
        axes.plot(places, small, marker=marker, color=colour, label=label, linewidth=1.6)
        for place, value in enumerate(small.tolist()):
            labels[place].append((value, colour))
    for place, values_here in enumerate(labels):
        # the lines fall: there is room above on the right and below on the left
        _annotate(axes, place, max(values_here), offset=(7.0, 5.0), corner=("left", "bottom"))
        if len(values_here) > 1:
            _annotate(axes, place, min(values_here), offset=(-7.0, -5.0), corner=("right", "top"))
    floor = quantity.small * steps[0].rmse[signal] / steps[0].noise_ratio[signal]
    axes.axhline(floor, color="0.4", linestyle="--", linewidth=1.2, label="noise floor")
    axes.set_yscale("log")
    axes.margins(y=0.15)
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.yaxis.set_minor_formatter(NullFormatter())
    axes.set_xticks(places, [fill(verbatim(step.title), TITLE) for step in steps])
    axes.set_xlim(-0.4, len(steps) - 0.6)
    axes.set_ylabel(f"RMS error, {quantity.words} ({quantity.small_unit})")
    axes.legend(frameon=False)
    tidy(axes)


def _annotate(
    axes: Axes,
    place: int,
    label: tuple[float, str],
    *,
    offset: tuple[float, float],
    corner: tuple[str, str],
) -> None:
    value, colour = label
    axes.annotate(
        f"{value:.3g}",
        (place, value),
        offset,
        textcoords="offset points",
        ha=corner[0],
        va=corner[1],
        color=colour,
    )


def story(
    fitted: Sequence[FittedStep], steps: Sequence[Step], signal: str = "joint_position"
) -> Figure:
    """The whole way in one picture: the ladder, the final overlay, the errors of all steps.

    Parameters
    ----------
    fitted : models on the way, each with its comparison; the first recording is drawn
    steps : entries of the ladder, one for each step
    signal : name of the signal

    Returns
    -------
    matplotlib.figure.Figure
    """
    quantity = shown(signal)
    figure = Figure(figsize=(9.0, 9.5), layout="constrained")
    top, middle, bottom = figure.subplots(3, 1, gridspec_kw={"height_ratios": [3, 3, 3]})
    _draw_ladder(top, steps, signal)
    top.set_title("Error after each step", loc="left", fontsize="medium")
    final = (fitted[-1].heldout or fitted[-1].comparison).files[0]
    kind = "held-out" if fitted[-1].heldout else "fitted"
    first = (fitted[0].heldout or fitted[0].comparison).files[0]
    time = final.measurement.time
    measured = final.measurement.signals[signal]
    middle.plot(*envelope(time, measured), color=BLACK, lw=2.4, label="measured")
    colours = STEP_COLOURS[: len(fitted)]
    for file, step, colour in ((first, fitted[0], colours[0]), (final, fitted[-1], colours[-1])):
        simulated = file.trajectory[file.trajectory.measured(signal)]
        middle.plot(*envelope(time, simulated), color=colour, lw=1.0, label=verbatim(step.title))
    middle.set_ylabel(f"{quantity.words} ({quantity.unit})")
    title = f"{shortened(final.measurement.name)} ({kind} data)"
    middle.set_title(title, loc="left", pad=24.0, fontsize="medium")
    for step, colour in zip(fitted, colours, strict=True):
        file = (step.heldout or step.comparison).files[0]
        simulated = file.trajectory[file.trajectory.measured(signal)]
        error = quantity.small * (simulated - measured)
        bottom.plot(*envelope(time, error), color=colour, linewidth=1.0, label=verbatim(step.title))
    bottom.axhline(0.0, color="0.5", linewidth=0.8)
    bottom.set_ylabel(f"error ({quantity.small_unit})")
    bottom.set_xlabel("time (s)")
    bottom.set_title("simulated less measured", loc="left", pad=24.0, fontsize="medium")
    middle.sharex(bottom)
    for axes in (middle, bottom):
        # above the axes, below their title: the curves fill them
        axes.legend(frameon=False, loc="lower left", bbox_to_anchor=(0.0, 0.98), ncols=3)
        tidy(axes)
    return figure


def check_picture(path: Path) -> None:
    """Refuse a file name whose suffix is no format of pictures.

    Raises
    ------
    OutputError : the suffix is none of `PICTURES`
    """
    if path.suffix.lower() not in PICTURES:
        raise OutputError(
            f"{path}: no picture is written with this suffix; use {', '.join(PICTURES)}"
        )


def is_ours(path: Path) -> bool:
    """Whether this is a PNG that `save` wrote: such a one may be replaced unasked."""
    return path.is_file() and SOFTWARE.encode() in path.read_bytes()[:4096]


def save(figure: Figure, path: Path) -> None:
    """Write a figure; the suffix of the path chooses the format.

    Parameters
    ----------
    figure : Figure
    path : file with a suffix of `PICTURES`

    Raises
    ------
    OutputError : the suffix is not known
    """
    check_picture(path)
    metadata = {"Software": SOFTWARE} if path.suffix.lower() == ".png" else None
    figure.savefig(path, dpi=130, metadata=metadata)


def tidy(axes: Axes) -> None:
    axes.grid(visible=True, color="0.92")
    axes.spines[["top", "right"]].set_visible(False)
