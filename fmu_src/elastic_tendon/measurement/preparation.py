"""What is done to a recording before it is compared: written down, so that it can be repeated.

The same tree stands in a TOML file beside the data and in the JSON of a comparison. A measurement
keeps the preparation that made it with every number filled in; reading the file with that one
gives the same samples, bit for bit.
"""

import difflib
import json
import re
import tomllib
from collections.abc import Container
from math import isfinite
from pathlib import Path
from typing import Any, Literal

from pydantic import BaseModel, Field, ValidationError, field_validator
from pydantic_core import PydanticCustomError

from elastic_tendon.actuator.problems import REFUSED, unknown_key
from elastic_tendon.actuator.quantity import STRICT
from elastic_tendon.errors import MeasurementError

# contract of the JSON of a comparison, which holds how each file was read
COMPARISON = "elastic-tendon/comparison/1"

# signal -> what its unit measures; in this order they are looked for
DIMENSIONS = {
    "time": "time",
    "motor_position": "angle",
    "joint_position": "angle",
    "joint_deflection": "angle",
    "load_torque": "torque",
    "joint_torque": "torque",
    "motor_torque": "torque",
    "upper_spring_force": "force",
    "lower_spring_force": "force",
    "motor_velocity": "speed",
}
# what a sensor may be late in; a static curve has no time, and the motor's speed is not used
SHIFTED = (
    *("motor_position", "joint_position", "load_torque", "joint_torque", "motor_torque"),
    *("upper_spring_force", "lower_spring_force"),
)

_NUMBER = r"[0-9]*\.?[0-9]+(?:[eE][+-]?[0-9]+)?"
_MAP = re.compile(
    rf"(?P<signal>\w+)=(?P<column>.+?)(?::(?P<unit>[^\W\d][^:*+=-]*|°[^:*+=-]*))?"
    rf"(?:\*(?P<scale>[+-]?{_NUMBER}))?(?P<offset>[+-]{_NUMBER})?"
)

# field -> what it may hold
_WANTED = {
    "": "a table with columns, time_shift, resample, window or runs",
    "columns": "a table such as [columns.joint_position]",
    "column": "the name of a column",
    "unit": 'a unit such as "deg"',
    "sign": "1 or -1",
    "scale": "a number",
    "offset": "a number in the SI unit of the signal",
    "remove_offset": '"start" or "mean"',
    "time_shift": 'a number of seconds for each signal, or "auto",',
    "resample": "a step in s, above 0,",
    "window": "a list of two times in s such as [3.3, 15.0]",
    "runs": "a list of values of the column run such as [1, 3]",
}


class SignalColumn(BaseModel):
    """Where a signal stands in the file: ``signal = column * unit * sign * scale + offset``.

    Parameters
    ----------
    column : name of the column, ``group/column`` in files with groups; None: found by its name
    unit : None: as the column's name or the file says, else SI
    sign : -1 where the sensor counts the other way
    scale : such as a gear ratio
    offset : added last, in the signal's SI unit
    remove_offset : "start": the mean over the first 0.1 s of what is read becomes `offset`;
        "mean": the mean over all that is read
    """

    model_config = STRICT

    column: str | None = Field(default=None, min_length=1)
    unit: str | None = Field(default=None, min_length=1)
    sign: Literal[1, -1] = 1
    scale: float = 1.0
    offset: float = 0.0
    remove_offset: Literal["start", "mean"] | None = None

    @field_validator("scale")
    @classmethod
    def _not_zero(cls, value: float) -> float:
        if value == 0.0:
            raise _refused("0 would leave nothing of the signal")
        return value


class Preparation(BaseModel):
    """All that is done to a recording.

    Parameters
    ----------
    columns : signal -> its column; signals that are left out are found by their names
    time_shift : signal -> s by which its sensor is late, or "auto": estimated by comparison
    resample : s between the samples, which lie at its whole multiples; None: as recorded
    window : first and last time that are read, s, in the time of the file
    runs : values of the column ``run`` that are read; None: all
    """

    model_config = STRICT

    columns: dict[str, SignalColumn] = Field(default_factory=dict)
    time_shift: dict[str, float | Literal["auto"]] = Field(default_factory=dict)
    resample: float | None = Field(default=None, gt=0.0)
    window: tuple[float, float] | None = None
    runs: tuple[int | str, ...] | None = Field(default=None, min_length=1)

    @field_validator("window", "runs", mode="before")
    @classmethod
    def _tuple(cls, value: object) -> object:
        # TOML and JSON have lists, which a strict model does not take for tuples
        return tuple(value) if isinstance(value, list) else value

    @field_validator("columns")
    @classmethod
    def _known(cls, value: dict[str, SignalColumn]) -> dict[str, SignalColumn]:
        for signal in value:
            if signal not in DIMENSIONS:
                raise _refused(unknown_signal(signal))
        if "time" in value and value["time"].remove_offset is not None:
            raise _refused("remove_offset is for positions and torques, not for time")
        return value

    @field_validator("time_shift")
    @classmethod
    def _shiftable(cls, value: dict[str, Any]) -> dict[str, Any]:
        for signal in value:
            if signal not in SHIFTED:
                raise _refused(f"{signal!r} cannot be shifted; shift {', '.join(SHIFTED)}")
        return value

    @field_validator("window")
    @classmethod
    def _forward(cls, value: tuple[float, float] | None) -> tuple[float, float] | None:
        if value is not None and not value[0] < value[1]:
            raise _refused("the window must end after it starts")
        return value


def parse_map(text: str, labels: Container[str] = ()) -> tuple[str, SignalColumn]:
    """Read one ``--map`` item, ``signal=column[:unit][*scale][+offset]``.

    Parameters
    ----------
    text : str; `scale` may be negative (a sign) or a gear ratio, `offset` is in the signal's SI
        unit and is added last
    labels : columns of the file, where they are known; what is as a whole the name of one is
        that column, whatever signs are in it

    Returns
    -------
    signal, and its column

    Raises
    ------
    MeasurementError : the item is misspelt, or its signal is not known
    """
    match = _MAP.fullmatch(text.strip())
    if match is None:
        raise MeasurementError(
            f"--map {text!r}: write it as signal=column[:unit][*scale][+offset], "
            "for example joint_position=encoder_2:deg*-1"
        )
    if match["signal"] not in DIMENSIONS:
        raise MeasurementError(f"--map {text!r}: {unknown_signal(match['signal'])}")
    whole = text.partition("=")[2].strip()
    if whole in labels:
        return match["signal"], SignalColumn(column=whole)
    scale, offset = float(match["scale"] or 1.0), float(match["offset"] or 0.0)
    if not (isfinite(scale) and isfinite(offset)):
        raise MeasurementError(f"--map {text!r}: a number in it is too large; write a smaller one")
    if scale == 0.0:
        raise MeasurementError(f"--map {text!r}: a scale of 0 would leave nothing of the signal")
    return match["signal"], SignalColumn(
        column=match["column"],
        unit=match["unit"],
        scale=scale,
        offset=offset,
    )


def unknown_signal(signal: str) -> str:
    """Sentence for a signal that nobody knows."""
    near = difflib.get_close_matches(signal, DIMENSIONS, n=1)
    advice = f"did you mean {near[0]}?" if near else f"choose one of {', '.join(DIMENSIONS)}"
    return f"there is no signal {signal!r}; {advice}"


def preparation_json(preparation: BaseModel) -> dict[str, Any]:
    """Tree of plain values, as it stands in TOML and JSON: what is not done is left out."""
    tree: dict[str, Any] = preparation.model_dump(mode="json", exclude_none=True)
    return {key: value for key, value in tree.items() if value != {}}


def check_preparation(tree: object, source: str) -> Preparation:
    """Check the content of a preparation; `source` names it in messages.

    Raises
    ------
    MeasurementError : the first field that is not known or has no fitting value
    """
    try:
        return Preparation.model_validate(tree)
    except ValidationError as error:
        problem = error.errors()[0]
    location = [str(part) for part in problem["loc"]]
    path = ".".join(location)
    if problem["type"] == REFUSED:
        sentence = f"{path}: {problem['msg']}"
    elif problem["type"] == "extra_forbidden":
        table = SignalColumn if len(location) > 1 else Preparation
        where = f"[{'.'.join(location[:-1])}]" if len(location) > 1 else "a preparation"
        sentence = unknown_key(path, location[-1], table.model_fields, where)
    else:
        # what follows is the place in a list, or which of two types was tried
        location = location[: {"columns": 3, "time_shift": 2}.get("".join(location[:1]), 1)]
        field = next((name for name in reversed(location) if name in _WANTED), "")
        value = list(problem["input"]) if isinstance(problem["input"], tuple) else problem["input"]
        sentence = f"{value!r} is found where {_WANTED[field]} is expected"
        sentence = ": ".join([*filter(None, [".".join(location)]), sentence])
    raise MeasurementError(f"{source}: {sentence}")


def read_preparations(path: Path, data: Path) -> tuple[Preparation, ...]:
    """Read how a file of measurements is prepared.

    Parameters
    ----------
    path : TOML file with one preparation, or the JSON of a comparison
    data : the file of measurements; a comparison has a preparation for each run and each piece
        of it

    Returns
    -------
    tuple of Preparation, at least one

    Raises
    ------
    MeasurementError : the file cannot be read or used
    """
    source = path.name
    try:
        text = path.read_bytes().decode("utf-8-sig")
        if path.suffix.lower() != ".json":
            return (check_preparation(tomllib.loads(text), source),)
        tree = json.loads(text)
    except FileNotFoundError:
        raise MeasurementError(
            f"{path}: there is no such file; name a preparation in TOML, the JSON of a "
            "comparison, or write signal=column[:unit][*scale][+offset]"
        ) from None
    except UnicodeDecodeError:
        raise MeasurementError(f"{source}: this is not a text file; save it in UTF-8") from None
    except OSError as error:
        raise MeasurementError(f"{path}: the file cannot be read ({error.strerror})") from None
    except ValueError as error:
        kind = "JSON" if path.suffix.lower() == ".json" else "TOML"
        raise MeasurementError(f"{source}: this is not valid {kind}: {error}") from None
    return _of_comparison(tree, source, data)


def _of_comparison(tree: object, source: str, data: Path) -> tuple[Preparation, ...]:
    """Preparations of one file of measurements in the JSON of a comparison.

    The file is that of the same path; where there is none, as in another folder, that of the same
    name.
    """
    files = tree.get("files") if isinstance(tree, dict) and tree.get("schema") == COMPARISON else 0
    if not isinstance(files, list) or not all(
        isinstance(file, dict) and {"source", "preparation"} <= file.keys() for file in files
    ):
        raise MeasurementError(
            f"{source}: this is not the JSON of a comparison that says how each file was read "
            f"({COMPARISON}); write one with compare --json"
        )
    paths = list(dict.fromkeys(str(file["source"]) for file in files))
    same = [path for path in paths if path == str(data)] or [
        path for path in paths if Path(path).name == data.name
    ]
    if not same:
        raise MeasurementError(
            f"{source}: there is nothing about {data.name} (found: {', '.join(paths) or 'none'}); "
            "name one of these files, or compare it without this preparation"
        )
    if len(same) > 1:
        raise MeasurementError(
            f"{source}: it holds several files called {data.name} ({', '.join(same)}); name one of "
            "them by this path"
        )
    return tuple(
        check_preparation(file["preparation"], f"{source}: {file.get('name', same[0])}")
        for file in files
        if str(file["source"]) == same[0]
    )


def _refused(sentence: str) -> PydanticCustomError:
    return PydanticCustomError(REFUSED, "{sentence}", {"sentence": sentence})
