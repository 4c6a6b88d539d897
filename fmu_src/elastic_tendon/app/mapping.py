"""How a file is read, as the page shows it and as users correct it; nothing of the page is here."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import isfinite
from typing import Any

from elastic_tendon.actuator.motion_kind import MotionKind
from elastic_tendon.app.document import Source
from elastic_tendon.app.numbers import parsed, with_minus
from elastic_tendon.errors import MeasurementError
from elastic_tendon.measurement import Measurement
from elastic_tendon.measurement.columns import STATIC
from elastic_tendon.measurement.preparation import (
    DIMENSIONS,
    SHIFTED,
    SignalColumn,
    parse_map,
)
from elastic_tendon.measurement.units import LINEAR, USUAL

READ = tuple(name for name in DIMENSIONS if name != "motor_velocity")  # that one nobody reads
_WRITTEN = {
    "us": "µs",
    "Nm": "N·m",
    "mNm": "mN·m",
    "uNm": "µN·m",
    "kNm": "kN·m",
    "Ncm": "N·cm",
    "Nmm": "N·mm",
}
BY_NAME = ""  # chosen in place of a column: found by its name, if it is there


@dataclass(frozen=True)
class Row:
    """Where a signal stands in a file: ``signal = column * unit * times + plus``.

    `column` None: the file has none. `motion` : whether it is of a machine that turns or slides.
    """

    signal: str
    column: str | None = None
    unit: str | None = None
    times: float = 1.0
    plus: float = 0.0
    motion: MotionKind = MotionKind.ROTARY

    @property
    def _usual(self) -> list[str]:
        """Units that are known of what it measures, that of SI first."""
        dimension = DIMENSIONS[self.signal]
        slides = self.motion is MotionKind.LINEAR
        return list(USUAL[LINEAR.get(dimension, dimension) if slides else dimension])

    @property
    def si(self) -> str:
        """Unit of `plus`."""
        return _WRITTEN.get(self._usual[0], self._usual[0])

    def units(self) -> list[dict[str, str]]:
        """Units to choose from, the present one among them."""
        usual = self._usual
        own = [self.unit] if self.unit and self.unit not in usual else []
        return [{"value": unit, "label": _WRITTEN.get(unit, unit)} for unit in (*usual, *own)]


def rows_of(
    source: Source,
    labels: Sequence[str],
    measurement: Measurement | None,
    motion: MotionKind = MotionKind.ROTARY,
) -> tuple[Row, ...]:
    """A row for each signal that the file has or could have.

    Parameters
    ----------
    source : Source
    labels : columns of the file
    measurement : the recording as it was read, None where it could not be
    motion : of the machine that was recorded
    """
    corrected = dict(parse_map(item, labels) for item in _items(source))
    read = {} if measurement is None else measurement.preparation.columns
    return tuple(
        replace(_row(signal, corrected.get(signal), read.get(signal)), motion=motion)
        for signal in _possible(measurement)
    )


def _possible(measurement: Measurement | None) -> tuple[str, ...]:
    if measurement is None:
        return READ
    if measurement.static:
        return STATIC
    unread = "joint_deflection" if measurement.motor_share is None else "joint_position"
    return tuple(name for name in READ if name != unread)


def _items(source: Source) -> list[str]:
    """Corrections of single signals; what else a mapping holds is the name of a preparation."""
    return [item for item in source.options.mapping if "=" in item]


def _row(signal: str, corrected: SignalColumn | None, read: SignalColumn | None) -> Row:
    said = read or corrected  # what was read has all gaps of a correction filled in
    if said is None:
        return Row(signal)
    times = said.sign * said.scale
    return Row(signal, said.column, said.unit, times, said.offset)


def remapped(
    source: Source, labels: Sequence[str], row: Row, field: str, value: str | None
) -> tuple[str, ...]:
    """The mapping of a source with one row corrected.

    Parameters
    ----------
    source : Source
    labels : columns of the file
    row : as it is
    field : of the row: "column", "unit", "times" or "plus"
    value : what it becomes; `BY_NAME` for a column

    Raises
    ------
    MeasurementError : there is no such column, or this is no number
    """
    if field == "column":
        new = Row(row.signal, column=value or None)  # its unit is as its own name says
    elif row.column is None:
        raise MeasurementError(f"{words(row.signal)}: choose its column first")
    elif field == "unit":
        new = replace(row, unit=value)
    else:
        number = number_of(value, f"{words(row.signal)}, {field}") or 0.0
        new = replace(row, times=number) if field == "times" else replace(row, plus=number)
    others = [
        item for item in source.options.mapping if item.partition("=")[0].strip() != row.signal
    ]
    return (*others, item_of(new, labels)) if new.column is not None else tuple(others)


def item_of(row: Row, labels: Sequence[str]) -> str:
    """``signal=column[:unit][*scale][+offset]``.

    Raises
    ------
    MeasurementError : the column's name would be misread, or a number is not allowed
    """
    if row.times == 0.0:
        raise MeasurementError(f"{words(row.signal)}: times 0 would leave nothing of it")
    text = f"{row.signal}={row.column}"
    if row.unit is not None:
        text += f":{row.unit}"
    if row.times != 1.0:
        text += f"*{row.times!r}"
    if row.plus != 0.0:
        text += f"{'-' if row.plus < 0 else '+'}{abs(row.plus)!r}"
    _, read = parse_map(text, labels)
    if (read.column, read.unit, read.scale, read.offset) != (
        row.column,
        row.unit,
        row.times,
        row.plus,
    ):
        raise MeasurementError(
            f"{row.column}: the name of this column has signs in it that a mapping needs; rename "
            "it in the file"
        )
    return text


def words(signal: str) -> str:
    """Name of a signal in words."""
    return signal.replace("_", " ")


def number_of(text: str | None, what: str) -> float | None:
    """The number in a field, None where it is empty; `what` names the field in the sentence.

    Raises
    ------
    MeasurementError : it is no number
    """
    if text is None or not text.strip():
        return None
    value = parsed(text)
    if value is None or not isfinite(value):
        raise MeasurementError(f"{what}: “{text}” is not a number; the last one is kept")
    return value


def window_of(source: Source, field: str, text: str | None) -> tuple[float | None, float | None]:
    """The window of a source with another "start" or "end".

    Raises
    ------
    MeasurementError : it is no number, or the window ends before it starts
    """
    start, end = source.window
    value = number_of(text, f"{field} of what is read")
    start, end = (value, end) if field == "start" else (start, value)
    if start is not None and end is not None and not start < end:
        raise MeasurementError(f"from {start:g} s to {end:g} s is nothing; end after the start")
    return start, end


def shifts_of(source: Source, signal: str, text: str | None) -> dict[str, Any]:
    """The time shifts of a source with another one; "auto" has it estimated.

    Raises
    ------
    MeasurementError : it is neither a number nor "auto"
    """
    others: Mapping[str, Any] = {
        name: shift for name, shift in source.options.time_shift.items() if name != signal
    }
    if text is not None and text.strip() == "auto":
        return {**others, signal: "auto"}
    value = number_of(text, f"{words(signal)}, late by")
    return dict(others) if not value else {**others, signal: value}


def shifted(measurement: Measurement | None) -> tuple[str, ...]:
    """Signals of a recording that may be late."""
    if measurement is None or measurement.static:
        return ()
    held = measurement.inputs.keys() | measurement.signals.keys()
    return tuple(name for name in SHIFTED if name in held)


DECLARE = "; if the file is right, add --as-declared"  # what `refuse_suspicious` ends with
_CHOOSE = re.compile(r"(name the right one|name it|choose) with --map \w+=COLUMN")
# one or more options in a sentence, up to where it goes on
ADVICE = re.compile(r"(?:--map \w+=.+?(?: (?=--map )|(?=; |, | or |$)))+")
_OPTIONS = {
    "--map": "the mapping",
    "--as-declared": "taken as declared",
    "--resample STEP": "resampling under Advanced",
    "--resample": "resampling under Advanced,",
    "--shift ": "",
}


def in_app_words(sentence: str) -> str:
    """A sentence with advice for the command line as the page says it."""
    plain = _CHOOSE.sub("choose its column below", sentence.removesuffix(DECLARE))
    plain = ADVICE.sub(_advice_in_words, plain).replace("read it with ", "read ")
    for option, said in _OPTIONS.items():
        plain = plain.replace(option, said)
    return plain


def _advice_in_words(match: re.Match[str]) -> str:
    return enumerated([item_in_words(item) for item in advised_items(match[0])])


def advised_items(text: str) -> tuple[str, ...]:
    """Items of a mapping in the first advice of a text, as a mapping takes them.

    Parameters
    ----------
    text : str; with options such as ``--map time=t --map load_torque="load cell:Nm"``
    """
    match = ADVICE.search(text)
    if match is None:
        return ()
    items = []
    for option in match[0].removeprefix("--map ").split(" --map "):
        signal, _, column = option.strip().partition("=")
        if column[:1] in ('"', "'") and column[-1:] == column[:1]:
            column = column[1:-1]  # quoted for a shell
        items.append(f"{signal}={column}")
    return tuple(items)


def item_in_words(item: str, labels: Sequence[str] = ()) -> str:
    """What one item of a mapping says."""
    try:
        signal, read = parse_map(item, labels)
    except MeasurementError:
        return item
    return (
        f"{words(signal)} from {read.column}"
        + (f" in {_WRITTEN.get(read.unit, read.unit)}" if read.unit else "")
        + (f" times {with_minus(f'{read.scale:g}')}" if read.scale != 1.0 else "")
        + (f" plus {with_minus(f'{read.offset:g}')}" if read.offset else "")
    )


def enumerated(parts: Sequence[str]) -> str:
    """Parts of a sentence: a, b and c."""
    return " and ".join(filter(None, [", ".join(parts[:-1]), *parts[-1:]]))
