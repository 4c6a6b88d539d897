"""Many runs in one call of the library: each is what `simulate` gives, and fails alone."""

import numpy as np
import pytest

from elastic_tendon.actuator.parameters import load_model
from elastic_tendon.simulation.simulate import simulate, simulate_many

TIME = np.linspace(0.0, 1.0, 201)
MOTOR = 0.3 * np.sin(2.0 * np.pi * 0.7 * TIME) + 0.2 * np.sin(2.0 * np.pi * 2.3 * TIME)
LOAD = 6.0 * np.sin(2.0 * np.pi * 1.1 * TIME)
KEPT = ("slack_state", "joint_position", "joint_torque")


def _model(*effect_ids):
    model = load_model("biorob_x4_joint_3")
    for effect_id, values in effect_ids:
        model = model.with_effect(effect_id, values)
    return model


@pytest.mark.parametrize("interpolation", ["hold", "linear", "cubic"])
@pytest.mark.parametrize(
    "effects",
    [(), (("coulomb_friction", {"torque": 0.3}), ("measurement_delay", {"delay": 0.004}))],
    ids=["bare", "friction and delay"],
)
def test_each_run_is_what_simulate_gives_to_the_last_bit(effects, interpolation):
    model = _model(*effects)
    varied = {
        "link.inertia": np.array([0.02, 0.03, 0.05]),
        "transmission.pretension_force": np.array([40.0, 80.0, 90.0]),
    }
    settings = {"interpolation": interpolation, "as_measured": True}
    many = simulate_many(model, varied, TIME, MOTOR, LOAD, outputs=KEPT, **settings)
    assert many.failures == ("", "", "")
    assert many.outputs.shape == (3, len(KEPT), len(TIME))
    for run in range(3):
        values = {path: float(column[run]) for path, column in varied.items()}
        alone = simulate(model.with_values(values), TIME, MOTOR, LOAD, **settings)
        for index, name in enumerate(KEPT):
            np.testing.assert_array_equal(many.outputs[run, index], alone[name])


def test_a_run_that_fails_fails_alone():
    inertia = np.array([0.03, np.nan, 0.03])
    many = simulate_many(_model(), {"link.inertia": inertia}, TIME, MOTOR, outputs=KEPT)
    assert [bool(reason) for reason in many.failures] == [False, True, False]
    assert many.failures[1].startswith("stopped at 0 s: ")
    assert np.isnan(many.outputs[1]).all()
    np.testing.assert_array_equal(many.outputs[0], many.outputs[2])
    assert np.isfinite(many.outputs[0]).all()


def test_all_runs_start_in_the_given_state():
    varied = {"link.inertia": np.array([0.02, 0.05])}
    start = {"joint_position": 0.1, "joint_velocity": -2.0}
    many = simulate_many(
        _model(), varied, TIME, MOTOR, outputs=["joint_position"], initial_state=start
    )
    np.testing.assert_array_equal(many.outputs[:, 0, 0], [0.1, 0.1])


@pytest.mark.parametrize(
    ("varied", "outputs", "fault"),
    [
        ({"link.inertias": [1.0]}, KEPT, "has no link.inertias"),
        ({"link.inertia": [1.0]}, ("joint_angle",), "no output joint_angle"),
        ({"link.inertia": [1.0], "link.damping": [1.0, 2.0]}, KEPT, "one row of values"),
        ({"link.inertia": 1.0}, KEPT, "one row of values"),
        ({}, KEPT, "one row of values"),
    ],
)
def test_arguments_that_do_not_fit_are_refused(varied, outputs, fault):
    with pytest.raises(ValueError, match=fault):
        simulate_many(_model(), varied, TIME, MOTOR, outputs=outputs)
