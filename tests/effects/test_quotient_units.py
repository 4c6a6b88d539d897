"""Units as exponents, and those of quotients as people write them."""

import pytest

from elastic_tendon.actuator.quantity import unit_text
from elastic_tendon.effects import CATALOGUE
from elastic_tendon.effects.units import base_exponents, quotient

INERTIA = "kg.m2"


@pytest.mark.parametrize(
    ("unit", "over_inertia"),
    [
        ("N.m", "1/s2"),
        ("N.m.s/rad", "1/s"),
        ("N", "1/(m.s2)"),
        ("N.s/m", "1/(m2.s)"),
        ("s", "s/(kg.m2)"),
        (INERTIA, "1"),
    ],
)
def test_a_quotient_is_in_base_units(unit, over_inertia):
    assert quotient(unit, INERTIA) == over_inertia


@pytest.mark.parametrize(
    "unit", sorted({parameter.unit for effect in CATALOGUE for parameter in effect.parameters})
)
def test_a_quotient_of_any_unit_is_a_unit_with_one_stroke(unit):
    ratio = quotient(unit, INERTIA)
    assert ratio.count("/") <= 1
    assert "rad" not in ratio
    expected = {**dict.fromkeys(("kg", "m", "s"), 0), **base_exponents(unit)}
    expected.pop("rad", None)
    expected["kg"] -= 1
    expected["m"] -= 2
    assert base_exponents(ratio) == {base: size for base, size in expected.items() if size}


def test_a_damping_over_an_inertia_is_a_rate():
    assert unit_text(quotient("N.m.s/rad", INERTIA)) == "1/s"


@pytest.mark.parametrize(
    ("unit", "text"),
    [
        ("N/m3", "N/m³"),
        ("N.m.s2/rad2", "N·m·s²/rad²"),
        ("N.m.s3/rad3", "N·m·s³/rad³"),
        ("kg.m2", "kg·m²"),
    ],
)
def test_a_unit_is_written_with_raised_digits(unit, text):
    assert unit_text(unit) == text
