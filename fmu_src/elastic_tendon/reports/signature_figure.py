"""Picture of how an effect shows; the data come from `signature`, nothing is computed here."""

from textwrap import fill

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from elastic_tendon.actuator.quantity import unit_text
from elastic_tendon.reports.comparison_figures import BLUE, VERMILLION, tidy
from elastic_tendon.reports.names import verbatim
from elastic_tendon.simulation.signature import HIDDEN, Beside, Signature

STATES = ("I", "III", "II")  # from negative deflections to positive ones, Fig. 4
LINE = 120  # characters that fit above the axes
FIXED = "\N{NO-BREAK SPACE}"  # where a line must not end


def signature_figure(signature: Signature) -> Figure:
    """Load over deflection, torque over deflection and a step, with the effect and without."""
    figure = Figure(figsize=(13.0, 4.6), layout="constrained")
    slow, fast, step = figure.subplots(1, 3)
    loading, swinging, stepping = signature.experiments
    _draw(slow, signature.slow_loop, loading)
    _draw(fast, signature.fast_loop, swinging)
    step.plot(signature.motor.x, signature.motor.y, "--", color="0.5", linewidth=1.0, label="motor")
    _draw(step, signature.step, stepping)
    slow.set_ylabel("load torque (N·m)")
    fast.set_ylabel("torque of the tendons on the joint (N·m)")
    step.set_ylabel("measured joint position (rad)")
    step.set_xlabel("time (s)")
    for axes in (slow, fast):
        axes.set_xlabel("measured deflection (rad)")
        _mark_states(axes, signature.slack_boundaries)
    step.legend(frameon=False, loc="lower right")
    figure.suptitle(_title(signature))
    return figure


def _draw(axes: Axes, beside: Beside, title: str) -> None:
    without, with_it = beside.without, beside.with_it
    axes.plot(without.x, without.y, color=BLUE, linewidth=2.6, alpha=0.6, label="without")
    axes.plot(with_it.x, with_it.y, color=VERMILLION, linewidth=1.2, label="with the effect")
    hidden = "; hardly any difference" if beside.difference < HIDDEN else ""
    axes.set_title(title + hidden, loc="left", fontsize="medium")
    tidy(axes)


def _mark_states(axes: Axes, boundaries: tuple[float, float]) -> None:
    """Write the slack states without the effect along the upper edge."""
    low, high = axes.get_xlim()
    ends = (low, *boundaries, high)
    for boundary in boundaries:
        axes.axvline(boundary, color="0.6", linewidth=0.8, linestyle=":")
    for name, left, right in zip(STATES, ends[:-1], ends[1:], strict=True):
        axes.text(
            *(0.5 * (left + right), 0.99, name),
            transform=axes.get_xaxis_transform(),
            ha="center",
            va="top",
            color="0.4",
        )


def _title(signature: Signature) -> str:
    units = {parameter.name: unit_text(parameter.unit) for parameter in signature.effect.parameters}
    numbers = [
        f"{name} = {value:.3g}" + ("" if units[name] == "1" else f" {units[name]}")
        for name, value in signature.numbers.items()
    ]
    times = "" if signature.times_typical == 1.0 else f"{signature.times_typical:g} × the "
    heading = f"{signature.effect.title} of {times}typical size on {signature.example}"
    below = fill(", ".join(number.replace(" ", FIXED) for number in numbers), LINE)
    return verbatim(f"{heading}\n{below}")
