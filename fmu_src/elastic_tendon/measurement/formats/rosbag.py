"""ROS 2 bags: a MCAP or SQLite file, or the folder that holds such files."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, fields, is_dataclass
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore

from elastic_tendon.errors import MeasurementError
from elastic_tendon.measurement.formats.base import (
    Chunk,
    FileSource,
    Group,
    check_columns,
    reading,
    refusing_damage,
)
from elastic_tendon.progress import Progress

_KIND = "ROS 2 bag"
_TIME = "time_s"
_SUFFIXES = (".mcap", ".db3")
# messages of a topic that are looked at for its columns: several nodes may publish on one topic
_SCANNED = 100
_CHUNK_MESSAGES = 10_000
# longer arrays are pictures and point clouds
_LONGEST_ARRAY = 100
_NANOSECOND = 1e-9


def open_file(path: Path) -> "RosbagSource":
    """Open a ROS 2 bag.

    Each topic is a `Group`; the numbers of its messages are columns such as ``pose.position.x``
    or ``position[0]``, those of sensor_msgs/JointState ``position[elbow]`` by the joint's name.
    ``time_s`` is the header's stamp where there is one, else the time of recording. Message types
    come from the bag, else they are those of ROS 2 Jazzy.

    Raises
    ------
    MeasurementError : the bag is damaged, its messages are not ROS 2's, or hold no numbers
    """
    if not path.is_dir() and path.suffix not in _SUFFIXES:
        raise MeasurementError(
            f"{path.name}: this is a {_KIND}; rename it so that it ends in {' or '.join(_SUFFIXES)}"
        )
    groups: list[Group] = []
    stamped: set[str] = set()
    with _opened(path) as bag:
        for topic in dict.fromkeys(connection.topic for connection in bag.connections):
            columns: dict[str, None] = {}
            first = 0.0
            for message, _ in islice(_messages(bag, topic), _SCANNED):
                columns |= dict.fromkeys(name for name, _ in _numbers(message))
                first = first or _stamp(message)
            if columns:
                rows = bag.topics[topic].msgcount
                names = (_TIME, *columns)
                groups.append(Group(topic, names, {_TIME: "s"}, rows, bracketed_units=False))
            if first:
                stamped.add(topic)
    return RosbagSource(path, check_columns(path, groups), frozenset(stamped))


@contextmanager
def _opened(path: Path) -> Iterator[AnyReader]:
    types = get_typestore(Stores.ROS2_JAZZY)
    with refusing_damage(path, _KIND), AnyReader([path], default_typestore=types) as bag:
        for connection in bag.connections:
            encoding = getattr(connection.ext, "serialization_format", "cdr")
            if encoding != "cdr":
                raise MeasurementError(
                    f"{path.name}: the messages of {connection.topic} are encoded as {encoding} "
                    "and not as ROS 2 does (cdr); export the table as CSV"
                )
        yield bag


def _messages(bag: AnyReader, topic: str) -> Iterator[tuple[Any, float]]:
    """Messages of a topic, each with the time of recording in s."""
    connections = [each for each in bag.connections if each.topic == topic]
    for connection, time, raw in bag.messages(connections):
        yield bag.deserialize(raw, connection.msgtype), time * _NANOSECOND


def _stamp(message: Any) -> float:
    """Time of a message by its header, s; 0 where it has none or nobody set it."""
    stamp = getattr(getattr(message, "header", None), "stamp", None)
    return 0.0 if stamp is None else float(stamp.sec + stamp.nanosec * _NANOSECOND)


def _numbers(message: Any, path: str = "") -> Iterator[tuple[str, float]]:
    """Numbers of a message with their paths, in the order of its definition."""
    joints = list(message.name) if message.__msgtype__.endswith("/JointState") else None
    for field in fields(message):
        value = getattr(message, field.name)
        name = f"{path}.{field.name}" if path else field.name
        if _is_number(value):
            yield name, float(value)
        elif is_dataclass(value):
            if name != "header":
                yield from _numbers(value, name)
        elif isinstance(value, np.ndarray | list) and len(value) <= _LONGEST_ARRAY:
            indices = joints if joints and len(joints) == len(value) else range(len(value))
            for index, part in zip(indices, value, strict=True):
                if is_dataclass(part):
                    yield from _numbers(part, f"{name}[{index}]")
                elif _is_number(part):
                    yield f"{name}[{index}]", float(part)


def _is_number(value: object) -> bool:
    return isinstance(value, int | float | np.number) and not isinstance(value, bool)


@dataclass(frozen=True)
class RosbagSource(FileSource):
    """A `Source` with a group for each topic."""

    stamped: frozenset[str]  # topics whose messages carry their time

    def read(self, group: str, columns: Sequence[str], progress: Progress) -> Iterator[Chunk]:
        """Read some columns in chunks, see `base.Source`.

        A message without any of the columns, such as one of another joint's, is left out; one
        without some of them has NaN there. Messages of several nodes, or late ones, are not
        recorded in the order of their stamps: they are sorted by time.
        """
        count = self.rows_of(group) or 1
        done = 0
        signals = set(columns) - {_TIME}
        tables: list[Chunk] = []
        with _opened(self.path) as bag:
            messages = _messages(bag, group)
            while some := list(islice(messages, _CHUNK_MESSAGES)):
                rows = [self._row(group, message, time) for message, time in some]
                kept = [row for row in rows if not signals.isdisjoint(row)] if signals else rows
                if kept:
                    tables.append(_table(kept, (_TIME, *columns)))
                done += len(some)
                progress(reading(self.path), min(done / count, 1.0))
        if tables:
            order = np.argsort(np.concatenate([table[_TIME] for table in tables]), kind="stable")
            yield {
                name: np.concatenate([table[name] for table in tables])[order] for name in columns
            }

    def _row(self, topic: str, message: Any, recorded: float) -> Mapping[str, float]:
        time = _stamp(message) if topic in self.stamped else recorded
        return {_TIME: time, **dict(_numbers(message))}


def _table(rows: Sequence[Mapping[str, float]], columns: Sequence[str]) -> Chunk:
    return {name: np.array([row.get(name, np.nan) for row in rows]) for name in columns}
