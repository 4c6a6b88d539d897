"""A fleet for the terminal: robot by robot, and what the robots share."""

from collections.abc import Iterator, Mapping
from math import floor, log10
from typing import Any

import numpy as np
import pandas as pd
from rich.box import SIMPLE_HEAD
from rich.table import Table

from elastic_tendon.actuator.parameters import Model
from elastic_tendon.actuator.quantity import unit_suffix
from elastic_tendon.reports.sweep_tables import short, with_unit
from elastic_tendon.reports.tables import TIGHT, four_digits
from elastic_tendon.reports.units import noise_ratio, shown
from elastic_tendon.sweeps.fleet import (
    DIGITS,
    HIGH,
    LOW,
    SIGNALS,
    error_columns,
    measured_signals,
    named,
    number,
    units_of,
)
from elastic_tendon.sweeps.fleet_findings import FleetFindings
from elastic_tendon.sweeps.task import APPEARED, DRIFTED, FAILURE, ROBOT, VERDICT

LOUD = 3.0  # times the noise: so much is not left by noise alone
MOST_DIGITS = 7  # of a number whose interval is narrow
MOST_LISTED = 50  # robots; more are in the table's file


def robots_table(model: Model, robots: pd.DataFrame) -> Table:
    """Which robot has drifted, in which parameter, and which effect has appeared.

    Parameters
    ----------
    model : Model that they were diagnosed against
    robots : rows of a `Fleet`
    """
    signal = _signal(robots)
    table = Table(title="The fleet", box=SIMPLE_HEAD, show_lines=False)
    table.add_column("robot", overflow="fold")
    table.add_column("verdict", overflow="fold")
    heading = f"{shown(signal).words}:\ntimes noise\nbefore, after"
    table.add_column(heading, justify="right", no_wrap=True)
    table.add_column("what has drifted or appeared", overflow="fold")
    columns = error_columns(signal)
    for row in robots.head(MOST_LISTED).to_dict("records"):
        if row[FAILURE]:
            table.add_row(row[ROBOT], "failed", "", row[FAILURE])
            continue
        errors = [noise_ratio(row[columns["noise_ratio", when]]) for when in ("before", "after")]
        words = "\n".join(_changes(model, row)) or "nothing"
        table.add_row(row[ROBOT], row[VERDICT].replace("_", " "), ", ".join(errors), words)
    table.caption = " ".join(_captions(robots, robots[columns["noise_ratio", "after"]]))
    return table


def _captions(robots: pd.DataFrame, after: pd.Series) -> Iterator[str]:
    if len(robots) > MOST_LISTED:
        yield f"The first {MOST_LISTED} of {len(robots)} robots; the file has them all."
    if (after > LOUD).any():
        yield (
            f"Where over {LOUD:g} times the noise remain, something disturbs the machine that is "
            "not recorded, or recordings contradict one another: diagnose them one by one."
        )


def pooled_table(found: FleetFindings) -> Table:
    """What the robots share."""
    table = Table(title="What the robots share", **TIGHT)
    table.add_column("parameter", overflow="fold")
    table.add_column("robots", justify="right")
    for heading in ("mean", "95 % interval", "between robots, one sigma"):
        table.add_column(heading, justify="right")
    for pooled in found.pooled:
        interval = " to ".join(map(four_digits, pooled.interval))
        numbers = (four_digits(pooled.mean), interval, four_digits(pooled.spread))
        table.add_row(
            with_unit(pooled.path, found.units[pooled.path]), f"{pooled.robots}", *numbers
        )
    table.caption = "a random-effects average of the robots whose recordings tell it"
    return table


def _signal(robots: pd.DataFrame) -> str:
    """The signal whose error is told of all robots: the first that any of them has."""
    computed = (name for name in SIGNALS if error_columns(name)["noise_ratio", "after"] in robots)
    return next(iter((*measured_signals(robots), *computed)))


def _changes(model: Model, row: Mapping[Any, Any]) -> Iterator[str]:
    """What drifted, with its numbers, and what appeared."""
    units, given = units_of(model), model.values()
    for path in named(row[DRIFTED]):
        yield f"{short(path)} {number(given[path])} -> {_with_interval(row, path, units[path])}"
    for text in filter(None, row[APPEARED].split("; ")):
        effect_id, _, alike = text.partition(": ")
        paths = [path for path in units if path.startswith(f"effects.{effect_id}.")]
        sizes = [
            f"{path.rpartition('.')[2]} {_with_interval(row, path, units[path])}" for path in paths
        ]
        yield f"{effect_id}: {', '.join([*sizes, *([alike] if alike else [])])}"


def _with_interval(row: Mapping[Any, Any], path: str, unit: str) -> str:
    """Estimate, unit and interval, with as many digits as distinguish its ends."""
    fitted, low, high = (row[path + end] for end in ("", LOW, HIGH))
    suffix = unit_suffix(unit)
    if np.isnan(low):
        return number(fitted) + suffix
    size, width = max(abs(low), abs(high)), high - low
    digits = 2 + floor(log10(size / width)) if 0.0 < width < size else DIGITS
    digits = min(max(digits, DIGITS), MOST_DIGITS)
    fitted, low, high = (number(value, digits) for value in (fitted, low, high))
    return f"{fitted}{suffix} ({low} to {high})"
