"""A fleet: the recordings of many robots, each diagnosed against one model.

A robot is one run of a sweep. Its files are read where the run is done, so on a cluster every
worker must see them under the same names.
"""

import hashlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pandas as pd

from elastic_tendon import effects
from elastic_tendon.actuator.motion_kind import MotionKind
from elastic_tendon.actuator.parameters import Model
from elastic_tendon.actuator.variables import SIGNALS as VARIABLES
from elastic_tendon.actuator.variables import interface
from elastic_tendon.comparison.simulated import SUFFIXES
from elastic_tendon.diagnosis.diagnose import diagnose
from elastic_tendon.diagnosis.result import Diagnosis
from elastic_tendon.errors import MeasurementError
from elastic_tendon.estimation.coordinates import free_parameters
from elastic_tendon.measurement import ReadOptions, read_prepared
from elastic_tendon.measurement.options import DEFAULT
from elastic_tendon.measurement.reader import split_window
from elastic_tendon.misreadings.belief import believed
from elastic_tendon.progress import silent
from elastic_tendon.sweeps.shipped import ShippedModel, ship
from elastic_tendon.sweeps.task import (
    APPEARED,
    DRIFTED,
    FAILURE,
    ROBOT,
    RUN,
    VERDICT,
    UnfitError,
)

LOW, HIGH = ".low", ".high"  # after the path of a parameter: ends of its 95 % interval
UNKNOWN = "unknown"  # what has appeared where no effect of the catalogue explains it
# that a recording may hold, and a model compute at some interface
SIGNALS = (
    *("joint_position", "joint_torque", "motor_torque", "motor_position"),
    *("upper_spring_force", "lower_spring_force"),
)
SUFFIXES_READ = (
    *(".csv", ".tsv", ".txt", ".dat", ".parquet", ".h5", ".hdf5"),
    *(".mat", ".mf4", ".mdf", ".mcap", ".db3"),
)
BAG = "metadata.yaml"  # of a folder that is one ROS 2 bag
DIGITS = 4  # of a number in words
PARTS, MOST_AT_ONCE = 1000, 20  # about, of a large fleet; robots in one of them
ABSENT = "absent"


@dataclass(frozen=True)
class Robot:
    """One robot: what it is called, and its recordings as `read_prepared` takes them."""

    name: str
    data: tuple[str, ...]


@dataclass(frozen=True, repr=False)
class Fleet:
    """Diagnoses as a task, see `elastic_tendon.sweeps.task`.

    A row holds, besides the run and its failure,

    * `robot`, and the diagnosis' `verdict`;
    * `drifted`: parameters of the model that moved significantly, by path, joined by "; ";
    * `appeared`: effects that are missing in the model, by id, joined by "; ", each with what these
      data do not tell it from: "coulomb_friction: indistinguishable from stribeck_friction";
    * for each of `SIGNALS` that the model computes its error with the model as given
      (`..._before`) and as improved (`..._after`): over the noise, and RMS in the signal's SI unit;
      NaN where not measured;
    * each free parameter of the model, and each of an effect that is not in it, by its dotted path,
      and `.low` and `.high`, its 95 % interval; NaN of an effect that did not appear.

    `options` : how all files are read. `digests` : SHA-256 of each robot's files.
    """

    model: ShippedModel
    robots: tuple[Robot, ...]
    options: ReadOptions
    digests: tuple[str, ...]

    def __repr__(self) -> str:
        return f"Fleet of {self.runs} robots, to be diagnosed against {self.model.model.name}"

    @property
    def runs(self) -> int:
        """One for each robot."""
        return len(self.robots)

    @property
    def identity(self) -> dict[str, str]:
        """Model, options of reading, names and files of the robots."""
        own = hashlib.sha256(b"".join(content for _, content in self.model.own_effects))
        robots = zip(self.robots, self.digests, strict=True)
        return {
            "kind": "fleet",
            "model": self.model.text,
            "effects": own.hexdigest(),
            "reading": repr(self.options),
            "robots": "\n".join(f"{robot.name} {digest}" for robot, digest in robots),
        }

    @property
    def threads(self) -> bool:
        """A diagnosis is mostly Python."""
        return False

    def batch(self) -> int:
        """A diagnosis takes seconds; of a large fleet some robots share a part."""
        return int(np.clip(self.runs // PARTS, 1, MOST_AT_ONCE))

    def rows(self, start: int, stop: int) -> pd.DataFrame:
        """Diagnoses of some robots.

        Raises
        ------
        UnfitError : this computer does not see the files as they were
        MeasurementError : a file cannot be used, or looks as if it was read wrongly
        SimulationError : the model cannot be simulated with the motion of a recording
        """
        return self._table([(run, self._diagnosed(run)) for run in range(start, stop)])

    def failed(self, run: int, reason: str) -> pd.DataFrame:
        """A robot that could not be diagnosed."""
        return self._table([(run, {FAILURE: reason})])

    def _table(self, rows_by_run: Sequence[tuple[int, Mapping[str, str | float]]]) -> pd.DataFrame:
        blank: dict[str, str | float] = dict.fromkeys((VERDICT, DRIFTED, APPEARED), "")
        blank |= dict.fromkeys(_numbers(self.model.model), np.nan)
        rows = [
            {RUN: run, ROBOT: self.robots[run].name, **blank, FAILURE: "", **row}
            for run, row in rows_by_run
        ]
        return pd.DataFrame(rows).astype({RUN: np.int64})

    def _diagnosed(self, run: int) -> dict[str, str | float]:
        model = self.model.model
        self._see(run)
        read = [
            measurement
            for data in self.robots[run].data
            for measurement in read_prepared(data, self.options)
        ]
        taken = believed(model, read, silent, as_declared=self.options.as_declared)
        diagnosis = diagnose(model, taken)
        if not diagnosis.complete:  # half a diagnosis is none
            raise KeyboardInterrupt
        return _summary(diagnosis)

    def _see(self, run: int) -> None:
        """Refuse files that are not those of the computer where the fleet was put together."""
        robot = self.robots[run]
        if _digest([*robot.data, *_files(self.options.mapping)]) != self.digests[run]:
            raise UnfitError(
                f"{robot.data[0]}: this computer sees no such recording of {robot.name}, or not "
                "the one that was there when the sweep was begun; let all see the same files"
            )


def fleet(
    model: Model, robots: Sequence[Robot | str | Path], options: ReadOptions = DEFAULT
) -> Fleet:
    """Prepare the diagnoses of many robots against one model.

    Parameters
    ----------
    model : Model of a robot that is as it should be; its uncertainties are the prior
    robots : the file or the folder of each, see `robots_of`
    options : how all files are read; what lies beside a file is taken as well

    Returns
    -------
    Fleet

    Raises
    ------
    MeasurementError : there are no robots, or two of one name
    """
    if not robots:
        raise MeasurementError("a fleet has no robots; name the recordings of at least one")
    chosen = [robot if isinstance(robot, Robot) else _robot(str(robot)) for robot in robots]
    _check_names(chosen)
    here = tuple(replace(robot, data=tuple(map(_absolute, robot.data))) for robot in chosen)
    items = tuple(_absolute(item) if Path(item).is_file() else item for item in options.mapping)
    return Fleet(
        # every effect of the user's own is a candidate
        model=ship(model, effects.BY_ID),
        robots=here,
        options=replace(options, mapping=items),
        digests=tuple(_digest([*robot.data, *_files(items)]) for robot in here),
    )


# ---- robots ------------------------------------------------------------------------------------


def robots_of(paths: Sequence[str]) -> tuple[Robot, ...]:
    """The robots that files and folders stand for.

    A file is a robot that is called as the file without its suffix; it may have a window,
    ``file.csv[1:5]``. A folder is a robot that is called as the folder, with all recordings in it,
    known by their suffix. A folder that is a ROS 2 bag counts as a file.

    Parameters
    ----------
    paths : of files and folders

    Returns
    -------
    tuple of Robot, in the order given

    Raises
    ------
    MeasurementError : nothing is there or in a folder, or two robots have one name
    """
    robots = tuple(map(_robot, paths))
    _check_names(robots)
    return robots


def _robot(data: str) -> Robot:
    if any(0xD800 <= ord(letter) < 0xE000 for letter in data):  # bytes that are no UTF-8
        raise MeasurementError(f"{data!a}: this name is no text; rename the file")
    path, window = split_window(data)
    if not path.is_dir():
        if not path.exists():
            raise MeasurementError(f"{path}: there is no such file or folder; check the name")
        return Robot(path.stem, (data,))
    name = path.resolve().name
    if _is_bag(path):
        return Robot(name, (data,))
    if window is not None:
        raise MeasurementError(f"{data}: a folder has no window; name the file and its window")
    recordings = sorted(str(file) for file in path.iterdir() if _is_recording(file))
    if not recordings:
        raise MeasurementError(
            f"{path}: no recordings are in this folder (none ends on {', '.join(SUFFIXES_READ)}); "
            "name the files, or a folder for each robot"
        )
    return Robot(name, tuple(recordings))


def _is_bag(path: Path) -> bool:
    return (path / BAG).is_file()


def _is_recording(path: Path) -> bool:
    hidden = path.name.startswith(".")
    return not hidden and (_is_bag(path) or path.suffix.lower() in SUFFIXES_READ)


def _check_names(robots: Sequence[Robot]) -> None:
    first: dict[str, Robot] = {}
    for robot in robots:
        earlier = first.setdefault(robot.name, robot)
        if earlier is not robot:
            raise MeasurementError(
                f"{earlier.data[0]} and {robot.data[0]}: two robots are called {robot.name}; "
                "rename a file, or put all recordings of a robot into one folder"
            )


def _absolute(data: str) -> str:
    """The same data for a worker that may stand in another folder."""
    path, window = split_window(data)
    return f"{path.absolute()}{data[data.rindex('[') :] if window else ''}"


def _files(mapping: Sequence[str]) -> list[str]:
    """Files among what says how to read; on a worker that does not see them, none of them."""
    return [item for item in mapping if Path(item).is_file()]


def _digest(data: Sequence[str]) -> str:
    """SHA-256 of all files that some data is read from, and of what is beside them."""
    digest = hashlib.sha256()
    for recording in data:
        path, _ = split_window(recording)
        beside = Path(f"{path}.toml")
        inside = sorted(path.rglob("*")) if path.is_dir() else [path]
        for file in (*inside, *([beside] if beside.is_file() else [])):
            digest.update(f"{recording} {file.name} {_content(file)}\n".encode())
    return digest.hexdigest()


def _content(file: Path) -> str:
    try:
        with file.open("rb") as stream:
            return hashlib.file_digest(stream, "sha256").hexdigest()
    except OSError:  # the run of this robot says why
        return ABSENT


# ---- what a row says ---------------------------------------------------------------------------


def error_columns(
    signal: str, motion: MotionKind = MotionKind.ROTARY
) -> dict[tuple[str, str], str]:
    """Columns of a signal's error: ("noise_ratio" or "rmse", "before" or "after") -> name."""
    unit = motion.unit(VARIABLES[signal].unit)
    suffixes = {"noise_ratio": "", "rmse": SUFFIXES[unit]}
    return {
        (kind, when): f"{signal}_{kind}_{when}{suffix}"
        for kind, suffix in suffixes.items()
        for when in ("before", "after")
    }


def measured_signals(robots: pd.DataFrame) -> list[str]:
    """Signals of `SIGNALS` that any robot of a table was compared by."""
    columns = {name: error_columns(name)["noise_ratio", "after"] for name in SIGNALS}
    return [
        name
        for name, column in columns.items()
        if column in robots and robots[column].notna().any()
    ]


def named(text: str) -> tuple[str, ...]:
    """Dotted paths in a text of `drifted`, or ids of effects in one of `appeared`."""
    return tuple(entry.partition(":")[0] for entry in text.split("; ") if entry)


def units_of(model: Model) -> dict[str, str]:
    """Unit of each number that a diagnosis may give, by dotted path; the same for all robots."""
    units = {quantity.path: quantity.unit for quantity in model.quantities()}
    known = {path: units[path] for path in free_parameters(model)}
    return known | {
        f"effects.{effect_id}.{parameter.name}": model.motion.unit(parameter.unit)
        for effect_id, effect in effects.BY_ID.items()
        if effect_id not in model.effect_ids
        for parameter in effect.parameters
    }


def _numbers(model: Model) -> Iterator[str]:
    """Columns of numbers; the same for all robots."""
    known = interface(*model.structure).output_names
    for signal in (name for name in SIGNALS if name in known):
        yield from error_columns(signal, model.motion).values()
    for path in units_of(model):
        yield from (path, path + LOW, path + HIGH)


def _summary(diagnosis: Diagnosis) -> dict[str, str | float]:
    estimates = {estimate.path: estimate for estimate in diagnosis.findings.estimates}
    row: dict[str, str | float] = {
        VERDICT: diagnosis.verdict,
        DRIFTED: "; ".join(diagnosis.parameters_changed),
        APPEARED: "; ".join(_appearances(diagnosis)),
    }
    ends = {"before": diagnosis.ladder[0], "after": diagnosis.ladder[-1]}
    for signal in ends["after"].rmse:
        for (kind, when), column in error_columns(signal, diagnosis.given.motion).items():
            step = ends[when]
            row[column] = (step.rmse if kind == "rmse" else step.noise_ratio)[signal]
    for effect_id in diagnosis.added:
        values = diagnosis.model.effects[effect_id]
        row |= {f"effects.{effect_id}.{name}": value for name, value in values.items()}
    for path in units_of(diagnosis.given).keys() & estimates.keys():
        estimate = estimates[path]
        low, high = estimate.interval
        row |= {path: estimate.fitted, path + LOW: low, path + HIGH: high}
    return row


def _appearances(diagnosis: Diagnosis) -> Iterator[str]:
    """Effects, and what would explain these data as well."""
    for effect_id in diagnosis.added:
        alike = sorted(_alike(diagnosis, effect_id))
        yield effect_id + (f": indistinguishable from {' and '.join(alike)}" if alike else "")
    if diagnosis.verdict == "unexplained":
        left = "what remains of the error" if diagnosis.added else "the error"
        text = f"{UNKNOWN}: no known effect explains {left}"
        if diagnosis.learned is not None:
            text += f", which depends on {', '.join(diagnosis.learned.variables)}"
        yield text


def _alike(diagnosis: Diagnosis, effect_id: str) -> set[str]:
    """Sets of effects that explain the data as well as the one with an effect that was added."""
    alike = set()
    for group in diagnosis.indistinguishable:
        own = {answer for answer in group if effect_id in answer.split("+")}
        alike |= set(group) - own if own else set()
    return alike


def number(value: float, digits: int = DIGITS) -> str:
    """Some digits without an exponent."""
    return np.format_float_positional(
        value, precision=digits, unique=False, fractional=False, trim="-"
    )
