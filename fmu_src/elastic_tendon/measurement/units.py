"""Units at the door: what a unit's text measures, and its factor to SI.

The usual units are in a table; any other is asked of pint, whose registry takes half a second to
load. pint reads torques differently (``nm`` is a nanometre, ``Nm`` the newton of a mass), so these
are taken apart before.
"""

import re
from dataclasses import dataclass
from functools import lru_cache
from math import pi
from typing import TYPE_CHECKING, Any

from elastic_tendon.errors import MeasurementError

if TYPE_CHECKING:
    from pint import UnitRegistry

_DEGREE, _TURN = pi / 180.0, 2.0 * pi

# dimension -> unit -> factor to SI; the first is the contract's own
USUAL = {
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0, "h": 3600.0},
    "angle": {"rad": 1.0, "mrad": 1e-3, "deg": _DEGREE},
    "torque": {"Nm": 1.0, "mNm": 1e-3, "uNm": 1e-6, "kNm": 1e3, "Ncm": 1e-2, "Nmm": 1e-3},
    "speed": {"rad_per_s": 1.0, "mrad_per_s": 1e-3, "deg_per_s": _DEGREE, "rpm": _TURN / 60.0},
    "length": {"m": 1.0, "mm": 1e-3, "um": 1e-6, "cm": 1e-2},
    "force": {"N": 1.0, "mN": 1e-3, "kN": 1e3},
    "velocity": {"m_per_s": 1.0, "mm_per_s": 1e-3},
}
# what a signal of a rotary machine measures -> what it measures at a linear one
LINEAR = {"angle": "length", "torque": "force", "speed": "velocity"}
EXAMPLES = {
    "time": "s or ms",
    "angle": "rad or deg",
    "torque": "Nm or mNm",
    "speed": "rad_per_s or rpm",
    "length": "m or mm",
    "force": "N or kN",
    "velocity": "m_per_s or mm_per_s",
}

_PLAIN = str.maketrans(
    {"°": "deg", "º": "deg", "µ": "u", "μ": "u", "·": "*", "⋅": "*", "•": "*", "×": "*"}
)
_NEWTON_METRE = re.compile(r"([muk]?)N[.* -]?([cmk]?)m")
# lower case -> unit, for words that mean nothing else in capitals
_WORDS = {
    **{word: word for word in ("rad", "deg", "rpm", "min")},
    **dict.fromkeys(("degree", "degrees"), "deg"),
    **dict.fromkeys(("radian", "radians"), "rad"),
    **dict.fromkeys(("sec", "second", "seconds"), "s"),
}
# words and operators, exponents of one figure: nothing that pint could calculate with for long
_WORD = r"[A-Za-z][A-Za-z_]*(?:\^-?\d)?"
_EXPRESSION = re.compile(rf"{_WORD}(?:[*/. ]{_WORD}){{0,5}}")

# exponents of kg, m, s and rad -> what it measures
_DIMENSIONS: dict[tuple[float, ...], str] = {
    (0, 0, 1, 0): "time",
    (0, 0, 0, 1): "angle",
    (1, 2, -2, 0): "torque",
    (0, 0, -1, 1): "speed",
    (0, 1, 0, 0): "length",
    (1, 1, -2, 0): "force",
    (0, 1, -1, 0): "velocity",
}
_BASES = ("kilogram", "meter", "second", "radian")
# what recordings are written in, by pint's names; more would misread words: "grad" is a gradian to
# some and a degree to others, "Grad" a thousand million radians, "act" of a carat
_MEANT = {
    *("second", "minute", "hour", "day", "radian", "degree", "turn", "arcminute", "arcsecond"),
    *("revolutions_per_minute", "revolutions_per_second", "meter", "inch", "foot", "newton"),
    *("dyne", "force_gram", "force_kilogram", "force_pound", "force_ounce", "foot_pound"),
}
_PREFIXES = ("", "micro", "milli", "kilo")
_PREFIXED = (("nano", "second"), ("centi", "meter"))


@dataclass(frozen=True)
class Unit:
    """A unit: `dimension` as in `USUAL`, or "" for any other, and `factor` to SI."""

    dimension: str
    factor: float


def parse_unit(text: str) -> Unit | None:
    """Read a unit.

    Parameters
    ----------
    text : str; such as ``deg``, ``rad/s``, ``deg_per_s``, ``mN.m``, ``°``, or any that pint knows

    Returns
    -------
    Unit, or None where it is not one
    """
    plain = usual_name(text)
    for dimension, factors in USUAL.items():
        if plain in factors:
            return Unit(dimension, factors[plain])
    return _ask_pint(text.strip())


def factor_of(unit: str, dimension: str, quantity: str, called: str) -> float:
    """Factor to SI of the unit that a user gives of a quantity; "" is its SI unit.

    Parameters
    ----------
    unit : as of `parse_unit`
    dimension : of `USUAL`, what the quantity's unit measures
    quantity, called : its name, and how a sentence about it begins

    Raises
    ------
    MeasurementError : it is no unit of this dimension
    """
    if not unit:
        return next(iter(USUAL[dimension].values()))
    parsed = parse_unit(unit)
    if parsed is None or parsed.dimension != dimension:
        raise MeasurementError(
            f"{called}: {unit} is no unit of {dimension}; {quantity} needs one such as "
            f"{EXAMPLES[dimension]}"
        )
    return parsed.factor


def usual_name(text: str) -> str:
    """Name in `USUAL` of a unit that may be spelt otherwise; any other text as it is."""
    plain = text.strip().translate(_PLAIN)
    if match := _NEWTON_METRE.fullmatch(plain):
        return f"{match[1]}N{match[2]}m"
    plain = plain.replace("/", "_per_")
    return _WORDS.get(plain.lower(), plain)


@lru_cache
def _ask_pint(text: str) -> Unit | None:
    if not _EXPRESSION.fullmatch(text.translate(_PLAIN)):
        return None
    from pint import PintError

    expression = text.translate(_PLAIN).replace("_per_", "/").replace(".", "*").replace("^", "**")
    expression = re.sub(r"\b([muk]?)N([cmk]?)m\b", r"\1N*\2m", expression)
    registry = _registry()
    try:
        quantity: Any = registry.Quantity(1.0, registry.parse_units(expression)).to_base_units()
    except (PintError, ValueError, TypeError, AttributeError, SyntaxError):
        return None
    meant = all(_is_meant(word) for word in re.findall("[A-Za-z_]+", expression))
    bases = {str(name): float(power) for name, power in quantity.unit_items()}
    exponents = tuple(bases.pop(name, 0.0) for name in _BASES)
    dimension = "" if bases else _DIMENSIONS.get(exponents, "")
    return Unit(dimension, float(quantity.magnitude)) if meant or not dimension else None


def _is_meant(word: str) -> bool:
    """Whether a word is one of the units in use, with one of the prefixes in use."""
    prefix, unit, _ = _registry().parse_unit_name(word)[0]
    return unit in _MEANT and (prefix in _PREFIXES or (prefix, unit) in _PREFIXED)


@lru_cache(maxsize=1)
def _registry() -> "UnitRegistry[Any]":
    from pint import UnitRegistry

    return UnitRegistry()
