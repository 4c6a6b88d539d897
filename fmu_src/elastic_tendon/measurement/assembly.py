"""From the runs of a file to measurements: units, clocks and gaps, and notes of what was done."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastic_tendon.errors import MeasurementError
from elastic_tendon.measurement.columns import Column, Layout
from elastic_tendon.measurement.noise import is_even
from elastic_tendon.measurement.outliers import without_spikes, without_standing
from elastic_tendon.measurement.preparation import (
    Preparation,
    SignalColumn,
    check_preparation,
    preparation_json,
)
from elastic_tendon.measurement.recording import (
    MINIMUM_SAMPLES,
    Measurement,
    samples_text,
    window_text,
)
from elastic_tendon.measurement.rows import MAXIMUM_SAMPLES, Label, Run
from elastic_tendon.measurement.tracks import (
    Array,
    Track,
    Tracks,
    common_time,
    evenly,
    on_one_clock,
    pieces,
)
from elastic_tendon.native.interpolation import AskedInterpolation

# s between the samples of a static curve: the sweep is slow against every motion of a joint
STATIC_STEP = 1000.0

# s at the beginning that "start" takes for rest
_BEGINNING = 0.1
# share of its range by which a signal that rests may move
_REST = 0.05
# an evenly sampled recording has steps that differ by less than this share
_EVEN = 0.1
# of its own step, below which a step is finer than a signal was sampled; it may have blanks
_FINER = 0.8
# whose samples the others are brought to: the first that there is
_CLOCKS = ("joint_position", "joint_deflection", "motor_position", "load_torque")
_MOST_NAMES = 6  # runs that a sentence names


@dataclass(frozen=True)
class Asked:
    """What the user wrote, ``path[start:end]``, and the window in it."""

    path: str
    data: str
    window: tuple[float, float] | None

    def suffix(self, preparation: Preparation) -> str:
        """The window as the user wrote it, "" where another is read."""
        asked = self.window is not None and preparation.window == self.window
        return self.data.removeprefix(self.path) if asked else ""


@dataclass(frozen=True)
class Reading:
    """How a file is read."""

    source: str
    asked: Asked
    layout: Layout
    preparation: Preparation
    interpolation: AskedInterpolation

    def name(self, run: Run) -> str:
        """Name of the file, with the run where it has some."""
        return self.source + (f"#{run.label}" if run.label is not None else "")


def assemble(reading: Reading, runs: Sequence[Run]) -> list[Measurement]:
    """Make measurements of the runs of a file.

    Parameters
    ----------
    reading : how the file is read
    runs : at least one, from `rows.read_runs`

    Returns
    -------
    list of Measurement, at least one: for each run, and for each piece between gaps

    Raises
    ------
    MeasurementError : nothing is long enough, the signals share no time, or a step is too short
    """
    layout = reading.layout
    short = [run for run in runs if _count(run, layout) < MINIMUM_SAMPLES]
    if len(short) == len(runs):
        raise _too_short(runs[0], reading)
    notes = _short_run_notes([run.label for run in short], cut=any(run.cut for run in short))
    return [
        measurement.noted(notes)
        for run in runs
        if _count(run, layout) >= MINIMUM_SAMPLES
        for measurement in _measurements(reading, run)
    ]


def check_static(preparation: Preparation, layout: Layout, source: str) -> None:
    """Refuse what needs a time, where the file holds a static curve.

    Raises
    ------
    MeasurementError : a window, a shift or another time is asked for
    """
    if not layout.static:
        return
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


def _measurements(reading: Reading, run: Run) -> list[Measurement]:
    """Measurements of one run: one, or several where it has gaps."""
    name = reading.name(run)
    columns = {
        column.signal: _resolved(column, run.tracks[column.signal])
        for column in reading.layout.signals
    }
    tracks = {
        column.signal: run.tracks[column.signal].converted(
            column.factor, columns[column.signal].offset
        )
        for column in reading.layout.signals
    }
    notes = (*_run_notes(run, reading), *_offset_notes(reading.layout, columns, tracks))
    if reading.layout.static:
        return [_static_measurement(reading, run, name, tracks, columns, notes)]
    measurements, left_out = [], []
    whole, lost, lost_notes = without_standing(tracks)
    notes += lost_notes
    parts = pieces(whole, reading.preparation.resample, lost)
    for part, window in parts:
        measurement = _of_piece(reading, run, name, part, window, columns)
        if measurement is None:
            left_out.append(part)
        else:
            measurements.append(measurement)
    if not measurements:
        raise _nothing_in_common(name, tracks)
    if len(parts) > 1:
        notes += _gap_notes(measurements, left_out, reading.preparation.resample)
    recording = name + reading.asked.suffix(reading.preparation) if len(parts) > 1 else ""
    return [
        replace(measurement, whole=recording, notes=(*measurement.notes, *notes))
        for measurement in measurements
    ]


def _count(run: Run, layout: Layout) -> int:
    """Samples of the signal that has the fewest."""
    if len(run.tracks) < len(layout.signals):
        return 0
    return min(len(track.time) for track in run.tracks.values())


def _too_short(run: Run, reading: Reading) -> MeasurementError:
    """Say why a run of less than ten samples cannot be used."""
    name = reading.name(run) + reading.asked.suffix(reading.preparation)
    count = _count(run, reading.layout)
    held = {signal for signal, track in run.tracks.items() if len(track.time)}
    empty = [column.label for column in reading.layout.signals if column.signal not in held]
    if held and empty:
        return MeasurementError(
            f"{name}: column {empty[0]} holds no number; fill it, or choose another column"
        )
    if run.cut:
        return MeasurementError(
            f"{name}: the window holds {samples_text(count)} and needs {MINIMUM_SAMPLES}; the "
            f"recording runs from {run.span[0]:.15g} s to {run.span[1]:.15g} s"
        )
    step = reading.preparation.resample
    after = "" if step is None else f" after resampling to {step:g} s"
    left = samples_text(count) if count else "no samples"
    return MeasurementError(f"{name}: it holds {left}{after} and needs at least {MINIMUM_SAMPLES}")


def _resolved(column: Column, track: Track) -> SignalColumn:
    """The column with the offset that is really added."""
    prepared = column.prepared
    if prepared.remove_offset is None:
        return prepared
    values = track.values
    if prepared.remove_offset == "start":
        values = values[_at_start(track)]
    removed = float(np.mean(values * column.factor))
    return prepared.model_copy(update={"offset": prepared.offset - removed, "remove_offset": None})


def _of_piece(
    reading: Reading,
    run: Run,
    name: str,
    part: Tracks,
    window: tuple[float, float] | None,
    columns: Mapping[str, SignalColumn],
) -> Measurement | None:
    """Measurement of one piece, None where fewer than ten samples are in common."""
    first, last = common_time(part)
    reference = next(name for name in _CLOCKS if name in part)
    if not first < last or len(part[reference].time) < MINIMUM_SAMPLES:
        return None
    step = reading.preparation.resample
    if step is not None and last - first > step * MAXIMUM_SAMPLES:
        raise MeasurementError(
            f"{name}: resampled to {step:g} s it has more than {MAXIMUM_SAMPLES} samples; choose a "
            "longer step"
        )
    if step is not None:
        _check_not_finer(part[reference], reference, step, name)
    part, spike_notes = without_spikes(part)
    time, values = on_one_clock(part, reference, step)
    if len(time) < MINIMUM_SAMPLES:
        return None
    if step is None:
        time = evenly(time)
    shown = window_text(time[0], time[-1]) if run.cut or window is not None else ""
    preparation = _resolved_preparation(reading, run, window, columns)
    given_shifts = preparation.time_shift
    shifts = {signal: shift for signal, shift in given_shifts.items() if shift != "auto"}
    waiting = {signal: shift for signal, shift in given_shifts.items() if shift == "auto"}
    motor_position: Any = values.pop("motor_position", None)
    measurement = Measurement(
        name=name + ((window is None and reading.asked.suffix(reading.preparation)) or shown),
        time=time,
        motor_position=motor_position,
        load_torque=values.pop("load_torque", None),
        signals=values,
        interpolation=reading.interpolation,
        notes=(
            *reading.layout.notes,
            *_clock_notes(part, reference, step, time),
            *spike_notes,
        ),
        preparation=preparation.model_copy(update={"time_shift": waiting}),
        source=reading.asked.path,
        motion=reading.layout.motion,
    )
    return measurement.shifted(shifts)


def _check_not_finer(track: Track, signal: str, step: float, name: str) -> None:
    """Refuse samples between the samples: they would have less noise than was measured."""
    # the mean, because averages over steps lie unevenly
    own = float(track.time[-1] - track.time[0]) / (len(track.time) - 1)
    if step < _FINER * own:
        raise MeasurementError(
            f"{name}: {signal} was sampled every {own:.4g} s, and steps of {step:g} s would need "
            f"samples in between; give --resample {own:.4g} or more"
        )


def _static_measurement(
    reading: Reading,
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
        motion=reading.layout.motion,
    )


def _resolved_preparation(
    reading: Reading,
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


def _run_notes(run: Run, reading: Reading) -> tuple[str, ...]:
    notes = []
    if reading.layout.static:
        notes.append(
            "a static curve: the motor is held at 0 and the load follows the torque slowly, one "
            f"row every {STATIC_STEP:g} s"
        )
    if run.repeated:
        notes.append(f"{run.repeated} rows that repeat the row before were dropped")
    return tuple(notes)


def _offset_notes(
    layout: Layout, columns: Mapping[str, SignalColumn], tracks: Tracks
) -> tuple[str, ...]:
    notes = []
    for column in layout.signals:
        given, resolved = column.prepared, columns[column.signal]
        if resolved == given:
            continue
        note = f"{column.signal}: an offset of {given.offset - resolved.offset:.6g} was removed"
        track = tracks[column.signal]
        travel = float(np.ptp(track.values[_at_start(track)]))
        if given.remove_offset == "start" and travel > _REST * float(np.ptp(track.values)):
            note += f", though it moves by {travel:.3g} in the first {_BEGINNING:g} s"
        notes.append(note)
    return tuple(notes)


def _at_start(track: Track) -> NDArray[np.bool_]:
    return np.asarray(track.time <= track.time[0] + _BEGINNING)


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
    measurements: Sequence[Measurement], left_out: Sequence[Tracks], resample: float | None
) -> tuple[str, ...]:
    blanks = " or long blanks" if resample is not None else ""
    notes = [
        f"the recording has gaps{blanks} and was split into {len(measurements) + len(left_out)} "
        "pieces, each with an initial state of its own"
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


def _clock_notes(
    part: Tracks, reference: str, resample: float | None, time: Array
) -> tuple[str, ...]:
    """What was averaged or interpolated, and whether samples are uneven; `time` as it is used."""
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
        between = f"every {steps.min() * 1e3:.3g} ms to {steps.max() * 1e3:.3g} ms"
        used = "and used as it stands"
        if is_even(time):
            used = f"as its time stamps are rounded; taken as every {np.diff(time)[0] * 1e3:.4g} ms"
        notes.append(f"sampled unevenly, {between}, {used}")
    return tuple(notes)
