"""What a user may ask of a search: which effects, how small, how long; and noise that is known."""

from collections.abc import Sequence
from dataclasses import replace
from math import isfinite
from typing import Annotated

import typer

import elastic_tendon as et
from elastic_tendon.cli.shared import notice

NoiseOption = Annotated[
    list[str] | None,
    typer.Option(
        "--noise",
        metavar="SIGNAL=SIGMA",
        help="Noise of a sensor that is known, one sigma, e.g. joint_position=0.2mrad; without a "
        "unit in rad or N m; repeatable.",
    ),
]
OnlyOption = Annotated[
    list[str] | None,
    typer.Option("--only", metavar="ID", help="Try this effect and no others; repeatable."),
]
WithoutOption = Annotated[
    list[str] | None,
    typer.Option("--without", metavar="ID", help="Never try this effect; repeatable."),
]
RelevanceOption = Annotated[
    str | None,
    typer.Option(
        "--relevance",
        metavar="SHARE",
        help="Share of the error as given, e.g. 10%, below which neither a change matters nor what "
        "is left. Without it changes matter from 5% on, and what is left from 1.5 times the noise.",
    ),
]
HorizonOption = Annotated[
    float | None,
    typer.Option(
        "--horizon",
        metavar="S",
        help="Simulate windows of so many s, each from its own initial state. Without it "
        "recordings are whole, unless the noise of its inputs makes the motor drift.",
    ),
]
TimeLimitOption = Annotated[
    float | None,
    typer.Option("--time-limit", metavar="S", help="Give the best answer found after so many s."),
]


def options_of(
    only: Sequence[str] | None,
    without: Sequence[str] | None,
    relevance: str | None,
    horizon: float | None,
    time_limit: float | None,
) -> "et.Options":
    """The options as they are given; numbers that mean nothing are wrong usage.

    Raises
    ------
    ModelError : an effect that the catalogue does not have
    """
    for seconds, option in ((horizon, "--horizon"), (time_limit, "--time-limit")):
        if seconds is not None and not (isfinite(seconds) and seconds > 0.0):
            raise typer.BadParameter("give a time in s, above 0", param_hint=option)
    options = et.Options(
        only=tuple(only or ()),
        without=tuple(without or ()),
        horizon=horizon,
        time_limit=time_limit,
    )
    options.check_ids()
    return options if relevance is None else replace(options, relevance=_share(relevance))


def repeated(
    noise: Sequence[str] | None,
    only: Sequence[str] | None,
    without: Sequence[str] | None,
    relevance: str | None,
    horizon: float | None,
) -> tuple[str, ...]:
    """The options again, as words of a command; a limit of time is of one call only."""
    lists = (("--noise", noise), ("--only", only), ("--without", without))
    words = [word for option, given in lists for value in given or () for word in (option, value)]
    if relevance is not None:
        words += ["--relevance", relevance]
    if horizon is not None:
        words += ["--horizon", f"{horizon:g}"]
    return tuple(words)


def _share(text: str) -> float:
    """A share, 0 to 1, of 0.05 or 5%."""
    number, percent, rest = text.partition("%")
    try:
        share = float(number) * (0.01 if percent else 1.0)
    except ValueError:
        share = float("nan")
    if rest.strip() or not 0.0 <= share < 1.0:
        fault = f"{text!r}: write a share from 0 to below 1, as 0.05 or 5%"
        raise typer.BadParameter(fault, param_hint="--relevance")
    return share


def with_noise(
    measurements: Sequence["et.Measurement"], sigmas: dict[str, float]
) -> list["et.Measurement"]:
    """Recordings with the noise that the user knows, of the signals that each has.

    Raises
    ------
    MeasurementError : no recording has one of the signals
    """
    measured = {name for measurement in measurements for name in measurement.signals}
    if missing := [name for name in sigmas if name not in measured]:
        raise et.MeasurementError(
            f"--noise {missing[0]}: no recording holds this signal; leave it out"
        )
    known = []
    for measurement in measurements:
        own = {name: sigma for name, sigma in sigmas.items() if name in measurement.signals}
        with_given = measurement.with_noise(own)
        for note in with_given.notes[len(measurement.notes) :]:
            notice.print(f"note: {with_given.name}: {note}", markup=False, soft_wrap=True)
        known.append(with_given)
    return known
