"""A command that comes late: stable while taut, a limit cycle in slack."""

from collections.abc import Mapping

import control
import numpy as np
from design import SAMPLE, Controller, softened, stiffness
from experiment import Signals

from elastic_tendon import (
    LimitCycles,
    LinearModel,
    Model,
    SlackState,
    describing_function,
    limit_cycles,
)


def delayed_loop(plant: control.StateSpace, controller: Controller, delay: int) -> np.ndarray:
    """Motion, observer and the commands under way, from one sample to the next.

    `delay`: in samples, at least 1; the observer does not know of it.
    """
    sampled, feedback = control.c2d(plant, SAMPLE), controller.feedback
    A = np.zeros((7 + delay, 7 + delay))
    A[:3, :3], A[:3, 7] = sampled.A, sampled.B[:, 0]  # the oldest command arrives
    A[3:7, :3], A[3:7, 3:7] = feedback.B @ sampled.C, feedback.A
    A[7:-1, 8:] = np.eye(delay - 1)
    A[-1, 3:7] = -feedback.C[0]
    return A


def fastest_growth(plant: control.StateSpace, controller: Controller, delay: int) -> float:
    """1/s; negative where the loop is stable in spite of the delay."""
    poles = np.linalg.eigvals(delayed_loop(plant, controller, delay))
    return float(np.log(np.abs(poles).max()) / SAMPLE)


def predicted(
    model: Model,
    plants: Mapping[SlackState, LinearModel],
    controller: Controller,
    delay: int,
    load: float,
) -> LimitCycles:
    """Limit cycles under a load, by the describing function of the springs.

    The sampled loop is taken to continuous time by the bilinear transformation, which puts the
    unit circle on the imaginary axis.
    """
    slack, taut = plants[SlackState.II], plants[SlackState.III]

    def closed(equivalent: float, _: float) -> control.StateSpace:
        share = (stiffness(taut) - equivalent) / (stiffness(taut) - stiffness(slack))
        plant = softened(taut, slack, share)
        A, one = delayed_loop(plant, controller, delay), np.eye(7 + delay)
        bilinear = 2.0 / SAMPLE * np.linalg.solve(A + one, A - one)
        return control.ss(bilinear, np.zeros((7 + delay, 1)), np.zeros((1, 7 + delay)), 0.0)

    return limit_cycles(describing_function(model, load_torque=load), closed)


def observed(signals: Signals, last: float = 2.0) -> tuple[float, float]:
    """Amplitude (rad) and angular frequency (rad/s) of the deflection in the last seconds."""
    late = signals["time"] >= signals["time"][-1] - last
    deflection = (signals["joint"] - signals["motor"])[late]
    swing = deflection - deflection.mean()
    rising = np.flatnonzero((swing[:-1] < 0.0) & (swing[1:] >= 0.0))
    cycle = SAMPLE * np.diff(rising).mean()
    return float(np.ptp(deflection) / 2.0), float(2.0 * np.pi / cycle)
