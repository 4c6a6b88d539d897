"""What a user would write without elastic-tendon: a pythonfmu slave that integrates with scipy.

The paper's actuator, base model, in SI units. Benchmarks use it, as a peer.
"""

import numpy as np
from numpy.typing import NDArray
from pythonfmu import Fmi2Causality, Fmi2Slave, Real
from scipy.integrate import solve_ivp

RADIUS = 0.03  # m, of both pulleys
PRETENSION = 80.0  # N
STIFFNESS = 2 * 11580.0  # N/m, two springs side by side
INERTIA = 0.03  # kg m2
DAMPING = 0.16  # N m s/rad


class PlainSlave(Fmi2Slave):  # type: ignore[misc]
    """Joint driven through two tendons with springs, which can go slack."""

    def __init__(self, **options: str) -> None:
        super().__init__(**options)
        self.motor_position = 0.0
        self.load_torque = 0.0
        self.joint_position = 0.0
        self.joint_velocity = 0.0
        for name in ("motor_position", "load_torque"):
            self.register_variable(Real(name, causality=Fmi2Causality.input))
        for name in ("joint_position", "joint_velocity"):
            self.register_variable(Real(name, causality=Fmi2Causality.output))

    def rates(self, _time: float, state: NDArray[np.float64]) -> list[float]:
        """Velocity and acceleration of the joint."""
        position, velocity = state
        stretch = RADIUS * (position - self.motor_position)
        upper = max(0.0, PRETENSION - STIFFNESS * stretch)
        lower = max(0.0, PRETENSION + STIFFNESS * stretch)
        torque = RADIUS * (upper - lower) - DAMPING * velocity + self.load_torque
        return [velocity, torque / INERTIA]

    def do_step(self, current_time: float, step_size: float) -> bool:
        """Integrate over a communication step."""
        state = [self.joint_position, self.joint_velocity]
        end = current_time + step_size
        motion = solve_ivp(self.rates, (current_time, end), state, rtol=1e-8, atol=1e-10)
        self.joint_position, self.joint_velocity = motion.y[:, -1]
        return bool(motion.success)
