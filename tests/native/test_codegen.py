"""The generated C stays of a size that compiles in seconds."""

from elastic_tendon.actuator.model import build
from elastic_tendon.native.codegen import generate

COUPLED = ("gear_backlash", "tendon_compliance", "spring_hardening", "spring_mass")


def test_coupled_unknowns_do_not_multiply_the_code() -> None:
    """They are eliminated once, not anew in every derivative."""
    without = generate(build(COUPLED[1:]))
    coupled = generate(build(COUPLED))
    assert len(coupled) < 4 * len(without)
