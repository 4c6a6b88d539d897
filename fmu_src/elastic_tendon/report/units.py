"""How signals are called and scaled for people; errors of an angle read best in mrad."""

from dataclasses import dataclass

from elastic_tendon.variables import OUTPUTS


@dataclass(frozen=True)
class Shown:
    """A signal for people: `words`, its `unit`, and a `small_unit` for errors, with the factor
    `small` from the SI unit to it.
    """

    words: str
    unit: str
    small: float
    small_unit: str


_SMALL = {"rad": (1e3, "mrad"), "rad/s": (1e3, "mrad/s"), "N.m": (1e3, "mN·m")}


def shown(signal: str) -> Shown:
    """How to show an output of the model.

    Parameters
    ----------
    signal : name of the output

    Returns
    -------
    Shown
    """
    unit = {output.name: output.unit for output in OUTPUTS}[signal]
    small, small_unit = _SMALL.get(unit, (1.0, unit))
    return Shown(signal.replace("_", " "), unit.replace(".", "·"), small, small_unit)
