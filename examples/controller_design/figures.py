"""Figures: what the joint does, and the loops in the complex plane."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import control
import matplotlib.pyplot as plt
import numpy as np
from design import SAMPLE, Design
from experiment import Scenario, Signals
from matplotlib.axes import Axes
from robustness import FREQUENCIES, loop

from elastic_tendon import LimitCycle, SlackState

COLOURS = ("C3", "C0", "C2")  # of the designs, from matplotlib's cycle
STYLES = ("-", "--", "-.")  # as two of them may coincide
PREDICTED = {"color": "black", "linestyle": ":", "linewidth": 1.0}
STATE_COLOURS = {SlackState.III: "C0", SlackState.I: "C3"}


def draw_motion(runs: Mapping[Scenario, Mapping[str, Signals]], picture: Path) -> None:
    """Errors of the joint over time, a panel for each scenario; shaded where a tendon is slack."""
    size = (7.5, 2.1 * len(runs))
    figure, panels = plt.subplots(len(runs), 1, figsize=size, sharex=True, layout="constrained")
    for axes, (scenario, by_design) in zip(panels, runs.items(), strict=True):
        _draw_errors(axes, by_design)
        axes.set_title(scenario.name, fontsize="medium", loc="left")
        axes.set_ylabel("error (mrad)")
    panels[0].legend(loc="center right", fontsize="small")
    panels[-1].set_xlabel("time (s)")
    figure.savefig(picture, dpi=110)


def _draw_errors(axes: Axes, by_design: Mapping[str, Signals]) -> None:
    for (name, run), colour, style in zip(by_design.items(), COLOURS, STYLES, strict=True):
        error = 1e3 * (run["joint"] - run["reference"])
        axes.plot(run["time"], error, style, color=colour, label=name, linewidth=1.2)
    _shade_slack(axes, run, f"slack, {name}")


def _shade_slack(axes: Axes, run: Signals, label: str) -> None:
    slack = run["slack_state"] != SlackState.III.value
    shade = {"color": "skyblue", "alpha": 0.25, "linewidth": 0, "label": label}
    transform = axes.get_xaxis_transform()
    axes.fill_between(run["time"], 0, 1, slack, transform=transform, **shade)
    axes.set_xlim(run["time"][0], run["time"][-1])


def draw_delayed(run: Signals, cycles: Sequence[LimitCycle], picture: Path) -> None:
    """The limit cycle of late commands: from the taut joint at rest until it is well in it."""
    figure, axes = plt.subplots(figsize=(7.5, 3.0), layout="constrained")
    begin = {name: values[run["time"] < 3.0] for name, values in run.items()}
    deflection = 1e3 * (begin["joint"] - begin["motor"])
    axes.plot(begin["time"], deflection, color=COLOURS[0], linewidth=1.2, label="taut only, late")
    _shade_slack(axes, begin, "slack")
    for cycle in cycles:
        for turn in (-cycle.amplitude, cycle.amplitude):
            axes.axhline(1e3 * (cycle.deflection + turn), **PREDICTED)
    axes.plot([], [], **PREDICTED, label="predicted: limit cycle")
    axes.set(xlabel="time (s)", ylabel="deflection (mrad)")
    axes.legend(loc="lower right", fontsize="small")
    figure.savefig(picture, dpi=110)


def draw_loops(
    plants: Mapping[SlackState, control.StateSpace], designs: Mapping[str, Design], picture: Path
) -> None:
    """Nyquist plots near -1, a panel for each design."""
    size = (9.0, 3.4)
    figure, panels = plt.subplots(1, len(designs), figsize=size, sharey=True, layout="constrained")
    circle = np.exp(1j * np.linspace(0.0, 2.0 * np.pi, 400))
    for axes, (name, design) in zip(panels, designs.items(), strict=True):
        axes.plot(circle.real, circle.imag, color="0.75", linewidth=0.8)
        for state, colour in STATE_COLOURS.items():
            response = loop(plants[state], design[state])(np.exp(1j * FREQUENCIES * SAMPLE))
            label = "both taut" if state is SlackState.III else "one slack"
            axes.plot(response.real, response.imag, color=colour, label=label)
        axes.plot(-1.0, 0.0, "+", color="black", markersize=9, markeredgewidth=1.5)
        axes.set(xlim=(-2.2, 1.2), ylim=(-2.2, 1.2), aspect="equal", xlabel="real part of the loop")
        axes.set_title(name, fontsize="medium")
    panels[0].set_ylabel("imaginary part")
    panels[0].legend(loc="upper left", fontsize="small")
    figure.savefig(picture, dpi=110)
