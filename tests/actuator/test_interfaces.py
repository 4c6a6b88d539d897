"""Either side of the actuator is given or computed: against the truth, and against each other."""

import tomllib

import numpy as np
import pytest

import elastic_tendon as et
from elastic_tendon.actuator.interfaces import WITH_SPRINGS, InterfaceKind, kinds_with
from elastic_tendon.actuator.parameters import parse_model
from elastic_tendon.actuator.variables import interface
from elastic_tendon.effects.base import Slot
from elastic_tendon.errors import ModelError
from elastic_tendon.simulation.simulate import sensitivities, simulate
from truth import torque_driven
from truth.every_effect import EFFECTS
from truth.torque_driven import Drive

AGREEMENT = 1e-7  # rad, with the truth
FORCES = 1e-6  # N·m
BETWEEN = 1e-8  # rad and N·m, between interfaces
TIME = np.arange(0.0, 2.0, 1e-3)
EVERY = 40  # th sample is compared with the truth

TREE = {
    "name": "driven",
    "transmission": {
        "joint_pulley_radius": 0.031,
        "motor_pulley_radius": 0.0223,
        "pretension_force": 9.0,
        "upper_spring": {"stiffness": 9100.0, "damping": 3.1, "max_deflection": 0.02},
        "lower_spring": {"stiffness": 5200.0, "damping": 1.7, "max_deflection": 0.03},
    },
    "link": {"inertia": 0.027, "damping": 0.11},
    "motor": {"inertia": 0.004, "damping": 0.02},
}
MODEL = parse_model(TREE, "driven")
DRIVE = Drive(
    joint_radius=0.031,
    motor_radius=0.0223,
    pretension=9.0,
    stiffness=(9100.0, 5200.0),
    damping=(3.1, 1.7),
    link=(0.027, 0.11),
    rotor=(0.004, 0.02),
)


def torque(t):
    return 0.9 * np.sin(4.0 * t) + 0.7 * np.sin(17.0 * t)


def load(t):
    return 1.4 * np.sin(6.0 * t)


MACHINES = {
    "plain": ({}, {}),
    "motor_friction": ({"torque": 0.3}, {"rotor_friction": 0.3}),
    "gear_loss": ({"motor_share": 0.2, "load_share": 0.3}, {"loss": (0.2, 0.3)}),
    "motor_stiction": (
        {
            "torque": 0.1,
            "motor_share": 0.05,
            "load_share": 0.1,
            "driving_square": 0.04,
            "driven_square": 0.06,
            "stribeck_velocity": 1.5,
            "exponent": 1.4,
        },
        {"slow": (0.1, 0.05, 0.1, 0.04, 0.06, 1.5, 1.4)},
    ),
    "motor_torque_gain": ({"error": -0.2}, {"gain": 0.8}),
    "motor_torque_offset": ({"offset": 0.15}, {"offset": 0.15}),
    "motor_cogging": (
        {"amplitude": 0.2, "waves": 7.0, "phase": 0.6},
        {"cogging": (0.2, 7.0, 0.6)},
    ),
}


@pytest.mark.parametrize("name", MACHINES)
def test_a_torque_drives_the_rotor_as_in_the_truth(name):
    numbers, of_truth = MACHINES[name]
    model = MODEL.at("torque")
    if numbers:
        model = model.with_effect(name, numbers)
    seen = TIME[::EVERY]
    truth = torque_driven.simulate(Drive(**{**vars(DRIVE), **of_truth}), seen, torque, load)
    # samples so dense that the spline between them errs by less than what is asked
    dense = np.linspace(0.0, TIME[-EVERY], 20 * (len(TIME) - EVERY) + 1)
    found = simulate(
        model,
        dense,
        load_torque=load(dense),
        motor_torque=torque(dense),
        interpolation="cubic",
        tolerance=1e-11,
    )
    step = 20 * EVERY
    assert np.ptp(truth[:, 0]) > 0.5
    assert {1.0, 2.0, 3.0} <= set(found["slack_state"])  # both tendons go slack on the way
    names = ("joint_position", "joint_velocity", "motor_position", "motor_velocity")
    for column, state in enumerate(names[::2]):
        error = np.abs(found[state][::step] - truth[:, 2 * column])
        assert error.max() < AGREEMENT, state
    pulls = np.array([DRIVE.pulls(*row) for row in truth])
    expected = DRIVE.joint_radius * (pulls[:, 0] - pulls[:, 1])
    assert np.abs(found["joint_torque"][::step] - expected).max() < FORCES


@pytest.mark.parametrize(
    "effect_ids",
    [(), ("spring_hysteresis",), ("pulley_eccentricity", "spring_relaxation")],
    ids="+".join,
)
def test_the_interfaces_of_one_machine_agree(effect_ids):
    """Each is driven by what another computed."""
    machine = et.models.biorob_x4_joint_3
    for effect_id in effect_ids:
        machine = machine.with_effect(effect_id, EFFECTS[effect_id])
    time = np.arange(0.0, 1.0, 2e-4)
    options = {"interpolation": "cubic", "tolerance": 1e-12}
    pushed = 0.8 * np.sin(9.0 * time) ** 3
    pulled = 2.0 * np.sin(7.0 * time) ** 3
    whole = simulate(machine.at("torque"), time, load_torque=pulled, motor_torque=pushed, **options)
    by_position = simulate(machine, time, whole["motor_position"], pulled, **options)
    at_joint = simulate(
        machine.at("joint"),
        time,
        whole["motor_position"],
        joint_position=whole["joint_position"],
        **options,
    )
    both = simulate(
        machine.at("torque_joint"),
        time,
        motor_torque=pushed,
        joint_position=whole["joint_position"],
        **options,
    )
    assert np.ptp(whole["joint_position"]) > 0.1
    assert np.abs(by_position["joint_position"] - whole["joint_position"]).max() < BETWEEN
    assert np.abs(both["motor_position"] - whole["motor_position"]).max() < BETWEEN
    for found in (by_position, at_joint, both):
        stiffness = 42.0  # N·m/rad, by which errors of position show in torque
        error = np.abs(found["joint_torque"] - whole["joint_torque"]).max()
        assert error < stiffness * BETWEEN
    assert (at_joint["load_torque"] == -at_joint["joint_torque"]).all()


def test_the_motor_bears_what_its_pulley_works():
    """Where the pulley turns faster than the motor, its torque on the motor is larger."""
    machine = MODEL.with_effect("pulley_eccentricity", {"amplitude": 0.3, "phase": 0.2})
    time = np.linspace(0.0, 1.0, 2001)
    position = 0.4 * np.sin(5.0 * time)
    found = simulate(machine.at("joint"), time, position, joint_position=0.0 * time)
    bare = MODEL.at("joint")
    pulley = position + 0.3 * (np.sin(position + 0.2) - np.sin(0.2))
    alone = simulate(bare, time, pulley, joint_position=0.0 * time)
    expected = alone["motor_torque"] * (1.0 + 0.3 * np.cos(position + 0.2))
    assert np.abs(found["motor_torque"] - expected)[1:].max() < 1e-3 * np.ptp(expected)


@pytest.mark.parametrize("kind", WITH_SPRINGS)
def test_derivatives_are_those_of_differences(kind):
    model = MODEL.at(kind).with_effect("spring_hardening", {"cubic_stiffness": 2e7})
    given = {
        "motor_position": 0.3 * np.sin(8.0 * TIME),
        "load_torque": load(TIME),
        "motor_torque": torque(TIME),
        "joint_position": 0.2 * np.sin(5.0 * TIME),
    }
    names = interface(*model.structure).input_names
    inputs = {name: values for name, values in given.items() if name in names}
    without = ("parallel", "slack", "max_deflection")  # whole numbers, and what changes no torque
    paths = [path for path in model.values() if not path.endswith(without)]
    found = sensitivities(
        model, TIME, parameters=paths, interpolation="cubic", tolerance=1e-10, **inputs
    )
    for path, column in zip(paths, found.of("joint_torque").T, strict=True):
        step = 1e-5 * abs(model.values()[path])
        high, low = (
            simulate(
                model.with_values({path: model.values()[path] + sign * step}),
                TIME,
                interpolation="cubic",
                tolerance=1e-12,
                **inputs,
            )["joint_torque"]
            for sign in (1, -1)
        )
        error = np.linalg.norm((high - low) / (2.0 * step) - column)
        assert error <= 1e-4 * np.linalg.norm(column), path


def test_model_toml_keeps_the_interface():
    model = MODEL.at("torque")
    again = parse_model(tomllib.loads(model.to_toml()), "again")
    assert again == model
    assert again.kind is InterfaceKind.TORQUE
    assert "interface" not in MODEL.to_toml()
    assert model.at_position().structure == MODEL.structure
    unsure = model.model_copy(update={"uncertainty": {"motor.inertia": 0.2, "link.inertia": 0.1}})
    assert unsure.at("position").uncertainty == {"link.inertia": 0.1}
    assert unsure.at("torque_joint").uncertainty == {"motor.inertia": 0.2}


REFUSED = {
    "kind": (
        {"interface": {"kind": "tork"}},
        "interface.kind: 'tork' is refused: input should be 'position', 'torque', 'joint',",
    ),
    "no rotor": (
        {"interface": {"kind": "torque"}, "motor": None},
        "motor: missing; interface torque moves the rotor: give a table [motor] with its inertia",
    ),
    "friction of designs": (
        {"interface": {"kind": "torque"}, "motor": {"inertia": 0.1, "friction_torque": 0.3}},
        "give it as torque of [effects.motor_friction]",
    ),
    "no link": (
        {"interface": {"kind": "joint"}, "effects": {"gravity_load": {}}},
        "gravity_load acts on the motion of the link, which interface joint does not compute; "
        "leave it out, or choose interface position or torque",
    ),
    "no place for a motor": (
        {"effects": {"motor_friction": {}}},
        "motor_friction acts on the motion of the rotor, which interface position does not "
        "compute; leave it out, or choose interface torque or torque_joint",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_does_not_fit_is_told_in_a_sentence(case):
    change, sentence = REFUSED[case]
    with pytest.raises(ModelError) as refused:
        parse_model(TREE | change, "bad.toml")
    assert sentence in str(refused.value)
    assert len(str(refused.value).splitlines()) == 1


def test_inputs_of_another_interface_are_refused():
    still = 0.0 * TIME
    with pytest.raises(
        ValueError, match="motor_torque is given, but driven has interface position"
    ):
        simulate(MODEL, TIME, still, motor_torque=still)
    with pytest.raises(ValueError, match="beside the time motor_torque is needed"):
        simulate(MODEL.at("torque"), TIME)
    with pytest.raises(ValueError, match="its inputs are motor_position, joint_position"):
        simulate(MODEL.at("joint"), TIME, still, still, joint_position=still)


def test_effects_say_at_which_interfaces_they_act():
    position, torque_kind, joint, torque_joint = WITH_SPRINGS
    assert kinds_with(Slot.SPRING_LAW) == WITH_SPRINGS
    assert kinds_with(Slot.JOINT_TORQUE) == (position, torque_kind)
    assert kinds_with(Slot.MOTOR_FRICTION) == (torque_kind, torque_joint)
    assert joint.value == "joint"
