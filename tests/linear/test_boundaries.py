"""How far the next switch is, against the paper's limits."""

import pytest
from linear_cases import MODELS, STATES

from elastic_tendon import load_model
from elastic_tendon.actuator.transmission import (
    SlackState,
    characteristic_torque,
    deflection_limits,
    slack_boundaries,
)
from elastic_tendon.linear.linearise import linearise
from elastic_tendon.linear.result import OperatingPoint


def expected(model, deflection):
    """Deflection and load on a boundary of the paper's actuator."""
    return deflection, -float(characteristic_torque(deflection, model.transmission))


@pytest.mark.parametrize("name", MODELS)
def test_between_both_slack_boundaries(name):
    model = load_model(name)
    low, high = linearise(model, "III").validity.boundaries
    for boundary, at in zip((low, high), slack_boundaries(model.transmission), strict=True):
        place = (boundary.deflection, boundary.load_torque)
        assert place == pytest.approx(expected(model, at), rel=1e-8)
        assert (boundary.deflection_margin, boundary.torque_margin) == pytest.approx(
            place, rel=1e-8
        )
    assert (low.switches, low.slack_state) == ({"lower_spring.taut": 0}, SlackState.I)
    assert (high.switches, high.slack_state) == ({"upper_spring.taut": 0}, SlackState.II)


@pytest.mark.parametrize("name", MODELS)
def test_margins_count_from_the_operating_point(name):
    model = load_model(name)
    limit, slack = deflection_limits(model.transmission)[0], slack_boundaries(model.transmission)[0]
    deflection = 0.3 * limit + 0.7 * slack
    point = OperatingPoint(deflection=deflection, motor_position=0.4)
    outer, inner = linearise(model, "I", point).validity.boundaries
    load = expected(model, deflection)[1]
    for boundary, at in ((outer, limit), (inner, slack)):
        there, torque = expected(model, at)
        assert boundary.deflection_margin == pytest.approx(there - deflection, rel=1e-7)
        assert boundary.torque_margin == pytest.approx(torque - load, rel=1e-7)
    assert outer.switches == {"upper_spring.overstretched": 1}
    assert inner.slack_state is SlackState.III


def test_the_next_boundary_is_that_of_an_effect_where_it_is_nearer():
    model = load_model("biorob_x4_joint_3")
    model = model.with_effect("overstretch_protection", {"engagement": 0.5, "stiffness": 2e4})
    outer, _ = linearise(model, "I", OperatingPoint(deflection=-0.12)).validity.boundaries
    assert outer.switches == {"upper_spring.overstretch_protection.engaged": 1}
    # elongation R |δ| + F_p / k is half of l_max
    assert outer.deflection == pytest.approx(-(0.5 * 0.015 - 80.0 / 23160.0) / 0.03)


def test_without_pretension_rest_is_a_boundary_of_the_slack_states():
    model = load_model("biorob_x4_joint_3").with_values({"transmission.pretension_force": 0.0})
    system = linearise(model, "III", OperatingPoint(deflection=0.0))
    assert system.validity.on_boundary
    assert [side.validity.slack_state.name for side in system.sides] == ["I", "II"]


@pytest.mark.parametrize("share", [0.0, 0.3, 0.6, 0.9, 1.0])
@pytest.mark.parametrize("name", MODELS)
def test_any_pretension_has_its_slack_boundaries(name, share):
    """Beyond (30) they lie outside the deflections that the springs bear, (16)."""
    model = load_model(name)
    largest = model.transmission.largest_pretension
    model = model.with_values({"transmission.pretension_force": share * largest})
    low, high = slack_boundaries(model.transmission)
    for state, end in (("I", low), ("II", high)):
        system = linearise(model, state)
        assert system.validity.active
        at = system.validity.operating_point.outputs["deflection"]
        assert at < low if state == "I" else at > high
        inner = [
            boundary for boundary in system.validity.boundaries if "taut" in str(boundary.switches)
        ]
        assert [boundary.deflection for boundary in inner] == pytest.approx(
            [end], rel=1e-6, abs=1e-8
        )


def test_without_pretension_both_tendons_are_never_taut():
    model = load_model("biorob_x4_joint_3").with_values({"transmission.pretension_force": 0.0})
    at_rest = OperatingPoint(deflection=0.0)
    active = {state: linearise(model, state, at_rest).validity.active for state in STATES}
    assert active == {"I": True, "II": True, "III": False, "both": False}


def test_just_beside_a_boundary_counts_as_on_it():
    """Closer than rounding and the dead band of an event tell apart."""
    model = load_model("biorob_x4_joint_3")
    beside = OperatingPoint(deflection=slack_boundaries(model.transmission)[1] + 1e-9)
    for state in ("II", "III"):
        validity = linearise(model, state, beside).validity
        assert validity.active
        assert validity.on_boundary
