"""Fitted parameters in one figure: how far each moved, and how surely."""

from typing import Any

from matplotlib.figure import Figure

from elastic_tendon.actuator.quantity import unit_suffix
from elastic_tendon.estimation.determinability import Estimate
from elastic_tendon.estimation.fit import FitResult
from elastic_tendon.reports.comparison_figures import BLUE, tidy
from elastic_tendon.reports.names import verbatim
from elastic_tendon.reports.tables import four_digits


def estimates_figure(fit: FitResult) -> Figure:
    """How far each parameter moved, in multiples of its given uncertainty, and its 95 % interval.

    Parameters
    ----------
    fit : FitResult

    Returns
    -------
    matplotlib.figure.Figure; a parameter that the data leave open has a hollow mark
    """
    estimates = fit.findings.every
    figure = Figure(figsize=(9.0, 1.6 + 0.55 * len(estimates)), layout="constrained")
    axes = figure.subplots()
    axes.axvspan(-1.0, 1.0, color="0.92", label="one sigma of what was given")
    axes.axvline(0.0, color="0.5", linewidth=0.8)
    for row, estimate in enumerate(estimates):
        sigma = fit.given.uncertainty_of(estimate.path)
        low, high = ((end - estimate.given) / sigma for end in estimate.interval)
        axes.hlines(row, low, high, color=BLUE, linewidth=2.0)
        mark: dict[str, Any] = {} if estimate.determined else {"markerfacecolor": "white"}
        axes.plot((estimate.fitted - estimate.given) / sigma, row, "o", color=BLUE, **mark)
    axes.plot([], [], "o-", color=BLUE, label="fitted, with 95 % interval")
    axes.plot([], [], "o", color=BLUE, markerfacecolor="white", label="the data leave it open")
    axes.set_yticks(range(len(estimates)), [_words(estimate) for estimate in estimates])
    axes.set_ylim(len(estimates) - 0.5, -0.5)
    axes.set_xlabel("change (multiples of the given one sigma)")
    figure.legend(loc="outside lower center", ncols=3, frameon=False)
    figure.suptitle(f"{verbatim(fit.model.name)}: fitted parameters")
    tidy(axes)
    return figure


def _words(estimate: Estimate) -> str:
    unit = unit_suffix(estimate.unit)
    values = f"{four_digits(estimate.given)} → {four_digits(estimate.fitted)}{unit}"
    return f"{verbatim(estimate.name)}\n{values}"
