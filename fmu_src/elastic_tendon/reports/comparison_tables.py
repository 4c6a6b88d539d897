"""A comparison for the terminal: how large the error is, and where it lies; 80 columns suffice."""

from collections.abc import Iterator, Mapping, Sequence

from rich.box import SIMPLE_HEAD
from rich.markup import escape
from rich.table import Table

from elastic_tendon.comparison.bins import Bin
from elastic_tendon.comparison.comparison import Comparison, ErrorFigures, FileComparison
from elastic_tendon.comparison.locate import FileLocation
from elastic_tendon.comparison.places import by_concentration
from elastic_tendon.comparison.residuals import Array
from elastic_tendon.comparison.tolerance import ToleranceCheck
from elastic_tendon.reports.residual_tests import residual_sentences
from elastic_tendon.reports.units import (
    Shown,
    noise_in_words,
    noise_ratio,
    number,
    shown,
    times_noise,
)

STATES = {"I": "I, lower slack", "II": "II, upper slack", "III": "III, both taut"}
# more rows are a wall that nobody reads; the option --all-bins shows them
ROWS = 10
# times its share of the samples, what a bin holds of the error before it tells anything
DENSER = 1.3
# of the squared error; torques that are multiples of one another differ less, by rounding
SAME_SHARE = 1e-3
NOTHING = "–"
OVER_ALL = "Where the error lies is told of all samples, whatever conditions they meet:"

FIGURES = (
    "error = simulated − measured; fit = 100 (1 − ‖y − ŷ‖ / ‖y − ȳ‖) %; times noise = RMS / floor"
)


def error_table(comparison: Comparison, file: FileComparison) -> Table:
    """Error of each signal of one recording, whole and by slack state."""
    only = "" if file.selection is None else f"\nonly where {file.selection.words}"
    table = _table(f"{file.measurement.name} beside {comparison.model.name}{only}", FIGURES)
    table.add_column("error of", overflow="fold", min_width=14)
    for heading in ("samples", "RMS", "largest", "bias", "fit %", "times\nnoise"):
        table.add_column(heading, justify="right", no_wrap=True)
    for name, error in file.signals.items():
        quantity = shown(name, static=file.measurement.static)
        words = f"{quantity.words}, {quantity.small_unit}"
        table.add_row(f"[bold]{words}[/bold]", str(error.count), *_figures(error, quantity))
        for state, part in error.slack_states.items():
            label = f"  {STATES.get(state, state)}"
            table.add_row(label, str(part.count), *_figures(part, quantity))
    return table


def _figures(error: ErrorFigures, quantity: Shown) -> tuple[str, ...]:
    sizes = (quantity.small * value for value in (error.rmse, error.max_abs, error.bias))
    fit = "-" if error.fit_percent is None else f"{error.fit_percent:.1f}"
    return (*(number(size) for size in sizes), fit, noise_ratio(error.noise_ratio))


def tolerance_sentence(check: ToleranceCheck) -> str:
    """Whether a signal keeps its tolerance, and by how much it misses."""
    quantity = shown(check.signal, static=check.static)
    words = f"{check.recording}: {quantity.words} "
    largest = f"largest error {quantity.error(check.largest)} at {number(check.time)} s"
    bound = f"the tolerance of {quantity.error(check.tolerance)}"
    if check.met:
        return f"{words}keeps {bound}: {largest}."
    share = f"{100.0 * check.share_beyond:.2g} % of the samples"
    return f"{words}exceeds {bound} in {share}: {largest}."


def noise_sentence(file: FileComparison) -> str:
    """Noise floors of the signals of one recording."""
    floors = []
    for name, error in file.signals.items():
        quantity = shown(name, static=file.measurement.static)
        floors.append(f"{quantity.words} {noise_in_words(error.noise, quantity)}")
    return f"Noise: {'; '.join(floors)}."


def sentences(file: FileComparison, location: FileLocation) -> list[str]:
    """How large the noise is, how each signal fails, what is left of it, what was hard to find."""
    failing = [failing_sentence(file, location, name) for name in location.in_words]
    left = residual_sentences(location)
    return [noise_sentence(file), *failing, *left, *location.missing_torque.notes]


def failing_sentence(file: FileComparison, location: FileLocation, signal: str) -> str:
    """How one signal of a recording fails."""
    words = shown(signal, static=file.measurement.static).words
    return f"{words[0].upper()}{words[1:]}: {location.in_words[signal]}."


def summary_sentences(comparison: Comparison) -> list[str]:
    """How large the error of each signal is over all recordings, beside the noise."""
    static = all(file.measurement.static for file in comparison.files)
    where = f" where {comparison.condition}" if comparison.condition else ""
    ratios = comparison.noise_ratio()
    sentences = []
    for name, rmse in comparison.rmse().items():
        quantity = shown(name, static=static)
        errors = [file.signals[name] for file in comparison.files if name in file.signals]
        fits = [error.fit_percent for error in errors if error.fit_percent is not None]
        text = (
            f"The {quantity.words} error of {comparison.model.name}{where} is "
            f"{quantity.error(rmse)} RMS, "
            f"{times_noise(ratios[name])}"
        )
        if fits:
            ends = dict.fromkeys(f"{fit:.1f}" for fit in (min(fits), max(fits)))
            text += f"; the fit is {' to '.join(ends)} %"
        sentences.append(f"{text}.")
    return sentences


def bin_tables(
    file: FileComparison, location: FileLocation, *, all_bins: bool = False, advice: str = ""
) -> Iterator[Table]:
    """Where the error of each signal lies: the bins that stand out, or all.

    Parameters
    ----------
    file : FileComparison
    location : FileLocation of the same recording
    all_bins : also those that do not stand out
    advice : how to see those that are left out

    Returns
    -------
    iterator of Table; signals of which no bin stands out have none
    """
    for name, same in _alike(location.bins).items():
        bins = location.bins[name]
        quantity = shown(name, static=file.measurement.static)
        outstanding = [bin_ for bin_ in bins if bin_.stands_out]
        chosen = list(bins) if all_bins else strongest(outstanding, sample_shares(bins))
        if not chosen:
            continue
        left = len(outstanding) - len(chosen)
        captions = [f"The {shown(signal).words} is off in the same places." for signal in same]
        if all_bins:
            captions.append("* stands out: more error than noise, sure for all bins together")
        elif left > 0:
            captions.append(f"{left} more stand out{advice}")
        title = f"{file.measurement.name}: where the {quantity.words} is off"
        table = _table(title, "\n".join(captions) or None)
        _fill(table, chosen, sample_shares(bins), quantity, mark=all_bins)
        yield table


def _alike(bins: Mapping[str, Sequence[Bin]]) -> dict[str, list[str]]:
    """Signals that are off in places of their own, each with those that repeat it.

    Where a torque was measured at the motor as at the joint, one is a multiple of the other.
    """
    groups: dict[str, list[str]] = {}
    for name, own in bins.items():
        for earlier in groups:
            if _same_places(own, bins[earlier]):
                groups[earlier].append(name)
                break
        else:
            groups[name] = []
    return groups


def repeats(files: Sequence[FileComparison]) -> dict[str, list[str]]:
    """Signals of all recordings, each with those that repeat it at a fixed ratio.

    Unlike signals that are off in the same places, these are the same curve in another unit.
    """
    groups: dict[str, list[str]] = {}
    for name in dict.fromkeys(name for file in files for name in file.signals):
        for earlier in groups:
            if all(_repeats(file, name, earlier) for file in files):
                groups[earlier].append(name)
                break
        else:
            groups[name] = []
    return groups


def _repeats(file: FileComparison, name: str, earlier: str) -> bool:
    """Whether both were measured and simulated at a fixed ratio, or neither in this recording."""
    if name not in file.signals or earlier not in file.signals:
        return name not in file.signals and earlier not in file.signals
    measured = file.measurement.signals
    simulated = {
        signal: file.trajectory[file.trajectory.measured(signal)] for signal in (name, earlier)
    }
    return all(
        _proportional(of[earlier], of[name])
        for of in (measured, {signal: simulated[signal] - measured[signal] for signal in simulated})
    )


def _proportional(first: Array, second: Array) -> bool:
    squares = float(first @ first)
    if squares == 0.0:
        return False
    left = second - first * (float(first @ second) / squares)
    return float(left @ left) < SAME_SHARE * float(second @ second)


def _same_places(some: Sequence[Bin], others: Sequence[Bin]) -> bool:
    return len(some) == len(others) and all(
        (first.by, first.bin) == (second.by, second.bin)
        and abs(first.share - second.share) < SAME_SHARE
        for first, second in zip(some, others, strict=True)
    )


def _fill(
    table: Table,
    bins: Sequence[Bin],
    sample_share: Mapping[Bin, float],
    quantity: Shown,
    *,
    mark: bool,
) -> None:
    table.add_column("by", no_wrap=True)
    table.add_column("where", overflow="fold")
    for heading in (f"RMS,\n{quantity.small_unit}", f"bias,\n{quantity.small_unit}"):
        table.add_column(heading, justify="right", no_wrap=True)
    table.add_column("share of\nerror", justify="right", no_wrap=True)
    table.add_column("share of\nsamples", justify="right", no_wrap=True)
    if mark:
        table.add_column("")
    for bin_ in bins:
        *cells, of_error, of_samples = bin_cells(bin_, quantity, sample_share[bin_])
        cells += [share if share == NOTHING else f"{share} %" for share in (of_error, of_samples)]
        if mark:
            cells.append("*" if bin_.stands_out else " ")
        table.add_row(*cells)


def bin_cells(error_bin: Bin, quantity: Shown, sample_share: float) -> list[str]:
    """A bin in words and numbers: what, where, RMS, bias, and in % share of error, of samples."""
    in_time = error_bin.by != "frequency"  # a band has neither samples nor a bias
    return [
        error_bin.by.replace("_", " "),
        error_bin.bin,
        number(quantity.small * error_bin.rmse),
        number(quantity.small * error_bin.bias) if in_time else NOTHING,
        f"{100.0 * error_bin.share:.0f}",
        f"{100.0 * sample_share:.0f}" if in_time else NOTHING,
    ]


def sample_shares(bins: Sequence[Bin]) -> dict[Bin, float]:
    """Share of each bin in the samples of its split."""
    totals: dict[str, int] = {}
    for bin_ in bins:
        totals[bin_.by] = totals.get(bin_.by, 0) + bin_.count
    return {bin_: bin_.count / totals[bin_.by] for bin_ in bins}


def strongest(bins: Sequence[Bin], sample_share: Mapping[Bin, float]) -> list[Bin]:
    """The `ROWS` bins with the most error for their share of the samples.

    First those of the variable that tells most. A bin that holds hardly more of the error than of
    the samples says nothing of where the error lies.

    Parameters
    ----------
    bins : those to choose from, in the order of their variables' ranges
    sample_share : of every bin of the signal
    """
    telling = [bin_ for bin_ in bins if bin_.share >= DENSER * sample_share[bin_]]
    chosen = sorted(telling, key=lambda bin_: sample_share[bin_] - bin_.share)[:ROWS]
    order = by_concentration(list(sample_share))
    return sorted((bin_ for bin_ in bins if bin_ in chosen), key=lambda bin_: order.index(bin_.by))


def _table(title: str, caption: str | None) -> Table:
    return Table(
        title=escape(title),
        caption=caption,
        box=SIMPLE_HEAD,
        padding=(0, 1, 0, 0),
        title_justify="left",
        caption_justify="left",
    )
