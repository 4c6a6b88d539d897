"""Figures of a diagnosis, one function for each; nothing is computed here."""

from collections.abc import Iterator, Sequence
from functools import partial
from textwrap import fill
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure, SubFigure
from matplotlib.ticker import PercentFormatter

from elastic_tendon.comparison.comparison import Comparison, FileComparison
from elastic_tendon.comparison.residuals import Array
from elastic_tendon.diagnosis.explained import (
    Explained,
    explained_by_effect,
    explained_by_learned,
    is_told,
    mean_curve,
    told_effects,
)
from elastic_tendon.diagnosis.result import Candidate, Diagnosis, Experiment, Round
from elastic_tendon.reports.comparison_figures import (
    BLACK,
    BLUE,
    LEGEND,
    ORANGE,
    STEP_COLOURS,
    VERMILLION,
    ladder,
    static_torque,
    tidy,
)
from elastic_tendon.reports.diagnosis_tables import NONE, called, called_set, none_of_them
from elastic_tendon.reports.experiment_panels import panels_of, title_of
from elastic_tendon.reports.location_figures import Drawing, file_names, missing_torque
from elastic_tendon.reports.names import shortened, verbatim
from elastic_tendon.reports.thinning import envelope, some
from elastic_tendon.reports.units import shown, times_noise

BARS = 8  # candidates of a round that are drawn
LETTERS = 22  # in a line beside a low panel


def all_figures(diagnosis: Diagnosis) -> Iterator[tuple[str, Drawing]]:
    """Every figure of a diagnosis: the name of its file without suffix, and what draws it."""
    for signal in diagnosis.ladder[0].rmse:
        yield f"ladder_{signal}", partial(ladder, diagnosis.ladder, signal)
    if any(candidate_round.candidates for candidate_round in diagnosis.rounds):
        yield "candidates", partial(candidates, diagnosis.rounds)
    for effect_id in told_effects(diagnosis):
        yield f"explained_by_{effect_id}", partial(explained_by, diagnosis, effect_id)
    yield from _of_recordings(diagnosis)
    if diagnosis.learned is not None and is_told(diagnosis):
        yield "learned_term", partial(learned_term, diagnosis)
    if diagnosis.next_experiment is not None:
        yield "next_experiment", partial(next_experiment, diagnosis.next_experiment)


def _of_recordings(diagnosis: Diagnosis) -> Iterator[tuple[str, Drawing]]:
    first, last = diagnosis.steps[0], diagnosis.steps[-1]
    pairs = [(*pair, "fitted") for pair in _pairs(first.comparison, last.comparison)]
    if first.heldout is not None and last.heldout is not None:
        pairs += [(*pair, "held-out") for pair in _pairs(first.heldout, last.heldout)]
    names = file_names([after.measurement.name for _, after, _ in pairs])
    for name, (before, after, kind) in zip(names, pairs, strict=True):
        yield f"{name}_before_and_after", partial(before_and_after, before, after, kind)
    located = zip(diagnosis.comparison.files, diagnosis.location.files, strict=True)
    for name, (file, location) in zip(names, located, strict=False):  # those held out come last
        if location.missing_torque.known:
            yield f"{name}_remaining_torque", partial(missing_torque, file, location)


def _pairs(
    before: Comparison, after: Comparison
) -> Iterator[tuple[FileComparison, FileComparison]]:
    return zip(before.files, after.files, strict=True)


# ---- before and after --------------------------------------------------------------------------


def before_and_after(before: FileComparison, after: FileComparison, kind: str) -> Figure:
    """A recording with the model as given and with the improved one, and the errors of both.

    Parameters
    ----------
    before, after : FileComparison of the same recording
    kind : "fitted" or "held-out"

    Returns
    -------
    matplotlib.figure.Figure; a pair of axes for each signal
    """
    signals = tuple(after.signals)
    figure = Figure(figsize=(8.0, 0.4 + 5.2 * len(signals)), layout="constrained")
    figure.suptitle(f"{shortened(after.measurement.name)} ({kind} data): before and after")
    parts = figure.subfigures(len(signals), 1, squeeze=False)
    for part, signal in zip(parts.flat, signals, strict=True):
        _draw_pair(part, before, after, signal)
    figure.align_ylabels()
    return figure


def _draw_pair(part: SubFigure, before: FileComparison, after: FileComparison, name: str) -> None:
    rows = part.subplots(3, 1, sharex=True, gridspec_kw={"height_ratios": [3, 2, 2]})
    measurement = after.measurement
    quantity = shown(name, static=measurement.static)
    measured = measurement.signals[name]
    across = measured if measurement.static else measurement.time
    if measurement.static:
        rows[0].plot(measured, static_torque(measurement), ".", color=BLACK, label="measured")
    else:
        curve = envelope(measurement.time, measured)
        rows[0].plot(*curve, color=BLACK, linewidth=2.2, label="measured")
    for file, label, colour in ((before, "as given", ORANGE), (after, "improved", BLUE)):
        simulated = file.trajectory[file.trajectory.measured(name)]
        error = quantity.small * (simulated - measured)
        style: dict[str, Any] = {"color": colour, "linewidth": 1.0}
        if measurement.static:
            rows[0].plot(simulated, static_torque(measurement), label=label, **style)
        else:
            rows[0].plot(*envelope(measurement.time, simulated), label=label, **style)
        rows[1].plot(*envelope(across, error), **style)
    rows[2].plot(*envelope(across, error), **style)
    _finish_pair(rows, before, after, name)


def _finish_pair(
    rows: Sequence[Axes], before: FileComparison, after: FileComparison, name: str
) -> None:
    static = after.measurement.static
    quantity = shown(name, static=static)
    was, now = before.signals[name], after.signals[name]
    rows[0].set_title(
        f"RMSE {quantity.error(was.rmse)} as given, {quantity.error(now.rmse)} improved, "
        f"{times_noise(now.noise_ratio)}",
        fontsize="medium",
        pad=22.0,
    )
    band = 2.0 * quantity.small * now.noise.sigma
    rows[2].axhspan(-band, band, color="0.8", zorder=0, label="± 2σ of the noise")
    rows[0].set_ylabel("joint torque (N·m)" if static else f"{quantity.words} ({quantity.unit})")
    rows[1].set_ylabel(f"both errors ({quantity.small_unit})")
    rows[2].set_ylabel(f"improved ({quantity.small_unit})")
    rows[2].set_xlabel("deflection (rad)" if static else "time (s)")
    # above the axes: the curves fill them
    rows[0].legend(frameon=False, loc="lower left", bbox_to_anchor=(0.0, 0.96), ncols=3)
    rows[2].legend(loc="upper right", **LEGEND)
    for axes in rows:
        tidy(axes)


# ---- candidates --------------------------------------------------------------------------------


def candidates(rounds: Sequence[Round]) -> Figure:
    """Probability and gain of the likeliest candidates of each round.

    Parameters
    ----------
    rounds : those without candidates are left out

    Returns
    -------
    matplotlib.figure.Figure; two panels for each round
    """
    drawn = [
        (number, candidate_round)
        for number, candidate_round in enumerate(rounds, start=1)
        if candidate_round.candidates
    ]
    counts = [1 + min(len(candidate_round.candidates), BARS) for _, candidate_round in drawn]
    size = (9.0, 0.9 + sum(0.9 + 0.36 * count for count in counts))
    figure = Figure(figsize=size, layout="constrained")
    panels = figure.subplots(
        len(drawn), 2, squeeze=False, sharey="row", gridspec_kw={"height_ratios": counts}
    )
    for (left, right), (number, candidate_round) in zip(panels, drawn, strict=True):
        likeliest = candidate_round.candidates[:BARS]
        _draw_probability(left, likeliest, candidate_round)
        _draw_gains(right, likeliest)
        added = called("+".join(candidate_round.chosen)) if candidate_round.chosen else "nothing"
        left.set_title(f"round {number}: {verbatim(added)} added", loc="left", fontsize="medium")
    panels[-1, 0].set_xlabel("probability in the round (%)")
    panels[-1, 1].set_xlabel("squared error explained (%)")
    handles, labels = panels[0, 1].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=2, frameon=False)
    return figure


def _draw_probability(axes: Axes, candidates: Sequence[Candidate], candidate_round: Round) -> None:
    taken = [candidate.ids == candidate_round.chosen for candidate in candidates]
    lengths = [candidate.probability for candidate in candidates]
    names = [verbatim(called_set(candidate)) for candidate in candidates]
    colours = [VERMILLION if chosen else "0.7" for chosen in taken]
    axes.barh(np.arange(len(candidates)), lengths, color=colours, height=0.7)
    axes.barh(len(candidates), none_of_them(candidate_round), color="0.7", height=0.7)
    axes.set_yticks(np.arange(len(candidates) + 1), [*names, NONE])
    axes.set_ylim(len(candidates) + 0.6, -0.6)  # the likeliest on top
    axes.set_xlim(0.0, 1.0)
    _finish_bars(axes)


def _draw_gains(axes: Axes, candidates: Sequence[Candidate]) -> None:
    kinds = [("gain", "on fitted data", BLUE, -0.19), ("heldout_gain", "held out", ORANGE, 0.19)]
    for kind, label, colour, offset in kinds:
        gains = [(place, getattr(candidate, kind)) for place, candidate in enumerate(candidates)]
        known = [(place, gain) for place, gain in gains if gain is not None]
        if not known:  # nothing was refitted
            continue
        # a candidate that ruins held-out data would hide all others
        lengths = [max(gain, -1.0) for _, gain in known]
        where = np.array([place for place, _ in known]) + offset
        axes.barh(where, lengths, color=colour, height=0.36, label=label)
    axes.axvline(0.0, color="0.5", linewidth=0.8)
    axes.set_xlim(right=1.0)
    _finish_bars(axes)


def _finish_bars(axes: Axes) -> None:
    axes.xaxis.set_major_formatter(PercentFormatter(1.0, symbol=""))
    tidy(axes)
    axes.grid(visible=False, axis="y")
    axes.set_axisbelow(True)


# ---- what an effect explains -------------------------------------------------------------------


def explained_by(diagnosis: Diagnosis, effect_id: str) -> Figure:
    """Torque that is missing without an effect, the effect's own torque over it, and what remains.

    Parameters
    ----------
    diagnosis : Diagnosis
    effect_id : one of those added

    Returns
    -------
    matplotlib.figure.Figure; the first fitted recording
    """
    file = diagnosis.comparison.files[0]
    explained = explained_by_effect(diagnosis, effect_id)
    title = f"what {called(effect_id)} explains"
    return _signature(explained, f"{shortened(file.measurement.name)}: {verbatim(title)}")


def learned_term(diagnosis: Diagnosis) -> Figure:
    """Torque that is missing, the learned term over it, and what would remain.

    Parameters
    ----------
    diagnosis : Diagnosis with a learned term

    Returns
    -------
    matplotlib.figure.Figure; the first fitted recording
    """
    file = diagnosis.comparison.files[0]
    explained = explained_by_learned(diagnosis)
    return _signature(
        explained, f"{shortened(file.measurement.name)}: what the learned term explains"
    )


def _signature(explained: Explained, title: str) -> Figure:
    figure = Figure(figsize=(7.5, 7.0), layout="constrained")
    upper, lower = figure.subplots(
        2, 1, sharex=True, sharey=True, gridspec_kw={"height_ratios": [3, 2]}
    )
    own = explained.modelled_variable, explained.modelled.torque
    left = explained.remaining_variable, explained.remaining.torque
    _draw_cloud(upper, (explained.variable, explained.measured.torque), "0.65", "the machine", 3.0)
    _draw_cloud(upper, own, ORANGE, "the effect", 1.2)
    upper.plot(*mean_curve(*own), color=VERMILLION, linewidth=1.8, label="the effect, mean")
    upper.set_ylabel("torque missing without it (N·m)")
    _draw_cloud(lower, left, "0.65", "the machine", 3.0)
    lower.plot(*mean_curve(*left), color=BLUE, linewidth=1.8, label="mean")
    lower.set_ylabel("torque missing with it (N·m)")
    lower.set_xlabel(f"{explained.by.replace('_', ' ')} ({explained.unit})")
    for axes in (upper, lower):
        axes.axhline(0.0, color="0.5", linewidth=0.8, zorder=0)
        axes.legend(loc="best", markerscale=4.0, **LEGEND)
        tidy(axes)
    figure.suptitle(title)
    return figure


def _draw_cloud(
    axes: Axes, cloud: tuple[Array, Array], colour: str, label: str, size: float
) -> None:
    kept = some(len(cloud[0]))
    style: dict[str, Any] = {"linestyle": "none", "marker": ".", "markersize": size}
    axes.plot(*(axis[kept] for axis in cloud), color=colour, label=label, rasterized=True, **style)


# ---- the next experiment -----------------------------------------------------------------------


def next_experiment(experiment: Experiment) -> Figure:
    """Motor motion, the load where one is to act, and what the answers predict, over time."""
    panels = list(panels_of(experiment))
    figure = Figure(figsize=(8.0, 0.6 + 2.3 * len(panels)), layout="constrained")
    rows = figure.subplots(len(panels), 1, sharex=True, squeeze=False).flat
    for axes, panel in zip(rows, panels, strict=True):
        colours = STEP_COLOURS if panel.predicted else (BLACK,)
        for (name, values), colour in zip(panel.curves.items(), colours, strict=False):
            curve = envelope(experiment.time, values)
            axes.plot(*curve, color=colour, linewidth=1.2, label=verbatim(name))
        axes.set_ylabel(fill(verbatim(panel.label), LETTERS))
        tidy(axes)
        if panel.predicted:
            axes.legend(**LEGEND)
    axes.set_xlabel("time (s)")
    figure.suptitle(title_of(experiment))
    return figure
