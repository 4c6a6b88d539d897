"""The figure of a describing function shows what was computed, and where it bends."""

import numpy as np
import pytest

from elastic_tendon.actuator.design import design
from elastic_tendon.actuator.parameters import load_model
from elastic_tendon.linear.describing_function import describing_function


def lines(axes):
    """Lines by label; lines without one under their place."""
    return {line.get_label(): line for line in axes.get_lines()}


@pytest.fixture(scope="module")
def symmetric():
    return load_model("biorob_x4_joint_3")


def test_a_lossless_symmetric_transmission_needs_one_pair_of_axes(symmetric):
    (axes,) = describing_function(symmetric).plot().axes
    table, drawn = design(symmetric), lines(axes)
    assert set(drawn) >= {"states I and II", "state III", "equivalent", "slack boundary"}
    assert drawn["state III"].get_ydata()[0] == table.stiffness_state_3
    boundary, limit = (
        drawn[label].get_xdata()[0] for label in ("slack boundary", "deflection limit")
    )
    assert boundary == pytest.approx(table.positive_slack_boundary)
    assert limit == pytest.approx(table.positive_max_deflection)
    assert np.isclose(drawn["equivalent"].get_ydata()[0], table.stiffness_state_3)
    assert axes.get_xlabel() == "amplitude of the deflection (rad)"
    assert axes.child_axes[0].get_xlabel() == "amplitude of the deflection (°)"
    assert axes.get_ylabel() == "equivalent stiffness\n(N·m/rad)"


def test_damping_has_axes_of_its_own(symmetric):
    damped = symmetric.with_values({"transmission.upper_spring.damping": 20.0})
    found = describing_function(damped, [0.05, 0.3])
    upper, lower = found.plot().axes
    assert lower.get_ylabel() == "equivalent damping\n(N·m·s/rad)"
    assert np.array_equal(lower.get_lines()[0].get_ydata(), found.damping)
    assert np.array_equal(lines(upper)["equivalent"].get_ydata(), found.stiffness)


def test_borders_are_reached_where_the_mean_under_load_lets_them(symmetric):
    found = describing_function(symmetric, np.linspace(0.01, 0.5, 40), load_torque=3.0)
    figure = found.plot()
    (axes,) = figure.axes
    boundary = design(symmetric).positive_slack_boundary
    reached = boundary - 3.0 / design(symmetric).stiffness_state_3  # while both tendons are taut
    assert lines(axes)["slack boundary"].get_xdata()[0] == pytest.approx(reached, rel=1e-2)
    assert "mean deflection 0.072 to" in figure.get_suptitle()
