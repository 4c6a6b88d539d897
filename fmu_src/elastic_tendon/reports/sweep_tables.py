"""What a sweep gave, for the terminal: tables and sentences; numbers come ready from `sweeps`."""

from collections.abc import Mapping, Sequence

from rich.table import Table

from elastic_tendon.actuator.quantity import unit_text
from elastic_tendon.comparison.simulated import SUFFIXES
from elastic_tendon.reports.names import at_dots
from elastic_tendon.reports.tables import SURE, TIGHT, four_digits
from elastic_tendon.sweeps.bootstrap import BootstrapInterval
from elastic_tendon.sweeps.summary import Summary
from elastic_tendon.sweeps.sweep import Swept

EXACT = "exact"  # an interval that no digit would show
WHICH_INTERVAL = (
    "Refits know bounds and curved dependences, but take the errors as they are: where something "
    "unknown acts on the machine, or springs trade with one another, the fit's own are safer."
)


def done_sentence(swept: Swept) -> str:
    """How much was done, and where it is."""
    before = f", {swept.resumed} of them done before" if swept.resumed else ""
    runs = "1 run" if swept.runs == 1 else f"{swept.runs} runs"
    return f"{runs} in {swept.path}{before}."


def failure_sentences(summary: Summary, *, reasons: bool) -> list[str]:
    """How many runs failed, and, if that is not said elsewhere, for which `reasons`."""
    if not summary.failed:
        return []
    some = f"{summary.failed} of {summary.runs} runs failed; the last column says of what"
    listed = [
        f"  {reason.count} like run {reason.run}: {reason.text}" for reason in summary.reasons
    ]
    return [some, *listed] if reasons else [some]


def statistics_table(summary: Summary, varied: Mapping[str, str]) -> Table:
    """What varied and what came of it, over all runs that went well.

    Parameters
    ----------
    summary : of the table of results
    varied : unit of each column that varied
    """
    table = Table(title="Over all runs", **TIGHT)
    table.add_column("", overflow="fold")
    for heading in ("minimum", "5 %", "median", "95 %", "maximum"):
        table.add_column(heading, justify="right", no_wrap=True)
    last = ""
    for column in summary.columns:
        numbers = (column.minimum, *column.quantiles, column.maximum)
        name, dot, statistic = column.name.partition(".")
        if column.name in varied:
            last, words = "", with_unit(column.name, varied[column.name])
        else:
            if name != last and dot:
                table.add_section()
                table.add_row(name.replace("_", " "))
            last, words = name, f"  {_words(statistic or name)}"
        table.add_row(words, *map(four_digits, numbers))
    if summary.sampled < summary.rows:
        table.caption = f"quantiles are those of {summary.sampled} rows, evenly spaced"
    return table


def short(path: str) -> str:
    """A parameter's path without what everybody knows."""
    return path.removeprefix("transmission.").removeprefix("effects.")


def with_unit(path: str, unit: str) -> str:
    """A parameter's path, and its unit if it has one."""
    name = at_dots(short(path))
    return name if unit == "1" else f"{name}, {unit_text(unit)}"


def _words(column: str) -> str:
    """``maximum_rad`` as words and unit."""
    for unit, suffix in SUFFIXES.items():
        if suffix and column.endswith(suffix) and not column.endswith(f"_per{suffix}"):
            return f"{column.removesuffix(suffix).replace('_', ' ')}, {unit_text(unit)}"
    return column.replace("_", " ")


def bootstrap_table(intervals: Sequence[BootstrapInterval]) -> Table:
    """Estimated parameters with the interval of the fit and that of the refits."""
    table = Table(title="Estimated parameters, with 95 % intervals", **TIGHT)
    table.add_column("parameter", overflow="fold")
    table.add_column("fitted", justify="right", no_wrap=True)
    table.add_column("by the fit alone", no_wrap=True)
    table.add_column("by refits", no_wrap=True)
    for interval in intervals:
        ends = [_ends(interval.fitted, pair) for pair in (interval.linear, interval.bootstrap)]
        table.add_row(with_unit(interval.path, interval.unit), four_digits(interval.fitted), *ends)
    table.caption = WHICH_INTERVAL
    return table


def _ends(fitted: float, interval: tuple[float, float]) -> str:
    """Ends of an interval; of data without noise they are nearer than digits tell."""
    if interval[1] - interval[0] <= 2.0 * SURE * abs(fitted):
        return EXACT
    return " to ".join(map(four_digits, interval))
