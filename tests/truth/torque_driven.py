"""A rotor and a link on two springs between pulleys, driven by a torque: plain equations, in scipy.

Written from the paper's text, apart from the rest of this folder: forces of one-sided springs and
dampers, friction by a smooth search for its sign with events, nothing symbolic.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

ROUNDING = 1e-10  # rad/s
NOTHING = 1e-13  # N·m
CREEPING = 1e-4  # rad/s, at which the dry friction of a controlled motor is nearly all there
Vector = NDArray[np.float64]
Signal = Callable[[float], float]


@dataclass(frozen=True)
class Drive:
    """Numbers of the machine, SI; radii of joint and motor pulley, springs upper and lower."""

    joint_radius: float
    motor_radius: float
    pretension: float
    stiffness: tuple[float, float]
    damping: tuple[float, float]
    link: tuple[float, float]  # inertia, damping
    rotor: tuple[float, float]  # inertia, damping
    rotor_friction: float = 0.0
    gravity: float = 0.0  # of a link that hangs at 0, N·m
    gain: float = 1.0
    offset: float = 0.0
    cogging: tuple[float, float, float] = (0.0, 1.0, 0.0)  # amplitude, waves, phase
    loss: tuple[float, float] = (0.0, 0.0)  # of the gear: shares of torques before and behind it
    # more of it while slow: without load, shares, squares driving and driven; velocity, exponent
    slow: tuple[float, ...] = (0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 2.0)

    def pulls(self, q: float, v: float, motor: float, rate: float) -> tuple[float, float]:
        """Tension of the upper and the lower tendon, N: never negative."""
        reach = self.motor_radius * motor - self.joint_radius * q
        speed = self.motor_radius * rate - self.joint_radius * v
        tensions = [
            max(self.pretension + k * sign * reach + d * sign * speed, 0.0)
            for k, d, sign in zip(self.stiffness, self.damping, (1.0, -1.0), strict=True)
        ]
        return tensions[0], tensions[1]

    @property
    def rubs(self) -> bool:
        """Whether anything can hold the rotor."""
        return self.rotor_friction > 0.0 or any(self.loss) or any(self.slow[:5])

    def sides(self, torque: float, x: Vector) -> tuple[float, float]:
        """Torques of the motor, before its gear, and of the tendons behind it, N·m."""
        upper, lower = self.pulls(*x)
        amplitude, waves, phase = self.cogging
        driving = self.gain * torque + self.offset + amplitude * np.sin(waves * x[2] + phase)
        return float(driving), -self.motor_radius * (upper - lower)

    def dry(self, torque: float, x: Vector) -> float:
        """Most that dry friction takes or holds, N·m."""
        driving, load = self.sides(torque, x)
        if driving * load >= 0.0:  # both push the same way: the shares of the gear work apart
            lost = [abs(abs(driving) * m - abs(load) * n) for m, n in (self.loss, self.slow[1:3])]
            square = 0.0
        else:
            lost = [abs(driving) * m + abs(load) * n for m, n in (self.loss, self.slow[1:3])]
            driven = abs(driving) <= abs(load)
            square = self.slow[4] * driving**2 if driven else self.slow[3] * load**2
        share = np.exp(-((abs(x[3]) / self.slow[5]) ** self.slow[6]))
        slow = self.slow[0] + lost[1] + square
        return float(self.rotor_friction + lost[0] + slow * share)

    def push(self, torque: float, x: Vector) -> float:
        """Torque on the rotor but its dry friction, N·m."""
        return sum(self.sides(torque, x)) - self.rotor[1] * float(x[3])

    def rates(self, t: float, x: Vector, torque: Signal, load: Signal, way: int) -> Vector:
        """Of joint position and velocity, motor position and velocity; `way` the motor moves."""
        q, v, motor, rate = x
        upper, lower = self.pulls(q, v, motor, rate)
        turning = self.joint_radius * (upper - lower) + load(t) - self.link[1] * v
        turning -= self.gravity * np.sin(q)
        if way == 0:
            return np.array([v, turning / self.link[0], 0.0, 0.0])
        pushed = self.push(torque(t), x) - way * self.dry(torque(t), x)
        return np.array([v, turning / self.link[0], rate, pushed / self.rotor[0]])


def simulate(drive: Drive, time: Vector, torque: Signal, load: Signal) -> Vector:
    """States (n, 4) from rest at zero: the motor sticks, or moves one way until it stops."""
    x, now, rows = np.zeros(4), float(time[0]), [np.zeros(4)]
    way = _released(drive, now, x, torque)
    while len(rows) < len(time):

        def stops(t: float, y: Vector, way: int = way) -> float:
            # a motor just released has no velocity yet, and rounding must not stop it at once
            return _freed(drive, torque(t), y) if way == 0 else way * y[3] + ROUNDING

        stops.terminal = True  # type: ignore[attr-defined]
        stops.direction = 1.0 if way == 0 else -1.0  # type: ignore[attr-defined]
        found = solve_ivp(
            lambda t, y, way=way: drive.rates(t, y, torque, load, way),
            (now, float(time[-1])),
            x,
            method="DOP853",
            rtol=1e-12,
            atol=1e-13,
            max_step=0.01,
            events=stops if drive.rubs else None,
            dense_output=True,
        )
        reached = time[len(rows) : np.searchsorted(time, found.t[-1], side="right")]
        assert found.sol is not None  # as dense_output asks
        rows += list(found.sol(reached).T) if len(reached) else []
        now, x = float(found.t[-1]), found.y[:, -1].copy()
        if drive.rubs:
            x[3] = 0.0
            way = _released(drive, now, x, torque)
    return np.array(rows)


def follow(drive: Drive, time: Vector, motion: Signal, load: Signal) -> tuple[Vector, Vector]:
    """States (n, 4) from rest at zero, and the torque (n,) of a controller that makes the motor
    follow a motion; its dry friction rises steeply with the velocity instead of holding."""
    stiffness, damping = 900.0 * drive.rotor[0], 60.0 * drive.rotor[0]

    def controller(t: float, x: Vector) -> float:
        ahead = (motion(t + 1e-4) - motion(t - 1e-4)) / 2e-4
        return float(stiffness * (motion(t) - x[2]) + damping * (ahead - x[3]))

    def rates(t: float, x: Vector) -> Vector:
        q, v, motor, rate = x
        upper, lower = drive.pulls(q, v, motor, rate)
        turning = drive.joint_radius * (upper - lower) + load(t) - drive.link[1] * v
        turning -= drive.gravity * np.sin(q)
        torque = controller(t, x)
        pushed = drive.push(torque, x) - drive.dry(torque, x) * np.tanh(rate / CREEPING)
        return np.array([v, turning / drive.link[0], rate, pushed / drive.rotor[0]])

    span = (float(time[0]), float(time[-1]))
    found = solve_ivp(
        *(rates, span, np.zeros(4)), "LSODA", t_eval=time, rtol=1e-9, atol=1e-10, max_step=0.02
    )
    torques = [controller(t, x) for t, x in zip(time.tolist(), found.y.T, strict=True)]
    return found.y.T, np.array(torques)


def _freed(drive: Drive, torque: float, x: Vector) -> float:
    """By how much a resting rotor is pushed more than friction holds, N·m.

    A little less: where there is no torque at all a gear that loses shares rests, and does not
    break loose at once.
    """
    resting = np.array([*x[:3], 0.0])
    return abs(drive.push(torque, resting)) - drive.dry(torque, resting) - NOTHING


def _released(drive: Drive, t: float, x: Vector, torque: Signal) -> int:
    """Which way a resting motor is pushed off, 0 where friction holds it."""
    if not drive.rubs:
        return 1
    rounding = max(1e-12 * drive.dry(torque(t), x), 0.1 * NOTHING)
    return int(np.sign(drive.push(torque(t), x))) if _freed(drive, torque(t), x) >= -rounding else 0
