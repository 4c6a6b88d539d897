"""Linear models of all states in one picture: frequency responses, poles and zeros."""

from collections.abc import Sequence
from typing import Any

import control
import numpy as np
from control.pzmap import PoleZeroData
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from elastic_tendon.actuator.quantity import unit_text
from elastic_tendon.actuator.transmission import SlackState
from elastic_tendon.linear.analysis import (
    JOINT_POSITION,
    analyse,
    frequencies,
    is_joint_given,
    main_channels,
)
from elastic_tendon.linear.names import unit_of
from elastic_tendon.linear.result import Array, Drive, LinearModel
from elastic_tendon.linear.selection import selected
from elastic_tendon.reports.comparison_figures import (
    BLUE,
    GREEN,
    ORANGE,
    PURPLE,
    VERMILLION,
    tidy,
)
from elastic_tendon.reports.linear_tables import columns, title_of
from elastic_tendon.reports.names import verbatim

# states lie upon each other in symmetric actuators: later ones are thinner, with other gaps
_STYLES: dict[SlackState | None, dict[str, Any]] = {
    SlackState.I: {"color": ORANGE, "linestyle": "-", "linewidth": 3.2},
    SlackState.BOTH: {"color": VERMILLION, "linestyle": (0, (1, 1.5)), "linewidth": 2.0},
    SlackState.II: {"color": PURPLE, "linestyle": (0, (4, 3)), "linewidth": 1.7},
    SlackState.III: {"color": GREEN, "linestyle": "-", "linewidth": 1.5},
    None: {"color": BLUE, "linestyle": (0, (6, 2, 1, 2)), "linewidth": 1.6},  # a second of one
}
_MARKER = 5.0  # points, and how much a marker grows with the line
_FAR = 10.0  # times the largest pole: zeros beyond are named, not drawn


def linear_figure(
    name: str, models: Sequence[LinearModel], channel: tuple[str, str] | None = None
) -> Figure:
    """Bode plots of one or two channels, and poles and zeros of the first, all states overlaid.

    Parameters
    ----------
    name : of the actuator
    models : of one drive, with all inputs and outputs
    channel : input and output; None: collocated and non-collocated of a torque-driven rotor, from
        a given joint's position and from the motor to the joint's torque, else from motor and from
        load to the joint's position

    Returns
    -------
    matplotlib.figure.Figure
    """
    channels = _drawn(models[0]) if channel is None else [channel]
    figure = Figure(figsize=(4.3 * (len(channels) + 1), 6.4), layout="constrained")
    grid = figure.add_gridspec(2, len(channels) + 1)
    styled = _styled(models)
    omega = frequencies([analyse(model) for _, model in columns(models)])
    for place, drawn in enumerate(channels):
        upper = figure.add_subplot(grid[0, place])
        lower = figure.add_subplot(grid[1, place], sharex=upper)
        _draw_bode(upper, lower, styled, drawn, omega)
    _draw_poles(figure.add_subplot(grid[:, -1]), styled, channels[0])
    figure.suptitle(title_of(verbatim(name), models[0]))
    handles = [Line2D([], [], label=label, **style) for label, _, style in styled]
    figure.legend(handles=handles, loc="outside lower center", ncols=2, frameon=False)
    return figure


def _drawn(model: LinearModel) -> list[tuple[str, str]]:
    if model.drive is Drive.TORQUE or is_joint_given(model):
        return list(main_channels(model)[:2])
    return [channel for channel in main_channels(model) if channel[1] == JOINT_POSITION]


_Styled = list[tuple[str, LinearModel, dict[str, Any]]]


def _styled(models: Sequence[LinearModel]) -> _Styled:
    """Label, model and style, thick lines first."""
    styled: _Styled = []
    used: set[SlackState] = set()
    for towards, model in columns(models):
        state = model.validity.slack_state
        style = _STYLES[None if state in used else state]
        used.add(state)
        styled.append((_label(towards, model), model, style))
    return sorted(styled, key=lambda entry: -float(entry[2]["linewidth"]))


def _label(towards: str, model: LinearModel) -> str:
    at = model.validity.operating_point
    parts = [model.validity.slack_state.label, towards]
    parts.append(f"at {at.outputs['deflection']:.3g} rad, load {at.inputs['load_torque']:.3g} N·m")
    parts.append("" if model.validity.active else "not active there")
    return ", ".join(part for part in parts if part)


def _draw_bode(
    upper: Axes, lower: Axes, styled: _Styled, channel: tuple[str, str], omega: Array
) -> None:
    for _, model, style in styled:
        if not analyse(model).channel(*channel).responds:
            continue  # what would be drawn is rounding
        system = selected(model, channel[:1], channel[1:])
        response = control.frequency_response(system, omega)
        control.bode_plot(
            response,
            ax=np.array([[upper], [lower]]),
            initial_phase=-90.0,  # the range of a motor's torque up to that of a position
            show_legend=False,
            grid=False,
            **style,
        )
    if not upper.lines:
        upper.text(0.5, 0.5, "no response", transform=upper.transAxes, ha="center")
        upper.set(xscale="log", yscale="log", xlim=(omega[0], omega[-1]))
    names = [signal.replace("_", " ") for signal in channel]
    upper.set_title(f"{names[0]} → {names[1]}", fontsize="medium")
    upper.set_ylabel(f"magnitude ({ratio_of_units(*channel)})")
    lower.set_ylabel("phase (°)")
    lower.set_xlabel("angular frequency (rad/s)")
    upper.set_xlabel("")
    upper.tick_params(labelbottom=False)
    for axes in (upper, lower):
        tidy(axes)
    hertz = upper.secondary_xaxis("top", functions=(_hertz, _angular))
    hertz.set_xlabel("frequency (Hz)")


def _hertz(frequency: Any) -> Any:
    return frequency / (2.0 * np.pi)


def _angular(frequency: Any) -> Any:
    return frequency * (2.0 * np.pi)


def ratio_of_units(input_name: str, output_name: str) -> str:
    """Unit of the response of an output to an input."""
    over, under = (unit_text(unit_of(signal) or "1") for signal in (output_name, input_name))
    if over == under:
        return "1"
    return f"{over}/({under})" if "·" in under or "/" in under else f"{over}/{under}"


def _draw_poles(axes: Axes, styled: _Styled, channel: tuple[str, str]) -> None:
    left_out: set[str] = set()
    for _, model, style in styled:
        poles = np.asarray(model.poles())
        zeros = np.array(analyse(model).channel(*channel).zeros, dtype=complex)
        far = np.abs(zeros) > _FAR * np.abs(poles).max(initial=1.0)
        left_out.update(f"{zero:.3g}" for zero in zeros[far].real)
        control.pole_zero_plot(
            PoleZeroData(poles, zeros[~far], dt=0),
            ax=axes,
            color=style["color"],
            marker_size=_MARKER + 2.5 * style["linewidth"],
            marker_width=style["linewidth"],
            show_legend=False,
        )
    axes.axhline(0.0, color="0.5", linewidth=0.8, zorder=1)
    axes.axvline(0.0, color="0.5", linewidth=0.8, zorder=1)
    axes.margins(0.15)
    if not any(model.poles().any() for _, model, _ in styled):
        axes.set(xlim=(-1.0, 1.0), ylim=(-1.0, 1.0))  # all at the origin
    axes.set_xlabel("real part (rad/s)")
    axes.set_ylabel("imaginary part (rad/s)")
    words = " → ".join(signal.replace("_", " ") for signal in channel)
    far_away = f"\nfar away: zeros at {', '.join(sorted(left_out))} rad/s" if left_out else ""
    axes.set_title(f"poles ×, zeros ○\n{words}{far_away}", fontsize="medium")
    tidy(axes)
