"""Figures of a diagnosis: units on every axis, and the diagnosis's own numbers."""

from dataclasses import replace

import numpy as np
import pytest
from matplotlib.colors import to_hex

from elastic_tendon.actuator.parameters import load_model
from elastic_tendon.actuator.transmission import characteristic_torque
from elastic_tendon.comparison.compare import compare
from elastic_tendon.diagnosis import explained
from elastic_tendon.measurement import Measurement
from elastic_tendon.reports.comparison_figures import VERMILLION
from elastic_tendon.reports.diagnosis_figures import (
    all_figures,
    before_and_after,
    candidates,
    explained_by,
    next_experiment,
)
from hand_made_diagnosis import COULOMB, friction_found, something_unknown
from hand_made_diagnosis import next_experiment as reversals


def expect_units(figure) -> None:
    """Every axis says what it shows and in which unit, where it has a label of its own."""
    labels = [
        label for axes in figure.axes for label in (axes.get_xlabel(), axes.get_ylabel()) if label
    ]
    assert labels
    assert all(label.endswith(")") for label in labels), labels


def test_every_figure_is_drawn_and_named_once() -> None:
    drawings = dict(all_figures(friction_found()))
    assert list(drawings) == [
        "ladder_joint_position",
        "candidates",
        "explained_by_coulomb_friction",
        "demo_fit_before_and_after",
        "demo_validate_before_and_after",
        "demo_fit_remaining_torque",
        "next_experiment",
    ]
    for draw in drawings.values():
        expect_units(draw())


def test_the_effect_lies_over_what_was_measured_and_little_remains() -> None:
    upper, lower = explained_by(friction_found(), COULOMB).axes
    assert lower.get_xlabel() == "joint velocity (rad/s)"
    velocity, torque = upper.lines[2].get_data()
    assert torque[velocity > 1.0] == pytest.approx(-0.35, abs=0.06)
    assert torque[velocity < -1.0] == pytest.approx(0.35, abs=0.06)
    left = lower.lines[1].get_ydata()
    assert np.max(np.abs(left)) < 0.01


def test_a_learned_term_is_drawn_as_an_effect_is(monkeypatch) -> None:
    # any effect will do: how a learned term becomes one is tested with it
    found = something_unknown()
    with_it = found.model.with_effect(COULOMB, {"torque": 0.35})
    monkeypatch.setattr(explained, "with_learned", lambda _diagnosis: with_it)
    drawings = dict(all_figures(found))
    upper, _ = drawings["learned_term"]().axes
    velocity, torque = upper.lines[2].get_data()
    assert np.mean(torque[velocity > 1.0]) < 0.0 < np.mean(torque[velocity < -1.0])


def test_bars_are_the_candidates_the_chosen_one_stands_out() -> None:
    left, right = candidates(friction_found().rounds).axes
    widths = [bar.get_width() for bar in left.patches]
    assert widths[:2] == [0.93, 0.07]
    assert left.get_yticklabels()[-1].get_text() == "none of them"
    assert [to_hex(bar.get_facecolor()).upper() for bar in left.patches].count(VERMILLION) == 1
    assert left.patches[0].get_facecolor() != left.patches[1].get_facecolor()
    assert [bar.get_width() for bar in right.patches] == [0.984, 0.984, 0.979, 0.979]


def test_ruined_held_out_data_do_not_hide_the_rest() -> None:
    first = friction_found().rounds[0]
    ruined = replace(first.candidates[0], heldout_gain=-40.0)
    _, right = candidates([replace(first, candidates=(ruined, *first.candidates[1:]))]).axes
    assert min(bar.get_width() for bar in right.patches) == -1.0


def test_errors_before_and_after_are_those_of_the_comparisons() -> None:
    found = friction_found()
    before, after = (found.steps[index].comparison.files[0] for index in (0, -1))
    rows = before_and_after(before, after, "fitted").axes
    assert len(rows) == 3
    drawn = np.max(np.abs(rows[2].lines[0].get_ydata()))
    assert drawn == pytest.approx(1e3 * after.signals["joint_position"].max_abs)
    drawn = np.max(np.abs(rows[1].lines[0].get_ydata()))
    assert drawn == pytest.approx(1e3 * before.signals["joint_position"].max_abs)


def test_a_static_curve_is_drawn_over_deflection() -> None:
    model = load_model("figure_8")
    deflection = np.linspace(-0.15, 0.15, 300)
    torque = 0.9 * characteristic_torque(deflection, model.transmission)
    curve = Measurement(
        *(10.0 * np.arange(300), np.zeros(300)),
        {"joint_position": deflection},
        -torque,
        static=True,
        name="curve",
    )
    (file,) = compare(model, [curve]).files
    rows = before_and_after(file, file, "fitted").axes
    assert rows[2].get_xlabel() == "deflection (rad)"
    assert rows[0].get_ylabel() == "joint torque (N·m)"


def test_no_panel_for_a_load_that_is_not_there() -> None:
    assert len(next_experiment(reversals()).axes) == 3
    loaded = replace(reversals(), load_torque=np.ones(2001))
    figure = next_experiment(loaded)
    assert len(figure.axes) == 4
    expect_units(figure)
