"""Offsets and delays act on what is measured, and leave the physics alone."""

import numpy as np
import pytest
from contract_cases import CROOKED, LOAD, TIME

from elastic_tendon.simulation.simulate import sensitivities, simulate

OFFSET, DELAY = 0.03, 0.0071  # rad; s, no multiple of the sampling
GAIN = 0.25
START = 0.5  # s, until which motor and joint rest
MOVING = np.maximum(TIME - START, 0.0)
MOTOR = 0.4 * np.sin(7.0 * MOVING)
PUSH = np.where(TIME < START, 0.0, LOAD - LOAD[np.searchsorted(TIME, START)])
AGREEMENT = 1e-9  # rad, of two runs at 1e-11 that stop at different times
GEAR = CROOKED.transmission.motor_pulley_radius / CROOKED.transmission.joint_pulley_radius


def run(model, motor=MOTOR, **options):
    return simulate(model, TIME, motor, PUSH, tolerance=1e-11, **options)


def wrong_encoders():
    """Both encoders with another scale and another zero."""
    model = CROOKED
    for side in ("joint", "motor"):
        model = model.with_effect(f"{side}_encoder_gain", {"error": GAIN})
        model = model.with_effect(f"{side}_encoder_offset", {"offset": OFFSET})
    return model


def with_delay(delay=DELAY):
    return CROOKED.with_effect("measurement_delay", {"delay": delay})


@pytest.mark.parametrize(
    ("effect", "numbers"),
    [
        ("joint_encoder_offset", {"offset": OFFSET}),
        ("motor_encoder_offset", {"offset": OFFSET}),
        ("measurement_delay", {"delay": DELAY}),
        ("deflection_gain", {"error": 0.1}),
        ("joint_encoder_gain", {"error": GAIN}),
        ("motor_encoder_gain", {"error": GAIN}),
    ],
)
def test_physical_outputs_stay_as_they_are(effect, numbers):
    base, measured = run(CROOKED), run(CROOKED.with_effect(effect, numbers))
    for name in base.output_names:
        assert np.array_equal(measured[name], base[name]), name


def test_joint_encoder_reads_the_offset_besides():
    motion = run(CROOKED.with_effect("joint_encoder_offset", {"offset": OFFSET}))
    assert np.array_equal(motion["measured_joint_position"], motion["joint_position"] + OFFSET)


def test_a_deflection_sensor_reads_its_share_besides():
    motion = run(CROOKED.with_effect("deflection_gain", {"error": 0.1}))
    read = motion["joint_position"] + 0.1 * motion["deflection"]
    assert np.abs(motion["measured_joint_position"] - read).max() < 1e-15


def test_motor_encoder_reads_the_offset_besides():
    motion = run(CROOKED.with_effect("motor_encoder_offset", {"offset": OFFSET}))
    assert np.array_equal(motion["measured_motor_position"], MOTOR + OFFSET)


def test_in_comparison_the_motor_is_where_its_encoder_reads_less_the_offset():
    model = CROOKED.with_effect("motor_encoder_offset", {"offset": OFFSET})
    measured, true = run(model, as_measured=True), run(CROOKED, MOTOR - OFFSET)
    assert np.abs(measured["joint_position"] - true["joint_position"]).max() < AGREEMENT
    assert np.abs(measured["measured_motor_position"] - MOTOR).max() < 1e-15
    deflection = true["joint_position"] - GEAR * (MOTOR - OFFSET)
    assert np.abs(measured["deflection"] - deflection).max() < AGREEMENT


def test_encoders_add_their_offset_to_what_the_gain_has_enlarged():
    motion = run(wrong_encoders())
    for side, position in (("joint", motion["joint_position"]), ("motor", MOTOR)):
        read = (1.0 + GAIN) * position + OFFSET
        assert np.abs(motion[f"measured_{side}_position"] - read).max() < 1e-15


def test_in_comparison_the_motor_is_where_gain_and_offset_say():
    measured = run(wrong_encoders(), as_measured=True)
    true = run(CROOKED, (MOTOR - OFFSET) / (1.0 + GAIN))
    assert np.abs(measured["measured_motor_position"] - MOTOR).max() < 1e-15
    # what damps in the springs and what the motor bears see the true motor's rate
    for name, unit in (("joint_position", 1.0), ("deflection", 1.0), ("motor_torque", 100.0)):
        assert np.abs(measured[name] - true[name]).max() < unit * AGREEMENT, name


@pytest.mark.parametrize("effect", ["joint_encoder_gain", "deflection_gain"])
def test_in_comparison_a_joint_that_is_given_moves_as_fast_as_it_truly_does(effect):
    model = CROOKED.at("joint")
    true_joint = 0.3 * np.sin(5.0 * MOVING)
    enlarged = true_joint if effect == "joint_encoder_gain" else true_joint - GEAR * MOTOR
    given = {"joint_position": true_joint + GAIN * enlarged}
    read = simulate(
        model.with_effect(effect, {"error": GAIN}), TIME, MOTOR, as_measured=True, **given
    )
    true = simulate(model, TIME, MOTOR, joint_position=true_joint)
    assert np.abs(read["deflection"] - true["deflection"]).max() < AGREEMENT
    assert np.abs(read["joint_torque"] - true["joint_torque"]).max() < 100.0 * AGREEMENT


def test_in_comparison_a_delay_is_exact():
    times = np.unique(np.concatenate([TIME, np.maximum(TIME - DELAY, 0.0)]))
    fine = simulate(
        CROOKED,
        times,
        *(np.interp(times, TIME, samples) for samples in (MOTOR, PUSH)),
        tolerance=1e-11,
    )
    late = run(with_delay(), as_measured=True)
    then = np.searchsorted(times, np.maximum(TIME - DELAY, 0.0))
    assert np.abs(late["measured_joint_position"] - fine["joint_position"][then]).max() < AGREEMENT
    # torques are a hundred times the angles
    assert np.abs(late["joint_torque"] - fine["joint_torque"][then]).max() < 100 * AGREEMENT
    # the last sample of a rate is that of the segment before it
    now = np.searchsorted(times, TIME)[:-1]
    assert np.abs(late["motor_torque"][:-1] - fine["motor_torque"][now]).max() < 100 * AGREEMENT


def test_in_simulation_a_delay_is_off_by_no_more_than_it_says():
    motion, exact = run(with_delay()), run(with_delay(), as_measured=True)
    acceleration = np.abs(np.gradient(motion["joint_velocity"], TIME)).max()
    error = np.abs(motion["measured_joint_position"] - exact["measured_joint_position"]).max()
    assert 0.1 * DELAY**2 / 2 * acceleration < error < DELAY**2 / 2 * acceleration


def test_the_derivative_by_a_delay_of_nothing_is_less_the_velocity():
    options = {"parameters": ["effects.measurement_delay.delay"], "as_measured": True}
    result = sensitivities(with_delay(0.0), TIME, MOTOR, PUSH, **options, tolerance=1e-11)
    (column,) = result.of("measured_joint_position").T
    assert np.abs(column + result.trajectory["joint_velocity"]).max() < 1e-6
