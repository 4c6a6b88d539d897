"""What was simulated or recorded, over time."""

from collections.abc import Mapping, Sequence
from typing import Any

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from elastic_tendon.actuator.quantity import unit_text
from elastic_tendon.measurement import Measurement
from elastic_tendon.reports.comparison_figures import BLACK, BLUE, static_torque, tidy
from elastic_tendon.reports.names import at_dots, shortened, verbatim
from elastic_tendon.reports.thinning import Array, envelope, some
from elastic_tendon.reports.units import shown, with_unit
from elastic_tendon.simulation.simulate import Sensitivities, Trajectory

DRAWN = ("joint_position", "joint_torque", "slack_state")
MOST_RUNS = 100  # more lines could not be distinguished
FEW_RUNS = 5  # lines of more than these are faint, for they lie upon each other
FAINT = 0.3
Curve = tuple[Array, Array]  # time, values


def trajectory_figure(trajectory: Trajectory) -> Figure:
    """Draw joint position, joint torque and slack state over time, those that there are.

    Parameters
    ----------
    trajectory : Trajectory

    Returns
    -------
    matplotlib.figure.Figure; one pair of axes for each
    """
    known = trajectory.keys()
    drawn = [name for name in DRAWN if name in known]
    return _over_time({name: [(trajectory.time, trajectory[name])] for name in drawn}, color=BLUE)


def measurement_figure(measurement: Measurement) -> Figure:
    """Draw inputs and signals of a recording over time; of a static curve, torque over deflection.

    Parameters
    ----------
    measurement : Measurement

    Returns
    -------
    matplotlib.figure.Figure; one pair of axes for each input and signal
    """
    if measurement.static:
        figure = _static_figure(measurement)
    else:
        columns = {**measurement.inputs, **measurement.signals}
        curves = {name: [(measurement.time, values)] for name, values in columns.items()}
        figure = _over_time(curves, color=BLACK)
    figure.suptitle(shortened(measurement.name))
    return figure


def runs_figure(table: pd.DataFrame) -> Figure:
    """Draw outputs of many runs over time, a line for each run, at most `MOST_RUNS`.

    Parameters
    ----------
    table : an output in each column, by its name, SI; the index is run and time (s)

    Returns
    -------
    matplotlib.figure.Figure; one pair of axes for each output
    """
    every = [run.droplevel(0) for _, run in table.groupby(level=0)]
    runs = [run for run in every if run.notna().any(axis=None)]
    chosen = [runs[index] for index in some(len(runs), MOST_RUNS)]
    curves = {
        str(name): [(run.index.to_numpy(), run[name].to_numpy()) for run in chosen]
        for name in table.columns
    }
    alpha = FAINT if len(chosen) > FEW_RUNS else 1.0
    figure = _over_time(curves, color=BLUE, alpha=alpha, linewidth=0.8)
    failed = f", {len(every) - len(runs)} failed" if len(every) > len(runs) else ""
    few = f", {len(chosen)} drawn" if len(chosen) < len(runs) else ""
    figure.suptitle(f"{len(every)} runs{failed}{few}")
    return figure


def sensitivities_figure(sensitivities: Sensitivities) -> Figure:
    """Draw derivatives of joint position and joint torque over time.

    Parameters
    ----------
    sensitivities : Sensitivities

    Returns
    -------
    matplotlib.figure.Figure; a row of axes for each parameter and initial state
    """
    rows = len(sensitivities.names)
    figure = Figure(figsize=(10.0, 1.0 + 1.9 * rows), layout="constrained")
    outputs = sensitivities.main_outputs
    panels = figure.subplots(rows, len(outputs), sharex=True, squeeze=False)
    for column, output in zip(panels.T, outputs, strict=True):
        column[0].set_title(f"derivative of the {shown(output).words}", fontsize="medium")
        column[-1].set_xlabel("time (s)")
        for axes, name, unit, values in zip(
            *(column, sensitivities.names, sensitivities.units, sensitivities.of(output).T),
            strict=True,
        ):
            axes.plot(*envelope(sensitivities.trajectory.time, values), color=BLUE)
            words = verbatim(at_dots(name))
            per = f"{shown(output).unit} per {unit_text(unit)}"
            axes.set_ylabel(f"by {words}\n({per})", fontsize="small")
            tidy(axes)
    figure.align_ylabels()
    return figure


def _over_time(curves: Mapping[str, Sequence[Curve]], **style: Any) -> Figure:
    """A pair of axes for each variable, with its curves."""
    figure = Figure(figsize=(8.0, 0.6 + 1.8 * len(curves)), layout="constrained")
    panels = figure.subplots(len(curves), 1, sharex=True, squeeze=False)[:, 0]
    for axes, (name, lines) in zip(panels, curves.items(), strict=True):
        for time, values in lines:
            _draw(axes, name, time, values, style)
        tidy(axes)
    panels[-1].set_xlabel("time (s)")
    figure.align_ylabels()
    return figure


def _draw(axes: Axes, name: str, time: Array, values: Array, style: Mapping[str, Any]) -> None:
    if name == "slack_state":
        axes.step(time, values, where="post", **style)
        axes.set_ylabel("slack state")
        axes.set_yticks([1, 2, 3, 4], ["I", "II", "III", "both slack"])
    else:
        axes.plot(*envelope(time, values), **style)
        axes.set_ylabel(with_unit(name).replace(" (", "\n("))


def _static_figure(measurement: Measurement) -> Figure:
    figure = Figure(figsize=(7.0, 5.0), layout="constrained")
    axes = figure.subplots()
    kept = some(len(measurement.time))
    deflection = measurement.signals["joint_position"][kept]
    axes.plot(deflection, static_torque(measurement)[kept], ".", color=BLACK)
    axes.set_xlabel("deflection (rad)")
    axes.set_ylabel("joint torque (N·m)")
    tidy(axes)
    return figure
