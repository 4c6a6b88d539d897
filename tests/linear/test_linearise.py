"""Linear models against the paper's closed forms, and where they say they hold."""

import numpy as np
import pytest
from linear_cases import MODELS, STATES, closed_form, damped, with_typical

from effects_at import placed
from elastic_tendon import load_model
from elastic_tendon.actuator.transmission import SlackState, slack_boundaries
from elastic_tendon.effects import BY_ID
from elastic_tendon.errors import LinearisationError
from elastic_tendon.linear.linearise import linearise
from elastic_tendon.linear.result import Drive, OperatingPoint


@pytest.mark.parametrize("state", STATES)
@pytest.mark.parametrize("name", MODELS)
def test_matrices_are_those_of_the_paper(name, state):
    model = damped(name)
    stiffness, damping = closed_form(model, state)
    t, link = model.transmission, model.link
    ratio = t.motor_pulley_radius / t.joint_pulley_radius
    system = linearise(model, state, outputs=["joint_torque", "deflection", "motor_torque"])
    A = [[0, 1], [-stiffness / link.inertia, -(damping + link.damping) / link.inertia]]
    B = [[0, 0, 0], np.array([ratio * stiffness, ratio * damping, 1.0]) / link.inertia]
    torque = [-stiffness, -damping, ratio * stiffness, ratio * damping, 0.0]
    seen = [torque, [1, 0, -ratio, 0, 0], [ratio * part for part in torque]]
    assert np.allclose(system.A, A, rtol=1e-12, atol=0)
    assert np.allclose(system.B, B, rtol=1e-12, atol=0)
    assert np.allclose(np.hstack([system.C, system.D]), seen, rtol=1e-11, atol=1e-12)


@pytest.mark.parametrize("state", STATES)
@pytest.mark.parametrize("name", MODELS)
def test_poles_are_those_of_a_damped_oscillator(name, state):
    model = damped(name)
    stiffness, damping = closed_form(model, state)
    polynomial = [model.link.inertia, damping + model.link.damping, stiffness]
    expected = np.sort_complex(np.roots(polynomial))
    assert np.allclose(np.sort_complex(linearise(model, state).poles()), expected, rtol=1e-9)


def test_names_are_those_of_the_fmu():
    system = linearise(load_model("biorob_x4_joint_3"), "III")
    assert system.input_labels == ["motor_position", "motor_velocity", "load_torque"]
    assert system.state_labels == ["joint_position", "joint_velocity"]
    assert system.output_labels == [
        *("joint_torque", "joint_position", "joint_velocity", "deflection", "motor_torque"),
        *("upper_spring_force", "lower_spring_force"),
    ]
    assert system["deflection", "load_torque"].dcgain() > 0.0


@pytest.mark.parametrize("name", MODELS)
def test_each_state_has_a_point_of_its_own(name):
    model = load_model(name)
    low, high = slack_boundaries(model.transmission)
    for state in STATES[:3]:
        validity = linearise(model, state).validity
        assert validity.active
        assert validity.operating_point.slack_state.name == state
        deflection = validity.operating_point.outputs["deflection"]
        assert {"I": deflection < low, "II": deflection > high, "III": deflection == 0.0}[state]
    assert not linearise(model, "both").validity.active


def test_a_state_that_is_not_active_is_said_not_to_be():
    model = load_model("biorob_x4_joint_3")
    point = OperatingPoint(load_torque=7.0)
    found = {state: linearise(model, state, point).validity for state in STATES}
    assert {state: linear.active for state, linear in found.items()} == {
        "I": False,
        "II": True,
        "III": False,
        "both": False,
    }
    for linear in found.values():
        assert linear.operating_point.slack_state is SlackState.II
        assert linear.operating_point.outputs["joint_torque"] == pytest.approx(-7.0)


@pytest.mark.parametrize(("end", "beyond"), [(0, "I"), (1, "II")])
@pytest.mark.parametrize("name", MODELS)
def test_on_a_boundary_both_sides_are_given(name, end, beyond):
    model = load_model(name)
    point = OperatingPoint(deflection=slack_boundaries(model.transmission)[end])
    system = linearise(model, "III", point)
    assert system.validity.on_boundary
    assert system.validity.active
    expected = [beyond, "III"] if end == 0 else ["III", beyond]
    assert [side.validity.slack_state.name for side in system.sides] == expected
    for side in system.sides:
        stiffness, _ = closed_form(model, side.validity.slack_state.name)
        assert side.A[1, 0] == pytest.approx(-stiffness / model.link.inertia, rel=1e-12)
        assert side.validity.active
        assert side.validity.on_boundary
    assert not linearise(model, "both", point).validity.active


def test_a_model_of_one_side_ends_at_the_boundary():
    model = load_model("biorob_x4_joint_3")
    low, high = slack_boundaries(model.transmission)
    taut, slack = linearise(model, "III", OperatingPoint(deflection=high)).sides
    below, here = taut.validity.boundaries
    assert (below.deflection_margin, here.deflection_margin) == (pytest.approx(low - high), 0.0)
    assert here.switches == {"upper_spring.taut": 0}
    here, above = slack.validity.boundaries
    assert here.deflection_margin == 0.0
    assert here.switches == {"upper_spring.taut": 1}
    assert here.slack_state is SlackState.III
    assert above.switches == {"lower_spring.overstretched": 1}
    assert linearise(model, "III", OperatingPoint(deflection=high)).validity.boundaries == (
        taut.validity.boundaries
    )


def test_what_sticks_sticks_on_both_sides():
    model = load_model("biorob_x4_joint_3").with_effect("coulomb_friction", {"torque": 0.35})
    point = OperatingPoint(deflection=slack_boundaries(model.transmission)[0])
    for motion in (-1, 0, 1):
        sides = linearise(model, "III", point, modes={"joint_motion": motion}).sides
        assert [side.validity.modes["joint_motion"] for side in sides] == [motion, motion]


def test_off_a_boundary_there_are_no_sides():
    model = load_model("biorob_x4_joint_3")
    at = slack_boundaries(model.transmission)[0]
    for deflection in (at - 1e-6, at + 1e-6):
        system = linearise(model, "III", OperatingPoint(deflection=deflection))
        assert not system.sides
        assert not system.validity.on_boundary
        assert system.validity.active is (deflection > at)


def test_protection_engaged():
    model = load_model("biorob_x4_joint_3")
    model = model.with_effect("overstretch_protection", {"engagement": 0.8, "stiffness": 2e4})
    engaged = {"upper_spring.overstretch_protection.engaged": 1}
    system = linearise(model, "I", modes=engaged)
    assert system.validity.active
    assert engaged.items() <= system.validity.modes.items()
    # two springs side by side, each with its protection
    stiffness = 0.03**2 * 2 * (11580.0 + 2e4)
    assert system.A[1, 0] == pytest.approx(-stiffness / 0.03)


def test_joint_stop_is_found_along_the_joint():
    model = with_typical(load_model("biorob_x4_joint_3"), "joint_stop")
    mode = next(mode for mode in linearise(model, "III").validity.modes if "joint_stop" in mode)
    system = linearise(model, "III", modes={mode: 1})
    assert system.validity.active
    free = linearise(model, "III")
    assert system.A[1, 0] < 2 * free.A[1, 0] < 0.0


def test_sticking_and_sliding():
    model = load_model("biorob_x4_joint_3").with_effect("coulomb_friction", {"torque": 0.35})
    sliding = linearise(model, "III")
    bare = linearise(load_model("biorob_x4_joint_3"), "III")
    assert np.allclose(sliding.A, bare.A)
    assert sliding.validity.modes["joint_motion"] == 1
    sticking = linearise(model, "III", modes={"joint_motion": 0})
    assert not sticking.A.any()
    assert not sticking.B.any()
    assert sticking.validity.active
    breakaway = [
        boundary
        for boundary in sticking.validity.boundaries
        if boundary.switches.get("joint_motion") is not None
    ]
    assert [boundary.torque_margin for boundary in breakaway] == pytest.approx([-0.35, 0.35])
    assert not sticking.validity.on_boundary


@pytest.mark.parametrize("load", [-7.0, 0.0, 7.0])
def test_a_joint_at_rest_sticks_in_every_slack_state(load):
    model = load_model("biorob_x4_joint_3").with_effect("coulomb_friction", {"torque": 0.35})
    state = {-7.0: "I", 0.0: "III", 7.0: "II"}[load]
    validity = linearise(model, state, OperatingPoint(load_torque=load)).validity
    assert validity.active
    assert validity.operating_point.modes["joint_motion"] == 0
    margins = [
        boundary.torque_margin
        for boundary in validity.boundaries
        if "joint_motion" in boundary.switches
    ]
    assert margins == pytest.approx([-0.35, 0.35])


def test_steady_motion_has_the_slope_of_its_friction():
    model = with_typical(load_model("biorob_x4_joint_3"), "stribeck_friction")
    system = linearise(model, "III", OperatingPoint(joint_velocity=0.05))
    assert system.validity.modes["joint_motion"] == 1
    still = linearise(model, "III")
    assert system.A[1, 1] != pytest.approx(still.A[1, 1], rel=1e-3)
    back = linearise(model, "III", OperatingPoint(joint_velocity=-0.05))
    assert back.validity.modes["joint_motion"] == -1
    assert back.A[1, 1] == pytest.approx(system.A[1, 1])


@pytest.mark.parametrize("effect_id", sorted(BY_ID))
def test_every_effect_is_linearised(effect_id):
    model = with_typical(placed(damped("biorob_x4_joint_3"), effect_id), effect_id)
    for asked in (None, OperatingPoint(load_torque=6.5), OperatingPoint(joint_velocity=0.5)):
        system = linearise(model, "III", asked)
        assert np.isfinite(system.A).all()
        validity = system.validity
        expected = "II" if asked and asked.load_torque else "III"
        assert validity.operating_point.slack_state.name == expected
        assert validity.active is (expected == "III")
        assert any(
            "taut" in name for boundary in validity.boundaries for name in boundary.switches
        ) or ("backlash" in effect_id)


def test_names_selected_keep_the_order_in_which_they_are_asked_for():
    model = damped("figure_7")
    whole = linearise(model, "II")
    part = linearise(model, "II", inputs=["load_torque", "motor_position"], outputs=["deflection"])
    assert part.input_labels == ["load_torque", "motor_position"]
    assert np.array_equal(part.B, whole.B[:, [2, 0]])
    assert np.array_equal(part.C, whole.C[[3]])
    assert np.array_equal(part.D, whole.D[[3]][:, [2, 0]])


@pytest.mark.parametrize("source", ["figure_7", "actuator.fmu"])
def test_a_path_is_not_a_model(source):
    with pytest.raises(LinearisationError, match=f"{source}: linearise takes a model.*_fmu"):
        linearise(source, "III")


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        ({"state": "IV"}, "no slack state 'IV'; choose I, II, III, both"),
        ({"inputs": ["torque"]}, "no input 'torque' with this drive; there are motor_position"),
        ({"outputs": ["slack_state"]}, "no output 'slack_state'"),
        ({"outputs": ["deflection", "deflection"]}, "output deflection stands twice"),
        ({"drive": Drive.TORQUE}, "needs \\[motor\\] in model.toml"),
        ({"modes": {"sticking": 1}}, "no mode 'sticking'; there are upper_spring.taut"),
        ({"modes": {"upper_spring.taut": 2}}, "upper_spring.taut is one of 0, 1, not 2"),
    ],
)
def test_wrong_arguments_are_told(arguments, told):
    with pytest.raises(LinearisationError, match=told):
        linearise(load_model("figure_7"), **{"state": "III", **arguments})
