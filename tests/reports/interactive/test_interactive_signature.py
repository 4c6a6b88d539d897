"""The picture of how an effect shows."""

from elastic_tendon import effects
from elastic_tendon.actuator.parameters import load_model
from elastic_tendon.reports.interactive.signature import signature_figure
from elastic_tendon.reports.interactive.theme import DARK
from elastic_tendon.simulation.signature import signature

FRICTION = signature(effects.BY_ID["coulomb_friction"], load_model("biorob_x4_joint_3"))


def test_three_experiments_have_units_and_one_legend() -> None:
    figure = signature_figure(FRICTION, theme=DARK)
    axes = [axis.title.text for axis in (*figure.select_xaxes(), *figure.select_yaxes())]
    assert len(axes) == 6
    assert all("(" in title for title in axes)
    named = [trace.name for trace in figure.data if trace.showlegend is not False]
    assert sorted(named) == ["a tendon falls slack", "motor", "with the effect", "without"]


def test_in_a_narrow_place_stands_the_experiment_that_tells_most() -> None:
    (title,) = signature_figure(FRICTION, telling_only=True).layout.annotations
    assert title.text == "motor step, no load"
    assert FRICTION.step.difference == FRICTION.difference
