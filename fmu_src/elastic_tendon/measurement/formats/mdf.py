"""MDF, the format of measurement and calibration tools, version 3 and 4."""

import logging
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from traceback import walk_tb
from typing import Any

import numpy as np
from asammdf import MDF
from asammdf.blocks.mdf_v3 import MDF3
from asammdf.blocks.mdf_v4 import MDF4
from numpy.typing import NDArray

from elastic_tendon.errors import MeasurementError
from elastic_tendon.measurement.formats.base import (
    Chunk,
    FileSource,
    Group,
    as_numbers,
    check_columns,
    reading,
    refusing_damage,
)
from elastic_tendon.progress import Progress

_KIND = "MDF file"
_TIME = "time_s"
# bytes of a group read at a time
_FRAGMENT = 1 << 22
# data types that are neither numbers nor text, by the version's first digit
_LEFT_OUT = {"3": range(8, 9), "4": range(10, 17)}


@dataclass(frozen=True)
class _Place:
    """Where a group lies: its number, and those of its channels."""

    group: int
    channels: Mapping[str, int]


def open_file(path: Path) -> "MdfSource":
    """Open an MDF file.

    Each channel group is a `Group`, called by its acquisition's name or ``group 0`` and so on;
    its master channel is the column ``time_s``. Arrays and structures are left out.

    Raises
    ------
    MeasurementError : the file is damaged or holds no usable channel
    """
    groups: list[Group] = []
    places: dict[str, _Place] = {}
    with refusing_damage(path, _KIND), _opened(path) as file:
        for number, data in enumerate(file.groups):
            name = _group_name(data, number, places)
            channels = _channels(file, number)
            units = {
                column: unit
                for column, index in channels.items()
                if (unit := "s" if column == _TIME else _unit(data.channels[index]))
            }
            rows = int(data.channel_group.cycles_nr)
            groups.append(Group(name, tuple(channels), units, rows))
            places[name] = _Place(number, channels)
    return MdfSource(path, check_columns(path, groups), places)


@contextmanager
def _opened(path: Path) -> Iterator[Any]:
    """Open a file without the logger, which would tell of damage beside our own sentence."""
    log = logging.getLogger("asammdf")
    was_disabled, log.disabled = log.disabled, True
    try:
        with MDF(path) as file:
            file.configure(read_fragment_size=_FRAGMENT)
            yield file
    except Exception as error:
        _close_half_made(error)
        raise
    finally:
        log.disabled = was_disabled


def _close_half_made(error: BaseException | None) -> None:
    """Close what could not be opened for damage, once and quietly.

    asammdf does so whenever the object goes, stumbles over a file that was never opened, and Python
    shows that as a traceback.
    """
    while error is not None:
        for frame, _ in walk_tb(error.__traceback__):
            half_made = frame.f_locals.get("self")
            if frame.f_code.co_name == "__init__" and isinstance(half_made, MDF3 | MDF4):
                vars(half_made).setdefault("_file", None)
                with suppress(AttributeError):
                    half_made.close()
        error = error.__context__


def _group_name(data: Any, number: int, taken: Mapping[str, object]) -> str:
    name = str(getattr(data.channel_group, "acq_name", "") or "").strip()
    return name if name and name not in taken else f"group {number}"


def _channels(file: Any, group: int) -> dict[str, int]:
    """Columns of a group and their channels; a name that comes again has its channel's number."""
    data = file.groups[group]
    left_out = _LEFT_OUT[file.version[0]]
    master = file.masters_db.get(group)
    channels: dict[str, int] = {} if master is None else {_TIME: master}
    for index, channel in enumerate(data.channels):
        whole = data.channel_dependencies[index] is None
        if index != master and whole and channel.data_type not in left_out:
            name = str(channel.name)
            channels[name if name not in channels else f"{name} ({index})"] = index
    return channels


def _unit(channel: Any) -> str:
    conversion = getattr(channel, "conversion", None)
    return str(channel.unit or getattr(conversion, "unit", "") or "").strip()


@dataclass(frozen=True)
class MdfSource(FileSource):
    """A `Source` with a group for each channel group."""

    places: Mapping[str, _Place]

    def read(self, group: str, columns: Sequence[str], progress: Progress) -> Iterator[Chunk]:
        """Read some columns in chunks, see `base.Source`."""
        rows = self.rows_of(group) or 0
        place = self.places[group]
        done = 0
        with refusing_damage(self.path, _KIND), _opened(self.path) as file:
            parts = [
                file.iter_get(group=place.group, index=place.channels[name], samples_only=True)
                for name in columns
            ]
            for part in zip(*parts, strict=True):
                chunk = {
                    name: _values(samples, invalid)
                    for name, (samples, invalid) in zip(columns, part, strict=True)
                }
                if size := len(chunk[columns[0]]):
                    yield chunk
                done += size
                progress(reading(self.path), min(done / max(rows, 1), 1.0))
        if done < rows:
            raise MeasurementError(
                f"{self.name}: {group} holds {done} of its {rows} samples; this {_KIND} is "
                "damaged or not complete; export it again"
            )


def _values(samples: Any, invalid: NDArray[np.bool_] | None) -> NDArray[Any]:
    values = as_numbers(np.asarray(samples))
    if values.dtype == object:
        return np.array([_text(value) for value in values], dtype=object)
    if invalid is not None and np.any(invalid):
        values = np.where(invalid, np.nan, values)
    return values


def _text(value: Any) -> str:
    return value.decode(errors="replace") if isinstance(value, bytes) else str(value)
