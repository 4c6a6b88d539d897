"""How commands read recordings: the options, and what is asked before data is believed."""

import functools
import inspect
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Annotated, Any, Literal

import typer

import elastic_tendon as et
from elastic_tendon.cli.shared import notice
from elastic_tendon.native.interpolation import AskedInterpolation
from elastic_tendon.progress import Progress

DataArgument = Annotated[
    list[str], typer.Argument(metavar="DATA...", help="file.csv, or file.csv\\[start:end] in s.")
]
ValidateOption = Annotated[
    list[str] | None,
    typer.Option("--validate", metavar="DATA", help="Held out, never fitted; repeatable."),
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
    AskedInterpolation,
    typer.Option(
        help="Of motor position and load between the samples; auto takes cubic for smooth inputs, "
        "linear for those that step or are noisy."
    ),
]


# option of `ReadOptions` -> its name on the command line
_NAMES = {
    "mapping": "--map",
    "time_shift": "--shift",
    "resample": "--resample",
    "remove_offset": "--remove-offset",
}


def read_options(
    mapping: MapOption = None,
    resample: ResampleOption = None,
    shift: ShiftOption = None,
    remove_offset: RemoveOffsetOption = None,
    as_declared: AsDeclaredOption = False,
    interpolation: InterpolationOption = "auto",
) -> "et.ReadOptions":
    """The options as they are given; what no file could be read with is wrong usage."""
    from elastic_tendon.measurement.options import ReadOptionError

    shifts = [_shift(text) for text in shift or ()]
    if len(dict(shifts)) < len(shifts):
        raise typer.BadParameter("a signal is shifted twice", param_hint="--shift")
    try:
        return et.ReadOptions(
            mapping=tuple(mapping or ()),
            time_shift=dict(shifts),
            resample=resample,
            remove_offset=tuple(remove_offset or ()),
            interpolation=interpolation,
            as_declared=as_declared,
        )
    except ReadOptionError as error:
        raise typer.BadParameter(error.fault, param_hint=_NAMES[error.option]) from None


def reading(command: Callable[..., None]) -> Callable[..., None]:
    """Give a command the options of `read_options`, in place of its parameter `options`."""
    own = inspect.signature(read_options).parameters
    shown = [
        parameter
        for given in inspect.signature(command).parameters.values()
        for parameter in (own.values() if given.name == "options" else [given])
    ]

    @functools.wraps(command)
    def run(**given: Any) -> None:
        options = read_options(**{name: given.pop(name) for name in own})
        command(options=options, **given)

    run.__signature__ = inspect.Signature(shown)  # type: ignore[attr-defined]  # Typer reads it
    run.__annotations__ = {parameter.name: parameter.annotation for parameter in shown}
    return run


def sizes_by_signal(kind: str, given: Sequence[str] | None) -> dict[str, float]:
    """What an option gives by signal, rad or N·m; what cannot be read is wrong usage."""
    from elastic_tendon.measurement import parse_size

    try:
        parsed = [parse_size(text, kind) for text in given or ()]
    except et.MeasurementError as error:
        raise typer.BadParameter(str(error), param_hint=f"--{kind}") from None
    if len(dict(parsed)) < len(parsed):
        raise typer.BadParameter(f"a signal has its {kind} twice", param_hint=f"--{kind}")
    return dict(parsed)


def check_conditions(where: Sequence[str]) -> None:
    """Refuse conditions of --where that cannot be read, which is wrong usage."""
    from elastic_tendon.comparison.conditions import parse_condition

    try:
        for text in where:
            parse_condition(text)
    except et.MeasurementError as error:
        raise typer.BadParameter(str(error), param_hint="--where") from None


def words(options: "et.ReadOptions") -> tuple[str, ...]:
    """The options again, as words of a command; those that are left out are defaults."""
    words = [word for item in options.mapping for word in ("--map", item)]
    if options.resample is not None:
        words += ["--resample", f"{options.resample:g}"]
    for signal, seconds in options.time_shift.items():
        words += ["--shift", f"{signal}={seconds}"]
    words += [word for signal in options.remove_offset for word in ("--remove-offset", signal)]
    if options.as_declared:
        words.append("--as-declared")
    if options.interpolation != "auto":
        words += ["--interpolation", options.interpolation]
    return tuple(words)


def read_all(
    model: "et.Model", data: Sequence[str], options: "et.ReadOptions", progress: "Progress"
) -> list["et.Measurement"]:
    """Read every file; check whether it was read rightly; say what was done to it.

    Raises
    ------
    MeasurementError : files cannot be used, all of which are named, or one looks as if it was read
        wrongly
    """
    from elastic_tendon.measurement.reader import read_prepared
    from elastic_tendon.misreadings.belief import believed

    read, refused = list[et.Measurement](), list[str]()
    for name in data:
        try:
            read += read_prepared(name, options, progress)
        except et.MeasurementError as error:
            refused.append(str(error))
    if refused:
        raise et.MeasurementError("; ".join(refused))
    taken = believed(model, read, progress, as_declared=options.as_declared)
    for before, after in zip(read, taken, strict=True):
        _tell("note", after.name, before.notes)
        _tell("warning", after.name, after.notes[len(before.notes) :])
    return taken


def read_motion(
    model: "et.Model", data: str, options: "et.ReadOptions", progress: "Progress"
) -> "et.Measurement":
    """Read a file that holds one recording, which need not hold the joint's position.

    Raises
    ------
    MeasurementError : see `read_all`, or the file holds several recordings
    """
    measurements = read_all(model, [data], replace(options, joint_required=False), progress)
    if len(measurements) > 1:
        names = ", ".join(measurement.name for measurement in measurements)
        raise et.MeasurementError(
            f"{data}: it holds {len(measurements)} recordings ({names}); cut one out with a window "
            "file.csv[start:end], or with runs in a file for --map"
        )
    return measurements[0]


def _tell(kind: str, name: str, notes: Sequence[str]) -> None:
    for note in notes:
        notice.print(f"{kind}: {name}: {note}", markup=False, soft_wrap=True)


def _shift(text: str) -> tuple[str, float | Literal["auto"]]:
    signal, _, value = text.partition("=")
    if value == "auto":
        return signal, "auto"
    try:
        return signal, float(value)
    except ValueError:
        advice = f"{text!r}: write it as signal=seconds or signal=auto, as joint_position=0.003"
        raise typer.BadParameter(advice, param_hint="--shift") from None
