"""How signals are called and scaled for people; errors of an angle read best in mrad."""

from dataclasses import dataclass
from math import floor, isfinite, isnan, log10

from elastic_tendon.actuator.quantity import unit_text
from elastic_tendon.actuator.variables import SIGNALS
from elastic_tendon.measurement import NoiseFloor


@dataclass(frozen=True)
class Shown:
    """A signal for people: `words`, its `unit`, and a `small_unit` for errors, with the factor
    `small` from the SI unit to it.
    """

    words: str
    unit: str
    small: float
    small_unit: str

    def error(self, value: float) -> str:
        """An error of the signal (SI unit) with its small unit."""
        return f"{number(self.small * value)} {self.small_unit}"


_SMALL = {"rad": (1e3, "mrad"), "rad/s": (1e3, "mrad/s"), "N.m": (1e3, "mN·m")}
# what an error is held against, beside the outputs of the model
_OTHERS = {
    "joint_acceleration": "rad/s²",
    "motor_position": "rad",
    "motor_velocity": "rad/s",
    "motor_acceleration": "rad/s²",
    "load_torque": "N·m",
    "time": "s",
    "frequency": "Hz",
}
# below this share of the noise an error is said to be no larger than that share
SMALL_RATIO = 0.1


def shown(signal: str, *, static: bool = False) -> Shown:
    """How to show an output of the model.

    Parameters
    ----------
    signal : name of the output
    static : of a static curve, whose motor stands still: the joint's position is its deflection

    Returns
    -------
    Shown
    """
    unit = SIGNALS[signal].unit
    small, small_unit = _SMALL.get(unit, (1.0, unit))
    words = "deflection" if static and signal == "joint_position" else signal.replace("_", " ")
    return Shown(words, unit_text(unit), small, small_unit)


def with_unit(variable: str) -> str:
    """Name of an output or of what an error is held against, with its unit; for an axis."""
    units = {name: unit_text(known.unit) for name, known in SIGNALS.items()} | _OTHERS
    return f"{variable.replace('_', ' ')} ({units[variable]})"


def number(value: float) -> str:
    """Three digits that count, without an exponent where the number is of everyday size."""
    if value != 0.0 and 3 <= floor(log10(abs(value))) < 7:
        return f"{value:.0f}"
    return f"{value:#.3g}".rstrip(".")


def evidence_text(evidence: float | None) -> str:
    """A difference of evidence; its fractions say nothing. "-" where it is not known."""
    if evidence is None or isnan(evidence):
        return "-"
    return f"{evidence:.0f}" if isfinite(evidence) else "∞"


def noise_ratio(ratio: float) -> str:
    """Error over noise floor; without noise, digits below a tenth would mean nothing."""
    return f"<{SMALL_RATIO:g}" if ratio < SMALL_RATIO else number(ratio)


def times_noise(ratio: float) -> str:
    """How an error compares with the noise floor, in words; `ratio` is error over noise."""
    words = noise_ratio(ratio).replace("<", "less than ")
    return f"{words} times the noise"


def noise_in_words(noise: NoiseFloor, quantity: Shown) -> str:
    """Size and kind of a noise floor, as "0.2 mrad, white, from high frequencies"."""
    return f"{quantity.error(noise.sigma)}, {noise.kind}, from {noise.method}"
