"""The exponent of Bouc-Wen's law: its default, and its derivatives."""

import casadi as ca
import numpy as np
import pytest
from contract_cases import PAPER, assert_sensitivities_agree_with_differences, measured

from elastic_tendon.actuator.parameters import parse_model
from elastic_tendon.effects.symbolic import NEARLY_NOTHING, power

DIFFERENCES = 1e-5  # relative, of central differences at 1e-5 of the value
# below 1 the law has a vertical tangent at z = 0, where steps of any method are of a low order
VERTICAL = 1e-4
NUMBERS = {"force": 12.0, "yield_length": 0.0011}


def with_exponent(exponent):
    return PAPER.with_effect("spring_hysteresis", NUMBERS | {"exponent": exponent})


def test_a_model_without_the_exponent_has_the_first_power():
    tree = PAPER.model_dump() | {"effects": {"spring_hysteresis": NUMBERS}}
    model = parse_model(tree, "older file")
    assert model.values()["effects.spring_hysteresis.exponent"] == 1.0
    assert np.array_equal(measured(model), measured(with_exponent(1.0)))


def test_a_larger_exponent_yields_later():
    late, early = (measured(with_exponent(exponent)) for exponent in (3.0, 1.0))
    assert np.abs(late - early).max() > 1e-3


@pytest.mark.parametrize("exponent", [0.6, 1.0, 2.0, 4.0])
def test_sensitivities_agree_with_differences_for_every_exponent(exponent):
    names = ("force", "yield_length", "exponent")
    paths = [f"effects.spring_hysteresis.{name}" for name in names]
    allowed = VERTICAL if exponent < 1.0 else DIFFERENCES
    assert_sensitivities_agree_with_differences(with_exponent(exponent), paths, allowed)


def test_a_power_has_finite_derivatives_at_zero():
    base, exponent = ca.SX.sym("base"), ca.SX.sym("exponent")
    raised = power(base, exponent)
    derivatives = ca.Function(
        "d", [base, exponent], [ca.gradient(raised, ca.vertcat(base, exponent))]
    )
    for value in (0.0, NEARLY_NOTHING, 2 * NEARLY_NOTHING, 0.5):
        for n in (0.5, 1.0, 2.0):
            assert np.isfinite(np.array(derivatives(value, n))).all()


def test_the_first_power_of_numbers_is_the_numbers():
    values = np.array([0.0, 1e-12, NEARLY_NOTHING, 0.1, 1.0 / 3.0, 1.0])
    assert np.array_equal(power(values, 1.0), values)
