"""Interactive figures of a diagnosis: units, the diagnosis's own numbers, and both themes."""

from dataclasses import replace
from functools import cache

import numpy as np
import plotly.graph_objects as go
import pytest

from elastic_tendon.diagnosis.explained import explained_by_effect
from elastic_tendon.diagnosis.result import Experiment
from elastic_tendon.linear.linearise import linearise
from elastic_tendon.linear.result import Drive, LinearModel
from elastic_tendon.reports.interactive.bode import bode
from elastic_tendon.reports.interactive.candidates import candidates
from elastic_tendon.reports.interactive.experiment import experiment
from elastic_tendon.reports.interactive.explained import explained
from elastic_tendon.reports.interactive.ladder import ladder
from elastic_tendon.reports.interactive.overlay import Run
from elastic_tendon.reports.interactive.residual import residual
from elastic_tendon.reports.interactive.theme import DARK, LIGHT, Theme
from hand_made_diagnosis import COULOMB, friction_found, next_experiment

POSITION = "joint_position"
STATES = ("I", "II", "III")


@cache
def linear_models() -> list[tuple[str, dict[str, LinearModel]]]:
    found = friction_found()
    return [
        (label, {state: linearise(model, state, drive=Drive.POSITION) for state in STATES})
        for label, model in (("as given", found.given), ("<b>improved</b>", found.model))
    ]


def figures(theme: Theme) -> dict[str, go.Figure]:
    found = friction_found()
    return {
        "ladder": ladder(found.ladder, POSITION, theme=theme),
        "candidates": candidates(found.rounds[0], theme=theme),
        "explained": explained(explained_by_effect(found, COULOMB), "<i>it</i>", theme=theme),
        "experiment": experiment(next_experiment(), theme=theme),
        "bode": bode(linear_models(), theme=theme),
        "residual": residual(Run("improved", found.comparison.files[0]), POSITION, theme=theme),
    }


@pytest.mark.parametrize("theme", [LIGHT, DARK], ids=lambda theme: theme.name)
def test_every_axis_with_a_title_has_a_unit(theme: Theme) -> None:
    for name, figure in figures(theme).items():
        axes = [*figure.select_xaxes(), *figure.select_yaxes()]
        titles = [axis.title.text for axis in axes if axis.title.text]
        assert titles, name
        assert all("(" in title for title in titles), titles
        assert figure.layout.template.layout.font.color == theme.ink


def test_texts_of_users_are_no_markup() -> None:
    drawn = figures(LIGHT)
    assert drawn["explained"].layout.title.text == "&lt;i&gt;it&lt;/i&gt;"
    assert {trace.name for trace in drawn["bode"].data} == {
        "as given",
        "&lt;b&gt;improved&lt;/b&gt;",
    }
    steps = [replace(step, title="<b>up</b>") for step in friction_found().ladder]
    labels = ladder(steps, POSITION).layout.xaxis.ticktext
    assert set(labels) == {"&lt;b&gt;up&lt;/b&gt;"}


def test_the_ladder_falls_to_the_floor() -> None:
    found = friction_found()
    fitted, heldout, floor = ladder(found.ladder, POSITION).data
    assert fitted.y == pytest.approx([1e3 * step.rmse[POSITION] for step in found.ladder])
    assert heldout.y == pytest.approx([1e3 * step.heldout_rmse[POSITION] for step in found.ladder])
    assert floor.y[0] == pytest.approx(1e3 * found.noise[POSITION].sigma)
    assert floor.text[0].startswith("noise floor, 0.23")
    # where two lines meet, the labels stand on both sides
    for below, above in zip(fitted.textposition, heldout.textposition, strict=True):
        assert below.split()[0] != above.split()[0]


@pytest.mark.parametrize("last", [0.0, 1e-9])
def test_an_error_of_nothing_has_its_place_on_the_ladder(last: float) -> None:
    steps = [*friction_found().ladder]
    steps[-1] = replace(
        steps[-1], rmse={POSITION: last}, noise_ratio={POSITION: 0.0}, heldout_rmse={}
    )
    figure = ladder(steps, POSITION)
    fitted = figure.data[0]
    low, high = figure.layout.yaxis.range
    assert fitted.text[-1] == ("0" if last == 0.0 else "1.00e-06")
    assert all(low <= np.log10(value) <= high for value in fitted.y)


def test_a_recording_without_any_error_has_a_ladder() -> None:
    nothing = {"rmse": {POSITION: 0.0}, "noise_ratio": {POSITION: 0.0}, "heldout_rmse": {}}
    figure = ladder([replace(friction_found().ladder[0], **nothing)], POSITION)
    assert figure.data[0].text == ("0",)


def test_bars_are_the_candidates_the_chosen_one_stands_out() -> None:
    likely, fitted, heldout = candidates(friction_found().rounds[0]).data
    assert likely.x[:2] == pytest.approx([93.0, 7.0])
    assert likely.y[-1] == "none of them"
    assert list(likely.marker.color).count(LIGHT.ink) == 1
    assert fitted.x[:2] == pytest.approx([98.4, 98.4])
    assert heldout.x[:2] == pytest.approx([97.9, 97.9])
    assert fitted.x[2] is None  # it was not refitted


@pytest.mark.parametrize("gain", [None, 1e-9])
def test_without_any_gain_there_is_one_panel(gain: float | None) -> None:
    first = friction_found().rounds[0]
    unknown = [replace(candidate, gain=gain, heldout_gain=None) for candidate in first.candidates]
    figure = candidates(replace(first, candidates=tuple(unknown)))
    assert len(figure.data) == 1
    assert len(list(figure.select_xaxes())) == 1


def test_ruined_held_out_data_do_not_hide_the_rest() -> None:
    first = friction_found().rounds[0]
    ruined = replace(first.candidates[0], heldout_gain=-40.0)
    figure = candidates(replace(first, candidates=(ruined, *first.candidates[1:])))
    assert figure.data[2].x[0] == -100.0
    assert figure.layout.xaxis2.range[0] == pytest.approx(-105.0)


def test_the_effect_lies_over_what_was_measured_and_little_remains() -> None:
    figure = figures(LIGHT)["explained"]
    mean, left = (trace for trace in figure.data if trace.mode == "lines")
    x, y = np.array(mean.x), np.array(mean.y)
    assert y[x > 1.0] == pytest.approx(-0.35, abs=0.06)
    assert y[x < -1.0] == pytest.approx(0.35, abs=0.06)
    assert np.max(np.abs(np.array(left.y))) < 0.01


def test_responses_have_a_column_for_each_state_and_peak_where_the_poles_are() -> None:
    figure = figures(LIGHT)["bode"]
    assert [annotation.text for annotation in figure.layout.annotations] == [
        "state I, lower slack",
        "state II, upper slack",
        "state III, both taut",
    ]
    model = linear_models()[0][1]["III"]
    magnitude = next(
        trace for trace in figure.data if (trace.name, trace.yaxis) == ("as given", "y3")
    )
    peak = magnitude.x[int(np.argmax(magnitude.y))]
    assert peak == pytest.approx(np.abs(model.poles()).max(), rel=0.02)
    assert np.array(magnitude.y)[0] == pytest.approx(1.0, abs=0.02)  # slowly, the joint follows


def test_a_state_without_a_model_is_left_out() -> None:
    (label, models), _ = linear_models()
    figure = bode([(label, {"II": models["II"]})])
    assert [annotation.text for annotation in figure.layout.annotations] == [
        "state II, upper slack"
    ]


def titles_beside(proposed: Experiment) -> list[str]:
    titles = [axis.title.text for axis in experiment(proposed).select_yaxes()]
    return [title.replace("<br>", " ") for title in titles]


def test_an_experiment_is_drawn_with_its_load_only_where_one_is_to_act() -> None:
    alone = replace(next_experiment(), predictions={})
    assert titles_beside(alone) == ["motor position (rad)"]
    loaded = replace(alone, load_torque=np.sin(alone.time))
    assert titles_beside(loaded) == ["motor position (rad)", "load torque (N·m)"]


def test_an_experiment_shows_what_each_answer_predicts_and_by_how_much_they_differ() -> None:
    proposed = next_experiment()
    assert titles_beside(proposed)[1:] == [
        "predicted joint position (rad)",
        "difference from Coulomb friction (mrad)",
    ]
    figure = experiment(proposed)
    coulomb, lugre = figure.select_traces({"yaxis": "y3"})
    assert (coulomb.name, lugre.name) == ("Coulomb friction", "LuGre friction")
    assert not np.any(coulomb.y)
    np.testing.assert_allclose(lugre.y, 1e3 * 0.02 * proposed.motor_position)
    assert [trace.name for trace in figure.data if trace.showlegend] == [coulomb.name, lugre.name]


def test_the_error_alone_has_the_noise_behind_it() -> None:
    file = friction_found().comparison.files[0]
    figure = residual(Run("improved", file), POSITION)
    (band,) = figure.layout.shapes
    assert band.y1 == pytest.approx(2e3 * file.signals[POSITION].noise.sigma)
    assert max(np.abs(figure.data[0].y)) == pytest.approx(1e3 * file.signals[POSITION].max_abs)
