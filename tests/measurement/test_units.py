"""Units as people write them, and what they measure."""

from math import pi

import pytest

from elastic_tendon.measurement.units import Unit, parse_unit

KNOWN = {
    "s": ("time", 1.0),
    "sec": ("time", 1.0),
    "MIN": ("time", 60.0),
    "ms": ("time", 1e-3),
    "us": ("time", 1e-6),
    "µs": ("time", 1e-6),
    "min": ("time", 60.0),
    "hour": ("time", 3600.0),
    "rad": ("angle", 1.0),
    "mrad": ("angle", 1e-3),
    "deg": ("angle", pi / 180),
    "°": ("angle", pi / 180),
    "Deg": ("angle", pi / 180),
    "DEG": ("angle", pi / 180),
    "Degrees": ("angle", pi / 180),
    "º": ("angle", pi / 180),
    "turn": ("angle", 2 * pi),
    "arcmin": ("angle", pi / 180 / 60),
    "Nm": ("torque", 1.0),
    "N.m": ("torque", 1.0),
    "N-m": ("torque", 1.0),
    "N•m": ("torque", 1.0),
    "N×m": ("torque", 1.0),
    "N·m": ("torque", 1.0),
    "mNm": ("torque", 1e-3),
    "mN*m": ("torque", 1e-3),
    "Ncm": ("torque", 1e-2),
    "kNm": ("torque", 1e3),
    "kgf*cm": ("torque", 0.0980665),
    "lbf.in": ("torque", 0.1129848290276167),
    "rpm": ("speed", 2 * pi / 60),
    "deg_per_s": ("speed", pi / 180),
    "°/s": ("speed", pi / 180),
    "rad/s": ("speed", 1.0),
    "turn_per_min": ("speed", 2 * pi / 60),
}


@pytest.mark.parametrize("text", KNOWN)
def test_known_unit(text: str) -> None:
    dimension, factor = KNOWN[text]
    unit = parse_unit(text)
    assert unit is not None
    assert unit.dimension == dimension
    assert unit.factor == pytest.approx(factor, rel=1e-12)


def test_newton_metres_are_not_nanometres() -> None:
    assert parse_unit("Nm") == Unit("torque", 1.0)
    assert parse_unit("nm") is None  # nobody records a machine in them


# a count of an encoder has no angle, although pint lets it pass for one
@pytest.mark.parametrize("text", ["count", "percent", "Hz", "Nm/rad", "degC", "rad/s/s"])
def test_unit_of_something_else(text: str) -> None:
    unit = parse_unit(text)
    assert unit is not None
    assert unit.dimension == ""


# a gradian to some, a degree to others; prefixes that only a slip of the shift key makes
@pytest.mark.parametrize(
    "text",
    ["grad", "Grad", "gon", "grade", "Mrad", "Gs", "Ts", "MNm", "dNm", "year", "a", "eV", "J"],
)
def test_what_nobody_records_in_is_not_known(text: str) -> None:
    unit = parse_unit(text)
    assert unit is None or unit.dimension == ""


@pytest.mark.parametrize(
    "text", ["", "1", "2", "raw", "furlongs per", "N_m", "s**9**9", "9 rad", "a" * 500, "(", "__"]
)
def test_text_that_is_no_unit(text: str) -> None:
    assert parse_unit(text) is None
