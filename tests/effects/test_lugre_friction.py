"""Bristles that bend further than those of any surface are warned of."""

import pytest

from elastic_tendon.actuator.parameters import load_model

GIVEN = load_model("biorob_x4_joint_3")


@pytest.mark.parametrize(("stiffness", "warned"), [(3.0, True), (300.0, False)])
def test_bristles_that_bend_far_are_warned_of(stiffness: float, warned: bool) -> None:
    values = {
        "coulomb_torque": 0.4,
        "static_torque": 0.4,
        "stribeck_velocity": 0.1,
        "bristle_stiffness": stiffness,
        "bristle_damping": 0.0,
    }
    told = GIVEN.with_effect("lugre_friction", values).warnings()
    assert any("bend by 0.13 rad before they slip" in text for text in told) == warned
