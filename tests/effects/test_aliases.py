"""Aliases that effects declare: what they say cannot be told apart gives the same measurement."""

import numpy as np
import pytest
from contract_cases import LOAD, MOTOR, PAPER, TIME

from elastic_tendon.actuator.transmission import characteristic_stiffness
from elastic_tendon.effects import BY_ID, CATALOGUE
from elastic_tendon.simulation.simulate import simulate

AGREEMENT = 1e-9  # rad, of two integrators at 1e-11
OFFSET = 0.05  # rad at the motor pulley

GEARED = PAPER.with_values({"transmission.motor_pulley_radius": 0.02})


def measured(model, **options):
    options = {"load_torque": LOAD, "as_measured": True, "tolerance": 1e-11} | options
    motion = simulate(model, TIME, MOTOR, **options)
    return motion[motion.measured("joint_position")]


def with_offsets(model):
    """The same misalignment, at the motor's encoder and at the joint's; what each measures."""
    at_joint = -OFFSET * 0.02 / 0.03
    motor = model.with_effect("motor_encoder_offset", {"offset": OFFSET})
    joint = model.with_effect("joint_encoder_offset", {"offset": at_joint})
    # the joint rests where the motor truly is
    start = {"joint_position": at_joint}
    return measured(motor, initial_state=start), measured(joint)


def test_encoder_offsets_are_the_same_once_the_start_is_free():
    at_motor, at_joint = with_offsets(GEARED)
    assert np.abs(at_motor - measured(GEARED)).max() > 0.5 * OFFSET
    assert np.abs(at_motor - at_joint).max() < AGREEMENT


@pytest.mark.parametrize(
    ("effect", "numbers"),
    [
        ("gravity_load", {"torque": 2.0, "angle": 0.3}),
        # alike, but simulated for seconds: studies
        pytest.param(
            *("joint_stop", {"lower": -0.3, "upper": 0.3, "stiffness": 500.0}),
            marks=pytest.mark.slow,
        ),
        pytest.param(
            *("pulley_eccentricity", {"amplitude": 0.1, "phase": 0.4}), marks=pytest.mark.slow
        ),
    ],
)
def test_encoder_offsets_differ_where_an_effect_knows_the_angle(effect, numbers):
    at_motor, at_joint = with_offsets(GEARED.with_effect(effect, numbers))
    assert np.abs(at_motor - at_joint).max() > 1e-4


SHARE = 0.05


def test_a_gain_of_the_motors_encoder_is_a_smaller_pulley():
    gain = measured(GEARED.with_effect("motor_encoder_gain", {"error": SHARE}))
    smaller = GEARED.with_values({"transmission.motor_pulley_radius": 0.02 / (1.0 + SHARE)})
    assert np.abs(gain - measured(GEARED)).max() > 1e-2
    assert np.abs(gain - measured(smaller)).max() < AGREEMENT


def gains(model):
    """Measured with a gain of the joint's encoder, and with the motor's that looks like it."""
    damped = {f"transmission.{side}_spring.damping": 30.0 for side in ("upper", "lower")}
    model = model.with_values(damped)
    both = ("stiffness", "damping")
    paths = [f"transmission.{side}_spring.{of}" for side in ("upper", "lower") for of in both]
    smaller = {
        path: model.values()[path] / (1.0 + SHARE)
        for path in (*paths, "link.inertia", "link.damping")
    }
    other = {"error": -SHARE / (1.0 + SHARE)}
    joint = model.with_effect("joint_encoder_gain", {"error": SHARE})
    return [measured(joint)] + [
        measured(one.with_effect("motor_encoder_gain", other))
        for one in (model.with_values(smaller), model)
    ]


def test_gains_of_both_encoders_are_the_same_where_stiffness_and_inertia_are_free():
    joint, motor, known = gains(GEARED)
    assert np.abs(joint - motor).max() < AGREEMENT
    assert np.abs(joint - known).max() > 1e-3


def test_gains_of_the_encoders_differ_where_an_effect_knows_the_angle():
    joint, motor, _ = gains(GEARED.with_effect("gravity_load", {"torque": 2.0, "angle": 0.3}))
    assert np.abs(joint - motor).max() > 1e-4


def softer(model, compliance):
    """The springs that are as soft as springs and tendons together."""
    values = {}
    for side in ("upper", "lower"):
        spring = getattr(model.transmission, f"{side}_spring")
        together = 1 + compliance * spring.combined_stiffness
        values[f"transmission.{side}_spring.stiffness"] = spring.stiffness / together
    return model.with_values(values)


def compliant_and_softer(model):
    compliance = 8e-6
    tendon = model.with_effect("tendon_compliance", {"compliance": compliance})
    return measured(tendon), measured(softer(model, compliance))


def test_tendon_compliance_is_softer_springs_without_damping():
    tendon, springs = compliant_and_softer(GEARED)
    assert np.abs(tendon - measured(GEARED)).max() > 1e-2
    assert np.abs(tendon - springs).max() < AGREEMENT


def test_tendon_compliance_differs_with_damping():
    damping = {f"transmission.{side}_spring.damping": 30.0 for side in ("upper", "lower")}
    tendon, springs = compliant_and_softer(GEARED.with_values(damping))
    assert np.abs(tendon - springs).max() > 1e-4


def test_tendon_compliance_differs_with_hardening_springs():
    hard = GEARED.with_effect("spring_hardening", {"cubic_stiffness": 5e7})
    tendon, springs = compliant_and_softer(hard)
    assert np.abs(tendon - springs).max() > 1e-4


def rubbing(wrap, pretension):
    """Measured with friction of the guides, and with the joint's beside stiffer springs."""
    model = GEARED.with_values({"transmission.pretension_force": pretension})
    guides = model.with_effect("tendon_guide_friction", {"wrap_friction": wrap})
    stiffer = {
        path: np.cosh(wrap) * model.values()[path]
        for path in (f"transmission.{side}_spring.stiffness" for side in ("upper", "lower"))
    }
    torque = 2.0 * model.values()["transmission.joint_pulley_radius"] * np.sinh(wrap) * pretension
    joint = model.with_values(stiffer).with_effect("coulomb_friction", {"torque": torque})
    return measured(guides), measured(joint)


def test_friction_of_guides_is_that_of_the_joint_while_both_tendons_are_taut():
    guides, joint = rubbing(0.1, 300.0)
    assert np.abs(guides - measured(GEARED)).max() > 1e-2
    assert np.abs(guides - joint).max() < AGREEMENT


def test_friction_of_guides_differs_where_a_tendon_is_slack():
    guides, joint = rubbing(0.1, 20.0)
    assert np.abs(guides - joint).max() > 1e-4


def pulled(pretension):
    """Measured with a constant torque, and with the joint's encoder off by what that deflects."""
    model = GEARED.with_values({"transmission.pretension_force": pretension})
    offset = 0.1 * OFFSET
    stiffness = float(characteristic_stiffness(0.0, model.transmission))
    torque = model.with_effect("constant_torque", {"torque": offset * stiffness})
    zero = model.with_effect("joint_encoder_offset", {"offset": offset})
    return measured(torque, initial_state={"joint_position": offset}), measured(zero)


def test_a_constant_torque_is_an_encoder_offset_while_both_tendons_are_taut():
    torque, zero = pulled(300.0)
    assert np.abs(torque - measured(GEARED)).max() > 1e-3
    assert np.abs(torque - zero).max() < AGREEMENT


def test_a_constant_torque_is_no_offset_where_a_tendon_is_slack():
    torque, zero = pulled(20.0)
    assert np.abs(torque - zero).max() > 1e-4


@pytest.mark.parametrize("effect", CATALOGUE, ids=lambda effect: effect.id)
def test_aliases_exist_and_are_declared_once_and_told_of_both(effect):
    for alias in effect.aliases:
        assert alias.when
        for rival in alias.of:
            if rival in BY_ID:
                assert any(effect.id in back.of for back in BY_ID.aliases_of(BY_ID[rival]))
                assert not any(effect.id in back.of for back in BY_ID[rival].aliases)
            else:
                assert rival in PAPER.values()
