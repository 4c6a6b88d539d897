"""`Actuators`: as `simulate`, with states that are saved, restored, reset and shared by threads."""

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from elastic_tendon.actuator.parameters import load_model, typical_value
from elastic_tendon.actuator.variables import interface
from elastic_tendon.effects import BY_ID
from elastic_tendon.errors import ModelError, SimulationError
from elastic_tendon.simulation.actuators import INPUTS, Actuators
from elastic_tendon.simulation.simulate import simulate

STEP = 0.002
TIME = STEP * np.arange(601)
TOLERANCE = 1e-10
# through slack, past the largest deflection of the springs
MOTOR, JOINT = (
    CubicSpline(TIME, amplitude * np.sin(2 * np.pi * frequency * TIME))
    for amplitude, frequency in ((0.4, 1.3), (0.3, 0.7))
)


WITH_MEMORY = ("spring_hysteresis", "spring_relaxation", "spring_mass", "tendon_compliance")


def _models():
    """The bundled joint with damped springs, alone and with effects: with states, modes, readings,
    a law."""
    damped = {f"transmission.{side}_spring.damping": 20.0 for side in ("upper", "lower")}
    model = load_model("biorob_x4_joint_3").with_values(damped).at("joint")
    models = {"none": model}
    for effect_id in (*WITH_MEMORY, "gear_backlash", "motor_encoder_offset", "spring_hardening"):
        numbers = {
            parameter.name: float(
                np.clip(typical_value(model, parameter), parameter.lower, parameter.upper)
            )
            for parameter in BY_ID[effect_id].parameters
        }
        models[effect_id] = model.with_effect(effect_id, numbers)
    return models


MODELS = _models()


@pytest.fixture
def actuators():
    return Actuators([*MODELS.values()], tolerance=TOLERANCE)


def at(time):
    """Inputs at a time."""
    return MOTOR(time), MOTOR(time, 1), JOINT(time), JOINT(time, 1)


def play(actuators, begin=1, end=None):
    """All outputs after each step, (n_steps, n, n_outputs)."""
    rows = []
    for time in TIME[begin:end]:
        actuators.step(STEP, *at(time))
        rows.append([actuators[name] for name in actuators.output_names])
    return np.array(rows).transpose(0, 2, 1)


def test_they_do_what_simulate_does(actuators):
    actuators.reset(*at(0.0))
    played = play(actuators)
    for index, (name, model) in enumerate(MODELS.items()):
        run = simulate(
            *(model, TIME, MOTOR(TIME)),
            joint_position=JOINT(TIME),
            interpolation="cubic",
            tolerance=TOLERANCE,
        )
        if name == "none":
            assert set(run["slack_state"]) == {1, 2, 3}
        for column, output in enumerate(actuators.output_names):
            size = np.abs(run[output]).max()
            error = np.abs(played[:, index, column] - run[output][1:]).max()
            assert error <= 1e-7 * size, (name, output)


@pytest.mark.parametrize("name", WITH_MEMORY)
def test_effects_with_states_of_their_own_are_among_them(name):
    assert interface(*MODELS[name].structure).states


def test_what_was_saved_goes_on_bit_by_bit(actuators):
    actuators.reset(*at(0.0))
    play(actuators, 1, 200)
    saved = actuators.save()
    there, time = actuators["joint_torque"], actuators.time
    first = play(actuators, 200, 300)
    actuators.restore(saved)
    assert actuators.time == time == pytest.approx(TIME[199])
    assert (actuators["joint_torque"] == there).all()
    assert (play(actuators, 200, 300) == first).all()
    others = Actuators(actuators.models, tolerance=TOLERANCE)
    others.restore(saved)
    assert (play(others, 200, 300) == first).all()


def test_reset_ones_are_as_new(actuators):
    first = play(actuators, 1, 100)
    actuators.reset()
    assert actuators.time == 0.0
    assert (play(actuators, 1, 100) == first).all()


@pytest.mark.parametrize("threads", [2, 5, 100])
def test_threads_change_nothing(actuators, threads):
    shared = Actuators(actuators.models, tolerance=TOLERANCE, threads=threads)
    assert (play(shared, 1, 100) == play(actuators, 1, 100)).all()
    assert (shared.derivatives() == actuators.derivatives()).all()


def test_each_has_its_own_inputs(actuators):
    joint = np.linspace(-0.01, 0.01, len(actuators))
    actuators.step(STEP, 0.0, 0.0, joint, 0.0)
    assert actuators["deflection"] == pytest.approx(joint, abs=0.02)
    assert len(set(actuators["joint_torque"])) == len(actuators)


def test_derivatives_are_those_of_the_outputs():
    stateless = [MODELS["none"], MODELS["spring_hardening"], MODELS["motor_encoder_offset"]]
    actuators, h = Actuators(stateless), 1e-6
    inputs = np.array([0.05, 1.0, 0.02, -0.5])
    actuators.reset(*inputs)
    exact = actuators.derivatives()
    for column in range(len(INPUTS)):
        sides = []
        for sign in (1, -1):
            actuators.reset(*(inputs + sign * h * np.eye(4)[column]))
            sides.append([actuators[name] for name in actuators.output_names])
        slope = ((np.array(sides[0]) - sides[1]) / (2 * h)).T
        assert exact[:, :, column] == pytest.approx(slope, rel=1e-6, abs=1e-5)
    actuators.reset()
    stiffness, damping = actuators.stiffness_and_damping()
    transmission = stateless[0].transmission
    radius, spring = transmission.joint_pulley_radius, transmission.upper_spring
    assert stiffness[0] == pytest.approx(2 * radius**2 * spring.parallel * spring.stiffness)
    assert damping[0] == pytest.approx(2 * radius**2 * spring.parallel * spring.damping)


@pytest.mark.parametrize(
    ("inputs", "words"),
    [
        (
            (np.zeros(3), 0.0, 0.0, 0.0),
            r"motor_position has shape \(3,\), but there are 2 actuators",
        ),
        ((0.0, 0.0, 0.0, [0.0]), r"joint_velocity has shape \(1,\)"),
    ],
)
def test_inputs_of_another_size_are_refused(inputs, words):
    actuators = Actuators([MODELS["none"]] * 2)
    with pytest.raises(ValueError, match=words):
        actuators.step(STEP, *inputs)
    with pytest.raises(ValueError, match=words):
        actuators.reset(*inputs)


def test_wrong_use_is_refused_in_a_sentence():
    model = MODELS["none"]
    with pytest.raises(ValueError, match="there are no actuators"):
        Actuators([])
    with pytest.raises(ModelError, match="works at interface joint, not at position; write"):
        Actuators([model, load_model("biorob_x4_joint_3")])
    with pytest.raises(ValueError, match="0 threads"):
        Actuators([model], threads=0)
    with pytest.raises(ValueError, match="tolerance 1 is outside"):
        Actuators([model], tolerance=1)
    actuators = Actuators([model] * 3)
    with pytest.raises(ValueError, match="the step is -1 s long"):
        actuators.step(-1, 0, 0, 0, 0)
    with pytest.raises(KeyError, match="no output 'torque'; there are joint_torque,"):
        actuators["torque"]
    with pytest.raises(ValueError, match="restore what actuators of the same models have saved"):
        actuators.restore(Actuators([model] * 2).save())


@pytest.mark.parametrize("threads", [1, 2])
def test_what_is_not_finite_is_told_with_actuator_and_time(threads):
    actuators = Actuators([MODELS["none"], MODELS["spring_relaxation"]], threads=threads)
    actuators.step(STEP, 0, 0, 0, 0)
    saved = actuators.save()
    words = r"actuator 1, biorob_x4_joint_3: joint_position is nan after 0\.002 s;.* shorter steps"
    with pytest.raises(SimulationError, match=words):
        actuators.step(STEP, 0, 0, np.array([0.0, np.nan]), 0)
    actuators.restore(saved)
    actuators.step(STEP, 0, 0, 0, 0)
    assert np.isfinite(actuators["joint_torque"]).all()
