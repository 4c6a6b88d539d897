"""How commands read recordings: the options, and what is asked before data is believed."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite
from os.path import isfile
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from elastic_tendon.cli.shared import notice
from elastic_tendon.errors import MeasurementError
from elastic_tendon.simulation.interpolation import Interpolation

if TYPE_CHECKING:
    from elastic_tendon.actuator.parameters import Model
    from elastic_tendon.measurement import Measurement
    from elastic_tendon.measurement.formats.base import Report

DataArgument = Annotated[
    list[str], typer.Argument(metavar="DATA...", help="file.csv, or file.csv\\[start:end] in s.")
]
ValidateOption = Annotated[
    list[str] | None,
    typer.Option("--validate", metavar="DATA", help="Never fitted, only judges; repeatable."),
]
MapOption = Annotated[
    list[str] | None,
    typer.Option(
        "--map",
        metavar="SIGNAL=COLUMN",
        help="signal=column, then \\[:unit]\\[*scale]\\[+offset], e.g. joint_position=enc2:deg*-1; "
        "or a TOML file that says how to read, or the JSON of an earlier comparison; repeatable.",
    ),
]
ResampleOption = Annotated[
    float | None,
    typer.Option("--resample", metavar="S", help="Bring the samples to steps of so many s."),
]
ShiftOption = Annotated[
    list[str] | None,
    typer.Option(
        "--shift",
        metavar="SIGNAL=S",
        help="By how many s a sensor is late; auto estimates it, if the model is right: friction "
        "looks alike; repeatable.",
    ),
]
RemoveOffsetOption = Annotated[
    list[str] | None,
    typer.Option(
        "--remove-offset",
        metavar="SIGNAL",
        help="Make the mean of its first 0.1 s zero; repeatable.",
    ),
]
AsDeclaredOption = Annotated[
    bool,
    typer.Option("--as-declared", help="Take data as they are, even if they look read wrongly."),
]
InterpolationOption = Annotated[
    Interpolation,
    typer.Option(
        help="Of motor position and load between the samples; cubic suits smooth inputs that are "
        "sampled slowly."
    ),
]


@dataclass(frozen=True)
class Reading:
    """The options of a command about reading."""

    mapping: tuple[str, ...]
    resample: float | None
    time_shift: dict[str, float | Literal["auto"]]
    remove_offset: tuple[str, ...]
    as_declared: bool
    interpolation: Interpolation

    @classmethod
    def from_options(
        cls,
        mapping: Sequence[str] | None,
        resample: float | None,
        shift: Sequence[str] | None,
        remove_offset: Sequence[str] | None,
        as_declared: bool,
        interpolation: Interpolation,
    ) -> "Reading":
        """The options as they are given; what no file could be read with is wrong usage."""
        from elastic_tendon.measurement.preparation import DIMENSIONS

        _check_mapping(mapping or ())
        if resample is not None and not (isfinite(resample) and resample > 0.0):
            raise typer.BadParameter("give a step in s, above 0", param_hint="--resample")
        for signal in remove_offset or ():
            _check_signal(signal, [one for one in DIMENSIONS if one != "time"], "--remove-offset")
        shifts = [_shift(one) for one in shift or ()]
        if len(dict(shifts)) < len(shifts):
            raise typer.BadParameter("a signal is shifted twice", param_hint="--shift")
        return cls(
            mapping=tuple(mapping or ()),
            resample=resample,
            time_shift=dict(shifts),
            remove_offset=tuple(remove_offset or ()),
            as_declared=as_declared,
            interpolation=interpolation,
        )

    def options(self) -> tuple[str, ...]:
        """The options again, as words of a command; those that are left out are defaults."""
        words = [word for one in self.mapping for word in ("--map", one)]
        if self.resample is not None:
            words += ["--resample", f"{self.resample:g}"]
        for signal, seconds in self.time_shift.items():
            words += ["--shift", f"{signal}={seconds}"]
        words += [word for one in self.remove_offset for word in ("--remove-offset", one)]
        if self.as_declared:
            words.append("--as-declared")
        if self.interpolation != "linear":
            words += ["--interpolation", self.interpolation]
        return tuple(words)

    def all(
        self, model: "Model", data: Sequence[str], report: "Report", *, joint_required: bool = True
    ) -> list["Measurement"]:
        """Read every file; look whether it was read rightly; say what was done to it.

        Raises
        ------
        MeasurementError : a file cannot be used, or looks as if it was read wrongly
        """
        from elastic_tendon.measurement.reader import read_prepared
        from elastic_tendon.misreadings.belief import believed

        read = [
            measurement
            for one in data
            for measurement in read_prepared(
                *(one, self.mapping),
                time_shift=self.time_shift,
                resample=self.resample,
                remove_offset=self.remove_offset,
                interpolation=self.interpolation,
                joint_required=joint_required,
                report=report,
            )
        ]
        taken = believed(model, read, report, as_declared=self.as_declared)
        for before, after in zip(read, taken, strict=True):
            _tell("note", after.name, before.notes)
            _tell("warning", after.name, after.notes[len(before.notes) :])
        return taken

    def one(self, model: "Model", data: str, report: "Report") -> "Measurement":
        """Read a file that holds one recording, which need not hold the joint's position.

        Raises
        ------
        MeasurementError : see `all`, or the file holds several recordings
        """
        found = self.all(model, [data], report, joint_required=False)
        if len(found) > 1:
            names = ", ".join(one.name for one in found)
            raise MeasurementError(
                f"{data}: it holds {len(found)} recordings ({names}); cut one out with a window "
                "file.csv[start:end], or with runs in a file for --map"
            )
        return found[0]


def _tell(kind: str, name: str, notes: Sequence[str]) -> None:
    for note in notes:
        notice.print(f"{kind}: {name}: {note}", markup=False, soft_wrap=True)


def _check_mapping(items: Sequence[str]) -> None:
    """Refuse items of --map that no file could be read with, as wrong usage."""
    from elastic_tendon.measurement.preparation import parse_map

    try:
        parsed = [parse_map(item) for item in items if "=" in item and not isfile(item)]
    except MeasurementError as error:
        fault = str(error).removeprefix("--map ")
        raise typer.BadParameter(fault, param_hint="--map") from None
    if len(dict(parsed)) < len(parsed):
        raise typer.BadParameter("a signal is mapped twice", param_hint="--map")


def _check_signal(signal: str, known: Sequence[str], option: str) -> None:
    if signal not in known:
        raise typer.BadParameter(f"{signal!r} is none of {', '.join(known)}", param_hint=option)


def _shift(text: str) -> tuple[str, float | Literal["auto"]]:
    from elastic_tendon.measurement.preparation import SHIFTED

    signal, _, value = text.partition("=")
    _check_signal(signal, SHIFTED, "--shift")
    if value == "auto":
        return signal, "auto"
    try:
        seconds = float(value)
    except ValueError:
        seconds = float("nan")
    if not isfinite(seconds):
        advice = f"{text!r}: write it as signal=seconds or signal=auto, as joint_position=0.003"
        raise typer.BadParameter(advice, param_hint="--shift")
    return signal, seconds
