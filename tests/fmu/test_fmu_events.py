"""Event mode of model exchange: relations are frozen outside it and settle inside it."""

from ctypes import POINTER, byref, c_double

import numpy as np
import pytest
from fmpy.fmi2 import fmi2EventInfo

from fmu_driver import ERROR

_DOUBLES = POINTER(c_double)
SLACK_AT = 80.0 / (0.03 * 2 * 11580.0)  # rad, (13): deflection at which a tendon is slack


def _indicators(model):
    n = model.description.numberOfEventIndicators
    values = np.zeros(n)
    model.fmu.getEventIndicators(values.ctypes.data_as(_DOUBLES), n)
    return values


def _move(model, *x):
    values = np.array(x)
    model.fmu.setContinuousStates(values.ctypes.data_as(_DOUBLES), len(x))


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
    taut = _indicators(model)
    _move(model, 1.5 * SLACK_AT, 0.0)
    assert ((_indicators(model) > 0) != (taut > 0)).sum() == 1
    assert model.get("slack_state") == 3
    assert model.get("upper_spring_force") < 0  # beyond the border, as an integrator wants it
    model.fmu.enterEventMode()
    assert model.get("slack_state") == 3
    model.iterate_events()
    assert model.get("slack_state") == 2
    assert model.get("upper_spring_force") == 0


def test_indicator_changes_sign_where_the_tendon_slackens(model):
    signs = []
    for deflection in (SLACK_AT * (1 - 1e-6), SLACK_AT * (1 + 1e-6)):
        _move(model, deflection, 0.0)
        signs.append(_indicators(model) > 0)
    assert (signs[0] != signs[1]).sum() == 1


def test_no_indicator_is_zero_after_an_event_on_the_border(model):
    """An integrator that stops exactly on the border goes on without the event repeating."""
    _move(model, SLACK_AT, 0.3)
    model.fmu.enterEventMode()
    model.iterate_events()
    before = _indicators(model)
    assert (np.abs(before) > 1e-11).all()
    _move(model, SLACK_AT * (1 + 1e-12), 0.3)
    assert ((_indicators(model) > 0) == (before > 0)).all()


def test_event_information_is_written_in_full(model):
    """Two calls: one that changes relations, one that finds nothing more to change."""
    _move(model, 1.5 * SLACK_AT, 0.0)
    model.fmu.enterEventMode()
    for again in (1, 0):
        info = fmi2EventInfo(*[7] * 5, 7.0)
        assert model.status("fmi2NewDiscreteStates", byref(info)) == 0
        assert info.newDiscreteStatesNeeded == again
        assert info.valuesOfContinuousStatesChanged == 0  # slack is no impulse
        assert info.terminateSimulation == info.nominalsOfContinuousStatesChanged == 0
        assert info.nextEventTimeDefined == 0


def test_states_are_said_to_jump_only_where_they_do(sticking):
    """A joint that comes to rest has a rounding's worth of velocity, which sticking removes."""
    model = sticking
    model.fmu.enterEventMode()
    model.set("load_torque", 1.0)
    assert not model.iterate_events()  # breaks away: no jump
    _move(model, 0.0, 1e-3)
    model.set("load_torque", 0.0)
    _move(model, 0.0, -1e-9)  # the integrator has stopped just past the standstill
    model.fmu.enterEventMode()
    assert model.iterate_events()
    assert model.get("joint_velocity") == 0.0
    assert model.get("der(joint_velocity)") == 0.0


def test_nominals_are_those_of_the_description(model):
    values = np.zeros(2)
    model.fmu.getNominalsOfContinuousStates(values.ctypes.data_as(_DOUBLES), 2)
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
    assert model.status("fmi2NewDiscreteStates", byref(fmi2EventInfo())) == ERROR
