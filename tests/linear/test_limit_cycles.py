"""Limit cycles by harmonic balance against simulation of the nonlinear loop."""

import control
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from elastic_tendon.actuator.design import design
from elastic_tendon.actuator.parameters import load_model
from elastic_tendon.actuator.transmission import characteristic_torque, slack_boundaries
from elastic_tendon.errors import LinearisationError
from elastic_tendon.linear.describing_function import describing_function
from elastic_tendon.linear.limit_cycles import interpolated, limit_cycles
from elastic_tendon.linear.linearise import linearise
from elastic_tendon.linear.result import Drive


@pytest.fixture(scope="module")
def symmetric():
    return load_model("biorob_x4_joint_3")


SLOW = 0.05  # s, lag of the motor that follows the joint
LAG = 0.01  # s, of each of two lags between controller and motor velocity


def force_controlled(model, gain):
    """Closed loop whose torque feedback suits soft springs; motor and joint pulley are equal.

    States: joint position and velocity, motor position, its velocity, the lagged command.
    """
    link = model.link

    def closed_loop(stiffness, damping):
        rows = [
            [0, 1, 0, 0, 0],
            [
                *(-stiffness / link.inertia, -(link.damping + damping) / link.inertia),
                *(stiffness / link.inertia, damping / link.inertia, 0),
            ],
            [0, 0, 0, 1, 0],
            [0, 0, 0, -1 / LAG, 1 / LAG],
            [gain * stiffness / LAG, 0, -gain * stiffness / LAG, 0, -1 / LAG],
        ]
        return control.StateSpace(rows, np.zeros((5, 1)), np.eye(5), np.zeros((5, 1)))

    return closed_loop


def force_controlled_motion(model, gain, deflection, duration, load=0.0):
    """Deflection (n,) of the same loop with the paper's characteristic, and its times.

    The controller wants the tendons to carry the load on the joint, N·m.
    """
    link, transmission = model.link, model.transmission

    def rates(_time, x):
        torque = float(characteristic_torque(x[0] - x[2], transmission))
        return [
            x[1],
            (torque + load - link.damping * x[1]) / link.inertia,
            x[3],
            (x[4] - x[3]) / LAG,
            (-gain * (torque + load) - x[4]) / LAG,
        ]

    time = np.linspace(0.0, duration, int(2000 * duration))
    start = [deflection, 0.0, 0.0, 0.0, 0.0]
    motion = solve_ivp(rates, (0.0, duration), start, t_eval=time, rtol=1e-8, atol=1e-10)
    return time, motion.y[0] - motion.y[2]


def oscillation(time, signal):
    """Amplitude and angular frequency of a swing."""
    rising = np.flatnonzero((signal[:-1] < 0) & (signal[1:] >= 0))
    share = -signal[rising] / (signal[rising + 1] - signal[rising])
    times = time[rising] + share * (time[1] - time[0])
    return 0.5 * np.ptp(signal), 2 * np.pi * (len(times) - 1) / (times[-1] - times[0])


def test_an_attracting_limit_cycle_is_found_where_the_simulation_ends(symmetric):
    """Torque feedback that is stable on the soft spring and unstable on the stiff one."""
    gain = 6.0
    described = describing_function(symmetric)
    (cycle,) = limit_cycles(described, force_controlled(symmetric, gain)).cycles
    assert cycle.attracting
    assert cycle.amplitude > slack_boundaries(symmetric.transmission)[1]
    for start in (0.3 * cycle.amplitude, 2.0 * cycle.amplitude):
        time, deflection = force_controlled_motion(symmetric, gain, start, 6.0)
        late = time > 5.0
        amplitude, frequency = oscillation(time[late], deflection[late])
        print(
            f"amplitude {cycle.amplitude:.4f} rad, simulated {amplitude:.4f} rad; "
            f"frequency {cycle.frequency:.3f} rad/s, simulated {frequency:.3f} rad/s"
        )
        assert amplitude == pytest.approx(cycle.amplitude, rel=0.05)
        assert frequency == pytest.approx(cycle.frequency, rel=0.05)


def test_under_load_the_limit_cycle_has_the_mean_that_carries_it(symmetric):
    gain, load = 6.0, 3.0
    described = describing_function(symmetric, load_torque=load)
    (cycle,) = limit_cycles(described, force_controlled(symmetric, gain)).cycles
    time, deflection = force_controlled_motion(symmetric, gain, 0.3, 6.0, load)
    late = deflection[time > 5.0]
    mean = 0.5 * (late.max() + late.min())
    amplitude, frequency = oscillation(time[time > 5.0], late - mean)
    print(
        f"amplitude {cycle.amplitude:.4f} rad around {cycle.deflection:.4f} rad, "
        f"simulated {amplitude:.4f} rad around {mean:.4f} rad; "
        f"frequency {cycle.frequency:.3f} rad/s, simulated {frequency:.3f} rad/s"
    )
    assert cycle.attracting
    assert amplitude == pytest.approx(cycle.amplitude, rel=0.05)
    assert mean == pytest.approx(cycle.deflection, rel=0.07)  # a second harmonic shifts it
    assert frequency == pytest.approx(cycle.frequency, rel=0.05)


def position_controlled(model, gain):
    """Closed loop of a lagged motor that follows the joint: stable on the stiff spring only."""
    link = model.link

    def closed_loop(stiffness, damping):
        bent, lost = stiffness / link.inertia, damping / link.inertia
        rows = [
            [0, 1, 0, 0],
            [-bent, -link.damping / link.inertia - lost, bent, lost],
            [0, 0, 0, 1],
            [-gain / SLOW, 0, 0, -1 / SLOW],
        ]
        return control.StateSpace(rows, np.zeros((4, 1)), np.eye(4), np.zeros((4, 1)))

    return closed_loop


def position_controlled_motion(model, gain, start, duration):
    """Deflection (n,) of the same loop with the paper's characteristic, and its times."""
    link, transmission = model.link, model.transmission

    def rates(_time, x):
        torque = float(characteristic_torque(x[0] - x[2], transmission))
        return [
            x[1],
            (torque - link.damping * x[1]) / link.inertia,
            x[3],
            (-gain * x[0] - x[3]) / SLOW,
        ]

    time = np.linspace(0.0, duration, int(2000 * duration))
    motion = solve_ivp(rates, (0.0, duration), start, t_eval=time, rtol=1e-8, atol=1e-10)
    return time, motion.y[0] - motion.y[2]


def test_a_repelling_limit_cycle_is_the_border_between_dying_out_and_growing(symmetric):
    """Started on the linear mode of the limit cycle, 5 % inside and outside of it."""
    gain = 12.0
    loop = position_controlled(symmetric, gain)
    (cycle,) = limit_cycles(describing_function(symmetric), loop).cycles
    assert not cycle.attracting
    poles, modes = np.linalg.eig(loop(cycle.stiffness, cycle.damping).A)
    mode = modes[:, np.argmin(np.abs(poles - 1j * cycle.frequency))]
    mode = mode / (mode[0] - mode[2])  # per deflection
    late = {}
    for share in (0.95, 1.05):
        start = share * cycle.amplitude * mode.real
        time, deflection = position_controlled_motion(symmetric, gain, start, 6.0)
        late[share] = oscillation(time[time > 5.5], deflection[time > 5.5])[0]
    print(f"repelling at {cycle.amplitude:.4f} rad, {cycle.frequency:.3f} rad/s: {late}")
    assert late[0.95] < 0.9 * cycle.amplitude
    assert late[1.05] > 1.1 * cycle.amplitude


def test_linear_models_and_a_controller_are_enough(symmetric):
    """The same loop from `linearise` in two states and a controller of python-control."""
    channels = {"inputs": ["motor_velocity"], "outputs": ["joint_torque"]}
    soft, stiff = (
        linearise(symmetric, state, drive=Drive.VELOCITY, **channels) for state in ("I", "III")
    )
    table = design(symmetric)
    plant = interpolated(soft, stiff, (table.stiffness_state_1, table.stiffness_state_3))
    lag = control.StateSpace([[-1 / LAG]], [[1 / LAG]], [[1]], [[0]])
    controller = 6.0 * lag * lag

    described = describing_function(symmetric)
    found = limit_cycles(described, lambda k, _: control.feedback(plant(k), controller, 1))
    assert found.cycles == ()  # the torque on the joint opposes the deflection: wrong sign
    found = limit_cycles(described, lambda k, _: control.feedback(plant(k), controller))
    by_hand = limit_cycles(described, force_controlled(symmetric, 6.0))
    assert found.cycles[0].amplitude == pytest.approx(by_hand.cycles[0].amplitude, rel=1e-6)
    assert found.cycles[0].frequency == pytest.approx(by_hand.cycles[0].frequency, rel=1e-6)
    assert found.cycles[0].attracting


def test_a_loop_without_limit_cycle_says_why(symmetric):
    described = describing_function(symmetric, np.linspace(0.02, 0.5, 20))
    stable = limit_cycles(described, force_controlled(symmetric, 1.0))
    unstable = limit_cycles(described, force_controlled(symmetric, 100.0))
    assert stable.cycles == unstable.cycles == ()
    assert stable.reason == "the loop is stable at every amplitude between 0.02 and 0.5 rad"
    assert unstable.reason == "the loop is unstable at every amplitude between 0.02 and 0.5 rad"


def test_a_pole_that_crosses_zero_is_no_oscillation(symmetric):
    described = describing_function(symmetric, np.linspace(0.02, 0.5, 20))

    def inverted(stiffness, _damping):
        """A joint that a negative stiffness of 30 N·m/rad tips over in slack."""
        return control.StateSpace([[0, 1], [30.0 - stiffness, -9]], [[0], [1]], [[1, 0]], [[0]])

    found = limit_cycles(described, inverted)
    assert found.cycles == ()
    assert found.reason.startswith("a real pole crosses zero between 0.02 and 0.5 rad")


def test_models_between_two_states_are_affine_in_the_stiffness(symmetric):
    loop = force_controlled(symmetric, 2.0)
    plant = interpolated(loop(20.0, 0.0), loop(40.0, 0.0), (20.0, 40.0))
    assert np.allclose(plant(33.0).A, loop(33.0, 0.0).A, rtol=1e-12)
    assert plant(33.0).state_labels == loop(20.0, 0.0).state_labels


def test_loops_that_cannot_be_balanced_are_refused(symmetric):
    single = describing_function(symmetric, [0.1])
    two = describing_function(symmetric, [0.1, 0.2])
    loop = force_controlled(symmetric, 1.0)
    with pytest.raises(LinearisationError, match="make it for two at least"):
        limit_cycles(single, loop)
    sampled = control.StateSpace([[0.5]], [[1]], [[1]], [[0]], 0.01)
    with pytest.raises(LinearisationError, match="discrete time"):
        limit_cycles(two, lambda _stiffness, _damping: sampled)
    renamed = control.StateSpace([[0.5]], [[1]], [[1]], [[0]])
    with pytest.raises(LinearisationError, match="differ in the names"):
        interpolated(loop(1.0, 0.0), renamed, (1.0, 2.0))
    with pytest.raises(LinearisationError, match="both models have the stiffness 1 N·m/rad"):
        interpolated(loop(1.0, 0.0), loop(1.0, 0.0), (1.0, 1.0))
