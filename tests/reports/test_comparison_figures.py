"""Figures show the comparison's own numbers, with a unit on every axis."""

import matplotlib.pyplot as plt
import numpy as np
import pytest

from elastic_tendon.actuator.parameters import load_model
from elastic_tendon.comparison.compare import compare
from elastic_tendon.comparison.comparison import Comparison
from elastic_tendon.estimation.ladder import AS_GIVEN, REFIT, FittedStep, climb
from elastic_tendon.measurement import Measurement
from elastic_tendon.reports.comparison_figures import PAIRS, ladder, overlay, story
from elastic_tendon.simulation.excitation import default_excitation
from elastic_tendon.simulation.simulate import simulate


@pytest.fixture(scope="module")
def comparisons():
    """A heavier machine beside the model as given, and beside one that is nearly right."""
    model = load_model("figure_8")
    inertia = model.link.inertia
    excitation = default_excitation(model)
    inputs = (excitation.time, excitation.motor_position, excitation.load_torque)
    machine = model.with_values({"link.inertia": 1.1 * inertia})
    trajectory = simulate(machine, *inputs)
    signals = {name: trajectory[name] for name in ("joint_position", "joint_torque")}
    recording = Measurement(inputs[0], inputs[1], signals, inputs[2], name="machine")
    nearly = model.with_values({"link.inertia": 1.09 * inertia})
    return compare(model, [recording]), compare(nearly, [recording])


@pytest.fixture(scope="module")
def fitted(comparisons):
    given, nearly = comparisons
    return (
        FittedStep(AS_GIVEN, None, 0, 0.0, given, given),
        FittedStep(REFIT, None, 0, 1.0, nearly, nearly),
    )


def test_overlay_shows_each_signal_with_its_error_below(comparisons) -> None:
    comparison = comparisons[0]
    figure = overlay(comparison)
    labels = [axes.get_ylabel() for axes in figure.axes]
    assert labels == [
        "joint position (rad)",
        "error (mrad)",
        "joint torque (N·m)",
        "error (mN·m)",
    ]
    file = comparison.files[0]
    drawn = figure.axes[1].lines[0].get_ydata()
    error = file.trajectory["joint_position"] - file.measurement.signals["joint_position"]
    assert np.asarray(drawn) == pytest.approx(1e3 * error)
    assert plt.get_fignums() == []  # nothing is left open in pyplot


def test_overlay_of_many_recordings_stays_a_picture(comparisons) -> None:
    comparison = comparisons[0]
    many = Comparison(comparison.model, comparison.files * PAIRS)
    figure = overlay(many)
    assert len(figure.axes) == 2 * PAIRS
    assert f"the first {PAIRS} of {2 * PAIRS} signals" in figure.get_suptitle()


def test_ladder_draws_fitted_and_held_out_errors_and_the_floor(fitted) -> None:
    steps = climb(fitted)
    (axes,) = ladder(steps).axes
    assert axes.get_yscale() == "log"
    assert axes.get_ylabel() == "RMS error, joint position (mrad)"
    expected = [1e3 * step.rmse["joint_position"] for step in steps]
    assert axes.lines[0].get_ydata() == pytest.approx(expected)
    assert expected[1] < expected[0]
    names = [text.get_text() for text in axes.get_legend().get_texts()]
    assert names == ["fitted data", "held-out data", "noise floor"]


def test_story_has_an_error_curve_for_each_step(fitted) -> None:
    bottom = story(fitted, climb(fitted)).axes[2]
    labels = [text.get_text() for text in bottom.get_legend().get_texts()]
    assert labels == [AS_GIVEN, REFIT]
    assert bottom.get_xlabel() == "time (s)"
