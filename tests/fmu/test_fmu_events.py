"""Event mode of model exchange: relations are frozen outside it and settle inside it."""

from ctypes import POINTER, c_double

import numpy as np
import pytest
from fmu_cases import BOTH

from fmu_driver import ERROR

pytestmark = BOTH

SLACK_AT = 80.0 / (0.03 * 2 * 11580.0)  # rad, (13): deflection at which a tendon is slack


@pytest.fixture
def model(base, instances):
    model = instances(base.model())
    model.begin()
    return model


@pytest.fixture
def sticking(fmus, instances):
    model = instances(fmus("effects").model())
    model.begin()
    return model


def test_relations_are_frozen_in_continuous_time(model):
    taut = model.indicators()
    model.move(1.5 * SLACK_AT, 0.0)
    assert ((model.indicators() > 0) != (taut > 0)).sum() == 1
    assert model.get("slack_state") == 3
    smooth = model.get("joint_torque")  # of a spring that pushes beyond the border
    model.fmu.enterEventMode()
    assert model.get("slack_state") == 3
    model.iterate_events()
    assert model.get("slack_state") == 2
    assert abs(model.get("joint_torque")) < abs(smooth)


def test_indicator_changes_sign_where_the_tendon_slackens(model):
    signs = []
    for deflection in (SLACK_AT * (1 - 1e-6), SLACK_AT * (1 + 1e-6)):
        model.move(deflection, 0.0)
        signs.append(model.indicators() > 0)
    assert (signs[0] != signs[1]).sum() == 1


def test_no_indicator_is_zero_after_an_event_on_the_border(model):
    """An integrator that stops exactly on the border goes on without the event repeating."""
    model.move(SLACK_AT, 0.3)
    model.fmu.enterEventMode()
    model.iterate_events()
    before = model.indicators()
    assert (np.abs(before) > 1e-11).all()
    model.move(SLACK_AT * (1 + 1e-12), 0.3)
    assert ((model.indicators() > 0) == (before > 0)).all()


def test_event_information(model):
    """Two calls: one that changes relations, one that finds nothing more to change."""
    model.move(1.5 * SLACK_AT, 0.0)
    model.fmu.enterEventMode()
    info = model.iterate_events()
    assert info.calls == 2
    assert not info.jumped  # slack is no impulse
    assert not info.terminate
    assert not info.nominals_changed
    assert info.next_time is None


def test_states_are_said_to_jump_only_where_they_do(sticking):
    """A joint that comes to rest has a rounding's worth of velocity, which sticking removes."""
    model = sticking
    model.fmu.enterEventMode()
    model.set("load_torque", 1.0)
    assert not model.iterate_events().jumped  # breaks away: no jump
    model.move(0.0, 1e-3)
    model.set("load_torque", 0.0)
    model.move(0.0, -1e-9)  # the integrator has stopped just past the standstill
    model.fmu.enterEventMode()
    assert model.iterate_events().jumped
    assert model.get("joint_velocity") == 0.0
    assert model.get("der(joint_velocity)") == 0.0


def test_nominals_are_those_of_the_description(model):
    values = np.zeros(2)
    model.fmu.getNominalsOfContinuousStates(values.ctypes.data_as(POINTER(c_double)), 2)
    names = ("joint_position", "joint_velocity")
    assert list(values) == [float(model.variables[name].nominal) for name in names]


def test_initialisation_settles_the_relations(base, instances):
    """Outputs read while initialising are those that hold after it."""
    for kind in (base.slave, base.model):
        instance = instances(kind())
        instance.set_up({"joint_position": 0.2, "motor_position": 0.0})
        initial = instance.everything()
        assert initial["slack_state"] == 2
        instance.fmu.exitInitializationMode()
        assert instance.everything() == initial


def test_time_may_run_ahead_of_the_stop_but_not_stay_there(base, instances):
    model = instances(base.model())
    model.begin(stop_time=1.0)
    model.fmu.setTime(1.1)  # what an integrator tries
    model.fmu.setTime(1.0)
    model.fmu.enterEventMode()
    model.iterate_events()
    model.fmu.setTime(1.1)
    model.fmu.enterEventMode()
    before = model.snapshot()
    with pytest.raises(Exception, match="DiscreteStates"):
        model.iterate_events()
    assert model.log[-1].status == ERROR
    assert model.snapshot() == before
