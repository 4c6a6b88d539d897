"""The next experiment at the other interfaces: run by independent simulators, it decides.

A motor or an axis that a torque drives follows the motion by a controller that the product does not
know; a joint whose position is given is that of a link far too heavy for the springs to move.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

import elastic_tendon as et
from diagnosis.test_beginnings import LINK, SECONDS
from diagnosis.test_beginnings import recording as axis_recording
from diagnosis.test_interfaces_diagnosed import GIVEN, NOISE, TRUE, held
from diagnosis.test_interfaces_diagnosed import recording as drive_recording
from elastic_tendon.actuator.parameters import Model, parse_model
from elastic_tendon.diagnosis.driving import at_rest, drive_of, following
from elastic_tendon.diagnosis.experiment import experiment_csv, next_experiment
from elastic_tendon.diagnosis.limits import BEYOND_RECORDED, limits_of
from elastic_tendon.diagnosis.result import Experiment
from elastic_tendon.diagnosis.separation import Rival
from elastic_tendon.estimation.coordinates import free_parameters
from elastic_tendon.estimation.fit import fit
from elastic_tendon.measurement import Measurement, ReadOptions, read_measurement
from truth import axis, torque_driven
from truth.catalogue import actuator_of, signal_maps_of
from truth.recording import record
from truth.signals import Experiment as Motion
from truth.signals import piecewise_linear

Array = NDArray[np.float64]

DECISIVE = 20.0  # difference of BIC, of an effect and one in its place
READ = ReadOptions(joint_required=False)
SHORT = {"torque": 0.4, "torque_joint": 0.7, "joint": 0.12}  # s that do not decide
HEAVY = 1e4  # kg·m² of a link that springs do not move
WITH_BOTH = et.load_model({"name": "axis", "motion": "linear", "link": LINK})
WITH_BOTH = WITH_BOTH.with_effect("constant_torque", {"torque": -axis.CONSTANT})


@dataclass(frozen=True)
class Case:
    """What was recorded, the two answers with what each leaves free, the right one first, and the
    machine that runs an experiment."""

    data: Measurement
    answers: dict[str, tuple[Model, tuple[str, ...]]]
    run: Callable[[Experiment], Measurement]


def curve(time: Array, values: Array) -> Callable[[float], float]:
    """Smoothly through the samples."""
    spline = CubicSpline(time, values)
    return lambda t: float(spline(t))


def noisy(values: Array, sigma: float, seed: int) -> Array:
    return values + sigma * np.random.default_rng(seed).standard_normal(len(values))


HARDENING = {"spring_hardening": {"cubic_stiffness": 6e6}}
RUBBING = replace(TRUE, rotor_friction=0.02)


def run_driven(experiment: Experiment) -> Measurement:
    """A controller follows the motion; a joint that is given is that of a heavy link."""
    time, motor = experiment.time, curve(experiment.time, experiment.motor_position)
    machine, load = RUBBING, curve(time, experiment.load_torque)
    if not experiment.kind.has_link:
        machine = replace(machine, link=(HEAVY, 0.0))
        joint = CubicSpline(time, experiment.driving["joint_position"])
        load = curve(time, HEAVY * joint(time, 2))
    states, torque = torque_driven.follow(machine, time, motor, load)
    recorded = Measurement(
        name="new",
        time=time,
        motor_position=noisy(states[:, 2], NOISE, 31),
        load_torque=experiment.load_torque,
        signals={"joint_position": noisy(states[:, 0], NOISE, 32), "motor_torque": torque},
    )
    return recorded.to_compare(GIVEN.at(experiment.kind))


def run_held(experiment: Experiment) -> Measurement:
    """Springs that harden, between the motor and the joint of a heavy link."""
    tree = GIVEN.model_dump() | {"effects": HARDENING}
    tree["link"] = {"inertia": HEAVY, "damping": 0.0}
    for side in ("upper_spring", "lower_spring"):
        tree["transmission"][side]["stiffness"] = 8300.0
    time = experiment.time
    joint = CubicSpline(time, experiment.driving["joint_position"])
    motion = Motion(
        float(time[-1]),
        piecewise_linear(time.tolist(), experiment.motor_position.tolist()),
        piecewise_linear(time.tolist(), (HEAVY * joint(time, 2)).tolist()),
    )
    run = record(actuator_of(tree), motion, time, signal_maps_of(tree))
    noise = {"joint_position": NOISE, "joint_torque": 0.02}
    signals = {name: noisy(run[name], sigma, 33) for name, sigma in noise.items()}
    return Measurement(
        time, experiment.motor_position, signals, name="new", given_noise={"joint_torque": 0.02}
    ).to_compare(GIVEN.at("joint"))


def run_axis(experiment: Experiment) -> Measurement:
    """The controller of the axis follows the motion, which begins where the axis stands."""
    place = experiment.driving["joint_position"]
    assert len(place) == round(axis.RATE * experiment.time[-1]) + 1
    run = axis.followed(place - place[0], "nothing", np.random.default_rng(34))
    return Measurement(
        time=run.time,
        load_torque=run.force,
        signals={"joint_position": run.position},
        name="new",
    ).to_compare(WITH_BOTH)


def driven_case(kind: str) -> Case:
    """Friction or cogging of the motor, of a motion that hardly turns."""
    data = drive_recording(RUBBING).window(0.0, SHORT[kind]).to_compare(GIVEN.at(kind))
    answers = {
        "motor_friction": {"torque": 0.02},
        "motor_cogging": {"amplitude": 0.02, "waves": 1, "phase": 0.0},
    }
    models = {name: GIVEN.at(kind).with_effect(name, numbers) for name, numbers in answers.items()}
    return Case(data, {name: (m, free_parameters(m)) for name, m in models.items()}, run_driven)


def held_case() -> Case:
    """Springs that harden, or stiffer ones: the same while they are hardly stretched."""
    data = held(HARDENING).window(0.0, SHORT["joint"]).to_compare(GIVEN.at("joint"))
    base = GIVEN.at("joint")
    harder = base.with_effect("spring_hardening", HARDENING["spring_hardening"])
    models = {"spring_hardening": harder, "stiffness": base}
    return Case(data, {name: (m, free_parameters(m)) for name, m in models.items()}, run_held)


def axis_case() -> Case:
    """Dry friction, or more of the constant force: the same while an axis moves one way."""
    whole = axis_recording("nothing", 1)
    assert SECONDS > 5.0
    forwards = whole.window(3.5, 4.95)
    assert np.diff(forwards.signals["joint_position"][::50]).min() > 0.0
    dry = WITH_BOTH.with_effect("coulomb_friction", {"torque": axis.DRY})
    free = tuple(path for path in free_parameters(dry) if "constant_torque" not in path)
    answers = {
        "coulomb_friction": (dry, free),
        "constant_torque": (WITH_BOTH, free_parameters(WITH_BOTH)),
    }
    return Case(forwards, answers, run_axis)


CASES = {
    "torque": lambda: driven_case("torque"),
    "torque_joint": lambda: driven_case("torque_joint"),
    "joint": held_case,
    "load": axis_case,
}


@cache
def case_of(kind: str) -> Case:
    return CASES[kind]()


def rivals_for(kind: str, data: list[Measurement]) -> tuple[Rival, ...]:
    answers = case_of(kind).answers.items()
    return tuple(Rival(name, fit(model, data, free=free)) for name, (model, free) in answers)


@cache
def proposed(kind: str) -> tuple[tuple[Rival, ...], Experiment]:
    """The rivals on the data at hand, and what is proposed."""
    data = [case_of(kind).data]
    rivals = rivals_for(kind, data)
    experiment = next_experiment(rivals, data)
    assert isinstance(experiment, Experiment), experiment
    return rivals, experiment


def lead_of_first(rivals: tuple[Rival, ...]) -> float:
    """By how much the first of two rivals has the lower BIC, under the noise that it shows."""
    right, wrong = (rival.fit for rival in rivals)
    squares = []
    for found in (right, wrong):
        errors = found.problem.errors(found.vector)
        squares.append(
            sum(
                float(np.sum((values / sigmas[name]) ** 2))
                for one, sigmas in zip(errors, right.sigmas, strict=True)
                for name, values in one.items()
            )
        )
    samples = sum(len(values) for one in errors for values in one.values())
    more = wrong.findings.effective - right.findings.effective
    return squares[1] - squares[0] + more * float(np.log(samples))


@pytest.mark.parametrize("kind", CASES)
def test_data_do_not_decide_and_the_proposed_experiment_does(kind: str) -> None:
    case = case_of(kind)
    rivals, experiment = proposed(kind)
    assert abs(lead_of_first(rivals)) < DECISIVE
    assert experiment.power > 0.95
    new = case.run(experiment)
    after = rivals_for(kind, [case.data, new])
    assert lead_of_first(after) > DECISIVE
    errors = [max(et.compare(one.fit.model, [new]).noise_ratio().values()) for one in after]
    assert errors[0] < 0.8 * errors[1]


@pytest.mark.parametrize("kind", CASES)
def test_columns_are_those_that_drive_the_interface(kind: str, tmp_path) -> None:
    rivals, experiment = proposed(kind)
    expected = {
        "torque": ["motor_position_rad", "load_torque_Nm", "motor_torque_Nm"],
        "torque_joint": ["motor_position_rad", "joint_position_rad", "motor_torque_Nm"],
        "joint": ["motor_position_rad", "joint_position_rad"],
        "load": ["load_torque_N", "joint_position_m"],
    }[kind]
    model = rivals[0].fit.model
    path = tmp_path / "experiment.csv"
    path.write_text(experiment_csv(experiment, model.motion))
    assert path.read_text().splitlines()[0].split(",") == ["time_s", *expected]
    moved = et.simulate(model, read_measurement(str(path), READ).for_model(model))
    assert moved.time[-1] == pytest.approx(experiment.time[-1], abs=1e-6)


@pytest.mark.parametrize("kind", CASES)
def test_it_stays_near_what_was_recorded(kind: str) -> None:
    case, (rivals, experiment) = case_of(kind), proposed(kind)
    limits = limits_of([rival.fit.model for rival in rivals], [case.data]).widened()
    drive = drive_of(experiment.kind)
    if drive is not None:
        torque = experiment.columns[drive.torque]
        recorded = case.data.inputs[drive.torque]
        assert np.abs(torque).max() <= 1.05 * limits.drive
        assert limits.drive == pytest.approx(3.0 * BEYOND_RECORDED * np.abs(recorded).max())
    if experiment.kind.has_springs:
        new = case.run(experiment)
        share = GIVEN.transmission.motor_share
        away = new.joint_position - share * experiment.motor_position
        low, high = limits.springs.deflection
        assert low < away.min() < away.max() < high


def test_under_one_torque_answers_drift_apart() -> None:
    """So a motion is proposed for a controller to follow, and no torque to be played."""
    right, wrong = proposed("load")[1].predictions.values()
    assert abs(right[-1] - wrong[-1]) > 0.5


def test_the_text_says_that_a_controller_follows_and_what_torque_is_expected() -> None:
    text = proposed("torque")[1].text
    assert "Motor: " in text
    assert "Let its controller follow this, and record the motor torque: Motor friction" in text
    assert "Joint, away from where springs hold it: " in proposed("torque_joint")[1].text
    sliding = proposed("load")[1].text
    assert "from rest with the joint at -0.11" in sliding
    assert "record the load force: Coulomb friction expects" in sliding
    assert "controller" not in proposed("joint")[1].text


def test_a_force_element_that_knows_no_link_has_its_experiment_too() -> None:
    """The joint then follows as fast as it was recorded to move."""
    tree = GIVEN.at("joint").model_dump() | {"link": None}
    base = parse_model({name: part for name, part in tree.items() if part is not None}, "x")
    models = {"stiffness": base, "spring_hardening": base.with_effect("spring_hardening", None)}
    data = [held(HARDENING).window(0.0, 0.5).to_compare(base)]
    limits = limits_of([base], data)
    turned = data[0].joint_position - base.transmission.motor_share * data[0].motor_position
    assert limits.springs.frequency == np.inf
    assert 0.1 < limits.frequency < 10.0
    assert limits.joint_side is not None
    assert limits.joint_side.recorded == (turned.min(), turned.max())
    rivals = [Rival(name, fit(model, data)) for name, model in models.items()]
    experiment = next_experiment(rivals, data)
    assert isinstance(experiment, Experiment)
    assert list(experiment.columns) == ["motor_position", "joint_position"]


# ---- parts ---------------------------------------------------------------------------------

STIFF = {"motor_friction": {"torque": 0.05}, "motor_torque_gain": {"error": -0.2}}


@pytest.mark.parametrize("effects", [{}, STIFF], ids=["plain", "friction and gain"])
def test_under_its_torque_the_model_follows_the_motion(effects) -> None:
    model = GIVEN.at("torque")
    for effect_id, numbers in effects.items():
        model = model.with_effect(effect_id, numbers)
    time = np.arange(0.0, 6.0, 4e-3)
    motion = 0.2 + 0.3 * np.sin(1.3 * time) ** 2
    experiment = Measurement(
        name="x",
        time=time,
        motor_position=motion,
        load_torque=0.4 * np.sin(time) ** 2,
        kind=model.kind,
        driving={"motor_torque": np.zeros_like(time)},
    )
    torque = following(model, experiment, at_rest(model, 0.2), motion, 5.0)
    start = {"motor_position": 0.2, "joint_position": 0.2 * model.transmission.motor_share}
    moved = et.simulate(
        model,
        time,
        motor_torque=torque,
        load_torque=experiment.load_torque,
        initial_state=start,
    )
    assert np.abs(moved["motor_position"] - motion).max() < 0.01


def test_at_rest_the_springs_hold_the_link_against_its_weight() -> None:
    """As at interface position, where a static curve tells."""
    heavy = GIVEN.at("torque").with_effect("gravity_load", {"torque": 0.8, "angle": 0.7})
    rest = at_rest(heavy, 0.3)
    time = np.linspace(0.0, 20.0, 4001)
    held_still = et.simulate(
        heavy.at("position"),
        time,
        np.full(4001, 0.3),
        initial_state={"joint_position": rest.position},
    )
    assert np.ptp(held_still["joint_position"]) < 1e-6
    assert rest.motor_position == 0.3
    assert at_rest(GIVEN.at("torque_joint"), 0.3).as_dict(GIVEN.at("torque_joint").kind) == {
        "motor_position": 0.3,
        "motor_velocity": 0.0,
    }
