"""Whether a machine turns or slides: its equations are the same, its units and words are not.

Names of variables and keys of files stay what they are (``joint_position``, ``load_torque``);
what they are counted in, and what people read, is asked here.
"""

import re
from dataclasses import replace
from enum import StrEnum
from functools import lru_cache
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from elastic_tendon.actuator.quantity import Quantity

# unit of a rotary machine -> the linear one's
_UNITS = {
    "rad": "m",
    "rad/s": "m/s",
    "rad/s2": "m/s2",
    "N.m": "N",
    "N.m/rad": "N/m",
    "N.m.s/rad": "N.s/m",
    "N.m.s2/rad2": "N.s2/m2",
    "N.m.s3/rad3": "N.s3/m3",
    "kg.m2": "kg",
}
# the same as people write them, and small ones
_WRITTEN = {
    "rad": "m",
    "rad/s": "m/s",
    "rad/s²": "m/s²",
    "mrad": "mm",
    "mrad/s": "mm/s",
    "rad/rad": "m/m",
    "rad/(N·m)": "m/N",
    "N·m": "N",
    "mN·m": "mN",
    "N·m/rad": "N/m",
    "N·m·s/rad": "N·s/m",
    "N·m·s²/rad²": "N·s²/m²",
    "N·m·s³/rad³": "N·s³/m³",
    "kg·m²": "kg",
}
_WORDS = {
    "moment of inertia": "mass",
    "angular velocity": "velocity",
    "angles": "positions",
    "angle": "position",
    "torques": "forces",
    "torque": "force",
}
_SAID = {**_UNITS, **_WRITTEN, **_WORDS}
_SAID |= {rotary.capitalize(): linear.capitalize() for rotary, linear in _WORDS.items()}
# no part of another unit or of a name, which may go on in a further line; an interface is called
# by its name
_ANY = "|".join(map(re.escape, sorted(_SAID, key=len, reverse=True)))
_PLACES = re.compile(rf"(?<![\w.·/])(?<!\.\n)(?<!interface )(?:{_ANY})(?![\w·²/])(?!\.\w)")
# what is counted in rad/s and is no velocity, up to where its unit stands
_OF_FREQUENCY = re.compile(
    r"(?:frequenc|resonance|poles|zeros|(?:real|imaginary) part)(?:(?!\. |;|velocity).){0,90}$",
    re.DOTALL,
)


class MotionKind(StrEnum):
    """Value of ``motion`` in model.toml."""

    ROTARY = "rotary"
    LINEAR = "linear"

    def unit(self, unit: str) -> str:
        """Unit that stands in place of a rotary machine's, in FMI's spelling."""
        return unit if self is MotionKind.ROTARY else _UNITS.get(unit, unit)

    @property
    def frequency_unit(self) -> str:
        """Unit of angular frequencies, of which a machine that slides turns nothing."""
        return "rad/s" if self is MotionKind.ROTARY else "1/s"

    def words(self, text: str) -> str:
        """A text with the units and words of this motion in place of a rotary machine's."""
        if self is MotionKind.ROTARY:
            return text
        return _PLACES.sub(self._said, text)

    def _said(self, place: re.Match[str]) -> str:
        if place[0] == "rad/s" and _OF_FREQUENCY.search(place.string, 0, place.start()):
            return self.frequency_unit
        return _SAID[place[0]]

    def quantities(self, of_rotary: "tuple[Quantity, ...]") -> "tuple[Quantity, ...]":
        """Quantities of a model that moves so."""
        return of_rotary if self is MotionKind.ROTARY else _of_linear(of_rotary)


@lru_cache
def _of_linear(quantities: "tuple[Quantity, ...]") -> "tuple[Quantity, ...]":
    linear = MotionKind.LINEAR
    return tuple(
        replace(
            quantity,
            # a pulley of a linear machine is a ratio of lengths
            unit="1" if quantity.path.endswith("pulley_radius") else linear.unit(quantity.unit),
            meaning=linear.words(quantity.meaning),
        )
        for quantity in quantities
    )
