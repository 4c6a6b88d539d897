"""The truth's effects against closed forms, energy and integrals of their own."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp
from scipy.special import ellipk

from truth.actuator import Actuator, Eccentricity, Link, Overstretch, Spring
from truth.friction import Coulomb, LuGre, Stribeck, guide_loss
from truth.hysteresis import BoucWen, Hysteresis, MaxwellSlip, exponential_slip
from truth.link import Gravity, Stop
from truth.recording import SignalMaps, record
from truth.signals import Experiment, constant, later, piecewise_linear, sines, smooth_step
from truth.solver import Trajectory, simulate
from truth.spring import LumpedMass, Relaxation
from truth.tendon import Reach, Tendon, TendonMode

POSITION_ERROR = 1e-9  # rad, integration error at the default tolerance of 1e-11
EVENT_TIME_ERROR = 1e-9  # s
ENERGY_ERROR = 1e-9  # relative, likewise

RADIUS, INERTIA, PRETENSION = 0.04, 0.025, 60.0  # m, kg m², N
UPPER, LOWER = Spring(9000.0), Spring(6500.0)
UNLIKE = Actuator(RADIUS, 0.025, PRETENSION, UPPER, LOWER, Link(INERTIA))
EVEN = Actuator(RADIUS, RADIUS, PRETENSION, UPPER, UPPER, Link(INERTIA))
TAUT_STIFFNESS = 2.0 * RADIUS**2 * UPPER.stiffness  # of EVEN, N·m/rad
# springs that move the joint by less than the position error
WEAK = Spring(stiffness=1e-9)


def free_body(link: Link) -> Actuator:
    """A link that no spring holds."""
    return Actuator(RADIUS, RADIUS, 1e-8, WEAK, WEAK, link)


def elastic_energy(spring: Spring, elongation: np.ndarray) -> np.ndarray:
    """Energy of a taut spring that hardens and has a string, J."""
    taut = np.maximum(elongation, 0.0)
    energy: np.ndarray = 0.5 * spring.stiffness * taut**2 + 0.25 * spring.cubic_stiffness * taut**4
    if spring.overstretch is not None:
        excess = np.maximum(taut - spring.overstretch.engagement, 0.0)
        energy += 0.5 * spring.overstretch.stiffness * excess**2
    return energy


def mechanical_energy(actuator: Actuator, run: Trajectory) -> np.ndarray:
    """Energy of link and springs with the motor at zero and without play, J."""
    travel = actuator.joint_pulley_radius * run["joint_position"]
    energy: np.ndarray = (
        0.5 * actuator.link.inertia * run["joint_velocity"] ** 2
        + elastic_energy(actuator.upper, actuator.rest_length(actuator.upper) - travel)
        + elastic_energy(actuator.lower, actuator.rest_length(actuator.lower) + travel)
    )
    return energy


# ---- friction ----------------------------------------------------------------------------------

COULOMB, STATIC, STRIBECK_VELOCITY = 0.5, 0.8, 0.3
STRIBECK = Stribeck(COULOMB, STATIC, STRIBECK_VELOCITY)


def sliding(velocity: float) -> float:
    return COULOMB + (STATIC - COULOMB) * math.exp(-((velocity / STRIBECK_VELOCITY) ** 2))


def test_a_body_on_stribeck_friction_stops_when_its_momentum_is_spent() -> None:
    speed = 2.0
    body = free_body(Link(INERTIA, friction=STRIBECK))
    run = simulate(body, Experiment(0.2, constant(0.0), initial_velocity=speed), np.array([0.2]))
    (stop,) = run.events
    duration = INERTIA * quad(lambda v: 1.0 / sliding(v), 0.0, speed, epsabs=1e-13)[0]
    distance = INERTIA * quad(lambda v: v / sliding(v), 0.0, speed, epsabs=1e-13)[0]
    assert stop.time == pytest.approx(duration, abs=EVENT_TIME_ERROR)
    assert run["joint_position"][-1] == pytest.approx(distance, abs=POSITION_ERROR)


def test_stribeck_friction_holds_up_to_the_static_torque() -> None:
    actuator = replace(EVEN, link=Link(INERTIA, friction=STRIBECK))
    ramp = piecewise_linear([0.0, 1.0], [0.0, 0.1])
    run = simulate(actuator, Experiment(1.0, ramp), np.linspace(0.0, 1.0, 101))
    release = STATIC / (TAUT_STIFFNESS * 0.1)
    assert run.events[0].time == pytest.approx(release, abs=EVENT_TIME_ERROR)
    assert run.events[0].after.direction == 1
    assert np.all(run["joint_position"][run.time < release] == 0.0)


def test_bristles_are_springs_at_first_and_slip_at_the_stribeck_torque() -> None:
    # a slow load bends them; a joint dragged along slides at g(v)
    stiffness = 400.0
    friction = LuGre(COULOMB, STATIC, STRIBECK_VELOCITY, stiffness, damping=2.0)
    body = free_body(Link(INERTIA, friction=friction, damping=1.0))
    load = smooth_step(0.0, 0.5, 1e-3)
    run = simulate(body, Experiment(3.0, constant(0.0), load), np.array([3.0]))
    # the bristle has slipped by a share torque / static of its deflection, once, at the most
    assert run["joint_position"][-1] == pytest.approx(1e-3 / stiffness, rel=2e-3)

    dragged = replace(EVEN, link=Link(INERTIA, friction=friction, damping=2.0))
    speed = 0.2
    ramp = piecewise_linear([0.0, 1.0], [0.0, speed])
    run = simulate(dragged, Experiment(4.0, ramp), np.array([3.9, 4.0]))
    # the transient falls as exp(-(damping + g') t / 2 J), at the falling slope g' = -0.9 to 1e-30
    assert run["joint_velocity"] == pytest.approx(np.full(2, speed), abs=1e-9)
    assert run["friction_torque"] == pytest.approx(np.full(2, sliding(speed)), abs=1e-8)


def test_stiffer_bristles_come_nearer_to_stribeck_friction() -> None:
    experiment = Experiment(0.7, sines([0.15], [1.5], [0.0]))
    time = np.linspace(0.0, 0.7, 141)

    def positions(friction: Stribeck | LuGre) -> np.ndarray:
        actuator = replace(EVEN, link=Link(INERTIA, friction=friction))
        return simulate(actuator, experiment, time, tolerance=1e-9)["joint_position"]

    stribeck = positions(STRIBECK)

    def difference(stiffness: float) -> float:
        damping = math.sqrt(stiffness * INERTIA)
        lugre = LuGre(COULOMB, STATIC, STRIBECK_VELOCITY, stiffness, damping)
        return float(np.max(np.abs(positions(lugre) - stribeck)))

    # between the root, of the swing after a stop, and the first power, of the static deflection
    soft, stiff = difference(1e3), difference(1e4)
    assert math.sqrt(10.0) * 0.9 < soft / stiff < 11.0
    assert stiff < 5e-3


@pytest.mark.parametrize("direction", [-1, 1])
def test_guides_take_what_the_capstan_equation_says(direction: int) -> None:
    wrap, upper, lower = 0.3, 70.0, 25.0
    after = upper * math.exp(-direction * wrap) - lower * math.exp(direction * wrap)
    loss = upper - lower - after
    assert guide_loss(wrap, direction, upper, lower) == pytest.approx(loss, rel=1e-12)


def test_guides_make_the_swing_shorter_by_the_same_at_every_turn_and_hold_at_last() -> None:
    # equal taut springs: F_1 + F_2 = 2 F_p, so friction is constant and the stiffness cosh w times
    wrap = 0.05
    actuator = replace(EVEN, wrap_friction=wrap)
    stiffness = TAUT_STIFFNESS * math.cosh(wrap)
    torque = 2.0 * RADIUS * PRETENSION * math.sinh(wrap)
    start, lost = 0.06, 2.0 * torque / stiffness
    turns = math.ceil((start - lost / 2) / lost)
    half = math.pi * math.sqrt(INERTIA / stiffness)
    held = Experiment(2.0, constant(0.0), initial_position=start)
    run = simulate(actuator, held, np.array([*(np.arange(turns + 1) * half), 2.0]))
    expected = [(-1) ** n * (start - n * lost) for n in range(turns + 1)]
    np.testing.assert_allclose(
        run["joint_position"], [*expected, expected[-1]], rtol=0, atol=POSITION_ERROR
    )
    assert run.events[-1].after.direction == 0
    # at rest the guides carry what the springs pull, and the joint sees nothing
    assert run["joint_torque"][-1] == pytest.approx(0.0, abs=1e-9)


def test_frictions_of_guides_and_joint_add_up() -> None:
    wrap, torque = 0.05, 0.2
    actuator = replace(EVEN, wrap_friction=wrap, link=Link(INERTIA, friction=Coulomb(torque)))
    ramp = piecewise_linear([0.0, 1.0], [0.0, 0.05])
    run = simulate(actuator, Experiment(1.0, ramp), np.array([1.0]))
    bound = torque + 2.0 * RADIUS * PRETENSION * math.sinh(wrap)
    # the upper tendon's guide holds 1 - exp(-w) of it, the lower one's exp(w) - 1
    release = bound / (TAUT_STIFFNESS * math.cosh(wrap) * 0.05)
    assert run.events[0].time == pytest.approx(release, abs=EVENT_TIME_ERROR)


# ---- surroundings of the link ------------------------------------------------------------------


def test_drag_slows_a_body_as_a_hyperbola() -> None:
    coefficient, speed = 0.02, -6.0
    body = free_body(Link(INERTIA, drag=coefficient))
    time = np.linspace(0.0, 1.0, 11)
    run = simulate(body, Experiment(1.0, constant(0.0), initial_velocity=speed), time)
    expected = speed / (1.0 + coefficient * abs(speed) * time / INERTIA)
    np.testing.assert_allclose(run["joint_velocity"], expected, rtol=0, atol=POSITION_ERROR)


def test_cubic_damping_slows_a_body_by_a_square_root() -> None:
    coefficient, speed = 0.003, -6.0
    body = free_body(Link(INERTIA, cubic_damping=coefficient))
    time = np.linspace(0.0, 1.0, 11)
    run = simulate(body, Experiment(1.0, constant(0.0), initial_velocity=speed), time)
    expected = speed / np.sqrt(1.0 + 2.0 * coefficient * speed**2 * time / INERTIA)
    np.testing.assert_allclose(run["joint_velocity"], expected, rtol=0, atol=POSITION_ERROR)


def test_a_constant_torque_accelerates_a_body() -> None:
    torque = -0.07
    body = free_body(Link(INERTIA, constant_torque=torque))
    time = np.linspace(0.0, 1.0, 11)
    run = simulate(body, Experiment(1.0, constant(0.0)), time)
    expected = 0.5 * torque / INERTIA * time**2
    np.testing.assert_allclose(run["joint_position"], expected, rtol=0, atol=POSITION_ERROR)


def test_gravity_makes_a_pendulum() -> None:
    torque, angle, amplitude = 0.9, 0.7, 1.9
    body = free_body(Link(INERTIA, gravity=Gravity(torque, angle)))
    period = 4.0 * math.sqrt(INERTIA / torque) * ellipk(math.sin(amplitude / 2.0) ** 2)
    released = Experiment(period, constant(0.0), initial_position=amplitude - angle)
    run = simulate(body, released, np.array([0.0, 0.5 * period, period]))
    expected = np.array([amplitude, -amplitude, amplitude]) - angle
    np.testing.assert_allclose(run["joint_position"], expected, rtol=0, atol=POSITION_ERROR)


@pytest.mark.parametrize("side", [-1, 1])
@pytest.mark.parametrize("ratio", [0.0, 0.3])
def test_a_stop_throws_back_by_its_restitution(side: int, ratio: float) -> None:
    # a spring and damper that never pull: contact ends when the deceleration does, before depth 0
    stiffness, gap, speed = 300.0, 0.05, 2.0
    frequency = math.sqrt(stiffness / INERTIA)
    stop = Stop(-gap, gap, stiffness, damping=2.0 * ratio * math.sqrt(stiffness * INERTIA))
    body = free_body(Link(INERTIA, stop=stop))
    damped = frequency * math.sqrt(1.0 - ratio**2)
    contact = math.atan2(2.0 * ratio * math.sqrt(1.0 - ratio**2), 2.0 * ratio**2 - 1.0) / damped
    after = (
        speed
        * math.exp(-ratio * frequency * contact)
        * (math.cos(damped * contact) - ratio * frequency / damped * math.sin(damped * contact))
    )
    hit = gap / speed
    experiment = Experiment(0.2, constant(0.0), initial_velocity=side * speed)
    run = simulate(body, experiment, np.array([hit + contact + 0.01]))
    times = [event.time for event in run.events[:2]]
    assert times == pytest.approx([hit, hit + contact], abs=EVENT_TIME_ERROR)
    assert run["joint_velocity"][0] == pytest.approx(side * after, abs=1e-8)
    assert side * after < 0.0 if side > 0 else side * after > 0.0


# ---- springs -----------------------------------------------------------------------------------


def test_hardening_springs_with_strings_keep_their_energy_through_slack() -> None:
    string = Overstretch(0.012, 20_000.0)
    upper = replace(UPPER, cubic_stiffness=3e7, overstretch=string)
    actuator = replace(UNLIKE, upper=upper, lower=replace(LOWER, cubic_stiffness=1e7))
    thrown = Experiment(2.0, constant(0.0), initial_velocity=14.0)
    run = simulate(actuator, thrown, np.linspace(0.0, 2.0, 401))
    assert set(run["slack_state"]) == {1, 2, 3}
    energy = mechanical_energy(actuator, run)
    assert np.ptp(energy) < ENERGY_ERROR * energy[0]


FORCE, YIELD_LENGTH = 40.0, 0.002  # N, m
# an elongation with large and small turns, and its rate
PATH = ([0.004, 0.0015], [0.5, 1.7], [0.0, 0.4])


def followed(law: Hysteresis, path: np.ndarray) -> np.ndarray:
    """Force (N) of a law along elongations (m) that lie close together."""
    branch = law.begin(float(path[0]))
    forces = [law.force(branch, float(path[0]))]
    for before, now in pairwise(path.tolist()):
        if (now - before) * branch.direction < 0.0:
            branch = law.continued(branch, before, before, -branch.direction)
        while branch.direction * (now - branch.end) > 0.0:
            branch = law.passed(branch)
        forces.append(law.force(branch, now))
    return np.array(forces)


@pytest.mark.parametrize("exponent", [0.6, 1.0, 1.6, 2.0, 4.0])
def test_branches_are_bouc_wens_law(exponent: float) -> None:
    signal = sines(*PATH)

    def rate(time: float, state: np.ndarray) -> list[float]:
        speed = signal.rate(time) / YIELD_LENGTH
        loading = speed * state[0] > 0.0
        return [speed * (1.0 - abs(state[0]) ** exponent) if loading else speed]

    time = np.linspace(0.0, 4.0, 40_001)
    solution = solve_ivp(
        rate, (0.0, 4.0), [0.0], t_eval=time, max_step=1e-3, rtol=1e-10, atol=1e-12
    )
    path = np.array([signal.value(t) for t in time])
    law = BoucWen(FORCE, YIELD_LENGTH, exponent)
    # a sample misses the turn itself by up to e'' dt² / 8 = 2e-10 m, that is 1e-7 of z; a dozen
    # turns, and as much for the integrator, which meets kinks in its right-hand side
    np.testing.assert_allclose(followed(law, path) / FORCE, solution.y[0], rtol=0, atol=3e-6)


def swept(law: Hysteresis, turns: list[float]) -> tuple[np.ndarray, np.ndarray]:
    """Elongations and forces along straight ways between elongations (m) of turning."""
    pieces = [np.linspace(a, b, 4001)[1:] for a, b in pairwise(turns)]
    path = np.concatenate([[turns[0]], *pieces])
    return path, followed(law, path)


AMPLITUDE = 10.0 * YIELD_LENGTH
LAWS: dict[str, tuple[Hysteresis, float]] = {
    # a law and what a loop of AMPLITUDE loses, J
    "bouc-wen": (
        BoucWen(FORCE, YIELD_LENGTH), FORCE * (4.0 * AMPLITUDE - 5.0 * YIELD_LENGTH)
    ),
    "maxwell-slip": (
        exponential_slip(FORCE, YIELD_LENGTH, 12), 4.0 * FORCE * (AMPLITUDE - 2.0 * YIELD_LENGTH)
    ),
}  # fmt: skip


@pytest.mark.parametrize(("law", "lost"), LAWS.values(), ids=LAWS.keys())
def test_a_loop_loses_its_area(law: Hysteresis, lost: float) -> None:
    path, force = swept(law, [0.0, AMPLITUDE, -AMPLITUDE, AMPLITUDE])
    loop = slice(4000, None)
    # trapezoids of steps of y / 200
    assert np.trapezoid(force[loop], path[loop]) == pytest.approx(lost, rel=1e-4)


def test_maxwell_slip_elements_begin_as_an_exponential_and_remember_turns() -> None:
    law = exponential_slip(FORCE, YIELD_LENGTH, 12)
    path, force = swept(law, [0.0, AMPLITUDE])
    expected = FORCE * (1.0 - np.exp(-path / YIELD_LENGTH))
    # twelve steps of a twelfth of the force, of which most of one may be missing on the way
    assert np.abs(force - expected).max() < FORCE / 24
    # an inner loop closes, and what follows is as if it had not been (return-point memory)
    small = [0.0, 0.004, 0.001, 0.003, 0.001, 0.006]
    with_loop = swept(law, small)[1][-1]
    without = swept(law, [0.0, 0.006])[1][-1]
    assert with_loop == pytest.approx(without, abs=1e-9)
    # which Bouc-Wen's law does not have: so the two are different physics
    bouc_wen = BoucWen(FORCE, YIELD_LENGTH)
    assert abs(swept(bouc_wen, small)[1][-1] - swept(bouc_wen, [0.0, 0.006])[1][-1]) > 0.05


def test_half_a_spring_bears_the_same_force_at_half_the_elongation() -> None:
    whole = Spring(
        9000.0,
        damping=4.0,
        overstretch=Overstretch(0.003, 5000.0),
        cubic_stiffness=2e7,
        hysteresis=MaxwellSlip((4000.0, 1000.0), (5.0, 3.0)),
        relaxation=Relaxation(2000.0, 0.1),
    )
    half = whole.half()
    for elongation in (-0.002, 0.001, 0.005):
        engaged = elongation > 0.003
        force = whole.static_force(elongation, engaged)
        assert half.static_force(0.5 * elongation, engaged) == pytest.approx(force)
    assert half.hysteresis is not None
    assert whole.hysteresis is not None
    forces = [swept(whole.hysteresis, [0.0, 0.003])[1], swept(half.hysteresis, [0.0, 0.0015])[1]]
    np.testing.assert_allclose(forces[0], forces[1], rtol=1e-12)
    assert half.damping * 0.5 == pytest.approx(whole.damping)


def test_a_relaxing_spring_carries_the_hereditary_integral() -> None:
    # F_m = k_m ∫ exp(-(t - s) / T) e'(s) ds of the elongation that was simulated
    stiffness, constant_ = 3000.0, 0.08
    relaxing = replace(UPPER, relaxation=Relaxation(stiffness, constant_))
    actuator = replace(EVEN, upper=relaxing, link=Link(INERTIA, damping=0.2))
    experiment = Experiment(1.0, sines([0.1], [1.3], [0.0]))
    time = np.linspace(0.0, 1.0, 2001)
    run = simulate(actuator, experiment, time)
    assert set(run["slack_state"]) == {3}
    elongation = PRETENSION / UPPER.stiffness + RADIUS * (
        run["motor_position"] - run["joint_position"]
    )
    rate = RADIUS * (run["motor_velocity"] - run["joint_velocity"])
    ends = range(200, 2001, 200)
    branch = np.array([
        stiffness * np.trapezoid(np.exp((time[:i] - time[i - 1]) / constant_) * rate[:i], time[:i])
        for i in ends
    ])  # fmt: skip
    last = np.array(ends) - 1
    expected = UPPER.stiffness * elongation[last] + branch
    # trapezoids: (0.5 ms)² / 12 times k_m T and the second derivative of e', up to 400 m/s³
    np.testing.assert_allclose(run["upper_spring_force"][last], expected, rtol=0, atol=3e-3)
    assert np.abs(branch).max() > 1.0


def test_a_slack_relaxing_spring_creeps_back_freely() -> None:
    # no force: k e + k_m (e - c) = 0, so c' = -c k / ((k + k_m) T)
    stiffness, time_constant, creep = 4000.0, 0.2, 0.005
    tendon = Tendon(replace(UPPER, relaxation=Relaxation(stiffness, time_constant)))
    total = UPPER.stiffness + stiffness
    slack, away = TendonMode(taut=False), Reach(-0.1, 0.0)
    start = stiffness * (stiffness * creep / total - creep)  # k_m (e - c)
    solution = solve_ivp(
        lambda _t, state: tendon.rates(slack, away, state), (0.0, 0.3), [start],
        rtol=1e-10, atol=1e-12,
    )  # fmt: skip
    fading = math.exp(-0.3 * UPPER.stiffness / (total * time_constant))
    last = solution.y[:, -1]
    assert last[0] == pytest.approx(start * fading, rel=1e-7)
    expected = stiffness * creep * fading / total
    assert tendon.elongation(slack, away, last) == pytest.approx(expected, rel=1e-7)
    # taut again exactly there
    for beyond in (-1e-9, 1e-9):
        pull = tendon.pull(slack, Reach(expected + beyond, 0.0), last)
        assert math.copysign(1.0, pull) == math.copysign(1.0, beyond)


def test_friction_inside_a_slack_spring_keeps_it_stretched() -> None:
    # after a wide swing a spring is slack until it is drawn beyond f z / k, and then as it was left
    law = BoucWen(FORCE, YIELD_LENGTH)
    actuator = replace(EVEN, upper=replace(UPPER, hysteresis=law))
    away = Experiment(0.5, constant(0.0), initial_position=0.0, initial_velocity=9.0)
    run = simulate(actuator, away, np.linspace(0.0, 0.5, 50_001))
    length = PRETENSION / UPPER.stiffness - RADIUS * run["joint_position"]
    slack = run["slack_state"] == 2
    assert slack.any()
    edges = np.flatnonzero(np.diff(slack.astype(int)))[:2]
    # no damper: goes slack and gets taut at the same length, at which friction balances the spring
    left, returned = length[edges]
    # samples 1e-5 s apart at up to 0.4 m/s
    assert left == pytest.approx(returned, abs=1e-5)
    z = -1.0 + math.exp((left - length[0]) / YIELD_LENGTH)
    assert UPPER.stiffness * left == pytest.approx(-FORCE * z, abs=UPPER.stiffness * 1e-5)


def test_a_mass_in_each_spring_swings_as_three_bodies_do() -> None:
    # small motion with the motor held: link and two masses, modes of a 3 by 3 matrix
    mass = 0.05
    lumped = LumpedMass(mass)
    actuator = replace(
        UNLIKE, upper=replace(UPPER, lumped=lumped), lower=replace(LOWER, lumped=lumped)
    )
    k_1, k_2 = 2.0 * UPPER.stiffness, 2.0 * LOWER.stiffness
    stiffness = np.array([
        [RADIUS**2 * (k_1 + k_2), -RADIUS * k_1, RADIUS * k_2],
        [-RADIUS * k_1, 2.0 * k_1, 0.0],
        [RADIUS * k_2, 0.0, 2.0 * k_2],
    ])  # fmt: skip
    inverse = np.diag([1.0 / INERTIA, 1.0 / mass, 1.0 / mass])
    speed = 0.5
    # the masses start with the mean velocity of their ends
    start = np.array([speed, 0.5 * RADIUS * speed, -0.5 * RADIUS * speed])
    values, vectors = np.linalg.eig(inverse @ stiffness)
    frequencies, shares = np.sqrt(values.real), np.linalg.solve(vectors, start)
    time = np.linspace(0.0, 0.2, 41)
    expected = (np.sin(np.outer(time, frequencies)) / frequencies * shares) @ vectors[0]
    run = simulate(actuator, Experiment(0.2, constant(0.0), initial_velocity=speed), time)
    assert not run.events
    np.testing.assert_allclose(run["joint_position"], expected, rtol=0, atol=POSITION_ERROR)


def test_compliant_tendons_with_damped_springs_follow_the_transfer_function() -> None:
    compliance, damping = 3e-5, 200.0
    spring = replace(UPPER, damping=damping, compliance=compliance)
    actuator = replace(EVEN, upper=spring, lower=spring, link=Link(INERTIA, damping=0.6))
    amplitude, frequency = 0.03, 3.0
    s = 2j * math.pi * frequency
    series = 1.0 / (compliance + 1.0 / (UPPER.stiffness + damping * s))
    elastic = 2.0 * RADIUS**2 * series
    response = elastic / (INERTIA * s**2 + 0.6 * s + elastic)
    time = np.linspace(2.0, 2.3, 61)
    run = simulate(actuator, Experiment(2.3, sines([amplitude], [frequency], [0.0])), time)
    expected = amplitude * np.imag(response * np.exp(s * time))
    # what is left of the transient after 2 s
    assert math.exp(-0.6 / (2.0 * INERTIA) * 2.0) * amplitude < POSITION_ERROR
    np.testing.assert_allclose(run["joint_position"], expected, rtol=0, atol=POSITION_ERROR)


def test_a_slack_tendon_does_not_push_its_damped_spring() -> None:
    tendon = Tendon(replace(UPPER, damping=200.0, compliance=3e-5))
    slack, away = TendonMode(taut=False), Reach(-0.1, -1.0)
    solution = solve_ivp(
        lambda _t, state: tendon.rates(slack, away, state), (0.0, 0.02), [0.004],
        rtol=1e-10, atol=1e-12,
    )  # fmt: skip
    expected = 0.004 * math.exp(-0.02 * UPPER.stiffness / 200.0)
    assert solution.y[0, -1] == pytest.approx(expected, rel=1e-7)
    assert tendon.tension(slack, away, solution.y[:, -1]) == 0.0


# ---- motor pulley ------------------------------------------------------------------------------


def test_a_joint_drifts_freely_within_the_play() -> None:
    # equal springs without torque at x = 0: a pulley in its play follows the joint
    gap, speed = 0.1, 0.7
    actuator = replace(EVEN, gap=gap)
    held = Experiment(0.3, constant(0.0), initial_velocity=speed)
    half = 0.5 * gap / speed
    swing = math.pi * math.sqrt(INERTIA / TAUT_STIFFNESS)
    samples = np.array([0.5 * half, half + 0.5 * swing, half + swing + 0.5 * half])
    run = simulate(actuator, held, samples)
    depth = speed * math.sqrt(INERTIA / TAUT_STIFFNESS)
    expected = [0.25 * gap, 0.5 * gap + depth, 0.25 * gap]
    np.testing.assert_allclose(run["joint_position"], expected, rtol=0, atol=POSITION_ERROR)
    touches = [event.time for event in run.events[:2]]
    assert touches == pytest.approx([half, half + swing], abs=EVENT_TIME_ERROR)
    assert [event.after.tooth for event in run.events[:2]] == [1, 0]


def test_play_between_unlike_hardening_springs_is_about_where_they_pull_alike() -> None:
    # they do not pull alike at the pretensioned lengths; energy stays all the same
    actuator = replace(
        UNLIKE,
        upper=replace(UPPER, cubic_stiffness=3e7),
        lower=replace(LOWER, cubic_stiffness=1e7),
        gap=0.05,
    )
    motor = 0.02
    thrown = Experiment(0.5, constant(motor), initial_position=0.1, initial_velocity=2.0)
    run = simulate(actuator, thrown, np.linspace(0.0, 0.5, 251))
    inside = np.abs(run["joint_torque"]) < 1e-8
    assert 0.02 < np.mean(inside) < 0.9
    force = run["upper_spring_force"][inside]
    assert np.ptp(force) < 1e-7
    assert abs(force[0] - PRETENSION) > 1.0
    # no energy is lost, so the joint passes the play as fast each time
    speed = np.abs(run["joint_velocity"][inside])
    assert set(np.sign(run["joint_velocity"][inside])) == {-1.0, 1.0}
    assert np.ptp(speed) < 1e-8


def test_an_eccentric_pulley_turns_as_its_law_says() -> None:
    eccentricity = Eccentricity(0.1, 0.6)
    step = 1e-6
    for angle in (-1.0, 0.0, 0.4, 3.0):
        ahead, behind = (eccentricity.driven(angle + d, 0.0)[0] for d in (step, -step))
        # central difference: step² / 6 and rounding / step
        assert eccentricity.driven(angle, 2.0)[1] == pytest.approx(
            2.0 * (ahead - behind) / (2.0 * step), abs=1e-8
        )
    assert eccentricity.driven(0.0, 0.0)[0] == 0.0
    # moved slowly and left alone, the joint follows the pulley
    actuator = replace(EVEN, eccentricity=eccentricity, link=Link(INERTIA, damping=1.2))
    run = simulate(actuator, Experiment(3.0, smooth_step(0.0, 0.5, 1.3)), np.array([3.0]))
    expected = 1.3 + 0.1 * (math.sin(1.9) - math.sin(0.6))
    assert run["joint_position"][0] == pytest.approx(expected, abs=POSITION_ERROR)


# ---- recordings --------------------------------------------------------------------------------


def test_a_recording_is_late_and_offset() -> None:
    experiment = Experiment(1.0, later(sines([0.3], [1.0], [0.0]), 0.1))  # at rest for 0.1 s
    time = np.linspace(0.0, 1.0, 101)
    true = simulate(UNLIKE, experiment, time)
    late = record(UNLIKE, experiment, time, SignalMaps(0.01, -0.02, delay=0.03))
    np.testing.assert_allclose(
        late["joint_position"][3:], true["joint_position"][:-3] + 0.01, rtol=0, atol=1e-11
    )
    np.testing.assert_allclose(
        late["joint_torque"][3:], true["joint_torque"][:-3], rtol=0, atol=1e-9
    )
    np.testing.assert_allclose(
        late["motor_position"], true["motor_position"] - 0.02, rtol=0, atol=1e-15
    )


def test_a_recording_begins_with_the_initial_state() -> None:
    experiment = Experiment(
        0.2, sines([0.3], [1.0], [0.0]), initial_position=0.02, initial_velocity=0.5
    )
    late = record(UNLIKE, experiment, np.array([0.0, 0.1]), SignalMaps(delay=0.03))
    assert late["joint_position"][0] == 0.02
    assert late["joint_velocity"][0] == 0.5
