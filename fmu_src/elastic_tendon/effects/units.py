"""Units as exponents of the SI base units."""

import re
from collections import Counter

from elastic_tendon.errors import BuildError

BASE_UNITS = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")

_SYMBOLS: dict[str, dict[str, int]] = {
    **{base: {base: 1} for base in BASE_UNITS},
    "N": {"kg": 1, "m": 1, "s": -2},
    "Pa": {"kg": 1, "m": -1, "s": -2},
    "J": {"kg": 1, "m": 2, "s": -2},
    "W": {"kg": 1, "m": 2, "s": -3},
    "Hz": {"s": -1},
}


def _factors(product: str) -> Counter[str]:
    exponents: Counter[str] = Counter()
    for factor in product.strip("()").split("."):
        if factor == "1":
            continue
        match = re.fullmatch(r"([A-Za-z]+)(-?\d+)?", factor)
        if match is None or match[1] not in _SYMBOLS:
            known = ", ".join(_SYMBOLS)
            raise BuildError(
                f"the unit factor {factor!r} is none of {known} with an exponent; "
                "factors are joined by a point, as in N.m/rad"
            )
        for base, exponent in _SYMBOLS[match[1]].items():
            exponents[base] += exponent * int(match[2] or 1)
    return exponents


def base_exponents(unit: str) -> dict[str, int]:
    """Exponents of the SI base units that are not 0, such as ``N.s/m`` -> kg: 1, s: -1.

    Raises
    ------
    BuildError
        for a unit that is not a product of known symbols, divided by at most one other
    """
    above, _, below = unit.partition("/")
    exponents = _factors(above)
    exponents.subtract(_factors(below or "1"))
    return {base: exponents[base] for base in BASE_UNITS if exponents[base] != 0}


def quotient(unit: str, divisor: str) -> str:
    """Unit of a quotient in SI base units, radians left out as the 1 that they are.

    So ``N.m.s/rad`` over ``kg.m2`` is ``1/s``.

    Raises
    ------
    BuildError
        see `base_exponents`
    """
    exponents = Counter(base_exponents(unit))
    exponents.subtract(base_exponents(divisor))
    above, below = (
        [
            f"{base}{size if size > 1 else ''}"
            for base in BASE_UNITS
            if base != "rad" and (size := sign * exponents[base]) > 0
        ]
        for sign in (1, -1)
    )
    divided = ".".join(below) if len(below) < 2 else f"({'.'.join(below)})"
    return "/".join([".".join(above) or "1", *([divided] if below else [])])
