"""Noise in words: what a user gives, and what is said of where it comes from."""

import re
from collections.abc import Mapping

from elastic_tendon.errors import MeasurementError
from elastic_tendon.measurement.noise import NoiseFloor
from elastic_tendon.measurement.preparation import DIMENSIONS
from elastic_tendon.measurement.units import factor_of

# what is compared with a model, and so has a noise floor
COMPARED = (
    *("joint_position", "joint_torque", "motor_torque"),
    *("upper_spring_force", "lower_spring_force"),
)
# what is measured in place of another signal and compared as that, without other errors
COMPARED_AS = {"joint_deflection": "joint_position"}
APART = 2.0  # figures of one noise that differ by more disagree

_GIVEN = re.compile(
    r"\s*(?P<signal>\w+)\s*=\s*(?P<size>[+-]?[0-9]*\.?[0-9]+(?:[eE][+-]?[0-9]+)?)\s*(?P<unit>.*?)\s*"
)
# as people write it; `USUAL` has what a column's name may hold
_WRITTEN = {"angle": "rad", "torque": "N·m", "force": "N"}


def parse_size(text: str, kind: str = "noise") -> tuple[str, float]:
    """Read the size that a user gives of one signal's noise or tolerance.

    Parameters
    ----------
    text : str, ``joint_position=0.2mrad``; without a unit it is in rad or N·m
    kind : what it is the size of, for messages

    Returns
    -------
    signal : str, one of `COMPARED`; that of a deflection is that of the joint position
    size : float > 0, rad or N·m

    Raises
    ------
    MeasurementError : no such signal, a unit that does not fit it, or not positive
    """
    match = _GIVEN.fullmatch(text)
    if match is None:
        raise MeasurementError(
            f"{kind} {text!r}: write SIGNAL=SIZE, such as joint_position=0.2mrad"
        )
    signal = COMPARED_AS.get(match["signal"], match["signal"])
    if signal not in COMPARED:
        raise MeasurementError(
            f"{kind} {text!r}: {signal} is not compared with a model; give that of "
            f"{', '.join(COMPARED[:-1])} or {COMPARED[-1]}"
        )
    size = float(match["size"]) * factor_of(
        match["unit"], DIMENSIONS[signal], signal, f"{kind} {text!r}"
    )
    check_size(size, f"{kind} {text!r}")
    return signal, size


def check_size(size: float, called: str) -> None:
    """Refuse a size that is none, with a sentence that begins as `called`.

    Raises
    ------
    MeasurementError : not positive, or not finite
    """
    if not 0.0 < size < float("inf"):
        raise MeasurementError(f"{called}: it has to be positive and finite, not {size:g}")


def _size(sigma: float, signal: str) -> str:
    """A standard deviation with its unit."""
    unit = _WRITTEN.get(DIMENSIONS.get(signal, ""), "")
    return f"{sigma:.2g} {unit}".rstrip()


def _differ(sigma: float, reference: float) -> bool:
    return not 1.0 / APART <= sigma / reference <= APART


def floor_notes(floors: Mapping[str, NoiseFloor]) -> tuple[str, ...]:
    """What a reader should know of noise floors.

    Parameters
    ----------
    floors : name of a signal -> NoiseFloor

    Returns
    -------
    tuple of sentences, one for each signal whose noise is known badly, or was given otherwise than
    the recording itself tells
    """
    notes = (_floor_note(signal, floor) for signal, floor in floors.items())
    return tuple(note for note in notes if note)


def _floor_note(signal: str, floor: NoiseFloor) -> str:
    if floor.source == "given":
        return given_note(signal, floor.sigma, floor, 0.0)
    if floor.is_least:
        return (
            f"{signal} looks filtered, as its spectrum falls steeply at {floor.falls_above:.3g} "
            f"Hz: its noise is {_size(floor.sigma, signal)} at least and may be far larger, so "
            "give it if it is known"
        )
    if floor.source != "periods" or floor.spectrum is None or floor.falls_above is not None:
        return ""
    if not _differ(floor.sigma, floor.spectrum):
        return ""
    high = _size(floor.spectrum, signal)
    return (
        f"{signal} differs from period to period by {_size(floor.sigma, signal)}, but its high "
        f"frequencies show {high} of noise; the periods count"
    )


def given_note(signal: str, given: float, own: NoiseFloor, rounding: float) -> str:
    """What speaks against a noise that was given; "" where nothing does.

    Parameters
    ----------
    signal : str
    given : float > 0, the signal's unit
    own : NoiseFloor of the recording itself
    rounding : float >= 0, the signal's unit; what rounding to the sensor's steps adds at least
    """
    if given < rounding:
        return (
            f"the noise of {signal} was given as {_size(given, signal)}, but its steps alone make "
            f"{_size(rounding, signal)}, which is taken"
        )
    spectrum = own.sigma if own.spectrum is None else own.spectrum
    # a filtered signal shows the least of its noise, which a larger one does not contradict
    limit_only = own.falls_above is not None
    if given > spectrum if limit_only else not _differ(given, spectrum):
        return ""
    least = "at least " if limit_only else ""
    return (
        f"the noise of {signal} was given as {_size(given, signal)}, but its high frequencies show "
        f"{least}{_size(spectrum, signal)}; what was given is taken"
    )
