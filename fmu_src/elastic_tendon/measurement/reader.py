"""Read the recordings of a file: from a name to measurements, one for each run and piece."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from os.path import exists, isfile
from pathlib import Path
from typing import Literal

import numpy as np
import pandas as pd

from elastic_tendon.errors import MeasurementError
from elastic_tendon.measurement.assembly import Asked, Reading, assemble, check_static
from elastic_tendon.measurement.columns import find_layout
from elastic_tendon.measurement.formats import Source, open_source
from elastic_tendon.measurement.formats.base import label
from elastic_tendon.measurement.options import DEFAULT, ReadOptions
from elastic_tendon.measurement.preparation import Preparation, read_preparations
from elastic_tendon.measurement.recording import Measurement, joined, window_text
from elastic_tendon.measurement.rows import read_runs
from elastic_tendon.native.interpolation import AskedInterpolation
from elastic_tendon.progress import Progress, silent

_WINDOW = re.compile(r"(?P<path>.+)\[(?P<start>[^\[\]:]*):(?P<end>[^\[\]:]*)\]")
_MOST_NAMES = 6  # measurements that a sentence names
_LONGEST_NAME = 100  # characters of a name that a sentence repeats


def read(
    data: "str | Path | pd.DataFrame",
    *,
    window: tuple[float | None, float | None] | None = None,
    map: Mapping[str, str] | str | Path | None = None,
    shift: Mapping[str, float | Literal["auto"]] | None = None,
    resample: float | None = None,
    remove_offset: Sequence[str] = (),
    noise: Mapping[str, float] | None = None,
    interpolation: AskedInterpolation = "auto",
    joint_required: bool = True,
) -> Measurement:
    """Read one recording, from a file or a table in memory.

    Parameters
    ----------
    data : path of a file, ``"file.csv[start:end]"`` for a window; or a DataFrame with such columns
    window : first and last time that are read, s; None at an end leaves it open
    map : signal -> ``"column[:unit][*scale][+offset]"``, such as
        ``{"joint_position": "enc2:deg*-1"}``; or the path of a TOML file that says how to read, or
        of the JSON of an earlier comparison. Else columns are found by their names
    shift : signal -> s by which its sensor is late, or "auto": estimated by comparison
    resample : s between the samples, coarser than recorded; None: as recorded
    remove_offset : signals whose mean over the first 0.1 s becomes 0
    noise : signal -> standard deviation of its noise, rad or N·m, where it is known
    interpolation : of motor position and load between the samples: "hold", "linear", "cubic", or
        "auto": cubic where their spectra show that they are smooth, else linear
    joint_required : false where only the motor's motion and the load are wanted

    Returns
    -------
    Measurement; SI units. Where it has gaps, its `cuts` say where they are

    Raises
    ------
    MeasurementError : the data cannot be used, or hold several runs
    """
    if isinstance(map, Mapping):
        mapping = tuple(f"{signal}={column}" for signal, column in map.items())
    else:
        mapping = () if map is None else (str(map),)
    options = ReadOptions(
        mapping=mapping,
        time_shift=shift or {},
        resample=resample,
        remove_offset=tuple(remove_offset),
        interpolation=interpolation,
        joint_required=joint_required,
    )
    path = "" if isinstance(data, pd.DataFrame) else str(data)
    asked = path if window is None else path + window_text(*window)
    if isinstance(data, pd.DataFrame):
        from elastic_tendon.measurement.formats.frame import FrameSource

        source = FrameSource(data)
        ends = split_window(f"{source.name}{asked}")[1]
        written, _ = _written_preparations(Path(), options)
        measurements = _read_as_written(source, Asked("", asked, ends), written, options)
    else:
        measurements = read_prepared(asked, options)
    recording = _only(measurements, path or "the data frame")
    return recording if noise is None else recording.with_noise(noise)


def read_measurement(data: str, options: ReadOptions = DEFAULT) -> Measurement:
    """Read a file that holds one recording; see `read_prepared`.

    Raises
    ------
    MeasurementError : the file cannot be used, or holds several recordings
    """
    return _only(read_prepared(data, options), data)


def _only(measurements: Sequence[Measurement], data: str) -> Measurement:
    """The one recording that was read."""
    if measurements[0].whole and len({piece.recording for piece in measurements}) == 1:
        return joined(measurements)
    if len(measurements) > 1:
        names = ", ".join(recording.name for recording in measurements[:_MOST_NAMES])
        raise MeasurementError(
            f"{data}: it holds {len(measurements)} recordings ({names}"
            f"{', ...' if len(measurements) > _MOST_NAMES else ''}) where one is wanted; choose "
            "one by a window, file[start:end], or by runs in a preparation"
        )
    return measurements[0]


def read_prepared(
    data: str, options: ReadOptions = DEFAULT, progress: Progress = silent
) -> list[Measurement]:
    """Read a file by options, and by what lies beside it.

    Parameters
    ----------
    data : str; ``file.csv``, or ``file.csv[start:end]`` for a window in s
    options : where they name no preparation, ``file.csv.toml`` beside the file is taken if it is
        there
    progress : is told what is being done, and the share of it that is done

    Returns
    -------
    list of Measurement, at least one

    Raises
    ------
    MeasurementError : the file or its preparation cannot be used
    """
    path, window = split_window(data)
    written, notes = _written_preparations(path, options)
    asked = Asked(str(path), data, window)
    measurements = _read_as_written(_open(path), asked, written, options, progress)
    return [
        replace(measurement, notes=(*notes, *measurement.notes)) for measurement in measurements
    ]


def _read_as_written(
    source: Source,
    asked: Asked,
    written: Sequence[Preparation],
    options: ReadOptions,
    progress: Progress = silent,
) -> list[Measurement]:
    """Read the recordings of an opened source as preparations and options say."""
    labels = {
        name
        for group in source.groups
        for column in group.columns
        for name in (column, label(group.name, column))
    }
    merged = [options.over(preparation, labels) for preparation in written]
    return [
        measurement
        for preparation in _for_window(merged, asked.window, asked.data)
        for measurement in _read(source, asked, preparation, options, progress)
    ]


def _for_window(
    written: Sequence[Preparation], window: tuple[float, float] | None, data: str
) -> list[Preparation]:
    """Preparations for a window that is asked for, which comes before those written down.

    Pieces of a run that were prepared alike are one recording again; of pieces prepared
    differently, such as each with an offset of its own, the parts within the window are read.

    Raises
    ------
    MeasurementError : they say two things about one stretch, or nothing about the window
    """
    distinct = [part for i, part in enumerate(written) if part not in written[:i]]
    if window is None:
        return [part for part in distinct if not any(_lies_within(part, each) for each in distinct)]
    distinct = [part for part in distinct if _shared(part, window)] or distinct
    anywhere = [part.model_copy(update={"window": None}) for part in distinct]
    preparations: list[Preparation] = []
    for part, bare in zip(distinct, anywhere, strict=True):
        alike = all(earlier == bare for earlier in anywhere if earlier.runs == bare.runs)
        kept = bare.model_copy(update={"window": window if alike else _shared(part, window)})
        if kept.window is not None and kept not in preparations:
            preparations.append(kept)
    for i, part in enumerate(preparations):
        if any(
            part.runs == earlier.runs and _shared(part, earlier.window)
            for earlier in preparations[:i]
        ):
            raise MeasurementError(
                f"{data}: what is written down says two ways to read a part of this window; "
                "choose one that lies within one piece"
            )
    if not preparations:
        raise MeasurementError(
            f"{data}: what is written down says nothing about this window; choose one that "
            "overlaps a piece, or read the file without --map"
        )
    return preparations


def _lies_within(part: Preparation, whole: Preparation) -> bool:
    """Whether a stretch was prepared as a longer one that holds it."""
    return (
        part.window is not None
        and part.window != whole.window
        and part.window == _shared(part, whole.window)
        and whole == part.model_copy(update={"window": whole.window})
    )


def _shared(
    preparation: Preparation, window: tuple[float, float] | None
) -> tuple[float, float] | None:
    """What a preparation's window has in common with another."""
    first, last = preparation.window or (-np.inf, np.inf)
    start, end = window or (-np.inf, np.inf)
    common = max(first, start), min(last, end)
    return common if common[0] < common[1] else None


def _written_preparations(
    path: Path, options: ReadOptions
) -> tuple[tuple[Preparation, ...], tuple[str, ...]]:
    """Preparations from files, and a note where one was not asked for."""
    if options.files:
        return read_preparations(options.files[0], path), ()
    beside = Path(f"{path}.toml")
    if isfile(beside):
        return read_preparations(beside, path), (f"read as {beside.name} beside it says",)
    return (Preparation(),), ()


def read_measurements(data: str, preparation: Preparation | None = None) -> list[Measurement]:
    """Read the recordings of a file by a preparation alone.

    Parameters
    ----------
    data : str; ``file.csv``, or ``file.csv[start:end]`` for a window in s, which comes before
        that of the preparation
    preparation : Preparation; None: columns are found by their names

    Returns
    -------
    list of Measurement, at least one: for each run, and for each piece between gaps; SI units

    Raises
    ------
    MeasurementError : the file cannot be used; the message names column and row
    """
    path, window = split_window(data)
    preparation = preparation or Preparation()
    if window is not None:
        preparation = preparation.model_copy(update={"window": window})
    return _read(_open(path), Asked(str(path), data, window), preparation, DEFAULT, silent)


def _open(path: Path) -> Source:
    try:
        return open_source(path)
    except OSError as error:  # such as a name that is too long
        raise MeasurementError(
            f"{str(path)[:_LONGEST_NAME]}: the file cannot be read ({error.strerror}); "
            "check the name"
        ) from None


def _read(
    source: Source,
    asked: Asked,
    preparation: Preparation,
    options: ReadOptions,
    progress: Progress,
) -> list[Measurement]:
    """Read the recordings of an opened file as a preparation says."""
    required = options.joint_required
    layout = find_layout(source.groups, preparation, source.name, joint_required=required)
    check_static(preparation, layout, source.name)
    reading = Reading(source.name, asked, layout, preparation, options.interpolation)
    return assemble(reading, read_runs(source, layout, preparation, progress))


def split_window(data: str) -> tuple[Path, tuple[float, float] | None]:
    if "\0" in data:
        raise MeasurementError(f"{data!r}: the name of a file holds no NUL; check the name")
    match = _WINDOW.fullmatch(data)
    if match is None or exists(data):
        return Path(data), None
    try:
        start = float(match["start"] or -np.inf)
        end = float(match["end"] or np.inf)
    except ValueError:
        start = end = np.nan
    if not start < end:
        raise MeasurementError(
            f"{data}: the window [{match['start']}:{match['end']}] must be two numbers in s, the "
            "first below the second, such as [3.3:15], [3.3:] or [:15]"
        )
    return Path(match["path"]), (start, end)
