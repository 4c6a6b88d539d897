"""Picture of a describing function; the data come from it, nothing is computed here."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from elastic_tendon.actuator.design import design
from elastic_tendon.actuator.motion_kind import MotionKind
from elastic_tendon.actuator.transmission import deflection_limits, slack_boundaries
from elastic_tendon.linear.describing_function import DescribingFunction
from elastic_tendon.linear.limit_cycles import LimitCycle
from elastic_tendon.reports.comparison_figures import (
    BLACK,
    BLUE,
    GREEN,
    ORANGE,
    PURPLE,
    VERMILLION,
    tidy,
)
from elastic_tendon.reports.names import verbatim

STATES = (("I", ORANGE), ("II", PURPLE), ("III", GREEN))
LOSSLESS = 1e-6  # of the stiffness: damping times frequency below it is that of a model without
SAME = 1e-6  # relative, of lines that are drawn as one


def describing_function_figure(
    function: DescribingFunction, cycles: Sequence[LimitCycle] = ()
) -> Figure:
    """Equivalent stiffness over the amplitude of the deflection; damping below, if there is any.

    Parameters
    ----------
    function : DescribingFunction
    cycles : limit cycles that were found with it, marked on its stiffness

    Returns
    -------
    matplotlib.figure.Figure
    """
    lossless = (
        np.abs(function.damping).max() * function.frequency < LOSSLESS * function.stiffness.max()
    )
    heights = [3] if lossless else [3, 2]
    figure = Figure(figsize=(8.0, 1.0 + 1.2 * sum(heights)), layout="constrained")
    rows = figure.subplots(
        len(heights), 1, sharex=True, squeeze=False, gridspec_kw={"height_ratios": heights}
    )[:, 0]
    _draw_stiffness(rows[0], function)
    _mark_cycles(rows[0], cycles)
    if not lossless:
        rows[1].plot(function.amplitudes, function.damping, color=BLUE)
        rows[1].set_ylabel("equivalent damping\n(N·m·s/rad)")
        rows[1].set_ylim(bottom=min(0.0, function.damping.min()))
    for axes in rows:
        _mark_amplitudes(axes, function)
        tidy(axes)
    rows[0].legend(loc="upper left", bbox_to_anchor=(1.01, 1.0), frameon=False)
    rows[-1].set_xlabel("amplitude of the deflection (rad)")
    rows[-1].set_xlim(0.0, function.amplitudes[-1])
    if function.model.motion is MotionKind.ROTARY:
        degrees = rows[0].secondary_xaxis("top", functions=(np.rad2deg, np.deg2rad))
        degrees.set_xlabel("amplitude of the deflection (°)")
    figure.suptitle(_title(function))
    return figure


def _draw_stiffness(axes: Axes, function: DescribingFunction) -> None:
    table = design(function.model)
    stiffnesses = (table.stiffness_state_1, table.stiffness_state_2, table.stiffness_state_3)
    drawn: dict[float, tuple[str, str]] = {}
    for (state, colour), stiffness in zip(STATES, stiffnesses, strict=True):
        same = next(
            (known for known in drawn if np.isclose(known, stiffness, rtol=SAME)), stiffness
        )
        earlier, first_colour = drawn.get(same, ("", colour))
        drawn[same] = (f"{earlier} and {state}" if earlier else state, first_colour)
    for stiffness, (states, colour) in drawn.items():
        plural = "s" if " and " in states else ""
        bare = "\nwithout effects" if function.model.effect_ids else ""
        label = f"state{plural} {states}{bare}"
        axes.axhline(stiffness, color=colour, linestyle="--", label=label)
    if function.scatter.any():
        low, high = (
            function.stiffness - 2 * function.scatter,
            function.stiffness + 2 * function.scatter,
        )
        axes.fill_between(function.amplitudes, low, high, color=BLUE, alpha=0.25, linewidth=0)
    axes.plot(
        function.amplitudes, function.stiffness, color=BLUE, linewidth=2.0, label="equivalent"
    )
    axes.set_ylabel("equivalent stiffness\n(N·m/rad)")
    axes.set_ylim(bottom=0.0)


def _mark_cycles(axes: Axes, cycles: Sequence[LimitCycle]) -> None:
    for words, inside in (("attracting", BLACK), ("repelling", "white")):
        kind = [cycle for cycle in cycles if cycle.attracting == (words == "attracting")]
        if kind:
            places = [cycle.amplitude for cycle in kind], [cycle.stiffness for cycle in kind]
            style: dict[str, Any] = {"color": BLACK, "markerfacecolor": inside, "markersize": 8}
            axes.plot(*places, "o", label=f"{words}\nlimit cycle", **style)


def _mark_amplitudes(axes: Axes, function: DescribingFunction) -> None:
    """Where the swing reaches slack boundaries and deflection limits; its mean may move."""
    transmission = function.model.transmission
    amplitudes = np.concatenate(([0.0], function.amplitudes))
    means = np.concatenate((function.deflection[:1], function.deflection))
    kinds = (
        (slack_boundaries(transmission), "0.45", ":", "slack boundary"),
        (deflection_limits(transmission), VERMILLION, "-.", "deflection limit"),
    )
    for borders, colour, style, label in kinds:
        beyond = [amplitudes - np.abs(border - means) for border in borders]
        reached = sorted(np.interp(0.0, excess, amplitudes) for excess in beyond if excess[-1] > 0)
        if len(reached) == 2 and np.isclose(reached[0], reached[1], rtol=SAME):
            reached.pop()
        for index, amplitude in enumerate(reached):
            axes.axvline(
                *(amplitude, 0.0, 1.0),
                color=colour,
                linestyle=style,
                linewidth=1.2,
                label="_" if index else label,  # one entry of the legend for all of a kind
            )


def _title(function: DescribingFunction) -> str:
    low, high = function.deflection.min(), function.deflection.max()
    mean = f"{low:.3g} rad" if low == high else f"{low:.3g} to {high:.3g} rad"
    heading = f"{verbatim(function.model.name)}: stiffness that an oscillation sees"
    return f"{heading}\nmean deflection {mean}, frequency {function.frequency:.4g} rad/s"
