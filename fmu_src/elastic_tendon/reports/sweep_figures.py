"""What a sweep gave, in one figure: over what varied, over time, or how it is distributed."""

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from elastic_tendon.actuator.parameters import quantities
from elastic_tendon.actuator.quantity import unit_text
from elastic_tendon.actuator.transmission import SlackState
from elastic_tendon.actuator.variables import Variable
from elastic_tendon.comparison.simulated import SUFFIXES
from elastic_tendon.reports.comparison_figures import BLACK, BLUE, tidy
from elastic_tendon.reports.fleet_figure import fleet_figure
from elastic_tendon.reports.location_figures import STATE_COLOURS
from elastic_tendon.reports.names import at_dots, verbatim
from elastic_tendon.reports.thinning import some
from elastic_tendon.reports.trajectory_figure import runs_figure
from elastic_tendon.reports.units import with_unit
from elastic_tendon.reports.worded import worded_figure
from elastic_tendon.sweeps.bootstrap import Bootstrap
from elastic_tendon.sweeps.fleet import Fleet
from elastic_tendon.sweeps.simulations import TIME, Simulations, share_of
from elastic_tendon.sweeps.task import RUN, Task

MOST_FACTORS = 6  # side by side; a wider figure could not be read
COLUMNS = 3  # of distributions
ENDS = ("minimum", "maximum")


def sweep_figure(task: Task, table: pd.DataFrame) -> Figure:
    """Draw what the runs of a task gave.

    Parameters
    ----------
    task : what was done
    table : its results, a row or several for each run

    Returns
    -------
    matplotlib.figure.Figure
    """
    if isinstance(task, Fleet):
        return fleet_figure(task.model.model, table)
    if not isinstance(task, Simulations):
        return _distributions(task, table)
    motion = task.shipped.model.motion
    if task.keep == "statistics":
        return worded_figure(_statistics(task, table), motion)
    names = {variable.name + SUFFIXES[variable.unit]: variable.name for variable in task.variables}
    runs = runs_figure(table.set_index([RUN, TIME])[list(names)].rename(columns=names))
    return worded_figure(runs, motion)


# ---- statistics over what varied ---------------------------------------------------------------


def _statistics(task: Simulations, table: pd.DataFrame) -> Figure:
    """A row of axes for each statistic, a column for each parameter that varied."""
    every = [factor.path for factor in task.points.factors]
    paths, units = every[:MOST_FACTORS], _units(task)
    rows = [row for variable in task.variables for row in _rows(variable, table)]
    size = (2.2 + 2.6 * len(paths), 0.8 + 2.0 * len(rows))
    figure = Figure(figsize=size, layout="constrained")
    panels = figure.subplots(len(rows), len(paths), sharex="col", sharey="row", squeeze=False)
    chosen = table.iloc[some(len(table))]
    for line, row in zip(panels, rows, strict=True):
        for axes, path in zip(line, paths, strict=True):
            for series in row.series:
                style: dict[str, Any] = {"color": series.colour, "label": series.label}
                axes.plot(chosen[path], chosen[series.column], ".", ms=4, rasterized=True, **style)
            tidy(axes)
        line[0].set_ylabel(row.words)
        if len(row.series) > 1:
            line[-1].legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False)
    for axes, path in zip(panels[-1], paths, strict=True):
        axes.set_xlabel(_horizontal(path, units))
    some_paths = f", the first {len(paths)} of {len(every)}" if len(every) > len(paths) else ""
    name = verbatim(task.shipped.model.name)
    figure.suptitle(f"{name}: {task.runs} runs, over what varied{some_paths}")
    figure.align_ylabels()
    return figure


class _Series(NamedTuple):
    """One column of the table of results."""

    column: str
    label: str = ""
    colour: str = BLUE


class _Row(NamedTuple):
    """What one row of axes shows, in words with the unit."""

    words: str
    series: Sequence[_Series]


def _rows(variable: Variable, table: pd.DataFrame) -> Iterator[_Row]:
    """Of an output: its error where it was measured, else its ends; of a state its shares."""
    if variable.discrete:
        shares = _states(variable, table) or [_Series(f"{variable.name}.share")]
        yield _Row(f"{variable.name.replace('_', ' ')}\n(share of samples)", shares)
        return
    suffix = SUFFIXES[variable.unit]
    words = with_unit(variable.name).replace(" (", "\n(")
    kinds = {f"{variable.name}.{kind}{suffix}": kind for kind in ("rms_error", *ENDS)}
    error, *ends = kinds
    for column in [error] if error in table else ends:
        kind = "RMS error" if column == error else kinds[column]
        yield _Row(f"{kind}, {words}", [_Series(column)])


def _states(variable: Variable, table: pd.DataFrame) -> list[_Series]:
    """Shares of the slack states that occur."""
    columns = {f"{variable.name}.{share_of(state)}": STATE_COLOURS[state] for state in SlackState}
    return [
        _Series(column, label, colour)
        for column, (colour, label) in columns.items()
        if column in table and table[column].any()
    ]


# ---- distributions -----------------------------------------------------------------------------


def _distributions(task: Task, table: pd.DataFrame) -> Figure:
    """A histogram of each column of numbers; of refits also what the fit itself found."""
    names = [str(name) for name in table.select_dtypes("number").columns if name != RUN]
    columns = max(1, min(COLUMNS, len(names)))
    rows = max(1, -(-len(names) // columns))
    figure = Figure(figsize=(0.6 + 3.4 * columns, 0.8 + 2.4 * rows), layout="constrained")
    panels: list[Axes] = list(figure.subplots(rows, columns, squeeze=False).flat)
    fitted, units = _fitted(task), _units(task)
    for axes, name in zip(panels, names, strict=False):
        values = table[name].to_numpy(dtype=float)
        axes.hist(values[np.isfinite(values)], bins="auto", color=BLUE)
        if name in fitted:
            axes.axvline(fitted[name], color=BLACK, label="fitted")
            axes.legend(frameon=False)
        axes.set_xlabel(_horizontal(name, units))
        axes.set_ylabel("runs")
        tidy(axes)
        axes.set_axisbelow(True)
    for axes in panels[len(names) :]:
        axes.set_visible(False)
    figure.suptitle(f"{task.runs} runs")
    return figure


def _fitted(task: Task) -> dict[str, float]:
    estimates = task.estimates if isinstance(task, Bootstrap) else ()
    return {estimate.path: estimate.fitted for estimate in estimates}


def _units(task: Task) -> dict[str, str]:
    """Units of the model's parameters; none of a task that is not known."""
    if isinstance(task, Simulations):
        effect_ids = task.shipped.model.effect_ids
    elif isinstance(task, Bootstrap):
        effect_ids = task.fitted.model.effect_ids
    else:
        return {}
    return {quantity.path: quantity.unit for quantity in quantities(effect_ids)}


def _horizontal(name: str, units: dict[str, str]) -> str:
    words = verbatim(at_dots(name))
    return f"{words} ({unit_text(units[name])})" if name in units else words
