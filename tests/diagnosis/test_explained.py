"""What an effect explains, beside the torque that is missing without it."""

import numpy as np
import pytest

from elastic_tendon.diagnosis.explained import explained
from hand_made_diagnosis import COULOMB, TORQUE, friction_found


@pytest.fixture(scope="module")
def found():
    diagnosis = friction_found()
    bare = diagnosis.model.without([COULOMB])
    return explained(bare, diagnosis.comparison.files[0], diagnosis.model)


def test_friction_is_ordered_by_the_velocity(found) -> None:
    assert (found.by, found.unit) == ("joint_velocity", "rad/s")


def test_measured_and_modelled_torque_agree_with_the_law(found) -> None:
    size = friction_found().model.values()[TORQUE]
    for variable, torque in (
        (found.variable, found.measured.torque),
        (found.modelled_variable, found.modelled.torque),
    ):
        fast = np.abs(variable) > 0.5
        assert np.mean(torque[fast] * np.sign(variable[fast])) == pytest.approx(-size, rel=0.03)


def test_little_remains(found) -> None:
    assert np.std(found.remaining.torque) < 0.05 * np.std(found.measured.torque)


def test_only_the_effect_is_taken_out() -> None:
    model = friction_found().model
    bare = model.without([COULOMB])
    kept = {path: value for path, value in model.values().items() if path != TORQUE}
    assert bare.values() == kept
    assert TORQUE in model.uncertainty
    assert bare.uncertainty_of("link.inertia") == model.uncertainty_of("link.inertia")
