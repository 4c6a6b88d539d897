"""Damping that differs by direction, in a machine that an independent simulator plays."""

import numpy as np
import pytest

import elastic_tendon as et
from truth.fast import Inputs, Player

GIVEN = et.load_model("biorob_x4_joint_3")
TIME = np.arange(0.0, 8.0, 0.002)
MOTOR = 0.8 * np.sin(2.3 * TIME) * np.sin(0.9 * TIME + 0.2) + 0.3 * np.sin(5.1 * TIME)
LOAD = 2.0 * np.sin(3.7 * TIME)
NOISE = 1e-4  # rad
DIFFERENCE = 0.12  # N·m·s/rad
RIVALS = ("coulomb_friction", "constant_torque", "quadratic_drag", "directional_damping")


@pytest.fixture(scope="module")
def recording():
    tree = GIVEN.model_dump(exclude_none=True)
    tree["effects"] = {"directional_damping": {"difference": DIFFERENCE}}
    joint = Player(Inputs(TIME, MOTOR, LOAD)).run(tree, (0.0, 0.0)).joint_position
    noisy = joint + NOISE * np.random.default_rng(3).standard_normal(len(TIME))
    return et.Measurement(
        TIME, MOTOR, {"joint_position": noisy}, load_torque=LOAD, interpolation="cubic"
    )


def test_it_is_found_among_its_rivals_where_it_is_asked_for(recording):
    found = et.diagnose(GIVEN, recording, options=et.Options(only=RIVALS))
    assert found.added == ("directional_damping",)
    fitted = found.model.effects["directional_damping"]["difference"]
    assert fitted == pytest.approx(DIFFERENCE, rel=0.05)
    assert found.ladder[-1].noise_ratio["joint_position"] < 1.1
