"""Read a recording from a CSV file."""

import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from elastic_tendon.errors import MeasurementError
from elastic_tendon.interpolation import Interpolation
from elastic_tendon.measurement.columns import REQUIRED, Column, find_columns, parse_map
from elastic_tendon.measurement.recording import MINIMUM_SAMPLES, Array, Measurement

_WINDOW = re.compile(r"(?P<path>.+)\[(?P<start>[^\[\]:]*):(?P<end>[^\[\]:]*)\]")
# the header is row 1 of the file as an editor shows it
_FIRST_ROW = 2


def read_measurement(
    data: str,
    mapping: Sequence[str] = (),
    *,
    interpolation: Interpolation = "linear",
    joint_required: bool = True,
) -> Measurement:
    """Read one recording.

    Parameters
    ----------
    data : str; ``file.csv``, or ``file.csv[start:end]`` for a window in s
    mapping : items ``signal=column[:unit][*scale][+offset]``, see `columns.parse_map`
    interpolation : of motor position and load between the samples; "cubic" suits smooth inputs,
        "linear" and "hold" those that step or are coarsely rounded
    joint_required : false where only the motor's motion and the load are wanted

    Returns
    -------
    Measurement; SI units

    Raises
    ------
    MeasurementError : the file cannot be used; the message names column and row
    """
    path, start, end = _split_window(data)
    source = path.name
    mapped = [parse_map(item) for item in mapping]
    table = _read_table(path)
    required = REQUIRED if joint_required else tuple(set(REQUIRED) - {"joint_position"})
    columns = find_columns([str(name) for name in table.columns], mapped, source, required)
    arrays = {column.signal: _numbers(table, column, source) for column in columns}
    time = arrays.pop("time")
    _check_time(time, source)
    measurement = Measurement(
        name=source,
        time=time,
        motor_position=arrays.pop("motor_position"),
        load_torque=arrays.pop("load_torque", None),
        interpolation=interpolation,
        notes=_notes(table, columns),
        signals={name: values for name, values in arrays.items() if name != "motor_velocity"},
    )
    return measurement if start is end is None else measurement.window(start, end)


def _split_window(data: str) -> tuple[Path, float | None, float | None]:
    match = _WINDOW.fullmatch(data)
    if match is None or Path(data).exists():
        return Path(data), None, None
    try:
        start, end = (float(match[key]) if match[key] else None for key in ("start", "end"))
    except ValueError:
        raise MeasurementError(
            f"{data}: the window [{match['start']}:{match['end']}] must be two numbers in s, "
            "such as [3.3:15], [3.3:] or [:15]"
        ) from None
    return Path(match["path"]), start, end


def _read_table(path: Path) -> pd.DataFrame:
    if not path.exists():
        raise MeasurementError(f"{path}: there is no such file; check the name and the folder")
    if path.is_dir():
        raise MeasurementError(f"{path}: this is a folder; name one CSV file in it")
    try:
        # blank lines are kept so that row numbers are those of the file
        table = pd.read_csv(path, skip_blank_lines=False, skipinitialspace=True, low_memory=False)
    except pd.errors.EmptyDataError:
        raise MeasurementError(
            f"{path.name}: the file is empty; it needs a header and one row for each sample"
        ) from None
    except (pd.errors.ParserError, UnicodeDecodeError) as error:
        reason = str(error).strip().removeprefix("Error tokenizing data. C error: ")
        raise MeasurementError(
            f"{path.name}: this is not a table of comma-separated values ({reason}); "
            "give every row as many values as the header has names"
        ) from None
    except OSError as error:
        raise MeasurementError(f"{path}: the file cannot be read ({error.strerror})") from None
    filled = np.flatnonzero(table.notna().any(axis=1).to_numpy())
    table = table.iloc[: filled[-1] + 1 if len(filled) else 0]
    if len(table) < MINIMUM_SAMPLES:
        raise MeasurementError(
            f"{path.name}: it holds {len(table) or 'no'} samples below the header and needs at "
            f"least {MINIMUM_SAMPLES}"
        )
    return table


def _numbers(table: pd.DataFrame, column: Column, source: str) -> Array:
    """Column in SI units; refuses text, gaps and infinities with their row."""
    raw = table[column.name]
    values = pd.to_numeric(raw, errors="coerce").to_numpy(dtype=np.float64)
    bad = np.flatnonzero(~np.isfinite(values))
    if len(bad):
        row = int(bad[0])
        cell = raw.iloc[row]
        found = "no number" if pd.isna(cell) else repr(str(cell))
        raise MeasurementError(
            f"{source}: column {column.name}, row {row + _FIRST_ROW} holds {found}; every sample "
            f"needs a finite number ({len(bad)} of {len(values)} rows are like this)"
        )
    return np.ascontiguousarray(values * column.factor + column.offset)


def _check_time(time: Array, source: str) -> None:
    steps = np.diff(time)
    bad = np.flatnonzero(steps <= 0.0)
    if len(bad):
        row = int(bad[0]) + 1
        raise MeasurementError(
            f"{source}: the time does not increase at row {row + _FIRST_ROW} "
            f"({time[row]:g} s after {time[row - 1]:g} s); sort the rows and drop repeated ones"
        )


def _notes(table: pd.DataFrame, columns: Sequence[Column]) -> tuple[str, ...]:
    used = {column.name for column in columns}
    extra = [str(name) for name in table.columns if name not in used]
    notes = []
    if extra:
        notes.append(f"not used: {', '.join(extra)}")
    if any(column.signal == "motor_velocity" for column in columns):
        notes.append("motor_velocity is not used: the motor position is differentiated instead")
    return tuple(notes)
