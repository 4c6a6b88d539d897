"""Design rules against the numbers of the paper and of its figures."""

import math

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg

from elastic_tendon.actuator import design
from elastic_tendon.actuator.design import DesignTable
from elastic_tendon.actuator.parameters import load_model, models, parse_model
from elastic_tendon.actuator.transmission import characteristic_stiffness, deflection_limits
from elastic_tendon.errors import ModelError
from elastic_tendon.reports import figures

# the paper prints so many digits; half of the last one may be rounding
PAPER_RAD = 0.0005
PAPER_HUNDREDTH = 0.005
PAPER_NEWTON = 0.05
# (37) prints 22.05 degrees for 22.051, (36) 6.60 for 6.597: both within half a digit
ROUNDING = 1e-12


@pytest.fixture
def biorob() -> DesignTable:
    return design.design(load_model("biorob_x4_joint_3"))


# ---- numbers to reproduce ----


def test_static_slack_boundary_36(biorob: DesignTable) -> None:
    for sign, found in ((-1, biorob.negative_slack_boundary), (1, biorob.positive_slack_boundary)):
        assert sign * found == pytest.approx(0.115, abs=PAPER_RAD)
        assert sign * math.degrees(found) == pytest.approx(6.60, abs=PAPER_HUNDREDTH)


def test_maximum_deflection_37(biorob: DesignTable) -> None:
    for sign, found in ((-1, biorob.negative_max_deflection), (1, biorob.positive_max_deflection)):
        assert sign * found == pytest.approx(0.385, abs=PAPER_RAD)
        assert sign * math.degrees(found) == pytest.approx(22.05, abs=PAPER_HUNDREDTH)


def test_erratum_4_only_the_corrected_16_yields_37() -> None:
    """The signs printed in (16) give 0.615 rad where (37) says 0.385 rad."""
    printed = 0.015 / 0.03 + 80.0 / (23160.0 * 0.03)
    assert printed == pytest.approx(0.615, abs=PAPER_RAD)
    _, high = deflection_limits(load_model("biorob_x4_joint_3").transmission)
    assert high == pytest.approx(0.385, abs=PAPER_RAD)


def test_erratum_3_parallel_tendons_add_33_34() -> None:
    """(35) prints k_i,1 + k_i,1; with equal springs the sum of (33) and (34) is the same."""
    transmission = load_model("biorob_x4_joint_3").transmission
    assert transmission.upper_spring.combined_stiffness == 11580.0 + 11580.0
    assert transmission.lower_spring.combined_stiffness == 23160.0


def test_parallel_dampers_add_too() -> None:
    path = "transmission.upper_spring.damping"
    model = load_model("biorob_x4_joint_3").with_values({path: 3.0})
    assert model.transmission.upper_spring.combined_damping == 6.0
    table = design.design(model)
    assert table.damping_state_1 == pytest.approx(0.03**2 * 6.0, rel=ROUNDING)  # (20)
    assert table.damping_state_2 == 0.0
    assert table.damping_state_3 == table.damping_state_1


def test_stiffness_38_39(biorob: DesignTable) -> None:
    assert biorob.stiffness_state_3 == pytest.approx(41.69, abs=PAPER_HUNDREDTH)
    assert biorob.stiffness_state_1 == pytest.approx(20.84, abs=PAPER_HUNDREDTH)
    assert biorob.stiffness_state_2 == pytest.approx(20.84, abs=PAPER_HUNDREDTH)


def test_pretension_limits_27_31(biorob: DesignTable) -> None:
    assert biorob.largest_pretension == pytest.approx(347.4, abs=PAPER_NEWTON)
    assert biorob.recommended_pretension == pytest.approx(173.7, abs=PAPER_NEWTON)


def test_maximum_torque(biorob: DesignTable) -> None:
    assert biorob.negative_max_torque == pytest.approx(10.42, abs=PAPER_HUNDREDTH)
    assert biorob.positive_max_torque == pytest.approx(-10.42, abs=PAPER_HUNDREDTH)


def test_link_and_frequencies(biorob: DesignTable) -> None:
    assert biorob.effective_link_mass == pytest.approx(0.03 / 0.03**2, rel=ROUNDING)
    assert biorob.frequency_state_3 == pytest.approx(math.sqrt(41.688 / 0.03), rel=ROUNDING)
    assert biorob.frequency_state_1 == pytest.approx(math.sqrt(20.844 / 0.03), rel=ROUNDING)


def test_figure_7() -> None:
    model = load_model("figure_7")
    upper, lower = model.transmission.upper_spring, model.transmission.lower_spring
    assert upper.combined_stiffness == 22820.0
    assert upper.max_deflection == 0.005
    assert lower.combined_stiffness == pytest.approx(0.75 * 22820.0, rel=ROUNDING)
    assert lower.max_deflection == pytest.approx(1.33 * 0.005, rel=ROUNDING)
    assert model.transmission.joint_pulley_radius == 0.05
    table = design.design(model)
    assert table.recommended_pretension == pytest.approx(
        0.005 * 22820.0 * 0.75 / 1.75, rel=ROUNDING
    )


def test_figure_8() -> None:
    model = load_model("figure_8")
    for spring in (model.transmission.upper_spring, model.transmission.lower_spring):
        assert spring.combined_stiffness == 11580.0
        assert spring.max_deflection == 0.015
    assert model.transmission.joint_pulley_radius == 0.04
    assert design.design(model).recommended_pretension == pytest.approx(86.85, rel=ROUNDING)


def test_figure_5_has_three_slopes() -> None:
    tree = load_model("figure_8").model_dump(exclude_none=True)
    upper, lower = (tree["transmission"][side] for side in ("upper_spring", "lower_spring"))
    upper["stiffness"] = 1.33 * lower["stiffness"]
    upper["max_deflection"] = 0.67 * lower["max_deflection"]
    transmission = parse_model(tree, "figure_5").transmission
    low, high = deflection_limits(transmission)
    slopes = characteristic_stiffness([low, 0.0, high], transmission)
    unit = 0.04**2 * 11580.0
    np.testing.assert_allclose(slopes, [1.33 * unit, 2.33 * unit, unit], rtol=ROUNDING)


# ---- curve families, Figs. 7 to 9 ----


@pytest.mark.parametrize("name", models)
def test_up_to_the_recommended_pretension_the_largest_torque_stays_the_same(name: str) -> None:
    model = load_model(name)
    transmission = model.transmission
    radius = transmission.joint_pulley_radius
    pretensions = np.linspace(0.0, transmission.recommended_pretension, 5).tolist()
    curves = design.characteristic_curves(model, pretensions)
    for curve in curves:
        assert curve.torque[0] == pytest.approx(radius * transmission.upper_spring.largest_force)
        assert curve.torque[-1] == pytest.approx(-radius * transmission.lower_spring.largest_force)
    highest = [curve.deflection[-1] for curve in curves]
    assert np.all(np.diff(highest) < 0.0)  # more pretension, less deflection


@pytest.mark.parametrize("share", [0.2, 0.5, 0.9])
def test_above_the_recommended_pretension_the_largest_torque_falls(share: float) -> None:
    """R [k_1 l_max,1 - F_p (1 + k_2/k_1) + k_2 l_max,1] at the limit of the upper spring."""
    model = load_model("biorob_x4_joint_3")
    limits = model.transmission
    recommended, largest = limits.recommended_pretension, limits.largest_pretension
    force = recommended + share * (largest - recommended)
    table = design.design(model.with_values({"transmission.pretension_force": force}))
    k_1 = k_2 = 23160.0
    expected = 0.03 * (k_1 * 0.015 - force * (1 + k_2 / k_1) + k_2 * 0.015)
    assert table.negative_max_torque == pytest.approx(expected, rel=1e-9)  # cancellation
    assert table.positive_max_torque == pytest.approx(-expected, rel=1e-9)
    assert table.negative_max_torque < 10.42


def test_at_the_largest_pretension_nothing_is_left_to_deflect() -> None:
    model = load_model("biorob_x4_joint_3")
    largest = {"transmission.pretension_force": model.transmission.largest_pretension}
    table = design.design(model.with_values(largest))
    assert table.positive_max_deflection == pytest.approx(0.0, abs=1e-15)  # (26)
    (curve,) = design.characteristic_curves(model, list(largest.values()))
    assert np.all(np.isnan(curve.slack_boundaries))


@pytest.mark.parametrize("name", models)
def test_curves_run_from_limit_to_limit_through_their_kinks(name: str) -> None:
    model = load_model(name)
    for curve in design.characteristic_curves(model):
        force = {"transmission.pretension_force": curve.pretension}
        limits = deflection_limits(model.with_values(force).transmission)
        assert (curve.deflection[0], curve.deflection[-1]) == limits
        inside = curve.slack_boundaries[np.isfinite(curve.slack_boundaries)]
        assert np.isin(inside, curve.deflection).all()
        assert np.all(np.diff(curve.deflection) > 0.0)
        assert np.all(np.diff(curve.torque) <= 0.0)


def test_default_family_holds_the_model_s_own_pretension() -> None:
    model = load_model("biorob_x4_joint_3")
    pretensions = [curve.pretension for curve in design.characteristic_curves(model)]
    assert 80.0 in pretensions
    assert pretensions == sorted(pretensions)
    assert len(pretensions) >= 4


def test_pretension_above_27_is_refused_for_a_curve() -> None:
    with pytest.raises(ModelError, match=r"347\.4 N"):
        design.characteristic_curves(load_model("biorob_x4_joint_3"), [400.0])


# ---- faces ----


def test_rows_say_every_value_with_name_equation_and_unit(biorob: DesignTable) -> None:
    rows = tuple(biorob.rows().values())
    assert len({row.name for row in rows}) == len(rows)
    for row in rows:
        assert row.symbol
        assert row.equation
        assert row.unit
        assert math.isfinite(row.value)
    assert rows[0].value == biorob.negative_slack_boundary


@pytest.mark.parametrize("name", models)
def test_figure_draws_each_curve_with_units(name: str) -> None:
    model = load_model(name)
    figure = figures.characteristic_curves(model)
    FigureCanvasAgg(figure).draw()
    torque_axes, stiffness_axes = figure.axes
    labels = torque_axes.get_legend_handles_labels()[1]
    assert len(labels) == len(design.characteristic_curves(model))
    assert sum("(model)" in label for label in labels) == 1
    assert "N·m" in torque_axes.get_ylabel()
    assert "N·m/rad" in stiffness_axes.get_ylabel()
    assert "rad" in stiffness_axes.get_xlabel()
