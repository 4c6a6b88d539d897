"""The figure of a fleet shows what its table says, of few robots and of many."""

import numpy as np
import pandas as pd
import pytest

from elastic_tendon.actuator.parameters import load_model
from elastic_tendon.reports.comparison_figures import PURPLE
from elastic_tendon.reports.fleet_figure import (
    LEAST,
    LIMIT,
    MOST_NUMBERED,
    MOST_ROWS,
    fleet_figure,
)
from elastic_tendon.sweeps.fleet import Robot, fleet

MODEL = load_model("biorob_x4_joint_3")
DAMPING, SOFT = "link.damping", "transmission.upper_spring.damping"


def table_of(rows):
    """Results of a fleet made by hand."""
    task = fleet(
        MODEL, [Robot(f"robot {number}", (f"{number}.csv",)) for number in range(len(rows))]
    )
    blank = {"joint_position_noise_ratio_before": 2.0, "joint_position_noise_ratio_after": 1.0}
    tables = [task.failed(run, "").assign(**blank | row) for run, row in enumerate(rows)]
    return pd.concat(tables, ignore_index=True)


DRIFTED = {"drifted": DAMPING, DAMPING: 0.2}
APPEARED = {"appeared": "gravity_load; own_effect: indistinguishable from gear_backlash"}
UNKNOWN = {"appeared": "unknown: no known effect explains the error"}
FAILED = {
    "failure": "log.csv: the column is_not_there",
    "joint_position_noise_ratio_before": np.nan,
    "joint_position_noise_ratio_after": np.nan,
}


def names(axes):
    return [label.get_text() for label in axes.get_xticklabels()]


def texts(axes):
    return [text.get_text() for text in axes.texts]


def test_robots_numbers_and_effects_are_where_the_table_says():
    figure = fleet_figure(MODEL, table_of([{}, DRIFTED, APPEARED, UNKNOWN, FAILED]))
    numbers, found, errors, *_ = figure.axes
    assert [label.get_text() for label in numbers.get_yticklabels()][1] == "robot 1"
    assert names(found) == ["Gravity load", "own_effect", "unknown"]
    marks = [(x, y) for line in found.lines for x, y in zip(*line.get_data(), strict=True)]
    assert marks == [(0, 2), (1, 2), (2, 3)]
    assert {line.get_color() for line in found.lines} == {PURPLE}
    (mesh,) = (
        collection for collection in numbers.collections if collection.get_array() is not None
    )
    changes = np.ma.filled(mesh.get_array().reshape(5, -1), np.nan)
    column = names(numbers).index(DAMPING)
    assert np.argwhere(np.isfinite(changes)).tolist() == [[1, column]]
    assert changes[1, column] == pytest.approx(25.0)
    assert texts(numbers) == ["+25 %", "not diagnosed: log.csv: the column is_not_there"]
    assert errors.get_xlabel() == "RMS error (multiples of the noise)"


def test_a_number_that_was_zero_moves_in_its_sigma():
    moved = 0.1 * MODEL.uncertainty_of(SOFT)
    row = {"drifted": SOFT, SOFT: moved}
    numbers = fleet_figure(MODEL, table_of([row])).axes[0]
    assert texts(numbers) == ["+10 %"]


def test_the_least_move_has_a_colour():
    row = {"drifted": DAMPING, DAMPING: 0.1601}
    (mesh,) = (
        collection
        for collection in fleet_figure(MODEL, table_of([row])).axes[0].collections
        if collection.get_array() is not None
    )
    low, high = (mesh.cmap(mesh.norm(share))[:3] for share in (-0.01 * LIMIT, 0.01 * LIMIT))
    assert min(low) < 0.9 > min(high)
    assert low[2] > low[0]
    assert high[0] > high[2]


def test_many_robots_are_drawn_without_numbers_in_cells():
    count = MOST_NUMBERED + 24
    figure = fleet_figure(MODEL, table_of([DRIFTED] * count))
    assert texts(figure.axes[0]) == []
    assert len(figure.axes[0].get_yticklabels()) == count
    assert 8.0 < figure.get_figheight() < 14.0


def test_a_fleet_without_any_diagnosis_is_drawn():
    figure = fleet_figure(MODEL, table_of([FAILED]))
    assert names(figure.axes[1]) == ["none"]
    figure.canvas.draw()


def test_signals_that_were_measured_are_told_apart():
    torque = {"joint_torque_noise_ratio_before": 9.0, "joint_torque_noise_ratio_after": 1.1}
    *_, spare = fleet_figure(MODEL, table_of([torque, {}])).axes
    labels = [label.get_text() for label in spare.get_legend().get_texts()]
    assert labels == ["as given", "improved", "joint position", "joint torque"]


def test_an_error_of_nothing_is_drawn_at_the_end_of_the_scale():
    errors = {"joint_position_noise_ratio_before": 5000.0, "joint_position_noise_ratio_after": 0.0}
    figure = fleet_figure(MODEL, table_of([errors]))
    low, high = figure.axes[2].get_xlim()
    assert 0.0 < low < LEAST < 5000.0 < high


def test_of_very_many_robots_it_says_how_many_differ_in_what():
    half = MOST_ROWS // 2
    table = table_of([DRIFTED] * half + [APPEARED] * half + [FAILED])
    spread, counts, errors = fleet_figure(MODEL, table).axes
    shown = dict(
        zip(
            (label.get_text() for label in counts.get_yticklabels()),
            (bar.get_width() for bar in counts.patches),
            strict=True,
        )
    )
    assert shown["Gravity load"] == shown["own_effect"] == shown[f"{DAMPING} drifted"] == half
    assert shown["not diagnosed"] == 1
    (middle,) = (line.get_xdata()[0] for line in spread.lines if line.get_marker() == "o")
    assert middle == pytest.approx(25.0)
    assert errors.get_xscale() == "log"
