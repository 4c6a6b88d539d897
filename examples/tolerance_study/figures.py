"""Figures: where tendons go slack, and how the loops behave, over all machines."""

from collections.abc import Mapping
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import FuncFormatter

PARTS = ("upper spring's stiffness", "lower spring's stiffness", "pretension")
PART_COLOURS = ("C0", "skyblue", "C1")
DESIGN_LINES = (("C3", "-"), ("C0", "--"), ("C2", "-."))
BINS = 40


def draw_boundaries(
    boundaries: Mapping[str, tuple[np.ndarray, float]],
    moved: Mapping[str, Mapping[str, float]],
    required: float,
    picture: Path,
) -> None:
    """Where the upper tendon goes slack, and which tolerance moves it.

    Parameters
    ----------
    boundaries : label with unit -> simulated values (k,), and that of the nominal machine; the
        second is the torque
    moved : boundary -> number -> share by which one sigma moves it
    required : N·m that the joint shall bear with both tendons taut
    """
    figure, axes = plt.subplots(1, 3, figsize=(11.0, 3.8), layout="constrained")
    for ax, (label, (values, nominal)) in zip(axes, boundaries.items(), strict=False):
        ax.hist(values, BINS, color="skyblue")
        ax.axvline(nominal, color="black", label="nominal")
        ax.set(xlabel=label, ylabel="machines")
    axes[1].axvline(required, color="C3", linestyle="--", label="required")
    axes[0].legend()
    axes[1].legend()
    _draw_parts(axes[2], moved)
    figure.suptitle("Where the upper tendon goes slack")
    figure.savefig(picture, dpi=120)
    plt.close(figure)


def _draw_parts(ax: Axes, moved: Mapping[str, Mapping[str, float]]) -> None:
    for i, (part, colour) in enumerate(zip(PARTS, PART_COLOURS, strict=True)):
        shares = [100.0 * list(numbers.values())[i] for numbers in moved.values()]
        ax.bar(np.arange(len(shares)) + 0.27 * (i - 1), shares, 0.25, color=colour, label=part)
    ax.axhline(0.0, color="black", linewidth=0.8)
    ax.set_xticks(range(len(moved)), list(moved))
    ax.set(xlabel="slack boundary", ylabel="moved by one sigma of a tolerance (%)")
    ax.set_ylim(top=18.0)
    ax.legend(fontsize="small", loc="upper center")


def draw_loops(
    damping: Mapping[str, np.ndarray],
    overshoot: Mapping[str, np.ndarray],
    limits: tuple[float, float],
    picture: Path,
) -> None:
    """Share of machines below a damping and above an overshoot, for each design.

    Parameters
    ----------
    damping, overshoot : design -> least and largest of the slack states, (k,)
    limits : of both, as required
    """
    figure, (left, right) = plt.subplots(
        1, 2, figsize=(9.0, 4.0), sharey=True, layout="constrained"
    )
    for (name, values), (colour, style) in zip(damping.items(), DESIGN_LINES, strict=True):
        ranks = 100.0 * (np.arange(len(values)) + 0.5) / len(values)
        line = {"color": colour, "linestyle": style, "label": f"designed for: {name}"}
        left.plot(np.sort(values), ranks, **line)
        right.plot(100.0 * np.sort(overshoot[name])[::-1], ranks, **line)
    for ax, limit in zip((left, right), (limits[0], 100.0 * limits[1]), strict=True):
        ax.axvline(limit, color="black", linestyle=":", label="required")
        ax.set_yscale("log")
        ax.yaxis.set_major_formatter(FuncFormatter(lambda share, _: f"{share:g}"))
        ax.grid(alpha=0.3)
    left.set(xlabel="least damping ratio of the slack states", ylabel="machines below (%)")
    right.set(xlabel="largest overshoot of a step (%)", ylabel="machines above (%)")
    right.yaxis.set_tick_params(labelleft=True)
    right.legend(fontsize="small", loc=(0.32, 0.42))
    figure.suptitle("The position loop of machines that differ from the one it was designed for")
    figure.savefig(picture, dpi=120)
    plt.close(figure)
