"""What varies: read from text, refused in one sentence, drawn as scipy.stats says."""

import numpy as np
import pytest
from scipy import stats

from elastic_tendon import load_model
from elastic_tendon.actuator.parameters import quantities
from elastic_tendon.errors import SweepError
from elastic_tendon.sweeps.factors import (
    MOST_VALUES,
    Factor,
    Normal,
    Uniform,
    Values,
    parse_factor,
    stated_factors,
)

SHARES = np.linspace(0.0005, 0.9995, 1999)


@pytest.fixture(scope="module")
def model():
    return load_model("figure_7")


def _bounds(model, path):
    (found,) = (quantity for quantity in quantities(model.effect_ids) if quantity.path == path)
    return found.lower, found.upper


def test_gaussian_is_that_of_scipy_cut_off_at_the_bounds():
    normal = Normal(0.1, 0.2, 0.0, 0.4)
    expected = stats.truncnorm((0.0 - 0.1) / 0.2, (0.4 - 0.1) / 0.2, loc=0.1, scale=0.2)
    drawn = normal.at(SHARES)
    np.testing.assert_allclose(drawn, expected.ppf(SHARES), rtol=1e-12)
    assert drawn.min() >= 0.0
    assert drawn.max() <= 0.4


def test_gaussian_far_from_its_bounds_is_whole():
    drawn = Normal(1e4, 1e3, 20.0, 1e8).at(SHARES)
    np.testing.assert_allclose(drawn, stats.norm(1e4, 1e3).ppf(SHARES), rtol=1e-9)
    assert np.isfinite(Normal(1e4, 1e3, 20.0, 1e8).at(np.array([0.0, 1.0]))).all()


def test_gaussian_at_its_bound_is_one_half():
    half = Normal(0.0, 2.0, 0.0, 1e4).at(SHARES)
    np.testing.assert_allclose(half, stats.halfnorm(scale=2.0).ppf(SHARES), rtol=1e-9)


def test_uniform_and_values_give_equal_chances():
    np.testing.assert_allclose(Uniform(2.0, 6.0).at(SHARES), stats.uniform(2.0, 4.0).ppf(SHARES))
    drawn = Values((3.0, 1.0, 2.0)).at(np.arange(3000) / 3000)
    values, counts = np.unique(drawn, return_counts=True)
    assert values.tolist() == [1.0, 2.0, 3.0]
    assert counts.tolist() == [1000, 1000, 1000]
    assert Values((3.0, 1.0)).at(np.array([1.0])).tolist() == [1.0]


@pytest.mark.parametrize(
    ("text", "distribution"),
    [
        ("link.damping=0.1:0.3", Uniform(0.1, 0.3)),
        (" link.damping = 0:1:5 ", Values((0.0, 0.25, 0.5, 0.75, 1.0))),
        ("link.damping=0.3,0.1, 2e-1", Values((0.3, 0.1, 0.2))),
        ("link.damping=0.25,0.5", Values((0.25, 0.5))),
        ("transmission.upper_spring.parallel=1:4:4", Values((1.0, 2.0, 3.0, 4.0))),
    ],
)
def test_forms_of_text(model, text, distribution):
    assert parse_factor(model, text) == Factor(text.partition("=")[0].strip(), distribution)


def test_spread_in_per_cent_and_as_the_model_states_it(model):
    path = "transmission.upper_spring.stiffness"
    value = model.values()[path]
    percent = parse_factor(model, f"{path}=5%").distribution
    assert percent == Normal(value, pytest.approx(0.05 * value), *_bounds(model, path))
    stated = parse_factor(model, path).distribution
    assert stated == Normal(value, model.uncertainty_of(path), *_bounds(model, path))


def test_stated_factors_are_those_of_the_model_file():
    bench = load_model("bench_actuator")
    found = {factor.path: factor.distribution.sigma for factor in stated_factors(bench)}
    assert found == {path: bench.uncertainty_of(path) for path in bench.uncertainty}
    assert found["link.damping"] == pytest.approx(2.0 * 5e-3)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("link.dampin=5%", "did you mean link.damping?"),
        ("=5%", "known are"),
        ("transmission.upper_spring.max_deflection", "write transmission.upper_spring.max_defl"),
        ("transmission.upper_spring.damping=5%", "write transmission.upper_spring.damping=0:HIGH"),
        ("link.damping=0%", "above 0%"),
        ("link.damping=-5%", "above 0%"),
        ("link.damping=much", "'much' is not a number"),
        ("link.damping=", "'' is not a number"),
        ("link.damping=nan:1", "'nan' is not a number"),
        ("link.damping=1:inf", "'inf' is not a number"),
        ("link.damping=0.3:0.1", "0.3 is not below 0.1"),
        ("link.damping=0:1:2:3", "cannot be read"),
        ("link.damping=0:1:1", "whole number from 2"),
        ("link.damping=0:1:2.5", "whole number from 2"),
        (f"link.damping=0:1:{MOST_VALUES + 1}", f"to {MOST_VALUES}"),
        ("link.damping=-1:1", "-1 is outside 0 to 10000 N·m·s/rad"),
        ("link.damping=0.1,2e4", "20000 is outside"),
        ("transmission.upper_spring.parallel", "parallel=A,B,C"),
        ("transmission.upper_spring.parallel=5%", "A,B,C"),
        ("transmission.upper_spring.parallel=1:3", "A,B,C"),
        ("transmission.upper_spring.parallel=1,1.5", "1.5 is not a whole number"),
    ],
)
def test_what_is_refused_is_told_in_one_sentence(model, text, said):
    with pytest.raises(SweepError) as refused:
        parse_factor(model, text)
    assert said in str(refused.value)
    assert "\n" not in str(refused.value)


def test_model_that_states_no_uncertainty_is_refused(model):
    with pytest.raises(SweepError, match=r"\[uncertainty\] states nothing"):
        stated_factors(model)


def test_limits_may_be_shares_of_the_value():
    model = load_model("biorob_x4_joint_3")
    inertia = model.link.inertia
    uniform = parse_factor(model, "link.inertia=-5%:10%").distribution
    assert (uniform.low, uniform.high) == pytest.approx((0.95 * inertia, 1.1 * inertia))
    values = parse_factor(model, "link.inertia=-10%:10%:3").distribution.values
    assert values == pytest.approx((0.9 * inertia, inertia, 1.1 * inertia))
    with pytest.raises(SweepError, match="its value is 0"):
        parse_factor(model, "transmission.upper_spring.damping=-5%:5%")


def test_one_value_is_refused_with_what_was_meant():
    with pytest.raises(SweepError, match=r"link.damping=5: one value .* write link.damping=5% for"):
        parse_factor(load_model("biorob_x4_joint_3"), "link.damping=5")
