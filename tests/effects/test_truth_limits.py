"""The product against other physics, with which an effect must agree in a limit or in shape.

Where the agreement of two simulators shows that equations are solved, these show that they are
the right ones: each truth here is an actuator without the effect, or with another law of it.
"""

import copy
import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest

from elastic_tendon.actuator.parameters import parse_model
from elastic_tendon.simulation.simulate import simulate
from truth import signals, solver
from truth.actuator import Actuator, Spring
from truth.catalogue import actuator_of
from truth.friction import Coulomb
from truth.hysteresis import exponential_slip
from truth.signals import Experiment
from truth.solver import Trajectory

DENSER = 20  # product's samples between those compared: the spline's error falls below 1e-10 rad
EXACT = 1e-9  # rad, what two integrators at 1e-10 and 1e-11 gather in a second

JOINT_RADIUS = 0.03  # m
STIFFNESS, PRETENSION, INERTIA = 12_000.0, 70.0, 0.03  # N/m of each side, N, kg m²
TREE = {
    "name": "limit",
    "transmission": {
        "joint_pulley_radius": JOINT_RADIUS,
        "motor_pulley_radius": 0.02,
        "pretension_force": PRETENSION,
        "upper_spring": {"stiffness": STIFFNESS, "max_deflection": 0.02},
        "lower_spring": {"stiffness": STIFFNESS / 2, "parallel": 2, "max_deflection": 0.02},
    },
    "link": {"inertia": INERTIA, "damping": 0.1},
}
# motor motions, rad: through slack, and with both tendons taut
WILD = signals.sines([0.6, 0.15], [1.1, 2.7], [0.0, 0.0])
GENTLE = signals.sines([0.12], [1.1], [0.0])


def tree_with(effects: Mapping[str, Mapping[str, float]]) -> dict:
    return {**copy.deepcopy(TREE), "effects": copy.deepcopy(dict(effects))}


def product(tree: Mapping, experiment: Experiment, time: np.ndarray) -> dict[str, np.ndarray]:
    """The product's outputs at `time` (s), which begins at 0 and has equal steps."""
    fine = np.linspace(0.0, time[-1], DENSER * (time.size - 1) + 1)
    motion = simulate(
        parse_model(tree, "limit"),
        fine,
        [experiment.motor_position.value(t) for t in fine],
        [experiment.load_torque.value(t) for t in fine],
        initial_state={"joint_position": experiment.initial_position},
        interpolation="cubic",
        tolerance=1e-10,
    )
    return {name: motion[name][::DENSER] for name in motion.output_names}


def apart(tree: Mapping, actuator: Actuator, experiment: Experiment) -> float:
    """Largest distance of the product's joint from that of another actuator, rad."""
    time = np.linspace(0.0, experiment.duration, 101)
    expected = solver.simulate(actuator, experiment, time)["joint_position"]
    return float(np.abs(product(tree, experiment, time)["joint_position"] - expected).max())


# ---- hysteresis: another law, matched in stiffness of unloading, height and loss ---------------

LOOP_FORCE, YIELD_LENGTH = 25.0, 0.0004  # N, m
ELEMENTS = 10
PERIOD = 1.0  # s
# a period after the load has come in fully, beginning before its largest value
LOOP_TIME = np.linspace(0.0, 2.1, 1051)
LAST_PERIOD = (LOOP_TIME > 1.1 - 1e-9) & (LOOP_TIME < 2.1 + 1e-9)


@pytest.fixture(scope="module")
def loops() -> tuple[dict[str, np.ndarray], Trajectory]:
    """A slow loop of the product with Bouc-Wen, and of the truth with Maxwell-slip elements.

    Of an amplitude A well above y, Bouc-Wen loses f (4 A - 5 y) and an exponential Maxwell-slip
    law 4 f (A - 2 y'); with y' = 5/8 y they lose the same.
    """
    tree = tree_with({"spring_hysteresis": {"force": LOOP_FORCE, "yield_length": YIELD_LENGTH}})
    # of two parallel springs each has the effect; so that both sides are alike, halve it there
    tree["transmission"]["lower_spring"] |= {"stiffness": STIFFNESS, "parallel": 1}
    tree["link"]["damping"] = 0.8
    load = signals.product(
        signals.smooth_step(0.0, 0.3, 1.0), signals.sines([3.7], [1.0 / PERIOD], [0.0])
    )
    experiment = Experiment(LOOP_TIME[-1], signals.constant(0.0), load)
    slip = exponential_slip(LOOP_FORCE, 0.625 * YIELD_LENGTH, ELEMENTS)
    spring = Spring(STIFFNESS, hysteresis=slip)
    actuator = replace(actuator_of(tree), upper=spring, lower=spring)
    expected = solver.simulate(actuator, experiment, LOOP_TIME, tolerance=1e-9)
    assert set(expected["slack_state"]) == {3}
    return product(tree, experiment, LOOP_TIME), expected


def loss(run: Mapping[str, np.ndarray] | Trajectory) -> float:
    """Energy that the springs turn into heat in the last period, J."""
    torque, position = run["joint_torque"][LAST_PERIOD], run["joint_position"][LAST_PERIOD]
    return -float(np.trapezoid(torque, position))


def test_bouc_wen_loses_what_its_law_says(loops):
    actual, _ = loops
    amplitude = 0.5 * JOINT_RADIUS * np.ptp(actual["joint_position"][LAST_PERIOD])
    expected = 2 * LOOP_FORCE * (4.0 * amplitude - 5.0 * YIELD_LENGTH)
    # at both ends of the loop z is ±1 but for this share
    assert math.exp(-(2.0 * amplitude - YIELD_LENGTH) / YIELD_LENGTH) < 1e-5
    # trapezoids of a thousand samples
    assert loss(actual) == pytest.approx(expected, rel=1e-3)


def test_bouc_wen_loses_as_much_as_maxwell_slip_elements(loops):
    actual, expected = loops
    # saturated at the ends they turn at the same places; with y' = y the losses would be 11 % apart
    assert loss(actual) == pytest.approx(loss(expected), rel=1e-3)


def test_bouc_wen_has_the_shape_of_maxwell_slip(loops):
    # friction torque as the distance from the elastic line, on the way down and on the way up
    elastic = 2.0 * STIFFNESS * JOINT_RADIUS**2
    height = 2.0 * LOOP_FORCE * JOINT_RADIUS
    curves = []
    for run in loops:
        position = run["joint_position"][LAST_PERIOD]
        friction = (-run["joint_torque"][LAST_PERIOD] - elastic * position) / height
        top, bottom = int(np.argmax(position)), int(np.argmin(position))
        assert top < bottom
        start = position[top]
        grid = np.linspace(0.0, 0.9 * (start - position[bottom]), 200)
        travel = start - position[top : bottom + 1]
        curves.append(np.interp(grid, travel, friction[top : bottom + 1]))
    bouc_wen, slip = curves
    # closed forms differ by at most 0.16 where z crosses zero: 1 - u against 2 exp(-0.8 u) - 1;
    # steps of ten elements add up to a twentieth
    difference = np.abs(bouc_wen - slip)
    assert 0.1 < difference.max() < 0.21
    # and not at all where both are saturated
    assert difference[-20:].max() < 0.02
    assert bouc_wen[-1] == pytest.approx(-1.0, abs=0.01)


# ---- friction ----------------------------------------------------------------------------------


def test_stiff_bristles_are_stribeck_friction():
    numbers = {"coulomb_torque": 0.5, "static_torque": 0.8, "stribeck_velocity": 0.5}
    motor = signals.total(signals.smooth_step(0.05, 0.15, 0.9), signals.smooth_step(0.6, 0.2, -1.8))
    experiment = Experiment(1.2, motor, signals.sines([0.3], [1.3], [0.0]))
    actuator = actuator_of(tree_with({"stribeck_friction": numbers}))

    def error(stiffness: float) -> float:
        damping = math.sqrt(stiffness * INERTIA)  # half the critical
        bristles = {"bristle_stiffness": stiffness, "bristle_damping": damping}
        return apart(tree_with({"lugre_friction": numbers | bristles}), actuator, experiment)

    soft, stiff = error(3e3), error(3e5)
    # a joint that comes to rest on bristles swings on by what its last velocity gives, which
    # falls as the root of their stiffness; their static deflection falls faster
    assert 8.0 < soft / stiff < 20.0
    assert stiff < 5e-4


def test_guides_of_equal_taut_springs_are_coulomb_friction():
    # F_1 + F_2 = 2 F_p is constant, so that the guides' friction is 2 R F_p sinh w, and the
    # difference of the tensions counts cosh w times; both exactly
    wrap = 0.15
    tree = tree_with({"tendon_guide_friction": {"wrap_friction": wrap}})
    experiment = Experiment(1.2, GENTLE, signals.sines([0.5], [1.9], [0.0]))
    spring = Spring(STIFFNESS * math.cosh(wrap))
    base = actuator_of(tree)
    friction = Coulomb(2.0 * JOINT_RADIUS * PRETENSION * math.sinh(wrap))
    coulomb = replace(
        base,
        wrap_friction=0.0,
        upper=spring,
        lower=spring,
        pretension_force=PRETENSION * math.cosh(wrap),
        link=replace(base.link, friction=friction),
    )
    run = solver.simulate(coulomb, experiment, np.linspace(0.0, 1.2, 121))
    assert set(run["slack_state"]) == {3}
    assert any(event.after.direction == 0 for event in run.events)
    assert apart(tree, coulomb, experiment) < EXACT


# ---- springs and tendons -----------------------------------------------------------------------


def test_compliant_tendons_with_undamped_springs_are_softer_springs():
    # exactly, through slack too: l_p + c F_p is the prestretched length of the softer spring
    compliance = 2e-5
    tree = tree_with({"tendon_compliance": {"compliance": compliance}})
    experiment = Experiment(1.2, WILD, signals.sines([1.0], [1.9], [0.0]))
    spring = Spring(1.0 / (1.0 / STIFFNESS + compliance))
    softer = replace(actuator_of(tree), upper=spring, lower=spring)
    run = solver.simulate(softer, experiment, np.linspace(0.0, 1.2, 121))
    assert set(run["slack_state"]) == {1, 2, 3}
    assert apart(tree, softer, experiment) < EXACT


def test_quick_relaxation_is_damping():
    # a branch far faster than the motion carries k_m T e'
    damping = 6.0  # N s/m of one side
    base = actuator_of(tree_with({}))
    experiment = Experiment(0.8, GENTLE)
    damped = replace(base, upper=replace(base.upper, damping=damping))
    damped = replace(damped, lower=replace(base.lower, damping=damping))

    def error(time_constant: float) -> float:
        numbers = {"stiffness": damping / time_constant, "time_constant": time_constant}
        tree = tree_with({"spring_relaxation": numbers})
        tree["transmission"]["lower_spring"] |= {"stiffness": STIFFNESS, "parallel": 1}
        return apart(tree, damped, experiment)

    slow, quick = error(4e-3), error(4e-4)
    # what is left is a delay of the force by T
    assert slow / quick == pytest.approx(10.0, rel=0.1)
    assert quick < 1e-4


def test_slow_relaxation_is_a_stiffer_spring():
    # a branch far slower than the motion is a spring beside, relaxed at the start
    stiffness = 4000.0
    base = actuator_of(tree_with({}))
    experiment = Experiment(0.8, GENTLE)

    def beside(time: float, position: float, _velocity: float) -> float:
        displacement = 0.02 * GENTLE.value(time) - JOINT_RADIUS * position
        return 2.0 * JOINT_RADIUS * stiffness * displacement

    stiffer = replace(base, link=replace(base.link, extra_torque=beside))

    def error(time_constant: float) -> float:
        numbers = {"stiffness": stiffness, "time_constant": time_constant}
        tree = tree_with({"spring_relaxation": numbers})
        tree["transmission"]["lower_spring"] |= {"stiffness": STIFFNESS, "parallel": 1}
        return apart(tree, stiffer, experiment)

    # what has crept is of the order of the duration over T
    soon, late = error(20.0), error(200.0)
    assert soon / late == pytest.approx(10.0, rel=0.1)
    assert late < 1e-4


def test_light_springs_are_springs_without_mass():
    # taut; a middle mass adds half of it to each end, to first order
    experiment = Experiment(0.5, signals.constant(0.0), initial_position=0.1)
    base = actuator_of(tree_with({}))

    def tree(mass: float) -> dict:
        heavy = tree_with({"spring_mass": {"mass": mass, "damping": 0.0}})
        heavy["transmission"]["lower_spring"] |= {"stiffness": STIFFNESS, "parallel": 1}
        return heavy

    def error(mass: float, actuator: Actuator) -> float:
        return apart(tree(mass), actuator, experiment)

    mass = 1e-3
    # with the motor held the middle moves at half the joint's speed: a quarter of the mass counts
    added = 2.0 * 0.25 * mass * JOINT_RADIUS**2
    heavier = replace(base, link=replace(base.link, inertia=INERTIA + added))
    assert error(mass, base) > 5.0 * error(mass, heavier)
    assert error(mass, base) / error(0.1 * mass, base) == pytest.approx(10.0, rel=0.2)
