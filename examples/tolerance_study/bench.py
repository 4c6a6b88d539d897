"""Two tests on a bench that show when a tendon goes slack, and what the paper says of it."""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from elastic_tendon import Model, Motion, Points, Task, simulations

SAMPLES = 2001
CLAMPED = 1e4  # kg·m²; a joint so heavy stays where it is
TURN, TURNING = 0.2, 0.1  # rad at the joint, s
LOAD, LOADING = 8.0, 20.0  # N·m, s: so slowly that the joint hardly swings
UPPER, LOWER = "transmission.upper_spring.stiffness", "transmission.lower_spring.stiffness"
PRETENSION = "transmission.pretension_force"


@dataclass(frozen=True)
class Bench:
    """A test in which a quantity rises evenly to `end` until the upper tendon is slack.

    `task` : the test of each machine, one row each.
    """

    task: Task
    end: float

    def boundary(self, table: pd.DataFrame) -> np.ndarray:
        """Where the upper tendon went slack, (k,): between the last taut sample and the next."""
        taut = SAMPLES * (1.0 - table["slack_state.share_II"].to_numpy())
        return self.end * (taut - 0.5) / (SAMPLES - 1)


def joint_clamped(model: Model, points: Points) -> Bench:
    """The joint is clamped and the motor turns away from it: the deflection rises."""
    transmission = model.transmission
    ratio = transmission.joint_pulley_radius / transmission.motor_pulley_radius  # n_t, (9)
    motion = Motion(np.linspace(0.0, TURNING, SAMPLES), ratio * np.linspace(0.0, -TURN, SAMPLES))
    return _bench(model.with_values({"link.inertia": CLAMPED}), points, motion, TURN)


def joint_loaded(model: Model, points: Points) -> Bench:
    """The motor stands still and a weight on the joint grows: the torque rises."""
    motion = Motion(
        np.linspace(0.0, LOADING, SAMPLES), np.zeros(SAMPLES), np.linspace(0.0, LOAD, SAMPLES)
    )
    return _bench(model, points, motion, LOAD)


def _bench(model: Model, points: Points, motion: Motion, end: float) -> Bench:
    return Bench(simulations(model, points, motion=motion, outputs=["slack_state"]), end)


def closed_form(model: Model, table: pd.DataFrame) -> tuple[np.ndarray, np.ndarray]:
    """Deflection (rad) and torque (N·m) at which the upper tendon goes slack, (14), (24), (36).

    δ = F_p / (R k_1), and the torque on the way there is R² (k_1 + k_2) δ.
    """
    transmission = model.transmission
    R = transmission.joint_pulley_radius
    k_1 = transmission.upper_spring.parallel * table[UPPER].to_numpy()
    k_2 = transmission.lower_spring.parallel * table[LOWER].to_numpy()
    deflection = table[PRETENSION].to_numpy() / (R * k_1)
    return deflection, R**2 * (k_1 + k_2) * deflection


def moved_by(boundary: np.ndarray, table: pd.DataFrame) -> dict[str, float]:
    """By which share of its mean a boundary moves with one sigma of each number that varies."""
    drawn = table[[UPPER, LOWER, PRETENSION]]
    scaled = (drawn - drawn.mean()) / drawn.std()
    slopes, *_ = np.linalg.lstsq(scaled.to_numpy(), boundary - boundary.mean())
    return dict(zip(drawn.columns, slopes / boundary.mean(), strict=True))
