"""Figures of an actuator's design; the data come from `design`, nothing is computed here."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from elastic_tendon.actuator import design
from elastic_tendon.actuator.design import CharacteristicCurve
from elastic_tendon.actuator.motion_kind import MotionKind
from elastic_tendon.actuator.parameters import Model
from elastic_tendon.reports.names import verbatim

DARKEST, LIGHTEST = 0.0, 0.85  # part of viridis that stands out from white paper


def characteristic_curves(model: Model, pretensions: Sequence[float] | None = None) -> Figure:
    """Torque and stiffness over deflection at several pretensions, as Figs. 7 to 9.

    Parameters
    ----------
    model : Model
    pretensions : sequence of float, N; None: a family around the model's own

    Returns
    -------
    matplotlib.figure.Figure; the model's own pretension is drawn thick

    Raises
    ------
    ModelError
        for a pretension above (27)
    """
    curves = design.characteristic_curves(model, pretensions)
    title = f"{verbatim(model.name)}: characteristic curves over pretension"
    return curves_figure(curves, title, model.transmission.pretension_force)


def curves_figure(
    curves: Sequence[CharacteristicCurve], title: str, own: float | None = None
) -> Figure:
    """Torque and stiffness over deflection of some curves.

    Parameters
    ----------
    curves : by rising pretension
    title : above them
    own : N; pretension of the curve that is drawn thick, as the model's own

    Returns
    -------
    matplotlib.figure.Figure
    """
    figure = Figure(figsize=(7.0, 7.0), layout="constrained")
    torque_axes, stiffness_axes = figure.subplots(
        2, 1, sharex=True, gridspec_kw={"height_ratios": [2, 1]}
    )
    shades = np.linspace(DARKEST, LIGHTEST, len(curves))
    for curve, shade in zip(curves, shades, strict=True):
        _draw_curve(torque_axes, stiffness_axes, curve, colormaps["viridis"](shade), own)

    figure.suptitle(title)
    torque_axes.set_ylabel(r"torque on the joint ${}^j\tau_e$ (N·m)")
    stiffness_axes.set_ylabel("stiffness (N·m/rad)")
    stiffness_axes.set_xlabel(r"joint deflection $q - {}^j\theta$ (rad)")
    stiffness_axes.set_ylim(bottom=0.0)
    if curves[0].motion is MotionKind.ROTARY:
        degrees = torque_axes.secondary_xaxis("top", functions=(np.rad2deg, np.deg2rad))
        degrees.set_xlabel("joint deflection (°)")
    for axes in (torque_axes, stiffness_axes):
        axes.grid(visible=True, color="0.9")
        axes.axhline(0.0, color="0.6", linewidth=0.8)
    _legend(torque_axes)
    return figure


def _draw_curve(
    torque_axes: Axes,
    stiffness_axes: Axes,
    curve: CharacteristicCurve,
    colour: tuple[float, float, float, float],
    own: float | None,
) -> None:
    is_own = curve.pretension == own
    line: dict[str, Any] = {
        "color": colour,
        "linewidth": 3.5 if is_own else 1.3,
        "zorder": 2.0 if is_own else 2.5,
    }
    label = f"$F_p$ = {curve.pretension:.4g} N" + (" (model)" if is_own else "")
    torque_axes.plot(curve.deflection, curve.torque, label=label, **line)
    stiffness_axes.plot(curve.deflection, curve.stiffness, **line)
    ends = [0, -1]
    torque_axes.plot(curve.deflection[ends], curve.torque[ends], "|", color=colour, markersize=11)
    torque_axes.plot(
        curve.slack_boundaries,
        curve.boundary_torques,
        "o",
        color=colour,
        markerfacecolor="white",
        markersize=6,
    )


def _legend(axes: Axes) -> None:
    marks = [
        Line2D([], [], color="0.3", marker="o", markerfacecolor="white", linestyle="none"),
        Line2D([], [], color="0.3", marker="|", markersize=11, linestyle="none"),
    ]
    handles, labels = axes.get_legend_handles_labels()
    axes.legend(
        [*handles, *marks],
        [*labels, "slack boundary, paper (14)", "largest deflection, paper (16)"],
        loc="upper right",
    )
