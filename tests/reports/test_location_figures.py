"""Figures of where a model fails: units on every axis, and the location's own numbers."""

import numpy as np
import pytest
from matplotlib.collections import PathCollection, QuadMesh
from matplotlib.colors import to_hex

from elastic_tendon.actuator.parameters import load_model
from elastic_tendon.actuator.transmission import characteristic_torque, slack_boundaries
from elastic_tendon.comparison.compare import compare
from elastic_tendon.comparison.comparison import Comparison
from elastic_tendon.comparison.locate import Location, locate
from elastic_tendon.measurement import Measurement
from elastic_tendon.reports.comparison_figures import VERMILLION, overlay
from elastic_tendon.reports.location_figures import (
    all_figures,
    error_maps,
    file_names,
    missing_torque,
    residual_correlation,
    share_of_error,
    torque_loop,
)
from elastic_tendon.simulation.excitation import default_excitation
from elastic_tendon.simulation.simulate import simulate

Compared = tuple[Comparison, Location]


def with_noise(values, sigma: float):
    return values + sigma * np.random.default_rng(5).standard_normal(len(values))


@pytest.fixture(scope="module")
def series() -> Compared:
    """A machine with friction, of which position and torque were measured; and without torque."""
    model = load_model("figure_8")
    machine = model.with_effect("coulomb_friction", {"torque": 0.3})
    excitation = default_excitation(model)
    inputs = (excitation.motor_position, excitation.load_torque)
    trajectory = simulate(machine, excitation.time, *inputs)
    signals = {
        "joint_position": with_noise(trajectory["joint_position"], 1e-4),
        "joint_torque": with_noise(trajectory["joint_torque"], 1e-2),
    }
    both = Measurement(excitation.time, inputs[0], signals, inputs[1], name="run.csv")
    position = {"joint_position": signals["joint_position"]}
    alone = Measurement(excitation.time, inputs[0], position, inputs[1], name="run.csv[0:9]")
    comparison = compare(model, [both, alone])
    return comparison, locate(comparison)


@pytest.fixture(scope="module")
def static() -> Compared:
    """A curve of springs that are softer than the model's."""
    model = load_model("figure_8")
    deflection = np.linspace(-0.15, 0.15, 300)
    torque = 0.9 * characteristic_torque(deflection, model.transmission)
    curve = Measurement(
        10.0 * np.arange(300),
        np.zeros(300),
        {"joint_position": with_noise(deflection, 1e-4)},
        -torque,
        static=True,
        name="curve.csv",
    )
    comparison = compare(model, [curve])
    return comparison, locate(comparison)


def expect_units(figure) -> None:
    """Every axis of every visible panel says what it shows and in which unit."""
    panels = [axes for axes in figure.axes if axes.get_visible()]
    assert panels
    for axes in panels:
        assert "(" in axes.get_ylabel(), axes.get_ylabel()
        categories = {label.get_text() for label in axes.get_xticklabels()} & {"I", "positive"}
        below = axes.xaxis.get_tick_params().get("labelbottom", True)  # not above another panel
        colour_bar = axes.get_label() == "<colorbar>"
        if below and not colour_bar and not categories:
            assert "(" in axes.get_xlabel(), axes.get_title()


def test_every_figure_has_its_own_name_and_units(series: Compared, static: Compared) -> None:
    for comparison, location in (series, static):
        drawings = dict(all_figures(comparison, location))
        assert len(drawings) == len(list(all_figures(comparison, location)))
        for draw in drawings.values():
            expect_units(draw())


def test_names_of_files_are_plain_and_unique() -> None:
    assert file_names(["run.csv", "run.csv[0:1.5]", "my run#2.parquet", "run.csv"]) == [
        *("run", "run_0_1.5", "my_run_2", "run_4")
    ]


def test_loop_says_where_its_torque_is_from(series: Compared) -> None:
    comparison, location = series
    labels = [
        torque_loop(comparison.model, *pair).axes[0].get_ylabel()
        for pair in zip(comparison.files, location.files, strict=True)
    ]
    assert "measured" in labels[0]
    assert "missing torque" in labels[1]


def test_reconstructed_loop_lies_about_the_friction_from_the_springs(series: Compared) -> None:
    comparison, location = series
    axes = torque_loop(comparison.model, comparison.files[1], location.files[1]).axes[0]
    clouds = [
        collection for collection in axes.collections if isinstance(collection, PathCollection)
    ]
    points = np.concatenate([np.asarray(cloud.get_offsets()) for cloud in clouds])
    springs = characteristic_torque(points[:, 0], comparison.model.transmission)
    off = points[:, 1] - springs
    assert np.quantile(np.abs(off), 0.5) == pytest.approx(0.3, abs=0.1)
    boundaries = {line.get_xdata()[0] for line in axes.lines if line.get_linestyle() == ":"}
    assert boundaries == set(slack_boundaries(comparison.model.transmission))


def test_bars_are_the_shares_and_those_that_stand_out_are_marked(series: Compared) -> None:
    comparison, location = series
    figure = share_of_error(comparison.files[0], location.files[0], "joint_position")
    bins = location.files[0].bins["joint_position"]
    bars = [bar for axes in figure.axes for bar in axes.patches]
    assert [bar.get_height() for bar in bars] == pytest.approx([bin_.share for bin_ in bins])
    marked = [to_hex(bar.get_facecolor()).upper() == VERMILLION for bar in bars]
    assert marked == [bin_.stands_out for bin_ in bins]
    assert any(marked)


def test_maps_of_signed_torque_are_centred_at_zero(series: Compared) -> None:
    comparison, location = series
    figure = error_maps(comparison.files[0], location.files[0])
    limits = [
        mesh.get_clim()
        for axes in figure.axes
        for mesh in axes.collections
        if isinstance(mesh, QuadMesh) and axes.get_label() != "<colorbar>"
    ]
    signed = [low < 0.0 for low, _ in limits]
    assert signed == [False, True, False, True]
    assert all(low == -high for low, high in limits[1::2])


def test_missing_torque_has_a_panel_for_each_curve(series: Compared) -> None:
    comparison, location = series
    found = location.files[0].missing_torque
    panels = [
        axes
        for axes in missing_torque(comparison.files[0], location.files[0]).axes
        if axes.get_visible()
    ]
    assert len(panels) == len(found.curves) >= 4
    for axes, curve in zip(panels, found.curves, strict=True):
        assert axes.lines[-1].get_ydata() == pytest.approx(curve.mean)


def test_correlation_shows_itself_and_the_inputs(series: Compared) -> None:
    location = series[1].files[0]
    figure = residual_correlation(series[0].files[0], location, "joint_position")
    titles = [axes.get_title() for axes in figure.axes]
    assert titles == [
        *("with itself", "with the motor position", "with the load torque"),
        *("with the motor velocity", "with the motor acceleration", ""),
    ]
    for axes, found in zip(figure.axes, location.correlations["joint_position"], strict=False):
        assert axes.lines[-1].get_ydata() == pytest.approx(found.values)


def test_static_curves_are_drawn_as_torque_over_deflection(static: Compared) -> None:
    comparison, _ = static
    upper, lower = overlay(comparison).axes
    assert upper.get_ylabel() == "joint torque (N·m)"
    assert lower.get_xlabel() == "deflection (rad)"
    assert lower.get_ylabel() == "error (mrad)"
    measured = comparison.files[0].measurement
    drawn = upper.lines[0]
    assert drawn.get_xdata() == pytest.approx(measured.signals["joint_position"])
    assert drawn.get_ydata() == pytest.approx(-measured.load_torque)
