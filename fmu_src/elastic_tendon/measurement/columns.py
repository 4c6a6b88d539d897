"""Which column of a file is which signal, and how its unit becomes SI."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from math import pi

from elastic_tendon.errors import MeasurementError

ANGLE = {"rad": 1.0, "mrad": 1e-3, "deg": pi / 180.0}
TORQUE = {"Nm": 1.0, "mNm": 1e-3}
TIME = {"s": 1.0, "ms": 1e-3, "us": 1e-6}
SPEED = {"rad_per_s": 1.0, "deg_per_s": pi / 180.0, "rpm": 2.0 * pi / 60.0}

# signal -> factor to SI of every unit it may come in; the first is the contract's own
UNITS: dict[str, dict[str, float]] = {
    "time": TIME,
    "motor_position": ANGLE,
    "joint_position": ANGLE,
    "load_torque": TORQUE,
    "joint_torque": TORQUE,
    "motor_torque": TORQUE,
    "motor_velocity": SPEED,
}
REQUIRED = ("time", "motor_position", "joint_position")

_NUMBER = r"[0-9]*\.?[0-9]+(?:[eE][+-]?[0-9]+)?"
_MAP = re.compile(
    rf"(?P<signal>\w+)=(?P<column>.+?)(?::(?P<unit>[A-Za-z_./]+))?"
    rf"(?:\*(?P<scale>[+-]?{_NUMBER}))?(?P<offset>[+-]{_NUMBER})?"
)


@dataclass(frozen=True)
class Column:
    """A column of a file and its way to SI: ``signal = column * factor + offset``."""

    signal: str
    name: str
    factor: float = 1.0
    offset: float = 0.0


def parse_map(text: str) -> Column:
    """Read one ``--map`` item, ``signal=column[:unit][*scale][+offset]``.

    Parameters
    ----------
    text : str; `scale` may be negative (a sign) or a gear ratio, `offset` is in the signal's SI
        unit and is added last

    Returns
    -------
    Column

    Raises
    ------
    MeasurementError : the item is misspelt, or its signal or unit is not known
    """
    match = _MAP.fullmatch(text.strip())
    if match is None:
        raise MeasurementError(
            f"--map {text!r}: write it as signal=column[:unit][*scale][+offset], "
            "for example joint_position=encoder_2:deg*-1"
        )
    signal, unit = match["signal"], match["unit"]
    if signal not in UNITS:
        raise MeasurementError(
            f"--map {text!r}: there is no signal {signal!r}; choose one of {', '.join(UNITS)}"
        )
    factor = 1.0 if unit is None else _unit_factor(signal, unit, text)
    return Column(
        signal=signal,
        name=match["column"],
        factor=factor * float(match["scale"] or 1.0),
        offset=float(match["offset"] or 0.0),
    )


def _unit_factor(signal: str, unit: str, text: str) -> float:
    plain = unit.replace("N.m", "Nm").replace("/", "_per_")
    factors = UNITS[signal]
    if plain not in factors:
        raise MeasurementError(
            f"--map {text!r}: {unit!r} is no unit of {signal}; choose one of {', '.join(factors)}"
        )
    return factors[plain]


def find_columns(
    header: Sequence[str],
    mapped: Sequence[Column],
    source: str,
    required: Sequence[str] = REQUIRED,
) -> list[Column]:
    """Decide which column of a file is which signal.

    A mapped signal takes its column; any other is found by its own name with a unit as suffix,
    such as ``time_s`` or ``joint_position_deg``. A column that says it is measured, such as
    ``measured_joint_position_rad``, comes before one that does not.

    Parameters
    ----------
    header : names of the columns in the file
    mapped : from `parse_map`
    source : str; name of the file for messages
    required : signals that must be there

    Returns
    -------
    list of Column; one for each signal that the file holds

    Raises
    ------
    MeasurementError : a required signal is missing or a signal comes twice
    """
    found = []
    by_map = {column.signal: column for column in mapped}
    if len(by_map) < len(mapped):
        raise MeasurementError(f"{source}: --map names a signal twice; map each signal once")
    for signal in UNITS:
        if signal in by_map:
            candidates = [by_map[signal]] if by_map[signal].name in header else []
        else:
            candidates = _named(f"measured_{signal}", signal, header) or _named(
                signal, signal, header
            )
        if len(candidates) > 1:
            names = " and ".join(column.name for column in candidates)
            raise MeasurementError(
                f"{source}: {signal} comes twice, as {names}; choose with --map {signal}=COLUMN"
            )
        if not candidates and (signal in required or signal in by_map):
            raise _missing(signal, by_map.get(signal), header, source)
        found += candidates
    return found


def _named(name: str, signal: str, header: Sequence[str]) -> list[Column]:
    """Columns called by a name with a unit of the signal as suffix."""
    return [
        Column(signal, f"{name}_{unit}", factor)
        for unit, factor in UNITS[signal].items()
        if f"{name}_{unit}" in header
    ]


def _missing(
    signal: str, mapped: Column | None, header: Sequence[str], source: str
) -> MeasurementError:
    wanted = f"{signal}_{next(iter(UNITS[signal]))}" if mapped is None else mapped.name
    shown = ", ".join(header[:12]) + (", ..." if len(header) > 12 else "")
    advice = f"name the right one with --map {signal}=COLUMN"
    for separator, word in ((";", "semicolons"), ("\t", "tabs")):
        if len(header) == 1 and separator in header[0]:
            advice = f"its columns are separated by {word}, save it with commas"
    return MeasurementError(f"{source}: there is no column {wanted} (found: {shown}); {advice}")
