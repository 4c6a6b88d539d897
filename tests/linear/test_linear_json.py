"""The JSON of linear models holds matrices, names, operating points and what they say."""

import json
from math import sqrt

import numpy as np
import pytest

from elastic_tendon.actuator.parameters import load_model
from elastic_tendon.errors import LinearisationError
from elastic_tendon.linear.linear_json import SCHEMA, linear_json
from elastic_tendon.linear.linearise import linearise
from elastic_tendon.linear.names import unit_of
from elastic_tendon.linear.result import Drive, OperatingPoint


@pytest.fixture(scope="module")
def model():
    return load_model("biorob_x4_joint_3")


def written(*args, **kwargs):
    """As a program reads it; NaN and infinity would be refused."""
    return json.loads(json.dumps(linear_json(*args, **kwargs), allow_nan=False))


def test_matrices_names_and_operating_point_come_back(model) -> None:
    models = [linearise(model, state) for state in ("I", "III")]
    content = written(model.name, models)
    assert (content["schema"], content["model"], content["drive"]) == (SCHEMA, model.name, "source")
    assert [told["state"] for told in content["models"]] == ["I", "III"]
    for told, linear in zip(content["models"], models, strict=True):
        for key in "ABCD":
            assert np.array_equal(told[key], getattr(linear, key))
        assert [signal["name"] for signal in told["outputs"]] == linear.output_labels
        assert told["operating_point"]["inputs"] == linear.validity.operating_point.inputs
        assert told["active"]
        assert "sides" not in told
    low, high = content["models"][1]["boundaries"]
    assert low["switches"] == {"lower_spring.taut": 0}
    assert high["slack_state"] == "II"
    assert high["deflection_margin"] == pytest.approx(0.1151, abs=1e-4)
    assert content["frequency_span"]["ratio"] == pytest.approx(sqrt(2.0), rel=1e-9)
    assert content["models"][1]["analysis"]["stiffness"] == pytest.approx(41.688)


def test_units_are_those_of_the_models_variables(model) -> None:
    with_mass = model.with_effect("spring_mass", None)
    (told,) = written("x", [linearise(with_mass, "III", drive=Drive.POSITION)])["models"]
    signals = [*told["states"], *told["inputs"], *told["outputs"]]
    units = {signal["name"]: signal["unit"] for signal in signals}
    assert units["joint_position"] == "rad"
    assert units["upper_spring.spring_mass.velocity"] == "m/s"
    assert units["lower_spring_force"] == "N"
    assert None not in units.values()
    assert unit_of("joint_velocity_shifted") == "rad/s"
    assert unit_of("motor_drive_torque") == "N.m"
    assert unit_of("effect_of_someone_else.speed") is None


def test_a_boundary_has_both_sides_with_the_same_keys(model) -> None:
    slack = model.transmission.pretension_force / (0.03 * 2 * 11580.0)
    linear = linearise(model, "III", OperatingPoint(deflection=slack))
    (told,) = written("x", [linear], outputs=["joint_position"])["models"]
    assert told["on_boundary"]
    assert [side["state"] for side in told["sides"]] == ["III", "II"]
    assert all(side.keys() == told.keys() - {"sides"} for side in told["sides"])
    assert told["C"] == told["sides"][0]["C"] == [[1.0, 0.0]]


def test_what_is_infinite_is_null(model) -> None:
    rough = model.with_effect("coulomb_friction", {"torque": 0.5})
    sticking = linearise(rough, "III", modes={"joint_motion": 0})
    (told,) = written("x", [sticking])["models"]
    assert told["analysis"]["stiffness"] is None
    assert {pole["time_constant"] for pole in told["analysis"]["poles"]} == {None}
    assert written("x", [sticking])["frequency_span"] is None
    (both,) = written("x", [linearise(model, "both")])["models"]
    assert both["state"] == "both"
    gains = {
        (channel["input"], channel["output"]): channel["gain"]
        for channel in both["analysis"]["channels"]
    }
    assert gains["load_torque", "joint_position"] is None


def test_selected_channels_are_in_the_order_asked_for(model) -> None:
    linear = linearise(model, "III")
    (told,) = written(
        "x", [linear], inputs=["load_torque"], outputs=["deflection", "joint_torque"]
    )["models"]
    assert [signal["name"] for signal in told["outputs"]] == ["deflection", "joint_torque"]
    assert np.array(told["D"]).shape == (2, 1)
    assert len(told["analysis"]["channels"]) == 21  # of all
    with pytest.raises(LinearisationError, match="no output 'deflexion'"):
        linear_json("x", [linear], outputs=["deflexion"])
