"""Read the recordings of a file: from a name to measurements, one for each run and piece."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from os.path import exists, isfile
from pathlib import Path
from typing import Literal

import numpy as np

from elastic_tendon.errors import MeasurementError
from elastic_tendon.interpolation import Interpolation
from elastic_tendon.measurement.columns import Column, Layout, find_layout
from elastic_tendon.measurement.formats import Report, Source, open_source, silent
from elastic_tendon.measurement.formats.base import label
from elastic_tendon.measurement.preparation import (
    Preparation,
    SignalColumn,
    check_preparation,
    preparation_json,
    read_preparations,
)
from elastic_tendon.measurement.recording import MINIMUM_SAMPLES, Measurement, window_text
from elastic_tendon.measurement.rows import MAXIMUM_SAMPLES, Label, Run, read_runs
from elastic_tendon.measurement.tracks import Track, Tracks, common_time, on_one_clock, pieces

# s between the samples of a static curve: the sweep is slow against every motion of a joint
STATIC_STEP = 1000.0

_WINDOW = re.compile(r"(?P<path>.+)\[(?P<start>[^\[\]:]*):(?P<end>[^\[\]:]*)\]")
# s at the beginning that "start" takes for rest
_BEGINNING = 0.1
# an evenly sampled recording has steps that differ by less than this share
_EVEN = 0.1
_MOST_NAMES = 6  # measurements that a sentence names
_LONGEST_NAME = 100  # characters of a name that a sentence repeats


def read_measurement(
    data: str,
    mapping: Sequence[str] = (),
    *,
    interpolation: Interpolation = "linear",
    joint_required: bool = True,
) -> Measurement:
    """Read a file that holds one recording.

    Parameters
    ----------
    data, mapping, interpolation, joint_required : see `read_prepared`

    Returns
    -------
    Measurement; SI units

    Raises
    ------
    MeasurementError : the file cannot be used, or holds several recordings
    """
    found = read_prepared(data, mapping, interpolation=interpolation, joint_required=joint_required)
    if len(found) > 1:
        names = ", ".join(one.name for one in found[:_MOST_NAMES])
        raise MeasurementError(
            f"{data}: it holds {len(found)} recordings ({names}"
            f"{', ...' if len(found) > _MOST_NAMES else ''}) where one is wanted; choose one by a "
            "window, file[start:end], or by runs in a preparation"
        )
    return found[0]


def read_prepared(
    data: str,
    mapping: Sequence[str] = (),
    *,
    time_shift: Mapping[str, float | Literal["auto"]] | None = None,
    resample: float | None = None,
    remove_offset: Sequence[str] = (),
    interpolation: Interpolation = "linear",
    joint_required: bool = True,
    report: Report = silent,
) -> list[Measurement]:
    """Read a file as the command line says: by options, and by what lies beside it.

    Parameters
    ----------
    data : str; ``file.csv``, or ``file.csv[start:end]`` for a window in s
    mapping : items ``signal=column[:unit][*scale][+offset]``, and at most one name of a
        preparation (TOML) or comparison (JSON); without one, ``file.csv.toml`` beside the file is
        taken where it is there
    time_shift, resample, remove_offset : see `Preparation.merged`
    interpolation, joint_required, report : see `read_measurements`

    Returns
    -------
    list of Measurement, at least one

    Raises
    ------
    MeasurementError : the file or its preparation cannot be used
    """
    path, window = _split_window(data)
    written, notes = _written_preparations(path, mapping)
    source = _open(path)
    labels = {
        name
        for group in source.groups
        for column in group.columns
        for name in (column, label(group.name, column))
    }
    items = [item for item in mapping if not _is_file(item)]
    merged = [
        one.merged(
            items,
            labels=labels,
            time_shift=time_shift,
            resample=resample,
            remove_offset=remove_offset,
        )
        for one in written
    ]
    return [
        replace(measurement, notes=(*notes, *measurement.notes))
        for preparation in _for_window(merged, window, data)
        for measurement in _read(
            source,
            _Asked(str(path), data, window),
            preparation,
            interpolation=interpolation,
            joint_required=joint_required,
            report=report,
        )
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
    distinct = [one for i, one in enumerate(written) if one not in written[:i]]
    if window is None:
        return distinct
    distinct = [one for one in distinct if _shared(one, window)] or distinct
    anywhere = [one.model_copy(update={"window": None}) for one in distinct]
    found: list[Preparation] = []
    for one, bare in zip(distinct, anywhere, strict=True):
        alike = all(other == bare for other in anywhere if other.runs == bare.runs)
        kept = bare.model_copy(update={"window": window if alike else _shared(one, window)})
        if kept.window is not None and kept not in found:
            found.append(kept)
    for i, one in enumerate(found):
        if any(one.runs == other.runs and _shared(one, other.window) for other in found[:i]):
            raise MeasurementError(
                f"{data}: what is written down says two ways to read a part of this window; "
                "choose one that lies within one piece"
            )
    if not found:
        raise MeasurementError(
            f"{data}: what is written down says nothing about this window; choose one that "
            "overlaps a piece, or read the file without --map"
        )
    return found


def _shared(
    preparation: Preparation, window: tuple[float, float] | None
) -> tuple[float, float] | None:
    """What a preparation's window has in common with another."""
    first, last = preparation.window or (-np.inf, np.inf)
    start, end = window or (-np.inf, np.inf)
    common = max(first, start), min(last, end)
    return common if common[0] < common[1] else None


def _is_file(item: str) -> bool:
    return "=" not in item or isfile(item)


def _written_preparations(
    path: Path, mapping: Sequence[str]
) -> tuple[tuple[Preparation, ...], tuple[str, ...]]:
    """Preparations from files, and a note where one was not asked for."""
    files = [Path(item) for item in mapping if _is_file(item)]
    if len(files) > 1:
        raise MeasurementError(
            f"--map names two preparations, {files[0]} and {files[1]}; put both in one file"
        )
    if files:
        return read_preparations(files[0], path), ()
    beside = Path(f"{path}.toml")
    if isfile(beside):
        return read_preparations(beside, path), (f"read as {beside.name} beside it says",)
    return (Preparation(),), ()


def read_measurements(
    data: str,
    preparation: Preparation | None = None,
    *,
    interpolation: Interpolation = "linear",
    joint_required: bool = True,
    report: Report = silent,
) -> list[Measurement]:
    """Read the recordings of a file.

    Parameters
    ----------
    data : str; ``file.csv``, or ``file.csv[start:end]`` for a window in s, which comes before
        that of the preparation
    preparation : Preparation; None: columns are found by their names
    interpolation : of motor position and load between the samples; "cubic" suits smooth inputs,
        "linear" and "hold" those that step or are coarsely rounded
    joint_required : false where only the motor's motion and the load are wanted
    report : is told what is being done, and the share of it that is done

    Returns
    -------
    list of Measurement, at least one: for each run, and for each piece between gaps; SI units

    Raises
    ------
    MeasurementError : the file cannot be used; the message names column and row
    """
    path, window = _split_window(data)
    preparation = preparation or Preparation()
    if window is not None:
        preparation = preparation.model_copy(update={"window": window})
    return _read(
        _open(path),
        _Asked(str(path), data, window),
        preparation,
        interpolation=interpolation,
        joint_required=joint_required,
        report=report,
    )


def _open(path: Path) -> Source:
    try:
        return open_source(path)
    except OSError as error:  # such as a name that is too long
        raise MeasurementError(
            f"{str(path)[:_LONGEST_NAME]}: the file cannot be read ({error.strerror}); "
            "check the name"
        ) from None


@dataclass(frozen=True)
class _Asked:
    """What the user wrote, ``path[start:end]``, and the window in it."""

    path: str
    data: str
    window: tuple[float, float] | None

    def suffix(self, preparation: Preparation) -> str:
        """The window as the user wrote it, "" where another is read."""
        asked = self.window is not None and preparation.window == self.window
        return self.data.removeprefix(self.path) if asked else ""


def _read(
    source: Source,
    asked: _Asked,
    preparation: Preparation,
    *,
    interpolation: Interpolation,
    joint_required: bool,
    report: Report,
) -> list[Measurement]:
    """Read the recordings of an opened file as a preparation says."""
    layout = find_layout(source.groups, preparation, source.name, joint_required=joint_required)
    if layout.static:
        _check_static(preparation, layout, source.name)
    reading = _Reading(source.name, asked, layout, preparation, interpolation)
    runs = read_runs(source, layout, preparation, report)
    short = [run for run in runs if _count(run, layout) < MINIMUM_SAMPLES]
    if len(short) == len(runs):
        raise _too_short(runs[0], reading)
    notes = _short_run_notes([run.label for run in short], cut=any(run.cut for run in short))
    return [
        replace(one, notes=(*one.notes, *notes))
        for run in runs
        if _count(run, layout) >= MINIMUM_SAMPLES
        for one in _measurements(reading, run)
    ]


def _check_static(preparation: Preparation, layout: Layout, source: str) -> None:
    """Refuse what needs a time."""
    asked: dict[str, object] = {
        "a window": preparation.window,
        "--resample": preparation.resample,
        "--shift": preparation.time_shift,
    }
    if any(column.prepared.remove_offset == "start" for column in layout.signals):
        asked["--remove-offset"] = "start"
    for name, value in asked.items():
        if value:
            raise MeasurementError(
                f"{source}: this is a static curve, it has no time; read it without {name}"
            )


def _split_window(data: str) -> tuple[Path, tuple[float, float] | None]:
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


@dataclass(frozen=True)
class _Reading:
    """How a file is read."""

    source: str
    asked: _Asked
    layout: Layout
    preparation: Preparation
    interpolation: Interpolation

    def name(self, run: Run) -> str:
        """Name of the file, with the run where it has some."""
        return self.source + (f"#{run.label}" if run.label is not None else "")


def _measurements(reading: _Reading, run: Run) -> list[Measurement]:
    """Measurements of one run: one, or several where it has gaps."""
    name = reading.name(run)
    columns = {one.signal: _resolved(one, run.tracks[one.signal]) for one in reading.layout.signals}
    tracks = {
        one.signal: run.tracks[one.signal].converted(one.factor, columns[one.signal].offset)
        for one in reading.layout.signals
    }
    notes = (*_run_notes(run, reading), *_offset_notes(reading.layout, columns))
    if reading.layout.static:
        return [_static_measurement(reading, run, name, tracks, columns, notes)]
    found, left_out = [], []
    parts = pieces(tracks, reading.preparation.resample)
    for part, window in parts:
        measurement = _of_piece(reading, run, name, part, window, columns)
        if measurement is None:
            left_out.append(part)
        else:
            found.append(measurement)
    if not found:
        raise _nothing_in_common(name, tracks)
    if len(parts) > 1:
        notes += _gap_notes(found, left_out, reading.preparation.resample)
    return [replace(one, notes=(*one.notes, *notes)) for one in found]


def _count(run: Run, layout: Layout) -> int:
    """Samples of the signal that has the fewest."""
    if len(run.tracks) < len(layout.signals):
        return 0
    return min(len(track.time) for track in run.tracks.values())


def _too_short(run: Run, reading: _Reading) -> MeasurementError:
    """Say why a run of less than ten samples cannot be used."""
    name = reading.name(run) + reading.asked.suffix(reading.preparation)
    count = _count(run, reading.layout)
    held = {signal for signal, track in run.tracks.items() if len(track.time)}
    empty = [one.label for one in reading.layout.signals if one.signal not in held]
    if held and empty:
        return MeasurementError(
            f"{name}: column {empty[0]} holds no number; fill it, or choose another column"
        )
    if run.cut:
        return MeasurementError(
            f"{name}: the window holds {count} samples and needs {MINIMUM_SAMPLES}; the recording "
            f"runs from {run.span[0]:.15g} s to {run.span[1]:.15g} s"
        )
    step = reading.preparation.resample
    after = "" if step is None else f" after resampling to {step:g} s"
    return MeasurementError(
        f"{name}: it holds {count or 'no'} samples{after} and needs at least {MINIMUM_SAMPLES}"
    )


def _resolved(column: Column, track: Track) -> SignalColumn:
    """The column with the offset that is really added."""
    prepared = column.prepared
    if prepared.remove_offset is None:
        return prepared
    values = track.values
    if prepared.remove_offset == "start":
        values = values[track.time <= track.time[0] + _BEGINNING]
    removed = float(np.mean(values * column.factor))
    return prepared.model_copy(update={"offset": prepared.offset - removed, "remove_offset": None})


def _of_piece(
    reading: _Reading,
    run: Run,
    name: str,
    part: Tracks,
    window: tuple[float, float] | None,
    columns: Mapping[str, SignalColumn],
) -> Measurement | None:
    """Measurement of one piece, None where fewer than ten samples are in common."""
    first, last = common_time(part)
    reference = "joint_position" if "joint_position" in part else "motor_position"
    if not first < last or len(part[reference].time) < MINIMUM_SAMPLES:
        return None
    step = reading.preparation.resample
    if step is not None and last - first > step * MAXIMUM_SAMPLES:
        raise MeasurementError(
            f"{name}: resampled to {step:g} s it has more than {MAXIMUM_SAMPLES} samples; choose a "
            "longer step"
        )
    time, values = on_one_clock(part, reference, step)
    if len(time) < MINIMUM_SAMPLES:
        return None
    shown = window_text(time[0], time[-1]) if run.cut or window is not None else ""
    preparation = _resolved_preparation(reading, run, window, columns)
    told = preparation.time_shift
    shifts = {signal: shift for signal, shift in told.items() if shift != "auto"}
    waiting = {signal: shift for signal, shift in told.items() if shift == "auto"}
    measurement = Measurement(
        name=name + ((window is None and reading.asked.suffix(reading.preparation)) or shown),
        time=time,
        motor_position=values.pop("motor_position"),
        load_torque=values.pop("load_torque", None),
        signals=values,
        interpolation=reading.interpolation,
        notes=(*reading.layout.notes, *_clock_notes(part, reference, step)),
        preparation=preparation.model_copy(update={"time_shift": waiting}),
        source=reading.asked.path,
    )
    return measurement.shifted(shifts) if shifts else measurement


def _static_measurement(
    reading: _Reading,
    run: Run,
    name: str,
    tracks: Tracks,
    columns: Mapping[str, SignalColumn],
    notes: tuple[str, ...],
) -> Measurement:
    """A static curve as a slow sweep of the load: in equilibrium it bears the joint torque."""
    deflection = tracks["joint_deflection"].values
    return Measurement(
        name=name,
        time=STATIC_STEP * np.arange(len(deflection), dtype=np.float64),
        motor_position=np.zeros(len(deflection)),
        signals={"joint_position": deflection},
        load_torque=-tracks["joint_torque"].values,
        interpolation=reading.interpolation,
        notes=(*reading.layout.notes, *notes),
        static=True,
        preparation=_resolved_preparation(reading, run, None, columns),
        source=reading.asked.path,
    )


def _resolved_preparation(
    reading: _Reading,
    run: Run,
    window: tuple[float, float] | None,
    columns: Mapping[str, SignalColumn],
) -> Preparation:
    """What was really done, so that it can be done again."""
    layout, given = reading.layout, reading.preparation
    resolved = {signal: preparation_json(column) for signal, column in columns.items()}
    tree = preparation_json(given) | {"columns": resolved}
    if run.label is not None:
        tree["runs"] = [run.label]
    if not layout.static:
        if len(layout.times) == 1:
            # the times of several groups are found again as they were found
            (time,) = layout.times.values()
            tree["columns"]["time"] = preparation_json(time.prepared)
        elif "time" in given.columns:
            tree["columns"]["time"] = preparation_json(given.columns["time"])
        bounds = [run.span, given.window or run.span, window or run.span]
        lower = max(low for low, _ in bounds if np.isfinite(low))
        upper = min(high for _, high in bounds if np.isfinite(high))
        tree["window"] = [float(lower), float(upper)]
    return check_preparation(tree, reading.source)


def _nothing_in_common(name: str, tracks: Tracks) -> MeasurementError:
    spans = ", ".join(
        f"{signal} {track.time[0]:.15g} s to {track.time[-1]:.15g} s"
        for signal, track in tracks.items()
    )
    return MeasurementError(
        f"{name}: no stretch without gaps holds {MINIMUM_SAMPLES} samples of every signal "
        f"({spans}); check the clocks of the groups"
    )


def _run_notes(run: Run, reading: _Reading) -> tuple[str, ...]:
    notes = []
    if reading.layout.static:
        notes.append(
            "a static curve: the motor is held at 0 and the load follows the torque slowly, one "
            f"row every {STATIC_STEP:g} s"
        )
    if run.repeated:
        notes.append(f"{run.repeated} rows that repeat the row before were dropped")
    return tuple(notes)


def _offset_notes(layout: Layout, columns: Mapping[str, SignalColumn]) -> tuple[str, ...]:
    return tuple(
        f"{column.signal}: an offset of {column.prepared.offset - resolved.offset:.6g} was removed"
        for column in layout.signals
        if (resolved := columns[column.signal]) != column.prepared
    )


def _short_run_notes(labels: Sequence[Label], *, cut: bool) -> tuple[str, ...]:
    if not labels:
        return ()
    names = ", ".join(map(str, labels[:_MOST_NAMES]))
    more = ", ..." if len(labels) > _MOST_NAMES else ""
    window = " in the window" if cut else ""
    return (
        f"{len(labels)} runs with less than {MINIMUM_SAMPLES} samples{window} were left out: "
        f"{names}{more}",
    )


def _gap_notes(
    found: Sequence[Measurement], left_out: Sequence[Tracks], resample: float | None
) -> tuple[str, ...]:
    blanks = " or long blanks" if resample is not None else ""
    notes = [
        f"the recording has gaps{blanks} and was split into {len(found) + len(left_out)} pieces, "
        "each with an initial state of its own"
    ]
    if left_out:
        count = sum(max(len(track.time) for track in part.values()) for part in left_out)
        seconds = sum(_length(part) for part in left_out)
        notes.append(
            f"{len(left_out)} pieces with less than {MINIMUM_SAMPLES} samples of every signal were "
            f"left out, {count} samples over {seconds:.3g} s"
        )
    return tuple(notes)


def _length(part: Tracks) -> float:
    """From the first sample of any signal to the last, s."""
    clocks = [track.time for track in part.values() if len(track.time)]
    if not clocks:
        return 0.0
    return float(max(clock[-1] for clock in clocks) - min(clock[0] for clock in clocks))


def _clock_notes(part: Tracks, reference: str, resample: float | None) -> tuple[str, ...]:
    """What was averaged or interpolated, and whether the samples are uneven."""
    clock = part[reference].time
    if resample is not None:
        return (f"resampled to steps of {resample * 1e3:g} ms",)
    steps = np.diff(clock)
    uneven = bool(np.ptp(steps) > _EVEN * steps.min())
    # a median costs as much as reading the clock
    usual = float(np.median(steps) if uneven else steps.min())
    notes = []
    for signal, track in part.items():
        if track.time is not clock:
            own = float(np.median(np.diff(track.time)))
            verb = "averaged" if own < usual else "interpolated"
            notes.append(
                f"{signal}, sampled every {own * 1e3:.3g} ms, was {verb} to the samples of "
                f"{reference}, every {usual * 1e3:.3g} ms"
            )
    if uneven:
        notes.append(
            f"sampled unevenly, every {steps.min() * 1e3:.3g} ms to {steps.max() * 1e3:.3g} ms, "
            "and used as it stands"
        )
    return tuple(notes)
