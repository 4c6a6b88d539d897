"""Figures of linear models: the responses drawn are those of the systems, with units."""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest

from elastic_tendon.actuator.parameters import load_model
from elastic_tendon.linear.linearise import linearise
from elastic_tendon.linear.result import Drive, OperatingPoint
from elastic_tendon.reports.comparison_figures import save
from elastic_tendon.reports.linear_figures import linear_figure

MODEL = load_model("biorob_x4_joint_3")


def test_curves_are_the_frequency_responses_of_all_states() -> None:
    models = {state: linearise(MODEL, state) for state in ("I", "II", "III")}
    figure = linear_figure("joint", list(models.values()))
    magnitude, phase, *_ = figure.axes
    assert magnitude.get_ylabel() == "magnitude (1)"
    assert phase.get_xlabel() == "angular frequency (rad/s)"
    assert phase.get_ylabel() == "phase (°)"
    assert len(magnitude.lines) == len(phase.lines) == 3
    omega, drawn = magnitude.lines[-1].get_data()  # thick lines first
    linear = models["III"]
    i, j = linear.output_labels.index("joint_position"), linear.input_labels.index("motor_position")
    expected = np.array([abs(linear(1j * rate)[i, j]) for rate in omega])
    assert np.asarray(drawn) == pytest.approx(expected, rel=1e-9)
    assert np.asarray(phase.lines[-1].get_ydata())[[0, -1]] == pytest.approx([0.0, -180.0], abs=5)
    peak = omega[np.argmax(drawn)]
    assert peak == pytest.approx(37.28 * (1.0 - 2.0 * 0.0715**2) ** 0.5, abs=0.1)
    assert omega[0] < 2.64
    assert omega[-1] > 372.0
    assert plt.get_fignums() == []  # nothing is left open in pyplot


def test_poles_and_zeros_of_the_collocated_channel_are_marked() -> None:
    linear = linearise(MODEL, "III", drive=Drive.TORQUE)
    figure = linear_figure("joint", [linear])
    labels = [axes.get_xlabel() for axes in figure.axes]
    axes = figure.axes[labels.index("real part (rad/s)")]
    assert axes.get_ylabel() == "imaginary part (rad/s)"
    marks = {line.get_marker(): line for line in axes.lines if line.get_marker() in ("x", "o")}
    zeros = np.sort(np.asarray(marks["o"].get_ydata()))
    assert zeros == pytest.approx([-37.18, 37.18], abs=0.01)
    assert len(marks["x"].get_ydata()) == 4
    titles = [axes.get_title() for axes in figure.axes]
    assert "motor drive torque → motor position" in titles
    assert "motor drive torque → joint position" in titles


def test_zeros_far_away_are_named_and_not_drawn() -> None:
    damped = MODEL.with_values({"transmission.upper_spring.damping": 2.0})
    figure = linear_figure("joint", [linearise(damped, "III", drive=Drive.VELOCITY)])
    (axes,) = [axes for axes in figure.axes if axes.get_xlabel() == "real part (rad/s)"]
    assert "far away: zeros at -1.16e+04 rad/s" in axes.get_title()
    assert axes.get_xlim()[0] > -100.0


def test_sides_of_a_boundary_and_an_undamped_joint_can_be_drawn(tmp_path: Path) -> None:
    undamped = MODEL.with_values({"link.damping": 0.0})
    slack = 80.0 / (0.03 * 2 * 11580.0)
    figure = linear_figure("joint", [linearise(undamped, "III", OperatingPoint(deflection=slack))])
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert len(labels) == 2
    assert any("towards +" in label and label.startswith("II:") for label in labels)
    save(figure, tmp_path / "sides.png")
    assert (tmp_path / "sides.png").stat().st_size > 10_000
    assert plt.get_fignums() == []


def test_a_channel_that_carries_nothing_is_said_to(tmp_path: Path) -> None:
    rough = MODEL.with_effect("coulomb_friction", {"torque": 0.3})
    sticking = linearise(rough, "III", modes={"joint_motion": 0})
    figure = linear_figure("joint", [sticking], ("load_torque", "joint_position"))
    assert [text.get_text() for text in figure.axes[0].texts] == ["no response"]
    save(figure, tmp_path / "sticking.png")


def test_a_channel_of_the_users_choice_is_drawn_alone_with_its_unit() -> None:
    linear = linearise(MODEL, "III")
    figure = linear_figure("joint", [linear], ("load_torque", "upper_spring_force"))
    titles = [axes.get_title() for axes in figure.axes if axes.get_title()]
    assert titles[0] == "load torque → upper spring force"
    assert figure.axes[0].get_ylabel() == "magnitude (N/(N·m))"
    assert len(titles) == 2  # the Bode plot and the poles
