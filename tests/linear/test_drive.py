"""What moves the motor: each drive against the two inputs that an FMU has."""

import control
import numpy as np
import pytest
from linear_cases import closed_form, damped, with_typical

from elastic_tendon.actuator.parameters import parse_model
from elastic_tendon.errors import LinearisationError
from elastic_tendon.linear.drive import SHIFTED
from elastic_tendon.linear.linearise import linearise
from elastic_tendon.linear.result import Drive, OperatingPoint

MOTOR = {"inertia": 2e-3, "damping": 0.05, "friction_torque": 0.2}
POINTS = 1j * np.logspace(-1, 4, 40)
EFFECTS = ((), ("spring_relaxation",), ("gravity_load", "tendon_compliance"))


@pytest.fixture(params=EFFECTS, ids=lambda effects: " ".join(effects) or "base")
def model(request):
    """With spring damping, a gear ratio, a rotor, and effects."""
    asymmetric = damped("figure_7").with_values({"transmission.motor_pulley_radius": 0.02})
    tree = asymmetric.model_dump() | {"motor": MOTOR}
    return with_typical(parse_model(tree, "test"), *request.param)


def response(system, output, source):
    """Frequency response of one channel, solved without a transfer function."""
    B, D = (getattr(system, matrix)[:, system.input_index[source]] for matrix in "BD")
    C, row = system.C[system.output_index[output]], system.output_index[output]
    identity = np.eye(system.nstates)
    return np.array([C @ np.linalg.solve(s * identity - system.A, B) + D[row] for s in POINTS])


@pytest.mark.parametrize("state", ["I", "II", "III"])
def test_position_alone_has_the_velocity_as_its_derivative(model, state):
    source = linearise(model, state)
    position = linearise(model, state, drive=Drive.POSITION)
    assert position.input_labels == ["motor_position", "load_torque"]
    for output in position.output_labels:
        both = response(source, output, "motor_position")
        both = both + POINTS * response(source, output, "motor_velocity")
        assert np.allclose(response(position, output, "motor_position"), both, rtol=1e-7, atol=1e-9)
        load = response(source, output, "load_torque")
        assert np.allclose(response(position, output, "load_torque"), load, rtol=1e-9)


def test_a_state_moved_by_the_position_says_so():
    position = linearise(damped("figure_7"), "III", drive=Drive.POSITION)
    assert position.state_labels == ["joint_position", f"joint_velocity{SHIFTED}"]
    undamped = linearise(
        damped("figure_7").with_values(
            {f"transmission.{side}_spring.damping": 0.0 for side in ("upper", "lower")}
        ),
        *("III",),
        drive=Drive.POSITION,
    )
    assert undamped.state_labels == ["joint_position", "joint_velocity"]
    assert "joint_torque" in undamped.output_labels


def test_an_improper_output_is_refused_with_the_reason():
    with pytest.raises(LinearisationError, match=r"joint_torque .* needs the motor's velocity"):
        linearise(damped("figure_7"), "III", drive=Drive.POSITION, outputs=["joint_torque"])


@pytest.mark.parametrize("state", ["I", "II", "III"])
def test_velocity_has_the_position_as_its_integral(model, state):
    source = linearise(model, state)
    velocity = linearise(model, state, drive=Drive.VELOCITY)
    assert velocity.input_labels == ["motor_velocity", "load_torque"]
    assert velocity.state_labels[-1] == velocity.output_labels[-1] == "motor_position"
    for output in source.output_labels:
        both = response(source, output, "motor_position") / POINTS
        both = both + response(source, output, "motor_velocity")
        assert np.allclose(response(velocity, output, "motor_velocity"), both, rtol=1e-7, atol=1e-9)


@pytest.mark.parametrize("state", ["I", "II", "III"])
def test_rotor_balances_drive_and_tendons(model, state):
    source = linearise(model, state)
    torque = linearise(model, state, drive=Drive.TORQUE)
    inverse = MOTOR["inertia"] * POINTS**2 + MOTOR["damping"] * POINTS
    motor = response(torque, "motor_position", "motor_drive_torque")
    tendons = response(source, "motor_torque", "motor_position")
    tendons = tendons + POINTS * response(source, "motor_torque", "motor_velocity")
    assert np.allclose(motor * (inverse + tendons), 1.0, rtol=1e-6)
    joint = response(source, "joint_position", "motor_position")
    joint = joint + POINTS * response(source, "joint_position", "motor_velocity")
    expected = joint * motor
    assert np.allclose(
        response(torque, "joint_position", "motor_drive_torque"), expected, rtol=1e-6, atol=1e-15
    )
    velocity = response(torque, "motor_velocity", "motor_drive_torque")
    assert np.allclose(velocity, POINTS * motor, rtol=1e-9)


@pytest.mark.parametrize("drive", Drive)
def test_every_name_has_its_value_at_the_operating_point(model, drive):
    point = OperatingPoint(load_torque=1.0, motor_position=0.4, joint_velocity=0.2)
    system = linearise(model, "III", point, drive=drive)
    at = system.validity.operating_point
    assert set(system.state_labels) <= at.states.keys()
    assert set(system.input_labels) <= at.inputs.keys()
    assert set(system.output_labels) <= at.outputs.keys()
    assert at.inputs["motor_position"] == 0.4


def test_the_drive_torque_carries_tendons_and_losses():
    tree = damped("biorob_x4_joint_3").model_dump() | {"motor": MOTOR}
    model = parse_model(tree, "test")
    at = linearise(model, "III", OperatingPoint(load_torque=2.0), drive=Drive.TORQUE)
    assert at.validity.operating_point.inputs["motor_drive_torque"] == pytest.approx(-2.0)
    moving = OperatingPoint(load_torque=2.0, joint_velocity=0.5)
    at = linearise(model, "III", moving, drive=Drive.TORQUE)
    losses = (model.link.damping + MOTOR["damping"]) * 0.5 + MOTOR["friction_torque"]
    torque = at.validity.operating_point.inputs["motor_drive_torque"]
    assert torque == pytest.approx(-2.0 + losses)


def test_collocated_zeros_are_the_poles_with_the_motor_held():
    """The anti-resonance: where the rotor stands still, joint and springs oscillate on."""
    tree = damped("biorob_x4_joint_3").model_dump() | {"motor": MOTOR}
    model = parse_model(tree, "test")
    for state in ("I", "III"):
        stiffness, damping = closed_form(model, state)
        held = np.roots([model.link.inertia, damping + model.link.damping, stiffness])
        system = linearise(model, state, drive=Drive.TORQUE)
        zeros = system["motor_position", "motor_drive_torque"].zeros()
        assert np.allclose(np.sort_complex(zeros), np.sort_complex(held), rtol=1e-8)
        at_joint = system["joint_position", "motor_drive_torque"].zeros()
        assert np.allclose(at_joint, -stiffness / damping, rtol=1e-6)


def test_controls_operators_accept_it():
    system = linearise(damped("biorob_x4_joint_3"), "III", drive=Drive.VELOCITY)
    channel = system["joint_position", "motor_velocity"]
    closed = control.feedback(channel * 5.0)
    assert isinstance(closed, control.StateSpace)
    assert closed.poles().real.max() < 0.0
    assert closed.dcgain() == pytest.approx(1.0)
