"""What one button would put right in how a file is read; nothing of the page is here."""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from elastic_tendon.app.document import Source
from elastic_tendon.app.mapping import (
    ADVICE,
    Row,
    advised_items,
    enumerated,
    item_in_words,
    item_of,
    words,
)
from elastic_tendon.errors import MeasurementError
from elastic_tendon.measurement.columns import signal_named
from elastic_tendon.measurement.preparation import parse_map
from elastic_tendon.measurement.units import parse_unit

REQUIRED = ("time", "motor_position", "joint_position")
# words in names that tell a signal; those of the second table only where no other does
_TELLING: Mapping[str, frozenset[str]] = {
    "time": frozenset({"time", "zeit", "timestamp", "seconds"}),
    "motor_position": frozenset({"motor", "mot", "actuator", "drive", "antrieb"}),
    "joint_position": frozenset({"joint", "gelenk", "abtrieb", "link"}),
    "load_torque": frozenset({"load", "last"}),
}
_HINTING: Mapping[str, frozenset[str]] = {
    "time": frozenset({"t", "sec"}),
    "motor_position": frozenset({"m", "theta"}),
    "joint_position": frozenset({"j", "q", "arm", "output"}),
}
# words of other quantities than time and positions
_ELSE = frozenset(
    {
        *("torque", "moment", "drehmoment", "tau", "force", "kraft", "nm", "mnm"),
        *("current", "strom", "voltage", "spannung", "temp", "temperature", "temperatur"),
        *("velocity", "speed", "vel", "omega", "rpm", "acceleration", "acc", "error", "status"),
        *("command", "cmd", "target", "ref", "reference", "setpoint", "soll", "desired"),
    }
)
_WORD = re.compile(r"[A-Z]?[a-z]+|[A-Z]+")


@dataclass(frozen=True)
class Offer:
    """Items of a mapping that would be taken over; `words` say what they do."""

    button: str
    words: str
    items: tuple[str, ...]


def missing(source: Source, labels: Sequence[str]) -> tuple[str, ...]:
    """Signals that a recording needs and for which no column is known.

    Parameters
    ----------
    source : Source
    labels : columns of the file
    """
    if any("=" not in item for item in source.options.mapping):
        return ()  # a preparation may name them
    said = {item.partition("=")[0].strip() for item in source.options.mapping}
    known = said | {_named(label) for label in labels}
    if {"joint_deflection", "joint_torque"} <= known and not known & {"time", "motor_position"}:
        return ()  # a static curve
    return tuple(signal for signal in REQUIRED if signal not in known)


def missing_in_words(source: Source, labels: Sequence[str]) -> str:
    """All signals that are missing, in one sentence; "" where one at most is, which is told."""
    signals = missing(source, labels)
    if len(signals) < 2:
        return ""
    named = enumerated([f"the {words(signal)}" for signal in signals])
    static = "; a static curve needs joint deflection and joint torque only"
    return (
        f"{source.name}: no names tell which columns are {named}; choose them below"
        f"{static if 'time' in signals else ''}"
    )


def guessed(source: Source, labels: Sequence[str]) -> tuple[Offer, ...]:
    """What telling names suggest, where signals are missing; at most one offer.

    Parameters
    ----------
    source : Source
    labels : columns of the file
    """
    wanted = missing(source, labels)
    if not wanted:
        return ()
    said = dict(parse_map(item, labels) for item in source.options.mapping)
    taken = {column.column for column in said.values()}
    free = [label for label in labels if label not in taken and _named(label) is None]
    absent = [*wanted, *(["load_torque"] if "load_torque" not in said else [])]
    if "load_torque" in map(_named, labels):
        absent = list(wanted)
    guesses = _distinguished(absent, free)
    items = tuple(_items(guesses, labels))
    if not guesses.keys() & set(wanted) or not items:
        return ()
    assignments = enumerated([item_in_words(item, labels) for item in items])
    return (Offer("Take this mapping", f"Going by the names, it may be: {assignments}.", items),)


def _distinguished(signals: Sequence[str], free: Sequence[str]) -> dict[str, str]:
    """Column of each signal that exactly one name tells."""
    columns: dict[str, str] = {}
    for table in (_TELLING, _HINTING):
        for signal in signals:
            left = [label for label in free if label not in columns.values()]
            telling = [
                label
                for label in left
                if _names_signal(label, signal, table.get(signal, frozenset()))
            ]
            if signal not in columns and len(telling) == 1:
                columns[signal] = telling[0]
    return {signal: columns[signal] for signal in signals if signal in columns}


def _names_signal(label: str, signal: str, telling: frozenset[str]) -> bool:
    said = {word.lower() for word in _WORD.findall(label.rpartition("/")[2])}
    return bool(said & telling) and (signal == "load_torque" or not said & _ELSE)


def _named(label: str) -> str | None:
    return signal_named(label.rpartition("/")[2])


def _items(guesses: Mapping[str, str], labels: Sequence[str]) -> Iterator[str]:
    for signal, column in guesses.items():
        try:
            yield item_of(Row(signal, column), labels)
        except MeasurementError:
            continue  # a name that a mapping cannot say


def advised(sentence: str, labels: Sequence[str]) -> tuple[Offer, ...]:
    """What a sentence advises, an offer for each way to read the file.

    Parameters
    ----------
    sentence : with advice for the command line, as of `misreadings.suspicion`
    labels : columns of the file
    """
    ways = [advised_items(clause) for clause in sentence.split("; or ") if ADVICE.search(clause)]
    usable = list(dict.fromkeys(way for way in ways if _usable(way, labels)))
    button = "Read it so"
    return tuple(
        Offer(button, f"{enumerated([item_in_words(item, labels) for item in way])}.", way)
        for way in usable
    )


def _usable(items: Sequence[str], labels: Sequence[str]) -> bool:
    """Whether advice says all that a mapping needs: a column of the file, and a unit if any."""
    try:
        read = [parse_map(item, labels)[1] for item in items]
    except MeasurementError:
        return False
    return all(
        column.column in labels and (column.unit is None or parse_unit(column.unit) is not None)
        for column in read
    )


def taken(source: Source, items: Sequence[str]) -> tuple[str, ...]:
    """The mapping of a source with items taken over, in place of what it says of these signals."""
    signals = {item.partition("=")[0].strip() for item in items}
    others = [
        item for item in source.options.mapping if item.partition("=")[0].strip() not in signals
    ]
    return (*others, *items)
