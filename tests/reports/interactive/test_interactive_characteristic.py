"""The interactive characteristic shows what `design` computes."""

import numpy as np

from elastic_tendon.actuator.parameters import load_model
from elastic_tendon.actuator.transmission import deflection_limits, slack_boundaries
from elastic_tendon.reports.interactive.characteristic import characteristic
from elastic_tendon.reports.interactive.theme import DARK

MODEL = load_model("figure_7")


def traces(figure) -> dict:
    return {trace.name: trace for trace in figure.data}


def test_boundaries_and_limits_stand_where_the_paper_has_them() -> None:
    drawn = traces(characteristic(MODEL))
    np.testing.assert_allclose(
        drawn["slack boundary (14)"].x, slack_boundaries(MODEL.transmission), rtol=1e-12
    )
    np.testing.assert_allclose(
        drawn["largest deflection (16)"].x, deflection_limits(MODEL.transmission), rtol=1e-12
    )
    assert "as loaded" not in drawn


def test_states_are_named_from_left_to_right() -> None:
    figure = characteristic(MODEL, theme=DARK)
    named = sorted(figure.layout.annotations, key=lambda label: label.x)
    assert [label.text for label in named] == [
        "I: lower<br>tendon slack",
        "III: both<br>tendons taut",
        "II: upper<br>tendon slack",
    ]
    assert figure.layout.xaxis.title.text.endswith("(rad)")


def test_without_a_boundary_within_the_limits_both_tendons_are_taut_everywhere() -> None:
    taut = MODEL.with_values({"transmission.pretension_force": 80.0})
    figure = characteristic(taut)
    assert [annotation.text for annotation in figure.layout.annotations] == [
        "III: both<br>tendons taut"
    ]
    assert "slack boundary (14)" not in traces(figure)


def test_the_curve_as_loaded_is_dashed_where_it_differs() -> None:
    stiffer = MODEL.with_values({"transmission.upper_spring.stiffness": 3e4})
    figure = characteristic(stiffer, given=MODEL)
    loaded = traces(figure)["as loaded"]
    for axis, values in ((figure.layout.xaxis, loaded.x), (figure.layout.yaxis, loaded.y)):
        assert axis.range[0] < np.min(values) < np.max(values) < axis.range[1]
    heavier = MODEL.with_values({"link.inertia": 0.05})
    assert "as loaded" not in traces(characteristic(heavier, given=MODEL))


def test_a_narrow_state_has_its_numeral_alone() -> None:
    figure = characteristic(MODEL.with_values({"transmission.pretension_force": 5.0}))
    assert "III" in [annotation.text for annotation in figure.layout.annotations]
