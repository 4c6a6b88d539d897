"""A fleet in one figure: which robot has drifted, in which parameter, and which effect appeared."""

from collections.abc import Sequence
from textwrap import shorten
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, NullFormatter

from elastic_tendon import effects
from elastic_tendon.actuator.parameters import Model
from elastic_tendon.actuator.quantity import unit_suffix
from elastic_tendon.estimation.coordinates import free_parameters
from elastic_tendon.reports.comparison_figures import (
    BLACK,
    BLUE,
    GREEN,
    PURPLE,
    SKY,
    VERMILLION,
    tidy,
)
from elastic_tendon.reports.names import shortened, verbatim
from elastic_tendon.reports.sweep_tables import short
from elastic_tendon.reports.units import shown
from elastic_tendon.sweeps.fleet import (
    SIGNALS,
    UNKNOWN,
    error_columns,
    measured_signals,
    named,
)
from elastic_tendon.sweeps.fleet_findings import FleetFindings
from elastic_tendon.sweeps.task import APPEARED, DRIFTED, FAILURE, ROBOT, VERDICT

LIMIT = 30.0  # %, where the colours end
# from the largest fall to the largest rise; the least move has a colour as well
COLOURS = ((0.0, BLUE), (0.5, "#D5E7F4"), (0.5, "#FBE6D6"), (1.0, VERMILLION))
DARK = 0.6 * LIMIT  # from here on white letters are read better
MOST_NUMBERED = 16  # robots whose cells have room for numbers
MOST_ROWS = 100  # robots with a row of their own
MOST_STEPS = 1000  # of a curve over all robots
MANY = (13.0, 5.0)  # inch, of the figure of more
ROW, LOW_ROW, CELL = 0.36, 0.2, 0.62  # inch; rows are low where there are many
ERRORS, NAMES, BAR = 2.6, 2.2, 0.14  # inch: width of the errors, of names; height of the scale
LETTERS = 13.0  # of a reason in an inch
SIGNAL_COLOURS = dict(zip(SIGNALS, (BLACK, SKY, VERMILLION, GREEN, BLUE, PURPLE), strict=True))
LEAST = 0.1  # multiples of the noise: less is drawn there, as data without noise tell
RANGE = (0.7, 3.0)  # multiples of the noise that are always shown


def fleet_figure(model: Model, table: pd.DataFrame) -> Figure:
    """Robots down; parameters of the model, effects and errors across.

    A number is coloured where it moved significantly, by how far in % of what was given (where that
    is 0, of its one sigma). Where a robot could not be diagnosed the row says why. Of more than
    `MOST_ROWS` robots, how many differ in what, and how far.

    Parameters
    ----------
    model : Model that the robots were diagnosed against
    table : rows of a `Fleet`, at least one

    Returns
    -------
    matplotlib.figure.Figure
    """
    if len(table) > MOST_ROWS:
        return _of_many(model, table)
    paths, appeared = free_parameters(model), _appeared(table)
    rows = len(table) * (ROW if len(table) <= MOST_NUMBERED else LOW_ROW)
    widths = [CELL * len(paths), CELL * max(len(appeared), 1), ERRORS]
    figure = Figure(figsize=(NAMES + sum(widths), rows + 3.0), layout="constrained")
    (numbers, effects, errors), (scale, *spare) = figure.subplots(
        2, 3, gridspec_kw={"width_ratios": widths, "height_ratios": [rows, BAR]}
    )
    figure.suptitle("Which robot has drifted, and what has appeared in it")
    for axes in (numbers, effects, errors):
        axes.set_ylim(len(table) - 0.5, -0.5)
        _draw_failures(axes, table)
    mesh = _draw_numbers(numbers, model, table)
    _draw_effects(effects, table, appeared)
    _draw_errors(errors, table)
    _write_reasons(numbers, table, widths[0])
    numbers.set_yticks(np.arange(len(table)), [shortened(str(robot)) for robot in table[ROBOT]])
    bar = figure.colorbar(mesh, cax=scale, orientation="horizontal", extend="both")
    bar.set_label("change where a parameter moved significantly (% of the given value)")
    for axes in spare:
        axes.set_axis_off()
    spare[-1].legend(handles=_legend(table), loc="center", frameon=False, borderaxespad=0.0)
    return figure


def pooled_figure(found: FleetFindings) -> Figure:
    """What robots share: mean of each parameter with its 95 % interval, and how they spread.

    Parameters
    ----------
    found : FleetFindings

    Returns
    -------
    matplotlib.figure.Figure
    """
    figure = Figure(figsize=(9.0, 1.5 + ROW * max(len(found.pooled), 1)), layout="constrained")
    axes = figure.subplots()
    for row, shared in enumerate(found.pooled):
        scale = 100.0 / (max(abs(shared.mean), shared.spread) or 1.0)
        spread, ends = scale * shared.spread, [scale * end for end in shared.interval]
        middle = scale * shared.mean
        axes.hlines(row, -spread, spread, color=SKY, linewidth=7.0)
        axes.hlines(row, ends[0] - middle, ends[1] - middle, color=BLACK, linewidth=1.5)
        axes.plot(0.0, row, "o", color=BLACK, markersize=4.0)
    names = [
        f"{verbatim(short(shared.path))} = {shared.mean:.4g}{unit_suffix(found.units[shared.path])}"
        for shared in found.pooled
    ]
    axes.set_yticks(range(len(names)), names)
    axes.invert_yaxis()
    axes.set_xlabel("around the mean (% of it, or of one sigma where that is more)")
    figure.suptitle("Mean of the robots, its 95 % interval (line), their one sigma (bar)")
    tidy(axes)
    return figure


# ---- many robots -------------------------------------------------------------------------------


def _of_many(model: Model, table: pd.DataFrame) -> Figure:
    figure = Figure(figsize=MANY, layout="constrained")
    spread, counts, errors = figure.subplots(1, 3)
    figure.suptitle(f"What {len(table)} robots differ in")
    _draw_spread(spread, model, table)
    _draw_counts(counts, table)
    _draw_distribution(errors, table)
    for axes in (spread, counts, errors):
        tidy(axes)
    return figure


def _draw_spread(axes: Axes, model: Model, table: pd.DataFrame) -> None:
    """Estimates of each parameter in % of what was given: median, middle half, middle 90 %."""
    paths, values = free_parameters(model), model.values()
    for row, path in enumerate(paths):
        scale = abs(values[path]) or model.uncertainty_of(path)
        changes = 100.0 * (table[path].dropna().to_numpy() - values[path]) / scale
        if changes.size:
            ends = np.percentile(changes, (5, 25, 50, 75, 95))
            axes.hlines(row, ends[0], ends[4], color=BLUE, linewidth=1.0)
            axes.hlines(row, ends[1], ends[3], color=BLUE, linewidth=5.0)
            axes.plot(ends[2], row, "o", color=BLACK, markersize=4.0)
    names = [verbatim(path.removeprefix("transmission.")) for path in paths]
    axes.set_yticks(range(len(paths)), names)
    axes.invert_yaxis()
    axes.axvline(0.0, color="0.4", linestyle="--", linewidth=1.0)
    axes.set_xlabel("estimate less given (% of given; of one sigma where that is 0)")
    axes.set_title("parameters: median, half, 90 % of the robots", fontsize="medium")


def _draw_counts(axes: Axes, table: pd.DataFrame) -> None:
    """How many robots show what."""
    names, counts = [], []
    for effect_id in _appeared(table):
        known = effect_id in effects.BY_ID
        names.append(effects.BY_ID[effect_id].title if known else effect_id)
        counts.append(sum(effect_id in named(text) for text in table[APPEARED]))
    drifted = [path for text in table[DRIFTED] for path in named(text)]
    for path in sorted(set(drifted), key=drifted.count, reverse=True):
        names.append(f"{path.removeprefix('transmission.')} drifted")
        counts.append(drifted.count(path))
    names += ["adequate", "not diagnosed"]
    counts += [int((table[VERDICT] == "adequate").sum()), int((table[FAILURE] != "").sum())]
    bars = axes.barh(range(len(names)), counts, color=PURPLE)
    axes.bar_label(bars, padding=3, fontsize="small")
    axes.margins(x=0.15)
    axes.set_yticks(range(len(names)), list(map(verbatim, names)))
    axes.invert_yaxis()
    axes.set_xlabel("robots")
    axes.set_title("what appeared or drifted", fontsize="medium")


def _draw_distribution(axes: Axes, table: pd.DataFrame) -> None:
    """Share of robots with at most so large an error, before and after."""
    for signal in measured_signals(table):
        for when, style in (("before", ":"), ("after", "-")):
            ratios = np.maximum(table[_ratio(signal, when)].dropna().to_numpy(), LEAST)
            steps = min(len(ratios), MOST_STEPS)
            share = 100.0 * np.arange(1, steps + 1) / steps
            ratios = np.percentile(ratios, share, method="inverted_cdf")
            words = f"{shown(signal).words}, {'as given' if when == 'before' else 'improved'}"
            axes.step(
                *(ratios, share), style, where="post", color=SIGNAL_COLOURS[signal], label=words
            )
    axes.axvline(1.0, color="0.4", linestyle="--", linewidth=1.0)
    axes.set_xscale("log")
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.set_xlabel("RMS error (multiples of the noise)")
    axes.set_ylabel("robots with no more (%)")
    axes.set_title("error", fontsize="medium")
    axes.legend(frameon=False, fontsize="small")


# ---- numbers and effects -----------------------------------------------------------------------


def _draw_numbers(axes: Axes, model: Model, table: pd.DataFrame) -> QuadMesh:
    paths = free_parameters(model)
    changes = _changes(model, table)
    mesh = axes.pcolormesh(
        np.arange(len(paths) + 1) - 0.5,
        np.arange(len(table) + 1) - 0.5,
        np.ma.masked_invalid(changes),
        cmap=LinearSegmentedColormap.from_list("change", COLOURS),
        vmin=-LIMIT,
        vmax=LIMIT,
    )
    if len(table) <= MOST_NUMBERED:
        for row, column in np.argwhere(np.isfinite(changes)).tolist():
            _write(axes, column, row, float(changes[row, column]))
    _grid(axes, [path.removeprefix("transmission.") for path in paths], len(table))
    axes.set_title("parameters of the model", fontsize="medium")
    return mesh


def _changes(model: Model, table: pd.DataFrame) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Change of each parameter of each robot, %, (robots, parameters); NaN where it did not."""
    paths, values = free_parameters(model), model.values()
    changes = np.full((len(table), len(paths)), np.nan)
    for row, text in enumerate(table[DRIFTED]):
        for path in named(text):
            scale = abs(values[path]) or model.uncertainty_of(path)
            moved = float(table[path].iloc[row]) - values[path]
            changes[row, paths.index(path)] = 100.0 * moved / scale
    return changes


def _write(axes: Axes, column: int, row: int, percent: float) -> None:
    digits = 0 if abs(percent) >= 10.0 else 1
    colour = "white" if abs(percent) > DARK else "black"
    text = f"{percent:+.{digits}f} %"
    axes.text(column, row, text, ha="center", va="center", color=colour, fontsize="x-small")


def _appeared(table: pd.DataFrame) -> tuple[str, ...]:
    """Ids of all effects that appeared, in the catalogue's order; what none explains is last."""
    ids = {effect_id for text in table[APPEARED] for effect_id in named(text)}
    known = [effect_id for effect_id in effects.BY_ID if effect_id in ids]
    return (*known, *sorted(ids.difference(known, [UNKNOWN])), *sorted(ids & {UNKNOWN}))


def _draw_effects(axes: Axes, table: pd.DataFrame, appeared: Sequence[str]) -> None:
    for row, text in enumerate(table[APPEARED]):
        for effect_id in named(text):
            axes.plot(appeared.index(effect_id), row, marker="D", color=PURPLE, markersize=7.0)
    titles = [
        effects.BY_ID[effect_id].title if effect_id in effects.BY_ID else effect_id
        for effect_id in appeared
    ]
    _grid(axes, titles or ["none"], len(table))
    axes.set_title("effects", fontsize="medium")
    axes.set_yticks([])


def _grid(axes: Axes, names: Sequence[str], rows: int) -> None:
    places = np.arange(len(names))
    labels = [verbatim(name) for name in names]
    axes.set_xticks(places, labels, rotation=40, ha="right", rotation_mode="anchor")
    axes.set_xlim(-0.5, len(names) - 0.5)
    axes.vlines(places[1:] - 0.5, -0.5, rows - 0.5, color="0.85", linewidth=0.6)
    axes.hlines(np.arange(1, rows) - 0.5, -0.5, len(names) - 0.5, color="0.85", linewidth=0.6)
    axes.spines[:].set_color("0.7")


# ---- robots that were not diagnosed ------------------------------------------------------------


def _draw_failures(axes: Axes, table: pd.DataFrame) -> None:
    for row in np.flatnonzero(table[FAILURE] != "").tolist():
        axes.axhspan(row - 0.5, row + 0.5, facecolor="0.92", edgecolor="none", zorder=0)


def _write_reasons(axes: Axes, table: pd.DataFrame, width: float) -> None:
    """Why, as far as it fits into the width (inch)."""
    for row, reason in enumerate(table[FAILURE]):
        if reason:
            text = shorten(f"not diagnosed: {reason}", int(LETTERS * width), placeholder=" ...")
            words: dict[str, Any] = {"color": "0.25", "fontsize": "x-small"}
            background = {"facecolor": "0.92", "edgecolor": "none", "pad": 1.0}
            axes.text(-0.4, row, verbatim(text), va="center", bbox=background, **words)


# ---- errors ------------------------------------------------------------------------------------


def _draw_errors(axes: Axes, table: pd.DataFrame) -> None:
    """Error of each signal over its noise, before and after, on one scale."""
    signals = measured_signals(table)
    offsets = 0.4 * (np.arange(len(signals)) + 0.5) / max(len(signals), 1) - 0.2
    shown_ratios = list(RANGE)
    for signal, offset in zip(signals, offsets.tolist(), strict=True):
        before, after = (
            np.maximum(table[_ratio(signal, when)].to_numpy(), LEAST)
            for when in ("before", "after")
        )
        places, colour = np.arange(len(table)) + offset, SIGNAL_COLOURS[signal]
        axes.hlines(places, after, before, color=colour, linewidth=1.0)
        axes.plot(before, places, "o", color=colour, markerfacecolor="white", markersize=5.0)
        axes.plot(after, places, "o", color=colour, markersize=4.0)
        shown_ratios += [0.8 * np.nanmin(after), 1.3 * np.nanmax(before)]
    axes.axvline(1.0, color="0.4", linestyle="--", linewidth=1.0)
    axes.set_xscale("log")
    axes.set_xlim(min(shown_ratios), max(shown_ratios))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.set_xlabel("RMS error (multiples of the noise)")
    axes.set_title("error", fontsize="medium")
    axes.set_yticks([])
    tidy(axes)


def _legend(table: pd.DataFrame) -> list[Line2D]:
    style: dict[str, Any] = {"marker": "o", "linestyle": "none", "color": BLACK}
    handles = [
        Line2D([], [], label="as given", markerfacecolor="white", **style),
        Line2D([], [], label="improved", **style),
    ]
    signals = measured_signals(table)
    if len(signals) > 1:
        handles += [
            Line2D([], [], label=shown(signal).words, color=SIGNAL_COLOURS[signal])
            for signal in signals
        ]
    return handles


def _ratio(signal: str, when: str) -> str:
    return error_columns(signal)["noise_ratio", when]
