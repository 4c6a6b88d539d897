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
    gain: float = 1.0
    offset: float = 0.0
    cogging: tuple[float, float, float] = (0.0, 1.0, 0.0)  # amplitude, waves, phase

    def pulls(self, q: float, v: float, motor: float, rate: float) -> tuple[float, float]:
        """Tension of the upper and the lower tendon, N: never negative."""
        reach = self.motor_radius * motor - self.joint_radius * q
        speed = self.motor_radius * rate - self.joint_radius * v
        tensions = [
            max(self.pretension + k * sign * reach + d * sign * speed, 0.0)
            for k, d, sign in zip(self.stiffness, self.damping, (1.0, -1.0), strict=True)
        ]
        return tensions[0], tensions[1]

    def push(self, torque: float, q: float, v: float, motor: float, rate: float) -> float:
        """Torque on the rotor but its dry friction, N·m."""
        upper, lower = self.pulls(q, v, motor, rate)
        amplitude, waves, phase = self.cogging
        driving = self.gain * torque + self.offset + amplitude * np.sin(waves * motor + phase)
        return float(driving - self.rotor[1] * rate - self.motor_radius * (upper - lower))

    def rates(self, t: float, x: Vector, torque: Signal, load: Signal, way: int) -> Vector:
        """Of joint position and velocity, motor position and velocity; `way` the motor moves."""
        q, v, motor, rate = x
        upper, lower = self.pulls(q, v, motor, rate)
        turning = self.joint_radius * (upper - lower) + load(t) - self.link[1] * v
        if way == 0:
            return np.array([v, turning / self.link[0], 0.0, 0.0])
        pushed = self.push(torque(t), q, v, motor, rate) - way * self.rotor_friction
        return np.array([v, turning / self.link[0], rate, pushed / self.rotor[0]])


def simulate(drive: Drive, time: Vector, torque: Signal, load: Signal) -> Vector:
    """States (n, 4) from rest at zero: the motor sticks, or moves one way until it stops."""
    x, now, rows = np.zeros(4), float(time[0]), [np.zeros(4)]
    way = _released(drive, now, x, torque)
    while len(rows) < len(time):

        def stops(t: float, y: Vector, way: int = way) -> float:
            pushed = drive.push(torque(t), *y[:3], 0.0)
            # a motor just released has no velocity yet, and rounding must not stop it at once
            return abs(pushed) - drive.rotor_friction if way == 0 else way * y[3] + ROUNDING

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
            events=stops if drive.rotor_friction else None,
            dense_output=True,
        )
        reached = time[len(rows) : np.searchsorted(time, found.t[-1], side="right")]
        rows += list(found.sol(reached).T) if len(reached) else []
        now, x = float(found.t[-1]), found.y[:, -1].copy()
        if drive.rotor_friction:
            x[3] = 0.0
            way = _released(drive, now, x, torque)
    return np.array(rows)


def _released(drive: Drive, t: float, x: Vector, torque: Signal) -> int:
    """Which way a resting motor is pushed off, 0 where friction holds it."""
    if not drive.rotor_friction:
        return 1
    pushed = drive.push(torque(t), x[0], x[1], x[2], 0.0)
    return int(np.sign(pushed)) if abs(pushed) >= drive.rotor_friction * (1.0 - 1e-12) else 0
