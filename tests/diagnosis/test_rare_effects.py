"""Effects that are tried on request, in machines that an independent simulator plays."""

import numpy as np
import pytest

import elastic_tendon as et
from elastic_tendon.effects import BY_ID
from truth.fast import Inputs, Player

GIVEN = et.load_model("biorob_x4_joint_3")
TIME = np.arange(0.0, 8.0, 0.002)
MOTOR = 0.8 * np.sin(2.3 * TIME) * np.sin(0.9 * TIME + 0.2) + 0.3 * np.sin(5.1 * TIME)
LOAD = 2.0 * np.sin(3.7 * TIME)
NOISE = 1e-4  # rad
HIDDEN = {
    "directional_damping": {"difference": 0.12},
    "cubic_damping": {"coefficient": 0.01},
    "spring_asymmetry": {"square_stiffness": 2e5},
    "joint_encoder_gain": {"error": 0.03},
    "motor_encoder_gain": {"error": -0.04},
}
RIVALS = ("coulomb_friction", "constant_torque", "quadratic_drag", "spring_hardening")


def recorded(effects: dict) -> et.Measurement:
    """A recording of the machine that is as given but for these effects."""
    tree = GIVEN.model_dump(exclude_none=True) | {"effects": effects}
    joint = Player(Inputs(TIME, MOTOR, LOAD)).run(tree, (0.0, 0.0)).joint_position
    noisy = joint + NOISE * np.random.default_rng(3).standard_normal(len(TIME))
    return et.Measurement(
        TIME, MOTOR, {"joint_position": noisy}, load_torque=LOAD, interpolation="cubic"
    )


@pytest.mark.parametrize("effect_id", HIDDEN)
def test_it_is_found_among_its_rivals_where_it_is_asked_for(effect_id):
    recording = recorded({effect_id: HIDDEN[effect_id]})
    assert BY_ID[effect_id].on_request
    found = et.diagnose(GIVEN, recording, options=et.Options(only=(*RIVALS, effect_id)))
    assert found.added == (effect_id,)
    ((name, value),) = HIDDEN[effect_id].items()
    assert found.model.effects[effect_id][name] == pytest.approx(value, rel=0.05)
    assert found.ladder[-1].noise_ratio["joint_position"] < 1.1


GAINS = ("joint_encoder_gain", "motor_encoder_gain")


def test_gains_of_two_encoders_are_told_together():
    """As long as stiffness and inertia are free, nothing tells one from the other."""
    recording = recorded({GAINS[1]: HIDDEN[GAINS[1]]})
    found = et.diagnose(GIVEN, recording, options=et.Options(only=(*RIVALS, *GAINS)))
    assert len(found.added) == 1
    assert found.indistinguishable == (GAINS,)
